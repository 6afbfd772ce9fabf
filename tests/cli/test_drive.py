"""`fleet drive` of boats by their own file: a thruster controller on a CAN bus, sensors in sentences, in real time."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from importlib import resources
from pathlib import Path

import pytest
from msgspec.structs import replace

from fleet.drivers.nmea import encode as nmea
from fleet.drivers.seam import Reading
from fleet.guidance.thrust import Thrusts
from fleet.hulls import catamaran
from fleet.mission.load import load
from fleet.mission.plan import build
from fleet.sim.controller.device import CanDevice
from fleet.sim.world import STEP_NS, World
from tests.cli.terminal import at_terminal, here
from tests.drivers.sensors.rig import free_port

SET_NS = 50_000_000
BLIND = Reading(0, battery_percent=80.0, raw=True)


class Live:
    """A catamaran at rest with a controller on its bus, in real time; `fleet drive` is the only one who talks to it."""

    def __init__(self, folder: Path) -> None:
        self.world = World(build(load("overtaking")), time.time_ns())
        self.device = CanDevice(self.world, "b1", 1.0)
        self.ship = self.world.ships["b1"]
        self.ship.state = catamaran.start(10.0, 20.0, 0.5, 0.0)
        self.blind = False  # the controller has no sensors
        self.says: Callable[[Reading], list[bytes]] = lambda reading: []  # of the instruments
        self.thrusts: list[tuple[int, float]] = []  # (when [ns], all thrusters together [N])
        self.most_u = 0.0
        self.file = folder / "boat.toml"
        self._port = free_port(socket.SOCK_DGRAM)
        self._line = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def write(self, *, sensors: bool = False, dbc: str = "") -> None:
        """The boat's file."""
        can = self.device.keys["can"]
        lines = [
            'boat = "b1"', "[link]", 'topology = "hub"', "[driver]", 'kind = "can"', "[driver.can]",
            f'interface = "{can["interface"]}"', f'channel = "{can["channel"]}"', f'dbc = "{dbc}"',
            f"options = {{ port = {can['options']['port']}, hop_limit = 0 }}",
        ]  # fmt: skip
        if sensors:
            lines += ["[[driver.sensors]]", 'kind = "nmea"', f'endpoint = "udp:127.0.0.1:{self._port}"']
        self.file.write_text("\n".join(lines) + "\n", encoding="utf-8")

    def start(self) -> None:
        self._thread.start()

    def _run(self) -> None:
        """A navigation set every 50 ms."""
        while not self._stop.wait(max(0.0, (self.world.now_ns + SET_NS - time.time_ns()) * 1e-9)):
            if time.time_ns() - self.world.now_ns > 10 * SET_NS:
                self.world.now_ns = time.time_ns() - SET_NS  # a machine that stood still
            until = self.world.now_ns + SET_NS
            while self.world.now_ns + STEP_NS <= until:
                self.world.step()
            self.world.now_ns = until
            seen = replace(self.world.sense("b1"), stamp_ns=until)
            self.device.exchange(BLIND if self.blind else seen)
            for line in self.says(seen):
                self._line.sendto(line, ("127.0.0.1", self._port))
            t = self.device.controller.thrusts
            thrust = sum(map(abs, (t.rear_port, t.rear_starboard, t.side_port, t.side_starboard)))
            self.thrusts.append((time.monotonic_ns(), thrust))
            self.most_u = max(self.most_u, self.ship.state.u)

    @property
    def last_thrust_ns(self) -> int:
        """When a thruster gave something for the last time."""
        return max((when for when, thrust in self.thrusts if thrust > 0.0), default=0)

    def drive(self, *argv: str, hold_s: float = 30.0, hangs_up: bool = False) -> tuple[int, str]:
        """`fleet drive` with its file; the time when the key was let go is in `let_go_ns`."""
        return at_terminal(
            "drive", "--config", str(self.file), *argv, hold_s=hold_s, hangs_up=hangs_up, then=self._let_go
        )

    def _let_go(self) -> None:
        self.let_go_ns = time.monotonic_ns()

    def close(self) -> None:
        self._stop.set()
        self._thread.join(5.0)
        self.device.close()
        self._line.close()


@pytest.fixture
def live(tmp_path: Path) -> Iterator[Live]:
    one = Live(tmp_path)
    one.write()
    one.start()
    yield one
    one.close()


def test_a_boat_on_can_driven_ahead_and_to_starboard_is_judged_and_stopped(live: Live) -> None:
    code, shown = live.drive("--surge", "0.3", "--yaw-rate", "0.2", "--for", "2.5")
    assert code == 0, shown
    assert "the boat does what it is told" in shown
    assert live.most_u > 0.08
    assert live.thrusts[-1][1] == 0.0


@pytest.mark.parametrize("hangs_up", [False, True])
def test_a_key_let_go_and_a_lost_terminal_stop_the_boat(live: Live, hangs_up: bool) -> None:
    code, shown = live.drive("--yaw-rate", "0.3", "--for", "20", hold_s=1.5, hangs_up=hangs_up)
    assert max(thrust for _, thrust in live.thrusts) > 5.0
    assert (live.last_thrust_ns - live.let_go_ns) * 1e-9 < 0.7 + 0.5  # the key's time, and what a busy machine takes
    if not hangs_up:
        assert (code, "let go: stopping" in shown) == (0, True), shown


def test_thrusters_that_are_exchanged_in_the_dbc_are_found_out(live: Live, tmp_path: Path) -> None:
    text = resources.files("fleet.drivers.can").joinpath("viam.dbc").read_text(encoding="utf-8")
    for a, b in (("RearPort", "RearStarboard"), ("SidePort", "SideStarboard")):
        text = (
            text.replace(f" SG_ {a} ", " SG_ X ").replace(f" SG_ {b} ", f" SG_ {a} ").replace(" SG_ X ", f" SG_ {b} ")
        )
    crossed = tmp_path / "crossed.dbc"
    crossed.write_text(text, encoding="utf-8")
    live.write(dbc=str(crossed))
    code, shown = live.drive("--yaw-rate", "0.1", "--for", "1.5")
    assert code == 1, shown
    assert "expected a turn to starboard" in shown


def test_a_pilot_with_the_remote_control_keeps_the_boat(live: Live) -> None:
    live.device.controller.pilot(Thrusts(0.0, 0.0, 0.0, 0.0))
    code, shown = live.drive("--surge", "0.4")
    assert code == 1
    assert "somebody else commands the boat: pilot with the remote control" in shown
    assert live.last_thrust_ns == 0


def test_where_the_controller_has_no_sensors_those_of_the_boats_file_are_used(live: Live) -> None:
    live.blind = True
    live.says = lambda r: [
        nmea.rmc(r.stamp_ns, r.lat_deg, r.lon_deg, r.v_north_mps, r.v_east_mps),
        nmea.hdt(r.heading_rad),
    ]
    live.write(sensors=True)
    code, shown = live.drive("--surge", "0.3", "--yaw-rate", "-0.2", "--for", "2.5")
    assert code == 0, shown
    assert "the boat does what it is told" in shown


def test_with_a_compass_alone_the_boat_turns_and_what_is_not_measured_is_not_judged(live: Live) -> None:
    live.blind = True
    live.says = lambda r: [nmea.hdt(r.heading_rad)]
    live.write(sensors=True)
    code, shown = live.drive("--yaw-rate", "0.2", "--for", "1")
    assert code == 0, shown
    assert "yaw rate: on average +0." in shown
    assert "surge: on average" not in shown
    code, shown = live.drive("--surge", "0.2", "--for", "2")
    assert code == 1
    assert "the boat cannot be driven: no heading, yaw rate or speed on the CAN bus" in shown, shown
    assert live.most_u < 0.05


def test_a_boat_whose_agent_runs_is_left_to_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "boat.toml"
    file.write_text('boat = "b1"\nlink.topology = "hub"\n[driver]\nkind = "can"\n', encoding="utf-8")
    monkeypatch.setattr("fleet.doctor.wiring.agent_of", lambda fleet, boat: 4711)
    run = here("drive", "--config", str(file), "--surge", "0.3")
    assert run.returncode == 1
    assert "an agent of b1 runs, process 4711: it has the boat; stop it first" in run.stderr


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (("--surge", "0.3"), "which boat? expected either ENDPOINT of an autopilot or --config FILE"),
        (("udp:127.0.0.1:1", "--config", "{file}", "--surge", "0.3"), "which boat? expected either"),
        (("--config", "{file}", "--surge", "0.3", "--arm"), '--arm: driver.kind = "can" has nothing that is armed'),
        (("--config", "{file}", "--surge", "0.3", "--sysid", "2"), "the boat's file says them; expected none with"),
        (("--config", "/none.toml", "--surge", "0.3"), "/none.toml: no such file; expected a configuration in TOML"),
        (("--config", "{file}", "--surge", "0.3"), "there is no terminal to hold it on"),
    ],
)
def test_wrong_input_is_refused_before_anything_moves(tmp_path: Path, argv: tuple[str, ...], message: str) -> None:
    file = tmp_path / "boat.toml"
    file.write_text('boat = "b1"\nlink.topology = "hub"\n[driver]\nkind = "can"\n', encoding="utf-8")
    run = here("drive", *(word.format(file=file) for word in argv))
    assert run.returncode == 2
    assert message in run.stderr
    assert "Traceback" not in run.stderr
