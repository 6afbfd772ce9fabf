"""Keeping station: within 2R of the hold point, bow into the current."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fleet.guidance import Limits, Station, StationParams, keep_station
from fleet.hulls import HULLS, STEP_S, HullState, Water

PARAMS, LIMITS = StationParams(), Limits()
ATTENTION_M = 12.0  # 2R


def hold(
    hull: str, heading: float, speed: float, water: Water[float], seconds: float
) -> tuple[list[float], HullState[float]]:
    """Distances from the hold point every 0.1 s, and the boat at the end."""
    model = HULLS[hull]
    boat = model.start(0.0, 0.0, heading, speed)
    distances = []
    for _ in range(round(seconds / 0.1)):
        k = keep_station(boat.x, boat.y, boat.psi, 0.0, 0.0, LIMITS, PARAMS)
        for _ in range(round(0.1 / STEP_S)):
            boat = model.advance(boat, k.u_d, k.r_d, water, LIMITS, STEP_S)
        distances.append(math.hypot(boat.x, boat.y))
    return distances, boat


@pytest.mark.parametrize("hull", HULLS)
@pytest.mark.parametrize("heading", [-2.0, 0.0, 1.57, 3.1])
def test_a_boat_stopped_at_full_speed_stays_within_2r_in_half_a_metre_per_second(hull: str, heading: float) -> None:
    distances, boat = hold(hull, heading, 1.5, Water(0.0, 0.5, 0.0, 0.0), 180.0)
    assert max(distances) < ATTENTION_M
    assert max(distances[1200:]) < 3.0
    assert math.cos(boat.psi + math.pi / 2) > 0.98  # bow into a current that sets east
    assert abs(boat.u) < 0.05


def test_wind_and_current_together_are_held_too() -> None:
    distances, boat = hold("unicycle", 0.0, 0.0, Water(0.3, 0.0, 0.1, 0.2), 180.0)
    assert max(distances) < ATTENTION_M
    assert math.cos(boat.psi - math.atan2(-0.2, -0.4)) > 0.98


@pytest.mark.parametrize("hull", HULLS)
def test_in_still_water_the_boat_comes_to_rest(hull: str) -> None:
    distances, boat = hold(hull, 0.4, 1.5, Water(0.0, 0.0, 0.0, 0.0), 120.0)
    assert distances[-1] < 3.0
    assert abs(boat.u) + abs(boat.v) + abs(boat.r) < 0.02


def test_near_the_hold_point_the_boat_stops_and_keeps_its_heading() -> None:
    k = keep_station(1.0, 1.0, 0.7, 0.0, 0.0, LIMITS, PARAMS)
    assert (k.u_d, k.r_d) == (0.0, 0.0)
    assert (k.gx, k.gy) == pytest.approx((math.cos(0.7), math.sin(0.7)))


def test_far_from_the_hold_point_the_boat_turns_to_it_first_and_then_comes_at_full_speed() -> None:
    away = keep_station(50.0, 0.0, 0.1, 0.0, 0.0, LIMITS, PARAMS)
    assert (away.u_d, away.r_d) == (0.0, LIMITS.yaw_rate_max_radps)
    toward = keep_station(50.0, 0.0, math.pi, 0.0, 0.0, LIMITS, PARAMS)
    assert toward.u_d == pytest.approx(1.5)
    assert (toward.gx, toward.gy) == pytest.approx((-1.0, 0.0))


@pytest.mark.parametrize("count", [1, 2, 1000])
def test_a_lane_gets_the_bits_of_a_boat(count: int) -> None:
    x, y, psi, x_h, y_h = np.random.default_rng(2).uniform(-5.0, 5.0, (5, count))
    x_h[0], y_h[0] = x[0], y[0]  # on the spot
    batch = keep_station(x, y, psi, x_h, y_h, LIMITS, PARAMS)
    rows = zip(*(v.tolist() for v in (x, y, psi, x_h, y_h)), strict=True)
    alone = [keep_station(*row, LIMITS, PARAMS) for row in rows]
    for name in Station.__struct_fields__:
        assert getattr(batch, name).tolist() == [getattr(k, name) for k in alone]
        assert all(type(getattr(k, name)) is float for k in alone)
