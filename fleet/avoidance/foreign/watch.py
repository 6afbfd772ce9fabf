"""One look around: every vessel's domain, when the paths enter it, and the encounters after that."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.foreign.banks import within
from fleet.avoidance.foreign.domain import Domain, domain
from fleet.avoidance.foreign.encounter import BY_STARBOARD, Bearing, bearing, classify, look
from fleet.avoidance.foreign.memory import Memory
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.rollout import (
    entry,
    following,
    time_back,
)
from fleet.avoidance.foreign.types import (
    NEVER_S,
    Boat,
    Edge,
    Encounter,
    TargetLike,
)


class Picture(Struct, frozen=True, gc=False):
    """What one look sees."""

    own: Bearing
    domains: tuple[Domain, ...]
    encounters: tuple[Encounter, ...]
    edges: tuple[Edge, ...]


def look_around(
    boats: Sequence[Boat],
    targets: Sequence[TargetLike],
    edges: Sequence[Edge],
    memory: Memory,
    params: ForeignParams,
    now: float,
) -> tuple[Picture, Memory]:
    """Everything around, and the encounters after it."""
    lead = boats[0]
    own, extent = bearing(lead), _extent(boats)
    domains = tuple(
        domain(target, lead.cruise, extent, params)
        for target in sorted(targets, key=lambda each: each.number)
        if target.usable > 0.5
    )
    acts = memory.ordered.acting > 0.5
    encounters = memory.encounters
    if domains:
        back = max(time_back(boat, params) for boat in boats)
        horizon = max(d.H for d in domains) + back
        ways = [following(boat, horizon, params) for boat in boats]
        before = {e.number: e for e in encounters}
        factor = params.acting_factor if acts else 1.0
        looked = (
            look(
                before.get(d.number),
                own,
                d,
                min(entry(way, d, d.H + back, factor, 1.0, 0.0) for way in ways),
                acts,
                params,
            )
            for d in domains
        )
        encounters = tuple(e for e in looked if e is not None)
    else:
        encounters = ()
    memory = structs.replace(memory, encounters=encounters, due_s=_next_look(memory.due_s, now, params))
    reach = max((d.H for d in domains), default=0.0) * lead.limits.speed_max_mps + 2.0 * extent
    near = within(edges, lead.x, lead.y, reach) if encounters or acts else ()
    return Picture(own, domains, encounters, near), memory


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
        kind, side = classify(picture.own, d, params)
        if kind in BY_STARBOARD and entry(way, d, horizon, params.acting_factor, 1.0, 0.0) < NEVER_S:
            found.append((d.number, side))
    return tuple(found)


def _next_look(due_s: float, now: float, params: ForeignParams) -> float:
    """Every 0.5 s from the last one due; from now where that is over."""
    return due_s + params.period_s if due_s + params.period_s > now else now + params.period_s


def _extent(boats: Sequence[Boat]) -> float:
    """Half the largest distance between boats [m]."""
    return 0.5 * max((ops.hypot(a.x - b.x, a.y - b.y) for a in boats for b in boats), default=0.0)
