"""Boats of the fleet meet foreign vessels: one scenario after the other on floats, with sensors, judged by the truth.

The law of `fleet.avoidance.foreign` runs as on a boat, every tick, on tracks of `fleet.sensing`. Vessels follow their
scripts and see nobody. Every random number is a hash of (seed, case, vessel, number, purpose).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from msgspec import Struct

from fleet.avoidance.foreign import (
    START,
    Advice,
    Boat,
    Edge,
    ForeignParams,
    Mate,
    Memory,
    keep_clear,
    order_of,
    sail_order,
)
from fleet.coordination import Member, along_path_error, formation_speed
from fleet.guidance import Limits, follow
from fleet.hulls import CALM, HullState, unicycle
from fleet.ops import FloatArray
from fleet.paths import straight
from fleet.sensing import Target, Track, begin, lost, seen, update_ais, update_position
from fleet.sim.batch.draws import more, normal, uniform

DT_S = 0.1
LIMITS = Limits()
GAIN_PER_M = 0.3
DONE_M = 1.0  # off its path, and
DONE_S = 5.0  # for this long clear of everybody: the scenario is over
FIRST_WORD = 7_000  # purposes of draws: 16 of them a vessel


class Ship(Struct, frozen=True, kw_only=True):
    """A foreign vessel and its script."""

    x: float  # at the start [m]
    y: float
    chi: float  # course [rad]
    U: float  # [m/s]
    length: float  # [m]
    turns_s: float = math.inf  # when it begins to turn
    turn: float = 0.0  # by how much, + to starboard [rad]
    rate: float = 0.05  # how fast [rad/s]
    sensor: str = "exact"  # exact, ais, positions


class ShipCase(Struct, frozen=True, kw_only=True):
    """One scenario. Every boat sails its own straight path at cruise speed."""

    suite: str
    seed: int
    case: int
    cruise: float  # [m/s]
    paths: tuple[tuple[float, float, float], ...]  # of each boat: north and east of its start, abscissa of its slot
    ships: tuple[Ship, ...]
    meet_s: float  # about when they meet
    limit_s: float
    edges: tuple[Edge, ...] = ()


class Decided(Struct, frozen=True, gc=False):
    """A decision of a boat."""

    t: float
    boat: int
    acting: float
    a: float
    factor: float
    target: float
    range_m: float  # to that vessel, true
    reason: float


class Voyage(Struct, frozen=True):
    """The truth of a scenario; arrays are (tick, boat) or (tick, ship)."""

    t: FloatArray
    x: FloatArray
    y: FloatArray
    psi: FloatArray
    u: FloatArray
    ship_x: FloatArray
    ship_y: FloatArray
    ship_chi: FloatArray
    decisions: tuple[Decided, ...]
    complete: bool  # over before its time was up


def ship_track(ship: Ship, ticks: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(x, y, course) of a vessel at every tick."""
    t = np.arange(ticks) * DT_S
    begun = np.clip(t - ship.turns_s, 0.0, None) if math.isfinite(ship.turns_s) else np.zeros(ticks)
    turned = np.minimum(begun * ship.rate, abs(ship.turn)) * math.copysign(1.0, ship.turn)
    chi = ship.chi + turned
    x = ship.x + np.concatenate([[0.0], np.cumsum(ship.U * np.cos(chi[:-1]) * DT_S)])
    y = ship.y + np.concatenate([[0.0], np.cumsum(ship.U * np.sin(chi[:-1]) * DT_S)])
    return x, y, chi


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


class _Watch:
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


class _Fleet:
    """The boats of one scenario while they sail: the first leads, unless each decides alone."""

    def __init__(self, case: ShipCase, params: ForeignParams, alone: bool) -> None:
        self.case, self.params, self.alone = case, params, alone
        far = 2.0 * case.limit_s * LIMITS.speed_max_mps + 1000.0
        self.paths = [straight((x, y), (x + far, y)) for x, y, _ in case.paths]
        self.hulls = [unicycle.start(x, y, 0.0, case.cruise) for x, y, _ in case.paths]
        self.s = [0.0 for _ in case.paths]
        self.memories = [START for _ in case.paths]

    def tick(self, targets: Sequence[Target], now: float) -> list[Advice]:
        """Decide, steer and move all boats by one tick."""
        boats = [self._boat(i) for i in range(len(self.hulls))]
        advice = [self._decide(i, boats, targets, now) for i in range(len(boats))]
        for i, (boat, told) in enumerate(zip(boats, advice, strict=True)):
            f = follow(boat.x, boat.y, boat.chi, boat.U, boat.path.at(boat.s), self.params.follow)
            u_d, r_d = (told.u_d, told.r_d) if told.acting > 0.5 else (self._wanted(i), f.r_d)
            self.hulls[i] = unicycle.advance(self.hulls[i], u_d, r_d, CALM, LIMITS, DT_S)
            self.s[i] += DT_S * f.s_dot
        return advice

    def at_rest(self) -> bool:
        """Everybody follows a path that is clear, and is on it."""
        return all(
            m.sailed.acting < 0.5 and not m.encounters and abs(hull.y - y) < DONE_M
            for m, hull, (_, y, _) in zip(self.memories, self.hulls, self.case.paths, strict=True)
        )

    def _boat(self, i: int) -> Boat:
        hull = self.hulls[i]
        return Boat(hull.x, hull.y, hull.psi, hull.u, hull.r, self.s[i], self.case.cruise, self.paths[i], LIMITS)

    def _decide(self, i: int, boats: Sequence[Boat], targets: Sequence[Target], now: float) -> Advice:
        edges, memory = self.case.edges, self.memories[i]
        others = [hull for j, hull in enumerate(self.hulls) if j != i]
        mates = [Mate(o.x, o.y, o.u * math.cos(o.psi), o.u * math.sin(o.psi)) for o in others]
        if self.alone or len(boats) == 1:
            memory, advice = keep_clear((boats[i],), targets, mates, edges, memory, self.params, now)
        elif i == 0:
            memory, advice = keep_clear(boats, targets, (), edges, memory, self.params, now)
        else:
            order = order_of(self.memories[0], 0.0)
            memory, advice = sail_order(boats[i], targets, mates, edges, order, True, memory, self.params, now)
        self.memories[i] = memory
        return advice

    def _wanted(self, i: int) -> float:
        """Speed that the formation wants of a boat [m/s]."""
        cruise = self.case.cruise
        if len(self.hulls) == 1:
            return cruise
        z = [hull.x - slot for hull, (_, _, slot) in zip(self.hulls, self.case.paths, strict=True)]
        e = along_path_error(z[i], [Member(1.0, other) for j, other in enumerate(z) if j != i])
        return formation_speed(e, cruise, 0.0, LIMITS.speed_max_mps, GAIN_PER_M)


def sail(case: ShipCase, params: ForeignParams | None = None, alone: bool = False) -> Voyage:
    """Sail one scenario until everybody is past and the boats are back on their paths, or its time is up.

    Args:
        params: of the law; its defaults if None
        alone: the boats of a formation decide each for itself, with the mates as discs
    """
    ticks = round(case.limit_s / DT_S)
    truth = [ship_track(ship, ticks) for ship in case.ships]
    watch = _Watch(case, truth)
    fleet = _Fleet(case, ForeignParams() if params is None else params, alone)
    rows: list[list[HullState[float]]] = []
    decisions: list[Decided] = []
    done = 0.0
    for k in range(ticks):
        now = k * DT_S
        rows.append(list(fleet.hulls))
        watch.take(k, fleet.hulls[0].x, fleet.hulls[0].y)
        hulls = list(fleet.hulls)
        for i, told in enumerate(fleet.tick(watch.targets(now), now)):
            if told.decided > 0.5:
                decisions.append(_decided(now, i, hulls[i], fleet.memories[i], truth, k))
        done = done + DT_S if now > case.meet_s and fleet.at_rest() else 0.0
        if done >= DONE_S:
            break
    kept = len(rows)
    x, y, psi, u = (np.array([[getattr(h, name) for h in row] for row in rows]) for name in ("x", "y", "psi", "u"))
    columns = [np.stack([track[n][:kept] for track in truth], axis=1) for n in range(3)]
    return Voyage(
        t=np.arange(kept, dtype=float) * DT_S,
        x=x,
        y=y,
        psi=psi,
        u=u,
        ship_x=columns[0],
        ship_y=columns[1],
        ship_chi=columns[2],
        decisions=tuple(decisions),
        complete=done >= DONE_S,
    )


def _decided(
    now: float,
    boat: int,
    hull: HullState[float],
    memory: Memory,
    truth: Sequence[tuple[FloatArray, FloatArray, FloatArray]],
    k: int,
) -> Decided:
    """A decision, with the true range to the vessel that it is for."""
    action, range_m = memory.ordered, math.nan
    if memory.target >= 0.0:
        x, y, _ = truth[int(memory.target)]
        range_m = math.hypot(x[k] - hull.x, y[k] - hull.y)
    return Decided(now, boat, action.acting, action.a, action.factor, memory.target, range_m, memory.reason)
