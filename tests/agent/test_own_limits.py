"""The boat's word wins: a mission that asks more of a boat than its own configuration allows is refused on board."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from fleet.agent.modes import Mode
from fleet.guidance.limits import Limits, OwnLimits, asked_too_much, within
from fleet.mission.model import Mission
from tests.agent.harness import Sea, mission, sailing


def with_boat(**changed: object) -> Mission:
    """Two boats, b1 another than usual."""
    two = mission(2)
    return msgspec.structs.replace(two, boats=(msgspec.structs.replace(two.boats[0], **changed), two.boats[1]))


@pytest.mark.parametrize(
    ("own", "found"),
    [
        (OwnLimits(), []),
        (OwnLimits(speed_max_mps=1.5, speed_min_mps=0.0, yaw_rate_max_radps=0.35, length_m=2.4), []),
        (OwnLimits(speed_max_mps=1.2), ["speed_max_mps = 1.5, the boat's own 1.2"]),
        (OwnLimits(speed_max_mps=2.0), []),
        (OwnLimits(speed_min_mps=0.3), ["speed_min_mps = 0, the boat's own 0.3"]),
        (OwnLimits(yaw_rate_max_radps=0.2), ["yaw_rate_max_radps = 0.35, the boat's own 0.2"]),
        (OwnLimits(acceleration_max_mps2=0.1), ["acceleration_max_mps2 = 0.3, the boat's own 0.1"]),
        (OwnLimits(surge_lag_s=3.0, yaw_lag_s=0.1), ["surge_lag_s = 2, the boat's own 3"]),
        (OwnLimits(length_m=4.0), ["length_m = 2.4, the boat's own 4"]),
    ],
)
def test_what_the_default_limits_ask_of_a_boat_that_can_less(own: OwnLimits, found: list[str]) -> None:
    assert asked_too_much(own, Limits()) == found


def test_a_launch_that_asks_more_than_a_boat_can_is_refused_by_that_boat_with_the_reason(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2))
    sea.agent("b1").can_do("", OwnLimits(speed_max_mps=1.2))
    sea.run(0.5)
    acks = sea.launch()
    assert not acks["b1"].ok
    assert acks["b1"].reason == "it asks more than this boat can: speed_max_mps = 1.5, the boat's own 1.2"
    assert acks["b1"].safety
    assert acks["b2"].ok
    sea.run(5.0)
    assert sea.mode("b1") == Mode.STANDBY, "not from the neighbour either"
    assert not sea.holds_mission("b1")


def test_a_launch_within_a_boats_own_limits_is_sailed(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2))
    for boat in sea.agents():
        sea.agent(boat).can_do("unicycle", OwnLimits(speed_max_mps=1.5, length_m=2.0))
    sea.run(0.5)
    assert all(ack.ok for ack in sea.launch().values())


@pytest.mark.parametrize(
    ("own", "asked", "why"),
    [
        ("catamaran", "unicycle", ""),
        ("catamaran", "catamaran", ""),
        ("", "otter", ""),
        ("catamaran", "otter", "it takes this boat for the hull 'otter'; it is 'catamaran'"),
    ],
)
def test_a_mission_may_take_a_boat_for_its_own_hull_or_for_none_in_particular(
    tmp_path: Path, own: str, asked: str, why: str
) -> None:
    sea = Sea(tmp_path, mission(2))
    sea.agent("b1").can_do(own, OwnLimits())
    sea.run(0.5)
    ack = sea.launch(with_boat(hull=asked))["b1"]
    assert (ack.ok, ack.reason) == (not why, why)


def test_without_a_mission_a_boat_keeps_station_within_its_own_limits(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    agent = sea.agent("b1")
    agent.can_do("", OwnLimits(speed_max_mps=1.5, yaw_rate_max_radps=0.35))
    assert agent.params.limits == Limits(), "a mission's limits hold while it is sailed"
    agent.orders.sailing = None
    agent.can_do("", OwnLimits(speed_max_mps=0.8, yaw_rate_max_radps=0.2))
    assert (agent.params.limits.speed_max_mps, agent.params.limits.yaw_rate_max_radps) == (0.8, 0.2)


def test_a_boat_whose_slowest_speed_is_above_the_usual_fastest_is_not_asked_the_impossible() -> None:
    limits = within(OwnLimits(speed_min_mps=2.0))
    assert limits.speed_min_mps <= limits.speed_max_mps
