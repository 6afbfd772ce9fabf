"""The law for one tick: look at every vessel twice a second, commit to one alteration, hold it until all is clear."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import structs

from fleet.avoidance.foreign.advise import advise, begin_sailing
from fleet.avoidance.foreign.commit import TICK_S, act, decide, latch, search_on
from fleet.avoidance.foreign.memory import Memory
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.types import (
    FOLLOW_PATH,
    NEVER_S,
    Action,
    Advice,
    Boat,
    Edge,
    Mate,
    Order,
    Reason,
    TargetLike,
)
from fleet.avoidance.foreign.watch import look_on

START = Memory(
    encounters=(),
    sailed=FOLLOW_PATH,
    ordered=FOLLOW_PATH,
    turning=0.0,
    decided_s=-NEVER_S,
    due_s=-NEVER_S,
    bad_s=0.0,
    free_s=0.0,
    beside_s=0.0,
    banked=0.0,
    serial=0.0,
    target=-1.0,
    reason=0.0,
    waited_s=0.0,
    alone=0.0,
    search=None,
    glance=None,
)
"""Memory of a boat that has met nobody."""


def keep_clear(
    boats: Sequence[Boat],
    targets: Sequence[TargetLike],
    mates: Sequence[Mate],
    edges: Sequence[Edge],
    memory: Memory,
    params: ForeignParams,
    now: float,
) -> tuple[Memory, Advice]:
    """Keep clear of foreign vessels: for one boat, or by a leader for its whole formation.

    To be called every tick. It looks around every 0.5 s and works out a decision in the tick in which it is due. A
    look at many boats, and a large decision (many boats, vessels or banks), goes on over a few ticks.

    Args:
        boats: the own boat first, then the mates that sail the same decision (leader of a formation), else it alone
        targets: foreign vessels, dead-reckoned to now, each number once
        mates: boats of the fleet that decide for themselves
        edges: of banks and no-go polygons
        memory: of the tick before, `START` at first
        now: any clock that does not jump [s]

    Returns:
        Memory for the next tick, and what to do.
    """
    before, memory = memory.serial, begin_sailing(memory, now)
    if memory.search is not None:
        memory = search_on(memory, params, now)
    elif memory.glance is not None or now + TICK_S >= memory.due_s:
        picture, memory = look_on(boats, targets, edges, memory, params, now)
        if picture is not None:
            memory = decide(boats, mates, picture, memory, params, now)
    decided = 1.0 if memory.serial != before else 0.0
    memory = begin_sailing(memory, now)
    return advise(boats[0], targets, edges, memory, params, decided)


def sail_order(
    boat: Boat,
    targets: Sequence[TargetLike],
    mates: Sequence[Mate],
    edges: Sequence[Edge],
    order: Order | None,
    in_formation: bool,
    memory: Memory,
    params: ForeignParams,
    now: float,
) -> tuple[Memory, Advice]:
    """Keep clear as a follower: sail the leader's order, and decide alone only where there is none in time.

    Args:
        order: the newest heard from the leader, None if none was ever heard
        in_formation: the leader is heard and the boat is within 10 m of its slot; without that it decides alone
    """
    if in_formation and _comes_late(order, memory, params, now):
        memory = structs.replace(memory, alone=0.0, waited_s=0.0)
    own_way = not in_formation or memory.alone > 0.5
    if own_way:
        memory = structs.replace(memory, alone=1.0)
        memory, advice = keep_clear((boat,), targets, mates, edges, memory, params, now)
        if in_formation and memory.ordered.acting < 0.5:
            memory = structs.replace(memory, alone=0.0, waited_s=0.0)
        return memory, advice
    decided = 0.0
    if order is not None and _is_new(order.action, memory.ordered):
        decided = 1.0
        memory = structs.replace(
            memory, ordered=order.action, decided_s=now, serial=memory.serial + 1.0,
            target=order.target, reason=float(Reason.ORDER),
        )  # fmt: skip
    memory = begin_sailing(memory, now)
    if now + TICK_S >= memory.due_s:
        picture, memory = look_on((boat,), targets, edges, memory, params, now, decides=False)
        assert picture is not None  # one boat is looked at in one tick
        sail_on = memory.ordered.acting > 0.5
        late = any(e.entry < d.T_so for e in picture.encounters for d in picture.domains if d.number == e.number)
        waited = memory.waited_s + params.period_s if late and not sail_on else 0.0
        memory = structs.replace(memory, waited_s=waited)
        if waited >= params.order_wait_s:
            near = min(picture.encounters, key=lambda e: e.entry)
            memory = latch(structs.replace(memory, alone=1.0), (near,))
            memory = act((boat,), mates, picture, memory, near.number, Reason.NO_ORDER, params, now)
            decided = 1.0 if memory.search is None else 0.0
            memory = begin_sailing(memory, now)
    return advise(boat, targets, edges, memory, params, decided)


def _comes_late(order: Order | None, memory: Memory, params: ForeignParams, now: float) -> bool:
    """The order that a boat waited for is there soon after it decided alone: it was worked out for this boat, too."""
    acts = order is not None and order.action.acting > 0.5
    return acts and memory.reason == Reason.NO_ORDER and now - memory.decided_s <= params.order_wait_s


def _is_new(told: Action, known: Action) -> bool:
    """Another action than the known one; following the path is always the same."""
    return told != known and (told.acting > 0.5 or known.acting > 0.5)


def order_of(memory: Memory, who: float) -> Order:
    """What the leader tells its formation, every time it speaks."""
    return Order(who=who, serial=memory.serial, action=memory.ordered, target=memory.target, reason=memory.reason)
