"""Banks: a course that leads to one turns parallel in time."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.avoidance.foreign.banks import ashore, bend, off_shore, within
from fleet.avoidance.foreign.domain import gap
from fleet.avoidance.foreign.rollout import holding, motion

from .scenes import P, boat

BANK = (-500.0, 15.0, 500.0, 15.0)


def test_a_course_along_or_off_the_bank_is_left_alone() -> None:
    for cx, cy in ((1.0, 0.0), (0.0, -1.0)):
        found = bend(0.0, 14.0, cx, cy, cx, cy, 1.0, 0.35, (BANK,), P)
        assert (found.bent, found.cx, found.cy) == (0.0, cx, cy)


def test_a_course_across_turns_within_its_turning_circle_and_the_margin() -> None:
    room = 2.0 + 0.6 + 1.0 / 0.35  # g = 90 deg at 1 m/s
    assert bend(0.0, 15.0 - room - 0.01, 0.0, 1.0, 0.0, 1.0, 1.0, 0.35, (BANK,), P).bent == 0.0
    found = bend(0.0, 15.0 - room + 0.01, 0.1, math.sqrt(0.99), 0.1, math.sqrt(0.99), 1.0, 0.35, (BANK,), P)
    assert found.bent == 0.0 or (found.cx, found.cy) == (1.0, 0.0)
    near = bend(0.0, 12.0, 0.1, math.sqrt(0.99), 0.1, math.sqrt(0.99), 1.0, 0.35, (BANK,), P)
    assert (near.bent, near.cx, near.cy, near.free) == (1.0, 1.0, 0.0, 1.0)


@pytest.mark.parametrize("course", [30.0, 89.0, 90.0, 91.0, 150.0])
def test_a_boat_that_goes_along_the_bank_does_not_turn_through_it(course: float) -> None:
    cx, cy = math.cos(math.radians(course)), math.sin(math.radians(course))
    back, on = (bend(0.0, 12.9, cx, cy, hx, 0.0, 1.0, 0.35, (BANK,), P) for hx in (-1.0, 1.0))
    assert (back.bent, back.cx, back.cy) == (1.0, -1.0, 0.0)
    assert (on.bent, on.cx, on.cy) == (1.0, 1.0, 0.0)


def test_nearer_than_two_metres_parallel_is_off_the_edge() -> None:
    near, ashore_almost = (
        bend(0.0, y, 0.1, math.sqrt(0.99), 1.0, 0.0, 1.0, 0.35, (BANK,), P) for y in (14.0, 14.9999999)
    )
    assert math.atan2(near.cy, near.cx) == pytest.approx(-math.atan(0.5))
    assert math.atan2(ashore_almost.cy, ashore_almost.cx) == pytest.approx(-math.pi / 4, abs=1e-6)


@pytest.mark.parametrize(("course", "way"), [(88.0, 1.0), (92.0, -1.0)])
def test_a_course_square_to_the_bank_turns_the_way_in_which_the_boat_already_turns(course: float, way: float) -> None:
    hx, hy = math.cos(math.radians(course)), math.sin(math.radians(course))
    for cx in (-1.0e-16, 0.0, 1.0e-16):
        assert bend(0.0, 12.0, cx, 1.0, hx, hy, 1.0, 0.35, (BANK,), P).cx == way


def test_the_way_round_that_leads_off_the_nearest_bank() -> None:
    west = (-500.0, -4.0, 500.0, -4.0)
    assert off_shore(0.0, 8.0, 0.0, (BANK,), 9.0) == -1.0  # it lies to starboard
    assert off_shore(0.0, 8.0, math.pi, (BANK,), 9.0) == 1.0
    assert off_shore(0.0, 0.0, 0.0, (BANK, west), 20.0) == 1.0  # the nearer one lies to port
    assert off_shore(0.0, 0.0, 0.0, (BANK,), 9.0) == 0.0


def test_in_a_corner_the_boat_stops() -> None:
    corner = (BANK, (3.0, -50.0, 3.0, 15.0))
    found = bend(0.0, 12.0, 0.1, math.sqrt(0.99), 0.1, math.sqrt(0.99), 1.0, 0.35, corner, P)
    assert (found.bent, found.free) == (1.0, 0.0)


def test_two_edges_in_line_are_no_corner() -> None:
    line = ((-500.0, 15.0, 5.0, 15.0), (5.0, 15.0, 500.0, 15.0))
    found = bend(0.0, 12.0, 0.1, math.sqrt(0.99), 0.1, math.sqrt(0.99), 1.0, 0.35, line, P)
    assert (found.bent, found.free) == (1.0, 1.0)


@given(st.floats(0.1, 3.0), st.floats(0.4, 1.5))
def test_no_course_leads_over_the_bank(course: float, u: float) -> None:
    way = holding(motion(boat(cruise=u)), course, math.cos(course), math.sin(course), u, (BANK,), 60.0, P)
    assert max(way.y) < 15.0 - 1.0


def test_a_leg_over_an_edge_or_near_its_end_is_ashore() -> None:
    assert ashore(0.0, 10.0, 0.0, 20.0, (BANK,), 1.0) == 1.0
    assert ashore(0.0, 10.0, 0.0, 13.9, (BANK,), 1.0) == 0.0
    assert ashore(500.5, 0.0, 500.5, 30.0, (BANK,), 1.0) == 1.0
    assert ashore(501.5, 0.0, 501.5, 30.0, (BANK,), 1.0) == 0.0


@given(st.lists(st.tuples(*[st.floats(-520.0, 520.0).map(lambda m: round(m, 3))] * 4), min_size=1, max_size=20))
def test_legs_that_are_not_measured_are_not_ashore(legs: list[tuple[float, float, float, float]]) -> None:
    x0, y0, x1, y1 = np.array(legs).T
    d, _ = gap(x0 + 500.0, y0 - 15.0, x1 + 500.0, y1 - 15.0, 0.0, 1000.0)
    expected = (d < 4.0).astype(float).tolist()
    assert ashore(x0, y0, x1, y1, (BANK,), 4.0).tolist() == expected
    assert [ashore(*leg, (BANK,), 4.0) for leg in legs] == expected


def test_edges_far_off_or_without_length_are_left_out() -> None:
    assert within((BANK, (0.0, 3.0, 0.0, 3.0), (0.0, 30.0, 9.0, 30.0)), 0.0, 0.0, 20.0) == (BANK,)


def test_lanes_bend_as_boats_alone() -> None:
    y, angle = np.linspace(0.0, 14.9, 40), np.linspace(0.0, 6.0, 40)
    cx, cy = np.cos(angle), np.sin(angle)
    edges = (BANK, (3.0, -50.0, 3.0, 15.0))
    r_max = np.full(40, 0.35)
    lanes = bend(0.0 * y, y, cx, cy, -cy, cx, 0.0 * y + 1.2, r_max, edges, P)
    for k in range(40):
        alone = bend(0.0, float(y[k]), float(cx[k]), float(cy[k]), -float(cy[k]), float(cx[k]), 1.2, 0.35, edges, P)
        assert (alone.cx, alone.cy, alone.bent, alone.free) == pytest.approx(
            (lanes.cx[k], lanes.cy[k], lanes.bent[k], lanes.free[k]), abs=0.0
        )
