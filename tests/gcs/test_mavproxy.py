"""MAVProxy, a ground station that people use, with a real bridge and five real agents over Zenoh."""

from __future__ import annotations

import json
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from msgspec import Struct

from fleet.agent.clock import warped
from fleet.agent.modes import Mode
from fleet.mission.load import encode, load
from fleet.operator import Fleet
from fleet.sim.processes import Processes
from tests.cli.terminal import FLEET, environment
from tests.gcs.mavproxy import Mavproxy, program

pytestmark = [
    pytest.mark.sails,
    pytest.mark.skipif(program() is None, reason="MAVProxy is not installed: make setup brings it"),
]
BOATS = ("b1", "b2", "b3", "b4", "b5")
LINES = ((0, 44.38, 8.93), (3, 44.3799, 8.93), (3, 44.3818, 8.93), (3, 44.3818, 8.932), (3, 44.3808, 8.932))
"""(frame, latitude, longitude) of home and the waypoints; all boats lie beside the first leg."""


class Shore(Struct):
    """How to reach them."""

    folder: Path
    connect: tuple[str, ...]
    ports: tuple[int, int]


def free_udp_ports() -> tuple[int, int]:
    """Two that nobody uses just now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as a, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as b:
        a.bind(("127.0.0.1", 0))
        b.bind(("127.0.0.1", 0))
        return a.getsockname()[1], b.getsockname()[1]


@pytest.fixture(scope="module")
def shore(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shore]:
    """A hub, a world, five agents, and `fleet gcs` as a process."""
    folder = tmp_path_factory.mktemp("shore")
    mission = folder / "mission.bin"
    mission.write_bytes(encode(load("survey-column", ("timeline=[]",))))
    processes = Processes(folder, warped(1.0), BOATS, fleet="sim", topology="hub", seed=0, record=False)
    ports = free_udp_ports()
    bridge = None
    try:
        processes.start_hub()
        processes.start_world(mission)
        for boat in BOATS:
            processes.start_agent(boat)
        endpoints = ",".join(f"udp:127.0.0.1:{port}" for port in ports)
        options = ["--fleet", "sim", "--connect", processes.connect[0], "--endpoint", endpoints]
        bridge = subprocess.Popen(
            [*FLEET, "gcs", *options, "--state-dir", str(folder / "gcs")],
            stdout=(folder / "bridge.log").open("w"),
            stderr=subprocess.STDOUT,
            env=environment(),
            start_new_session=True,
        )
        yield Shore(folder, processes.connect, ports)
        bridge.terminate()
        assert bridge.wait(10.0) == 0
        assert json.loads((folder / "gcs" / "gcs-sim.json").read_text()) == {b: i + 1 for i, b in enumerate(BOATS)}
    finally:
        if bridge is not None and bridge.poll() is None:
            bridge.kill()
            bridge.wait()
        processes.close()


def waypoints(*places: tuple[int, float, float]) -> str:
    """A file as MAVProxy reads it."""
    rows = (f"{i}\t0\t{frame}\t16\t0\t0\t0\t0\t{lat}\t{lon}\t0\t1" for i, (frame, lat, lon) in enumerate(places))
    return "\n".join(["QGC WPL 110", *rows]) + "\n"


def numbers(file: Path) -> list[list[float]]:
    """What stands in such a file."""
    return [[float(number) for number in line.split()] for line in file.read_text().splitlines()[1:]]


def test_mavproxy_sees_five_boats_sends_a_mission_sails_it_and_is_refused_in_words(shore: Shore) -> None:
    with Mavproxy(shore.ports[0], shore.folder) as mp:
        for sysid in range(1, 6):
            mp.see(f"Detected vehicle {sysid}:1", at_most_s=20.0)
        mp.ask("vehicle 1", "Set vehicle 1")
        mp.see(r"Received \d+ parameters")
        mp.ask("param show FLT_CRUISE", r"FLT_CRUISE +1\.0")

        mp.ask("mode AUTO", "AUTO refused: no mission; upload one", "DO_SET_MODE: FAILED")
        mp.ask("arm throttle force", "arming by force refused", "COMPONENT_ARM_DISARM: DENIED")
        mp.ask("arm throttle", "COMPONENT_ARM_DISARM: ACCEPTED", "ARMED")
        mp.ask("param set FLT_CRUISE 0.8", "")

        (shore.folder / "tight.txt").write_text(waypoints(*LINES[:3], (3, 44.3818, 8.93002), (3, 44.38, 8.93002)))
        mp.ask("wp load tight.txt", "mission refused: .*corners of radius", "TYPE_MISSION: INVALID")
        (shore.folder / "wp.txt").write_text(waypoints(*LINES))
        mp.ask("wp load wp.txt", "TYPE_MISSION: ACCEPTED", "mission for b1, b2, b3, b4, b5; AUTO starts it")
        mp.ask("wp save back.txt", "Saved 5 waypoints")
        assert numbers(shore.folder / "back.txt") == numbers(shore.folder / "wp.txt")

        with Fleet("sim", connect=shore.connect, operator="anna") as anna:
            assert not anna.wait_for(BOATS)
            mp.ask("mode AUTO", "DO_SET_MODE: ACCEPTED", "Mode AUTO", "mode: standby -> follow")
            held = anna.formation()
            assert held.roster == BOATS
            assert held.cruise_mps == pytest.approx(0.8), "what was set before the upload"
            mp.ask("param set FLT_SPACING 3", r"FLT_SPACING refused: spacing 3 m: .* at least 8\.0 m")
            mp.ask("param set FLT_SPACING 12", "formation: spacing 12 m")
            assert anna.formation().spacing_m == 12.0
            mp.ask("mode HOLD", "DO_SET_MODE: ACCEPTED", "Mode HOLD", "mode: (follow|avoid) -> hold")
            assert mode_of(anna, "b1") == Mode.HOLD
            assert mode_of(anna, "b2") in (Mode.FOLLOW, Mode.AVOID), "the others sail on"

            with Mavproxy(shore.ports[1], shore.folder, "--source-system=254") as second:
                second.see("Detected vehicle 5:1", at_most_s=20.0)
                second.ask("vehicle 2", "Set vehicle 2")
                second.ask("mode RTL", "RTL refused: another ground station commands", "DO_SET_MODE: DENIED")

            anna.take()
            mp.ask("mode RTL", "RTL refused: anna holds control", "DO_SET_MODE: DENIED")
            mp.ask("disarm", "COMPONENT_ARM_DISARM: ACCEPTED", "DISARMED")
            assert mode_of(anna, "b1") == Mode.NEUTRAL, "anybody may stop a boat"


def mode_of(fleet: Fleet, boat: str) -> int:
    """What it does, by a state that is newer than the question."""
    asked = time.monotonic()
    view = fleet.look()[boat]
    while view.state is None or view.heard_s <= asked:
        time.sleep(0.01)
        view = fleet.look()[boat]
    return view.state.mode
