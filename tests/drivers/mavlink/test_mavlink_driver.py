"""The driver against the simulated autopilot, over real UDP sockets, in simulated time."""

from __future__ import annotations

import math
import socket
from collections.abc import Callable

import pytest

from fleet.drivers.mavlink import words
from fleet.drivers.mavlink.config import MavlinkConfig
from fleet.drivers.mavlink.driver import STREAMS, MavlinkDriver
from fleet.sim.autopilot.guided import Aim
from tests.drivers.mavlink.bench import BEGIN_NS, STEP_NS, Bench

Make = Callable[..., Bench]


def rates(bench: Bench) -> dict[int, float]:
    """What the autopilot sends the driver of what it asks for [Hz]."""
    (wanted,) = bench.rover.streams._peers.values()
    return {message: round(1e9 / wanted[message][0]) for message in STREAMS}


# -- finding and taking the boat ---------------------------------------------------------------------------------------
def test_before_an_operator_says_so_it_neither_changes_the_mode_nor_arms(bench: Bench) -> None:
    bench.run(5.0)
    assert (bench.mode, bench.rover.armed) == ("MANUAL", False)
    assert bench.known
    assert (bench.reading.authority, bench.reading.trouble) == ("", "")
    bench.run(5.0, (1.0, 0.0))
    assert (bench.mode, bench.rover.armed) == ("MANUAL", False)
    assert bench.refused == "in MANUAL: not ours to change"


def test_after_a_launch_it_sets_guided_then_arms_and_the_heartbeat_confirms_both(bench: Bench) -> None:
    taken_s = bench.launch()
    assert (bench.mode, bench.rover.armed) == ("GUIDED", True)
    assert taken_s < 3.0


def test_a_boat_that_may_not_be_armed_by_us_is_driven_once_somebody_else_has_armed_it(bench_of: Make) -> None:
    bench = bench_of(arm="never")
    bench.run(2.0)
    bench.driver.obeyed("launch")
    bench.run(5.0, (1.0, 0.0))
    assert not bench.rover.armed
    assert bench.refused == "not armed: somebody has to arm the boat"
    bench.rover.armed = True
    bench.run(2.0, (1.0, 0.0))
    assert bench.refused == ""
    assert bench.thrust.powered


def test_a_cold_autopilot_is_waited_for_and_armed_when_its_checks_are_good(bench_of: Make) -> None:
    bench = bench_of(running_s=0.0)
    bench.driver.obeyed("launch")
    said: set[str] = set()
    bench.look = lambda: said.add(bench.refused)
    asked_early: list[int] = []
    command = bench.rover._set_mode
    bench.rover._set_mode = lambda mode: (asked_early.append(bench.rover.mode), command(mode))[1]  # type: ignore[method-assign,func-returns-value]
    taken_s = bench.until(lambda: bench.rover.armed, 50.0, (0.0, 0.0))
    assert set(asked_early) == {words.MANUAL}, "nothing was asked while it was starting"
    assert 42.0 <= taken_s <= 46.0
    assert {"the autopilot is starting", "cannot arm: PreArm: Need Position Estimate", "arming"} <= said


def test_permission_ends_after_a_minute_and_is_asked_for_in_words(bench: Bench) -> None:
    bench.fix = False
    bench.run(15.0)
    bench.driver.obeyed("launch")
    bench.run(61.0, (0.0, 0.0))
    bench.fix = True
    bench.run(15.0, (0.0, 0.0))
    assert not bench.rover.armed
    assert bench.refused == "not armed: an operator has to say launch, resume or take"


@pytest.mark.parametrize("word", ["stop-now", "hold", "abort"])
def test_a_word_that_stops_withdraws_the_permission(bench: Bench, word: str) -> None:
    bench.run(2.0)
    bench.driver.obeyed("launch")
    bench.driver.obeyed(word)
    bench.run(5.0, (0.0, 0.0))
    assert not bench.rover.armed


def test_take_alone_arms_nothing_before_there_is_something_to_drive(bench: Bench) -> None:
    bench.run(2.0)
    bench.driver.obeyed("take")
    bench.run(5.0)
    assert not bench.rover.armed
    bench.run(5.0, (0.5, 0.0))
    assert bench.rover.armed


def test_an_arming_refusal_reaches_the_operator_in_the_autopilots_words_and_is_not_repeated_fast(bench: Bench) -> None:
    asked: list[int] = []
    bench.rover.unfit = lambda mode: "Arm: GPS 1: Bad fix"  # type: ignore[method-assign]
    arm = bench.rover._arm
    bench.rover._arm = lambda armed: (asked.append(bench.now_ns), arm(armed))[1]  # type: ignore[method-assign,func-returns-value]
    bench.run(2.0)
    bench.driver.vehicle.ready = True
    bench.driver.obeyed("launch")
    bench.look = lambda: setattr(bench.driver.vehicle, "ready", True)  # it said so a moment ago
    bench.run(10.0, (0.0, 0.0))
    assert 3 <= len(asked) <= 6
    assert "Arm: GPS 1: Bad fix" in bench.heard
    assert "arming: failed" in bench.heard


def test_another_vehicle_on_the_same_link_is_not_taken_for_ours(bench_of: Make) -> None:
    bench = bench_of(sysid=7)
    bench.run(5.0)
    assert not bench.known
    assert bench.reading.trouble.startswith("no autopilot with sysid 7 at udp:127.0.0.1:")
    assert bench.driver.frames.counts["others"] > 10


# -- driving -----------------------------------------------------------------------------------------------------------
def test_surge_and_yaw_rate_are_reached_and_positive_is_to_starboard(driven: Bench) -> None:
    psi = driven.state.psi
    driven.run(5.0, (1.0, 0.2))
    assert driven.state.u == pytest.approx(1.0, abs=0.1)
    assert driven.state.r == pytest.approx(0.2, abs=0.03)
    assert driven.state.psi > psi
    assert driven.reading.yaw_rate_radps == pytest.approx(driven.state.r, abs=0.02)


def test_what_is_read_is_what_the_hull_does(driven: Bench) -> None:
    reading, truth = driven.reading, driven.senses()
    assert abs(reading.stamp_ns - driven.now_ns) <= 120_000_000
    assert reading.lat_deg == pytest.approx(truth.lat_deg, abs=2e-6)
    assert reading.v_north_mps == pytest.approx(truth.v_north_mps, abs=0.02)
    assert reading.heading_rad == pytest.approx(truth.psi_rad, abs=0.01)
    assert reading.position_error_m == 0.5
    assert reading.battery_percent == 100.0


def test_streams_come_at_the_rates_asked_for(driven: Bench) -> None:
    assert rates(driven) == STREAMS


def test_a_set_point_that_is_no_number_is_refused(driven: Bench) -> None:
    assert "expected numbers" in driven.driver.write(math.nan, 0.0)


def test_a_set_point_from_an_old_reading_is_not_sent(driven: Bench) -> None:
    driven.now_ns += 400_000_000
    assert driven.driver.write(1.0, 0.0) == ""
    driven.now_ns += 200_000_000
    assert driven.driver.write(1.0, 0.0) == "the set-point is older than its limit"


# -- stopping ----------------------------------------------------------------------------------------------------------
def test_a_stop_is_zero_velocity_then_loiter(driven: Bench) -> None:
    modes: list[str] = []
    driven.look = lambda: modes.append(driven.mode)
    driven.run(1.0)
    assert driven.thrust.powered
    assert driven.rover.aim is not None
    assert driven.rover.aim.speed_mps == 0.0
    driven.run(6.0)
    assert modes[0] == "GUIDED"
    assert modes[-1] == "LOITER"
    assert driven.reading.authority == "", "we left it there ourselves"
    driven.run(3.0, (1.0, 0.0))
    assert driven.mode == "GUIDED", "and take it up again"


def test_a_stop_may_be_left_in_hold_without_thrust(bench_of: Make) -> None:
    bench = bench_of(stop="hold")
    bench.launch()
    bench.run(5.0, (1.0, 0.0))
    bench.run(7.0)
    assert bench.mode == "HOLD"
    assert not bench.thrust.powered


def test_closing_leaves_the_boat_on_station(driven: Bench) -> None:
    driven.driver.close()
    driven.driver_alive = False
    driven.run(1.0)
    assert driven.mode == "LOITER"


# -- who commands ------------------------------------------------------------------------------------------------------
def test_a_pilot_who_takes_the_boat_is_reported_and_not_fought(driven: Bench) -> None:
    driven.rover.pilot(words.MANUAL)
    driven.run(0.2, (1.0, 0.0))
    assert driven.reading.authority == "pilot or ground station: MANUAL"
    driven.run(10.0, (1.0, 0.0))
    assert driven.mode == "MANUAL"
    driven.rover.pilot(words.GUIDED)
    driven.run(0.5, (1.0, 0.0))
    assert driven.reading.authority == "", "given back"
    assert driven.refused == ""


def test_a_ground_station_that_steers_in_guided_while_we_stand_by_is_left_alone(driven: Bench) -> None:
    driven.run(8.0)
    assert driven.mode == "LOITER"
    driven.rover.pilot(words.GUIDED)
    driven.rover.aim = Aim(1.0, 0.0)
    driven.run(2.5)
    assert (driven.mode, driven.rover.aim) == ("GUIDED", Aim(1.0, 0.0))
    driven.driver.close()
    driven.run(0.2)
    assert driven.mode == "GUIDED"


def test_after_an_operators_word_the_boat_is_taken_back(driven: Bench) -> None:
    driven.rover.pilot(words.MANUAL)
    driven.run(2.0)
    driven.driver.obeyed("take")
    driven.run(0.2)
    assert driven.reading.authority == ""
    driven.run(3.0, (1.0, 0.0))
    assert driven.mode == "GUIDED"
    driven.rover.pilot(words.MANUAL)
    driven.run(3.0, (1.0, 0.0))
    assert driven.mode == "MANUAL", "the permission was used"


def test_a_ground_station_that_disarms_the_boat_is_not_fought(driven: Bench) -> None:
    driven.rover.armed = False
    driven.run(5.0, (1.0, 0.0))
    assert not driven.rover.armed
    assert driven.refused == "not armed: an operator has to say launch, resume or take"


def test_a_rebooted_autopilot_is_asked_for_its_streams_again_and_not_armed(driven: Bench) -> None:
    driven.rover.reboot()
    driven.run(50.0, (1.0, 0.0))
    assert not driven.rover.armed
    assert "the autopilot was restarted" in driven.heard
    assert driven.known
    assert rates(driven) == STREAMS
    assert driven.driver.vehicle.reboots == 1


def test_a_restart_of_the_autopilot_withdraws_the_permission(bench: Bench) -> None:
    bench.fix = False
    bench.run(12.0)
    bench.driver.obeyed("launch")
    bench.run(3.0, (0.0, 0.0))
    bench.rover.reboot()
    bench.fix = True
    bench.run(50.0, (0.0, 0.0))
    assert bench.rover.unfit(words.GUIDED) == ""
    assert not bench.rover.armed


def test_a_pilot_who_leaves_guided_before_the_boat_is_armed_is_not_fought(bench: Bench) -> None:
    bench.fix = False
    bench.run(12.0)
    bench.driver.obeyed("launch")
    bench.run(5.0, (0.0, 0.0))
    assert bench.mode == "GUIDED"
    bench.rover.pilot(words.HOLD)
    bench.fix = True
    bench.run(20.0, (0.0, 0.0))
    assert (bench.mode, bench.rover.armed) == ("HOLD", False)


def test_a_launch_makes_the_boat_ready_before_it_takes_effect_and_a_stop_undoes_that(bench: Bench) -> None:
    bench.run(2.0)
    bench.driver.obeyed("launch")
    bench.run(8.0)
    assert (bench.mode, bench.rover.armed) == ("GUIDED", True)
    bench.driver.obeyed("stop-now")
    bench.run(5.0)
    assert bench.mode == "LOITER"


# -- knowing where it is -----------------------------------------------------------------------------------------------
def test_a_cold_autopilot_that_says_zero_zero_is_not_believed(bench_of: Make) -> None:
    bench = bench_of(running_s=0.0)
    bench.look = lambda: pytest.fail("a position before the first") if bench.known else None  # type: ignore[func-returns-value]
    bench.run(41.0)
    bench.look = lambda: None
    bench.run(4.0)
    assert bench.known


def test_a_lost_fix_is_noticed_within_two_seconds_though_velocity_and_estimator_go_on(driven: Bench) -> None:
    driven.fix = False
    assert driven.until(lambda: not driven.known, 3.0, (1.0, 0.0)) <= 1.5
    assert driven.rover.flags == 0x33F, "the estimator has noticed nothing yet"


def test_without_navigation_a_stop_cuts_the_thrust(driven: Bench) -> None:
    driven.fix = False
    driven.until(lambda: not driven.known, 3.0, (1.0, 0.0))
    assert driven.until(lambda: not driven.thrust.powered, 3.0) < 0.5
    assert driven.mode == "HOLD"


def test_positions_that_stand_still_at_speed_are_frozen(driven: Bench) -> None:
    driven.rover._estimate = lambda dt: None  # type: ignore[method-assign]
    assert driven.until(lambda: not driven.known, 4.0, (1.0, 0.0)) <= 2.0
    assert "frozen" in driven.driver.vehicle.lost(driven.now_ns)


def test_one_wild_position_is_passed_over_and_ten_that_agree_are_believed(driven: Bench) -> None:
    driven.shift(x=driven.state.x + 500.0)
    driven.run(0.5, (1.0, 0.0))
    assert driven.driver.vehicle.counts["position"] > 10
    assert driven.reading.lat_deg < 44.3830, "not yet"
    driven.run(2.0, (1.0, 0.0))
    assert driven.reading.lat_deg == pytest.approx(driven.senses().lat_deg, abs=1e-5)


def test_messages_that_waited_in_a_queue_are_old(driven: Bench) -> None:
    driven.driver_alive = False
    driven.run(3.0)
    driven.now_ns += STEP_NS
    stamp_ns = driven.driver.read().stamp_ns
    assert driven.now_ns - stamp_ns <= 1_000_000_000, "all of three seconds were read, the newest counts"
    driven.now_ns += 2_000_000_000
    assert not math.isfinite(driven.driver.read().lat_deg)


def test_a_long_text_arrives_in_one_piece(driven: Bench) -> None:
    text = "PreArm: a sentence that is by far too long for the fifty characters of one message"
    driven.rover.say(4, text)
    driven.run(0.5, (1.0, 0.0))
    assert text in driven.heard


def test_the_autopilot_that_was_never_switched_on_is_said(bench: Bench) -> None:
    bench.port.hear = lambda: None  # type: ignore[method-assign]
    bench.run(2.0, (1.0, 0.0))
    assert bench.reading.trouble.startswith("no autopilot with sysid 1")
    assert bench.refused == bench.reading.trouble


def test_an_autopilot_that_falls_silent_is_said_within_four_seconds(driven: Bench) -> None:
    driven.port.speak = lambda: None  # type: ignore[method-assign]
    silent_s = driven.until(lambda: bool(driven.reading.trouble), 5.0, (1.0, 0.0))
    assert silent_s <= 4.0
    assert driven.reading.trouble.startswith("the autopilot is silent for ")


# -- other links -------------------------------------------------------------------------------------------------------
def test_an_autopilot_that_sends_to_us_is_answered(bench_of: Make) -> None:
    bench = bench_of(endpoint="udpin:127.0.0.1:0")
    bench.rover.streams.know(("127.0.0.1", bench.driver.link.port))  # type: ignore[attr-defined]
    bench.launch()
    bench.run(5.0, (0.5, 0.0))
    assert bench.state.u > 0.3


def test_a_connection_that_was_lost_is_opened_again_at_once_and_then_every_two_seconds() -> None:
    now_ns = BEGIN_NS
    with socket.create_server(("127.0.0.1", 0)) as server:
        driver = MavlinkDriver(MavlinkConfig(endpoint=f"tcp:127.0.0.1:{server.getsockname()[1]}"), lambda: now_ns)
        driver.open()
        server.accept()[0].close()
        driver.read()
        assert driver.link.up
        server.accept()[0].close()
        now_ns += 1_000_000_000
        driver.read()
        assert not driver.link.up
        assert driver.write(1.0, 0.0).startswith("no autopilot with sysid 1 at tcp:")
        now_ns += 1_000_000_000
        driver.read()
        now_ns += 100_000_000
        driver.read()
        again, _ = server.accept()
        again.settimeout(5.0)
        assert again.recv(500)[0] == 0xFD, "our HEARTBEAT"
        again.close()
        driver.close()
