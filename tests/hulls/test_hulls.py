"""Hulls: every one obeys its set-points over ground, drifts without power, and gives lanes the bits of a boat."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet.guidance import Limits
from fleet.hulls import CALM, HULLS, STEP_S, HullState, Water, three_dof

LIMITS = Limits()
every_hull = pytest.mark.parametrize("name", HULLS)


def sail(
    name: str,
    boat: HullState[float],
    u_d: float,
    r_d: float,
    seconds: float,
    water: Water[float] = CALM,
    powered: float = 1.0,
) -> HullState[float]:
    for _ in range(round(seconds / STEP_S)):
        boat = HULLS[name].advance(boat, u_d, r_d, water, LIMITS, STEP_S, powered)
    return boat


@every_hull
def test_a_hull_reaches_top_speed_and_sails_straight(name: str) -> None:
    boat = sail(name, HULLS[name].start(0.0, 0.0, 0.5, 0.0), 1.5, 0.0, 60.0)
    assert boat.u == pytest.approx(1.5, abs=0.01)
    assert boat.psi == pytest.approx(0.5)
    assert math.atan2(boat.y, boat.x) == pytest.approx(0.5)
    assert 75.0 < math.hypot(boat.x, boat.y) < 90.0


@every_hull
def test_a_positive_yaw_rate_turns_to_starboard_at_the_rate_asked(name: str) -> None:
    boat = sail(name, HULLS[name].start(0.0, 0.0, 0.0, 1.0), 1.0, 0.2, 5.0)
    assert boat.psi > 0.5
    assert boat.y > 0.0
    assert sail(name, boat, 1.0, 0.2, 20.0).r == pytest.approx(0.2, abs=0.002)


@every_hull
def test_set_points_beyond_the_limits_are_held_within_them(name: str) -> None:
    boat = sail(name, HULLS[name].start(0.0, 0.0, 0.0, 0.0), 9.0, 0.0, 60.0)
    assert boat.u == pytest.approx(LIMITS.speed_max_mps, abs=0.01)
    assert abs(sail(name, boat, 1.0, -5.0, 20.0).r) <= LIMITS.yaw_rate_max_radps + 1e-3


@every_hull
def test_speed_grows_no_faster_than_the_limit(name: str) -> None:
    boat = HULLS[name].start(0.0, 0.0, 0.0, 0.0)
    for _ in range(200):
        after = HULLS[name].advance(boat, 1.5, 0.0, CALM, LIMITS, STEP_S)
        assert after.u - boat.u <= LIMITS.acceleration_max_mps2 * STEP_S * 1.02
        boat = after


@every_hull
@pytest.mark.parametrize("water", [Water(-0.4, 0.0, 0.0, 0.0), Water(0.3, 0.0, 0.1, 0.0)], ids=str)
def test_surge_is_over_ground_whatever_the_current_ahead_or_astern(name: str, water: Water[float]) -> None:
    boat = sail(name, HULLS[name].start(0.0, 0.0, 0.0, 1.0), 1.0, 0.0, 60.0, water)
    assert HULLS[name].velocity(boat, water) == pytest.approx((1.0, 0.0), abs=0.005)


@every_hull
def test_current_and_leeway_abeam_set_the_boat_down(name: str) -> None:
    water = Water(0.0, 0.2, 0.0, 0.1)
    boat = sail(name, HULLS[name].start(0.0, 0.0, 0.0, 1.0), 1.0, 0.0, 60.0, water)
    assert HULLS[name].velocity(boat, water) == pytest.approx((1.0, 0.3), abs=0.02)
    assert boat.v == pytest.approx(0.3, abs=0.02)


@every_hull
def test_without_power_a_boat_coasts_to_rest_in_the_water_and_drifts_with_it(name: str) -> None:
    still = sail(name, HULLS[name].start(0.0, 0.0, 0.7, 1.5), 1.5, 0.3, 60.0, CALM, 0.0)
    assert HULLS[name].velocity(still, CALM) == pytest.approx((0.0, 0.0), abs=0.01)
    assert 1.0 < math.hypot(still.x, still.y) < 8.0
    water = Water(0.2, -0.3, 0.0, 0.1)
    adrift = sail(name, HULLS[name].start(0.0, 0.0, 0.7, 1.5), 1.5, 0.3, 120.0, water, 0.0)
    assert HULLS[name].velocity(adrift, water) == pytest.approx((0.2, -0.2), abs=0.01)
    assert abs(adrift.r) < 0.01


@every_hull
def test_power_that_comes_back_is_obeyed_again(name: str) -> None:
    water = Water(0.0, 0.3, 0.0, 0.0)
    boat = sail(name, HULLS[name].start(0.0, 0.0, 0.0, 1.0), 1.0, 0.0, 40.0, water, 0.0)
    assert sail(name, boat, 1.0, 0.0, 40.0, water).u == pytest.approx(1.0, abs=0.01)


@every_hull
def test_the_step_is_short_enough(name: str) -> None:
    coarse = fine = HULLS[name].start(0.0, 0.0, 0.0, 0.0)
    for _ in range(500):
        coarse = HULLS[name].advance(coarse, 1.2, 0.15, CALM, LIMITS, STEP_S)
    for _ in range(5000):
        fine = HULLS[name].advance(fine, 1.2, 0.15, CALM, LIMITS, STEP_S / 10.0)
    assert (coarse.x, coarse.y) == pytest.approx((fine.x, fine.y), abs=0.05)


@every_hull
def test_the_heading_stays_wrapped_through_many_turns(name: str) -> None:
    boat = HULLS[name].start(0.0, 0.0, 3.0, 1.0)
    for _ in range(3000):
        boat = HULLS[name].advance(boat, 1.0, 0.3, CALM, LIMITS, STEP_S)
        assert abs(boat.psi) <= math.nextafter(math.pi, 4.0)


@every_hull
@given(
    st.floats(-math.pi, math.pi), st.floats(0.0, 1.5), st.floats(-0.3, 0.3), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)
)
@settings(deadline=None, derandomize=True, max_examples=30)
def test_port_mirrors_starboard(name: str, psi: float, u_d: float, r_d: float, north: float, east: float) -> None:
    a = sail(name, HULLS[name].start(0.0, 0.0, psi, 1.0), u_d, r_d, 1.0, Water(north, east, 0.0, 0.0))
    b = sail(name, HULLS[name].start(0.0, 0.0, -psi, 1.0), u_d, -r_d, 1.0, Water(north, -east, 0.0, 0.0))
    assert (b.x, b.y, b.u, b.v, b.r) == pytest.approx((a.x, -a.y, a.u, -a.v, -a.r), abs=1e-9)


@every_hull
@pytest.mark.parametrize("count", [1, 2, 1000])
def test_a_lane_gets_the_bits_of_a_boat(name: str, count: int) -> None:
    rng = np.random.default_rng(3)
    fields = rng.uniform(-2.0, 2.0, (8, count))
    u_d, r_d = rng.uniform(-1.0, 2.0, count), rng.uniform(-0.5, 0.5, count)
    streams = rng.uniform(-0.5, 0.5, (4, count))
    powered = np.where(rng.random(count) < 0.7, 1.0, 0.0)
    batch, water = HullState(*fields), Water(*streams)
    boats = [HullState(*column) for column in fields.T.tolist()]
    waters = [Water(*column) for column in streams.T.tolist()]
    inputs = list(zip(u_d.tolist(), r_d.tolist(), waters, powered.tolist(), strict=True))
    for _ in range(20):
        batch = HULLS[name].advance(batch, u_d, r_d, water, LIMITS, STEP_S, powered)
        boats = [
            HULLS[name].advance(boat, u, r, w, LIMITS, STEP_S, p)
            for boat, (u, r, w, p) in zip(boats, inputs, strict=True)
        ]
    for field in HullState.__struct_fields__:
        assert getattr(batch, field).tolist() == [getattr(boat, field) for boat in boats]
        assert all(type(getattr(boat, field)) is float for boat in boats)
    vx, vy = HULLS[name].velocity(batch, water)
    assert list(zip(vx.tolist(), vy.tolist(), strict=True)) == [
        HULLS[name].velocity(boat, w) for boat, w in zip(boats, waters, strict=True)
    ]


@every_hull
@pytest.mark.parametrize("water", [CALM, Water(0.3, -0.2, 0.05, 0.0)])
@pytest.mark.parametrize("powered", [1.0, 0.0])
def test_several_steps_at_once_give_the_bits_of_one_after_the_other(
    name: str, water: Water[float], powered: float
) -> None:
    rng = np.random.default_rng(5)
    start = HullState(*rng.uniform(-3.1, 3.1, (8, 50)))
    u_d, r_d = rng.uniform(-1.0, 2.0, 50), rng.uniform(-0.5, 0.5, 50)
    singly = start
    for _ in range(7):
        singly = HULLS[name].advance(singly, u_d, r_d, water, LIMITS, STEP_S, powered)
    at_once = HULLS[name].advance_by(7, start, u_d, r_d, water, LIMITS, STEP_S, powered)
    for field in HullState.__struct_fields__:
        assert np.array_equal(getattr(at_once, field), getattr(singly, field)), field


@every_hull
def test_a_description_is_one_line(name: str) -> None:
    assert HULLS[name].description
    assert "\n" not in HULLS[name].description


def test_the_otter_at_full_thrust_makes_its_six_knots() -> None:
    u = 0.0
    for _ in range(5000):
        u += STEP_S * three_dof.accelerations(u, 0.0, 0.0, 24.4 * 9.81, 0.0)[0]
    assert u == pytest.approx(6.0 * 0.5144, rel=1e-6)


def test_the_inertia_of_the_otter_in_yaw_is_the_published_41_4() -> None:
    per_moment = three_dof.accelerations(0.0, 0.0, 0.0, 0.0, 1.0)[2]
    assert 1.0 / per_moment == pytest.approx(41.4 - 11.0 * 11.0 / 162.5, abs=0.1)  # sway free: M33 - M23^2 / M22


def test_the_propellers_serve_the_yaw_moment_first_and_never_push_a_stopped_boat_ahead() -> None:
    assert three_dof.propel(100.0, 10.0) == (100.0, 10.0)
    force, moment = three_dof.propel(240.0, 52.0)
    assert moment == 52.0
    assert 100.0 < force < 240.0
    assert three_dof.propel(0.0, 500.0)[0] == pytest.approx(0.0, abs=1e-9)
