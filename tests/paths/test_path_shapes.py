"""Every path: abscissa is arc length, the tangent is the derivative, junctions are smooth, nearest points are found."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet import paths
from fleet.paths import NEVER_M, Cell, Path, evaluate, sample

TEN_DEG = math.radians(10.0)
ZIGZAG = [(i * 12.0, 15.0 * math.sin(0.9 * i)) for i in range(20)]
LOOP = [(0.0, 0.0), (60.0, 10.0), (70.0, 60.0), (20.0, 80.0), (-20.0, 40.0)]
PATHS: dict[str, Path] = {
    "line": paths.straight((10.0, -5.0), (310.0, 395.0)),
    "arc to starboard": paths.arc((5.0, 7.0), 25.0, 0.4, 4.0),
    "arc to port": paths.arc((5.0, 7.0), 25.0, 0.4, -4.0),
    "circle": paths.arc((0.0, 0.0), 15.0, 1.0, 2.0 * math.pi),
    "circle to port": paths.arc((0.0, 0.0), 60.0, 1.0, -2.0 * math.pi),
    "polyline": paths.polyline([(0.0, 0.0), (100.0, 0.0), (120.0, 60.0), (40.0, 80.0)], 6.0),
    "circuit": paths.polyline([(0.0, 0.0), (100.0, 0.0), (100.0, 50.0), (0.0, 50.0)], 8.0, closed=True),
    "circuit to port": paths.polyline([(0.0, 0.0), (0.0, 50.0), (100.0, 50.0), (100.0, 0.0)], 8.0, closed=True),
    "sine": paths.sine((0.0, 0.0), (220.0, 40.0), 10.0, 80.0),
    "steep sine": paths.sine((0.0, 0.0), (100.0, 0.0), 15.0, 30.0),
    "spline": paths.through(ZIGZAG),
    "uneven spline": paths.through([(0.0, 0.0), (1.0, 2.0), (80.0, 20.0), (82.0, 24.0), (90.0, 100.0)]),
    "loop": paths.through(LOOP, closed=True),
}
every_path = pytest.mark.parametrize("path", PATHS.values(), ids=PATHS.keys())
OPEN = {name: path for name, path in PATHS.items() if not path.closed}
CLOSED = {name: path for name, path in PATHS.items() if path.closed}


def abscissae(path: Path, count: int = 700) -> list[float]:
    """Spread over the path by an irrational step, its ends and junctions among them."""
    spread = [(k * 0.6180339887 % 1.0) * path.length for k in range(count)]
    return [*spread, 0.0, math.nextafter(path.length, 0.0), *(cell.s0 for cell in path.cells[:200])]


@every_path
def test_abscissa_is_arc_length_everywhere_to_a_thousandth(path: Path) -> None:
    for s in abscissae(path):
        a, b = path.at(s - 0.005), path.at(s + 0.005)
        assert math.hypot(b.x - a.x, b.y - a.y) == pytest.approx(0.01, rel=1e-3)


@every_path
def test_the_whole_length_is_that_of_the_drawn_line(path: Path) -> None:
    points = sample(path, 0.02)
    drawn = sum(math.dist(a, b) for a, b in pairwise(points))
    assert path.length == pytest.approx(drawn, rel=1e-4)


@every_path
def test_the_tangent_is_of_unit_length_and_the_derivative_of_the_position(path: Path) -> None:
    for s in abscissae(path):
        p, a, b = path.at(s), path.at(s - 1e-4), path.at(s + 1e-4)
        d = math.hypot(b.x - a.x, b.y - a.y)
        assert p.tx * p.tx + p.ty * p.ty == pytest.approx(1.0, abs=1e-12)
        assert (p.tx, p.ty) == pytest.approx(((b.x - a.x) / d, (b.y - a.y) / d), abs=1e-4)


@every_path
def test_position_and_tangent_are_continuous_at_every_junction(path: Path) -> None:
    for cell in path.cells:
        a, b = path.at(cell.s0 - 1e-9), path.at(cell.s0 + 1e-9)
        assert (a.x, a.y) == pytest.approx((b.x, b.y), abs=1e-4)
        assert a.tx * b.ty - a.ty * b.tx == pytest.approx(0.0, abs=1e-6)


@every_path
def test_no_point_bends_more_than_the_path_says(path: Path) -> None:
    bends = [abs(path.at(s).c) for s in abscissae(path)]
    assert max(bends) <= path.max_curvature * (1.0 + 1e-9)
    assert max(bends) >= 0.95 * path.max_curvature


@every_path
def test_one_comparison_finds_the_cell(path: Path) -> None:
    assert path.hops <= 1
    for s in abscissae(path):
        cell = path.cells[path.index(s)]
        assert cell.s0 <= s
        assert (s - cell.s0) * cell.per_m <= 1.0 + 1e-9


@pytest.mark.parametrize(("name", "bend"), [("arc to starboard", 1 / 25), ("arc to port", -1 / 25), ("circle", 1 / 15)])
def test_curvature_of_an_arc_is_one_over_its_radius_and_positive_to_starboard(name: str, bend: float) -> None:
    for s in abscissae(PATHS[name]):
        assert PATHS[name].at(s).c == pytest.approx(bend, rel=0.01)


def test_an_arc_lies_on_its_circle_to_a_millionth_of_the_radius() -> None:
    for s in abscissae(PATHS["circle"]):
        p = PATHS["circle"].at(s)
        assert math.hypot(p.x, p.y) == pytest.approx(15.0, rel=1e-6)


@pytest.mark.parametrize("path", OPEN.values(), ids=OPEN.keys())
def test_beyond_its_ends_an_open_path_goes_straight_on(path: Path) -> None:
    first, last = path.at(0.0), path.at(path.length)
    before, after = path.at(-7.0), path.at(path.length + 7.0)
    assert (before.x, before.y) == pytest.approx((first.x - 7.0 * first.tx, first.y - 7.0 * first.ty))
    assert (after.x, after.y) == pytest.approx((last.x + 7.0 * last.tx, last.y + 7.0 * last.ty))
    assert before.c == after.c == 0.0
    assert (after.tx, after.ty) == (last.tx, last.ty)


@pytest.mark.parametrize("path", CLOSED.values(), ids=CLOSED.keys())
def test_a_closed_path_comes_round_again_lap_after_lap(path: Path) -> None:
    for s in (0.0, 3.7, 0.5 * path.length, path.length - 1e-9):
        p = path.at(s)
        for laps in (-3, 1, 5):
            q = path.at(s + laps * path.length)
            assert (q.x, q.y, q.tx, q.ty) == pytest.approx((p.x, p.y, p.tx, p.ty), abs=1e-6)
    for s in (-1e-300, -5e-17, path.length, 4.0 * path.length, math.nextafter(path.length, 0.0)):
        assert math.isfinite(path.at(s).x)


def test_an_abscissa_that_is_no_number_gives_no_position_instead_of_an_exception() -> None:
    assert all(math.isnan(path.at(math.nan).x) for path in PATHS.values())


@every_path
def test_straight_is_never_too_long_by_more_than_a_cell_and_rarely_short(path: Path) -> None:
    short = []
    for s in abscissae(path, 150):
        here, said = path.at(s), path.straight(s)
        longest = 1.0 / path.cells[path.index(min(s, path.length - 1e-9))].per_m if path.closed else 1.0
        true, step = 0.0, 0.05
        limit = min(said + 3.0, 80.0)
        while true < limit:
            ahead = path.at(s + true)
            if (
                abs(math.atan2(here.tx * ahead.ty - here.ty * ahead.tx, here.tx * ahead.tx + here.ty * ahead.ty))
                > TEN_DEG
            ):
                break
            true += step
        if true < limit:
            assert said <= true + max(longest, 1.0) + step
            short.append(said < 0.5 * true - 1.0)
        else:
            assert said >= 0.0
    assert sum(short) <= 0.15 * max(len(short), 1)


def test_straight_on_lines_and_arcs_is_exact() -> None:
    line, circle, circuit = PATHS["line"], PATHS["circle"], PATHS["circuit"]
    assert line.straight(3.0) == line.straight(-50.0) == line.straight(1e4) == NEVER_M
    for s in (0.0, 1.0, 40.0, 94.0, 500.0, -3.0):
        assert circle.straight(s) == pytest.approx(15.0 * TEN_DEG, rel=1e-6)
    assert circuit.straight(0.0) == pytest.approx(100.0 - 16.0 + 8.0 * TEN_DEG, abs=1e-6)
    assert circuit.straight(circuit.length - 3.0) == pytest.approx(8.0 * TEN_DEG, abs=1e-6)
    assert 0.3 < circuit.straight(circuit.length - 1.0) <= 1.0 + 84.0 + 8.0 * TEN_DEG - 1.0
    assert circuit.straight(10.0 + 2.0 * circuit.length) == pytest.approx(circuit.straight(10.0), abs=1e-6)


def test_the_leg_after_the_last_corner_never_bends_again() -> None:
    path = PATHS["polyline"]
    assert path.straight(path.length - 10.0) == NEVER_M
    assert path.straight(-20.0) == pytest.approx(path.straight(0.0) + 20.0)


@every_path
def test_project_is_the_inverse_of_at(path: Path) -> None:
    reach = 0.5 / path.max_curvature if path.max_curvature > 0.0 else 20.0
    for s in abscissae(path, 60)[:80]:
        p = path.at(s)
        for side in (0.0, min(0.3, 0.5 * reach), -min(0.3, 0.5 * reach)):
            x, y = p.x - side * p.ty, p.y + side * p.tx
            assert path.project(x, y, s - 2.0, s + 2.0) == pytest.approx(s, abs=2e-3)


@every_path
def test_project_finds_no_worse_a_point_than_a_patient_search(path: Path) -> None:
    points = np.array(sample(path, 0.1))
    for x, y in np.random.default_rng(7).uniform(-60.0, 160.0, (15, 2)).tolist():
        p = path.at(path.project(x, y))
        patient = float(np.min(np.hypot(points[:, 0] - x, points[:, 1] - y)))
        assert math.hypot(p.x - x, p.y - y) <= patient + 1e-3


def test_a_boat_before_the_start_or_beyond_the_end_of_an_open_path_has_an_abscissa_there() -> None:
    line = paths.straight((0.0, 0.0), (100.0, 0.0))
    assert line.project(-12.0, 3.0) == pytest.approx(-12.0)
    assert line.project(130.0, -3.0) == pytest.approx(130.0)
    assert line.project(-12.0, 3.0, 0.0, 100.0) == 0.0
    assert line.project(130.0, 3.0, -50.0, 110.0) == pytest.approx(110.0)
    assert line.project(40.0, 3.0, -20.0, -5.0) == pytest.approx(-5.0)
    assert line.project(40.0, 3.0, 105.0, 120.0) == pytest.approx(105.0)


def test_a_window_on_a_closed_path_counts_laps_and_wraps_the_seam() -> None:
    circle = PATHS["circle"]
    lap = circle.length
    p = circle.at(1.0)
    assert circle.project(p.x, p.y) == pytest.approx(1.0)
    assert circle.project(p.x, p.y, 2.0 * lap - 5.0, 2.0 * lap + 5.0) == pytest.approx(2.0 * lap + 1.0)
    assert circle.project(p.x, p.y, -5.0, 5.0) == pytest.approx(1.0)
    assert circle.project(p.x, p.y, 3.0, 4.0) == pytest.approx(3.0)
    q = circle.at(lap - 0.5)
    assert circle.project(q.x, q.y, 3.0 * lap - 2.0, 3.0 * lap + 2.0) == pytest.approx(3.0 * lap - 0.5)
    assert 0.0 <= circle.project(circle.at(0.0).x, circle.at(0.0).y) < lap


@given(st.floats(0.0, 1.0), st.floats(-math.pi, math.pi), st.floats(-500.0, 500.0), st.floats(-500.0, 500.0))
@settings(deadline=None, derandomize=True, max_examples=40)
def test_turning_and_moving_the_points_turns_and_moves_the_path(share: float, turn: float, n: float, e: float) -> None:
    c, s = math.cos(turn), math.sin(turn)
    moved = paths.through([(n + c * x - s * y, e + s * x + c * y) for x, y in LOOP], closed=True)
    here, there = PATHS["loop"].at(share * PATHS["loop"].length), moved.at(share * moved.length)
    assert moved.length == pytest.approx(PATHS["loop"].length, rel=1e-3)
    at = (n + c * here.x - s * here.y, e + s * here.x + c * here.y)
    assert (there.x, there.y) == pytest.approx(at, abs=0.02)


def test_a_mirrored_path_bends_the_other_way() -> None:
    mirrored = paths.through([(x, -y) for x, y in ZIGZAG])
    for s in abscissae(mirrored, 50)[:50]:
        a, b = PATHS["spline"].at(s), mirrored.at(s)
        assert (b.x, b.y, b.tx, b.ty, b.c) == pytest.approx((a.x, -a.y, a.tx, -a.ty, -a.c), abs=1e-9)


@pytest.mark.parametrize("count", [1, 2, 1000])
def test_a_lane_of_cells_gets_the_bits_of_a_boat(count: int) -> None:
    rows = [(path, s) for path in PATHS.values() for s in abscissae(path, 100)][:count]
    cells = [path.cells[path.index(s)] for path, s in rows]
    names = Cell.__struct_fields__
    lanes = Cell(*(np.array([getattr(cell, name) for cell in cells]) for name in names))
    batch = evaluate(lanes, (np.array([s for _, s in rows]) - lanes.s0) * lanes.per_m)
    alone = [path.at(s) for path, s in rows]
    for name in batch.__struct_fields__:
        assert getattr(batch, name).tolist() == [getattr(p, name) for p in alone]


def test_points_of_a_path_are_plain_floats() -> None:
    for path in PATHS.values():
        for s in (-3.0, 0.0, 1.0, path.length + 3.0):
            p = path.at(s)
            assert all(type(v) is float for v in (p.x, p.y, p.tx, p.ty, p.c, path.straight(s), path.project(p.x, p.y)))
