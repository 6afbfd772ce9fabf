"""`fleet hub` and `fleet agent` as an operator finds them: up, in reach, and ended by a signal."""

from __future__ import annotations

import json
import signal
import subprocess
from pathlib import Path

import psutil
import pytest

from fleet.sim.processes import free_port
from tests.cli.terminal import FLEET, environment, fleet, until

pytestmark = pytest.mark.sails


def test_a_hub_and_an_agent(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    link = {"FLEET_FLEET": "quay", "FLEET_CONNECT": endpoint}
    with subprocess.Popen(
        [*FLEET, "hub", "--listen", endpoint], stdout=subprocess.PIPE, text=True, env=environment()
    ) as hub:
        assert hub.stdout is not None
        assert hub.stdout.readline() == f"hub listens at {endpoint}; Ctrl-C ends it\n"
        nobody = fleet("status", **link)
        assert (nobody.returncode, nobody.stderr) == (4, "error: no boat of fleet 'quay' is in reach\n")
        line = ["agent", "--boat", "b1", "--topology", "hub", "--record", "none", "--world", "127.0.0.1:9"]
        with subprocess.Popen(
            [*FLEET, *line, "--state-dir", str(tmp_path)], stderr=subprocess.DEVNULL, env=environment(**link)
        ) as agent:
            until(lambda: fleet("status", **link).returncode == 0, "b1 is in reach")
            (boat,) = json.loads(fleet("status", "--json", **link).stdout)["boats"]
            assert (boat["boat"], boat["alive"], boat["mode"]) == ("b1", True, "fault")  # no world: no position
            assert psutil.Process(agent.pid).cmdline()[1:3] == ["-m", "fleet.agent"]
            agent.send_signal(signal.SIGTERM)
            assert agent.wait(10) == 0
        hub.send_signal(signal.SIGTERM)
        assert hub.wait(10) == 0
