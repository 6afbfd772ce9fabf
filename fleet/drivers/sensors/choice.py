"""Which of several sources is believed. Pure."""

from __future__ import annotations

LOST_NS = 2_000_000_000  # a source that gives nothing for so long is lost, and the next one is believed
AGAIN_NS = 3_000_000_000  # a better one that came back is believed after so long
NOBODY = -1


class Choice:
    """The first source in rank that gives something. Ranks are 0, 1, ..., the best first.

    A source that comes and goes does not make the boat jump to and fro between two antennas: who is lost gives way
    after 2 s, and has its place back after 3 s without a gap.
    """

    def __init__(self) -> None:
        self.chosen = NOBODY
        self._heard: dict[int, int] = {}
        self._since: dict[int, int] = {}

    def take(self, rank: int, now_ns: int) -> bool:
        """A new value from a source; whether it is to be used."""
        if now_ns - self._heard.get(rank, -LOST_NS) > LOST_NS or rank not in self._since:
            self._since[rank] = now_ns
        self._heard[rank] = now_ns
        if rank == self.chosen:
            return True
        better = rank < self.chosen and now_ns - self._since[rank] >= AGAIN_NS
        if better or self.lost(now_ns):
            self.chosen = rank
            return True
        return False

    def lost(self, now_ns: int) -> bool:
        """Whether the one believed gives nothing, or there was none yet."""
        return self.chosen == NOBODY or now_ns - self._heard[self.chosen] > LOST_NS
