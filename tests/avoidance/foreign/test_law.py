"""Whole encounters: the boat commits, holds, and goes back."""

from __future__ import annotations

import math

import pytest
from msgspec import structs

from fleet.avoidance.foreign import (
    NEVER_S,
    START,
    Kind,
    Mate,
    Memory,
    Order,
    Reason,
    Role,
    keep_clear,
    order_of,
    sail_order,
)
from fleet.avoidance.foreign.domain import domain
from fleet.hulls import unicycle
from fleet.paths import sine

from .scenes import LIMITS, P, Sea, boat, meeting, target

MEETINGS = [
    (180.0, 3.0, Kind.HEAD_ON),
    (-90.0, 3.0, Kind.CROSSING_GIVE_WAY),
    (90.0, 3.0, Kind.CROSSING_STAND_ON),
    (0.0, 3.0, Kind.OVERTAKEN),
    (0.0, 0.4, Kind.OVERTAKING),
    (0.0, 0.0, Kind.STATIC),
]


@pytest.mark.parametrize(("course", "U", "kind"), MEETINGS)
def test_nobody_enters_the_domain_of_a_vessel_that_holds_its_course(course: float, U: float, kind: Kind) -> None:
    sea = Sea([meeting(course, U, 90.0)]).sail(260.0)
    first, last = sea.decisions[0], sea.decisions[-1]
    assert first.kind == kind
    assert abs(first.a) >= math.radians(30.0) - 1e-9 or first.factor <= 0.5
    assert sea.nearest >= 1.0
    assert last.reason == Reason.CLEAR
    assert abs(sea.hull.y) < 1.0
    assert len(sea.decisions) <= 3  # one alteration, perhaps going on beside the path, and back
    assert U < 1.0 or Reason.BESIDE not in [one.reason for one in sea.decisions]  # a faster vessel is soon past


@pytest.mark.parametrize("course", [180.0, -90.0, -120.0])
def test_who_gives_way_turns_to_starboard_or_slows_down_in_time(course: float) -> None:
    sea = Sea([meeting(course, 3.0, 120.0)]).sail(130.0)
    first = sea.decisions[0]
    assert first.role == Role.GIVE_WAY
    assert first.a >= 0.0
    assert 33.0 < first.entry < domain(meeting(course, 3.0, 120.0), 1.0, 0.0, P).T_gw


def test_who_stands_on_keeps_course_until_the_last_moment_for_acting_alone() -> None:
    t = meeting(90.0, 3.0, 120.0)
    sea = Sea([t]).sail(130.0)
    first, d = sea.decisions[0], domain(t, 1.0, 0.0, P)
    assert first.role == Role.STAND_ON
    assert d.T_so - 2.5 < first.entry < d.T_so
    assert not (first.a < 0.0 and first.factor > 0.0)  # rule 17 c


def test_who_meets_several_does_not_stand_on_until_one_could_just_be_cleared() -> None:
    pair = [meeting(90.0, 3.0, 120.0), meeting(10.0, 3.0, 125.0, number=2.0)]
    sea = Sea(pair).sail(160.0)
    first, d = sea.decisions[0], domain(pair[0], 1.0, 0.0, P)
    assert first.reason == Reason.STAND_ON
    assert d.T_so + 10.0 < first.entry < d.T_gw
    assert sea.nearest >= 1.0


def test_a_vessel_that_passes_well_clear_changes_nothing() -> None:
    sea = Sea([target(100.0, 60.0, 180.0, 3.0)]).sail(60.0)
    assert sea.decisions == []
    assert sea.advice is not None
    assert sea.advice.contacts[0].kind == Kind.NONE


def test_two_vessels_are_cleared_by_one_decision_that_sees_both() -> None:
    sea = Sea([meeting(180.0, 3.0, 90.0), meeting(-90.0, 3.0, 90.0, number=2.0)]).sail(220.0)
    assert sea.nearest >= 1.0
    assert len(sea.decisions) <= 3


def test_along_a_curved_path_it_is_cleared_as_well() -> None:
    path = sine((0.0, 0.0), (600.0, 0.0), 10.0, 150.0)
    sea = Sea([meeting(180.0, 2.0, 90.0)], path=path).sail(220.0)
    assert sea.decisions[0].acting == 1.0
    assert sea.nearest >= 1.0
    assert sea.advice is not None
    assert sea.advice.acting == 0.0


def test_the_boat_does_not_go_ashore_to_keep_clear() -> None:
    bank = (-500.0, 12.0, 2000.0, 12.0)
    sea = Sea([meeting(180.0, 2.0, 90.0, length=8.0)], edges=(bank,))
    east = 0.0
    for _ in range(220):
        sea.sail(1.0)
        east = max(east, sea.hull.y)
    assert sea.decisions
    assert east < 12.0 - 1.0
    assert sea.nearest >= 0.9


def test_a_boat_that_goes_back_along_a_bank_turns_about_off_it() -> None:
    bank = (-500.0, 15.0, 2000.0, 15.0)
    held = structs.replace(START.sailed, acting=1.0, a=math.pi, cx=-1.0, cy=0.0)
    sea = Sea([meeting(180.0, 0.5, 120.0)], edges=(bank,))
    sea.hull = unicycle.start(0.0, 13.0, math.pi, 1.0)
    sea.memory = structs.replace(START, ordered=held, sailed=held, decided_s=0.0, target=1.0)
    east = 0.0
    for _ in range(90):
        sea.sail(1.0)
        east = max(east, sea.hull.y)
    assert east < 15.0 - 1.0


def test_the_round_turn_by_starboard_goes_by_starboard() -> None:
    sailed = structs.replace(
        START.sailed, acting=1.0, a=math.radians(240.0), cx=math.cos(4.18879), cy=math.sin(4.18879), sense=1.0
    )
    memory = structs.replace(START, sailed=sailed, ordered=sailed, turning=1.0, due_s=1e9)
    assert keep_clear((boat(),), (), (), (), memory, P, 0.0)[1].r_d == LIMITS.yaw_rate_max_radps
    memory, advice = keep_clear((boat(chi=4.1),), (), (), (), memory, P, 0.0)
    assert advice.r_d > 0.0
    assert memory.turning == 0.0
    assert keep_clear((boat(chi=4.3),), (), (), (), memory, P, 0.0)[1].r_d < 0.0


def test_between_two_looks_nothing_is_decided_and_no_memory_changes() -> None:
    t = meeting(180.0, 3.0, 20.0)
    memory, advice = keep_clear((boat(),), (t,), (), (), START, P, 10.0)
    assert (advice.acting, advice.decided) == (1.0, 1.0)
    again, advice = keep_clear((boat(),), (t,), (), (), memory, P, 10.1)
    assert (advice.acting, advice.decided) == (1.0, 0.0)
    assert again == memory


def test_the_same_numbers_give_the_same_decision() -> None:
    t = (meeting(180.0, 3.0, 20.0), meeting(-60.0, 4.0, 30.0, number=2.0))
    assert keep_clear((boat(),), t, (), (), START, P, 10.0) == keep_clear((boat(),), t[::-1], (), (), START, P, 10.0)


def test_a_mate_is_in_the_way_of_an_alteration() -> None:
    t = meeting(180.0, 3.0, 20.0)
    _, free = keep_clear((boat(),), (t,), (), (), START, P, 0.0)
    abreast = [Mate(x, y, 1.0, 0.0) for x in (-6.0, 0.0, 6.0, 12.0) for y in (7.0, 13.0)]
    _, hemmed = keep_clear((boat(),), (t,), abreast, (), START, P, 0.0)
    assert free.a > 0.0
    assert (hemmed.a, hemmed.factor) != (free.a, free.factor)


def test_all_values_of_memory_and_advice_are_plain_floats() -> None:
    memory, advice = keep_clear((boat(),), (meeting(180.0, 3.0, 20.0),), (), (), START, P, 0.0)
    flat = [*structs.astuple(memory.sailed), *structs.astuple(memory.encounters[0]), *structs.astuple(advice)[:-1]]
    assert {type(value) for value in flat} == {float}


def stopped_for(number: float) -> Sea:
    """A boat that has stopped for some vessel, 60 m before one that lies still and was acted for as well."""
    sea = Sea([target(60.0, 0.0)])
    stop = structs.replace(START.sailed, acting=1.0, factor=0.0)
    (met,) = keep_clear((boat(),), sea.targets, (), (), START, P, 0.0)[0].encounters
    acted = structs.replace(met, acting=1.0)
    sea.memory = structs.replace(START, sailed=stop, ordered=stop, decided_s=0.0, target=number, encounters=(acted,))
    return sea


def test_a_stopped_boat_does_not_wait_for_ever_before_a_vessel_that_lies_still() -> None:
    sea = stopped_for(1.0).sail(59.0)
    assert sea.decisions == []
    sea.sail(241.0)
    assert sea.decisions[0].reason == Reason.REVIEW
    assert sea.hull.x > 100.0
    assert sea.nearest >= 1.0


def test_the_action_for_a_vessel_that_is_past_is_not_held_for_another_one() -> None:
    sea = stopped_for(2.0).sail(1.0)
    assert [(one.reason, one.target) for one in sea.decisions] == [(Reason.PASSED, 1.0)]
    assert sea.decisions[0].factor > 0.0


def test_a_slow_vessel_is_overtaken_in_parallel() -> None:
    sea, east = Sea([target(90.0, 0.0, 0.0, 0.5)]), 0.0
    for _ in range(300):
        sea.sail(1.0)
        east = max(east, abs(sea.hull.y))
    assert [one.reason for one in sea.decisions] == [Reason.GIVE_WAY, Reason.BESIDE, Reason.CLEAR]
    assert 11.2 < east < 45.0
    assert sea.nearest >= 1.0


@pytest.mark.parametrize(("after_s", "reason"), [(48.0, Reason.NONE), (65.0, Reason.CLEAR)])
def test_nobody_goes_back_to_a_path_that_a_vessel_to_stand_on_for_is_about_to_cross(
    after_s: float, reason: Reason
) -> None:
    held = structs.replace(START.sailed, acting=1.0, a=math.radians(30.0), cx=math.cos(0.52), cy=math.sin(0.52))
    memory = structs.replace(START, ordered=held, sailed=held, decided_s=0.0, free_s=P.clear_s - 0.5)
    memory, advice = keep_clear((boat(),), (meeting(90.0, 3.0, after_s),), (), (), memory, P, 10.0)
    assert memory.encounters[0].kind == Kind.CROSSING_STAND_ON
    assert memory.reason == reason
    assert advice.acting == (1.0 if reason is Reason.NONE else 0.0)


def test_what_is_resumed_is_clear_by_a_quarter_more_than_what_is_given_up() -> None:
    t = target(60.0, 13.0, 180.0, 1.0)  # C is 11.2 m: 13 m aside is no risk, but not enough to go back to
    held = structs.replace(START.sailed, acting=1.0, a=math.radians(-30.0), cx=math.cos(0.52), cy=-math.sin(0.52))
    acting = structs.replace(START, ordered=held, sailed=held, decided_s=0.0)
    assert keep_clear((boat(),), (t,), (), (), START, P, 10.0)[1].entry == NEVER_S
    assert keep_clear((boat(),), (t,), (), (), acting, P, 10.0)[1].entry < 30.0


def test_beside_a_vessel_as_fast_on_nearly_its_course_a_boat_goes_on_in_parallel() -> None:
    sea = Sea([target(-10.0, -30.0, 10.0, 1.0)]).sail(240.0)
    assert Reason.BESIDE in [one.reason for one in sea.decisions]
    assert sea.nearest >= 1.0


def test_no_boat_sails_for_ever_beside_a_vessel_as_fast_on_the_course_that_it_holds() -> None:
    sea = Sea([target(0.0, -30.0, 45.0, 1.0)])
    held = structs.replace(START.sailed, acting=1.0, a=math.pi / 4.0, cx=math.sqrt(0.5), cy=math.sqrt(0.5))
    sea.hull = unicycle.start(0.0, 0.0, math.pi / 4.0, 1.0)
    sea.memory = structs.replace(START, ordered=held, sailed=held, decided_s=0.0, target=1.0)
    sea.sail(260.0)
    assert [one.reason for one in sea.decisions] == [Reason.REVIEW, Reason.CLEAR]


def test_a_boat_off_its_path_looks_beyond_the_moment_when_it_is_back() -> None:
    """60 m beside its path it is back after 69 s, and then 45 m before a lying vessel."""
    _, advice = keep_clear((boat(y=60.0),), (target(90.0, 0.0, length=5.0),), (), (), START, P, 0.0)
    assert 100.0 < advice.entry < 125.0
    assert advice.acting == 0.0


COLUMN = tuple(boat(x=10.0 * k) for k in (0, 1, 2))


def led(memory: Memory = START, now: float = 0.0) -> tuple[Memory, Order]:
    memory, _ = keep_clear(COLUMN, (meeting(180.0, 3.0, 40.0),), (), (), memory, P, now)
    return memory, order_of(memory, 3.0)


def leads() -> tuple[Memory, Order]:
    """Memory and order of a leader that has just decided."""
    memory, now = START, 0.0
    while memory.ordered.acting < 0.5:
        memory, order = led(memory, now)
        now += 0.5
    return memory, order


def test_the_boat_nearest_to_the_ship_starts_the_formation() -> None:
    t = (meeting(180.0, 3.0, 42.0),)
    alone, _ = keep_clear(COLUMN[:1], t, (), (), START, P, 0.0)
    together, _ = keep_clear(COLUMN, t, (), (), START, P, 0.0)
    assert together.encounters[0].entry < alone.encounters[0].entry - 3.0  # 20 m at 4 m/s is 5 s


def test_everybody_begins_at_the_same_moment() -> None:
    memory, order = leads()
    at = order.action.at
    assert at == pytest.approx(memory.decided_s + P.latency_s)
    for now, acting in ((at - 0.1, 0.0), (at, 1.0)):
        _, leader = keep_clear(COLUMN, (), (), (), structs.replace(memory, due_s=1e9), P, now)
        _, follower = sail_order(COLUMN[1], (), (), (), order, True, structs.replace(START, due_s=1e9), P, now)
        assert leader.acting == follower.acting == acting
        assert (leader.cx, leader.cy, leader.u_d) == (follower.cx, follower.cy, follower.u_d)


def test_a_follower_holds_the_order_until_it_is_told_to_resume() -> None:
    _, order = leads()
    far = (target(5000.0, 5000.0),)
    memory = START
    for k in range(100):
        memory, advice = sail_order(COLUMN[1], far, (), (), order, True, memory, P, 10.0 + 0.5 * k)
    assert advice.acting == 1.0
    assert advice.reason == Reason.ORDER
    resume = Order(3.0, order.serial + 1.0, structs.replace(START.sailed, at=70.0), -1.0, float(Reason.CLEAR))
    memory, advice = sail_order(COLUMN[1], far, (), (), resume, True, memory, P, 70.0)
    assert advice.acting == 0.0


def test_a_follower_without_an_order_acts_alone_four_seconds_after_it_had_to() -> None:
    t, memory = meeting(90.0, 3.0, 25.0), START
    begun = None
    for k in range(40):
        now = 0.5 * k
        here = boat(x=now)
        there = structs.replace(t, x=t.x + t.vx * now, y=t.y + t.vy * now)
        memory, advice = sail_order(here, (there,), (), (), None, True, memory, P, now)
        late = memory.waited_s
        if advice.acting > 0.5:
            begun = now
            break
    assert begun is not None
    assert late == P.order_wait_s
    assert (advice.reason, memory.alone) == (Reason.NO_ORDER, 1.0)


def test_an_order_that_comes_just_after_a_follower_began_alone_is_taken_a_later_one_is_not() -> None:
    _, order = leads()
    free = (target(5000.0, 5000.0),)
    began = structs.replace(
        START, ordered=structs.replace(order.action, a=-1.0, at=0.0), alone=1.0, reason=float(Reason.NO_ORDER),
        decided_s=10.0, due_s=1e9,
    )  # fmt: skip
    soon, advice = sail_order(COLUMN[1], free, (), (), order, True, began, P, 10.0 + P.order_wait_s)
    assert (soon.alone, advice.a, advice.reason) == (0.0, order.action.a, Reason.ORDER)
    late, advice = sail_order(COLUMN[1], free, (), (), order, True, began, P, 10.1 + P.order_wait_s)
    assert (late.alone, advice.a) == (1.0, -1.0)


def test_a_leader_of_many_boats_decides_over_some_ticks_and_says_so_once() -> None:
    t = tuple(meeting(150.0 + 20.0 * k, 3.0, 38.0, number=float(k)) for k in range(4))
    boats = tuple(boat(x=10.0 * k) for k in range(8))
    memory, decided, pending = START, [], []
    for k in range(60):
        memory, advice = keep_clear(boats, t, (), (), memory, P, 0.1 * k)
        pending.append(memory.search is not None)
        if advice.decided > 0.5:
            decided.append(k)
    assert len(decided) == 1
    first = pending.index(True)
    assert 2 <= decided[0] - first <= 20
    assert all(pending[first : decided[0]])
    assert not any(pending[decided[0] :])


def test_a_boat_that_is_cut_off_decides_for_itself_and_joins_again_after_resuming() -> None:
    t = meeting(180.0, 3.0, 20.0)
    _, order = leads()
    memory, advice = sail_order(COLUMN[1], (t,), (), (), order, False, START, P, 0.0)
    assert advice.reason == Reason.GIVE_WAY
    memory, advice = sail_order(COLUMN[1], (t,), (), (), order, True, memory, P, 0.1)
    assert (memory.alone, advice.reason) == (1.0, Reason.GIVE_WAY)  # holds its own action
    free = (target(5000.0, 5000.0),)
    for k in range(16):
        memory, advice = sail_order(COLUMN[1], free, (), (), order, True, memory, P, 1.0 + 0.5 * k)
    assert memory.alone == 0.0
