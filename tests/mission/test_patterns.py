"""Patterns: places, who takes which slot, how one becomes another, and what is refused with its reason."""

from __future__ import annotations

import math
from itertools import combinations, permutations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs

from fleet.errors import UsageError
from fleet.mission.beside import sail
from fleet.mission.change import changed, words
from fleet.mission.check import check, check_formation
from fleet.mission.formation import gap_needed
from fleet.mission.load import load
from fleet.mission.model import Mission, Polyline, Sine, Start, Straight
from fleet.mission.multiply import multiply
from fleet.mission.pattern import PATTERNS, Shape, assigned, closed_up, redrawn, slots_of
from fleet.mission.plan import Plan, build
from fleet.mission.redraw import redrawing
from fleet.mission.wingman import wingmen

SWATH, WINGMAN, COLUMN = (load(name) for name in ("swath", "wingman", "patterns"))
NAMES = ("b1", "b2", "b3", "b4", "b5")


def shape(pattern: str, *slots: float, spacing: float = 12.0, lateral: float = 10.0) -> Shape:
    return Shape(pattern, spacing, lateral, 1.0, slots or slots_of(pattern, 5))


def places(one: Shape) -> list[tuple[float, float]]:
    assert list(one.places) == [one.place(i) for i in range(len(one.slots))]
    return list(one.places)


def refused(mission: Mission, **changes: object) -> list[str]:
    """What is wrong with a mission whose formation was changed."""
    formation = structs.replace(mission.formation, **changes)
    return list(check(structs.replace(mission, formation=formation, checks={})).problems)


# -- places ------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("column", [(0.0, 0.0), (-12.0, 0.0), (-24.0, 0.0)]),
        ("abreast", [(0.0, 0.0), (0.0, 10.0), (0.0, -10.0)]),
        ("echelon", [(0.0, 0.0), (-12.0, 10.0), (-24.0, 20.0)]),
        ("wedge", [(0.0, 0.0), (-12.0, 10.0), (-12.0, -10.0)]),
        ("wingman", [(0.0, 0.0), (0.0, 0.0), (0.0, 0.0)]),
    ],
)
def test_where_the_first_three_slots_of_a_pattern_lie(pattern: str, expected: list[tuple[float, float]]) -> None:
    assert places(shape(pattern, *slots_of(pattern, 3))) == expected


def test_who_leads_and_whom_a_wingman_sails_beside() -> None:
    flight = shape("wingman", 0.0, 2.0, -1.0, 1.0)
    assert flight.leading == 0
    assert [flight.leader_of(i) for i in range(4)] == [None, 3, 0, 0]
    assert shape("column", 0.0, 1.0).leading == 1
    assert shape("column", 0.0, 1.0, spacing=-12.0).leading == 0


def test_boats_of_one_slot_all_sail_beside_the_leader() -> None:
    star = shape("wingman", 1.0, 0.0, 1.0)
    assert [star.leader_of(i) for i in range(3)] == [1, None, 1]


# -- who takes which slot ----------------------------------------------------------------------------------------------
@given(
    st.integers(1, 5).flatmap(
        lambda n: st.lists(st.lists(st.floats(0.0, 100.0), min_size=n, max_size=n), min_size=n, max_size=n)
    )
)
def test_the_assignment_is_the_cheapest_of_all(cost: list[list[float]]) -> None:
    n = range(len(cost))
    found = assigned(cost)
    assert sorted(found) == list(n)
    best = min(sum(cost[i][one[i]] for i in n) for one in permutations(n))
    assert sum(cost[i][found[i]] for i in n) == pytest.approx(best)


def test_a_column_becomes_a_wedge_from_the_front() -> None:
    wedge = redrawn(shape("column"), "wedge")
    assert wedge.slots[0] == 0.0
    assert {abs(slot) for slot in wedge.slots[1:3]} == {1.0}
    assert {abs(slot) for slot in wedge.slots[3:]} == {2.0}


@pytest.mark.parametrize("before", ["column", "abreast", "echelon", "wedge"])
@pytest.mark.parametrize("after", ["column", "abreast", "echelon", "wedge"])
def test_boats_redrawn_keep_apart_on_the_way(before: str, after: str) -> None:
    """Without a detour, since nobody's way crosses another's needlessly."""
    plan = build(COLUMN)
    old = shape(before, lateral=12.0)
    change = redrawing(places(old), redrawn(old, after), plan.boats, 8.0)
    if change is not None:
        assert set(change.detours) == {0.0}
        assert nearest(change) >= 8.0 - 1e-6


def nearest(change: object) -> float:
    moments = [change.places(change.duration_s * k / 100.0) for k in range(101)]  # type: ignore[attr-defined]
    return min(math.dist(a, b) for moment in moments for a, b in combinations(moment, 2))


def test_boats_that_change_over_across_a_third_pass_ahead_and_astern_of_it() -> None:
    old = shape("abreast", 0.0, 1.0, -1.0, lateral=12.0)
    new = changed(("b1", "b2", "b3"), old, "slots", "b2=-1,b3=1")
    change = redrawing(places(old), new, build(COLUMN).boats[:3], 8.0)
    assert change is not None
    assert change.detours == (0.0, -12.0, 12.0)  # to port astern, to starboard ahead
    assert nearest(change) >= 8.0


@settings(max_examples=30)
@given(st.permutations(slots_of("abreast", 5)))
def test_no_exchange_of_slots_abreast_brings_boats_below_the_safety_radius(slots: list[float]) -> None:
    old = shape("abreast", lateral=12.0)
    change = redrawing(places(old), structs.replace(old, slots=tuple(slots)), build(COLUMN).boats, 8.0)
    assert change is None or nearest(change) >= 6.0


def test_a_change_of_spacing_alone_is_left_to_the_speeds() -> None:
    old = shape("wedge")
    assert redrawing(places(old), structs.replace(old, spacing_m=20.0), build(COLUMN).boats, 8.0) is None


# -- vacancies ---------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("slots", "gone", "expected"),
    [
        ((0.0, -1.0, -2.0, -3.0), "b2", (0.0, -3.0, -1.0, -2.0)),
        ((0.0, -1.0, -2.0, -3.0), "b1", (-3.0, 0.0, -1.0, -2.0)),
        ((0.0, 1.0, -1.0, 2.0, -2.0), "b2", (0.0, 2.0, -1.0, 1.0, -2.0)),
        ((0.0, 1.0, -1.0, 2.0, -2.0), "b1", (2.0, 0.0, -1.0, 1.0, -2.0)),
        ((0.0, -1.0, -2.0), "b3", (0.0, -1.0, -2.0)),
    ],
)
def test_those_further_out_move_in(slots: tuple[float, ...], gone: str, expected: tuple[float, ...]) -> None:
    assert closed_up(slots, [name == gone for name in NAMES[: len(slots)]]) == expected


@given(st.permutations(slots_of("wedge", 5)), st.lists(st.booleans(), min_size=5, max_size=5))
def test_nobody_moves_twice_and_no_slot_is_lost(slots: list[float], gone: list[bool]) -> None:
    once = closed_up(tuple(slots), gone)
    assert sorted(once) == sorted(slots)
    assert closed_up(once, gone) == once
    assert closed_up(once, [False] * 5) == once  # who comes back takes the place that is kept for it


# -- what is refused ---------------------------------------------------------------------------------------------------
def test_a_lane_that_bends_more_than_a_boat_can_turn_is_refused_with_the_place() -> None:
    found = refused(SWATH, lateral_m=11.0)
    assert any("lateral_m = 11" in text and "bends with a radius of 3.0 m at" in text for text in found)
    assert any("b4 needs 4.3 m (1.5 m/s at 0.35 rad/s)" in text for text in found)


def test_a_lane_with_a_cusp_is_refused() -> None:
    assert any("radius of 0.0 m at" in text for text in refused(SWATH, lateral_m=14.0))


def test_a_lane_on_which_the_outer_boat_is_too_slow_is_refused_with_the_place() -> None:
    found = refused(SWATH, cruise_mps=0.8)
    assert any("20 m to port of path lanes asks for 1.44 m/s at" in text for text in found)


def test_a_lane_outside_the_fence_is_refused_with_the_place() -> None:
    wide = structs.replace(SWATH, paths={"lanes": Straight(start=(0.0, 0.0), end=(160.0, 0.0))})
    found = refused(wide, lateral_m=35.0)
    assert any("the lane 70 m to port of path lanes leaves the fence at 0 m, at [0.0, -70.0] m" in t for t in found)


def test_slots_abreast_too_near_are_refused() -> None:
    assert any("are 7.0 m apart on path lanes" in text for text in refused(SWATH, lateral_m=7.0))


def test_a_pattern_with_lanes_needs_one_path_for_all() -> None:
    problems = refused(WINGMAN, pattern="abreast", lateral_m=15.0)
    assert any("b1 sails path line, b2 path curve; expected one path for all" in text for text in problems)


def test_paths_that_are_not_oriented_in_the_same_direction_are_refused_with_the_place() -> None:
    back = Polyline(points=((0.0, 20.0), (200.0, 20.0), (200.0, 60.0), (0.0, 60.0)), corner_radius_m=15.0)
    mission = structs.replace(WINGMAN, paths={**WINGMAN.paths, "curve": back})
    (text,) = [text for text in refused(mission) if "oriented" in text]
    assert "path curve at 2" in text
    assert "deg off path line at" in text
    assert "expected paths oriented in the same direction, at most 73 deg apart" in text


def test_a_path_on_which_the_wingman_is_too_slow_is_refused_with_the_place() -> None:
    boats = tuple(structs.replace(b, limits=structs.replace(b.limits, speed_max_mps=1.15)) for b in WINGMAN.boats)
    (text,) = refused(structs.replace(WINGMAN, boats=boats))
    assert "asks for 1.09 m/s to stay abeam; b2 needs 0.6 to 1.05 m/s to keep its place" in text


def test_two_leaders_are_refused() -> None:
    boats = (WINGMAN.boats[0], structs.replace(WINGMAN.boats[1], slot=0.0))
    plan = build(structs.replace(WINGMAN, boats=boats))
    assert check_formation(plan, plan.shape) == [
        "pattern wingman: b1, b2 have nobody nearer to slot 0 to sail beside; expected one leader"
    ]


def test_too_little_path_for_a_change_is_refused_before_anything_moves() -> None:
    plan = build(COLUMN)
    wedge = redrawn(plan.shape, "wedge")
    near_the_end = {name: 380.0 - 10.0 * i for i, name in enumerate(NAMES)}
    (text,) = check_formation(plan, wedge, near_the_end, before=plan.shape)
    assert text.startswith("pattern wedge: changing lanes takes 7")
    assert text.endswith("b1 has 40 m of path line left")
    assert check_formation(plan, wedge, dict.fromkeys(NAMES, 100.0), before=plan.shape) == []


@pytest.mark.parametrize(
    ("what", "value", "message"),
    [
        ("pattern", "wegde", "no such pattern; did you mean"),
        ("leader", "b9", "no such boat"),
        ("slots", "b1", "expected BOAT=SLOT, such as b1=0"),
        ("slots", "b1=0,b1=1", "b1 is named twice"),
        ("slots", "b7=0", "no such boat"),
        ("slots", "b1=nan", "expected BOAT=SLOT"),
        ("lateral", "wide", "expected a number of metres"),
        ("heading", "3", "expected one of spacing, lateral, speed, pattern, leader, slots"),
    ],
)
def test_a_change_that_means_nothing_is_refused(what: str, value: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        changed(NAMES, shape("column"), what, value)


def test_a_new_leader_and_the_old_one_exchange_their_slots() -> None:
    new = changed(NAMES, shape("column"), "leader", "b3")
    assert new.slots == (-2.0, -1.0, 0.0, -3.0, -4.0)
    assert words(NAMES, new, "leader") == "b3"


def test_two_boats_in_one_slot_are_refused() -> None:
    plan = build(COLUMN)
    double = changed(NAMES, plan.shape, "slots", "b2=0")
    assert check_formation(plan, double) == ["slots: b1 and b2 both have slot 0 on path line"]


# -- wingmen -----------------------------------------------------------------------------------------------------------
def plan_of(wavelength: float = 220.0) -> Plan:
    curve = Sine(start=(0.0, 0.0), end=(550.0, 0.0), amplitude_m=15.0, wavelength_m=wavelength)
    return build(structs.replace(WINGMAN, paths={**WINGMAN.paths, "curve": curve}))


@pytest.mark.parametrize("wavelength", [110.0, 150.0, 220.0])
def test_with_the_room_that_it_gives_a_wingman_is_never_nearer_than_slots_may_be(wavelength: float) -> None:
    plan = plan_of(wavelength)
    need = gap_needed(plan.mission)
    (one,) = wingmen(plan, plan.shape, need).values()
    near = [math.dist((m.own.x, m.own.y), (m.leader.x, m.leader.y)) for m in sail(one.boat, one.leader, one.room)]
    assert min(near[25:]) >= need - 0.6  # on curves places shift a little while it falls back


def test_abeam_where_there_is_room_and_8_m_behind_where_the_paths_cross() -> None:
    plan = plan_of()
    (one,) = wingmen(plan, plan.shape, 8.0).values()
    by_abeam = {abs(m.abeam): one.room.at(m.s2)[0] for m in one.voyage[30:]}
    assert min(by_abeam.values()) == pytest.approx(-8.0, abs=0.1)
    assert by_abeam[max(by_abeam)] == 0.0
    assert all(room <= 0.0 for room in by_abeam.values())


def test_the_second_wingman_of_a_leader_goes_ahead() -> None:
    second = structs.replace(WINGMAN.boats[1], name="b3", slot=-1.0, path="other", start=Start(s_m=47.0))
    curve = Sine(start=(0.0, 0.0), end=(550.0, 0.0), amplitude_m=-15.0, wavelength_m=220.0)
    mission = structs.replace(WINGMAN, boats=(*WINGMAN.boats, second), paths={**WINGMAN.paths, "other": curve})
    plan = build(mission)
    found = wingmen(plan, plan.shape, 8.0)
    assert max(found[2].room.values) == pytest.approx(8.0, abs=0.1)
    assert min(found[1].room.values) == pytest.approx(-8.0, abs=0.1)


# -- missions ----------------------------------------------------------------------------------------------------------
def test_boats_abreast_begin_abreast() -> None:
    assert sorted((boat.x, boat.y) for boat in build(SWATH).boats) == [(20.0, -20.0 + 10.0 * i) for i in range(5)]


def test_more_boats_take_the_next_slots_of_the_pattern() -> None:
    many = multiply(SWATH, 7)
    assert [boat.slot for boat in many.boats] == [0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0]
    assert {boat.start.s_m for boat in many.boats} == {20.0}


def test_every_pattern_is_named_once_in_the_mission_file_and_once_on_the_wire() -> None:
    assert set(PATTERNS) == {"column", "abreast", "echelon", "wedge", "wingman"}
    for pattern in PATTERNS:
        structs.replace(SWATH.formation, pattern=pattern)
