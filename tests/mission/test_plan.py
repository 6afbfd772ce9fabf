"""The plan in metres; formations that can be sailed and that cannot; checks; pictures."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from fleet.errors import FleetError, MissionError
from fleet.mission.check import check, check_formation
from fleet.mission.checks import CHECKS, evaluate
from fleet.mission.formation import gap_needed
from fleet.mission.load import load
from fleet.mission.model import Arc, Boat, Environment, Geographic, Mission, Start, Straight
from fleet.mission.pattern import Shape
from fleet.mission.picture import picture, slots
from fleet.mission.plan import Plan, build
from fleet.mission.waters import inside

OVERTAKING = build(load("overtaking"))


def formed(plan: Plan, spacing: float, cruise: float = 1.0) -> Shape:
    """The launch formation of a plan with another spacing and speed."""
    return structs.replace(plan.shape, spacing_m=spacing, cruise_mps=cruise)


def abreast(distance: float) -> Mission:
    """Two boats side by side on parallel lines."""
    mission = load("overtaking")
    lines = {
        name: Straight(start=(0.0, east), end=(280.0, east)) for name, east in (("line", 0.0), ("beside", distance))
    }
    first, second = mission.boats
    second = structs.replace(second, path="beside", slot=1.0, start=Start(s_m=40.0))
    return structs.replace(mission, paths=lines, boats=(first, second), timeline=(), checks={})


def test_the_plan_puts_boats_on_their_path_heading_along_it() -> None:
    b1, b2 = OVERTAKING.boats
    assert (b1.x, b1.y, b1.psi, b1.u, b1.s) == (40.0, 0.0, 0.0, 1.0, 40.0)
    assert (b2.x, b2.y) == (20.0, 0.0)
    assert [OVERTAKING.shape.ahead(i) for i in (0, 1)] == [20.0, 0.0]
    assert [formed(OVERTAKING, -20.0).ahead(i) for i in (0, 1)] == [-20.0, 0.0]
    assert OVERTAKING.boat("b2") is b2


def test_a_start_beside_the_path_is_to_starboard_for_a_positive_offset() -> None:
    b3 = build(load("late-joiner")).boat("b3")
    assert (b3.x, b3.y) == (5.0, 12.0)
    assert b3.starts_late


def test_a_boat_that_is_killed_before_it_is_started_does_not_start_late() -> None:
    assert not any(boat.starts_late for boat in build(load("comes-back")).boats)


def test_positions_on_the_globe_and_in_metres_agree() -> None:
    mission = load("overtaking")
    lat, lon = OVERTAKING.plane.to_geographic(280.0, 0.0)
    line = Straight(start=(0.0, 0.0), end=Geographic(lat_deg=lat, lon_deg=lon))
    plan = build(structs.replace(mission, paths={"line": line}))
    assert plan.paths["line"].length == pytest.approx(280.0, abs=1e-6)


def test_a_start_by_position_knows_its_abscissa() -> None:
    mission = load("overtaking")
    start = Start(position=(33.0, -4.0), heading_deg=270.0)
    plan = build(structs.replace(mission, boats=(structs.replace(mission.boats[0], start=start),)))
    assert plan.boats[0].s == pytest.approx(33.0)
    assert plan.boats[0].psi == pytest.approx(-math.pi / 2)


def test_a_plan_that_cannot_be_built_says_why() -> None:
    mission = structs.replace(load("overtaking"), paths={"line": Straight(start=(0.0, 0.0), end=(0.0, 0.0))})
    with pytest.raises(MissionError, match="coincide"):
        build(mission)


@pytest.mark.parametrize(
    ("spacing", "cruise", "reasons"),
    [
        (20.0, 1.0, []),
        (-20.0, 1.0, []),
        (8.0, 1.0, []),
        (-7.5, 1.0, ["spacing -7.5 m: b1 and b2 are 7.5 m apart on path line; at least 8.0 m"]),
        (0.0, 1.0, ["spacing 0 m: b1 and b2 are 0.0 m apart on path line; at least 8.0 m"]),
        (math.nan, 1.0, ["spacing nan m: expected a number"]),
        (20.0, 0.7, ["cruise 0.7 m/s: b1 (and 1 more) needs 0.8 to 1.2 m/s to keep its place"]),
        (20.0, math.nan, ["cruise nan m/s: b1 (and 1 more) needs 0.8 to 1.2 m/s to keep its place"]),
        (300.0, 1.0, ["spacing 300 m: from b2 to b1 the formation is 300 m long, path line only 280 m"]),
    ],
)
def test_a_formation_is_refused_with_the_reason(spacing: float, cruise: float, reasons: list[str]) -> None:
    assert check_formation(OVERTAKING, formed(OVERTAKING, spacing, cruise)) == reasons


def test_a_place_beyond_the_end_of_the_path_is_refused_while_under_way() -> None:
    there = {"b1": 260.0, "b2": 240.0}
    assert check_formation(OVERTAKING, formed(OVERTAKING, 40.0, 1.0), there) == []
    assert check_formation(OVERTAKING, formed(OVERTAKING, 100.0, 1.0), there) == [
        "spacing 100 m: the place of b1 would be at 300 m of path line, which goes from 0 to 280 m"
    ]


def test_position_errors_widen_the_slots() -> None:
    mission = load("overtaking")
    assert gap_needed(mission) == 8.0
    assert gap_needed(mission, sigma_m=1.5) == pytest.approx(6.5 + 3.0 * math.sqrt(2.0))
    noisy = structs.replace(mission, environment=Environment(gnss_sigma_m=1.5))
    assert gap_needed(noisy) == gap_needed(mission, sigma_m=1.5)
    assert len(check_formation(OVERTAKING, formed(OVERTAKING, 10.0, 1.0), sigma_m=1.5)) == 1


def test_lines_side_by_side_need_the_room_of_slots() -> None:
    assert check(abreast(8.0)).problems == ()
    assert check(abreast(7.0)).problems == (
        "formation.spacing_m = 20: the places of b1 and b2 are 7.0 m apart for most of the way; at least 8.0 m",
    )


def test_lines_that_cross_are_a_warning_because_boats_keep_clear() -> None:
    mission = abreast(60.0)
    crossing = structs.replace(
        mission, paths={**mission.paths, "beside": Straight(start=(140.0, -140.0), end=(140.0, 140.0))}
    )
    findings = check(structs.replace(crossing, fence=None, home=None))
    assert findings.problems == ()
    assert len(findings.warnings) == 1
    assert "come within 0.0 m of each other" in findings.warnings[0]


@given(st.integers(2, 12), st.floats(8.0, 40.0))
def test_round_a_circle_there_is_room_for_as_many_boats_as_fit(boats: int, spacing: float) -> None:
    plan = circle(boats)
    lap = plan.paths["ring"].length
    fits = boats * spacing <= lap - max(8.0 - spacing, 0.0) and lap - (boats - 1) * spacing >= 8.0
    assert (check_formation(plan, formed(plan, spacing, 1.0)) == []) or not fits


def test_a_column_as_long_as_the_lap_is_refused() -> None:
    plan = circle(5)
    lap = plan.paths["ring"].length
    assert check_formation(plan, formed(plan, lap / 5.0, 1.0)) == []
    assert check_formation(plan, formed(plan, lap / 4.0, 1.0)) == [
        "spacing 62.8319 m: b1 and b5 are 0.0 m apart on path ring; at least 8.0 m"
    ]


def circle(boats: int) -> Plan:
    """Boats on a circle of 40 m radius."""
    ring = Arc(centre=(0.0, 0.0), radius_m=40.0, from_deg=0.0, turn_deg=360.0)
    roster = tuple(
        Boat(name=f"b{i + 1}", path="ring", slot=-float(i), start=Start(s_m=240.0 - 10.0 * i)) for i in range(boats)
    )
    return build(structs.replace(load("circuit"), paths={"ring": ring}, boats=roster))


def test_checks_hold_in_their_direction_and_a_missing_figure_fails() -> None:
    checks = {"collisions": 0.0, "min_separation_m": 6.0, "reformed_s": 90.0, "finished": 1.0, "formation_error_m": 0.1}
    figures = {"collisions": 0.0, "min_separation_m": 5.9, "reformed_s": 90.0, "finished": 1.0, "speed_max_mps": 9.0}
    results = evaluate(checks, figures)
    assert [result.name for result in results] == list(checks)
    assert [result.ok for result in results] == [True, False, True, True, False]
    assert results[-1].value is None


@pytest.mark.parametrize("name", CHECKS)
def test_what_is_not_a_number_passes_no_check(name: str) -> None:
    assert not evaluate({name: 1.0}, {name: math.nan})[0].ok


def test_inside_and_outside_of_a_fence_with_a_bay() -> None:
    fence = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (5.0, 2.0), (0.0, 10.0)]
    assert inside((1.0, 5.0), fence)
    assert inside((9.0, 5.0), fence)
    assert not inside((5.0, 5.0), fence)
    assert not inside((-1.0, 5.0), fence)


def test_slots_at_launch_stand_where_the_boats_begin_in_formation() -> None:
    assert slots(OVERTAKING) == [(40.0, 0.0), (20.0, 0.0)]


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_a_mission_is_drawn(tmp_path: Path, ending: str) -> None:
    file = picture(OVERTAKING, tmp_path / f"mission.{ending}")
    assert file.stat().st_size > 10_000


def test_without_matplotlib_the_picture_names_the_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(FleetError, match=r"fleet-usv\[plots\]"):
        picture(OVERTAKING, tmp_path / "mission.png")
