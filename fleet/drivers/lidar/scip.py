"""SCIP 2.0, the text protocol of Hokuyo's scanners: values to bytes and back. Pure.

A reply is lines of ASCII, each ended by a line feed, and an empty line after the last:

    echo of the command
    status (2 characters), sum
    lines, each with its sum

The sum is 6 bits: (sum of the characters & 0x3f) + 0x30. Numbers are 2, 3 or 4 characters of 6 bits each, the highest
first, plus 0x30. A measurement's first line after the status is the scanner's clock [ms, 24 bits]; its distances [mm]
follow as one string, cut into lines of 64 characters.

Source: Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B; ME and GE from that of the
UTM-30LX-EW.
"""

from __future__ import annotations

import math
import re

from msgspec import Struct

BLOCK = 64  # characters of a line of distances
TICKS = 1 << 24  # after so many milliseconds the scanner's clock begins anew
OK, STREAM = "00", "99"
LARGEST = 1 << 16  # bytes of a reply
MOST_STEPS = 9999
LEAST_MM = 20  # distances below are error codes
CHARACTERS = {"MD": 3, "MS": 2, "ME": 3, "GD": 3, "GS": 2, "GE": 3}
"""Characters of a distance. M: again and again; G: once; S: short; E: each with its intensity."""
BEYOND_MM = {2: 4094, 3: (1 << 18) - 2}  # the largest number of all says "beyond"
COMMANDS = frozenset({*CHARACTERS, "VV", "PP", "II", "BM", "QT", "RS", "TM", "SS", "CR", "HS", "DB", "SC"})
_STATUS = re.compile(rb"[0-9A-Z]{2}")
_NUMBER = re.compile(r"[0-9]{1,8}")
_ECHO = re.compile(rb"[\x20-\x7e]{2,64}")


# -- numbers -----------------------------------------------------------------------------------------------------------
def checksum(line: bytes) -> int:
    """The character that ends a line."""
    return (sum(line) & 0x3F) + 0x30


def encode(value: int, characters: int) -> bytes:
    """A number as so many characters; ValueError where it does not fit."""
    if not 0 <= value < 1 << 6 * characters:
        raise ValueError(f"{value} does not fit {characters} characters")
    return bytes((value >> 6 * (characters - 1 - k) & 0x3F) + 0x30 for k in range(characters))


def decode(text: bytes) -> int:
    """The number; -1 where a character is none of the code."""
    value = 0
    for character in text:
        if not 0x30 <= character <= 0x6F:
            return -1
        value = value << 6 | character - 0x30
    return value


# -- what is asked -----------------------------------------------------------------------------------------------------
class Request(Struct, frozen=True):
    """A measurement: steps from first to last, of every `cluster` the least distance, of every `skip` + 1 turns one."""

    command: str  # one of CHARACTERS
    first: int
    last: int
    cluster: int = 1
    skip: int = 0
    count: int = 0  # of scans; 0: until told otherwise

    @property
    def values(self) -> int:
        """How many distances come of it."""
        return -(-(self.last - self.first + 1) // max(self.cluster, 1))

    @property
    def again(self) -> bool:
        """Whether scans come without being asked for again."""
        return self.command[0] == "M"

    def steps(self) -> bytes:
        """Command and steps: what an echo must begin with."""
        head = f"{self.command}{self.first:04d}{self.last:04d}{self.cluster:02d}"
        return (head + f"{self.skip:d}" if self.again else head).encode()

    def line(self) -> bytes:
        """The command."""
        return self.steps() + (b"%02d\n" % self.count if self.again else b"\n")


def command(name: str, code: str = "") -> bytes:
    """Any other command: `VV PP II BM QT RS`, `TM` with 0, 1 or 2, `SCIP2.0` for scanners that begin with version 1."""
    return f"{name}{code}\n".encode()


# -- what is answered --------------------------------------------------------------------------------------------------
class Reply(Struct, frozen=True):
    """An answer that is no measurement."""

    command: str
    status: str  # 00 is well; of SCIP 1.1 one character
    lines: tuple[str, ...] = ()  # without their sums

    @property
    def table(self) -> dict[str, str]:
        """Lines `KEY:value` of VV, PP and II."""
        return dict(line.split(":", 1) for line in self.lines if ":" in line)


class Measurement(Struct, frozen=True):
    """Distances as they came."""

    ms: int  # the scanner's clock
    ranges: bytes  # float32 each, low byte first [m]; NaN: no return
    left: int  # scans that will still come; 0 of one that goes on


class Model(Struct, frozen=True):
    """What a scanner is, by its PP reply."""

    name: str
    least_mm: int
    most_mm: int
    around: int  # steps of a whole turn
    first: int
    last: int
    front: int
    rpm: int

    @property
    def turn_s(self) -> float:
        """Time of a whole turn."""
        return 60.0 / self.rpm

    def angle(self, step: float) -> float:
        """Bearing of a step from the scanner's front, + to starboard [rad]: steps are counted to port."""
        return 2.0 * math.pi * (self.front - step) / self.around

    def step(self, angle: float) -> int:
        """The step nearest to a bearing, within those measured."""
        return min(max(round(self.front - angle * self.around / (2.0 * math.pi)), self.first), self.last)


def model(reply: Reply) -> Model | None:
    """The scanner of a PP reply; None where it cannot be."""
    table = reply.table
    numbers: list[int] = []
    for key in ("DMIN", "DMAX", "ARES", "AMIN", "AMAX", "AFRT", "SCAN"):
        text = table.get(key, "").strip()
        if not _NUMBER.fullmatch(text):
            return None
        numbers.append(int(text))
    found = Model(table.get("MODL", "")[:64], *numbers)
    possible = (
        0 <= found.least_mm < found.most_mm <= 1_000_000
        and 0 <= found.first < found.last <= MOST_STEPS
        and found.first <= found.front <= found.last
        and found.last - found.first <= found.around <= 100_000
        and 60 <= found.rpm <= 60_000
    )
    return found if possible else None


class Counts(Struct):
    """What became of all blocks; each is counted once."""

    scans: int = 0
    replies: int = 0
    foreign: int = 0  # no command's echo, or that of a measurement not asked for
    check: int = 0  # a sum is wrong, or a character is none of the code
    length: int = 0  # too few or too many lines or distances
    overflow: int = 0  # bytes without an end

    @property
    def refused(self) -> int:
        """Those that were not believed."""
        return self.foreign + self.check + self.length + self.overflow


class Decoder:
    """Bytes to replies; give it what arrived, in any pieces."""

    def __init__(self) -> None:
        self.counts = Counts()
        self._request: Request | None = None
        self._least_m, self._most_m = LEAST_MM * 1e-3, 0.0
        self._rest = b""

    def expect(self, request: Request | None, model: Model | None) -> None:
        """Take measurements of this request only; None: of none."""
        self._request = request
        if request is not None and model is not None:
            self._least_m = max(model.least_mm, LEAST_MM) * 1e-3
            self._most_m = min(model.most_mm, BEYOND_MM[CHARACTERS[request.command]]) * 1e-3

    def forget(self) -> None:
        """Pieces from before do not belong to what comes."""
        self._rest = b""

    def feed(self, chunk: bytes) -> list[Reply | Measurement]:
        """What is complete now."""
        *blocks, self._rest = (self._rest + chunk).split(b"\n\n")
        if len(self._rest) > LARGEST:
            self._rest = b""
            self.counts.overflow += 1
        found: list[Reply | Measurement] = []
        for block in filter(None, (piece.strip(b"\n") for piece in blocks)):
            one = self._block(block) if len(block) <= LARGEST else "overflow"
            if isinstance(one, str):
                setattr(self.counts, one, getattr(self.counts, one) + 1)
            else:
                found.append(one)
        return found

    def _block(self, block: bytes) -> Reply | Measurement | str:
        """What it says, or under what it is counted."""
        echo, *lines = block.split(b"\n")
        name = echo[:2].decode("latin-1")
        if not lines or name not in COMMANDS or not _ECHO.fullmatch(echo):
            return "foreign"
        if len(lines) == 1 and len(lines[0]) == 1:  # SCIP 1.1
            return self._replied(Reply(name, lines[0].decode("latin-1")))
        if len(lines[0]) != 3 or checksum(lines[0][:2]) != lines[0][2] or not _STATUS.fullmatch(lines[0][:2]):
            return "check"
        status = lines[0][:2].decode()
        if name in CHARACTERS and (len(lines) > 1 or status == STREAM):
            return self._measured(echo, status, lines[1:])
        said = []
        for line in lines[1:]:
            text = _unsummed(line, code=name == "TM")
            if text is None:
                return "check"
            said.append(text)
        return self._replied(Reply(name, status, tuple(said)))

    def _replied(self, reply: Reply) -> Reply:
        self.counts.replies += 1
        return reply

    def _measured(self, echo: bytes, status: str, lines: list[bytes]) -> Measurement | str:
        """A measurement: the echo has no sum of its own, so it must be the one asked for to the letter."""
        request = self._request
        if request is None or status != (STREAM if request.again else OK):
            return "foreign"
        steps, left = request.steps(), 0
        if echo[: len(steps)] != steps:
            return "foreign"
        if request.again:
            rest = echo[len(steps) :]
            if len(rest) != 2 or not rest.isdigit():
                return "foreign"
            left = int(rest)
        elif len(echo) != len(steps):
            return "foreign"
        if len(lines) < 2 or len(lines[0]) != 5:
            return "length"
        if checksum(lines[0][:4]) != lines[0][4]:
            return "check"
        ms = decode(lines[0][:4])
        characters = CHARACTERS[request.command]
        wanted = request.values * characters * (2 if request.command[1] == "E" else 1)
        if [len(line) - 1 for line in lines[1:-1]] != [BLOCK] * (len(lines) - 2):
            return "length"
        text = b"".join(line[:-1] for line in lines[1:])
        if len(text) != wanted or not 1 <= len(lines[-1]) - 1 <= BLOCK:
            return "length"
        if ms < 0 or any(checksum(line[:-1]) != line[-1] for line in lines[1:]):
            return "check"
        ranges = self._metres(text, characters, intensities=request.command[1] == "E")
        if ranges is None:
            return "check"
        self.counts.scans += 1
        return Measurement(ms, ranges, left)

    def _metres(self, text: bytes, characters: int, *, intensities: bool) -> bytes | None:
        """Distances as a scan keeps them; None where a character is none of the code."""
        import numpy as np

        digits = np.frombuffer(text, dtype=np.uint8) - np.uint8(0x30)  # what is below wraps to above
        if digits.max() > 0x3F:
            return None
        if intensities:
            digits = digits.reshape(-1, 2, characters)[:, 0, :]
        weights = np.array([1 << 6 * (characters - 1 - k) for k in range(characters)], dtype=np.float64)
        metres = digits.reshape(-1, characters).astype(np.float64) @ weights * 1e-3
        seen = (metres >= self._least_m - 1e-6) & (metres <= self._most_m + 1e-6)
        return np.where(seen, metres, math.nan).astype("<f4").tobytes()


def _unsummed(line: bytes, *, code: bool) -> str | None:
    """A line without its sum, which a `;` stands before in lines of words, and is not part of; None where it is wrong.

    In lines of the code `;` is a character as any other.

    Some firmware leaves a remark that begins with `<-` out of the sum.
    """
    said, last = line[:-1], line[-1] if line else -1
    words = said[:-1] if said.endswith(b";") and not code else said
    if last not in {checksum(said), checksum(words), checksum(words.split(b"<-")[0])}:
        return None
    return words.decode("latin-1")
