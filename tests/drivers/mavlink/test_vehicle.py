"""What of an autopilot's messages is believed, message by message."""

from __future__ import annotations

import math
from typing import Any

import pytest

from fleet.drivers.mavlink.gate import Gate
from fleet.drivers.mavlink.vehicle import Vehicle
from fleet.drivers.mavlink.words import dialect

M = dialect()
BEGIN_NS = 1_700_000_000_000_000_000
TICK_NS = 100_000_000
GOOD = 0x33F


class Told:
    """A vehicle, and an autopilot whose every field can be chosen."""

    def __init__(self) -> None:
        self.vehicle, self.now_ns, self.boot_ms, self.north_m = Vehicle(), BEGIN_NS, 60_000, 0.0

    def tick(self, ticks: int = 1, *, flags: int = GOOD, fix: int = 3, mps: float = 1.0, **less: Any) -> None:
        """A tenth of a second of messages; `less` names those that are missing, or gives a position of its own."""
        for _ in range(ticks):
            self.now_ns += TICK_NS
            self.boot_ms += 100
            self.north_m += 0.1 * mps
            lat = less.get("lat", round((44.38 + self.north_m / 111_195.0) * 1e7))
            lon = less.get("lon", round(8.93e7))
            said = {
                "position": M.MAVLink_global_position_int_message(
                    self.boot_ms, lat, lon, 0, 0, round(mps * 100), 0, 0, 0
                ),
                "attitude": M.MAVLink_attitude_message(self.boot_ms, 0.0, 0.0, 0.3, 0.0, 0.0, 0.1),
                "estimator": M.MAVLink_ekf_status_report_message(flags, 0.0, 0.0, 0.0, 0.0, 0.0),
                "fix": M.MAVLink_gps_raw_int_message(0, fix, 0, 0, 0, 80, 80, 0, 0, 9, 0, 400, 0, 0),
            }
            for kind, message in said.items():
                if less.get(kind, True):
                    self.vehicle.take(message, self.now_ns)

    @property
    def lost(self) -> str:
        return self.vehicle.lost(self.now_ns)


@pytest.fixture
def told() -> Told:
    one = Told()
    one.tick(20)
    assert one.lost == ""
    return one


def test_a_good_vehicle_is_read_with_its_errors(told: Told) -> None:
    reading = told.vehicle.reading(told.now_ns)
    assert reading.stamp_ns == told.now_ns
    assert (reading.v_north_mps, reading.heading_rad) == (1.0, pytest.approx(0.3))
    assert reading.position_error_m == 0.4


@pytest.mark.parametrize("flags", [0x400, 0, 0xA7, 0x27 & ~0x10, GOOD | 0x80, GOOD | 0x400])
def test_navigation_is_good_only_when_the_estimator_says_so(told: Told, flags: int) -> None:
    told.tick(flags=flags)
    assert told.lost == f"the estimator has no position (flags {flags:#x})"
    assert math.isnan(told.vehicle.reading(told.now_ns).lat_deg)


def test_an_estimator_that_falls_silent_says_nothing_good(told: Told) -> None:
    told.tick(26, estimator=False)
    assert told.lost == "the estimator does not report"


def test_a_fix_that_was_there_and_is_gone_counts(told: Told) -> None:
    told.tick(10, fix=1)
    assert told.lost == ""
    told.tick(1, fix=1)
    assert told.lost == "the GNSS receiver has lost its fix"


def test_a_boat_that_never_had_gnss_is_believed_by_its_estimator_alone() -> None:
    told = Told()
    told.tick(20, fix=0)
    assert told.lost == ""


@pytest.mark.parametrize("missing", ["position", "attitude"])
def test_an_old_position_or_attitude_is_none(told: Told, missing: str) -> None:
    told.tick(10, **{missing: False})
    assert told.lost == ""
    told.tick(1, **{missing: False})
    assert told.lost == "position or attitude is old"


def test_zero_zero_is_no_position_whatever_the_estimator_says() -> None:
    told = Told()
    told.tick(30, lat=0, lon=0)
    assert told.vehicle.counts["position"] == 30
    assert told.lost == "position or attitude is old"


def test_a_boat_at_rest_is_not_frozen(told: Told) -> None:
    told.tick(100, mps=0.0)
    assert told.lost == ""


def test_stamps_follow_the_quickest_messages(told: Told) -> None:
    told.now_ns += 300_000_000  # these come late
    told.tick(3)
    assert told.vehicle.reading(told.now_ns).stamp_ns == pytest.approx(told.now_ns - 300_000_000, abs=1_000_000)


def test_one_message_from_the_future_is_not_believed(told: Told) -> None:
    future = M.MAVLink_attitude_message(told.boot_ms + 100_000, 0.0, 0.0, 0.3, 0.0, 0.0, 0.1)
    told.vehicle.take(future, told.now_ns)
    told.tick(3)
    assert told.vehicle.counts["time"] == 1
    assert told.vehicle.reading(told.now_ns).stamp_ns == pytest.approx(told.now_ns, abs=1_000_000)


def test_a_time_that_goes_back_is_a_restart_when_three_messages_say_so(told: Told) -> None:
    past = M.MAVLink_attitude_message(5_000, 0.0, 0.0, 0.3, 0.0, 0.0, 0.1)
    told.vehicle.take(past, told.now_ns)
    told.tick(2)
    assert (told.vehicle.reboots, told.lost) == (0, "")
    told.boot_ms = 5_000
    told.tick(3)
    assert told.vehicle.reboots == 1
    assert told.lost


@pytest.mark.parametrize(("yaw", "rate"), [(math.nan, 0.0), (0.3, math.inf), (9.0, 0.0), (0.3, 50.0)])
def test_an_attitude_that_cannot_be_is_refused(told: Told, yaw: float, rate: float) -> None:
    told.vehicle.take(M.MAVLink_attitude_message(told.boot_ms + 50, 0.0, 0.0, yaw, 0.0, 0.0, rate), told.now_ns)
    assert told.vehicle.counts["attitude"] >= 1
    assert told.vehicle.reading(told.now_ns).heading_rad == pytest.approx(0.3)


def test_a_gate_lets_through_what_is_near_and_what_is_said_again_and_again() -> None:
    gate = Gate(1.0, 0.0, agree=3)
    assert [gate.passes((0.0,), t) for t in range(3)] == [False, False, True]
    assert gate.passes((0.9,), 3)
    assert [gate.passes((5.0,), t) for t in range(4, 7)] == [False, False, True]
    assert [gate.passes((9.0,), 7), gate.passes((20.0,), 8), gate.passes((9.0,), 9)] == [False] * 3
    assert gate.passes((5.5,), 10), "what disagrees with itself changes nothing"
