"""Path-following: signs by hand, laws that always hold, and the bands of the published experiment."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet import ops
from fleet.guidance import Follow, FollowParams, Limits, course_over_ground, follow
from fleet.hulls import CALM, HULLS, STEP_S, HullState, Water
from fleet.paths import Path, PathPoint, arc, sine, straight

PARAMS, LIMITS = FollowParams(), Limits()
NORTH: PathPoint[float] = PathPoint(0.0, 0.0, 1.0, 0.0, 0.0)
TICK_S = 0.1
metres, angles, speeds = st.floats(-60.0, 60.0), st.floats(-math.pi, math.pi), st.floats(0.0, 2.0)
bends = st.floats(-0.2, 0.2)


def sail(
    hull: str,
    path: Path,
    boat: HullState[float],
    u_d: float,
    seconds: float,
    water: Water[float] = CALM,
    s: float = 0.0,
) -> list[tuple[float, HullState[float], Follow[float]]]:
    """Time, boat and what path-following wanted, tick by tick."""
    model, seen = HULLS[hull], []
    for tick in range(round(seconds / TICK_S)):
        chi, speed = course_over_ground(*model.velocity(boat, water), boat.psi)
        f = follow(boat.x, boat.y, chi, speed, path.at(s), PARAMS)
        seen.append((tick * TICK_S, boat, f))
        s += TICK_S * f.s_dot
        for _ in range(round(TICK_S / STEP_S)):
            boat = model.advance(boat, u_d, f.r_d, water, LIMITS, STEP_S)
    return seen


def test_on_the_path_and_along_it_nothing_is_wanted() -> None:
    f = follow(0.0, 0.0, 0.0, 1.0, NORTH, PARAMS)
    assert (f.s1, f.y1, f.r_d, f.beta, f.s_dot) == (0.0, 0.0, 0.0, 0.0, 1.0)
    assert (f.gx, f.gy) == (1.0, 0.0)


def test_a_boat_to_starboard_of_its_path_turns_to_port() -> None:
    f = follow(0.0, 4.0, 0.0, 1.0, NORTH, PARAMS)
    assert f.y1 == f.y_e == 4.0
    assert f.gy < 0.0
    assert f.r_d == pytest.approx(-0.8 * 1.05 * math.tanh(0.8))


def test_far_off_the_course_wanted_is_the_approach_angle() -> None:
    f = follow(0.0, 100.0, 0.0, 1.0, NORTH, PARAMS)
    assert math.atan2(f.gy, f.gx) == pytest.approx(-1.05)


def test_a_target_ahead_waits_and_one_behind_hurries() -> None:
    assert follow(-0.6, 0.0, 0.0, 1.0, NORTH, PARAMS).s_dot == pytest.approx(0.4)
    assert follow(2.0, 0.0, 0.0, 1.0, NORTH, PARAMS).s_dot == pytest.approx(3.0)
    assert follow(200.0, 0.0, 0.0, 1.0, NORTH, PARAMS).s_dot == PARAMS.s_dot_max_mps
    assert follow(-200.0, 0.0, 0.0, 1.0, NORTH, PARAMS).s_dot == -PARAMS.s_dot_max_mps


def test_on_a_bend_the_yaw_rate_is_speed_times_curvature() -> None:
    bend: PathPoint[float] = PathPoint(0.0, 0.0, 1.0, 0.0, 0.05)
    assert follow(0.0, 0.0, 0.0, 1.2, bend, PARAMS).r_d == pytest.approx(0.06)


def test_the_yaw_rate_holds_the_derivative_of_the_approach_angle() -> None:
    y, chi, h = 3.0, -0.3, 1e-6
    f = follow(0.0, y, chi, 1.0, NORTH, PARAMS)

    def phi(offset: float) -> float:
        return -1.05 * math.tanh(0.2 * offset)

    phi_dot = (phi(y + h * math.sin(chi)) - phi(y - h * math.sin(chi))) / (2.0 * h)
    assert f.r_d == pytest.approx(phi_dot - 0.8 * (chi - phi(y)), abs=1e-8)


@given(metres, metres, angles, speeds, bends)
@settings(deadline=None, derandomize=True)
def test_port_mirrors_starboard(x: float, y: float, chi: float, speed: float, bend: float) -> None:
    a = follow(x, y, chi, speed, PathPoint(1.0, 2.0, 0.6, 0.8, bend), PARAMS)
    b = follow(x, -y, -chi, speed, PathPoint(1.0, -2.0, 0.6, -0.8, -bend), PARAMS)
    assert (b.s1, b.y1, b.s_dot, b.gx, b.gy) == pytest.approx((a.s1, -a.y1, a.s_dot, a.gx, -a.gy), abs=1e-9)
    if abs(abs(ops.wrap(a.beta - math.atan2(a.gy, a.gx) + math.atan2(0.8, 0.6))) - math.pi) > 1e-6:  # no side there
        assert b.r_d == pytest.approx(-a.r_d, abs=1e-9)


@given(metres, metres, angles, speeds, bends, angles)
@settings(deadline=None, derandomize=True)
def test_turning_the_whole_scene_changes_nothing_but_the_course_wanted(
    x: float, y: float, chi: float, speed: float, bend: float, turn: float
) -> None:
    c, s = math.cos(turn), math.sin(turn)
    a = follow(x, y, chi, speed, PathPoint(0.0, 0.0, 1.0, 0.0, bend), PARAMS)
    b = follow(c * x - s * y, s * x + c * y, ops.wrap(chi + turn), speed, PathPoint(0.0, 0.0, c, s, bend), PARAMS)
    assert (b.s1, b.y1, b.s_dot) == pytest.approx((a.s1, a.y1, a.s_dot), abs=1e-9)
    assert (b.gx, b.gy) == pytest.approx((c * a.gx - s * a.gy, s * a.gx + c * a.gy), abs=1e-9)
    if abs(abs(ops.wrap(chi - math.atan2(a.gy, a.gx))) - math.pi) > 1e-6:
        assert b.r_d == pytest.approx(a.r_d, abs=1e-9)


@pytest.mark.parametrize("count", [1, 2, 1000])
def test_a_lane_gets_the_bits_of_a_boat(count: int) -> None:
    rng = np.random.default_rng(1)
    x, y, chi, speed, px, py, along, c = (rng.uniform(-3.0, 3.0, count) for _ in range(8))
    tx, ty = np.cos(along), np.sin(along)
    batch = follow(x, y, chi, speed, PathPoint(px, py, tx, ty, c), PARAMS)
    rows = zip(*(v.tolist() for v in (x, y, chi, speed, px, py, tx, ty, c)), strict=True)
    alone = [follow(*row[:4], PathPoint(*row[4:]), PARAMS) for row in rows]
    for name in Follow.__struct_fields__:
        assert getattr(batch, name).tolist() == [getattr(f, name) for f in alone]
        assert all(type(getattr(f, name)) is float for f in alone)
    chis, speeds_ = course_over_ground(x, y, chi)
    pairs = [course_over_ground(*row) for row in zip(x.tolist(), y.tolist(), chi.tolist(), strict=True)]
    assert list(zip(chis.tolist(), speeds_.tolist(), strict=True)) == pairs


def test_a_boat_that_hardly_moves_has_its_heading_for_a_course() -> None:
    assert course_over_ground(0.0, 0.049, 0.3) == (0.3, 0.049)
    assert course_over_ground(0.0, 0.05, 0.3) == (pytest.approx(math.pi / 2), 0.05)
    assert course_over_ground(0.0, 0.0, -2.0) == (-2.0, 0.0)


@pytest.mark.parametrize("hull", HULLS)
@pytest.mark.parametrize("side", [8.0, -8.0])
def test_from_8_m_off_a_straight_path_the_boat_is_on_it_in_27_s_without_overshoot(hull: str, side: float) -> None:
    seen = sail(hull, straight((0.0, 0.0), (400.0, 0.0)), HULLS[hull].start(0.0, side, 0.0, 1.0), 1.0, 60.0)
    assert min(f.y1 * math.copysign(1.0, side) for _, _, f in seen) >= -0.1
    assert max(t for t, _, f in seen if abs(f.y1) >= 0.1) <= 27.0


@pytest.mark.parametrize("hull", HULLS)
def test_a_cross_current_leaves_no_error(hull: str) -> None:
    boat = HULLS[hull].start(0.0, 0.0, 0.0, 1.0)
    _, boat, f = sail(hull, straight((0.0, 0.0), (400.0, 0.0)), boat, 1.0, 120.0, Water(0.0, 0.3, 0.0, 0.0))[-1]
    assert abs(f.y1) < 0.005
    assert boat.psi < -0.2


@pytest.mark.parametrize("heading", [-3.0, -1.5, 0.0, 1.5])
def test_from_the_centre_of_a_circle_the_boat_finds_it(heading: float) -> None:
    seen = sail(
        "unicycle",
        arc((0.0, 0.0), 15.0, 0.0, 2.0 * math.pi),
        HULLS["unicycle"].start(0.0, 0.0, heading, 1.0),
        1.0,
        60.0,
    )
    assert max(abs(f.s_dot) for _, _, f in seen) <= 5.5
    assert max(t for t, _, f in seen if abs(f.y1) > 0.3) < 30.0
    assert math.hypot(seen[-1][1].x, seen[-1][1].y) == pytest.approx(15.0, abs=0.01)


def test_a_sine_is_followed_within_two_decimetres() -> None:
    path = sine((0.0, 0.0), (300.0, 0.0), 10.0, 80.0)
    p = path.at(0.0)
    seen = sail("unicycle", path, HULLS["unicycle"].start(0.0, 0.0, math.atan2(p.ty, p.tx), 1.0), 1.0, 200.0)
    assert max(abs(f.y1) for _, _, f in seen) < 0.2


@pytest.mark.parametrize(
    "wrong", [b'{"k1_per_s": 0.0}', b'{"psi_a_rad": 1.6}', b'{"s_dot_max_mps": 1.0}', b'{"k": 1.0}']
)
def test_tuning_that_cannot_work_is_refused(wrong: bytes) -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.json.decode(wrong, type=FollowParams)
