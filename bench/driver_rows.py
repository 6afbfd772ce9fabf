"""What one agent costs with each driver at its working rates, against the agent whose world is simulated."""

from __future__ import annotations

import statistics
from typing import get_args

from bench.fleet_run import HZ, Window, run
from bench.table import Row, Table
from fleet.sim.device import DriverKind

BOATS = 3
GROUP = f"one agent with each driver, {BOATS} boats in column at {HZ:g} Hz"


def driver_rows(table: Table, quick: bool) -> None:
    """A fleet with each driver: CPU of one agent, all its threads, and its memory."""
    plain = 0.0
    known: tuple[DriverKind, ...] = get_args(DriverKind)
    for driver in sorted(known, key=lambda kind: kind != "simulated"):
        window = run(BOATS, *((2.0, 8.0) if quick else (4.0, 30.0)), table.say, driver).windows["sailing"]
        share = _share(window)
        plain = plain or share
        loop = sum(agent.loop for agent in window.agents.values()) / sum(agent.all for agent in window.agents.values())
        table.add(
            Row(
                group=GROUP,
                name=f"driver {driver}: CPU of an agent under way",
                value=100.0 * share,
                unit="% of a core",
                ratio=share / plain,
                over="driver simulated",
                note=f"{100.0 * loop:.0f} % in the loop's thread; {statistics.median(window.rss):.0f} MiB resident; "
                f"strangers used {window.strangers:.2f} cores",
            )
        )


def _share(window: Window) -> float:
    """Cores that one agent takes, median over the boats."""
    return statistics.median(agent.all for agent in window.agents.values()) / window.seconds * 1e-9
