"""Going on after a restart, or standing by and saying why not (DESIGN section 4, Resume)."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from fleet.agent.modes import Mode, Reason
from fleet.mission.model import Start
from tests.agent.harness import CIRCUIT, Sea, mission, sailing

SAILS = {Mode.FOLLOW, Mode.AVOID}


def restarted(folder: Path, **how) -> Sea:
    sea = sailing(folder)
    sea.restart("b2", **how)
    sea.run(2.0)
    return sea


def stands_by(sea: Sea, why: str, boat: str = "b2") -> None:
    assert sea.mode(boat) == Mode.STANDBY
    assert not sea.powered(boat)
    assert Reason.NOT_RESUMED in sea.reasons(boat)
    assert "the mission was not resumed after a restart" in sea.statuses[boat].reasons
    assert any(why in text for text in sea.says(boat, "not-resumed")), sea.says(boat, "not-resumed")


# -- one by one --------------------------------------------------------------------------------------------------------
def test_soon_near_and_in_the_same_boot_a_boat_goes_on(tmp_path: Path) -> None:
    sea = restarted(tmp_path, after_s=3.0)
    assert sea.mode("b2") in SAILS
    sea.run(60.0)
    assert abs(sea.agent("b2").decision.e) < 1.0


def test_the_same_within_the_minute(tmp_path: Path) -> None:
    assert restarted(tmp_path, after_s=58.0).mode("b2") in SAILS


def test_after_a_minute_it_stands_by(tmp_path: Path) -> None:
    stands_by(restarted(tmp_path, after_s=61.0), "s have passed, more than 60 s")


def test_after_another_boot_it_stands_by(tmp_path: Path) -> None:
    stands_by(restarted(tmp_path, boot_id="boot-2"), "the machine was started anew")


def test_where_the_boot_cannot_be_told_it_stands_by(tmp_path: Path) -> None:
    sea = Sea(tmp_path)
    for boat in sea.stations:
        sea.stations[boat].boot_id = "unknown"
        sea.restart(boat)
    sea.run(0.5)
    sea.launch()
    sea.run(5.0)
    sea.restart("b2")
    sea.run(2.0)
    stands_by(sea, "the machine was started anew")


def test_too_far_from_where_it_was_it_stands_by(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    ship = sea.world.ships["b2"]
    ship.state = msgspec.structs.replace(ship.state, y=ship.state.y + 40.0)
    sea.restart("b2", after_s=2.0)
    sea.run(2.0)
    stands_by(sea, "m from where it was, more than")


@pytest.mark.parametrize(("moved_m", "goes_on"), [(21.0, True), (26.0, False)])
def test_how_far_is_20_m_and_what_it_could_have_sailed(tmp_path: Path, moved_m: float, goes_on: bool) -> None:
    sea = sailing(tmp_path)
    sea.run(0.1)
    sea.kill("b2")
    ship = sea.world.ships["b2"]
    ship.state = msgspec.structs.replace(ship.state, y=ship.state.y + moved_m, u=0.0)
    sea.restart("b2", after_s=1.0)  # and at most one second since it was written: 20 m + 1.5 m/s x 1 to 2 s
    sea.run(1.0)
    assert (sea.mode("b2") in SAILS) == goes_on


def test_with_a_stop_unreleased_it_does_not_go_on_even_when_released(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.command("stop-now", command_id="s1", boats=("b2",))
    sea.restart("b2")
    sea.run(2.0)
    assert sea.mode("b2") == Mode.NEUTRAL
    assert any("stopped, not released" in text for text in sea.says("b2", "not-resumed"))
    sea.command("release", names=("s1",), boats=("b2",))
    sea.run(2.0)
    assert sea.mode("b2") == Mode.STANDBY


def test_a_boat_that_held_goes_on_holding(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.command("hold")
    sea.run(3.0)
    sea.restart("b2")
    sea.run(3.0)
    assert sea.mode("b2") == Mode.HOLD


def test_a_clock_that_went_back_is_no_proof_of_being_soon(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    sea.stations["b2"].clock_offset_ns = -100 * 10**9
    sea.restart("b2")
    sea.run(2.0)
    assert sea.mode("b2") == Mode.STANDBY


def test_it_has_the_formation_that_was_in_force(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.change(spacing_m=15.0)
    sea.run(5.0)
    sea.cut("b1")
    sea.cut("b3")
    sea.restart("b2", after_s=1.0)
    sea.run(1.0)
    assert sea.spacing("b2") == 15.0
    assert sea.agent("b2").orders.control.operator == "anna"


# -- the abscissa ------------------------------------------------------------------------------------------------------
def test_where_a_path_comes_by_twice_the_boat_is_found_on_the_leg_that_it_was_on(tmp_path: Path) -> None:
    """Two legs 1 m apart: the whole path searched would find either."""
    from fleet.mission.model import Polyline

    hairpin = Polyline(
        points=((0.0, 0.0), (120.0, 0.0), (120.0, 31.0), (60.0, 31.0), (60.0, 1.0), (0.0, 1.0)), corner_radius_m=12.0
    )
    sea = sailing(tmp_path, mission(1, path=hairpin, starts=[Start(s_m=10.0, speed_mps=1.0)]), 15.0)
    s = sea.state("b1").s_m
    ship = sea.world.ships["b1"]
    ship.state = msgspec.structs.replace(ship.state, y=0.9)
    sea.restart("b1")
    sea.run(0.5)
    assert sea.state("b1").s_m == pytest.approx(s, abs=8.0)


def test_laps_are_kept(tmp_path: Path) -> None:
    starts = [Start(s_m=s) for s in (45.0, 30.0)]
    sea = sailing(tmp_path, mission(2, 12.0, path=CIRCUIT, starts=starts), 150.0)
    lap, s = sea.state("b2").lap, sea.state("b2").s_m
    assert lap >= 1
    sea.restart("b2", after_s=1.0)
    sea.run(0.5)
    assert sea.state("b2").s_m == pytest.approx(s, abs=8.0)


# -- an operator says where --------------------------------------------------------------------------------------------
def test_a_bare_resume_is_refused_and_says_what_to_say(tmp_path: Path) -> None:
    sea = restarted(tmp_path, boot_id="boot-2")
    ack = sea.command("resume", boats=("b2",))["b2"]
    assert not ack.ok
    assert ack.reason == (
        "not resumed after a restart (the machine was started anew): say where, with --at nearest or --at S"
    )
    assert sea.mode("b2") == Mode.STANDBY


def test_resume_at_nearest_goes_on_from_the_nearest_point(tmp_path: Path) -> None:
    sea = restarted(tmp_path, boot_id="boot-2")
    assert sea.command("resume", boats=("b2",), text="nearest")["b2"].ok
    sea.run(1.0)
    assert sea.mode("b2") in SAILS
    assert sea.state("b2").s_m == pytest.approx(sea.where("b2")[0], abs=3.0)


def test_resume_at_an_abscissa_goes_on_there(tmp_path: Path) -> None:
    sea = restarted(tmp_path, boot_id="boot-2")
    assert sea.command("resume", boats=("b2",), text="110")["b2"].ok
    sea.tick()
    assert sea.state("b2").s_m == pytest.approx(110.0, abs=2.0)


@pytest.mark.parametrize("text", ["here", "-1", "1e9", "nan", "inf", "-inf", "1e400"])
@pytest.mark.parametrize("closed", [False, True])
def test_resume_at_nowhere_is_refused(tmp_path: Path, text: str, closed: bool) -> None:
    starts = [Start(s_m=45.0), Start(s_m=30.0)]
    sea = sailing(tmp_path, mission(2, 12.0, path=CIRCUIT, starts=starts) if closed else mission(2, 12.0), 1.0)
    acks = sea.command("resume", text=text)
    assert not any(ack.ok for ack in acks.values())
    assert all("--at" in ack.reason for ack in acks.values())


def test_resume_without_navigation_is_refused_and_leaves_no_trace(tmp_path: Path) -> None:
    sea = restarted(tmp_path, boot_id="boot-2")
    sea.world.trouble("b2", "gnss-down")
    sea.run(2.0)
    acks = sea.command("resume", boats=("b2",), text="110")
    assert acks["b2"].reason == "own navigation is stale or not finite"
    assert sea.agent("b2").resumption.take_abscissa() is None


# -- at the quay -------------------------------------------------------------------------------------------------------
def test_a_boat_switched_on_at_the_quay_does_not_join_yesterdays_mission_that_it_held(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    sea.restart("b2", boot_id="boot-2", after_s=100.0)
    sea.run(30.0)
    assert set(sea.modes()) & SAILS, "its peers sail on"
    stands_by(sea, "the machine was started anew")


def test_a_boat_that_never_held_the_mission_joins_it(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(3), ashore=("b3",))
    sea.run(0.5)
    sea.launch()
    sea.run(10.0)
    sea.stations["b3"].switch_on()
    sea.run(3.0)
    assert sea.mode("b3") in SAILS
    sea.run(60.0)
    assert abs(sea.agent("b3").decision.e) < 1.0


def test_a_whole_fleet_switched_on_at_the_quay_stands_by(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    for boat in sea.stations:
        sea.kill(boat)
    sea.run(100.0)
    for boat in sea.stations:
        sea.restart(boat, boot_id="boot-2")
    sea.run(20.0)
    assert sea.modes() == [Mode.STANDBY] * 3
    assert not any(sea.powered(boat) for boat in sea.stations)


def test_a_boat_new_to_the_fleet_does_not_take_yesterdays_mission_from_boats_that_stand_by(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(3), ashore=("b3",))
    sea.run(0.5)
    sea.launch()
    sea.run(10.0)
    for boat in ("b1", "b2"):
        sea.restart(boat, boot_id="boot-2")
    sea.stations["b3"].switch_on()
    sea.run(20.0)
    assert sea.modes() == [Mode.STANDBY] * 3
    assert not sea.powered("b3")


def test_a_boat_does_not_set_sail_among_boats_that_were_told_to_hold(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(3), ashore=("b3",))
    sea.run(0.5)
    sea.launch()
    sea.run(10.0)
    sea.command("hold")
    sea.run(1.0)
    sea.stations["b3"].switch_on()
    sea.run(20.0)
    assert sea.mode("b3") == Mode.STANDBY
    sea.command("resume", boats=("b1", "b2"))
    sea.run(3.0)
    assert sea.mode("b3") in SAILS


def test_a_boat_at_the_quay_takes_todays_mission_that_it_never_held(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    sea.run(1.0)
    sea.launch(mission(title="Today's"))
    sea.run(5.0)
    sea.restart("b2", boot_id="boot-2")
    sea.run(5.0)
    assert sea.mode("b2") in SAILS
    assert sea.state("b2").mission_id == sea.state("b1").mission_id


def test_standing_by_outlives_another_restart(tmp_path: Path) -> None:
    sea = restarted(tmp_path, boot_id="boot-2")
    sea.restart("b2", after_s=1.0)
    sea.run(3.0)
    stands_by(sea, "it stood by before the restart")
    assert not sea.command("resume", boats=("b2",))["b2"].ok


# -- before the boat knows where it is ---------------------------------------------------------------------------------
def test_two_kills_before_the_first_fix_do_not_lose_the_mission(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.world.trouble("b2", "gnss-down")
    sea.restart("b2")
    sea.run(2.0)
    sea.restart("b2")
    sea.run(2.0)
    sea.world.trouble("b2", "gnss-up")
    sea.run(5.0)
    assert sea.holds_mission("b2")
    assert sea.mode("b2") in SAILS


def test_an_abort_before_the_first_fix_ends_the_mission(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.world.trouble("b2", "gnss-down")
    sea.restart("b2")
    sea.run(1.0)
    sea.command("abort", boats=("b2",))
    sea.world.trouble("b2", "gnss-up")
    sea.run(5.0)
    assert not sea.holds_mission("b2")
    assert sea.mode("b2") == Mode.HOLD
    sea.restart("b2")
    sea.run(5.0)
    assert not sea.holds_mission("b2")


def test_a_hold_before_the_first_fix_holds(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.world.trouble("b2", "gnss-down")
    sea.restart("b2")
    sea.run(1.0)
    sea.command("hold", boats=("b2",))
    sea.world.trouble("b2", "gnss-up")
    sea.run(5.0)
    assert sea.mode("b2") == Mode.HOLD
    assert sea.holds_mission("b2")


def test_files_that_cannot_be_read_leave_the_boat_in_standby(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    for name in ("kept", "progress"):
        (sea.stations["b2"].folder / name).write_bytes(b"\xc1")
    sea.parts = {"b2": 9}
    sea.restart("b2")
    sea.run(3.0)
    assert sea.mode("b2") == Mode.STANDBY
