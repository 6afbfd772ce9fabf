"""How late a receiver's words are, compared with the promptest of the last minutes. Pure."""

from __future__ import annotations

DAY_NS = 86_400_000_000_000
FORGET_NS = 60_000_000_000
"""After one to two of these the promptest is forgotten: two clocks drift apart by some ms in that time."""


class Delay:
    """The own clock is not set by it, and need not be right: only the difference of the two clocks counts.

    What waited in a modem or a gateway and comes in a burst has old times in it, and is as old as it says.
    """

    def __init__(self) -> None:
        self._newer: int | None = None
        self._older: int | None = None
        self._since_ns = 0
        self._first_ns = 0

    def late_ns(self, time_s: float, stamp_ns: int) -> int:
        """How much later a sentence came than the promptest; of its UTC time of the day, and its arrival."""
        offset = (stamp_ns - round(time_s * 1e9)) % DAY_NS
        if self._newer is None:
            self._first_ns = offset  # differences are counted from here, so that midnight is nothing special
        offset = (offset - self._first_ns + DAY_NS // 2) % DAY_NS - DAY_NS // 2
        if self._newer is None or stamp_ns - self._since_ns > FORGET_NS:
            self._older, self._newer, self._since_ns = self._newer, offset, stamp_ns
        self._newer = min(self._newer, offset)
        least = self._newer if self._older is None else min(self._newer, self._older)
        return offset - least
