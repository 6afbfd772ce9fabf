"""Boats of the fleet meet foreign vessels: one scenario after the other on floats, with sensors, judged by the truth.

The law of `fleet.avoidance.foreign` runs as on a boat, every tick, on tracks of `fleet.sensing`. Vessels follow their
scripts and see nobody. Boats tell each other what they do, and the leader what it orders, by the radio of
`ships_radio`. Every random number is a hash of (seed, case, vessel, number, purpose).
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
from fleet.hulls import HULLS, STEP_S, HullState, Water
from fleet.ops import FloatArray
from fleet.paths import Lane, Path, polyline, straight
from fleet.sensing import Target, Track, begin, lost, seen, update_ais, update_position
from fleet.sim.batch.draws import more, normal, uniform
from fleet.sim.batch.ships_radio import DT_S, Radio, Said, State

LIMITS = Limits()
GAIN_PER_M = 0.3
HULL_STEPS = round(DT_S / STEP_S)
STANDS_MPS = 0.05
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


class Bend(Struct, frozen=True, kw_only=True):
    """Where the path of the boats bends: a corner, rounded."""

    at_m: float  # from the start
    turn: float  # + to starboard [rad]
    radius_m: float = 20.0


class ShipCase(Struct, frozen=True, kw_only=True):
    """One scenario. Every boat sails at cruise speed along its path: to the north, bent once if at all."""

    suite: str
    seed: int
    case: int
    cruise: float  # [m/s]
    paths: tuple[tuple[float, float, float], ...]  # of each boat: north and east of its start, abscissa of its slot
    ships: tuple[Ship, ...]
    meet_s: float  # about when they meet
    limit_s: float
    edges: tuple[Edge, ...] = ()
    bend: Bend | None = None
    hull: str = "unicycle"
    limits: Limits = LIMITS
    current: tuple[float, float] = (0.0, 0.0)  # north, east [m/s]
    radio: Radio = Radio()

    def path(self) -> Path:
        """The path of the first boat; the others sail beside it."""
        x, y, _ = self.paths[0]
        far = 2.0 * self.limit_s * self.limits.speed_max_mps + 1000.0
        if self.bend is None:
            return straight((x, y), (x + far, y))
        corner, turn = x + self.bend.at_m, self.bend.turn
        end = (corner + far * math.cos(turn), y + far * math.sin(turn))
        return polyline([(x, y), (corner, y), end], self.bend.radius_m)

    def path_of(self, boat: int) -> Path | Lane:
        """That of any boat."""
        aside = self.paths[boat][1] - self.paths[0][1]
        return self.path() if aside == 0.0 else Lane(self.path(), aside)


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
        self.paths = [case.path_of(i) for i in range(len(case.paths))]
        self.model = HULLS[case.hull]
        self.water = Water(*case.current, 0.0, 0.0)
        self.hulls = [self.model.start(x, y, 0.0, case.cruise) for x, y, _ in case.paths]
        self.s = [x - case.paths[0][0] for x, _, _ in case.paths]
        self.off = [0.0 for _ in case.paths]
        self.memories = [START for _ in case.paths]
        self.said = Said(case.radio, len(case.paths), case.seed, case.case)

    def tick(self, targets: Sequence[Target], k: int) -> list[Advice]:
        """Decide, steer and move all boats by one tick."""
        case, now, boats = self.case, k * DT_S, [self._boat(i) for i in range(len(self.hulls))]
        for i, boat in enumerate(boats if len(boats) > 1 else ()):
            vx, vy = boat.U * math.cos(boat.chi), boat.U * math.sin(boat.chi)
            order = order_of(self.memories[0], 0.0) if i == 0 else None
            self.said.say(k, State(now, i, boat.x, boat.y, vx, vy, boat.chi, boat.U, boat.r, boat.s, order))
        advice = [self._decide(i, boats[i], self.said.heard(k, i), targets, now) for i in range(len(boats))]
        for i, (boat, told) in enumerate(zip(boats, advice, strict=True)):
            f = follow(boat.x, boat.y, boat.chi, boat.U, boat.path.at(boat.s), self.params.follow)
            u_d, r_d = (told.u_d, told.r_d) if told.acting > 0.5 else (self._wanted(i, now), f.r_d)
            self.hulls[i] = self.model.advance_by(
                HULL_STEPS, self.hulls[i], u_d, r_d, self.water, case.limits, STEP_S, 1.0
            )
            lane = boat.path.stretch(boat.s) if isinstance(boat.path, Lane) else 1.0
            self.s[i] += DT_S * f.s_dot / lane
            self.off[i] = f.y1
        return advice

    def at_rest(self) -> bool:
        """Everybody follows a path that is clear, and is on it."""
        return all(
            m.sailed.acting < 0.5 and not m.encounters and abs(off) < DONE_M
            for m, off in zip(self.memories, self.off, strict=True)
        )

    def _boat(self, i: int) -> Boat:
        hull = self.hulls[i]
        chi, U = _over_ground(*self.model.velocity(hull, self.water), hull.psi)
        return Boat(hull.x, hull.y, chi, U, hull.r, self.s[i], self.case.cruise, self.case.limits, self.paths[i])

    def _decide(self, i: int, boat: Boat, heard: Sequence[State], targets: Sequence[Target], now: float) -> Advice:
        edges, memory, params = self.case.edges, self.memories[i], self.params
        mates = [Mate(o.x, o.y, o.vx, o.vy) for o in heard]
        if self.alone or len(self.hulls) == 1:
            memory, advice = keep_clear((boat,), targets, mates, edges, memory, params, now)
        elif i == 0:
            boats = (boat, *(self._fellow(o) for o in heard))
            memory, advice = keep_clear(boats, targets, (), edges, memory, params, now)
        else:
            order = next((o.order for o in heard if o.boat == 0), None)
            in_place = order is not None and abs(self._error(i, heard)) <= params.slot_m
            memory, advice = sail_order(boat, targets, mates, edges, order, in_place, memory, params, now)
        self.memories[i] = memory
        return advice

    def _fellow(self, o: State) -> Boat:
        """A boat of the formation as the leader knows it."""
        return Boat(o.x, o.y, o.chi, o.U, o.r, o.s, self.case.cruise, self.case.limits, self.paths[o.boat])

    def _error(self, i: int, heard: Sequence[State]) -> float:
        """Along-path error of a boat, as it knows the others [m]."""
        slots = [slot for _, _, slot in self.case.paths]
        return along_path_error(self.s[i] - slots[i], [Member(1.0, o.s - slots[o.boat]) for o in heard])

    def _wanted(self, i: int, now: float) -> float:
        """Speed that the formation wants of a boat [m/s]."""
        cruise = self.case.cruise
        if len(self.hulls) == 1:
            return cruise
        e = self._error(i, self.said.known(i, now))
        return formation_speed(e, cruise, 0.0, self.case.limits.speed_max_mps, GAIN_PER_M)


def _over_ground(vx: float, vy: float, psi: float) -> tuple[float, float]:
    """Course and speed; the heading below 0.05 m/s."""
    U = math.hypot(vx, vy)
    return (math.atan2(vy, vx) if U >= STANDS_MPS else psi), U


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
        for i, told in enumerate(fleet.tick(watch.targets(now), k)):
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
