"""gpsd's reports to fixes: what is believed of them, and what is not."""

from __future__ import annotations

import json
import math

import pytest

from fleet.drivers.gpsd.receiver import GpsdOptions, GpsdReceiver
from fleet.drivers.seam import Observed

MS = 1_000_000
TPV = {
    "class": "TPV",
    "device": "/dev/ttyACM0",
    "mode": 3,
    "time": "2025-11-28T12:00:00.000Z",
    "lat": 44.38,
    "lon": 8.93,
    "epx": 3.0,
    "epy": 4.0,
    "track": 90.0,
    "speed": 1.5,
    "eps": 0.4,
    "magtrack": 88.0,
    "altHAE": 12.0,
}


def heard(*reports: dict[str, object], options: GpsdOptions | None = None) -> tuple[Observed, GpsdReceiver]:
    receiver = GpsdReceiver(options or GpsdOptions())
    for i, report in enumerate(reports):
        receiver.take(json.dumps(report).encode(), (i + 1) * 100 * MS)
    return receiver.observed(0), receiver


def why(**fields: object) -> str:
    said, receiver = heard({key: value for key, value in {**TPV, **fields}.items() if value is not None})
    assert said.fix_ns == 0
    (reason,) = receiver.counts
    return reason


def test_a_report_is_a_fix_with_errors_of_one_sigma() -> None:
    said, receiver = heard(TPV)
    assert (said.fix_ns, said.lat_deg, said.lon_deg) == (100 * MS, 44.38, 8.93)
    assert (said.v_north_mps, said.v_east_mps) == (pytest.approx(0.0, abs=1e-9), 1.5)
    assert (said.position_error_m, said.velocity_error_mps) == (2.0, 0.2)
    assert receiver.counts == {"accepted": 1}


def test_the_error_may_be_known_better_than_gpsd_knows_it() -> None:
    assert heard(TPV, options=GpsdOptions(position_error_m=1.5))[0].position_error_m == 1.5
    bare = {key: value for key, value in TPV.items() if key not in ("epx", "epy")}
    assert heard(bare)[0].position_error_m == 3.0
    assert heard({**bare, "eph": 4.9})[0].position_error_m == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"mode": 1}, "no fix"),
        ({"mode": 0}, "no fix"),
        ({"mode": 3, "status": 8}, "not a measured fix"),
        ({"lat": None}, "no position"),
        ({"lat": 0.0, "lon": 0.0}, "position 0, 0"),
        ({"lat": 91.0}, "not a position"),
        ({"time": None}, "no time"),
        ({"time": "yesterday"}, "not a time"),
        ({"speed": 60.0}, "implausible"),
        ({"track": 361.0}, "implausible"),
        ({"epx": -1.0, "epy": None}, "implausible"),
        ({"lat": "44"}, "not a report"),
        ({"class": "SKY"}, "not used"),
    ],
)
def test_what_is_no_fix_says_why(fields: dict[str, object], reason: str) -> None:
    assert why(**fields) == reason


def test_without_speed_there_is_no_velocity_and_at_rest_no_course_is_needed() -> None:
    none, _ = heard({key: value for key, value in TPV.items() if key not in ("speed", "track")})
    assert math.isnan(none.v_north_mps)
    rest, _ = heard({**{key: value for key, value in TPV.items() if key != "track"}, "speed": 0.01})
    assert (rest.v_north_mps, rest.v_east_mps) == (0.0, 0.0)


def test_the_same_report_again_is_not_a_second_fix() -> None:
    _, receiver = heard(TPV, TPV)
    assert receiver.counts == {"accepted": 1, "time does not advance": 1}


def test_a_jump_is_refused() -> None:
    _, receiver = heard(TPV, {**TPV, "lat": 44.39, "time": "2025-11-28T12:00:00.100Z"})
    assert receiver.counts == {"accepted": 1, "position jumps": 1}


def test_heading_and_rate_of_turn_come_with_reports_of_the_attitude() -> None:
    said, _ = heard({"class": "ATT", "device": "/dev/ttyUSB1", "heading": 350.0, "rot": 60.0, "mag_st": "N"})
    assert math.degrees(said.heading_rad) == pytest.approx(-10.0)
    assert math.degrees(said.yaw_rate_radps) == pytest.approx(1.0)
    assert said.fix_ns == 0


def test_of_several_receivers_one_may_be_chosen() -> None:
    said, receiver = heard(TPV, options=GpsdOptions(device="/dev/ttyUSB9"))
    assert said.fix_ns == 0
    assert receiver.counts == {"another device": 1}


@pytest.mark.parametrize("line", [b"", b"{", b"[]", b"null", b'{"class": 3}', b'{"class":"TPV","mode":', b"\xff\x00"])
def test_what_is_no_report_is_counted(line: bytes) -> None:
    receiver = GpsdReceiver(GpsdOptions())
    receiver.take(line, 1)
    assert receiver.counts == {"not a report": 1}
