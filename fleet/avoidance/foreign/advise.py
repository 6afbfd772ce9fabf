"""What is sailed this tick, and what is shown to people."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import structs

from fleet import ops
from fleet.avoidance.foreign.banks import bend, within
from fleet.avoidance.foreign.commit import TICK_S
from fleet.avoidance.foreign.decision import speed
from fleet.avoidance.foreign.domain import domain
from fleet.avoidance.foreign.encounter import earliest, role
from fleet.avoidance.foreign.memory import Memory
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.rollout import (
    distance,
    left_to_turn,
)
from fleet.avoidance.foreign.types import (
    NEVER_S,
    Advice,
    Boat,
    Contact,
    Edge,
    Kind,
    TargetLike,
)

TURNED_RAD = 0.35  # this near to the course a named turn is done


def begin_sailing(memory: Memory, now: float) -> Memory:
    """What was decided is sailed from its time on."""
    new = memory.ordered
    if new == memory.sailed or now + TICK_S < new.at:
        return memory
    turning = 1.0 if new.acting > 0.5 and new.sense != 0.0 else 0.0
    return structs.replace(memory, sailed=new, turning=turning)


def advise(
    boat: Boat,
    targets: Sequence[TargetLike],
    edges: Sequence[Edge],
    memory: Memory,
    params: ForeignParams,
    decided: float,
) -> tuple[Memory, Advice]:
    """What to sail this tick."""
    action, limits = memory.sailed, boat.limits
    first = earliest(memory.encounters)
    deciding = next((e for e in memory.encounters if e.number == memory.target), None)
    kind = deciding.kind if deciding is not None else float(Kind.NONE)
    cx, cy, u_d, r_d, banked = action.cx, action.cy, boat.cruise, 0.0, 0.0
    turning = memory.turning
    if action.acting > 0.5:
        u_d = speed(boat, action.factor)
        left = left_to_turn(boat.chi, cx, cy, action.sense if turning > 0.5 else 0.0)
        turning = turning if abs(left) > TURNED_RAD else 0.0
        near = within(edges, boat.x, boat.y, _bank_reach(boat, params))
        if near:
            hy, hx = ops.sincos(boat.chi)
            bent = bend(boat.x, boat.y, cx, cy, hx, hy, boat.U, limits.yaw_rate_max_radps, near, params)
            banked = bent.bent
            if banked > 0.5:
                cx, cy, u_d = bent.cx, bent.cy, u_d * bent.free
                left = left_to_turn(boat.chi, cx, cy, 0.0)
        r_d = ops.clip(params.k1 * left, -limits.yaw_rate_max_radps, limits.yaw_rate_max_radps)
    memory = structs.replace(memory, turning=turning, banked=banked)
    return memory, Advice(
        acting=action.acting,
        cx=cx,
        cy=cy,
        u_d=u_d,
        r_d=r_d,
        a=action.a,
        factor=action.factor,
        sense=action.sense,
        banked=banked,
        target=memory.target,
        kind=kind,
        role=float(role(kind)),
        reason=memory.reason,
        entry=first.entry if first is not None else NEVER_S,
        decided=decided,
        serial=memory.serial,
        contacts=_contacts(boat, targets, memory, params),
    )


def _bank_reach(boat: Boat, params: ForeignParams) -> float:
    """Farther off no bank bends a course [m]."""
    return params.bank_m + boat.U * (params.bank_s + 1.0 / boat.limits.yaw_rate_max_radps)


def _contacts(boat: Boat, targets: Sequence[TargetLike], memory: Memory, params: ForeignParams) -> tuple[Contact, ...]:
    """Every usable vessel, for people."""
    met = {e.number: e for e in memory.encounters}
    shown = []
    for target in sorted(targets, key=lambda each: each.number):
        if target.usable < 0.5:
            continue
        d, e = domain(target, boat.cruise, 0.0, params), met.get(target.number)
        away = distance(boat.x, boat.y, d)
        if e is None:
            shown.append(Contact(d.number, 0.0, 0.0, 0.0, 0.0, NEVER_S, away, d.C))
        else:
            shown.append(Contact(d.number, e.kind, float(role(e.kind)), e.side, e.acting, e.entry, away, d.C))
    return tuple(shown)
