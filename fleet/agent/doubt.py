"""Words that do not follow from what a name said before: believed once enough of them in a row agree.

A message that was altered on its way, forged or replayed must not shut out the true ones, and a boat whose numbers or
place truly leapt must not be shut out for ever. What follows plainly settles every doubt.
"""

from __future__ import annotations

from msgspec import Struct

from fleet import ops
from fleet.wire.messages import BoatState

FASTEST_JUMP_MPS = 15.0
NEAR_M = 5.0
SLACK = 5  # messages missed at once that need no time: below the 7 periods after which a boat is silent


class Doubt(Struct):
    """The last doubtful message of a name, and how many before it agree with it."""

    epoch: int = -1
    seq: int = 0
    x: float = 0.0
    y: float = 0.0
    since_ns: int = 0
    at_ns: int = 0
    count: int = 0

    def add(self, state: BoatState, x: float, y: float, now_ns: int, state_hz: float) -> None:
        """One more."""
        gap_s = (now_ns - self.at_ns) * 1e-9
        agrees = (
            self.epoch == state.epoch
            and 0 < state.seq - self.seq <= most_missed(gap_s, state_hz) + 1
            and ops.hypot(x - self.x, y - self.y) < FASTEST_JUMP_MPS * gap_s + NEAR_M
        )
        if not agrees:
            self.since_ns, self.count = now_ns, 0
        self.epoch, self.seq, self.x, self.y, self.at_ns = state.epoch, state.seq, x, y, now_ns
        self.count += 1

    def settled(self, messages: int, seconds: float) -> bool:
        """Whether so many have agreed for so long."""
        return self.count >= messages and (self.at_ns - self.since_ns) * 1e-9 >= seconds

    def clear(self) -> None:
        """Forget them."""
        self.epoch, self.count = -1, 0


def most_missed(gap_s: float, state_hz: float) -> float:
    """Messages that may have been lost in a time; a number that leaps further is not believed at once."""
    return SLACK + 2.0 * gap_s * state_hz
