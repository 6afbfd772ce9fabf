"""The driver on a real python-can bus (UDP multicast on this machine), against the simulated controller in a world."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator

import msgspec
import pytest

from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.driver import CanDriver
from fleet.drivers.can.helm import PILOT
from fleet.errors import ConfigError, FleetError
from fleet.guidance.thrust import Thrusters
from fleet.mission.load import load
from fleet.mission.plan import build
from fleet.sim.controller.device import CanDevice
from fleet.sim.world import STEP_NS, World

PATIENCE_S = 10.0
SET_NS = 50_000_000


class Sea:
    """A world with one boat on its bus, a driver, and a clock that both share."""

    def __init__(self) -> None:
        self.world = World(build(load("overtaking")), 1_000_000_000)
        self.device = CanDevice(self.world, "b1", 1.0)
        self.config = msgspec.convert(self.device.keys["can"], CanConfig)
        self.driver = CanDriver(self.config, lambda: self.world.now_ns, simulated=True)

    def once(self) -> None:
        """50 ms of the world, and one exchange."""
        until = self.world.now_ns + SET_NS
        while self.world.now_ns + STEP_NS <= until:
            self.world.step()
        self.world.now_ns = until
        self.device.exchange(self.world.sense("b1"))

    def run(self, seconds: float, command: tuple[float, float] | None = None) -> list[str]:
        """Time passes, and the driver hears every set; what it answered to commands."""
        told = []
        for k in range(round(seconds / 0.05)):
            if command is not None and k % 2 == 0:
                told.append(self.driver.write(*command))
            self.once()
            self.wait(lambda: self.driver.read().stamp_ns == self.world.now_ns)
        return told

    def wait(self, holds: object) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not holds():  # type: ignore[operator]
            assert time.monotonic() < deadline
            time.sleep(0.0)

    @property
    def thrust(self) -> float:
        t = self.device.controller.thrusts
        return sum(map(abs, (t.rear_port, t.rear_starboard, t.side_port, t.side_starboard)))

    def seconds_until_no_thrust(self) -> float:
        """The world goes on, whether the driver hears or not."""
        began = self.world.now_ns
        while self.thrust > 0.0 and self.world.now_ns - began < 5_000_000_000:
            self.once()
        return (self.world.now_ns - began) * 1e-9


@pytest.fixture
def sea() -> Iterator[Sea]:
    sea = Sea()
    sea.driver.open()
    try:
        yield sea
    finally:
        sea.driver.close()
        sea.device.close()


def test_the_boat_goes_where_it_is_told_over_a_real_bus(sea: Sea) -> None:
    sea.run(0.5)
    assert set(sea.run(15.0, (1.2, 0.1))) == {""}
    ship = sea.world.ships["b1"]
    assert ship.state.u == pytest.approx(1.2, abs=0.02)
    assert ship.state.r == pytest.approx(0.1, abs=0.01)
    reading = sea.driver.read()
    assert (reading.trouble, reading.authority, reading.battery_percent) == ("", "", 100.0)
    assert reading.heading_rad == pytest.approx(ship.state.psi, abs=0.02)


def test_close_leaves_the_boat_in_neutral(sea: Sea) -> None:
    sea.run(0.5)
    sea.run(3.0, (1.0, 0.0))
    assert sea.thrust > 10.0
    sea.driver.close()
    assert sea.seconds_until_no_thrust() <= 0.1


def test_a_bus_that_goes_off_is_said_and_comes_back_by_itself(sea: Sea) -> None:
    sea.run(0.5)
    sea.run(3.0, (1.0, 0.0))
    sea.device.trouble("bus-off", 0.0)
    sea.wait(lambda: sea.driver.read().trouble == "CAN bus off")
    assert sea.driver.write(1.0, 0.0) == "CAN bus off"
    assert sea.seconds_until_no_thrust() <= 0.65
    sea.wait(lambda: sea.driver.reopened == 1)
    sea.once()
    assert sea.driver.write(1.0, 0.0) == "the controller on the CAN bus is silent"
    sea.device.trouble("bus-on", 0.0)
    sea.run(0.5)
    assert sea.driver.read().trouble == ""
    assert set(sea.run(12.0, (1.0, 0.0))) == {""}
    assert sea.world.ships["b1"].state.u == pytest.approx(1.0, abs=0.02)


def test_an_adapter_that_is_pulled_is_said_and_taken_up_again(sea: Sea) -> None:
    sea.run(0.5)
    sea.run(3.0, (1.0, 0.0))
    sea.driver._bus.shutdown()
    sea.wait(lambda: sea.driver.read().trouble.startswith("CAN bus: "))
    assert sea.seconds_until_no_thrust() <= 0.65
    sea.wait(lambda: sea.driver.reopened == 1)
    sea.run(0.5)
    assert set(sea.run(12.0, (1.0, 0.0))) == {""}
    assert sea.world.ships["b1"].state.u == pytest.approx(1.0, abs=0.02)


def test_an_adapter_that_hears_but_sends_no_more_is_said_and_opened_again(sea: Sea) -> None:
    sea.run(0.5)
    sea.run(3.0, (1.0, 0.0))

    def broken(*_: object) -> None:
        raise OSError("no buffer space available")

    sea.driver._bus.send = broken
    for _ in range(10):  # frames come in all the while
        sea.once()
        if sea.driver._bus is None:
            break
        sea.driver.write(1.0, 0.0)
        sea.wait(lambda: sea.driver._bus is None or sea.driver.read().stamp_ns == sea.world.now_ns)
    assert sea.driver.read().trouble == "CAN bus: no buffer space available"
    sea.wait(lambda: sea.driver.reopened == 1)
    sea.run(0.5)
    assert set(sea.run(6.0, (1.0, 0.0))) == {""}


def test_what_queued_while_the_process_was_stopped_is_thrown_away(sea: Sea) -> None:
    sea.run(0.5)
    heard = sea.driver.helm.decoder.counts.accepted
    with sea.driver._lock:  # the thread waits here
        for _ in range(20):
            sea.once()
        sea.driver._listened_s -= 10.0
    sea.wait(lambda: time.monotonic() - sea.driver._listened_s < 5.0)
    sea.run(0.2)
    assert sea.driver.helm.decoder.counts.accepted - heard < 12  # of 20 sets and 10 heartbeats, and the 6 after them


def test_the_pilot_has_the_boat_until_he_gives_it_back(sea: Sea) -> None:
    sea.run(0.5)
    sea.run(3.0, (1.0, 0.0))
    sea.device.trouble("pilot-takes", 30.0)
    sea.run(0.2)
    assert sea.driver.read().authority == PILOT
    sea.run(1.0)
    assert sea.device.controller.thrusts.rear_port == pytest.approx(30.0)
    sea.device.trouble("pilot-gives", 0.0)
    sea.run(0.2)
    assert sea.driver.read().authority == ""
    assert sea.thrust == 0.0


def test_thrusters_that_do_not_answer_are_said(sea: Sea) -> None:
    sea.run(0.5)
    sea.world.trouble("b1", "actuator-down")
    sea.run(0.2)
    assert sea.driver.read().trouble.startswith("controller: rear port thruster failed, rear starboard")


def test_strangers_on_the_bus_change_nothing(sea: Sea) -> None:
    import random
    import socket

    import can

    rng = random.Random(2)
    sea.run(0.5)
    port = int(sea.config.options["port"])
    with can.Bus(interface="udp_multicast", channel=sea.config.channel, port=port, hop_limit=0) as stranger:
        for k in range(20):
            for _ in range(20):
                identifier, payload = rng.choice((0x200, 0x210, 0x211, 0x212, 0x7FF)), rng.randbytes(8)
                stranger.send(can.Message(arbitration_id=identifier, data=payload, is_extended_id=bool(k % 2)))
            sea.run(0.1, (1.0, 0.0))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as junk:  # not even frames
        junk.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        for _ in range(3):
            junk.sendto(rng.randbytes(30), (sea.config.channel, port))
    sea.run(0.5, (1.0, 0.0))
    assert sea.driver.read().trouble == ""
    assert sea.driver.helm.decoder.counts.foreign + sea.driver.helm.decoder.counts.refused >= 100
    assert sea.world.ships["b1"].state.u > 0.3


CHILD = """
import sys, time, msgspec
from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.driver import CanDriver
driver = CanDriver(msgspec.json.decode(sys.argv[1], type=CanConfig), time.monotonic_ns, simulated=True)
driver.open()
print("open", flush=True)
while True:
    driver.write(1.0, 0.0)
    time.sleep(0.02)
"""


def test_a_killed_process_leaves_the_controllers_watchdog_to_stop_the_boat() -> None:
    sea = Sea()
    config = msgspec.json.encode(sea.config).decode()
    child = subprocess.Popen([sys.executable, "-c", CHILD, config], stdout=subprocess.PIPE)
    try:
        assert child.stdout is not None
        assert child.stdout.readline() == b"open\n"
        began = time.monotonic()
        while sea.thrust < 5.0:
            sea.once()
            assert time.monotonic() - began < PATIENCE_S
        child.send_signal(signal.SIGKILL)
        child.wait()
        assert 0.4 <= sea.seconds_until_no_thrust() <= 0.65  # 0.5 s, in steps of 50 ms of the world
    finally:
        child.kill()
        child.wait()
        child.stdout.close()
        sea.device.close()


@pytest.mark.parametrize("library", ["can", "cantools"])
def test_without_its_libraries_it_says_what_to_install(library: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ConfigError) as caught:
        CanDriver(CanConfig(), time.monotonic_ns).open()
    assert str(caught.value) == (f"driver can needs {library}, which is not installed; pip install 'fleet-usv[can]'")


@pytest.mark.parametrize(
    ("config", "message"),
    [
        (CanConfig(interface="sockcan"), "driver.can.interface 'sockcan': no such interface; expected one of "),
        (CanConfig(channel="can97"), "driver.can.channel 'can97': socketcan cannot open it: "),
        (
            CanConfig(thrusters=Thrusters(rear_ahead_n=300.0)),
            "driver.can.thrusters.rear_ahead_n = 300: expected at most 204.7, what a Thrust frame carries",
        ),
        (CanConfig(dbc="/none.dbc"), "driver.can.dbc '/none.dbc': no such file; expected a DBC"),
        (
            CanConfig(interface="udp_multicast", channel="239.74.163.2", options={"port": "x"}),
            "driver.can.channel '239.74.163.2': udp_multicast cannot open it: ",
        ),
    ],
    ids=["interface", "channel", "thrust", "dbc", "options"],
)
def test_a_bus_that_cannot_be_is_refused_with_what_is_wrong(config: CanConfig, message: str) -> None:
    driver = CanDriver(config, time.monotonic_ns)
    with pytest.raises(ConfigError) as caught:
        driver.open()
    assert str(caught.value).startswith(message)
    assert isinstance(caught.value, FleetError)
    driver.close()
