"""What one agent costs with each driver, with sensors, and with a LIDAR, at their working rates."""

from __future__ import annotations

import statistics
from typing import Any, get_args

from bench.fleet_run import HZ, Window, run
from bench.scenes import moored
from bench.table import Row, Table
from fleet.mission.model import Lidar, Positions
from fleet.sim.device import DriverKind

BOATS = 3
GROUP = f"one agent with each driver, {BOATS} boats in column at {HZ:g} Hz"
SENSORS = f"one agent with sensors beside the driver, {BOATS} boats in column at {HZ:g} Hz"
PLAIN, POSITIONS = "driver simulated", "a moored vessel by bare positions, 1 Hz"


def driver_rows(table: Table, quick: bool) -> None:
    """A fleet with each: CPU of one agent, all its threads, and its memory."""
    plain = _row(table, quick, GROUP, PLAIN)
    kinds: tuple[DriverKind, ...] = get_args(DriverKind)
    for driver in (kind for kind in kinds if kind != "simulated"):
        _row(table, quick, GROUP, f"driver {driver}", (plain, PLAIN), driver=driver)
    _row(table, quick, SENSORS, "60 sentences of NMEA 0183 a second", (plain, PLAIN), sensors="nmea")
    blind = _row(table, quick, SENSORS, POSITIONS, (plain, PLAIN), traffic=(moored(Positions()),))
    name = "the vessel by a LIDAR, 10 scans of 1,081 beams a second"
    _row(table, quick, SENSORS, name, (blind, POSITIONS), traffic=(moored(Lidar()),))


def _row(table: Table, quick: bool, group: str, name: str, over: tuple[float, str] | None = None, **more: Any) -> float:
    """Cores that one agent takes; with a row that says so, beside another's."""
    window = run(BOATS, *((2.0, 8.0) if quick else (4.0, 30.0)), table.say, **more).windows["sailing"]
    share = _share(window)
    loop = sum(agent.loop for agent in window.agents.values()) / sum(agent.all for agent in window.agents.values())
    table.add(
        Row(
            group=group,
            name=f"{name}: CPU of an agent under way",
            value=100.0 * share,
            unit="% of a core",
            ratio=share / (over[0] if over else share),
            over=over[1] if over else name,
            note=f"{100.0 * loop:.0f} % in the loop's thread; {statistics.median(window.rss):.0f} MiB resident; "
            f"strangers used {window.strangers:.2f} cores",
        )
    )
    return share


def _share(window: Window) -> float:
    """Cores that one agent takes, median over the boats."""
    return statistics.median(agent.all for agent in window.agents.values()) / window.seconds * 1e-9
