"""How late a receiver's words are, compared with the promptest so far. Pure."""

from __future__ import annotations

DAY_NS = 86_400_000_000_000
DRIFT = 2e-4
"""Two clocks drift apart by no more; so slowly the promptest is forgotten: what came 2 s late stays late for hours."""


class Delay:
    """The own clock is not set by it, and need not be right: only the difference of the two clocks counts.

    What waited in a modem or a gateway and comes in a burst has old times in it, and is as old as it says.
    """

    def __init__(self) -> None:
        self._first_ns = 0
        self._least: float | None = None
        self._last_ns = 0

    def late_ns(self, time_s: float, stamp_ns: int) -> int:
        """How much later a sentence came than the promptest; of its UTC time of the day, and its arrival."""
        offset = (stamp_ns - round(time_s * 1e9)) % DAY_NS
        if self._least is None:
            self._first_ns, self._least, self._last_ns = offset, 0.0, stamp_ns  # midnight is then nothing special
        offset = (offset - self._first_ns + DAY_NS // 2) % DAY_NS - DAY_NS // 2
        least = self._least + DRIFT * max(stamp_ns - self._last_ns, 0)
        self._least, self._last_ns = min(float(offset), least), stamp_ns
        return int(offset - self._least)
