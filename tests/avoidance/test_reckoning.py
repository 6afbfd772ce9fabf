"""Where another boat is by now."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.avoidance.reckoning import reckoned

real = st.floats(-50.0, 50.0)


def test_a_fresh_message_is_carried_on_straight() -> None:
    assert reckoned(10.0, 20.0, 1.0, -0.5, 0.3, 0.2) == (10.2, 19.9, 1.0, -0.5)


def test_a_boat_heard_two_seconds_ago_has_turned_on_for_one() -> None:
    """1 m/s north, 0.3 rad/s to starboard: it sails 2 m on 0.15 rad and heads 0.3 rad."""
    x, y, vx, vy = reckoned(0.0, 0.0, 1.0, 0.0, 0.3, 2.0)
    assert (x, y) == pytest.approx((2.0 * math.cos(0.15), 2.0 * math.sin(0.15)))
    assert (vx, vy) == pytest.approx((math.cos(0.3), math.sin(0.3)))


def test_nobody_is_believed_to_spin() -> None:
    assert reckoned(0.0, 0.0, 1.0, 0.0, 100.0, 5.0)[2] == pytest.approx(math.cos(0.6))


@given(real, real, real, real, st.floats(-2.0, 2.0), st.floats(0.0, 10.0))
def test_speed_and_distance_sailed_are_those_of_the_message(
    x: float, y: float, vx: float, vy: float, r: float, age: float
) -> None:
    px, py, ux, uy = reckoned(x, y, vx, vy, r, age)
    speed = math.hypot(vx, vy)
    assert math.hypot(ux, uy) == pytest.approx(speed)
    assert math.hypot(px - x, py - y) == pytest.approx(speed * age, abs=1e-9)


def test_lanes_have_the_bits_of_one_boat() -> None:
    rows = [(1.0, 2.0, 0.7, -0.4, r, age) for r in (-0.3, 0.0, 0.2) for age in (0.1, 0.6, 2.0)]
    lanes = reckoned(*(np.array(column) for column in zip(*rows, strict=True)))
    for place, row in enumerate(rows):
        assert tuple(float(value[place]) for value in lanes) == reckoned(*row)
