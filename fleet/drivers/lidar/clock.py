"""A scanner's clock, 24 bits of milliseconds from its start, told by the agent's clock. Pure.

The scanner is asked for its time before it measures (TM); the answer that came back quickest says best how the two
clocks lie. From then on the least delay of scans, found anew every ten seconds, tells how the scanner's clock drifts.
"""

from __future__ import annotations

from fleet.drivers.lidar.scip import TICKS

MS = 1_000_000
HALF = TICKS // 2
LATE_NS, EARLY_NS = 1_000_000_000, 200_000_000  # a scan that says to be older than that, or of the future, is refused
WRONG_MOST = 5  # so many one after the other, and the clock is another one's: the scanner was switched off and on
WINDOW_NS = 10_000_000_000
STEP_NS = 2_000_000  # corrected at most in a window: 200 parts in a million


class ScannerClock:
    """From the scanner's milliseconds to nanoseconds of the agent's clock."""

    def __init__(self) -> None:
        self.refused = 0
        self._wrong = 0
        self._offset_ns: int | None = None
        self._ms = 0  # as it would be without wrapping
        self._trip_ns = 0  # of the best answer
        self._least_ns: int | None = None  # delay of scans in the first window
        self._window_ns = 0  # when the present one began
        self._window_least_ns = LATE_NS

    @property
    def known(self) -> bool:
        """Whether the scanner told its time."""
        return self._offset_ns is not None

    @property
    def lost(self) -> bool:
        """Whether its time is to be asked for again."""
        return self._wrong >= WRONG_MOST

    def answered(self, ms: int, sent_ns: int, received_ns: int) -> None:
        """The scanner said its time, asked for at `sent_ns`."""
        trip_ns = received_ns - sent_ns
        if trip_ns < 0:
            return
        unwrapped = self._unwrapped(ms)
        if self._offset_ns is None or trip_ns < self._trip_ns:
            self._offset_ns, self._trip_ns = sent_ns + trip_ns // 2 - unwrapped * MS, trip_ns

    def stamp_ns(self, ms: int, received_ns: int, least_delay_ns: int) -> int:
        """When a scan with this time was measured; 0 where that cannot be.

        Args:
            ms: the scanner's time
            received_ns: when it came
            least_delay_ns: a scan takes at least so long to come; for scanners that do not tell their time
        """
        unwrapped = self._unwrapped(ms)
        if self._offset_ns is None:
            self._offset_ns = received_ns - least_delay_ns - unwrapped * MS
        stamp = self._offset_ns + unwrapped * MS
        delay = received_ns - stamp
        if not -EARLY_NS <= delay <= LATE_NS:
            self.refused += 1
            self._wrong += 1
            return 0
        self._wrong = 0
        self._follow(delay, received_ns)
        return stamp

    def _unwrapped(self, ms: int) -> int:
        self._ms += (ms - self._ms + HALF) % TICKS - HALF
        return self._ms

    def _follow(self, delay_ns: int, now_ns: int) -> None:
        """Follow the drift: what the least delay grows by is the scanner's clock falling behind."""
        assert self._offset_ns is not None
        self._window_ns = self._window_ns or now_ns
        self._window_least_ns = min(self._window_least_ns, delay_ns)
        if now_ns - self._window_ns < WINDOW_NS:
            return
        if self._least_ns is None:
            self._least_ns = self._window_least_ns
        else:
            drift = self._window_least_ns - self._least_ns
            self._offset_ns += min(max(drift, -STEP_NS), STEP_NS)
        self._window_ns, self._window_least_ns = now_ns, LATE_NS
