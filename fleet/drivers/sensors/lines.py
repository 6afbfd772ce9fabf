"""Bytes to lines, each with the time at which it arrived."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable

from fleet.drivers.sensors.port import Endpoint, Port

LONGEST = 1024  # NMEA 0183 allows 82, receivers make more, and gpsd a lot more
MOST_WAITING = 4000  # lines that nobody has asked for yet; the oldest give way
MOST_AT_ONCE = 400  # lines of one look: a flood takes its time from nobody


class Splitter:
    """Cuts bytes at line ends; what is longer than any line is dropped, up to the next line end. Pure."""

    def __init__(self, longest: int = LONGEST) -> None:
        self._longest = longest
        self._rest = b""
        self._skipping = False
        self.too_long = 0

    def feed(self, payload: bytes, *, whole: bool = False) -> list[bytes]:
        """The lines that end in these bytes, without their ends; `whole`: the last one ends here too."""
        *lines, rest = (self._rest + payload).replace(b"\r", b"\n").split(b"\n")
        if whole:
            lines, rest = [*lines, rest], b""
        found = []
        for line in lines:
            if self._skipping or len(line) > self._longest:
                self.too_long += not self._skipping
                self._skipping = False
            elif line:
                found.append(line)
        if len(rest) > self._longest:
            self.too_long += not self._skipping
            self._skipping, rest = True, b""
        self._rest = rest
        return found

    def forget(self) -> None:
        """Drop the line that has begun."""
        self._rest, self._skipping = b"", False


class Lines:
    """A port that gives lines."""

    def __init__(
        self,
        where: Endpoint,
        now_ns: Callable[[], int],
        greet: Callable[[Port], None] = lambda port: None,
        longest: int = LONGEST,
    ) -> None:
        self.port = Port(where, now_ns, self._take, lambda: self._begin(greet))
        self.counts: Counter[str] = Counter()
        self.heard_ns = 0  # when anything arrived last
        self._datagrams = where.kind == "udp"
        self._splitter = Splitter(longest)
        self._waiting: deque[tuple[bytes, int]] = deque(maxlen=MOST_WAITING)

    def _begin(self, greet: Callable[[Port], None]) -> None:
        self._splitter.forget()
        greet(self.port)

    def _take(self, payload: bytes, stamp_ns: int) -> None:
        self.heard_ns = stamp_ns
        for line in self._splitter.feed(payload, whole=self._datagrams):
            self.counts["dropped"] += len(self._waiting) >= MOST_WAITING
            self._waiting.append((line, stamp_ns))

    def take(self) -> list[tuple[bytes, int]]:
        """Lines that arrived, with their stamps; so many at most, the rest later."""
        return [self._waiting.popleft() for _ in range(min(len(self._waiting), MOST_AT_ONCE))]
