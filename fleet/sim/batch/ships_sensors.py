"""What boats hear and see of foreign vessels: AIS and bare positions with noise and gaps, and their tracks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from msgspec import Struct

from fleet.ops import FloatArray
from fleet.sensing import Target, Track, begin, lost, seen, update_ais, update_position
from fleet.sim.batch.draws import more, normal, uniform
from fleet.sim.batch.ships import Ship, ShipCase
from fleet.sim.batch.ships_radio import DT_S

FIRST_WORD = 7_000  # purposes of draws: 16 of them a vessel


class Report(Struct, frozen=True, gc=False):
    """What a sensor says of a vessel."""

    tick: int
    x: float
    y: float
    sigma: float
    velocity: tuple[float, float] | None


def reports(case: ShipCase, number: int, truth: tuple[FloatArray, FloatArray, FloatArray]) -> Iterator[Report]:
    """What is heard or seen of a vessel, in time; range is not looked at.

    AIS every 2 to 10 s, positions at 1 to 2 Hz, both with 1 to 3 m; 10 % lost; 40 % of the vessels have one gap of 15
    to 45 s (AIS), of 4 to 12 s (positions). Exact: twice a second, without noise.
    """
    ship = case.ships[number]
    h = more(more(more(0, case.seed), case.case), number)

    def draw(purpose: int, low: float, high: float) -> float:
        return low + (high - low) * uniform(more(h, FIRST_WORD + purpose))

    exact, ais = ship.sensor == "exact", ship.sensor == "ais"
    every = 0.5 if exact else draw(0, 2.0, 10.0) if ais else draw(0, 0.5, 1.0)
    sigma = 0.3 if exact else draw(1, 1.0, 3.0)
    gap_from = draw(3, 0.0, case.meet_s)
    has_gap = not exact and draw(2, 0.0, 1.0) < 0.4
    gap_until = gap_from + (draw(4, 15.0, 45.0) if ais else draw(4, 4.0, 12.0)) if has_gap else gap_from
    x, y, chi = truth
    t = 0.0 if exact else draw(5, 0.0, every)
    k = 0
    while round(t / DT_S) < len(x):
        i = round(t / DT_S)
        word = more(more(h, FIRST_WORD + 100), k)
        heard = exact or (uniform(more(word, 1)) >= 0.1 and not gap_from <= t < gap_until)
        if heard:
            vx, vy = ship.U * math.cos(chi[i]), ship.U * math.sin(chi[i])
            if exact:
                yield Report(i, float(x[i]), float(y[i]), sigma, (vx, vy))
            else:
                px, py = float(x[i]) + sigma * normal(word, 10), float(y[i]) + sigma * normal(word, 20)
                told = (vx + 0.1 * normal(word, 30), vy + 0.1 * normal(word, 40)) if ais else None
                yield Report(i, px, py, sigma, told)
        k += 1
        t += every


def believed_length(case: ShipCase, number: int) -> float:
    """Length of a vessel as the boats think it is: +-25 % where only positions are seen [m]."""
    ship = case.ships[number]
    if ship.sensor != "positions":
        return ship.length
    h = more(more(more(0, case.seed), case.case), number)
    return ship.length * (0.75 + 0.5 * uniform(more(h, FIRST_WORD + 6)))


def reach(ship: Ship) -> float:
    """How far off a vessel is noticed [m]."""
    if ship.sensor != "positions":
        return 5000.0
    return 400.0 if ship.length >= 20.0 else 200.0


class Tracks:
    """The tracks of all vessels, as the boats have them."""

    def __init__(self, case: ShipCase, truth: Sequence[tuple[FloatArray, FloatArray, FloatArray]]) -> None:
        self.case = case
        self.feeds = [reports(case, i, track) for i, track in enumerate(truth)]
        self.next: list[Report | None] = [next(feed, None) for feed in self.feeds]
        self.tracks: list[Track | None] = [None for _ in self.feeds]

    def take(self, tick: int, x: float, y: float) -> None:
        """Take what has come until now from vessels within reach of (x, y)."""
        for i, feed in enumerate(self.feeds):
            said = self.next[i]
            while said is not None and said.tick <= tick:
                if math.hypot(said.x - x, said.y - y) <= reach(self.case.ships[i]):
                    self.tracks[i] = self._merged(i, self.tracks[i], said)
                said = self.next[i] = next(feed, None)

    def _merged(self, i: int, track: Track | None, said: Report) -> Track:
        now = said.tick * DT_S
        if track is None or lost(track, now):
            length = believed_length(self.case, i)
            return begin(float(i), said.x, said.y, said.sigma, now, length, said.velocity)
        if said.velocity is None:
            return update_position(track, said.x, said.y, said.sigma, now)
        return update_ais(track, said.x, said.y, said.sigma, *said.velocity, now)

    def targets(self, now: float) -> list[Target]:
        """The vessels as they are thought to be now."""
        return [seen(track, now) for track in self.tracks if track is not None and not lost(track, now)]
