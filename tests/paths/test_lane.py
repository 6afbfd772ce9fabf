"""Lanes: parallel curves with the abscissa of the path beside them, and changes from one to another."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.paths import Lane, Path, PathPoint, Shift, arc, lane, polyline, shift_length, straight
from fleet.paths.lane import beside, stretch

LINE = straight((0.0, 0.0), (100.0, 0.0))
ARC = arc((0.0, 0.0), 20.0, 0.0, math.pi)  # clockwise: bends to starboard
LANES = polyline([(0.0, 0.0), (120.0, 0.0), (120.0, 50.0), (0.0, 50.0)], 20.0)
RING = arc((0.0, 0.0), 30.0, 0.0, 2.0 * math.pi)


def test_a_lane_beside_a_line_is_the_line_moved_to_starboard() -> None:
    p = Lane(LINE, 8.0).at(30.0)
    assert (p.x, p.y, p.tx, p.ty, p.c) == (30.0, 8.0, 1.0, 0.0, 0.0)


def test_inside_a_bend_of_20_m_the_lane_at_5_m_has_15_m_and_three_quarters_of_the_way() -> None:
    inner = Lane(ARC, 5.0)
    p = inner.at(10.0)
    assert math.hypot(p.x, p.y) == pytest.approx(15.0, rel=1e-5)
    assert p.c == pytest.approx(1.0 / 15.0, rel=1e-3)
    assert inner.stretch(10.0) == pytest.approx(0.75, rel=1e-3)


def test_no_lane_is_the_path_itself() -> None:
    assert lane(LANES, 0.0) is LANES


def test_half_way_through_a_change_the_boat_is_half_way_over() -> None:
    over = Lane(LINE, 10.0, Shift(20.0, 60.0, -10.0, 0.0))
    assert [over.offset(s)[0] for s in (10.0, 20.0, 50.0, 80.0, 90.0)] == [-10.0, -10.0, 0.0, 10.0, 10.0]
    assert over.straight(50.0) == 0.0
    assert over.straight(85.0) == pytest.approx(LINE.straight(85.0))


def test_a_change_that_is_changed_on_the_way_goes_on_without_a_kink() -> None:
    first = Lane(LINE, 10.0, Shift(0.0, 60.0, 0.0, 0.0))
    n, slope, _ = first.offset(30.0)
    second = Lane(LINE, -10.0, Shift(30.0, 60.0, n, slope))
    a, b = first.at(30.0), second.at(30.0 + 1e-9)
    assert (a.x, a.y, a.tx, a.ty) == pytest.approx((b.x, b.y, b.tx, b.ty), abs=1e-6)


def test_a_change_is_never_steeper_than_20_degrees_nor_tighter_than_twice_the_radius() -> None:
    for n in (0.5, 5.0, 24.0):
        length = shift_length(n, 4.3)
        over = Lane(LINE, n, Shift(0.0, length, 0.0, 0.0))
        points = [over.at(length * i / 200.0) for i in range(201)]
        assert max(abs(math.atan2(p.ty, p.tx)) for p in points) <= math.radians(20.0)
        assert max(abs(p.c) for p in points) <= 0.5 / 4.3 + 1e-9


paths = st.sampled_from([LINE, ARC, LANES, RING])
offsets_m = st.floats(-12.0, 12.0)
shares = st.floats(0.01, 0.99)


@given(paths, offsets_m, shares)
def test_a_metre_of_abscissa_is_so_many_metres_of_the_lane(path: Path, n: float, share: float) -> None:
    own, s, h = Lane(path, n), share * path.length, 1e-4
    a, b = own.at(s), own.at(s + h)
    assert math.dist((a.x, a.y), (b.x, b.y)) / h == pytest.approx(own.stretch(s), abs=5e-2)


@given(paths, offsets_m, shares)
def test_a_point_of_the_lane_is_found_again(path: Path, n: float, share: float) -> None:
    own, s = Lane(path, n), share * path.length
    p = own.at(s)
    assert own.project(p.x, p.y) == pytest.approx(s, abs=1e-3)  # also across the start of a ring
    assert own.project(p.x, p.y, s - 5.0, s + 5.0) == pytest.approx(s, abs=1e-3)


@given(offsets_m, shares)
def test_port_and_starboard_are_mirror_images(n: float, share: float) -> None:
    mirrored = polyline([(0.0, 0.0), (120.0, 0.0), (120.0, -50.0), (0.0, -50.0)], 20.0)
    p, q = Lane(LANES, n).at(share * LANES.length), Lane(mirrored, -n).at(share * LANES.length)
    assert (p.x, p.y, p.tx, p.ty, p.c) == pytest.approx((q.x, -q.y, q.tx, -q.ty, -q.c), abs=1e-9)


@given(paths, offsets_m, st.floats(-8.0, 8.0), shares)
def test_while_changing_lanes_the_tangent_is_that_of_the_curve(path: Path, n: float, to: float, share: float) -> None:
    over = Lane(path, to, Shift(0.2 * path.length, 0.5 * path.length, n, 0.0))
    s, h = share * path.length, 1e-5
    a, b = over.at(s - h), over.at(s + h)
    p, long = over.at(s), math.dist((a.x, a.y), (b.x, b.y))
    if long > 0.5 * h:
        assert ((b.x - a.x) / long, (b.y - a.y) / long) == pytest.approx((p.tx, p.ty), abs=2e-2)


@given(st.lists(st.tuples(offsets_m, st.floats(-0.5, 0.5), st.floats(-0.05, 0.05), shares), min_size=1, max_size=5))
def test_lanes_of_a_batch_get_what_each_boat_gets_alone(rows: list[tuple[float, float, float, float]]) -> None:
    points = [LANES.at(share * LANES.length) for _, _, _, share in rows]
    alone = [beside(p, n, slope, bend) for p, (n, slope, bend, _) in zip(points, rows, strict=True)]
    names = PathPoint.__struct_fields__
    together = PathPoint(*(np.array([getattr(p, name) for p in points]) for name in names))
    n, slope, bend = (np.array([row[i] for row in rows]) for i in range(3))
    lanes = beside(together, n, slope, bend)
    assert [getattr(lanes, name).tolist() for name in names] == [[getattr(p, name) for p in alone] for name in names]
    ways = [stretch(p.c, row[0], row[1]) for p, row in zip(points, rows, strict=True)]
    assert stretch(together.c, n, slope).tolist() == ways


@given(st.sampled_from([LINE, ARC]), st.floats(-8.0, 8.0), st.floats(-8.0, 8.0), st.floats(0.25, 0.65))
def test_while_changing_lanes_the_curvature_is_how_the_tangent_turns(
    path: Path, n: float, to: float, share: float
) -> None:
    over = Lane(path, to, Shift(0.2 * path.length, 0.5 * path.length, n, 0.0))
    s, h = share * path.length, 1e-3
    a, b, p = over.at(s - h), over.at(s + h), over.at(s)
    turn = math.asin(a.tx * b.ty - a.ty * b.tx)
    assert turn / (2.0 * h * over.stretch(s)) == pytest.approx(p.c, abs=2e-3)
