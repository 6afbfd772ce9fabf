"""Begin to act, hold the alteration, change it when it fails, resume when the path is clear."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.foreign.decision import MOST_AT_ONCE, Scene, begin, chosen, go_on, round_off
from fleet.avoidance.foreign.domain import Domain
from fleet.avoidance.foreign.encounter import Bearing, due, earliest, reason, role, watched
from fleet.avoidance.foreign.memory import Memory
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.types import (
    FOLLOW_PATH,
    NEVER_S,
    Action,
    Afloat,
    Boat,
    Encounter,
    Mate,
    Reason,
    Role,
)
from fleet.avoidance.foreign.watch import Picture, beside_path, foreseen

TICK_S = 1.0e-9
HELD_LONG = 2.5  # reviews after which a held action is at a disadvantage: it leads nowhere, as beside a vessel as fast
SOON_PAST = 1.5  # times the boat's speed


def decide(
    boats: Sequence[Boat],
    mates: Sequence[Mate],
    picture: Picture,
    memory: Memory,
    params: ForeignParams,
    now: float,
) -> Memory:
    """Begin to act, hold, change the action, or resume."""
    new = [e for e in picture.encounters if due(e, params) and e.acting < 0.5]
    memory = latch(memory, new)
    if memory.ordered.acting < 0.5:
        first = earliest([e for e in memory.encounters if due(e, params)])
        if first is None:
            return memory
        return act(boats, mates, picture, memory, first.number, reason(first), params, now)
    numbers = watched(memory.encounters)
    far = {d.number: d.T_gw for d in picture.domains}
    free = all(e.entry >= (NEVER_S if e.number in numbers else far[e.number]) for e in memory.encounters)
    memory = structs.replace(memory, free_s=memory.free_s + params.period_s if free else 0.0)
    if memory.free_s >= params.clear_s:
        return _resume(boats, memory, params, now)
    memory = _alongside(picture, memory, params)
    if memory.beside_s >= params.beside_s:
        return _go_on_beside(boats, picture, memory, params, now)
    first = earliest([e for e in memory.encounters if e.number in numbers])
    if first is not None and memory.target >= 0.0 and all(e.number != memory.target for e in memory.encounters):
        return act(boats, mates, picture, memory, first.number, Reason.PASSED, params, now)
    if first is not None and now - memory.decided_s >= params.review_s:
        return act(boats, mates, picture, memory, first.number, Reason.REVIEW, params, now)
    failure = _fails(picture, memory, new, now)
    if failure is None:
        return structs.replace(memory, bad_s=0.0)
    if failure.number >= 0.0:
        memory = structs.replace(memory, bad_s=memory.bad_s + params.period_s)
    least = params.held_urgent_s if failure.entry < params.urgent_s else params.held_least_s
    ready = now - memory.decided_s + TICK_S >= least
    sure = memory.bad_s >= params.held_bad_s or failure.cause is Reason.BANK
    if failure.cause is Reason.NEW_TARGET or (ready and sure):
        return act(boats, mates, picture, memory, failure.number, failure.cause, params, now)
    return memory


class Failure(Struct, frozen=True, gc=False):
    """The held action does not keep clear of a vessel, or of a bank."""

    number: float  # of the vessel, -1 a bank
    entry: float  # time until it is too near [s]
    cause: Reason


def _fails(picture: Picture, memory: Memory, new: Sequence[Encounter], now: float) -> Failure | None:
    """What the held action fails on: nearer than 0.92 C, growth halved, within T_gw (T_so where we stand on)."""
    if now + TICK_S < memory.ordered.at:
        return None
    fresh = {e.number for e in new}
    passive = {e.number for e in picture.encounters if e.acting < 0.5 and role(e.kind) == Role.STAND_ON}
    held = dict(picture.held)
    worst: Failure | None = None
    for d in picture.domains:
        t = held.get(d.number, NEVER_S)
        if d.number in passive and t >= d.T_so:
            continue
        if t < NEVER_S and (worst is None or t < worst.entry):
            worst = Failure(d.number, t, Reason.NEW_TARGET if d.number in fresh else Reason.HELD_FAILS)
    if worst is None and memory.banked > 0.5 and memory.reason != Reason.BANK:
        return Failure(-1.0, NEVER_S, Reason.BANK)
    return worst


def _alongside(picture: Picture, memory: Memory, params: ForeignParams) -> Memory:
    """Count how long the course of the path has been clear beside the path, while the path itself is not.

    Not for vessels that go by at 1.5 times the boat's speed: until they are past the room to the side is worth having.
    """
    own = picture.own
    fast = {d.number for d in picture.domains if _passing(own, d) >= SOON_PAST * own.cruise}
    soon_past = any(e.acting > 0.5 and e.entry < NEVER_S and e.number in fast for e in memory.encounters)
    counts = memory.ordered.a != 0.0 and memory.ordered.at <= memory.due_s and picture.beside and not soon_past
    return structs.replace(memory, beside_s=memory.beside_s + params.period_s if counts else 0.0)


def _passing(own: Bearing, d: Domain) -> float:
    """Speed of a vessel relative to the boat on its path [m/s]."""
    g = d.guesses[0]
    return ops.hypot(own.cruise * own.ex - g.vx, own.cruise * own.ey - g.vy)


def _go_on_beside(boats: Sequence[Boat], picture: Picture, memory: Memory, params: ForeignParams, now: float) -> Memory:
    """Far enough to the side: pass on the course of the path instead of leaving it ever farther."""
    action = round_off(beside_path(picture.own), boats[0], picture.edges, params)
    return _ordered(boats, action, memory, memory.target, Reason.BESIDE, params, now)


def latch(memory: Memory, new: Sequence[Encounter]) -> Memory:
    """We act for these now."""
    if not new:
        return memory
    numbers = {e.number for e in new}
    encounters = tuple(structs.replace(e, acting=1.0) if e.number in numbers else e for e in memory.encounters)
    return structs.replace(memory, encounters=encounters)


def act(
    boats: Sequence[Boat],
    mates: Sequence[Mate],
    picture: Picture,
    memory: Memory,
    target: float,
    cause: Reason,
    params: ForeignParams,
    now: float,
) -> Memory:
    """Begin to decide; a leader of many boats, whose look took long enough, goes on in the next tick."""
    afloat = tuple(Afloat(*(getattr(boat, name) for name in Afloat.__struct_fields__)) for boat in boats)
    ahead = foreseen(boats[0], picture, params)
    scene = Scene(
        afloat, picture.own, picture.domains, memory.encounters, tuple(mates), picture.edges, memory.ordered, ahead
    )
    if now - memory.ordered.at >= HELD_LONG * params.review_s:
        params = structs.replace(params, review_gain=-params.review_gain)
    memory = structs.replace(memory, search=begin(scene, target, cause, params))
    return memory if len(boats) > MOST_AT_ONCE else search_on(memory, params, now)


def search_on(memory: Memory, params: ForeignParams, now: float) -> Memory:
    """Go on deciding; the same alteration as before only starts the waiting anew."""
    search = memory.search
    if search is None:
        return memory
    search = go_on(search, params)
    found = chosen(search)
    if found is None:
        return structs.replace(memory, search=search)
    memory, held = structs.replace(memory, search=None), memory.ordered
    boats, target, cause = search.scene.boats, search.target, search.cause
    if held.acting > 0.5 and found.a == held.a and found.factor == held.factor:
        return structs.replace(memory, decided_s=now, bad_s=0.0, free_s=0.0, beside_s=0.0, target=target)
    return _ordered(boats, found, memory, target, cause, params, now)


def _resume(boats: Sequence[Boat], memory: Memory, params: ForeignParams, now: float) -> Memory:
    """Back to the path, and to cruise speed."""
    memory = structs.replace(memory, encounters=tuple(structs.replace(e, count=0.0) for e in memory.encounters))
    return _ordered(boats, FOLLOW_PATH, memory, -1.0, Reason.CLEAR, params, now)


def _ordered(
    boats: Sequence[Afloat],
    action: Action,
    memory: Memory,
    target: float,
    cause: Reason,
    params: ForeignParams,
    now: float,
) -> Memory:
    """A new decision; a formation sails it a moment later, when all have heard of it."""
    latency = params.latency_s if len(boats) > 1 else 0.0
    return structs.replace(
        memory,
        ordered=structs.replace(action, at=now + latency),
        decided_s=now,
        bad_s=0.0,
        free_s=0.0,
        beside_s=0.0,
        serial=memory.serial + 1.0,
        target=target,
        reason=float(cause),
    )
