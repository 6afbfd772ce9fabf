"""A driver with sensors beside it: whose word counts, and what is said when one goes silent."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from fleet.agent.config import load_config
from fleet.drivers.seam import Observed, Reading, Scan, Sighting
from fleet.drivers.sensors.choice import Choice
from fleet.drivers.sensors.config import EVERYTHING, SensorConfig
from fleet.drivers.sensors.equipped import Equipped, Fitted
from fleet.drivers.sensors.kinds import equipped, wrong_sensors
from fleet.errors import ConfigError
from fleet.sensing.scan import packed

S = 1_000_000_000
SHIP = Sighting(S, "ais", "mmsi-247000001", 44.4, 8.9, 10.0)
SCAN = Scan(S, -1.0, 0.1, packed((5.0, math.nan, 7.0)), 30.0)


class Thrusters:
    """A driver that may know where it is."""

    simulated = True

    def __init__(self, reading: Reading) -> None:
        self.reading, self.calls = reading, [""]

    def open(self) -> None:
        self.calls.append("open")

    def read(self) -> Reading:
        return self.reading

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        return f"{surge_mps:g} {yaw_rate_radps:g}"

    def neutral(self) -> None:
        self.calls.append("neutral")

    def close(self) -> None:
        self.calls.append("close")


class Said:
    """A sensor that says what it is told to."""

    gives = EVERYTHING

    def __init__(self) -> None:
        self.next: list[Observed] = []
        self.closed = False

    def open(self) -> None: ...

    def read(self, now_ns: int) -> Observed:  # noqa: ARG002
        return self.next.pop(0) if self.next else Observed()

    def close(self) -> None:
        self.closed = True


def fix(lat_deg: float, stamp_ns: int) -> Observed:
    return Observed(stamp_ns, lat_deg, 8.9, 1.5, 1.0, 0.0, 0.1)


class Boat:
    def __init__(self, sensors: int, own: Reading | None = None, use: frozenset[str] = EVERYTHING) -> None:
        self.now_ns = 100 * S
        self.sensors = [Said() for _ in range(sensors)]
        self.driver = Thrusters(own or Reading(stamp_ns=0, battery_percent=80.0))
        fitted = [Fitted(f"gnss-{i}", one, use) for i, one in enumerate(self.sensors)]
        self.equipped = Equipped(self.driver, fitted, lambda: self.now_ns)

    def read(self, *said: Observed | None) -> Reading:
        for sensor, one in zip(self.sensors, said, strict=True):
            sensor.next = [one] if one is not None else []
        self.now_ns += S // 10
        return self.equipped.read()


def test_position_of_one_sensor_and_heading_of_another_are_one_raw_reading_with_their_own_stamps() -> None:
    boat = Boat(2)
    heading = Observed(heading_ns=100 * S + 2, heading_rad=1.0, heading_error_rad=0.02)
    reading = boat.read(fix(44.1, 100 * S + 1), heading)
    assert reading.raw
    assert (reading.lat_deg, reading.stamp_ns, reading.velocity_error_mps) == (44.1, 100 * S + 1, 0.1)
    assert (reading.heading_rad, reading.heading_stamp_ns, reading.heading_error_rad) == (1.0, 100 * S + 2, 0.02)
    assert math.isnan(reading.yaw_rate_radps)
    assert reading.battery_percent == 80.0


def test_nothing_is_said_twice() -> None:
    boat = Boat(1)
    assert boat.read(fix(44.1, 1)).lat_deg == 44.1
    again = boat.read(None)
    assert math.isnan(again.lat_deg)
    assert again.stamp_ns == 0


def test_the_second_receiver_is_believed_after_two_seconds_without_the_first_and_the_first_again_after_three() -> None:
    boat = Boat(2)
    used = []
    for k in range(120):
        first_well = not 20 <= k < 60
        reading = boat.read(fix(44.1, 1) if first_well else None, fix(44.2, 1))
        used.append(reading.lat_deg)
    assert set(used[:20]) == {44.1}
    assert all(map(math.isnan, used[20:39]))  # the gap is shorter than what the fusion reckons over
    assert set(used[41:60]) == {44.2}
    assert set(used[60:89]) == {44.2}
    assert set(used[91:]) == {44.1}
    assert boat.equipped.noted() == ["fix from gnss-0", "fix from gnss-1", "fix from gnss-0"]


def test_what_the_driver_measures_comes_last_each_value_once() -> None:
    own = Reading(50 * S, 44.3, 8.9, 0.5, 1.0, 0.0, 0.1, 2.0, raw=True, heading_error_rad=0.03)
    boat = Boat(1, own)
    reading = boat.read(None)
    assert (reading.lat_deg, reading.heading_rad, reading.yaw_rate_radps) == (44.3, 0.5, 0.1)
    assert math.isnan(boat.read(None).lat_deg)
    boat.driver.reading = Reading(101 * S, 44.3, 8.9, 0.5, 1.0, 0.0, 0.1, 2.0, raw=True)
    assert boat.read(fix(44.1, 101 * S)).lat_deg == 44.3  # the better sensor has just begun
    for k in range(40):
        boat.driver.reading = Reading((102 + k) * S, 44.3, 8.9, 0.5, 1.0, 0.0, 0.1, 2.0, raw=True)
        reading = boat.read(fix(44.1, (102 + k) * S))
    assert (reading.lat_deg, reading.heading_rad) == (44.1, 0.5)


def test_a_scanner_and_an_ais_receiver_leave_the_drivers_own_navigation_as_it_is() -> None:
    own = Reading(50 * S, 44.3, 8.9, 0.5, 1.0, 0.0, 0.1, 2.0)
    boat = Boat(1, own, frozenset({"traffic", "scan"}))
    assert boat.read(None) is own
    reading = boat.read(Observed(sightings=(SHIP,), scans=(SCAN,)))
    assert (reading.lat_deg, reading.raw) == (44.3, False)
    assert (reading.sightings, reading.scans) == ((SHIP,), (SCAN,))


def test_of_a_sensor_only_what_is_to_be_used_is_used() -> None:
    boat = Boat(1, use=frozenset({"heading"}))
    reading = boat.read(Observed(1, 44.1, 8.9, 1.0, heading_ns=1, heading_rad=0.3, sightings=(SHIP,), scans=(SCAN,)))
    assert math.isnan(reading.lat_deg)
    assert reading.heading_rad == 0.3
    assert (reading.sightings, reading.scans) == ((), ())


def test_a_silent_sensor_is_named_while_it_is_and_told_once() -> None:
    boat = Boat(1)
    for _ in range(3):
        assert boat.read(Observed(trouble="silent")).amiss == ("gnss-0: silent",)
    assert boat.equipped.noted() == ["gnss-0: silent"]
    assert boat.read(fix(44.1, 1)).amiss == ()
    assert boat.equipped.noted() == ["gnss-0: well again", "fix from gnss-0"]
    assert boat.read(None).trouble == ""  # the boat can be commanded all the while


def test_a_sensor_of_another_package_that_raises_is_in_trouble_and_nothing_else() -> None:
    boat = Boat(1)
    boat.sensors[0].read = lambda now_ns: 1 // 0  # type: ignore[assignment, method-assign, return-value]
    reading = boat.read(None)
    assert reading.amiss == ("gnss-0: its driver failed: ZeroDivisionError: integer division or modulo by zero",)


def test_the_driver_steers_and_all_are_closed() -> None:
    boat = Boat(1)
    boat.equipped.open()
    assert boat.equipped.write(1.0, 0.2) == "1 0.2"
    boat.equipped.neutral()
    boat.equipped.close()
    assert boat.driver.calls == ["", "open", "neutral", "close"]
    assert boat.sensors[0].closed


def test_the_first_to_speak_is_believed_at_once() -> None:
    choice = Choice()
    assert choice.take(2, 0)
    assert not choice.take(1, 1)
    assert choice.take(2, 2)


def test_sensors_that_cannot_be_are_refused_in_words(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    head = 'boat = "b1"\n[link]\ntopology = "hub"\n'
    file.write_text(head + '[[driver.sensors]]\nkind = "sextant"\n')
    with pytest.raises(ConfigError, match=r'driver.sensors, sextant: kind = "sextant": expected one of .*driver'):
        load_config(file, {}, {})
    file.write_text(head + '[[driver.sensors]]\nkind = "driver"\nuse = ["fix", "fox"]\n')
    with pytest.raises(ConfigError, match=r"driver.sensors.*use.*fox"):
        load_config(file, {}, {})
    assert "two sensors are called" in wrong_sensors((SensorConfig(kind="driver"), SensorConfig(kind="driver")))


def test_the_drivers_own_measurements_may_be_given_a_rank() -> None:
    driver = Thrusters(Reading(50 * S, 44.3, 8.9, 0.5))
    assert equipped("b1", driver, (), lambda: 0) is driver
    ranked = equipped("b1", driver, (SensorConfig(kind="driver"),), lambda: 0)
    assert ranked.read().lat_deg == 44.3
