"""Velocity scoring, by hand: what one boat decides in scenes that can be worked out."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.avoidance import METHODS
from fleet.avoidance import brake as brakes
from fleet.avoidance.brake import brake
from fleet.avoidance.cost import Beside, legs, returned, sweep_price, swept, threat
from fleet.avoidance.pair import Judged, Pair, bound_alike, fresh_pair, judge, view
from fleet.avoidance.params import ScoringParams, beside, for_radius
from fleet.avoidance.scoring import ScoringMemory, align, keep_clear, start_memory
from fleet.avoidance.search import candidates, speed_of
from fleet.avoidance.types import Advice, Own, Peer
from fleet.guidance.limits import Limits
from tests.avoidance.scenes import own_at, peer_at

LIMITS = Limits()
PARAMS = ScoringParams()


def decide(own: Own[float], *peers: Peer[float]) -> tuple[ScoringMemory[float], Advice[float]]:
    return keep_clear(own, peers, start_memory(0.0, len(peers)), LIMITS, PARAMS, 0.1)


def judged(own: Own[float], peer: Peer[float], pair: Pair[float] | None = None) -> Judged[float]:
    seen = view(own, peer, PARAMS)
    speed = math.hypot(own.vx, own.vy)
    return judge(own, math.cos(own.chi), math.sin(own.chi), speed, peer, seen, pair or fresh_pair(0.0), PARAMS)


def test_alone_a_boat_sails_its_plan() -> None:
    _, advice = decide(own_at(u_d=1.2))
    assert (advice.avoiding, advice.steers, advice.u_d, advice.target) == (0.0, 0.0, 1.2, -1.0)


def test_a_meeting_head_on_turns_to_starboard() -> None:
    memory, advice = decide(own_at(), peer_at(4.0, 60.0, 0.0, math.pi))
    assert (advice.avoiding, advice.steers, advice.target, advice.side) == (1.0, 1.0, 4.0, 1.0)
    assert advice.r_d > 0.0
    assert memory.pairs[0].side == 1.0
    assert memory.pairs[0].stand_on == 0.0


def test_a_meeting_head_on_misses_by_the_wanted_radius() -> None:
    # 60 m apart at 2 m/s: after 30 s abeam; a course off by a misses by about 30 sin(a); 7.5 m need 15 deg (7.8 m)
    memory, _ = decide(own_at(), peer_at(4.0, 60.0, 0.0, math.pi))
    assert math.degrees(math.atan2(memory.cy, memory.cx)) == pytest.approx(15.0)


def test_a_boat_passing_8_metres_off_on_the_right_side_changes_nothing() -> None:
    _, advice = decide(own_at(), peer_at(4.0, 60.0, -8.0, math.pi))
    assert advice.avoiding == 0.0


def test_the_stand_on_boat_keeps_92_percent_of_the_radius() -> None:
    from_port = judged(own_at(), peer_at(1.0, 40.0, -40.0, math.pi / 2))
    from_starboard = judged(own_at(), peer_at(1.0, 40.0, 40.0, -math.pi / 2))
    assert (from_port.pair.stand_on, from_port.radius) == (1.0, pytest.approx(0.92 * 7.5))
    assert (from_starboard.pair.stand_on, from_starboard.radius) == (0.0, 7.5)


def test_the_overtaking_boat_gives_way_and_the_overtaken_stands_on() -> None:
    behind = judged(own_at(u=1.5), peer_at(1.0, 20.0, 1.0, 0.0, 0.7, u_d=0.7))
    ahead = judged(own_at(u=0.7, u_d=0.7), peer_at(1.0, -20.0, -1.0, 0.0, 1.5))
    assert (behind.pair.conflict, behind.pair.stand_on) == (1.0, 0.0)
    assert (ahead.pair.conflict, ahead.pair.stand_on) == (1.0, 1.0)


def test_an_unknown_vehicle_never_makes_us_stand_on() -> None:
    assert judged(own_at(), peer_at(1.0, 40.0, -40.0, math.pi / 2, known=0.0)).pair.stand_on == 0.0


def test_both_boats_leave_each_other_to_port_even_where_the_miss_says_otherwise() -> None:
    # it would pass 5 m to starboard, in 30 s: the common sense of turning goes the other way round
    assert judged(own_at(), peer_at(1.0, 60.0, 5.0, math.pi)).pair.side == 1.0


def test_late_or_unknown_a_vehicle_well_to_starboard_is_left_there() -> None:
    assert judged(own_at(), peer_at(1.0, 20.0, 5.0, math.pi)).pair.side == -1.0
    assert judged(own_at(), peer_at(1.0, 60.0, 5.0, math.pi, known=0.0)).pair.side == -1.0
    assert judged(own_at(), peer_at(1.0, 20.0, 3.0, math.pi)).pair.side == 1.0  # less than R_s / 2


def test_the_side_is_kept_until_past_and_clear() -> None:
    pair = Pair(1.0, 0.0, 1.0, 0.0, 0.0)
    assert judged(own_at(), peer_at(1.0, 20.0, 9.0, math.pi), pair).pair.side == 1.0
    assert judged(own_at(), peer_at(1.0, -3.0, 5.0, math.pi), pair).pair.side == 1.0
    assert judged(own_at(), peer_at(1.0, -6.0, 5.0, math.pi), pair).pair.side == 0.0


def test_the_horizon_of_a_pair_ends_where_a_path_bends() -> None:
    own, peer = own_at(), peer_at(1.0, 200.0, 0.0, math.pi)
    assert view(own, peer, PARAMS).horizon == 150.0
    assert view(own, msgspec.structs.replace(peer, straight=70.0), PARAMS).horizon == 70.0
    assert view(own, msgspec.structs.replace(peer, straight=3.0), PARAMS).horizon == 30.0
    assert view(own, msgspec.structs.replace(peer, known=0.0), PARAMS).horizon == 60.0


def test_companions_have_no_side_and_a_smaller_radius() -> None:
    beside = judged(own_at(), peer_at(1.0, 0.0, 7.0, 0.0, 0.9))
    assert (beside.pair.companion, beside.pair.side, beside.radius, beside.horizon) == (1.0, 0.0, 6.5, 30.0)
    assert judged(own_at(), peer_at(1.0, 0.0, 7.0, 0.0, 0.8)).pair.companion == 0.0  # 20 % slower
    kept = Pair(0.0, 0.0, 0.0, 1.0, 0.0)
    assert judged(own_at(), peer_at(1.0, 0.0, 38.0, 0.0, 0.75), kept).pair.companion == 1.0
    assert judged(own_at(), peer_at(1.0, 0.0, 40.0, 0.0, 1.0), kept).pair.companion == 0.0


def test_margin_and_widening_grow_the_radius() -> None:
    own, peer = own_at(sigma=1.5), peer_at(1.0, 60.0, 0.0, math.pi, sigma=1.5, widen=1.0)
    seen = view(own, peer, PARAMS)
    assert seen.wanted == pytest.approx(7.5 + 2.5 * math.sqrt(2.0) * 1.5 + 1.0)
    assert seen.margin == pytest.approx(2.0 * math.sqrt(2.0) * 1.5)  # of companions, whose slots are laid for it


def test_the_escort_timer_runs_up_beside_and_down_four_times_as_fast() -> None:
    # both want 0.4 rad towards each other and sail north, 8 m apart
    own = own_at(gamma=0.4, y_e=-3.0)
    beside = peer_at(1.0, 0.0, 8.0, 0.0, gamma=-0.4)
    assert judged(own, beside).pair.escort == 0.5
    astern = peer_at(1.0, -8.0, 0.0, 0.0, gamma=-0.4)
    assert judged(own, astern, Pair(0.0, 0.0, 0.0, 1.0, 10.0)).pair.escort == 8.0


def test_of_two_escorting_boats_the_one_with_the_other_to_starboard_yields() -> None:
    long = Pair(0.0, 0.0, 0.0, 1.0, 20.0)
    port_boat = judged(own_at(gamma=0.4, y_e=-3.0), peer_at(1.0, 0.0, 8.0, 0.0, gamma=-0.4), long)
    starboard_boat = judged(own_at(gamma=-0.4, y_e=3.0), peer_at(1.0, 0.0, -8.0, 0.0, gamma=0.4), long)
    assert (port_boat.yield_companion, starboard_boat.yield_companion) == (1.0, 0.0)
    assert port_boat.yield_other == 0.0


def test_the_escort_timer_starts_anew_once_the_boat_yields_to_another_vehicle() -> None:
    long = Pair(0.0, 0.0, 0.0, 0.0, 45.0)
    own, peer = own_at(gamma=0.4, y_e=-3.0), peer_at(1.0, 0.0, 8.0, 0.0, gamma=-0.4, u_d=0.6)
    yields = judged(own, peer, long)
    assert (yields.yield_other, yields.yield_companion, yields.pair.escort) == (1.0, 0.0, 0.0)
    kept = judged(own, peer, Pair(0.0, 0.0, 0.0, 0.0, 30.0))
    assert (kept.yield_other, kept.pair.escort) == (0.0, 30.5)


def test_yielding_to_a_companion_is_a_quarter_of_the_speed() -> None:
    memory = start_memory(0.0, 1)
    memory = msgspec.structs.replace(memory, pairs=(Pair(0.0, 0.0, 0.0, 1.0, 20.0),))
    own, peer = own_at(gamma=0.4, y_e=-3.0), peer_at(1.0, 0.0, 8.0, 0.0, gamma=-0.4)
    memory, advice = keep_clear(own, [peer], memory, LIMITS, PARAMS, 0.1)
    assert memory.yield_companion == 10.0
    assert (advice.avoiding, advice.u_d, advice.target) == (1.0, 0.25, 1.0)


def test_a_boat_does_not_yield_into_the_way_of_one_close_astern() -> None:
    memory = start_memory(0.0, 2)
    memory = msgspec.structs.replace(memory, pairs=(Pair(0.0, 0.0, 0.0, 1.0, 20.0), fresh_pair(0.0)))
    own, companion = own_at(gamma=0.4, y_e=-3.0), peer_at(1.0, 0.0, 8.0, 0.0, gamma=-0.4)
    astern = peer_at(2.0, -8.0, 0.0, 0.0)  # as fast as we are, and no faster: it meets us only if we slow down
    memory, advice = keep_clear(own, [companion, astern], memory, LIMITS, PARAMS, 0.1)
    assert memory.yield_companion == 10.0
    assert advice.u_d == 1.0


def test_who_passes_another_at_a_third_of_a_metre_a_second_does_not_escort_it() -> None:
    own, slower = own_at(gamma=0.4, y_e=-3.0), peer_at(1.0, 0.0, 8.0, 0.0, 0.7, gamma=-0.4)
    assert judged(own, slower, Pair(0.0, 0.0, 0.0, 1.0, 10.0)).pair.escort == 8.0


def test_yielding_to_another_leaves_only_half_speed_and_less() -> None:
    memory = msgspec.structs.replace(start_memory(0.0, 0), yield_other=5.0)
    _, advice = keep_clear(own_at(), [], memory, LIMITS, PARAMS, 0.1)
    assert (advice.avoiding, advice.steers, advice.u_d) == (1.0, 0.0, 0.5)


def goes_on(peer: Peer[float], avoiding: float) -> float:
    """1 where a boat that sails 15 deg to starboard of its plan is still off it after the next decision."""
    course = math.radians(15.0)
    memory = msgspec.structs.replace(
        start_memory(0.0, 1), cx=math.cos(course), cy=math.sin(course), steers=avoiding, avoiding=avoiding
    )
    return keep_clear(own_at(), [peer], memory, LIMITS, PARAMS, 0.1)[1].avoiding


def test_an_avoidance_does_not_end_only_because_the_other_is_off_its_plan() -> None:
    # bound for us on our very line, it bears away 20 deg to starboard for now: 120 m ahead that is 20 m clear of us
    away = math.pi + math.radians(20.0)
    bears_away = peer_at(4.0, 120.0, 0.0, away, gamma=math.pi, chi_p=math.pi)
    assert goes_on(bears_away, avoiding=1.0) == 1.0
    assert goes_on(bears_away, avoiding=0.0) == 0.0  # nor does that begin one
    assert goes_on(msgspec.structs.replace(bears_away, known=0.0), avoiding=1.0) == 0.0  # nothing is known of its plan
    assert goes_on(peer_at(4.0, 120.0, 0.0, away, chi_p=away), avoiding=1.0) == 0.0  # it means to go there


def test_it_ends_where_the_path_of_the_other_leads_clear() -> None:
    # southbound: 12 m to port of its path is 12 m east of it, so the path passes 12 m to the west of us
    aside = peer_at(4.0, 120.0, 0.0, math.pi + 0.35, gamma=math.pi, chi_p=math.pi, y_e=-12.0)
    assert goes_on(aside, avoiding=1.0) == 0.0


def test_a_returned_vehicle_is_on_its_path_at_the_speed_of_its_plan() -> None:
    own, peer = own_at(), peer_at(4.0, 50.0, 10.0, math.pi + 0.5, 0.3, chi_p=math.pi, u_d=1.2, y_e=4.0)
    seen = view(own, peer, PARAMS)
    back = returned(threat(own, peer, seen, judged(own, peer), PARAMS), peer, 0.0, PARAMS)
    assert (back.dx, back.dy, back.vx, back.vy) == pytest.approx((50.0, 14.0, -1.2, 0.0))
    assert back.soft > 0.0
    assert returned(threat(own, peer, seen, judged(own, peer), PARAMS), peer, 1.0, PARAMS).soft == 0.0


def test_boats_near_and_bound_within_15_degrees_are_bound_alike_at_any_speed() -> None:
    own = own_at()
    near = {deg: peer_at(1.0, 10.0, 20.0, 0.0, 0.2, chi_p=math.radians(deg)) for deg in (14.0, 16.0)}
    assert [bound_alike(own, p, view(own, p, PARAMS), PARAMS) for p in near.values()] == [1.0, 0.0]
    for other in (peer_at(1.0, 31.0, 0.0, 0.0), peer_at(1.0, 10.0, 20.0, 0.0, known=0.0)):
        assert bound_alike(own, other, view(own, other, PARAMS), PARAMS) == 0.0


def test_beside_a_boat_bound_alike_a_turn_is_dearer_and_slowing_down_cheaper() -> None:
    apart, together = ({(c.a, c.factor): c.price for c in candidates(params)} for params in (PARAMS, beside(PARAMS)))
    assert together[(math.pi, 1.0)] == pytest.approx(4.0)  # 4 / pi^2 of pi^2
    assert apart[(math.pi, 1.0)] == pytest.approx(0.24 * math.pi**2)
    assert (apart[(0.0, 0.5)], together[(0.0, 0.5)]) == pytest.approx((0.675, 0.45))


def test_the_way_back_takes_the_offset_over_the_speed_across() -> None:
    way = legs(own_at(gamma=-0.5, y_e=4.0), 2.0)
    assert way.t1 == pytest.approx(4.0 / (2.0 * math.sin(0.5)))


def test_there_are_205_candidates_and_the_plan_comes_first() -> None:
    table = candidates(PARAMS)
    assert len(table) == 205
    assert (table[0].price, table[0].a, table[0].factor) == (0.0, 0.0, 1.0)
    assert min(c.a for c in table) == pytest.approx(-math.radians(120.0))
    assert max(c.a for c in table) == pytest.approx(math.pi)
    half = next(c for c in table if c.factor == 1.0 and c.a == pytest.approx(-math.pi / 2))
    assert half.price == pytest.approx(0.24 * (math.pi / 2) ** 2 + 0.15 * math.pi / 2)


def test_candidate_speeds_respect_the_floor_and_the_slowest_speed() -> None:
    assert speed_of(1.2, 0.5, 0.0, PARAMS) == pytest.approx(0.6)
    assert speed_of(0.1, 0.5, 0.0, PARAMS) == pytest.approx(0.15)
    assert speed_of(1.0, 0.25, 0.4, PARAMS) == 0.4


def test_between_decisions_the_course_is_held_and_the_fifth_tick_decides() -> None:
    memory, peers = start_memory(0.0, 1), [peer_at(4.0, 60.0, 0.0, math.pi)]
    memory, first = keep_clear(own_at(), peers, memory, LIMITS, PARAMS, 0.1)
    gone = [peer_at(4.0, 500.0, 500.0, 0.0)]
    for _ in range(4):
        memory, advice = keep_clear(own_at(), gone, memory, LIMITS, PARAMS, 0.1)
        assert (advice.avoiding, advice.r_d) == (1.0, first.r_d)
    memory, advice = keep_clear(own_at(), gone, memory, LIMITS, PARAMS, 0.1)
    assert advice.avoiding == 0.0


@pytest.mark.parametrize("dt", [0.02, 0.05, 0.1, 0.11, 0.13, 0.4, 0.9])
def test_decisions_come_every_half_second_whatever_the_tick(dt: float) -> None:
    memory, decisions, ticks = start_memory(0.0, 0), 0, int(200.0 / dt)
    for _ in range(ticks):
        before = memory.countdown
        memory, _ = keep_clear(own_at(), [], memory, LIMITS, PARAMS, dt)
        decisions += memory.countdown > before - dt
    assert decisions == pytest.approx(min(400, ticks), abs=2)


def test_the_turn_is_proportional_and_limited() -> None:
    memory = msgspec.structs.replace(start_memory(0.0, 0), cx=0.0, cy=1.0, steers=1.0, avoiding=1.0, countdown=0.5)
    _, far = keep_clear(own_at(chi=0.0), [], memory, LIMITS, PARAMS, 0.1)
    _, near = keep_clear(own_at(chi=math.pi / 2 - 0.1), [], memory, LIMITS, PARAMS, 0.1)
    assert far.r_d == LIMITS.yaw_rate_max_radps
    assert near.r_d == pytest.approx(0.08)


def test_a_wreck_close_ahead_brakes_and_one_close_astern_does_not() -> None:
    # stopping segment 2 x 1 + 0.2 = 2.2 m; 5 m ahead leaves 2.8 < 3.2 m
    _, ahead = decide(own_at(), peer_at(7.0, 5.0, 0.0, 0.0, 0.0, known=0.0))
    _, astern = decide(own_at(), peer_at(7.0, -3.0, 0.0, 0.0, 0.0, known=0.0))
    _, clear = decide(own_at(), peer_at(7.0, 5.5, 0.0, 0.0, 0.0, known=0.0))
    assert (ahead.braking, ahead.u_d, ahead.avoiding) == (1.0, 0.0, 1.0)
    assert (astern.braking, clear.braking) == (0.0, 0.0)


def test_the_brake_works_between_decisions_and_names_its_vehicle() -> None:
    memory = msgspec.structs.replace(start_memory(0.0, 1), countdown=0.5)
    memory, advice = keep_clear(own_at(), [peer_at(7.0, 5.0, 0.0, 0.0, 0.0)], memory, LIMITS, PARAMS, 0.1)
    assert (advice.braking, advice.target, memory.avoiding) == (1.0, 7.0, 0.0)


def test_boats_that_turn_towards_each_other_brake_before_their_courses_meet() -> None:
    """Opposite courses 4 m apart, 6 m to go: straight on they pass 4 m off, in their turns 1.9 m (D_sh is 3.2 m)."""
    own, peer = own_at(), peer_at(7.0, 6.0, 4.0, math.pi)
    straight = brake(own, [peer], LIMITS, PARAMS)
    to_starboard = msgspec.structs.replace(own, r=0.35), msgspec.structs.replace(peer, r=0.35)
    away = msgspec.structs.replace(own, r=-0.35), msgspec.structs.replace(peer, r=-0.35)
    assert straight.braking == 0.0
    assert brake(to_starboard[0], [to_starboard[1]], LIMITS, PARAMS).braking == 1.0
    assert brake(away[0], [away[1]], LIMITS, PARAMS).braking == 0.0


@given(st.lists(st.tuples(*[st.floats(-3.0, 3.0)] * 8, st.floats(2.0, 8.0)), min_size=1, max_size=20))
def test_a_second_look_that_the_brake_leaves_out_would_have_found_nothing(pairs: list[tuple[float, ...]]) -> None:
    dx, dy, ax, ay, turn, bx, by, its_turn, keep = np.array(pairs).T
    found = brakes._comes_too_near(keep, 2.0 * dx, 2.0 * dy, (ax, ay, turn), (bx, by, its_turn), 0.02, 7)
    for k in range(len(pairs)):
        x, y, ax, ay, turn, bx, by, its_turn, keep = pairs[k]
        looks = ((ax, ay, bx, by), (*brakes._turned(ax, ay, turn), *brakes._turned(bx, by, its_turn)))
        both = [brakes._segments(2.0 * x, 2.0 * y, *ends, 7) for ends in looks]
        assert found[k] == any(advance < keep and advance < stay - 0.02 for stay, advance in both)


def test_radii_scale_with_the_safety_radius() -> None:
    assert for_radius(6.0) == PARAMS
    assert for_radius(12.0).wanted_m == 15.0


def test_pairs_follow_their_vehicle_by_number() -> None:
    memory = msgspec.structs.replace(
        start_memory(0.0, 2), pairs=(Pair(1.0, 0.0, 1.0, 0.0, 0.0), Pair(-1.0, 0.0, 1.0, 0.0, 0.0))
    )
    moved = align(memory, [2.0, 5.0], [1.0, 5.0])
    assert moved.pairs == (fresh_pair(0.0), memory.pairs[1])


@pytest.mark.parametrize("name", sorted(METHODS))
def test_the_memory_of_every_method_goes_through_msgpack(name: str) -> None:
    method = METHODS[name]
    own, peers = own_at(), [peer_at(4.0, 9.0, 0.5, math.pi)]
    memory, _ = method.keep_clear(own, peers, method.start(0.0, 1), LIMITS, method.params(6.0, "closest"), 0.1)
    again = msgspec.msgpack.decode(msgspec.msgpack.encode(memory), type=method.memory)
    assert again == memory
    assert method.align(memory, [4.0], [4.0]) == memory
    assert isinstance(again, ScoringMemory) == (name == "scoring")


def test_who_turns_back_together_with_the_boat_astern_is_not_on_its_way_into_it() -> None:
    """10 m apart, both still sail north, both are told to turn round: the plan alone would meet the other at 2 m/s."""
    back = own_at(gamma=math.pi, chi_p=math.pi)
    mate = peer_at(2.0, -10.0, 0.0, 0.0, gamma=math.pi, chi_p=math.pi)
    assert decide(back, mate)[1].avoiding == 1.0
    assert decide(back, msgspec.structs.replace(mate, together=1.0))[1].avoiding == 0.0


def test_boats_that_turn_together_are_companions_that_keep_the_hard_radius_for_12_seconds() -> None:
    mate = peer_at(2.0, 0.0, 10.0, 1.0, chi_p=1.0, u_d=0.5, sigma=0.3)  # neither its course nor its speed is ours
    assert judged(own_at(), mate).pair.companion == 0.0
    found = judged(own_at(), msgspec.structs.replace(mate, together=1.0))
    assert (found.pair.companion, found.horizon, found.radius) == (1.0, 12.0, pytest.approx(3.5 + 2.0 * 0.3))


def test_boats_that_turn_together_still_keep_out_of_each_other() -> None:
    """It comes back faster than we do, from 8 m abeam: 1 m/s across, so it would be here in 8 s."""
    mate = peer_at(2.0, 0.0, -8.0, math.pi / 4, math.sqrt(2.0), gamma=math.pi / 4, chi_p=0.0, u_d=math.sqrt(2.0))
    assert decide(own_at(), msgspec.structs.replace(mate, together=1.0))[1].avoiding == 1.0


def near(dx: float, dy: float) -> tuple[Beside[float], ...]:
    """Those that sweeping counts of one vehicle there, at 1 m/s: 2 u / r_max is 2 / 0.35 = 5.7 m, R_h 3.5 m."""
    peer = peer_at(1.0, dx, dy, 0.0, 0.0, u_d=0.0)
    own = own_at()
    seen = view(own, peer, PARAMS)
    one = threat(own, peer, seen, judged(own, peer), PARAMS)
    return swept(1.0, (one,), LIMITS.yaw_rate_max_radps, PARAMS)


def test_turning_through_the_bearing_of_a_vehicle_within_the_turning_circles_breadth_has_a_price() -> None:
    reach = 3.5 + 2.0 / LIMITS.yaw_rate_max_radps
    beside = near(0.6 * reach * math.cos(0.5), 0.6 * reach * math.sin(0.5))  # 0.5 rad on the starboard bow
    price = 12.0 * 0.4
    assert sweep_price(1.0, 0.0, math.cos(1.0), math.sin(1.0), beside) == pytest.approx(price)
    assert sweep_price(1.0, 0.0, math.cos(0.4), math.sin(0.4), beside) == 0.0  # stops short of it
    assert sweep_price(1.0, 0.0, math.cos(1.0), -math.sin(1.0), beside) == 0.0  # the other way round
    assert near(1.01 * reach, 0.0) == ()


def test_a_boat_beside_another_goes_on_with_its_turn_instead_of_turning_back_through_it() -> None:
    # heading 70 deg, a boat that lies still 7 m ahead of the path to port of the bow; the path leads north
    own = own_at(chi=math.radians(70.0), gamma=math.radians(-20.0), y_e=3.0)
    still = peer_at(1.0, 7.0, 3.0, 0.0, 0.0, u_d=0.0)
    _, advice = decide(own, still)
    assert advice.r_d >= 0.0 or advice.u_d < 0.5


def test_swept_counts_only_vehicles_that_are_present() -> None:
    own, peer = own_at(), msgspec.structs.replace(peer_at(1.0, 5.0, 1.0, 0.0, 0.0), present=0.0)
    gone = threat(own, peer, view(own, peer, PARAMS), judged(own, peer), PARAMS)
    assert sweep_price(1.0, 0.0, 0.0, 1.0, swept(1.0, (gone,), LIMITS.yaw_rate_max_radps, PARAMS)) == 0.0
