"""Boats whose sensors have noise, and fail one by one: the agent fuses what is left."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from msgspec.structs import replace

from fleet.agent.modes import Mode, Reason
from fleet.agent.sensors import sensors_of
from fleet.drivers.seam import Reading
from fleet.mission.model import Environment
from fleet.sim.world import World

from .harness import Sea, mission, sailing

REAL = Environment(
    gnss_white_m=0.3, gnss_velocity_mps=0.05, heading_noise_deg=1.5, yaw_rate_noise_degps=0.3
)  # fmt: skip


def at_sea(folder: Path, seconds: float = 10.0, boats: int = 1) -> Sea:
    return sailing(folder, replace(mission(boats), environment=REAL), seconds)


def off_path(sea: Sea, boat: str = "b1") -> float:
    return abs(sea.where(boat)[1])


def test_with_the_noise_of_real_sensors_a_formation_keeps_its_path_and_its_places(tmp_path: Path) -> None:
    sea = at_sea(tmp_path, 40.0, boats=2)
    assert [sea.mode(boat) for boat in ("b1", "b2")] == [Mode.FOLLOW, Mode.FOLLOW]
    assert off_path(sea) < 0.5
    assert sea.where("b1")[0] - sea.where("b2")[0] == pytest.approx(12.0, abs=0.7)
    assert 0.15 <= sea.state("b1").position_error_m < 0.3


def test_without_noise_the_boat_gets_the_truth_as_ever(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(1), 2.0)
    assert not sea.agent("b1").reading.raw
    assert sea.agent("b1").nav.x == pytest.approx(sea.where("b1")[0], abs=0.2)


def test_without_gnss_the_boat_reckons_for_ten_seconds_with_a_growing_error_then_stops(tmp_path: Path) -> None:
    sea = at_sea(tmp_path)
    sea.world.trouble("b1", "gnss-down")
    sea.run(5.0)
    assert sea.mode("b1") == Mode.FOLLOW
    assert off_path(sea) < 1.0
    growing = sea.agent("b1").nav.sigma
    sea.run(3.0)
    assert sea.agent("b1").nav.sigma > growing > 0.3
    sea.run(3.0)
    assert sea.mode("b1") == Mode.FAULT
    assert Reason.NAVIGATION in sea.reasons("b1")
    sea.world.trouble("b1", "gnss-up")
    sea.run(4.0)
    assert sea.mode("b1") == Mode.FOLLOW


@pytest.mark.parametrize("lost", ["compass-down", "gyro-down"])
def test_without_compass_or_without_gyro_the_boat_stays_on_its_path(tmp_path: Path, lost: str) -> None:
    sea = at_sea(tmp_path)
    sea.world.trouble("b1", lost)
    sea.run(40.0)
    assert sea.mode("b1") == Mode.FOLLOW
    assert off_path(sea) < 2.0


def test_a_wild_fix_does_not_turn_the_boat(tmp_path: Path) -> None:
    sea = at_sea(tmp_path)
    driver = sea.stations["b1"].driver
    driver.spoil = lambda reading: replace(reading, lat_deg=reading.lat_deg + 1e-3)  # 111 m
    sea.run(0.5)
    driver.spoil = lambda reading: reading
    assert sea.agent("b1").fused.outliers >= 4.0
    assert abs(sea.agent("b1").nav.y) < 1.0
    sea.run(10.0)
    assert off_path(sea) < 0.7


def test_a_sensor_that_fails_where_there_is_no_noise_is_missed_all_the_same(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(1), 5.0)
    sea.world.trouble("b1", "compass-down")
    sea.run(2.0)
    assert sea.agent("b1").reading.raw
    assert math.isnan(sea.agent("b1").reading.heading_rad)
    sea.run(20.0)
    assert sea.mode("b1") == Mode.FOLLOW
    assert off_path(sea) < 1.0


@pytest.mark.parametrize(
    "changes", [{"lat_deg": 0.0, "lon_deg": 0.0}, {"lat_deg": 95.0}, {"lon_deg": math.nan}, {"position_error_m": -1.0}]
)
def test_a_position_that_cannot_be_is_none(changes: dict[str, float]) -> None:
    good = Reading(stamp_ns=10**9, lat_deg=44.0, lon_deg=9.0, heading_rad=1.0, raw=True)
    assert sensors_of(good, lambda lat, lon: (lat, lon), 10**9).x == 44.0
    assert math.isnan(sensors_of(replace(good, **changes), lambda lat, lon: (lat, lon), 10**9).x)


def test_ages_are_those_of_each_sensor_and_the_future_has_none() -> None:
    reading = Reading(stamp_ns=10**9, lat_deg=44.0, lon_deg=9.0, heading_stamp_ns=9 * 10**8, raw=True)
    seen = sensors_of(reading, lambda lat, lon: (lat, lon), 11 * 10**8)
    assert (seen.fix_age, seen.psi_age, seen.r_age) == pytest.approx((0.1, 0.2, 0.1))
    assert math.isnan(sensors_of(reading, lambda lat, lon: (lat, lon), 10**8).fix_age)


def test_the_noise_of_the_world_is_what_the_mission_says() -> None:
    from fleet.mission.plan import build

    world = World(build(replace(mission(1), environment=REAL)), 0, seed=4)
    world.begins_ns = 1 << 62  # nobody moves
    readings = []
    for _ in range(600):
        world.step()
        readings.append(world.sense("b1"))
    psi = world.ships["b1"].state.psi
    spread = math.sqrt(sum((r.heading_rad - psi) ** 2 for r in readings) / 600)
    assert math.degrees(spread) == pytest.approx(1.5, rel=0.1)
    spread = math.sqrt(sum((r.v_east_mps) ** 2 for r in readings) / 600)
    assert spread == pytest.approx(0.05, rel=0.1)
    assert {r.raw for r in readings} == {True}
