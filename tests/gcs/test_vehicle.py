"""A boat as a vehicle: what it sends, how modes, arming, go-to and parameters become words to the fleet."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from fleet.agent.modes import Mode, Reason
from fleet.gcs.chart import turning_radius_m
from fleet.wire.messages import FleetEvent, Revision
from tests.gcs.deck import LAT, LON, NORTH, Deck, mission

HOLD, LOITER, AUTO, RTL, GUIDED, MANUAL = 4, 5, 10, 11, 15, 0
ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
LINE = mission((0.0, 0.0), (400.0, 0.0))


def test_every_boat_is_a_vehicle_of_its_own_with_heartbeats_once_a_second() -> None:
    deck = Deck("b1", "b2", "b10")
    deck.run(5.0)
    beats = deck.station.all("HEARTBEAT")
    assert {m.get_srcSystem() for m in beats} == {1, 2, 3}, "b2 comes before b10"
    assert {(m.get_srcComponent(), m.type, m.autopilot) for m in beats} == {(1, 11, 3)}
    assert len(deck.station.all("HEARTBEAT", 1)) == 5
    assert 19 <= len(deck.station.all("GLOBAL_POSITION_INT", 1)) <= 21
    for kind in ("SYS_STATUS", "BATTERY_STATUS", "GPS_RAW_INT", "VFR_HUD", "MISSION_CURRENT", "EKF_STATUS_REPORT"):
        assert deck.station.all(kind, 2), kind
    assert deck.station.all("HOME_POSITION", 2)


def test_where_a_boat_is_and_how_it_moves_arrive_in_mavlinks_units() -> None:
    deck = Deck("b1")
    deck.change("b1", cog_rad=math.pi / 2, sog_mps=1.5, heading_rad=-0.5, yaw_rate_radps=0.2)
    deck.run(1.0)
    p = deck.station.last("GLOBAL_POSITION_INT")
    assert (p.lat, p.lon, p.vx, p.vy) == (round(LAT * 1e7), round(LON * 1e7), 0, 150)
    assert p.hdg == round(math.degrees(-0.5) * 100) % 36000
    a = deck.station.last("ATTITUDE")
    assert (a.yaw, a.yawspeed) == (pytest.approx(-0.5), pytest.approx(0.2))
    assert deck.station.last("BATTERY_STATUS").battery_remaining == 80


def test_each_vehicle_counts_its_own_frames() -> None:
    deck = Deck("b1", "b2")
    deck.run(3.0)
    for sysid in (1, 2):
        numbers = [m.get_seq() for m in deck.station.heard if m.get_srcSystem() == sysid]
        assert all((b - a) % 256 == 1 for a, b in pairwise(numbers))


def test_a_boat_that_is_not_heard_says_so_and_beats_no_more_until_it_is() -> None:
    deck = Deck("b1", "b2")
    deck.dead.add("b2")
    deck.run(4.0)
    assert deck.station.texts(2) == ["b2 is not heard any more: no HEARTBEAT until it is"]
    deck.station.clear()
    deck.run(3.0)
    assert not deck.station.all("HEARTBEAT", 2)
    assert deck.station.all("HEARTBEAT", 1)
    deck.station.mode(2, AUTO)
    assert deck.station.last("COMMAND_ACK", 2).result == FAILED
    deck.dead.clear()
    deck.run(0.1)
    assert deck.station.all("HEARTBEAT", 2)


@pytest.mark.parametrize(
    ("mode", "shown", "is_armed", "status"),
    [
        (Mode.STANDBY, HOLD, False, 3),
        (Mode.FOLLOW, AUTO, True, 4),
        (Mode.AVOID, AUTO, True, 4),
        (Mode.ALONE, AUTO, True, 4),
        (Mode.HOLD, LOITER, True, 4),
        (Mode.RETURN, RTL, True, 4),
        (Mode.NEUTRAL, HOLD, False, 3),
        (Mode.FAULT, HOLD, False, 5),
    ],
)
def test_modes_of_the_fleet_are_shown_as_rovers(mode: Mode, shown: int, is_armed: bool, status: int) -> None:
    deck = Deck("b1")
    deck.change("b1", mode=int(mode))
    deck.run(1.0)
    beat = deck.station.last("HEARTBEAT")
    assert (beat.custom_mode, bool(beat.base_mode & 128), beat.system_status) == (shown, is_armed, status)


@pytest.mark.parametrize(
    ("mode", "word"), [(HOLD, "hold"), (LOITER, "hold"), (GUIDED, "hold"), (RTL, "return"), (12, "return")]
)
def test_a_mode_is_a_word_to_the_fleet_and_acknowledged_when_the_boat_has(mode: int, word: str) -> None:
    deck = Deck("b1", "b2")
    deck.sails(_fleet(deck))
    deck.station.clear()
    deck.station.mode(2, mode)
    assert not deck.station.all("COMMAND_ACK"), "nobody has answered yet"
    assert deck.does(word).boat == "b2"
    assert deck.station.last("COMMAND_ACK", 2).result == ACCEPTED
    assert deck.station.last("HEARTBEAT", 2).custom_mode == mode, "at once: stations wait for it"


def _fleet(deck: Deck):  # type: ignore[no-untyped-def]
    """The mission that was uploaded, as it was charted."""
    assert deck.station.upload(1, LINE) == -1
    wish = deck.does("chart")
    return wish.value


def test_a_refusal_of_the_boat_arrives_in_words() -> None:
    deck = Deck("b1")
    deck.sails(_fleet(deck))
    deck.station.mode(1, RTL)
    deck.does("return", ok=False, text="anna holds control; `fleet take` takes it over")
    assert deck.station.last("COMMAND_ACK").result == DENIED
    assert deck.station.texts()[-1] == "RTL refused: anna holds control; `fleet take` takes it over"


def test_a_mode_that_no_fleet_has_is_refused_in_words() -> None:
    deck = Deck("b1")
    deck.station.mode(1, MANUAL)
    assert deck.station.last("COMMAND_ACK").result == DENIED
    assert "MANUAL refused: boats of a fleet know HOLD, LOITER, AUTO" in deck.station.texts()[0]
    assert not deck.wishes


def test_hold_of_a_boat_that_waits_moves_nothing_and_loiter_makes_it_keep_station() -> None:
    deck = Deck("b1")
    deck.station.mode(1, HOLD)
    assert deck.station.last("COMMAND_ACK").result == ACCEPTED
    assert not deck.wishes
    deck.station.mode(1, LOITER)
    deck.does("hold")


def test_a_command_said_again_while_it_is_done_is_done_once() -> None:
    deck = Deck("b1")
    deck.sails(_fleet(deck))
    deck.station.clear()
    for _ in range(3):
        deck.station.mode(1, RTL)
    deck.does("return")
    assert len(deck.station.all("COMMAND_ACK")) == 1


def test_set_mode_and_pause_and_the_other_ways_to_say_it_mean_the_same() -> None:
    deck = Deck("b1")
    deck.sails(_fleet(deck))
    deck.station.say("set_mode", 1, 1, HOLD)
    deck.does("hold")
    deck.station.command(1, 193, 0)
    deck.does("hold")
    deck.station.command(1, 17)
    deck.does("hold")
    deck.station.command(1, 20)
    deck.does("return")
    deck.change("b1", mode=int(Mode.HOLD))
    deck.bridge.shared.charted = None
    deck.station.command(1, 193, 1)
    deck.does("resume")


def test_guided_arm_start_as_a_station_says_it_launches_what_was_uploaded() -> None:
    deck = Deck("b1", "b2")
    plan = _fleet(deck)
    deck.station.clear()
    deck.station.mode(1, GUIDED)
    assert deck.station.last("HEARTBEAT", 1).custom_mode == GUIDED
    deck.station.command(1, 400, 1)
    assert deck.does("ready").value == ()
    assert deck.station.last("HEARTBEAT", 1).base_mode & 128
    deck.station.command(1, 300)
    wish = deck.does("start", value="2000-gcs")
    assert [boat.name for boat in wish.value.boats] == ["b1", "b2"]
    assert wish.value.paths == plan.paths
    assert deck.station.last("COMMAND_ACK", 1).result == ACCEPTED
    assert deck.station.last("HEARTBEAT", 1).custom_mode == AUTO, "before the boats begin, two seconds later"


def test_auto_without_a_mission_says_so() -> None:
    deck = Deck("b1")
    deck.station.mode(1, AUTO)
    assert deck.station.last("COMMAND_ACK").result == FAILED
    assert deck.station.texts() == ["AUTO refused: no mission; upload one"]


def test_auto_of_a_held_boat_resumes_and_of_one_under_way_is_nothing_new() -> None:
    deck = Deck("b1")
    plan = _fleet(deck)
    deck.bridge.shared.charted = None
    deck.sails(plan, mode=Mode.HOLD)
    deck.station.mode(1, AUTO)
    deck.does("resume")
    deck.change("b1", mode=int(Mode.FOLLOW))
    deck.station.mode(1, AUTO)
    assert not deck.wishes


# -- arming --------------------------------------------------------------------------------------------------------
def test_disarming_stops_and_arming_lifts_the_bridges_own_stop() -> None:
    deck = Deck("b1")
    deck.station.command(1, 400, 0)
    deck.does("stop", value="stop-7")
    deck.change("b1", mode=int(Mode.NEUTRAL), stops=("stop-7",), reasons=int(Reason.STOPPED))
    deck.run()
    assert not deck.station.last("HEARTBEAT").base_mode & 128
    deck.station.command(1, 400, 1)
    assert deck.does("ready").value == ("stop-7",)


def test_somebody_elses_stop_is_not_lifted_by_arming() -> None:
    deck = Deck("b1")
    deck.change("b1", mode=int(Mode.NEUTRAL), stops=("theirs",))
    deck.run()
    deck.station.command(1, 400, 1)
    assert deck.station.last("COMMAND_ACK").result == DENIED
    assert "stopped by another operator" in deck.station.texts()[-1]


@pytest.mark.parametrize("force", [21196.0, 2989.0])
def test_arming_by_force_is_refused(force: float) -> None:
    deck = Deck("b1")
    deck.station.command(1, 400, 1, force)
    assert deck.station.last("COMMAND_ACK").result == DENIED
    assert deck.station.texts() == ["arming by force refused"]


def test_who_does_not_hold_control_cannot_arm_but_can_disarm() -> None:
    deck = Deck("b1")
    deck.change("b1", control=Revision(1, "anna"))
    deck.run()
    deck.station.command(1, 400, 1)
    assert deck.station.texts() == ["arming refused: anna holds control; FLT_CONTROL 1 takes it"]
    deck.station.command(1, 400, 0, 21196.0)
    deck.does("stop", value="s")


def test_a_boat_without_navigation_is_not_armed() -> None:
    deck = Deck("b1")
    deck.change("b1", mode=int(Mode.FAULT), reasons=int(Reason.NAVIGATION))
    deck.run()
    deck.station.command(1, 400, 1)
    assert deck.station.texts() == ["arming refused: own navigation is stale or not finite"]


# -- go-to ---------------------------------------------------------------------------------------------------------
def go(deck: Deck, sysid: int, north_m: float, east_m: float = 0.0) -> None:
    x, y = round((LAT + north_m * NORTH) * 1e7), round((LON + east_m * NORTH) * 1e7)
    deck.station.say("command_int", sysid, 1, 0, 192, 0, 0, -1.0, 1.0, 0.0, math.nan, x, y, 50.0)


def test_a_go_to_is_a_straight_mission_of_one_boat_that_is_shown_as_guided() -> None:
    deck = Deck("b1", "b2")
    go(deck, 2, 60.0)
    wish = deck.does("start", value="3000-gcs")
    assert [boat.name for boat in wish.value.boats] == ["b2"]
    end = wish.value.paths["uploaded"].end
    assert end.lat_deg == pytest.approx(LAT + 60.0 * NORTH, abs=1e-7)
    deck.change("b2", mode=int(Mode.FOLLOW), mission_id="3000-gcs")
    deck.run(10.0)
    assert deck.station.last("HEARTBEAT", 2).custom_mode == GUIDED


def test_a_go_to_does_not_tear_a_formation() -> None:
    deck = Deck("b1", "b2")
    deck.sails(_fleet(deck))
    go(deck, 2, 60.0)
    assert deck.station.last("COMMAND_ACK", 2).result == DENIED
    text = "go-to refused: a go-to would take b2 out of a formation of 2; HOLD it first"
    assert deck.station.texts()[-1] == text
    deck.change("b2", mode=int(Mode.HOLD))
    go(deck, 2, 60.0)
    deck.does("start", value="x")


def test_a_go_to_nowhere_is_refused_and_one_without_a_place_holds() -> None:
    deck = Deck("b1")
    deck.station.say("command_int", 1, 1, 0, 192, 0, 0, -1.0, 1.0, 0.0, 0.0, 0, 0, 0.0)
    assert "is no position" in deck.station.texts()[-1]
    deck.station.say("command_int", 1, 1, 0, 192, 0, 0, -1.0, 1.0, 0.0, 0.0, 2**31 - 1, 2**31 - 1, 0.0)
    deck.does("hold")


# -- parameters ----------------------------------------------------------------------------------------------------
def test_all_parameters_are_told_with_their_numbers() -> None:
    deck = Deck("b1")
    deck.station.say("param_request_list", 1, 1)
    told = deck.station.all("PARAM_VALUE")
    assert [m.param_index for m in told] == list(range(told[0].param_count))
    values = {m.param_id: m.param_value for m in told}
    assert (values["FLT_SPACING"], values["FLT_CRUISE"], values["MAV_SYSID"]) == (15.0, 1.0, 1.0)
    assert {m.param_type for m in told} == {9}


def test_a_parameter_under_way_is_a_change_of_the_formation_and_all_are_told() -> None:
    deck = Deck("b1", "b2")
    deck.sails(_fleet(deck))
    deck.station.say("param_request_read", 2, 1, b"FLT_SPACING", -1)
    deck.station.clear()
    deck.station.set(1, "FLT_SPACING", 12.0)
    assert deck.does("set").value == ("spacing", 12.0)
    assert deck.station.last("PARAM_VALUE", 1).param_value == 12.0
    deck.run(1.5)
    assert deck.station.last("PARAM_VALUE", 2).param_value == 12.0, "the other's is the same one"


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("FLT_SPACING", 500.0, "FLT_SPACING 500: expected -200 to 200"),
        ("FLT_CRUISE", math.nan, "FLT_CRUISE nan: expected 0.05 to 20"),
        ("FLT_PATTERN", 1.5, "FLT_PATTERN 1.5: expected a whole number"),
        ("MAV_SYSID", 7.0, "MAV_SYSID cannot be set"),
        ("FLT_CONTROL", 0.0, "control is not given back"),
    ],
)
def test_a_value_that_cannot_be_is_answered_with_the_old_one_and_words(name: str, value: float, why: str) -> None:
    deck = Deck("b1")
    deck.station.say("param_request_read", 1, 1, name.encode(), -1)
    before = deck.station.last("PARAM_VALUE").param_value
    deck.station.set(1, name, value)
    assert deck.station.last("PARAM_VALUE").param_value == before
    assert why in deck.station.texts()[-1]
    assert not deck.wishes


def test_what_the_boats_refuse_leaves_the_old_value() -> None:
    deck = Deck("b1", "b2")
    deck.sails(_fleet(deck))
    deck.station.set(1, "FLT_SPACING", 3.0)
    deck.does("set", ok=False, text="spacing 3 m: b1 and b2 are 3.0 m apart")
    assert deck.station.last("PARAM_VALUE").param_value == 15.0
    assert deck.station.texts()[-1] == "FLT_SPACING refused: spacing 3 m: b1 and b2 are 3.0 m apart"


def test_values_set_before_a_mission_are_those_of_the_next_one() -> None:
    deck = Deck("b1", "b2")
    for name, value in (("FLT_SPACING", 20.0), ("FLT_CRUISE", 0.7), ("FLT_GAIN", 0.2), ("FLT_PATTERN", 1.0)):
        deck.station.set(1, name, value)
        assert deck.station.last("PARAM_VALUE").param_value == pytest.approx(value)
    formation = _fleet(deck).formation
    assert (formation.spacing_m, formation.cruise_mps, formation.gain_per_m) == (20.0, 0.7, 0.2)
    assert formation.pattern == "abreast"


# -- who commands --------------------------------------------------------------------------------------------------
def test_two_ground_stations_do_not_take_turns() -> None:
    deck = Deck("b1")
    deck.sails(_fleet(deck))
    second = deck.join(sysid=254)
    deck.station.mode(1, RTL)
    deck.does("return")
    second.mode(1, AUTO)
    assert second.last("COMMAND_ACK").result == DENIED
    assert second.texts()[-1] == "AUTO refused: another ground station commands; FLT_CONTROL 1 takes over"
    second.mode(1, LOITER)
    deck.does("hold")
    second.set(1, "FLT_CONTROL", 1.0)
    deck.does("take")
    deck.station.mode(1, RTL)
    assert deck.station.last("COMMAND_ACK").result == DENIED


def test_the_seat_of_a_ground_station_that_left_is_free() -> None:
    deck = Deck("b1")
    deck.sails(_fleet(deck))
    second = deck.join(sysid=254)
    deck.station.mode(1, RTL)
    deck.does("return")
    deck.run(11.0)
    second.mode(1, RTL)
    deck.does("return")


# -- what stations ask when they connect ---------------------------------------------------------------------------
def test_everything_that_is_asked_at_the_beginning_is_answered_at_once() -> None:
    deck = Deck("b1")
    s = deck.station
    s.command(1, 512, 148)
    version = s.last("AUTOPILOT_VERSION")
    assert version.capabilities & 8192
    assert version.capabilities & 4
    for unknown in (435, 397, 300, 395):
        s.command(1, 512, unknown)
        assert s.last("COMMAND_ACK").result == UNSUPPORTED
    s.command(1, 4242)
    assert s.last("COMMAND_ACK").result == UNSUPPORTED
    s.command(1, 511, 33, 250_000)
    assert s.last("COMMAND_ACK").result == ACCEPTED
    for kind in (0, 1, 2):
        s.say("mission_request_list", 1, 1, kind)
        assert (s.last("MISSION_COUNT").count, s.last("MISSION_COUNT").mission_type) == (0, kind)
    s.say("timesync", 0, 777)
    assert s.last("TIMESYNC").ts1 == 777
    assert s.last("TIMESYNC").tc1 > 0
    s.say("ping", 1, 9, 0, 0)
    assert s.last("PING").seq == 9
    s.say("file_transfer_protocol", 0, 1, 1, [5, 0, 1, 4] + [0] * 247)
    answer = s.last("FILE_TRANSFER_PROTOCOL").payload
    assert (answer[0], answer[3], answer[5]) == (6, 129, 4)


def test_messages_for_others_are_not_answered() -> None:
    deck = Deck("b1")
    deck.station.mode(9, HOLD)
    deck.station.say("command_long", 1, 154, 512, 0, 148, *(0.0,) * 6)
    assert not deck.station.all("COMMAND_ACK")


def test_events_and_long_texts_arrive_whole_and_a_flood_is_bounded() -> None:
    deck = Deck("b1")
    long = "keeping clear of b2, leaving it to port, and of another that has a long name"
    deck.events = [FleetEvent(1, "b1", 1, "avoid", long)]
    deck.run()
    assert deck.station.texts() == [f"avoid: {long}"]
    deck.events = [FleetEvent(1, "b1", 1, "avoid", str(i)) for i in range(1000)]
    deck.run()
    assert len(deck.station.texts()) < 20


def test_a_slot_is_asked_for_by_the_boats_own_parameter() -> None:
    deck = Deck("b1", "b2")
    deck.sails(_fleet(deck))
    deck.station.set(2, "FLT_SLOT", 1.0)
    assert deck.does("set").value == ("slots", "b2=1.0")


def test_corners_are_as_round_as_the_fastest_of_the_roster_needs() -> None:
    deck = Deck("b1")
    plan = _fleet(deck)
    assert turning_radius_m(plan) == pytest.approx(1.05 * 1.5 / 0.35)
