"""What boats that meet foreign vessels tell each other, ten times a second: lost, late, out of order and doubled."""

from __future__ import annotations

from msgspec import Struct, structs

from fleet.avoidance.foreign import Order
from fleet.sim.batch.draws import more, uniform

DT_S = 0.1
LINK_S = 3.0  # a boat that has not been heard for so long is lost
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


class State(Struct, frozen=True, gc=False):
    """A boat's message of a tick; the leader's carries its order, repeated every time."""

    t: float  # when it was said [s]
    boat: int
    x: float
    y: float
    vx: float
    vy: float
    chi: float
    U: float
    r: float
    s: float  # abscissa [m]
    order: Order | None


class Said:
    """The messages of one scenario on their way, and what everybody heard last from whom."""

    def __init__(self, radio: Radio, boats: int, seed: int, case: int) -> None:
        self._radio, self._boats = radio, boats
        self._h = more(more(more(0, seed), case), WORD)
        self._air: list[tuple[int, int, State]] = []  # tick at which it comes, to whom, what
        self._last: list[dict[int, State]] = [{} for _ in range(boats)]

    def say(self, k: int, state: State) -> None:
        """A boat tells all others."""
        for to in range(self._boats):
            if to == state.boat:
                continue
            if self._radio.perfect:
                self._last[to][state.boat] = state
                continue
            h = more(more(more(self._h, k), state.boat), to)
            late = self._radio.delay_s * (1.0 - UNEVEN + 2.0 * UNEVEN * uniform(more(h, 1)))
            if uniform(more(h, 2)) >= self._radio.loss:
                self._air.append((k + round(late / DT_S), to, state))
            if uniform(more(h, 3)) < DOUBLED and uniform(more(h, 4)) >= self._radio.loss:
                self._air.append((k + round((late + AGAIN_S * uniform(more(h, 5))) / DT_S), to, state))

    def heard(self, k: int, to: int) -> list[State]:
        """What a boat knows of the others at tick k, moved on to now; the newest message counts, whenever it comes."""
        left = []
        for due, whom, state in self._air:
            if due > k:
                left.append((due, whom, state))
            elif state.t > self._newest(whom, state.boat):
                self._last[whom][state.boat] = state
        self._air = left
        return self.known(to, k * DT_S)

    def known(self, to: int, now: float) -> list[State]:
        """The same, without taking in what has come since."""
        return [_moved(one, now) for _, one in sorted(self._last[to].items()) if now - one.t <= LINK_S]

    def _newest(self, whom: int, boat: int) -> float:
        """When the message was said that a boat has last of another [s]."""
        known = self._last[whom].get(boat)
        return -1.0 if known is None else known.t


def _moved(one: State, now: float) -> State:
    """As it went on: straight on for the age of the message, at its speed along its path."""
    age = now - one.t
    if age <= 0.0:
        return one
    return structs.replace(one, x=one.x + age * one.vx, y=one.y + age * one.vy, s=one.s + age * one.U)
