"""Where a boat will be, and when that is too near."""

from __future__ import annotations

import math

import pytest

from fleet.avoidance.foreign import NEVER_S, Boat
from fleet.avoidance.foreign.domain import domain
from fleet.avoidance.foreign.rollout import entry, following, holding, left_to_turn, motion
from fleet.guidance import follow
from fleet.hulls import CALM, unicycle
from fleet.paths import Path, sine, straight

from .scenes import LIMITS, P, boat, meeting, target


def sailed(path: Path, x: float, y: float, chi: float, seconds: float) -> list[tuple[float, float]]:
    """The true way of a boat at 1 m/s, a point a second."""
    hull, s, points = unicycle.start(x, y, chi, 1.0), path.project(x, y), []
    for k in range(round(seconds * 50) + 1):
        if k % 50 == 0:
            points.append((hull.x, hull.y))
        f = follow(hull.x, hull.y, hull.psi, hull.u, path.at(s), P.follow)
        hull = unicycle.advance(hull, 1.0, f.r_d, CALM, LIMITS, 0.02)
        s += 0.02 * f.s_dot
    return points


@pytest.mark.parametrize(
    ("path", "x", "y", "chi", "within"),
    [
        (straight((0.0, 0.0), (500.0, 0.0)), 0.0, 0.0, 0.0, 1e-6),
        (straight((0.0, 0.0), (500.0, 0.0)), 10.0, 30.0, 1.0, 2.5),
        (straight((0.0, 0.0), (500.0, 0.0)), 10.0, -5.0, -0.5, 1.5),
        (sine((0.0, 0.0), (500.0, 0.0), 10.0, 120.0), 0.0, 0.0, 0.4, 2.5),
    ],
)
def test_the_way_along_the_path_is_the_one_that_is_sailed(
    path: Path, x: float, y: float, chi: float, within: float
) -> None:
    way = following(Boat(x, y, chi, 1.0, 0.0, path.project(x, y), 1.0, LIMITS, path), 60.0, P)
    truth = sailed(path, x, y, chi, 60.0)
    for t, wx, wy in zip(way.t, way.x, way.y, strict=True):
        if t == round(t):
            assert math.hypot(wx - truth[round(t)][0], wy - truth[round(t)][1]) <= within, t


def test_on_a_straight_path_two_seconds_are_one_step() -> None:
    way = following(boat(), 20.0, P)
    assert way.t == [2.0 * k for k in range(11)]
    assert way.y == [0.0] * 11


@pytest.mark.parametrize(
    ("chi", "course_deg", "sense", "left_deg"),
    [
        (0.0, 90.0, 0.0, 90.0),
        (0.0, 180.0, -1.0, -180.0),
        (0.0, 240.0, 1.0, 240.0),
        (math.radians(30.0), 240.0, 1.0, 210.0),
        (math.radians(245.0), 240.0, 1.0, -5.0),  # 5 deg too far: back, not round again
    ],
)
def test_a_named_turn_goes_the_named_way(chi: float, course_deg: float, sense: float, left_deg: float) -> None:
    c = math.radians(course_deg)
    assert math.degrees(left_to_turn(chi, math.cos(c), math.sin(c), sense)) == pytest.approx(left_deg)


def test_an_alteration_is_rolled_out_as_it_is_sailed() -> None:
    c = math.radians(60.0)
    way = holding(motion(boat()), c, math.cos(c), math.sin(c), 0.5, (), 30.0, P)
    hull = unicycle.start(0.0, 0.0, 0.0, 1.0)
    for _ in range(1500):
        hull = unicycle.advance(hull, 0.5, P.k1 * (c - hull.psi), CALM, LIMITS, 0.02)
    assert math.hypot(way.x[-1] - hull.x, way.y[-1] - hull.y) < 0.6
    assert way.t[-1] == 30.0


def test_entry_is_where_the_distance_becomes_the_clearance() -> None:
    """A stopped vessel of 20 m, 100 m ahead: C = 19.2 m, so we enter after 80.8 s at 1 m/s."""
    d = domain(target(100.0, 0.0), 1.0, 0.0, P)
    way = following(boat(), 100.0, P)
    assert entry(way, d, 100.0, 1.0, 1.0, 0.0) == pytest.approx(80.8, abs=1e-9)
    assert entry(way, d, 80.0, 1.0, 1.0, 0.0) == NEVER_S
    assert entry(way, d, 100.0, 1.1, 1.0, 0.0) == pytest.approx(100.0 - 1.1 * 19.2, abs=1e-9)


def test_nothing_slips_through_between_two_vertices() -> None:
    """At 9 m/s across the bow, in a way of 2 s steps."""
    d = domain(meeting(90.0, 9.0, 31.0, length=5.0), 1.0, 0.0, P)
    t = entry(following(boat(), 60.0, P), d, 60.0, 1.0, 1.0, 0.0)
    assert 28.0 < t < 31.0


def test_a_vessel_that_turns_is_feared_on_both_courses() -> None:
    passing = target(80.0, 30.0, 180.0, 3.0)
    turning = target(80.0, 30.0, 180.0, 3.0, om=0.1)
    way = following(boat(), 60.0, P)
    assert entry(way, domain(passing, 1.0, 0.0, P), 60.0, 1.0, 1.0, 0.0) == NEVER_S
    assert entry(way, domain(turning, 1.0, 0.0, P), 60.0, 1.0, 1.0, 0.0) < 30.0


def test_who_is_inside_already_is_given_four_seconds_to_open() -> None:
    d = domain(target(-14.0, 0.0), 1.0, 0.0, P)  # astern, C = 19.2: out after 5.2 s
    near = domain(target(-16.0, 0.0), 1.0, 0.0, P)  # out after 3.2 s
    way = holding(motion(boat()), 0.0, 1.0, 0.0, 1.0, (), 30.0, P)
    assert entry(way, d, 30.0, 1.0, 1.0, 0.0) == 0.0
    assert entry(way, d, 30.0, 1.0, 1.0, 4.0) < NEVER_S
    assert entry(way, near, 30.0, 1.0, 1.0, 4.0) == NEVER_S
