"""The wingman's laws: by hand, on curves against the printed ones, mirrored, as lanes of a batch."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from fleet.coordination import Leader, cvt_speed, wingman_speed
from fleet.paths import PathPoint, sine, straight

NORTH: Leader[float] = Leader(good=1.0, stopped=0.0, x=0.0, y=0.0, tx=1.0, ty=0.0, c=0.0, U=1.0, room=0.0, slope=0.0)


def at(x: float, y: float, course_deg: float = 0.0) -> PathPoint[float]:
    chi = math.radians(course_deg)
    return PathPoint(x, y, math.cos(chi), math.sin(chi), 0.0)


def test_abeam_on_a_parallel_path_it_goes_as_fast_as_the_leader() -> None:
    assert cvt_speed(at(0.0, 10.0), NORTH) == 1.0


def test_on_a_path_60_degrees_off_it_must_go_twice_as_fast() -> None:
    assert cvt_speed(at(0.0, 10.0, 60.0), NORTH) == pytest.approx(2.0)


def test_a_metre_ahead_it_goes_half_a_metre_a_second_slower() -> None:
    assert cvt_speed(at(1.0, 10.0), NORTH) == pytest.approx(0.5)
    assert cvt_speed(at(-1.0, 10.0), NORTH) == pytest.approx(1.5)


def test_inside_the_leaders_bend_of_20_m_it_goes_three_quarters() -> None:
    assert cvt_speed(at(0.0, 5.0), structs.replace(NORTH, c=1.0 / 20.0)) == pytest.approx(0.75)


def test_eight_metres_behind_on_purpose_is_its_place() -> None:
    assert cvt_speed(at(-8.0, 3.0), structs.replace(NORTH, room=-8.0)) == 1.0


def test_while_it_falls_back_half_a_metre_a_metre_it_goes_two_thirds() -> None:
    falling = structs.replace(NORTH, room=-4.0, slope=-0.5)
    assert cvt_speed(at(-4.0, 5.0), falling) == pytest.approx(1.0 / 1.5)


def test_a_path_across_the_leaders_does_not_divide_by_nothing() -> None:
    assert cvt_speed(at(0.0, 10.0, 90.0), NORTH) == pytest.approx(1.0 / 0.3)


def test_in_its_place_the_wingman_goes_as_fast_as_its_cvt() -> None:
    assert wingman_speed(1.2, 0.0, 100.0, 0.5, 2.5) == 1.2


def test_behind_its_place_it_goes_up_to_06_faster_within_its_limits() -> None:
    assert wingman_speed(1.0, 50.0, 100.0, 0.5, 2.5) == pytest.approx(1.6, abs=1e-6)
    assert wingman_speed(1.0, 50.0, 100.0, 0.5, 1.4) == 1.4
    assert wingman_speed(0.6, -50.0, 100.0, 0.5, 1.4) == 0.5


def test_for_five_seconds_after_keeping_clear_it_does_not_catch_up_but_it_does_fall_back() -> None:
    assert wingman_speed(1.0, 5.0, 4.9, 0.5, 2.5) == 1.0
    assert wingman_speed(1.0, 5.0, 5.0, 0.5, 2.5) > 1.3
    assert wingman_speed(1.0, -5.0, 4.9, 0.5, 2.5) < 0.7


def beside(law: Any, seconds: float = 200.0, dt: float = 0.1) -> list[float]:
    """How far the CVT on a sine is ahead of abeam of a leader on a line, from 20 s on [m]."""
    path, line = sine((0.0, 10.0), (400.0, 10.0), 10.0, 80.0), straight((0.0, 0.0), (400.0, 0.0))
    s1, s2, ahead = 20.0, 20.0, []
    for k in range(int(seconds / dt)):
        p = line.at(s1)
        s2 += dt * law(path.at(s2), structs.replace(NORTH, x=p.x, y=p.y))
        s1 += dt
        if k * dt > 20.0:
            ahead.append(path.at(s2).x - line.at(s1).x)
    return ahead


def test_on_a_sine_the_exact_feed_forward_stays_abeam() -> None:
    assert max(map(abs, beside(cvt_speed))) < 0.03  # 0.94 m as printed; what is left is the time step


def test_the_printed_feed_forward_does_not() -> None:
    def printed(cvt: PathPoint[float], leader: Leader[float]) -> float:
        return leader.U * (leader.tx * cvt.tx + leader.ty * cvt.ty) - 0.5 * (cvt.x - leader.x)

    assert max(map(abs, beside(printed))) > 0.5


metres = st.floats(-30.0, 30.0)
courses = st.floats(-60.0, 60.0)


@given(metres, metres, courses, st.floats(-0.05, 0.05))
def test_port_and_starboard_are_mirror_images(x: float, y: float, course: float, c: float) -> None:
    right = cvt_speed(at(x, y, course), structs.replace(NORTH, c=c))
    left = cvt_speed(at(x, -y, -course), structs.replace(NORTH, c=-c))
    assert right == pytest.approx(left, rel=1e-12, abs=1e-12)


@given(st.lists(st.tuples(metres, metres, courses, metres, st.floats(0.0, 10.0)), min_size=1, max_size=6))
def test_lanes_get_what_each_boat_gets_alone(rows: list[tuple[float, float, float, float, float]]) -> None:
    alone = [wingman_speed(cvt_speed(at(x, y, chi), NORTH), e, calm, 0.5, 2.5) for x, y, chi, e, calm in rows]
    points = [at(x, y, chi) for x, y, chi, _, _ in rows]
    together = PathPoint(*(np.array([getattr(p, name) for p in points]) for name in PathPoint.__struct_fields__))
    leader = Leader(*(np.full(len(rows), value) for value in structs.astuple(NORTH)))
    e, calm = (np.array([row[i] for row in rows]) for i in (3, 4))
    limits = np.full(len(rows), 0.5), np.full(len(rows), 2.5)
    assert wingman_speed(cvt_speed(together, leader), e, calm, *limits).tolist() == alone
