"""`fleet doctor` as an operator finds it: a boat that is fit, one that is not, one whose agent runs."""

from __future__ import annotations

import json
import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from fleet.agent.config import AgentConfig, DriverConfig, load_config
from fleet.doctor import hardware, reach
from fleet.drivers.seam import Driver, Reading
from fleet.errors import ConfigError
from fleet.sim.processes import free_port
from fleet.wire.link import LinkConfig
from tests.cli.terminal import here, running, until


class Told:
    """A driver that says what a test wants."""

    def __init__(self, reading: Reading, *, simulated: bool = False, wrong: str = "") -> None:
        self.reading, self.simulated, self.wrong, self.closed = reading, simulated, wrong, False

    def open(self) -> None:
        if self.wrong:
            raise ConfigError(self.wrong)

    def read(self) -> Reading:
        return self.reading

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:  # noqa: ARG002
        raise AssertionError("a doctor commands nothing")

    def neutral(self) -> None: ...

    def close(self) -> None:
        self.closed = True


def makes(driver: Driver) -> Callable[[AgentConfig, Callable[[], int]], Driver]:
    return lambda config, now_ns: driver


CONFIG = AgentConfig(boat="b1", link=LinkConfig(topology="hub"), driver=DriverConfig(kind="can"))
GOOD = Reading(1, 44.38, 8.93, 1.0, 0.0, 0.0, 0.0, 1.5, battery_percent=80.0)


SAID = "can: 44.380000 8.930000, heading 57 deg, right to 1.5 m, battery 80 %"
SILENT = "the controller on the CAN bus is silent"


@pytest.mark.parametrize(
    ("told", "found"),
    [
        (Told(GOOD), [f"ok {SAID}"]),
        (Told(GOOD, simulated=True), [f"ok {SAID}", "warn can: simulated"]),
        (Told(Reading(0)), ["fail can: it opens, and says nothing within 0.1 s"]),
        (Told(Reading(0, trouble=SILENT)), [f"fail can: {SILENT}"]),
        (Told(GOOD, wrong="no such bus"), ["fail can: no such bus"]),
        (Told(Reading(1, 44.0, 8.0)), ["ok can: 44.000000 8.000000", "fail can: no heading"]),
        (Told(Reading(1, heading_rad=0.0)), ["ok can: nan nan, heading 0 deg", "fail can: no position"]),
        (
            Told(Reading(1, 44.0, 8.0, 0.0, authority="pilot")),
            ["ok can: 44.000000 8.000000, heading 0 deg", "warn can: commanded by pilot"],
        ),
    ],
)
def test_a_driver_is_opened_looked_at_and_closed(told: Told, found: list[str]) -> None:
    seen = list(hardware.driver(CONFIG, 0, 0.1, makes(told)))
    assert [f"{one.verdict} {one.found}" for one in seen] == found
    assert all(one.do for one in seen if one.verdict != "ok")
    assert told.closed == (not told.wrong)


def test_a_driver_that_an_agent_has_is_left_alone() -> None:
    (found,) = hardware.driver(CONFIG, 4711, 0.1, makes(Told(GOOD, wrong="opened")))
    assert found.found == "can: left to the agent that runs, process 4711"


def test_a_place_where_nobody_or_somebody_else_listens() -> None:
    nobody = AgentConfig(boat="b1", link=LinkConfig(topology="hub", connect=(f"tcp/127.0.0.1:{free_port()}",)))
    (found,) = reach.links(nobody, 1.0)
    assert (found.verdict, found.found.split(": ")[1]) == ("fail", "nobody listens there")
    with socket.create_server(("127.0.0.1", 0)) as deaf:
        port = deaf.getsockname()[1]
        other = AgentConfig(boat="b1", link=LinkConfig(topology="hub", connect=(f"tcp/127.0.0.1:{port}",)))
        (found,) = reach.links(other, 0.5)
    assert "no session within 0.5 s" in found.found
    routed = AgentConfig(boat="b1", link=LinkConfig(connect=nobody.link.connect, listen=("tcp/127.0.0.1:1",)))
    (found,) = reach.links(routed, 1.0)
    assert found.verdict == "warn", "another boat may be switched off"


def test_a_link_that_is_open_to_strangers_is_said() -> None:
    config = AgentConfig(boat="b1", link=LinkConfig(listen=("tcp/0.0.0.0:7447",), insecure=True))
    found = list(reach.links(config, 0.1))
    assert [one.verdict for one in found] == ["warn", "ok"]
    assert found[0].found.startswith("INSECURE")


NAME = f"b{os.getpid()}"  # of no other agent on this machine


def boat(tmp_path: Path, endpoint: str, world: str = "127.0.0.1:9") -> Path:
    file = tmp_path / "b1.toml"
    file.write_text(
        f'boat = "{NAME}"\nstate_dir = "{tmp_path}/state"\nrecord = "none"\n'
        f'[link]\ntopology = "hub"\nconnect = ["{endpoint}"]\n[driver]\nworld = "{world}"\n'
    )
    return file


@pytest.mark.sails
def test_a_boat_whose_hub_is_there_and_whose_agent_runs(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    file = boat(tmp_path, endpoint)
    before = here("doctor", "--config", str(file), "--timeout", "0.5")
    assert before.returncode == 1
    assert "nobody listens there" in before.stdout
    assert "simulated: it opens, and says nothing" in before.stdout or "simulated: no world" in before.stdout
    assert "-> it wants a world" in before.stdout
    assert "things to mend" in before.stderr
    with running("hub", "--listen", endpoint) as hub, running("agent", "--config", str(file)) as agent:
        assert hub.stdout is not None
        assert hub.stdout.readline()
        until(lambda: here("status", FLEET_CONNECT=endpoint).returncode == 0, "b1 is in reach")
        run = here("doctor", "--config", str(file), "--json")
        told = json.loads(run.stdout)
        found = {one["subject"]: one for one in told["findings"]}
        assert (told["boat"], told["fit"], run.returncode) == (NAME, True, 0), told
        assert found["link"]["found"] == f"{endpoint}: connected, and taken"
        assert found["driver"]["found"] == f"simulated: left to the agent that runs, process {agent.pid}"
        assert {"versions", "clock", "state", "service"} <= set(found)
        assert all(one["do"] for one in told["findings"] if one["verdict"] != "ok")


def test_without_a_configuration_the_machine_is_looked_at(tmp_path: Path) -> None:
    run = here("doctor", HOME=str(tmp_path))
    assert run.returncode == 0, run.stdout
    assert "only the machine was looked at" in run.stdout


def test_a_wrong_configuration_is_wrong_input(tmp_path: Path) -> None:
    file = tmp_path / "b1.toml"
    file.write_text('boat = "b1"\nspeed = 3\n')
    run = here("doctor", "--config", str(file))
    assert (run.returncode, run.stdout) == (2, "")
    assert "speed: unknown key" in run.stderr


def test_the_shipped_boats_can_be_asked_about(tmp_path: Path) -> None:
    for file in sorted((Path(__file__).parents[2] / "deploy" / "boats").glob("*.toml")):
        assert load_config(file, {}, {}).boat == file.stem
