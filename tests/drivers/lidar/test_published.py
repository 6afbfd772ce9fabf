"""Scans published on board, as a sensor: over Zenoh, with a publisher as the manual shows it, and what is refused."""

from __future__ import annotations

import json
import math
import struct
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
import zenoh

from fleet.agent.hardware import Subscribes, subscribe
from fleet.drivers.lidar.published import PublishedScans
from fleet.drivers.seam import Observed, Reading
from fleet.drivers.sensors.config import SensorConfig
from fleet.drivers.sensors.equipped import Equipped, Fitted
from fleet.errors import ConfigError
from fleet.sensing.scan import packed, unpacked
from fleet.sim import passes
from fleet.wire.bus import Heard
from fleet.wire.credentials.trust import load
from fleet.wire.link import LinkConfig
from fleet.wire.scans import PublishedScan, encode
from fleet.wire.zenoh_bus import ZenohBus
from tests.wire.test_bus_contract import free_port, wait_for

S = 1_000_000_000
NOW_NS = 1_700_000_000 * S


def config(**more: object) -> SensorConfig:
    return msgspec.convert({"kind": "scan", "name": "bow", "silent_s": 1.0, **more}, SensorConfig)


class Board:
    """A sensor with what was published for it."""

    def __init__(self, **options: object) -> None:
        self.waiting: list[Heard] = []
        self.sensor = PublishedScans(config(options=options), lambda: NOW_NS)
        self.sensor.listen(self._fetch)
        self.sensor.open()

    def _fetch(self) -> list[Heard]:
        waiting, self.waiting = self.waiting, []
        return waiting

    def read(self, after_s: float, *payloads: bytes) -> Observed:
        now_ns = NOW_NS + round(after_s * S)
        self.waiting = [Heard("b1", payload, now_ns) for payload in payloads]
        return self.sensor.read(now_ns)


def said(stamp_ns: int = 0) -> bytes:
    return encode(PublishedScan(1, stamp_ns, 0.5, -0.5, packed([9.0, 10.0, 11.0]), 0.1, 30.0))


def test_a_published_scan_is_mounted_as_the_boat_says() -> None:
    board = Board(yaw_deg=90.0, ahead_m=1.0, range_max_m=10.5, blind_deg=[[80.0, 100.0]])
    (scan,) = board.read(0.1, said()).scans
    assert (scan.yaw_rad, scan.ahead_m, scan.range_max_m) == (pytest.approx(math.pi / 2), 1.0, 10.5)
    ranges = unpacked(scan.ranges)  # bearings 118.6, 90 and 61.4 degrees from the bow
    assert ranges[0] == 9.0
    assert all(math.isnan(one) for one in ranges[1:])


def test_nobody_who_publishes_is_trouble_after_its_time_and_so_are_scans_that_are_refused() -> None:
    board = Board()
    assert board.read(0.9) == Observed()
    assert board.read(1.1).trouble == "nobody publishes scans"
    assert board.read(1.2, said(NOW_NS - 20 * S)).trouble == "scans refused: old, or from the future"
    assert board.read(1.3, b"junk").trouble == "scans refused: does not decode"
    assert board.sensor.refused == {"old, or from the future": 1, "does not decode": 1}
    assert board.read(1.4, said()).trouble == ""
    assert board.sensor.taken == 1


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"options": {"key": "state"}}, "the boat itself publishes there"),
        ({"options": {"key": "command/x"}}, "the boat itself publishes there"),
        ({"options": {"key": "*"}}, "options: key"),
        ({"options": {"key": "../b2/scan"}}, "options: key"),
        ({"endpoint": "tcp:1.2.3.4:5"}, "scans come over the boat's link; expected none"),
    ],
)
def test_keys_that_are_not_below_the_own_name_or_taken_are_refused(wrong: dict[str, object], why: str) -> None:
    with pytest.raises(ConfigError) as refused:
        PublishedScans(config(**wrong), lambda: 0)
    assert why in str(refused.value)


# -- over Zenoh --------------------------------------------------------------------------------------------------------
class Still:
    """A driver that has nothing to say."""

    simulated = True

    def open(self) -> None: ...

    def read(self) -> Reading:
        return Reading(stamp_ns=0)

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:  # noqa: ARG002
        return ""

    def neutral(self) -> None: ...

    def close(self) -> None: ...


@pytest.fixture
def boat() -> Iterator[tuple[Equipped, ZenohBus, int]]:
    """A boat that is a router, with a sensor of kind `scan` under another key than usual."""
    port = free_port()
    sensor = PublishedScans(config(options={"key": "scan/bow"}), time.time_ns)
    assert isinstance(sensor, Subscribes)
    driver = Equipped(Still(), [Fitted("bow", sensor, frozenset({"scan"}))], time.time_ns)
    bus = ZenohBus("demo", "b1", LinkConfig(topology="routed", listen=(f"tcp/127.0.0.1:{port}",)), time.time_ns)
    subscribe(driver, bus)
    driver.open()
    bus.open()
    yield driver, bus, port
    bus.close()
    driver.close()


def test_the_publisher_of_the_manual_is_heard_and_one_under_another_boats_name_is_not(
    boat: tuple[Equipped, ZenohBus, int],
) -> None:
    driver, bus, port = boat
    wait_for(bus.open)
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", f'["tcp/127.0.0.1:{port}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    with wait_for(lambda: zenoh.open(config)) as session:

        def published(key: str) -> object:
            ranges = struct.pack("<3f", 4.0, math.inf, 6.0)
            session.put(key, msgspec.msgpack.encode([1, time.time_ns(), 0.5, -0.5, ranges, 0.1, 30.0]))
            return driver.read().scans

        assert not published("fleet/demo/b2/scan/bow")
        (scan,) = wait_for(lambda: published("fleet/demo/b1/scan/bow"))[-1:]
    assert scan.scanner == "bow"
    assert [one for one in unpacked(scan.ranges) if not math.isnan(one)] == [4.0, 6.0]


def test_with_credentials_a_publisher_with_the_boats_own_folder_is_heard_and_one_with_anothers_is_not(
    tmp_path: Path,
) -> None:
    place, port = passes.found(tmp_path / "credentials", "demo", ("b1", "b2"), "anna"), free_port()
    driver = Equipped(
        Still(), [Fitted("bow", PublishedScans(config(), time.time_ns), frozenset({"scan"}))], time.time_ns
    )
    where = f"tls/127.0.0.1:{port}"
    link = LinkConfig(topology="routed", listen=(where,), credentials=str(place / "b1"))
    bus = ZenohBus("demo", "b1", link, time.time_ns, load(place / "b1", "demo", "boat", "b1"))
    subscribe(driver, bus)
    driver.open()
    wait_for(bus.open)

    def publisher(folder: Path) -> zenoh.Session:
        """As the manual shows it."""
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", json.dumps([where]))
        config.insert_json5("scouting/multicast/enabled", "false")
        tls = {
            "root_ca_certificate": f"{folder}/authority.pem",
            "connect_certificate": f"{folder}/own.pem",
            "connect_private_key": f"{folder}/own.key",
            "enable_mtls": True,
        }
        config.insert_json5("transport/link/tls", json.dumps(tls))
        session: zenoh.Session = wait_for(lambda: zenoh.open(config))
        return session

    def put(session: zenoh.Session, metres: float) -> list[float]:
        ranges = struct.pack("<1f", metres)
        session.put("fleet/demo/b1/scan", msgspec.msgpack.encode([1, time.time_ns(), 0.5, -0.5, ranges, 0.1, 30.0]))
        return [one for scan in driver.read().scans for one in unpacked(scan.ranges)]

    try:
        with publisher(place / "b2") as other, publisher(place / "b1") as own:
            for _ in range(20):
                put(other, 4.0)
            heard: list[float] = []
            while len(heard) < 5:
                put(other, 4.0)
                heard += wait_for(lambda: put(own, 6.0))
        assert set(heard) == {6.0}
    finally:
        bus.close()
        driver.close()
