"""Paths as they are drawn, and the words with which what cannot be drawn is refused."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from fleet import paths
from fleet.errors import UsageError
from fleet.paths import PathError, sample

NAN = math.nan


def test_a_line_runs_from_its_start_to_its_end() -> None:
    line = paths.straight((1.0, 2.0), (4.0, 6.0))
    assert line.length == pytest.approx(5.0)
    assert (line.at(5.0).x, line.at(5.0).y) == pytest.approx((4.0, 6.0))
    assert line.max_curvature == 0.0
    assert len(line.cells) == 1


def test_an_arc_to_starboard_that_starts_north_of_its_centre_heads_east() -> None:
    arc = paths.arc((0.0, 0.0), 10.0, 0.0, math.pi / 2)
    assert (arc.at(0.0).x, arc.at(0.0).y) == pytest.approx((10.0, 0.0))
    assert (arc.at(0.0).tx, arc.at(0.0).ty) == pytest.approx((0.0, 1.0), abs=1e-12)
    assert (arc.at(arc.length).x, arc.at(arc.length).y) == pytest.approx((0.0, 10.0), abs=1e-9)
    assert arc.length == pytest.approx(5.0 * math.pi)
    assert not arc.closed


@pytest.mark.parametrize("turn", [2.0 * math.pi, -2.0 * math.pi])
def test_a_whole_turn_is_a_closed_path(turn: float) -> None:
    circle = paths.arc((3.0, 4.0), 10.0, 0.3, turn)
    assert circle.closed
    assert circle.length == pytest.approx(20.0 * math.pi)
    assert math.copysign(1.0, circle.at(5.0).c) == math.copysign(1.0, turn)


def test_an_arc_turns_at_most_a_quarter_of_a_radian_per_cell() -> None:
    circle = paths.arc((0.0, 0.0), 100.0, 0.0, 2.0 * math.pi)
    assert max(1.0 / cell.per_m for cell in circle.cells) / 100.0 <= 0.25


def test_a_corner_of_90_degrees_is_rounded_by_a_quarter_circle() -> None:
    path = paths.polyline([(0.0, 0.0), (50.0, 0.0), (50.0, 50.0)], 10.0)
    assert path.length == pytest.approx(40.0 + 5.0 * math.pi + 40.0)
    assert path.max_curvature == pytest.approx(0.1, rel=0.01)
    middle = path.at(40.0 + 2.5 * math.pi)
    assert (middle.x, middle.y) == pytest.approx((40.0 + 10.0 * math.sqrt(0.5), 10.0 - 10.0 * math.sqrt(0.5)), abs=1e-4)
    assert middle.c == pytest.approx(0.1, rel=0.01)
    assert path.at(20.0).c == 0.0


def test_a_closed_polyline_starts_after_its_first_corner_and_ends_there() -> None:
    path = paths.polyline([(0.0, 0.0), (100.0, 0.0), (100.0, 50.0), (0.0, 50.0)], 8.0, closed=True)
    assert path.closed
    assert path.length == pytest.approx(2.0 * (100.0 + 50.0) - 8.0 * 8.0 + 2.0 * math.pi * 8.0)
    assert (path.at(0.0).x, path.at(0.0).y) == pytest.approx((8.0, 0.0))


def test_legs_that_just_fit_their_corners_are_accepted() -> None:
    path = paths.polyline([(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0)], 10.0, closed=True)
    assert path.length == pytest.approx(20.0 * math.pi, rel=1e-6)


def test_points_in_one_line_are_no_corner() -> None:
    path = paths.polyline([(0.0, 0.0), (50.0, 0.0), (100.0, 0.0)], 10.0)
    assert path.max_curvature == 0.0
    assert path.length == pytest.approx(100.0)
    assert path.straight(0.0) == paths.NEVER_M


def test_a_hardly_visible_corner_makes_no_tiny_cell() -> None:
    path = paths.polyline([(0.0, 0.0), (1000.0, 0.0), (2000.0, 0.01)], 5.0)
    assert min(1.0 / cell.per_m for cell in path.cells) > 0.4
    assert path.hops <= 1


def test_a_sine_with_positive_amplitude_goes_to_starboard_first() -> None:
    path = paths.sine((0.0, 0.0), (160.0, 0.0), 10.0, 80.0)
    assert max(y for _, y in sample(path, 0.1)[: round(len(sample(path, 0.1)) / 4)]) == pytest.approx(10.0, abs=1e-3)
    assert (path.at(path.length).x, path.at(path.length).y) == pytest.approx((160.0, 0.0), abs=1e-6)
    assert path.max_curvature == pytest.approx(10.0 * (2.0 * math.pi / 80.0) ** 2, rel=0.01)


def test_the_points_of_a_sine_lie_on_it() -> None:
    for x, y in sample(paths.sine((0.0, 0.0), (160.0, 0.0), 15.0, 50.0), 0.37):
        assert y == pytest.approx(15.0 * math.sin(2.0 * math.pi * x / 50.0), abs=1e-3)


def test_a_sine_without_amplitude_is_a_line() -> None:
    assert len(paths.sine((0.0, 0.0), (100.0, 0.0), 0.0, 50.0).cells) == 1


@pytest.mark.parametrize("closed", [False, True])
def test_a_spline_passes_through_its_points_in_order(closed: bool) -> None:
    points = [(0.0, 0.0), (30.0, 10.0), (50.0, 50.0), (10.0, 60.0)]
    path = paths.through(points, closed)
    seen = [path.project(*p) for p in points]
    assert seen == sorted(seen)
    for s, p in zip(seen, points, strict=True):
        assert (path.at(s).x, path.at(s).y) == pytest.approx(p, abs=1e-6)
    assert path.closed is closed


def test_a_natural_spline_ends_without_curvature_and_a_periodic_one_has_no_seam() -> None:
    points = [(0.0, 0.0), (30.0, 10.0), (50.0, 50.0), (10.0, 60.0)]
    natural, periodic = paths.through(points), paths.through(points, closed=True)
    assert natural.at(0.01).c == pytest.approx(0.0, abs=1e-3)
    assert periodic.at(-0.01).c == pytest.approx(periodic.at(0.01).c, abs=2e-3)


def test_cells_of_smooth_curves_are_at_most_a_metre() -> None:
    for path in (
        paths.sine((0.0, 0.0), (100.0, 0.0), 15.0, 30.0),
        paths.through([(0.0, 0.0), (40.0, 30.0), (90.0, 0.0)]),
    ):
        assert max(1.0 / cell.per_m for cell in path.cells) <= 1.0 + 1e-9


def test_a_sample_ends_at_the_end() -> None:
    assert sample(paths.straight((0.0, 0.0), (10.0, 0.0)), 4.0) == [(0.0, 0.0), (4.0, 0.0), (8.0, 0.0), (10.0, 0.0)]


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "line without length": (
        lambda: paths.straight((1.0, 2.0), (1.0, 2.0)),
        r"points 1 and 2 coincide at \[1\.00, 2\.00\] m; expected neighbours apart",
    ),
    "NaN": (lambda: paths.straight((0.0, NAN), (1.0, 2.0)), r"east of point 1 is nan; expected a finite number"),
    "radius": (lambda: paths.arc((0.0, 0.0), -3.0, 0.0, 1.0), r"radius of the arc is -3\.0 m; expected a number > 0"),
    "no turn": (
        lambda: paths.arc((0.0, 0.0), 3.0, 0.0, 0.0),
        r"arc about \[0\.00, 0\.00\] m turns by 0 deg; expected up",
    ),
    "two turns": (lambda: paths.arc((0.0, 0.0), 3.0, 0.0, 12.0), r"turns by 687\.549 deg; expected up to 360 deg"),
    "bearing": (lambda: paths.arc((0.0, 0.0), 3.0, math.inf, 1.0), r"bearing of the arc's start is inf; expected"),
    "one point": (lambda: paths.polyline([(0.0, 0.0)], 3.0), r"path has 1 points; expected at least 2"),
    "corner radius": (
        lambda: paths.polyline([(0.0, 0.0), (9.0, 0.0)], 0.0),
        r"corner radius is 0\.0 m; expected a number > 0",
    ),
    "short leg": (
        lambda: paths.polyline([(0.0, 0.0), (50.0, 0.0), (50.0, 10.0), (0.0, 10.0)], 6.0),
        r"leg from point 2 \[50\.00, 0\.00\] m to point 3 \[50\.00, 10\.00\] m is 10\.00 m long, its corners of radius "
        r"6\.00 m need 12\.00 m; expected a corner radius of at most 5\.00 m, or a longer leg",
    ),
    "doubling back": (
        lambda: paths.polyline([(0.0, 0.0), (50.0, 0.0), (10.0, 0.0)], 6.0),
        r"path doubles back at point 2 \[50\.00, 0\.00\] m, turning by 180\.0 deg; expected less than 180 deg",
    ),
    "coinciding waypoints": (
        lambda: paths.polyline([(0.0, 0.0), (50.0, 0.0), (50.0, 0.0)], 6.0),
        r"points 2 and 3 coincide at \[50\.00, 0\.00\] m",
    ),
    "closed by hand": (
        lambda: paths.polyline([(0.0, 0.0), (50.0, 0.0), (50.0, 50.0), (0.0, 0.0)], 6.0, closed=True),
        r"points 4 and 1 coincide .*a closed path ends at its first point by itself",
    ),
    "wavelength": (
        lambda: paths.sine((0.0, 0.0), (50.0, 0.0), 5.0, 0.0),
        r"wavelength of the sine is 0\.0 m; expected a number > 0",
    ),
    "amplitude": (lambda: paths.sine((0.0, 0.0), (50.0, 0.0), NAN, 5.0), r"amplitude of the sine is nan; expected"),
    "spline of two, closed": (
        lambda: paths.through([(0.0, 0.0), (50.0, 0.0)], closed=True),
        r"path has 2 points; expected at least 3",
    ),
    "spline through one place twice": (
        lambda: paths.through([(0.0, 0.0), (0.0, 0.0), (50.0, 0.0)]),
        r"points 1 and 2 coincide",
    ),
    "sample": (
        lambda: sample(paths.straight((0.0, 0.0), (1.0, 0.0)), 0.0),
        r"step of the sample is 0\.0 m; expected a number > 0",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_cannot_be_drawn_is_refused_with_value_place_and_what_was_expected(name: str) -> None:
    draw, message = WRONG[name]
    with pytest.raises(PathError, match=message) as refusal:
        draw()
    assert isinstance(refusal.value, UsageError)
