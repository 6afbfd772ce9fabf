"""The scanner's side of SCIP 2.0: command lines in, replies out. Pure; times are handed in."""

from __future__ import annotations

import re

from fleet.drivers.lidar.scip import (
    CHARACTERS,
    OK,
    TICKS,
    Model,
    Request,
    encode,
)
from fleet.sim.scanner.speech import measurement_bytes, model_lines, reply_bytes

MODEL = Model("SIMULATED (fleet)", 20, 60000, 1440, 0, 1080, 540, 600)
_MEASURE = re.compile(rb"(MD|MS|ME)(\d{4})(\d{4})(\d{2})(\d)(\d{2})|(GD|GS|GE)(\d{4})(\d{4})(\d{2})")
LONGEST = 64  # bytes of a command


class Responder:
    """A scanner with its laser off, until it is told otherwise."""

    def __init__(self, model: Model = MODEL) -> None:
        self.model = model
        self.laser = False
        self.fault = ""  # status of a broken scanner
        self.streaming: Request | None = None
        self._adjusting = False
        self._left = 0
        self._skipped = 0
        self._distances: list[int] = []
        self._rest = b""

    def reset(self) -> None:
        """As after switching on."""
        self.laser, self.streaming, self._adjusting, self._rest = False, None, False, b""

    def hear(self, chunk: bytes, ms: int) -> bytes:
        """What was received at the scanner's time `ms`; the replies."""
        *lines, rest = (self._rest + chunk).replace(b"\r", b"\n").split(b"\n")
        self._rest = rest[-LONGEST:]
        return b"".join(self._answer(line, ms) for line in lines if line)

    def _answer(self, line: bytes, ms: int) -> bytes:
        name = line[:2]
        if name == b"TM":
            return self._time(line, ms)
        if self._adjusting:
            return reply_bytes(line, "0E")
        if name == b"QT":
            self.laser, self.streaming = False, None
            return reply_bytes(line, OK)
        if name == b"RS":
            self.reset()
            self.fault = ""
            return reply_bytes(line, OK)
        if name == b"VV":
            return reply_bytes(line, OK, [b"VEND:fleet", b"PROD:simulated scanner", b"PROT:SCIP 2.0"], words=True)
        if name == b"PP":
            return reply_bytes(line, OK, model_lines(self.model), words=True)
        if name == b"II":
            laser = b"ON" if self.laser else b"OFF"
            return reply_bytes(line, OK, [b"LASR:" + laser, b"STAT:works well"], words=True)
        if name == b"BM":
            status = "01" if self.fault else "02" if self.laser else OK
            self.laser = not self.fault
            return reply_bytes(line, status)
        return self._measure(line, ms)

    def _time(self, line: bytes, ms: int) -> bytes:
        code = line[2:3]
        if code not in (b"0", b"1", b"2"):
            return reply_bytes(line, "01")
        if code == b"1":
            return reply_bytes(line, OK, [encode(ms % TICKS, 4)]) if self._adjusting else reply_bytes(line, "04")
        wanted = code == b"0"
        status = OK if wanted != self._adjusting else "02" if wanted else "03"
        self._adjusting = wanted
        self.laser = self.laser and not wanted
        return reply_bytes(line, status)

    def _measure(self, line: bytes, ms: int) -> bytes:
        match = _MEASURE.fullmatch(line)
        if match is None:
            return reply_bytes(line, "0C" if line[:2].decode("latin-1") in CHARACTERS else "0E")
        again = match[1] is not None
        name, first, last, cluster = match.groups()[:4] if again else match.groups()[6:10]
        skip, count = (int(match[5]), int(match[6])) if again else (0, 0)
        request = Request(name.decode(), int(first), int(last), max(int(cluster), 1), skip, count)
        if self.fault:
            return reply_bytes(line, self.fault)
        if request.last > self.model.last:
            return reply_bytes(line, "04")
        if request.last <= request.first:
            return reply_bytes(line, "05")
        if again:
            self.laser, self.streaming, self._left, self._skipped = True, request, request.count, 0
            return reply_bytes(line, OK)
        if not self.laser:
            return reply_bytes(line, "10")
        return measurement_bytes(request, ms, self._cut(request)) if self._distances else b""

    def turned(self, ms: int, distances_mm: list[int]) -> bytes:
        """The scanner has made a turn that began at its time `ms`: distances by step, from 0; what it sends."""
        self._distances = distances_mm
        request = self.streaming
        if request is None:
            return b""
        if self.fault:
            self.streaming, self.laser = None, False
            return reply_bytes(request.line()[:-1], self.fault)
        self._skipped = (self._skipped + 1) % (request.skip + 1)
        if self._skipped != 1 % (request.skip + 1):
            return b""
        if request.count:
            self._left -= 1
            if self._left == 0:
                self.streaming, self.laser = None, False
        return measurement_bytes(request, ms, self._cut(request), self._left)

    def _cut(self, request: Request) -> list[int]:
        """The distances asked for: of every cluster the least that is none of the error codes, else its first."""
        most = (1 << 6 * CHARACTERS[request.command]) - 1
        steps = [min(one, most) for one in self._distances[request.first : request.last + 1]]
        steps += [0] * (request.last + 1 - request.first - len(steps))
        parts = (steps[k : k + request.cluster] for k in range(0, len(steps), request.cluster))
        return [min((one for one in part if one >= self.model.least_mm), default=part[0]) for part in parts]
