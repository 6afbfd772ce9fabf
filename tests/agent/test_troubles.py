"""Trouble with oneself: link, navigation, driver, operator, fence, battery, disk (DESIGN section 3, the other rows)."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from fleet.agent.modes import Mode, Reason
from fleet.agent.why import OUT_OF_REACH_S
from fleet.drivers.seam import Reading
from fleet.mission.model import Fence, Lost
from tests.agent.harness import Sea, mission, sailing


def spoilt(**changes: float) -> Callable[[Reading], Reading]:
    return lambda reading: msgspec.structs.replace(reading, **changes)


# -- own link down -----------------------------------------------------------------------------------------------------
def test_a_boat_whose_link_is_down_goes_on_alone_at_cruise_speed_then_holds(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.cut("b2")
    sea.run(2.0)
    assert sea.mode("b2") == Mode.ALONE
    assert Reason.LINK_DOWN in sea.reasons("b2")
    began = sea.time_s
    sea.run(5.0)
    assert sea.speed("b2") == pytest.approx(1.0, abs=0.02), "cruise, whatever the formation's error was"
    took = sea.run_until(lambda: sea.mode("b2") == Mode.HOLD, 40.0)
    assert sea.time_s - began == pytest.approx(30.0, abs=0.3)
    assert took > 20.0
    assert Reason.LINK_DOWN in sea.reasons("b2"), "it says why it holds"


def test_how_long_a_boat_goes_on_alone_is_the_missions_to_say(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0, lost=Lost(alone_for_s=5.0)))
    sea.cut("b2")
    sea.run(2.0)
    assert sea.run_until(lambda: sea.mode("b2") == Mode.HOLD, 10.0) == pytest.approx(5.0, abs=0.3)


@pytest.mark.parametrize("outage_s", [10.0, 60.0])
def test_a_boat_whose_link_comes_back_recovers_by_itself(tmp_path: Path, outage_s: float) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.cut("b2")
    sea.run(outage_s)
    sea.mend("b2")
    sea.run(1.0)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)
    sea.run(60.0)
    assert abs(sea.agent("b2").decision.e) < 1.0
    assert Reason.LINK_DOWN not in sea.reasons("b2")


def test_a_second_outage_has_its_full_time_again(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    for _ in range(2):
        sea.cut("b2")
        sea.run(25.0)
        assert sea.mode("b2") == Mode.ALONE
        sea.mend("b2")
        sea.run(5.0)


def test_a_boat_alone_keeps_clear_of_everybody_it_remembers(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.cut("b2")
    sea.run(20.0)
    agent = sea.agent("b2")
    assert [agent.picture.name_of(peer.number) for peer in agent.peers] == ["b1"]


# -- own navigation ----------------------------------------------------------------------------------------------------
BAD = {
    "no position": spoilt(lat_deg=math.nan, lon_deg=math.nan),
    "not a number somewhere": spoilt(heading_rad=math.nan),
    "an infinite speed": spoilt(v_north_mps=math.inf),
    "null island": spoilt(lat_deg=0.0, lon_deg=0.0),
    "beyond the pole": spoilt(lat_deg=123.0),
    "an error that is none": spoilt(position_error_m=math.nan),
    "nothing yet": lambda reading: Reading(stamp_ns=0),
}


@pytest.mark.parametrize("how", BAD)
def test_without_navigation_the_thrusters_stop_until_three_seconds_of_good_data(tmp_path: Path, how: str) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    driver = sea.stations["b2"].driver
    driver.spoil = BAD[how]
    sea.tick()
    assert sea.mode("b2") == Mode.FAULT
    assert not sea.powered("b2")
    assert Reason.NAVIGATION in sea.reasons("b2")
    sea.run(4.0)
    assert sea.mode("b2") == Mode.FAULT
    driver.spoil = lambda reading: reading
    sea.run(2.8)
    assert sea.mode("b2") == Mode.FAULT
    sea.run(0.4)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)
    assert sea.powered("b2")


def test_a_reading_that_stands_still_is_stale_after_a_second(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    last = sea.agent("b2").reading
    sea.stations["b2"].driver.spoil = lambda reading: last
    sea.run(0.8)
    assert sea.mode("b2") != Mode.FAULT, "dead-reckoned for a second"
    sea.run(0.3)
    assert sea.mode("b2") == Mode.FAULT
    assert not sea.powered("b2")


@pytest.mark.parametrize("how", BAD)
def test_a_boat_without_navigation_never_tells_the_others_a_false_position(tmp_path: Path, how: str) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    x, y = sea.where("b2")
    sea.stations["b2"].driver.spoil = BAD[how]
    sea.run(20.0)
    track = sea.agent("b1").picture.others["b2"].track
    assert track is not None
    assert math.hypot(track.x - x, track.y - y) < 1.0, "where it was last, not in the Gulf of Guinea"
    assert sea.agent("b1").peers, "and it is kept clear of"


def test_a_boat_without_navigation_goes_on_saying_that_it_is_not_under_command(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.stations["b2"].driver.spoil = BAD["no position"]
    sea.run(5.0)
    assert sea.state("b2").mode == Mode.FAULT
    assert sea.now_ns - sea.state("b2").stamp_ns == 0
    assert "own navigation is stale or not finite" in sea.statuses["b2"].reasons
    assert sea.members("b1") == 0


def test_what_is_published_without_navigation_is_less_certain_by_the_second(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.stations["b2"].driver.spoil = BAD["no position"]
    sea.run(2.0)
    early = sea.state("b2").position_error_m
    sea.run(10.0)
    assert sea.state("b2").position_error_m > early


def test_a_boat_that_never_knew_where_it_is_says_nothing_of_its_position(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2, 12.0))
    sea.stations["b2"].driver.spoil = BAD["no position"]
    sea.run(1.0)
    sea.launch()
    sea.run(5.0)
    assert "b2" not in sea.raw
    assert not sea.powered("b2")


# -- the driver --------------------------------------------------------------------------------------------------------
def test_a_driver_that_cannot_write_is_not_written_to_ten_times_a_second(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    driver = sea.stations["b2"].driver
    driver.refuses = "the autopilot left the commanded mode"
    sea.run(2.0)
    driver.written.clear()
    sea.run(10.0)
    assert len(driver.written) <= 10, "stop commanding; a try now and then finds out whether it works again"


def test_a_driver_that_cannot_write_is_said_without_a_flood(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.stations["b2"].driver.refuses = "the autopilot left the commanded mode"
    sea.run(1.0)
    before = len(sea.says("b2", "mode"))
    said: list[bool] = []
    sea.each_tick.append(lambda: said.append(Reason.DRIVER in sea.reasons("b2")))
    sea.run(10.0)
    assert all(said)
    assert len(sea.says("b2", "mode")) - before <= 20
    assert "autopilot" in sea.statuses["b2"].driver


def test_a_driver_that_can_write_again_is_used_again(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    driver = sea.stations["b2"].driver
    driver.refuses = "bus off"
    sea.run(5.0)
    driver.refuses = ""
    sea.run(3.0)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)
    assert sea.powered("b2")
    assert Reason.DRIVER not in sea.reasons("b2")


def test_thrusters_that_do_not_answer_are_left_in_neutral_and_reported(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.world.trouble("b2", "actuator-down")
    sea.run(1.0)
    assert sea.mode("b2") == Mode.NEUTRAL
    assert Reason.DRIVER in sea.reasons("b2")
    assert sea.statuses["b2"].driver == "the thrusters do not answer"
    sea.world.trouble("b2", "actuator-up")
    sea.run(1.0)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)


def test_somebody_else_at_the_helm_is_not_fought(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    driver = sea.stations["b2"].driver
    driver.spoil = lambda reading: msgspec.structs.replace(reading, authority="pilot")
    sea.tick()
    driver.written.clear()
    driver.neutrals = 0
    sea.run(10.0)
    assert driver.written == []
    assert driver.neutrals == 0, "neutral is a command too"
    assert sea.mode("b2") == Mode.NEUTRAL
    assert Reason.AUTHORITY in sea.reasons("b2")
    assert sea.statuses["b2"].driver == "pilot"
    assert sea.members("b1") == 0
    driver.spoil = lambda reading: reading
    sea.run(1.0)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)


# -- the operator ------------------------------------------------------------------------------------------------------
def test_without_an_operator_the_boats_go_on_by_default(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.operators.clear()
    sea.run(60.0)
    assert set(sea.modes()) <= {Mode.FOLLOW, Mode.AVOID}


def test_without_an_operator_the_boats_hold_if_the_mission_says_so_and_go_on_when_one_is_back(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(lost=Lost(operator="hold", operator_after_s=10.0)))
    sea.operators.clear()
    sea.run(9.0)
    assert set(sea.modes()) <= {Mode.FOLLOW, Mode.AVOID}
    sea.run(2.0)
    assert sea.modes() == [Mode.HOLD] * 3
    assert Reason.OPERATOR_LOST in sea.reasons("b1")
    sea.operators["anna"] = None
    sea.run(1.0)
    assert set(sea.modes()) <= {Mode.FOLLOW, Mode.AVOID}


def test_without_an_operator_the_boats_return_if_the_mission_says_so(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(lost=Lost(operator="return", operator_after_s=5.0)), 30.0)
    sea.operators.clear()
    sea.run(6.0)
    assert sea.modes() == [Mode.RETURN] * 3
    assert sea.says("b1", "trouble") == ["no operator in reach: return"]
    sea.operators["anna"] = None
    sea.run(2.0)
    assert sea.modes() == [Mode.RETURN] * 3, "an operator says when to go on"
    sea.command("resume")
    sea.run(1.0)
    assert set(sea.modes()) <= {Mode.FOLLOW, Mode.AVOID}


# -- fence and battery -------------------------------------------------------------------------------------------------
NARROW = Fence(points=((-50.0, -40.0), (1100.0, -40.0), (1100.0, 40.0), (-50.0, 40.0)))


def shove(sea: Sea, boat: str, east_m: float) -> None:
    """A squall."""
    ship = sea.world.ships[boat]
    ship.state = msgspec.structs.replace(ship.state, y=ship.state.y + east_m)


def test_a_boat_outside_the_fence_goes_back_along_its_own_track(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0, fence=NARROW), 30.0)
    shove(sea, "b1", 45.0)
    sea.run(2.0)
    assert sea.mode("b1") == Mode.RETURN
    assert Reason.OUTSIDE_FENCE in sea.reasons("b1")
    assert sea.says("b1", "trouble") == ["outside the fence: return"]
    sea.run(30.0)
    assert sea.where("b1")[1] < 40.0
    assert Reason.OUTSIDE_FENCE not in sea.reasons("b1")
    assert sea.mode("b1") in (Mode.RETURN, Mode.HOLD), "it does not go out again by itself"


def test_one_wild_fix_is_no_breach(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0, fence=NARROW), 5.0)
    sea.stations["b1"].driver.spoil = spoilt(lon_deg=8.94)
    sea.run(0.5)
    sea.stations["b1"].driver.spoil = lambda reading: reading
    sea.run(2.0)
    assert sea.mode("b1") in (Mode.FOLLOW, Mode.AVOID)
    assert sea.says("b1", "trouble") == []


def test_outside_the_fence_a_boat_is_not_resumed(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0, fence=NARROW), 10.0)
    shove(sea, "b1", 60.0)
    sea.run(2.0)
    ack = sea.command("resume", boats=("b1",))["b1"]
    assert not ack.ok
    assert ack.reason == "outside the fence"
    assert ack.safety
    assert sea.mode("b1") == Mode.RETURN


def test_a_battery_below_its_reserve_takes_the_boat_back_along_its_track(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 30.0)
    sea.world.trouble("b2", "battery", 19.0)
    sea.run(1.0)
    assert sea.mode("b2") == Mode.RETURN
    assert Reason.BATTERY_RESERVE in sea.reasons("b2")
    x, _ = sea.where("b2")
    sea.run(30.0)
    assert sea.where("b2")[0] < x - 5.0
    ack = sea.command("resume", boats=("b2",))["b2"]
    assert ack.reason == "battery at 19 %, reserve is 20 %"


def test_a_boat_that_has_come_home_holds_there(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 30.0)
    sea.world.trouble("b2", "battery", 19.0)
    sea.run_until(lambda: sea.mode("b2") == Mode.HOLD, 250.0)
    assert math.dist(sea.where("b2"), (0.0, -20.0)) < 6.0
    sea.run(60.0)
    assert math.dist(sea.where("b2"), (0.0, -20.0)) < 12.0, "2R"


def test_a_critical_battery_stops_the_boat(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.world.trouble("b2", "battery", 4.0)
    sea.run(1.0)
    assert sea.mode("b2") == Mode.NEUTRAL
    assert not sea.powered("b2")
    assert Reason.BATTERY_CRITICAL in sea.reasons("b2")


def test_an_unknown_battery_level_is_no_trouble(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.world.trouble("b2", "battery", math.nan)
    sea.run(5.0)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)


# -- the disk ----------------------------------------------------------------------------------------------------------
def test_with_a_full_disk_the_boat_sails_on_and_says_that_it_does_not_record(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.agent("b2").reporter.recording.trouble = "disk full"
    sea.run(2.0)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)
    assert Reason.NOT_RECORDING in sea.reasons("b2")
    assert sea.statuses["b2"].recording == "disk full"
    assert "not recording" in sea.statuses["b2"].reasons


def test_a_store_that_cannot_be_written_is_said_and_the_boat_sails_on(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.agent("b2").store._folder = tmp_path / "gone"
    sea.run(2.0)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)
    assert Reason.STORE in sea.reasons("b2")
    assert "cannot write its state to disk" in sea.statuses["b2"].reasons


# -- the slot ----------------------------------------------------------------------------------------------------------
def test_a_boat_that_cannot_reach_its_slot_says_why_and_recovers(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    limits = sea.world.ships["b2"].limits
    sea.world.ships["b2"].limits = msgspec.structs.replace(limits, speed_max_mps=0.45)  # weed in the propeller
    ahead = sea.agent("b1")
    ahead.params = msgspec.structs.replace(
        ahead.params, limits=msgspec.structs.replace(ahead.params.limits, speed_min_mps=0.9)
    )
    sea.run(OUT_OF_REACH_S + 30.0)
    assert Reason.SLOT_OUT_OF_REACH in sea.reasons("b2")
    assert "cannot reach its slot" in sea.statuses["b2"].reasons
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID), "it goes on trying"
    sea.world.ships["b2"].limits = limits
    sea.run_until(lambda: Reason.SLOT_OUT_OF_REACH not in sea.reasons("b2"), 300.0)


def test_whichever_way_an_agent_ends_the_driver_is_left_in_neutral(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    assert sea.powered("b2")
    sea.agent("b2").close()
    assert not sea.powered("b2")
    sea.stations["b2"].agent = None
    sea.run(0.5)
    assert "b2" not in sea.water.tokens


def test_a_dead_agent_leaves_a_hull_whose_thrusters_stop_by_themselves(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    sea.kill("b2")
    sea.run(12.0)
    assert sea.speed("b2") < 0.05
