"""A small fleet that waits for orders: a hub, a world and two agents, as the simulator starts them."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from subprocess import CompletedProcess
from unittest import mock

import pytest
from msgspec import Struct

from fleet.agent.clock import warped
from fleet.cli.main import main
from fleet.mission.load import encode, load
from fleet.sim.processes import Processes
from tests.cli.terminal import until

WARP = 8.0
FENCE = "fence.points=[[-50,-60],[3100,-60],[3100,60],[-50,60]]"
LONG = ("timeline=[]", "paths.line.end=[3000,0]", FENCE)  # a path that the tests do not reach the end of


class Afloat(Struct):
    """How to reach them."""

    processes: Processes
    connect: str

    def fleet(self, *argv: str, operator: str = "anna") -> CompletedProcess[str]:
        """Run a command of an operator; in this process, since starting forty takes longer than their work."""
        link = {"FLEET_FLEET": "sim", "FLEET_CONNECT": self.connect, "FLEET_OPERATOR": operator}
        out, err = io.StringIO(), io.StringIO()
        with mock.patch.dict(os.environ, link), redirect_stdout(out), redirect_stderr(err):
            code = main(argv)
        return CompletedProcess(argv, code, out.getvalue(), err.getvalue())


@pytest.fixture(scope="module")
def afloat(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Afloat]:
    folder: Path = tmp_path_factory.mktemp("afloat")
    mission = folder / "mission.bin"
    mission.write_bytes(encode(load("overtaking", LONG)))
    clock = warped(WARP)
    processes = Processes(folder, clock, ("b1", "b2"), fleet="sim", topology="hub", seed=0, record=False)
    try:
        processes.start_hub()
        processes.start_world(mission)
        for boat in ("b1", "b2"):
            processes.start_agent(boat)
        one = Afloat(processes, processes.connect[0])
        until(lambda: one.fleet("status").stdout.count("standby") == 2, "two boats in standby")
        yield one
    finally:
        processes.close()
