"""The catamaran with four thrusters: what its parts and its size say about how it moves."""

from __future__ import annotations

import math

import pytest

from fleet.guidance import Limits
from fleet.guidance.thrust import Thrusts, allocate, resultant, slew
from fleet.hulls import CALM, STEP_S, HullState, Water, catamaran
from fleet.hulls.catamaran import M11, M33, THRUSTERS

LIMITS = Limits()


def pushed(boat: HullState[float], thrusts: Thrusts[float], seconds: float) -> HullState[float]:
    surge, yaw = resultant(thrusts, THRUSTERS)
    for _ in range(round(seconds / STEP_S)):
        boat = catamaran.push(boat, surge, yaw, CALM, STEP_S)
    return boat


def sail(boat: HullState[float], u_d: float, r_d: float, seconds: float) -> HullState[float]:
    for _ in range(round(seconds / STEP_S)):
        boat = catamaran.advance(boat, u_d, r_d, CALM, LIMITS, STEP_S)
    return boat


def test_both_rear_thrusters_at_full_ahead_make_2_5_metres_a_second() -> None:
    top = pushed(catamaran.start(0.0, 0.0, 0.0, 0.0), Thrusts(133.0, 133.0, 0.0, 0.0), 60.0)
    assert top.u == pytest.approx(2.52, abs=0.01)  # 36 u^2 + 15 u = 266
    assert (top.v, top.r) == (0.0, 0.0)


def test_it_goes_astern_with_half_the_thrust() -> None:
    astern = pushed(catamaran.start(0.0, 0.0, 0.0, 0.0), Thrusts(-66.0, -66.0, 0.0, 0.0), 60.0)
    assert astern.u == pytest.approx(-1.72, abs=0.01)


def test_the_side_pair_turns_it_on_the_spot() -> None:
    boat = pushed(catamaran.start(0.0, 0.0, 0.0, 0.0), Thrusts(0.0, 0.0, 28.0, -28.0), 20.0)
    assert boat.r == pytest.approx(0.949, abs=0.005)  # 10 r^2 + 20 r = 28
    assert math.hypot(boat.x, boat.y) == 0.0


def test_the_side_pair_turns_it_tighter_than_the_printed_four_metres() -> None:
    boat = pushed(catamaran.start(0.0, 0.0, 0.0, 0.5), Thrusts(9.6, 9.6, 28.0, -28.0), 60.0)
    assert math.hypot(boat.u, boat.v) / boat.r < 1.0  # derived from size; the paper has 3.8 to 4.3 m at 0.55 m/s


def test_it_starts_with_the_thrust_that_keeps_its_speed() -> None:
    assert sail(catamaran.start(0.0, 0.0, 0.0, 1.2), 1.2, 0.0, 5.0).u == pytest.approx(1.2, abs=1e-6)


def test_speed_settles_without_overshoot_and_so_does_yaw_rate_within_a_twentieth() -> None:
    boat, fastest, quickest = catamaran.start(0.0, 0.0, 0.0, 0.0), 0.0, 0.0
    for _ in range(1000):
        boat = catamaran.advance(boat, 1.3, 0.3, CALM, LIMITS, STEP_S)
        fastest, quickest = max(fastest, boat.u), max(quickest, boat.r)
    assert boat.u == pytest.approx(1.3, abs=0.001)
    assert boat.r == pytest.approx(0.3, abs=0.001)
    assert fastest < 1.301
    assert quickest < 0.315


def test_asked_for_more_than_it_has_it_turns_first() -> None:
    wide = Limits(speed_max_mps=3.0, yaw_rate_max_radps=1.9, acceleration_max_mps2=1.0)
    boat = catamaran.start(0.0, 0.0, 0.0, 1.0)
    for _ in range(2000):
        boat = catamaran.advance(boat, 3.0, 1.9, CALM, wide, STEP_S)
    force, moment = M11 * boat.i_u, M33 * boat.i_r
    assert boat.r == pytest.approx(1.9, abs=0.01)
    assert moment > THRUSTERS.side_moment_max
    assert force == pytest.approx(
        2.0 * THRUSTERS.rear_ahead_n - (moment - THRUSTERS.side_moment_max) / THRUSTERS.rear_arm_m
    )


def test_force_changes_no_faster_than_its_thrusters() -> None:
    boat = catamaran.start(0.0, 0.0, 0.0, 1.5)
    for u_d, r_d in ((-1.5, 0.35), (1.5, -0.35)):
        for _ in range(100):
            after = catamaran.advance(boat, u_d, r_d, CALM, LIMITS, STEP_S)
            change = M11 * abs(after.i_u - boat.i_u)
            assert change <= 2.0 * THRUSTERS.rear_rate_n_per_s * STEP_S + 1e-9
            boat = after


def test_nothing_winds_up_while_it_is_held_fast() -> None:
    """Against a stream that it cannot stem, for two minutes; then the stream ends."""
    boat, stream = catamaran.start(0.0, 0.0, 0.0, 0.0), Water(-3.0, 0.0, 0.0, 0.0)
    for _ in range(6000):
        boat = catamaran.advance(boat, 1.0, 0.0, stream, LIMITS, STEP_S)
    assert boat.u < 0.0
    assert M11 * boat.i_u == pytest.approx(2.0 * THRUSTERS.rear_ahead_n)
    fastest = 0.0
    for _ in range(2000):
        boat = catamaran.advance(boat, 1.0, 0.0, CALM, LIMITS, STEP_S)
        fastest = max(fastest, boat.u)
    assert boat.u == pytest.approx(1.0, abs=0.01)
    assert fastest < 2.6


def test_the_memory_is_the_force_and_moment_given() -> None:
    boat = sail(catamaran.start(0.0, 0.0, 0.0, 1.0), 1.0, 0.2, 20.0)
    thrusts = allocate(M11 * boat.i_u, M33 * boat.i_r, THRUSTERS)
    assert resultant(slew(thrusts, thrusts, THRUSTERS, STEP_S), THRUSTERS) == pytest.approx(
        (M11 * boat.i_u, M33 * boat.i_r)
    )
