"""A small fleet that waits for orders: a hub, a world and two agents, as the simulator starts them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from msgspec import Struct

from fleet.agent.clock import warped
from fleet.mission.load import encode, load
from fleet.sim.processes import Processes
from tests.cli.terminal import fleet as run_fleet
from tests.cli.terminal import until

WARP = 4.0


class Afloat(Struct):
    """How to reach them."""

    processes: Processes
    connect: str

    def fleet(self, *argv: str, operator: str = "anna"):
        """Run a command of an operator."""
        link = {"FLEET_FLEET": "sim", "FLEET_CONNECT": self.connect, "FLEET_OPERATOR": operator}
        return run_fleet(*argv, **link)


@pytest.fixture(scope="module")
def afloat(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Afloat]:
    folder: Path = tmp_path_factory.mktemp("afloat")
    mission = folder / "mission.bin"
    mission.write_bytes(encode(load("overtaking", ["timeline=[]"])))
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
