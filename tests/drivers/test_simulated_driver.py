"""The driver of a simulated boat, against a socket in the place of the world."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator

import msgspec
import pytest

from fleet.drivers.seam import Reading
from fleet.drivers.simulated import Sensed, Setpoint, SimulatedDriver
from fleet.errors import ConfigError

encode = msgspec.msgpack.encode


@pytest.fixture
def world() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sea:
        sea.bind(("127.0.0.1", 0))
        sea.settimeout(5.0)
        yield sea


def connected(world: socket.socket) -> tuple[SimulatedDriver, tuple[str, int]]:
    driver = SimulatedDriver("b1", f"127.0.0.1:{world.getsockname()[1]}")
    driver.open()
    payload, address = world.recvfrom(2048)
    assert msgspec.msgpack.decode(payload, type=Setpoint) == Setpoint("b1", False, 0.0, 0.0), "neutral comes first"
    return driver, address


def read_until(driver: SimulatedDriver, stamp_ns: int) -> Reading:
    deadline = time.monotonic() + 5.0
    while (reading := driver.read()).stamp_ns != stamp_ns:
        assert time.monotonic() < deadline
    return reading


def test_before_the_world_speaks_nothing_is_known() -> None:
    assert SimulatedDriver("b1", "127.0.0.1:9").read().stamp_ns == 0


def test_a_setpoint_reaches_the_world(world: socket.socket) -> None:
    driver, _ = connected(world)
    assert driver.write(1.25, -0.1) == ""
    assert msgspec.msgpack.decode(world.recv(2048), type=Setpoint) == Setpoint("b1", True, 1.25, -0.1)
    driver.close()


def test_the_newest_reading_counts_and_rubbish_is_passed_over(world: socket.socket) -> None:
    driver, boat = connected(world)
    for stamp in (1, 2, 3):
        world.sendto(encode(Sensed(Reading(stamp_ns=stamp, lat_deg=44.0), 0.1, 0.2, True)), boat)
        world.sendto(b"\xc1 rubbish", boat)
    reading = read_until(driver, 3)
    assert reading.lat_deg == 44.0
    assert (driver.sensed.radio_delay_s, driver.sensed.radio_loss, driver.sensed.radio_down) == (0.1, 0.2, True)
    assert driver.read().stamp_ns == 3, "it stays, and its stamp grows old"
    driver.close()


def test_closing_leaves_the_boat_in_neutral(world: socket.socket) -> None:
    driver, _ = connected(world)
    driver.close()
    assert msgspec.msgpack.decode(world.recv(2048), type=Setpoint).powered is False
    assert driver.write(1.0, 0.0) == "not connected to the world"
    driver.close()


def test_a_world_that_has_gone_is_said_and_never_raised() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sea:
        sea.bind(("127.0.0.1", 0))
        port = sea.getsockname()[1]
    driver = SimulatedDriver("b1", f"127.0.0.1:{port}")
    driver.open()
    said = {driver.write(1.0, 0.0) for _ in range(20)}
    assert "the world does not answer" in said
    driver.read()
    driver.close()


@pytest.mark.parametrize(
    "where", ["", "nowhere", "127.0.0.1:", "127.0.0.1:x", "127.0.0.1:0", "127.0.0.1:70000", ":5000"]
)
def test_a_world_that_cannot_be_is_refused_with_what_was_expected(where: str) -> None:
    with pytest.raises(ConfigError, match="expected HOST:PORT"):
        SimulatedDriver("b1", where)
