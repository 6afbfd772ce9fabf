"""What boats that meet foreign vessels tell each other, ten times a second: lost, late, out of order and doubled."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct

from fleet.avoidance.foreign import Order
from fleet.sim.batch.draws import more, uniform
from fleet.sim.batch.hearing import Message

DT_S = 0.1
UNEVEN = 0.5  # a message comes within this share of the delay, sooner or later
DOUBLED, AGAIN_S = 0.05, 1.0  # so many come a second time, up to so much later
WORD = 9_000  # first purpose of draws


class Radio(Struct, frozen=True, kw_only=True):
    """Radio between every two boats. Without delay and loss it is perfect: everybody hears everything at once."""

    delay_s: float = 0.0
    loss: float = 0.0

    @property
    def perfect(self) -> bool:
        """Neither late nor lost."""
        return self.delay_s == 0.0 and self.loss == 0.0


class Words(Struct, frozen=True, gc=False):
    """A boat's message of a tick; that of a boat that decides carries its order, repeated every time."""

    t: float  # when it was said [s]
    boat: int
    told: Message[float]
    psi: float  # heading [rad]
    r: float  # yaw rate [rad/s]
    e: float  # along-path error [m]
    alone: bool  # it decides for itself
    order: Order | None


class Said:
    """The messages of one scenario on their way, and what everybody heard last from whom."""

    def __init__(self, radio: Radio, first: Sequence[Words], seed: int, case: int) -> None:
        """`first` is what everybody knows of each boat at the start."""
        self._radio, self._boats = radio, len(first)
        self._h = more(more(more(0, seed), case), WORD)
        self._air: list[tuple[int, int, Words]] = []  # tick at which it comes, to whom, what
        self._last = [{words.boat: words for words in first if words.boat != i} for i in range(len(first))]

    def say(self, k: int, words: Words) -> None:
        """A boat tells all others."""
        for to in range(self._boats):
            if to == words.boat:
                continue
            if self._radio.perfect:
                self._last[to][words.boat] = words
                continue
            h = more(more(more(self._h, k), words.boat), to)
            late = self._radio.delay_s * (1.0 - UNEVEN + 2.0 * UNEVEN * uniform(more(h, 1)))
            if uniform(more(h, 2)) >= self._radio.loss:
                self._air.append((k + round(late / DT_S), to, words))
            if uniform(more(h, 3)) < DOUBLED and uniform(more(h, 4)) >= self._radio.loss:
                self._air.append((k + round((late + AGAIN_S * uniform(more(h, 5))) / DT_S), to, words))

    def heard(self, k: int, to: int) -> dict[int, Words]:
        """What a boat knows of the others at tick k; the newest message counts, whenever it comes."""
        left = []
        for due, whom, words in self._air:
            if due > k:
                left.append((due, whom, words))
            elif words.t > self._last[whom][words.boat].t:
                self._last[whom][words.boat] = words
        self._air = left
        return self._last[to]
