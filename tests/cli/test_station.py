"""`fleet hub` and `fleet agent` as an operator finds them: up, in reach, and ended by a signal."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import psutil
import pytest

from fleet.sim.processes import free_port
from tests.cli.terminal import fleet, running, until

pytestmark = pytest.mark.sails


def test_a_hub_and_an_agent(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    link = {"FLEET_FLEET": "quay", "FLEET_CONNECT": endpoint}
    flags = ["--topology", "hub", "--record", "none", "--world", "127.0.0.1:9", "--state-dir", str(tmp_path)]
    with running("hub", "--listen", endpoint) as hub, running("agent", "--boat", "b1", *flags, **link) as agent:
        assert hub.stdout is not None
        assert hub.stdout.readline() == f"hub listens at {endpoint}; Ctrl-C ends it\n"
        until(lambda: fleet("status", **link).returncode == 0, "b1 is in reach")
        (boat,) = json.loads(fleet("status", "--json", **link).stdout)["boats"]
        assert (boat["boat"], boat["alive"], boat["mode"]) == ("b1", True, "standby")
        assert "own navigation is stale or not finite" in boat["reasons"]  # there is no world
        assert psutil.Process(agent.pid).cmdline()[1:3] == ["-m", "fleet.agent"]
        agent.send_signal(signal.SIGTERM)
        assert agent.wait(10) == 0
        nobody = fleet("status", **link)
        assert (nobody.returncode, nobody.stderr) == (4, "error: no boat of fleet 'quay' is in reach\n")
        hub.send_signal(signal.SIGTERM)
        assert hub.wait(10) == 0
