"""One scenario with foreign vessels, judged: rules 8 and 13 to 17 as figures, from the true tracks only."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from fleet.avoidance.foreign import ForeignParams, Kind, Reason
from fleet.avoidance.foreign.encounter import BY_STARBOARD
from fleet.sim.batch.ships import Decided, ShipCase, Voyage
from fleet.sim.batch.ships_cases import c0
from fleet.sim.batch.ships_measures import (
    PARAMS,
    closest,
    core,
    deviation,
    domain_share,
    hull_distance,
    miss,
    nominal,
    to_edge,
    velocity,
    way_made,
)
from fleet.sim.batch.ships_radio import DT_S
from fleet.sim.batch.ships_results import Outcome, Summary
from fleet.sim.batch.ships_sail import sail

AGAIN_S = 60.0  # acting again for the same vessel sooner than this: re-trigger
BANK_ROOM_M = 3.0
SEEN_S, SEEN_RAD, SEEN_SHARE = 15.0, math.radians(25.0), 0.3
BEGAN_INSIDE = 1.2


def judge(case: ShipCase, voyage: Voyage) -> Outcome:
    """Figures of one scenario from its truth."""
    hull, dom, inside = math.inf, math.inf, False
    for k in range(len(case.ships)):
        hull = min(hull, float(hull_distance(case, voyage, k).min()))
        shares = domain_share(case, voyage, k)
        dom, inside = min(dom, float(shares.min())), inside or bool(shares[0].min() < BEGAN_INSIDE)
    met = {(party[0], k): nominal(case, k, party) for party in case.parties for k in range(len(case.ships))}
    sides = [
        miss(case, voyage, k, *_nearest(case, voyage, k, party)) > 0.0
        for party in case.parties
        for k in range(len(case.ships))
        for kind, entry in (met[party[0], k],)
        if kind in BY_STARBOARD
        and math.isfinite(entry)
        and _judged(case, voyage, k, _nearest(case, voyage, k, party)[0])
    ]
    risky = [(entry, kind) for kind, entry in met.values() if math.isfinite(entry)]
    _, kind = min(risky, default=(math.inf, 0.0))
    acts = [d for d in voyage.decisions if d.acting > 0.5 and d.reason != Reason.ORDER]
    lead_s = _lead(case, met, acts[0]) if acts else math.nan
    only = kind == Kind.CROSSING_STAND_ON and len(case.ships) == 1 and case.bend is None and not case.courses
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
        early=math.nan if case.courses else _in_time(case, kind, lead_s, len(case.ships)),
        substantial=_substantial(voyage, acts[0]) if acts else math.nan,
        first=int(out),
        decisions=len(acts),
        reversals=_reversals(voyage),
        retriggers=_retriggers(voyage),
        delay_s=float(voyage.t[-1] - way_made(case, voyage) / case.cruise),
        deviation_m=deviation(case, voyage),
        closest_m=closest(voyage),
        alone=0 if case.courses else sum(d.boat != case.leader for d in acts),
        bank_m=min((float(to_edge(voyage, e).min()) for e in case.edges), default=math.inf),
        complete=voyage.complete,
        ended_s=float(voyage.t[-1]),
    )


def _substantial(voyage: Voyage, first: Decided) -> float:
    """1 the track alters by 25 deg, or the speed by 30 %, within 15 s of the first action."""
    begin, i = round(first.t / DT_S), first.boat
    rows = slice(begin, min(begin + round(SEEN_S / DT_S) + 1, len(voyage.t)))
    vx, vy = velocity(voyage.x[rows, i]), velocity(voyage.y[rows, i])
    turned = abs(np.arctan2(vx[0] * vy - vy[0] * vx, vx[0] * vx + vy[0] * vy)).max()
    U = np.hypot(vx, vy)
    return float(turned >= SEEN_RAD or abs(U / max(float(U[0]), 1e-6) - 1.0).max() >= SEEN_SHARE)


def _nearest(case: ShipCase, voyage: Voyage, k: int, party: Sequence[int]) -> tuple[int, int]:
    """(tick, boat) at which hulls of a party and a vessel are nearest."""
    distances = hull_distance(case, voyage, k)[:, list(party)]
    row, column = np.unravel_index(int(distances.argmin()), distances.shape)
    return int(row), party[int(column)]


def _lead(case: ShipCase, met: dict[tuple[int, int], tuple[float, float]], first: Decided) -> float:
    """From the first action to the entry into the domain that it prevents [s]."""
    head = next(party[0] for party in case.parties if first.boat in party)
    return met[head, int(first.target)][1] - first.t


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
        blur = core(case, 0, (4.0 * case.ships[0].length) ** 2)[2] - c_of(case)  # c / 2
        latest = PARAMS.stand_on_factor * (T_need + blur / u) + PARAMS.stand_on_s + 2.0
        return float(T_need <= lead_s <= latest)
    return float(lead_s >= T_need)


def _extent(case: ShipCase) -> float:
    """Half the largest distance between the boats at the start [m]."""
    return 0.5 * max(math.hypot(a[0] - b[0], a[1] - b[1]) for a in case.paths for b in case.paths)


def c_of(case: ShipCase) -> float:
    """C0 of the first vessel [m]."""
    return core(case, 0)[2]


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


def run_suite(cases: Iterable[ShipCase], params: ForeignParams | None = None, alone: bool = False) -> Summary:
    """Sail and judge all scenarios of a suite."""
    import time

    began = time.process_time()
    outcomes, suite = [], ""
    for case in cases:
        suite = case.suite
        outcomes.append(judge(case, sail(case, params, alone)))
    return Summary(suite=suite, outcomes=outcomes, cpu_s=time.process_time() - began)
