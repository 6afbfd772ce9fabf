"""A conversation with a SCIP scanner, from the first word to scans: replies and times in, commands and scans out. Pure.

    QT  stop, whatever it does          VV PP II  what it is, and how it is
    TM  its clock, asked a few times    BM  laser on
    MD  measure                         QT  at the end: laser off

After hardware trouble the scanner is reset first (RS).
"""

from __future__ import annotations

import math

from fleet.drivers.lidar.clock import ScannerClock
from fleet.drivers.lidar.config import LidarOptions
from fleet.drivers.lidar.mount import mounted
from fleet.drivers.lidar.scip import (
    CHARACTERS,
    OK,
    Counts,
    Decoder,
    Measurement,
    Model,
    Reply,
    Request,
    command,
    decode,
    model,
)
from fleet.drivers.lidar.words import HARDWARE, in_words
from fleet.sensing.scan import Scan

ANSWER_S = 1.0  # a command is waited for so long, then said again
TRIES = 3
STALLED_S = 2.0  # without a scan for so long, all begins anew
TIMES = 5  # so often the clock is asked for
MOST_SKIPPED = 9
STOP, RESET, MEASURE, RUNNING = "QT", "RS", "measure", "running"
FIRST = (STOP, "VV", "PP", "II")


class Session:
    """One connection. When `failed` says why, it is over: connect again."""

    def __init__(self, options: LidarOptions, name: str, *, reset: bool = False) -> None:
        self._options, self._name = options, name
        self._decoder = Decoder()
        self._clock = ScannerClock()
        clock = ("TM0", *("TM1",) * TIMES, "TM2") if options.synchronise else ()
        self._plan = [STOP, RESET, *FIRST] if reset else [*FIRST]
        self._plan += [*clock, "BM", MEASURE]
        self._at = 0
        self._sent = (0, 0.0)  # when: by the agent's clock [ns], by the wall's [s]
        self._tries = 0
        self._heard_s = math.inf  # last scan, by the wall's clock
        self._next_s = 0.0  # of commands that measure once: when to ask again
        self.model: Model | None = None
        self.request: Request | None = None
        self.version: dict[str, str] = {}
        self.state: dict[str, str] = {}
        self.failed = ""
        self.says = ""  # why no scans come, though the connection stands
        self.hardware = False  # it needs a reset

    @property
    def counts(self) -> Counts:
        """What came of all that was received."""
        return self._decoder.counts

    @property
    def refused(self) -> int:
        """Replies and scans that were not believed."""
        return self.counts.refused + self._clock.refused

    @property
    def doing(self) -> str:
        """The step of the plan."""
        return self._plan[self._at] if self._at < len(self._plan) else RUNNING

    def begin(self, now_ns: int, wall_s: float) -> bytes:
        """The first command."""
        return self._say(now_ns, wall_s)

    def take(self, chunk: bytes, now_ns: int, wall_s: float) -> tuple[list[Scan], bytes]:
        """What was received: scans, and what is to be sent."""
        scans: list[Scan] = []
        answer = b""
        for said in self._decoder.feed(chunk):
            if self.failed:
                break
            if isinstance(said, Reply):
                answer += self._replied(said, now_ns, wall_s)
            else:
                scan = self._measured(said, now_ns, wall_s)
                scans += [scan] if scan is not None else []
        return scans, answer

    def due(self, now_ns: int, wall_s: float) -> bytes:
        """What is to be sent because time went by."""
        if self.failed:
            return b""
        if self.doing == RUNNING:
            assert self.request is not None
            if wall_s - self._heard_s > STALLED_S:
                self.failed = self.says or f"no scan for {STALLED_S:g} s"
            elif not self.request.again and self._next_s <= wall_s:
                self._next_s = wall_s + ANSWER_S
                return self.request.line()
            return b""
        if wall_s - self._sent[1] < ANSWER_S:
            return b""
        if self._tries >= TRIES:
            self.failed = f"does not answer {self.doing}"
            return b""
        return self._say(now_ns, wall_s)

    # -- step by step ------------------------------------------------------------------------------------------------
    def _say(self, now_ns: int, wall_s: float) -> bytes:
        self._sent = (now_ns, wall_s)
        self._tries += 1
        if self.doing != MEASURE:
            return command(self.doing)
        assert self.request is not None
        self._decoder.expect(self.request, self.model)
        return self.request.line()

    def _on(self, now_ns: int, wall_s: float, *, to: str = "") -> bytes:
        """The next step, or a later one."""
        self._at = self._plan.index(to) if to else self._at + 1
        self._tries = 0
        if self.doing == RUNNING:
            self._heard_s = wall_s
            return b""
        return self._say(now_ns, wall_s)

    def _replied(self, reply: Reply, now_ns: int, wall_s: float) -> bytes:
        if self.doing == RUNNING or (self.doing == MEASURE and reply.command in CHARACTERS):
            return self._about_measuring(reply, now_ns, wall_s)
        if reply.command != self.doing[:2]:
            return b""
        if self.doing == STOP:
            return self._stopped(reply, now_ns, wall_s)
        if self.doing in ("VV", "II"):
            table = reply.table
            self.version, self.state = (table, self.state) if self.doing == "VV" else (self.version, table)
        elif self.doing == "PP":
            self.model = model(reply)
            if self.model is None:
                self.failed = "does not say what it measures (PP)"
                return b""
            self.request = request(self._options, self.model)
            if self.request.first >= self.request.last:
                self.failed = f"measures nothing from {self._options.from_deg:g} to {self._options.to_deg:g} degrees"
                return b""
        elif self.doing == "TM0" and reply.status not in (OK, "02"):
            return self._on(now_ns, wall_s, to="BM")  # it has no such command: its clock is taken from its scans
        elif self.doing == "TM1":
            ms = decode(reply.lines[0].encode("latin-1")) if len(reply.lines) == 1 and len(reply.lines[0]) == 4 else -1
            if reply.status == OK and ms >= 0:
                self._clock.answered(ms, self._sent[0], now_ns)
        elif self.doing == "BM" and reply.status == "01":
            self._broken(in_words("BM", "01"))
            return b""
        return self._on(now_ns, wall_s)

    def _stopped(self, reply: Reply, now_ns: int, wall_s: float) -> bytes:
        if reply.status == "E":  # it begins with SCIP 1.1
            return command("SCIP2.0") + self._say(now_ns, wall_s)
        if reply.status == "0E":  # it was left while its clock was asked for
            return command("TM", "2") + self._say(now_ns, wall_s)
        return self._on(now_ns, wall_s)

    def _about_measuring(self, reply: Reply, now_ns: int, wall_s: float) -> bytes:
        """A reply without distances to a command that measures."""
        if reply.command not in CHARACTERS:
            return b""
        words = in_words(reply.command, reply.status)
        if reply.status == OK:
            return self._on(now_ns, wall_s) if self.doing == MEASURE else b""
        if words == HARDWARE or reply.status == "0L":
            self._broken(words)
        elif self.doing == MEASURE:
            self.failed = f"does not measure: {words}"
        else:
            self.says = "" if reply.status == "98" else words
        return b""

    def _broken(self, words: str) -> None:
        self.failed, self.hardware = words, True

    # -- scans -------------------------------------------------------------------------------------------------------
    def _measured(self, said: Measurement, now_ns: int, wall_s: float) -> Scan | None:
        assert self.model is not None
        assert self.request is not None
        if self.doing == MEASURE:
            self._on(now_ns, wall_s)
        self._heard_s = wall_s
        self.says = ""
        if not self.request.again:
            self._next_s = max(self._next_s - ANSWER_S + 1.0 / self._options.rate_hz, wall_s)
        stamp_ns = self._clock.stamp_ns(said.ms, now_ns, round(self.model.turn_s * 1e9))
        if self._clock.lost:
            self.failed = "its clock has jumped"
        if stamp_ns == 0:
            return None
        step = 2.0 * math.pi / self.model.around
        cluster = max(self.request.cluster, 1)
        scan = Scan(
            stamp_ns=stamp_ns,
            first_rad=self.model.angle(self.request.first + 0.5 * (cluster - 1)),
            increment_rad=-cluster * step,
            ranges=said.ranges,
            range_max_m=self.model.most_mm * 1e-3,
            beam_s=self.model.turn_s / self.model.around * cluster,
            scanner=self._name,
        )
        return mounted(scan, self._options)


def request(options: LidarOptions, model: Model) -> Request:
    """What to ask of a scanner: as much of it as it can, not more often than wanted."""
    last = model.step(math.radians(options.from_deg))  # steps are counted to port
    first = model.step(math.radians(options.to_deg))
    skip = min(max(math.floor(1.0 / (model.turn_s * options.rate_hz) + 1e-6) - 1, 0), MOST_SKIPPED)
    return Request(options.command, min(first, last), max(first, last), options.cluster, skip)
