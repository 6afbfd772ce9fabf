"""One look around: every vessel's domain, when the paths enter it, and the encounters after that.

A look at many boats goes on over some ticks, a few boats in each.
"""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.foreign.banks import within
from fleet.avoidance.foreign.decision import speed
from fleet.avoidance.foreign.domain import Domain, domain
from fleet.avoidance.foreign.encounter import BY_STARBOARD, Bearing, bearing, believed, look
from fleet.avoidance.foreign.memory import Glance, Memory, Sighted
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.rollout import (
    Way,
    entry,
    following,
    holding,
    left_to_turn,
    motion,
    time_back,
)
from fleet.avoidance.foreign.types import (
    FOLLOW_PATH,
    NEVER_S,
    Action,
    Boat,
    Edge,
    Encounter,
    TargetLike,
)

LOOK_WORK = 100.0  # of a tick; 1 is the entry of one way into one domain, about 0.05 ms
FOLLOWING, HOLDING, BESIDE_BANKS = 5.0, 3.0, 15.0  # the work of one way


class Picture(Struct, frozen=True, gc=False):
    """What one look sees."""

    own: Bearing
    domains: tuple[Domain, ...]
    encounters: tuple[Encounter, ...]
    edges: tuple[Edge, ...]
    held: tuple[tuple[float, float], ...]  # (number, entry on the alteration that is held)
    beside: bool  # the path's course is clear beside the path


def look_on(
    boats: Sequence[Boat],
    targets: Sequence[TargetLike],
    edges: Sequence[Edge],
    memory: Memory,
    params: ForeignParams,
    now: float,
    decides: bool = True,
) -> tuple[Picture | None, Memory]:
    """Look at as many boats as one tick has time for, counted in ways and vessels; the picture once all are done.

    Each boat is looked at as it is in its own tick. With the picture come the encounters after it.

    Args:
        decides: what is held is looked at, too
    """
    lead = boats[0]
    own, extent = bearing(lead), _extent(boats)
    domains = tuple(
        domain(target, lead.cruise, extent, params)
        for target in sorted(targets, key=lambda each: each.number)
        if target.usable > 0.5
    )
    acts = memory.ordered.acting > 0.5
    reach = max((d.H for d in domains), default=0.0) * lead.limits.speed_max_mps + 2.0 * extent
    near = within(edges, lead.x, lead.y, reach) if domains or acts else ()
    glance = memory.glance
    if glance is None or glance.boats != len(boats):
        seen = tuple(Sighted(d.number, NEVER_S, NEVER_S) for d in domains)
        glance = Glance(float(len(boats)), 0.0, 1.0, seen)
        memory = structs.replace(memory, due_s=_next_look(memory.due_s, now, params))
    if domains:
        back, left = max(time_back(boat, params) for boat in boats), LOOK_WORK
        held_on = memory.ordered if decides else FOLLOW_PATH
        while glance.done < glance.boats and left > 0.0:
            boat = boats[int(glance.done)]
            glance = _looked(glance, boat, own, domains, near, back, held_on, memory.turning, params, now)
            left -= _work(len(domains), held_on, near)
        if glance.done < glance.boats:
            return None, structs.replace(memory, glance=glance)
    encounters = _encounters(glance, own, domains, memory, params, now)
    held = tuple((one.number, ops.maximum(one.held - now, 0.0)) for one in glance.seen if one.held < NEVER_S)
    memory = structs.replace(memory, encounters=encounters, glance=None)
    return Picture(own, domains, encounters, near if encounters or acts else (), held, glance.beside > 0.5), memory


def _work(vessels: int, held: Action, edges: Sequence[Edge]) -> float:
    """What it takes to look at one boat."""
    ways = (2.0 if held.a != 0.0 else 1.0) if held.acting > 0.5 else 0.0
    return FOLLOWING + ways * (BESIDE_BANKS if edges else HOLDING) + (1.0 + ways) * vessels


def _looked(
    glance: Glance,
    boat: Boat,
    own: Bearing,
    domains: Sequence[Domain],
    edges: Sequence[Edge],
    back: float,
    action: Action,
    turning: float,
    params: ForeignParams,
    now: float,
) -> Glance:
    """One more boat has been looked at."""
    acts = action.acting > 0.5
    factor = params.clear_factor if acts else 1.0
    path = following(boat, max(d.H for d in domains) + back, params)
    on_it = holding_on(boat, action, turning, edges, max(d.T_gw for d in domains), params) if acts else None
    by_number = {d.number: d for d in domains}
    seen = []
    for one in glance.seen:
        d = by_number.get(one.number)
        if d is None:
            continue
        t = entry(path, d, d.H + back, factor, 1.0, 0.0)
        held = NEVER_S
        if on_it is not None:
            held = entry(on_it, d, d.T_gw, params.held_factor, 0.5, params.opening_s)
        seen.append(Sighted(one.number, _earlier(one.entry, t, now), _earlier(one.held, held, now)))
    beside = glance.beside > 0.5 and acts and action.a != 0.0
    if beside:
        way = holding_on(boat, beside_path(own), 0.0, edges, max(d.H for d in domains), params)
        beside = all(entry(way, d, d.H, params.acting_factor, 1.0, params.opening_s) >= NEVER_S for d in domains)
    return Glance(glance.boats, glance.done + 1.0, 1.0 if beside else 0.0, tuple(seen))


def _earlier(at: float, t: float, now: float) -> float:
    """The earlier of a moment and of t seconds from now."""
    return at if t >= NEVER_S else min(at, now + t)


def _encounters(
    glance: Glance,
    own: Bearing,
    domains: Sequence[Domain],
    memory: Memory,
    params: ForeignParams,
    now: float,
) -> tuple[Encounter, ...]:
    """The encounters after the look."""
    before, acts = {e.number: e for e in memory.encounters}, memory.ordered.acting > 0.5
    by_number = {d.number: d for d in domains}
    met = [one for one in glance.seen if one.number in by_number]
    crowd = not acts and sum(one.entry - now < by_number[one.number].T_gw for one in met) > 1
    looked = (
        look(
            before.get(one.number),
            own,
            by_number[one.number],
            NEVER_S if one.entry >= NEVER_S else max(one.entry - now, 0.0),
            params,
            acts,
            crowd,
        )
        for one in met
    )
    return tuple(e for e in looked if e is not None)


def holding_on(
    boat: Boat, action: Action, turning: float, edges: Sequence[Edge], horizon: float, params: ForeignParams
) -> Way[float]:
    """The way of a boat that goes on with an action."""
    left = left_to_turn(boat.chi, action.cx, action.cy, action.sense if turning > 0.5 else 0.0)
    u_d = speed(boat, action.factor)
    return holding(motion(boat), left, action.cx, action.cy, u_d, edges, horizon, params)


def beside_path(own: Bearing) -> Action:
    """Course of the path at cruise speed, beside it."""
    return Action(1.0, 0.0, 1.0, own.ex, own.ey, 0.0, 0.0)


def foreseen(boat: Boat, picture: Picture, params: ForeignParams) -> tuple[tuple[float, float], ...]:
    """(number, side) of the vessels that the path meets later than they are looked at, but before all is over.

    A vessel for which rule 14 or 15 will ask for a side counts with that side as soon as something is decided.
    """
    met = {e.number for e in picture.encounters}
    later = [d for d in picture.domains if d.number not in met]
    if not later:
        return ()
    horizon = max(d.H for d in picture.domains) + time_back(boat, params)
    way, found = following(boat, horizon, params), []
    for d in later:
        kind, side = believed(picture.own, d, params)
        if kind in BY_STARBOARD and entry(way, d, horizon, params.acting_factor, 1.0, 0.0) < NEVER_S:
            found.append((d.number, side))
    return tuple(found)


def _next_look(due_s: float, now: float, params: ForeignParams) -> float:
    """Every 0.5 s from the last one due; from now where that is over."""
    return due_s + params.period_s if due_s + params.period_s > now else now + params.period_s


def _extent(boats: Sequence[Boat]) -> float:
    """Half the largest distance between boats [m]."""
    return 0.5 * max((ops.hypot(a.x - b.x, a.y - b.y) for a in boats for b in boats), default=0.0)
