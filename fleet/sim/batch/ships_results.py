"""What came of meeting foreign vessels, from the true tracks only: rules 8 and 13 to 17 as figures."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from msgspec import Struct, structs

from fleet.avoidance.foreign import ForeignParams, Kind, Reason
from fleet.avoidance.foreign.domain import domain, gap
from fleet.avoidance.foreign.encounter import BY_STARBOARD, Bearing, classify
from fleet.ops import FloatArray
from fleet.sensing import Target
from fleet.sim.batch.ships import Decided, ShipCase, Voyage, sail
from fleet.sim.batch.ships_cases import c0
from fleet.sim.batch.ships_radio import DT_S

HULL_RADIUS_M = 0.6  # of the own capsule, 2.4 m x 1.2 m
HULL_HALF_M = 0.6  # from its centre to the centres of its round ends
CLASS_BEFORE_S = 200.0 * 2.2 / 1500.0  # of the time to meet: the class counts this long before entry
AGAIN_S = 60.0  # acting again for the same vessel sooner than this: re-trigger
BANK_ROOM_M = 3.0
SEEN_S, SEEN_RAD, SEEN_SHARE = 15.0, math.radians(25.0), 0.3
SPARSE = 10  # ticks
BEGAN_INSIDE = 1.2
PARAMS = ForeignParams()


class Outcome(Struct, frozen=True, kw_only=True):
    """One scenario, judged."""

    case: int
    kind: int  # Kind of the first vessel at risk, 0 none
    risk: bool  # straight on, some domain would have been entered
    contact: bool  # hulls touched
    hull_m: float  # least distance of hulls
    inside: bool  # it began within 1.2 C0 of a core: nothing of the domain is asked of it
    dom: float  # least distance to a core, as a share of C0; inf without a vessel
    side: float  # 1 every head-on and crossing vessel from starboard was left to port, 0 not, NaN none to judge
    stand_on_port: bool  # rule 17 c: as the stand-on boat it turned to port for a vessel to port
    first_range_m: float  # at the first action, NaN none
    lead_s: float  # from the first action to the entry it prevents, NaN none
    early: float  # 1 the first action was in time for its role, 0 not, NaN none
    substantial: float  # 1 the track shows it: 25 deg or 30 % of the speed within 15 s, 0 not, NaN none
    first: int  # 0 none, 1 starboard, -1 port, 2 only speed
    decisions: int  # alterations begun or changed, of all boats that decide
    reversals: int
    retriggers: int
    delay_s: float  # of the first boat
    deviation_m: float
    closest_m: float  # of two boats, inf for one
    alone: int  # followers' decisions of their own
    bank_m: float  # least distance to an edge, inf without
    complete: bool
    ended_s: float

    @property
    def rule_right(self) -> float:
        """1 what the rules ask is done: side, in time, to be seen, no closed turn to port; 0 not; NaN none asked."""
        asked = [each for each in (self.side, self.early, self.substantial) if not math.isnan(each)]
        return float(all(asked) and not self.stand_on_port) if asked else math.nan


class Summary(Struct, kw_only=True):
    """A suite."""

    suite: str
    outcomes: list[Outcome]
    cpu_s: float = 0.0

    def share(self, condition: Iterable[bool]) -> float:
        """Per cent of the scenarios."""
        return 100.0 * sum(condition) / max(len(self.outcomes), 1)

    def figures(self) -> dict[str, Any]:
        """The row of a table."""
        o = self.outcomes
        outside = [each for each in o if not each.inside]
        risk = [each for each in outside if each.risk]
        acted = [each for each in o if each.first != 0]
        sides = [each.side for each in o if not math.isnan(each.side)]
        timely = [each.early for each in o if not math.isnan(each.early)]
        plain = [each.substantial for each in o if not math.isnan(each.substantial)]
        right = [each.rule_right for each in o if not math.isnan(each.rule_right)]
        return {
            "suite": self.suite,
            "n": len(o),
            "at_risk": len(risk),
            "contact": sum(each.contact for each in o),
            "began inside": len(o) - len(outside),
            "dom<1 %": _share([each.dom < 1.0 for each in outside]),
            "dom<0.8 %": _share([each.dom < 0.8 for each in outside]),
            "dom 5/50 %": _percentiles([each.dom for each in risk], (5, 50)),
            "side ok %": _share(sides),
            "judged": len(sides),
            "stand-on port %": _share([each.stand_on_port for each in o]),
            "range 5/50/95 m": _percentiles([each.first_range_m for each in acted], (5, 50, 95)),
            "lead 5/50/95 s": _percentiles([each.lead_s for each in acted], (5, 50, 95)),
            "in time %": _share(timely),
            "substantial %": _share(plain),
            "rules right %": _share(right),
            "decisions": float(np.mean([each.decisions for each in acted])) if acted else 0.0,
            "reversal %": _share([each.reversals > 0 for each in o]),
            "re-trigger %": _share([each.retriggers > 0 for each in o]),
            "delay 50/95 s": _percentiles([each.delay_s for each in o], (50, 95)),
            "deviation 95 m": _percentiles([each.deviation_m for each in o], (95,)),
            "starboard/port/speed": tuple(sum(each.first == k for each in o) for k in (1, -1, 2)),
            "closest boats m": min((each.closest_m for each in o), default=math.inf),
            "boats < 6 m %": _share([each.closest_m < 6.0 for each in o]),
            "decided alone %": _share([each.alone > 0 for each in o]),
            "bank m": min((each.bank_m for each in o), default=math.inf),
            "unfinished": sum(not each.complete for each in o),
            "failed": [each.case for each in o if each.contact or (each.dom < 0.8 and not each.inside)],
            "cpu s a run": self.cpu_s / max(len(o), 1),
        }


def run_suite(cases: Iterable[ShipCase], params: ForeignParams | None = None, alone: bool = False) -> Summary:
    """Sail and judge all scenarios of a suite."""
    import time

    began = time.process_time()
    outcomes, suite = [], ""
    for case in cases:
        suite = case.suite
        outcomes.append(judge(case, sail(case, params, alone)))
    return Summary(suite=suite, outcomes=outcomes, cpu_s=time.process_time() - began)


def judge(case: ShipCase, voyage: Voyage) -> Outcome:
    """Figures of one scenario from its truth."""
    hull, dom, where, inside = math.inf, math.inf, [], False
    for k in range(len(case.ships)):
        distances = hull_distance(case, voyage, k)
        row, boat = np.unravel_index(int(distances.argmin()), distances.shape)
        where.append((int(row), int(boat)))
        hull = min(hull, float(distances.min()))
        shares = domain_share(case, voyage, k)
        dom, inside = min(dom, float(shares.min())), inside or bool(shares[0].min() < BEGAN_INSIDE)
    meetings = [_nominal(case, k) for k in range(len(case.ships))]
    sides = [
        _miss(case, voyage, k, *where[k]) > 0.0
        for k, (kind, entry) in enumerate(meetings)
        if kind in BY_STARBOARD and math.isfinite(entry) and _judged(case, voyage, k, where[k][0])
    ]
    risky = [(entry, kind) for kind, entry in meetings if math.isfinite(entry)]
    _, kind = min(risky, default=(math.inf, 0.0))
    acts = [d for d in voyage.decisions if d.acting > 0.5 and d.reason != Reason.ORDER]
    lead_s = meetings[int(acts[0].target)][1] - acts[0].t if acts else math.nan
    only = kind == Kind.CROSSING_STAND_ON and len(case.ships) == 1 and case.bend is None
    out = (1.0 if acts[0].a > 0.0 else -1.0 if acts[0].a < 0.0 else 2.0) if acts else 0.0
    return Outcome(
        case=case.case,
        kind=int(kind),
        risk=bool(risky),
        contact=hull <= 0.0,
        hull_m=hull,
        inside=inside,
        dom=dom,
        side=float(all(sides)) if sides else math.nan,
        stand_on_port=only and any(d.a < 0.0 < d.factor and _to_port(case, voyage, d.t) for d in acts),
        first_range_m=acts[0].range_m if acts else math.nan,
        lead_s=lead_s if math.isfinite(lead_s) else math.nan,
        early=_in_time(case, kind, lead_s, len(case.ships)),
        substantial=_substantial(voyage, acts[0]) if acts else math.nan,
        first=int(out),
        decisions=len(acts),
        reversals=_reversals(voyage),
        retriggers=_retriggers(voyage),
        delay_s=float(voyage.t[-1] - _way_made(case, voyage) / case.cruise),
        deviation_m=_deviation(case, voyage),
        closest_m=_closest(voyage),
        alone=sum(d.acting > 0.5 and d.boat > 0 and d.reason != Reason.ORDER for d in voyage.decisions),
        bank_m=min((float(_to_edge(voyage, e).min()) for e in case.edges), default=math.inf),
        complete=voyage.complete,
        ended_s=float(voyage.t[-1]),
    )


def _way_made(case: ShipCase, voyage: Voyage) -> float:
    """Of the first boat along its path [m]."""
    if case.bend is None:
        return float(voyage.x[-1, 0] - case.paths[0][0])
    return case.path().project(float(voyage.x[-1, 0]), float(voyage.y[-1, 0]))


def _deviation(case: ShipCase, voyage: Voyage) -> float:
    """Largest distance of a boat from its path [m]."""
    if case.bend is None:
        return float(abs(voyage.y - np.array([y for _, y, _ in case.paths])).max())
    most = 0.0
    for i in range(len(case.paths)):
        path = case.path_of(i)
        for x, y in zip(voyage.x[::SPARSE, i].tolist(), voyage.y[::SPARSE, i].tolist(), strict=True):
            point = path.at(path.project(x, y))
            most = max(most, math.hypot(x - point.x, y - point.y))
    return most


def _substantial(voyage: Voyage, first: Decided) -> float:
    """1 the track alters by 25 deg, or the speed by 30 %, within 15 s of the first action."""
    begin, i = round(first.t / DT_S), first.boat
    rows = slice(begin, min(begin + round(SEEN_S / DT_S) + 1, len(voyage.t)))
    vx, vy = _velocity(voyage.x[rows, i]), _velocity(voyage.y[rows, i])
    turned = abs(np.arctan2(vx[0] * vy - vy[0] * vx, vx[0] * vx + vy[0] * vy)).max()
    U = np.hypot(vx, vy)
    return float(turned >= SEEN_RAD or abs(U / max(float(U[0]), 1e-6) - 1.0).max() >= SEEN_SHARE)


def _velocity(x: FloatArray) -> FloatArray:
    """Over ground from positions [m/s]."""
    v: FloatArray = np.gradient(x, DT_S, axis=0) if len(x) > 1 else np.zeros_like(x)
    return v


def _share(values: Sequence[float] | Sequence[bool]) -> float:
    """Mean as per cent, NaN of nothing."""
    return 100.0 * float(np.mean([float(v) for v in values])) if values else math.nan


def _percentiles(values: Sequence[float], which: tuple[int, ...]) -> tuple[float, ...]:
    """Rounded to two places; NaN of nothing."""
    known = [v for v in values if math.isfinite(v)]
    return tuple(round(float(np.percentile(known, q)), 2) if known else math.nan for q in which)


def _relative(voyage: Voyage, k: int, extra: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Boats' centres in the frame of vessel k, its course as the first axis; `extra` metres ahead of the centre."""
    c, s = np.cos(voyage.ship_chi[:, k, None]), np.sin(voyage.ship_chi[:, k, None])
    dx = voyage.x + extra * np.cos(voyage.psi) - voyage.ship_x[:, k, None]
    dy = voyage.y + extra * np.sin(voyage.psi) - voyage.ship_y[:, k, None]
    return dx * c + dy * s, dy * c - dx * s


def hull_distance(case: ShipCase, voyage: Voyage, k: int) -> FloatArray:
    """(tick, boat): distance of the capsules, target length L and radius 0.1 L; <= 0 they touch [m]."""
    L = case.ships[k].length
    bow, stern = _relative(voyage, k, HULL_HALF_M), _relative(voyage, k, -HULL_HALF_M)
    d, _ = gap(stern[0], stern[1], bow[0], bow[1], -0.4 * L, 0.4 * L)
    return d - 0.1 * L - HULL_RADIUS_M


def _core(case: ShipCase, k: int, variance: float = 0.0) -> tuple[float, float, float]:
    """(astern, ahead, C) of the true vessel, C0 where it is exactly known; a stopped one is a point."""
    d = domain(structs.replace(_as_target(case, k, 0.0), P11=variance), case.cruise, 0.0, PARAMS)
    return d.astern, d.ahead, d.C


def _as_target(case: ShipCase, k: int, t: float) -> Target:
    """The vessel at time t, exactly known, before it turns."""
    ship = case.ships[k]
    vx, vy = ship.U * math.cos(ship.chi), ship.U * math.sin(ship.chi)
    return Target(
        float(k), ship.x + t * vx, ship.y + t * vy, vx, vy, 0.0, 0.0, 0.0, 0.0, ship.length, 0.0, 1.0
    )  # fmt: skip


def domain_share(case: ShipCase, voyage: Voyage, k: int) -> FloatArray:
    """(tick, boat): distance from the own centre to the core, as a share of C0."""
    astern, ahead, C = _core(case, k)
    x, y = _relative(voyage, k)
    over = x - np.clip(x, astern, ahead)
    share: FloatArray = np.sqrt(over * over + y * y) / C
    return share


def _nominal(case: ShipCase, k: int) -> tuple[float, float]:
    """(Kind, entry): with everybody straight on, when the domain would be entered and the class before that [s]."""
    ship = case.ships[k]
    t = np.array([i * DT_S for i in range(round(case.limit_s / DT_S))])
    vx, vy = ship.U * math.cos(ship.chi), ship.U * math.sin(ship.chi)
    astern, ahead, C = _core(case, k)
    inside = np.zeros(len(t), dtype=bool)
    c, s = math.cos(ship.chi), math.sin(ship.chi)
    for i in range(len(case.paths)):
        x, y = _undisturbed(case, i, t)
        dx, dy = x - ship.x - vx * t, y - ship.y - vy * t
        along, across = dx * c + dy * s, dy * c - dx * s
        over = along - np.clip(along, astern, ahead)
        inside |= over * over + across * across < C * C
    if not inside.any():
        return 0.0, math.inf
    entry = float(t[inside.argmax()])
    at = max(entry - CLASS_BEFORE_S * case.meet_s, 0.0)
    point = case.path().at(case.cruise * at)
    ex, ey = point.tx, point.ty
    own = Bearing(point.x, point.y, ex, ey, case.cruise, case.cruise * ex, case.cruise * ey)
    kind, _ = classify(own, domain(_as_target(case, k, at), case.cruise, 0.0, PARAMS), PARAMS)
    return kind, entry


def _undisturbed(case: ShipCase, boat: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where a boat would be with nobody in the way, at every time."""
    x, y, slot = case.paths[boat]
    if case.bend is None:
        return x + case.cruise * t, np.full_like(t, y)
    path = case.path_of(boat)
    places = [path.at(slot + case.cruise * each) for each in t[::SPARSE].tolist()]
    return (
        np.interp(t, t[::SPARSE], [place.x for place in places]),
        np.interp(t, t[::SPARSE], [place.y for place in places]),
    )


def _miss(case: ShipCase, voyage: Voyage, k: int, row: int, boat: int) -> float:
    """m = cross(p, w) at that tick: > 0 the vessel is left to port."""
    chi, U = voyage.ship_chi[row, k], case.ships[k].U
    px, py = voyage.ship_x[row, k] - voyage.x[row, boat], voyage.ship_y[row, k] - voyage.y[row, boat]
    before = max(min(row, len(voyage.t) - 2), 0)
    rows = slice(before, before + 2)
    vx, vy = _velocity(voyage.x[rows, boat])[0], _velocity(voyage.y[rows, boat])[0]
    wx, wy = vx - U * math.cos(chi), vy - U * math.sin(chi)
    return float(px * wy - py * wx)


def _judged(case: ShipCase, voyage: Voyage, k: int, row: int) -> bool:
    """The side can be asked of: it has not turned, no shoal is near, and a bank to starboard leaves room."""
    if voyage.t[row] > case.ships[k].turns_s:
        return False
    if len(case.edges) != 1:
        return not case.edges
    return bool(voyage.ship_y[row, k] + 0.7 * c0(case.ships[k].length) <= case.edges[0][1] - BANK_ROOM_M)


def _to_port(case: ShipCase, voyage: Voyage, t: float) -> bool:
    """The first vessel is to port of the first boat's path course, and has not turned so far."""
    row = round(t / DT_S)
    return bool(voyage.ship_y[row, 0] < voyage.y[row, 0]) and t < case.ships[0].turns_s


def _in_time(case: ShipCase, kind: float, lead_s: float, vessels: int) -> float:
    """Give-way: T_need before entry or more. Stand-on: T_need or more, and not 2 s before T_so of the widest domain."""
    if vessels > 1 or not math.isfinite(lead_s) or kind in (float(Kind.NONE), float(Kind.OVERTAKEN)):
        return math.nan
    u = max(case.cruise, PARAMS.least_speed_mps)
    T_need = PARAMS.react_s + (c_of(case) + _extent(case)) / u
    if kind == Kind.CROSSING_STAND_ON:
        blur = _core(case, 0, (4.0 * case.ships[0].length) ** 2)[2] - c_of(case)  # c / 2
        latest = PARAMS.stand_on_factor * (T_need + blur / u) + PARAMS.stand_on_s + 2.0
        return float(T_need <= lead_s <= latest)
    return float(lead_s >= T_need)


def _extent(case: ShipCase) -> float:
    """Half the largest distance between the boats at the start [m]."""
    return 0.5 * max(math.hypot(a[0] - b[0], a[1] - b[1]) for a in case.paths for b in case.paths)


def c_of(case: ShipCase) -> float:
    """C0 of the first vessel [m]."""
    return _core(case, 0)[2]


def _reversals(voyage: Voyage) -> int:
    """How often an alteration changed its side."""
    count = 0
    held: dict[int, float] = {}
    for d in voyage.decisions:
        if d.acting > 0.5 and held.get(d.boat, 0.0) * d.a < 0.0:
            count += 1
        held[d.boat] = d.a if d.acting > 0.5 else 0.0
    return count


def _retriggers(voyage: Voyage) -> int:
    """How often an action was begun for a vessel less than 60 s after resuming from one for it."""
    count = 0
    for boat in {d.boat for d in voyage.decisions}:
        ended: dict[float, float] = {}
        acting: set[float] = set()
        for d in (each for each in voyage.decisions if each.boat == boat):
            if d.acting < 0.5:
                ended.update(dict.fromkeys(acting, d.t))
                acting = set()
                continue
            if not acting and d.t - ended.get(d.target, -math.inf) < AGAIN_S:
                count += 1
            acting.add(d.target)
    return count


def _closest(voyage: Voyage) -> float:
    """Least distance between the centres of two boats [m]."""
    boats = voyage.x.shape[1]
    return min(
        (
            float(np.hypot(voyage.x[:, i] - voyage.x[:, j], voyage.y[:, i] - voyage.y[:, j]).min())
            for i in range(boats)
            for j in range(i)
        ),
        default=math.inf,
    )


def _to_edge(voyage: Voyage, edge: tuple[float, float, float, float]) -> FloatArray:
    """(tick, boat): distance to an edge [m]."""
    ax, ay, bx, by = edge
    long = math.hypot(bx - ax, by - ay)
    ex, ey = (bx - ax) / long, (by - ay) / long
    px, py = voyage.x - ax, voyage.y - ay
    along, across = px * ex + py * ey, py * ex - px * ey
    over = along - np.clip(along, 0.0, long)
    away: FloatArray = np.sqrt(over * over + across * across)
    return away


__all__ = ["Outcome", "Summary", "judge", "run_suite"]
