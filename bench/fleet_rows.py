"""Fleets of real agents: the whole tick, loss, lateness, CPU by kind of thread, memory, start-up."""

from __future__ import annotations

import statistics

from bench.fleet_run import HZ, Result, Window, run
from bench.table import Row, Table
from bench.timing import REFERENCE_US, percentile

TICK_AIM_US = 300.0
LATE_AIM_MS = 10.0
MEMORY_AIM_MIB = 45.0


def tick_rows(table: Table, quick: bool) -> None:
    """The whole tick of a real agent with 1 and with 10 peers."""
    for boats in (2, 11):
        result = run(boats, *((4.0, 6.0) if quick else (8.0, 12.0)), table.say)
        for window in result.windows.values():
            _tick_row(table, f"{boats - 1} peers, {window.name}", "whole agent tick, CPU of the loop's thread", window)


def fleet_rows(table: Table, quick: bool) -> None:
    """10, 25 and 50 agents with hub and world on this machine."""
    for boats in (10, 25, 50):
        result = run(boats, *((4.0, 8.0) if quick else (10.0, 20.0)), table.say)
        group = f"{boats} agents at {HZ:g} Hz, hub and world, one machine"
        _start_rows(table, group, result)
        for window in result.windows.values():
            _window_rows(table, group, window)


def _tick_row(table: Table, name: str, group: str, window: Window) -> None:
    median = statistics.median(window.tick_us)
    table.add(
        Row(
            group=group,
            name=name,
            value=median,
            unit="us",
            ratio=median / window.slept_us,
            over="calibration, slept",
            aim=TICK_AIM_US,
            scale=max(window.unit_us / REFERENCE_US, 1.0),
            note=f"p99 {percentile(window.tick_us, 0.99):.0f} us; calibration {window.unit_us:.1f} us warm, "
            f"{window.slept_us:.1f} slept",
        )
    )


def _start_rows(table: Table, group: str, result: Result) -> None:
    table.add(Row(group=group, name="first process to all alive and heard", value=result.start_s, unit="s"))
    table.add(
        Row(
            group=group,
            name="an agent's CPU up to its first tick",
            value=result.first_tick_cpu_ms,
            unit="ms",
            aim=150.0,
        )
    )
    table.add(Row(group=group, name="the tick that takes a mission, CPU", value=result.worst_launch_ms, unit="ms"))


def _window_rows(table: Table, group: str, window: Window) -> None:
    what = window.name
    share = 100.0 * window.heard / max(window.could, 1.0)
    table.add(
        Row(
            group=group,
            name=f"{what}: messages lost",
            value=float(window.lost),
            unit="",
            aim=0.0,
            note=f"of {window.heard + window.lost}, {share:.1f} % of those due",
        )
    )
    table.add(
        Row(
            group=group,
            name=f"{what}: lateness of ticks, p99",
            value=window.late(0.99),
            unit="ms",
            aim=LATE_AIM_MS,
            note=f"p50 {window.late(0.5):.2f} ms, {window.skipped} of {len(window.late_ms)} ticks skipped; "
            f"strangers used {window.strangers:.2f} cores",
        )
    )
    _tick_row(table, f"{what}: whole tick", group, window)
    ticks = len(window.late_ms)
    agents = window.agents.values()
    parts = [sum(getattr(a, kind) for a in agents) for kind in ("loop", "zenoh", "others")]
    cores = sum(parts) / window.seconds * 1e-9
    around = [x.all / window.seconds * 1e-9 for x in (window.hub, window.world)]
    loop, zenoh, others = (part * 1e-3 / ticks for part in parts)
    table.add(
        Row(
            group=group,
            name=f"{what}: cores, all together",
            value=cores + sum(around),
            unit="",
            aim=2.0,
            note=f"agents {cores:.2f}, hub {around[0]:.2f}, world {around[1]:.2f}; "
            f"a tick: loop {loop:.0f}, Zenoh {zenoh:.0f}, recorder {others:.0f} us",
        )
    )
    table.add(
        Row(
            group=group,
            name=f"{what}: resident memory of an agent",
            value=statistics.median(window.rss),
            unit="MiB",
            aim=MEMORY_AIM_MIB,
            note=f"proportional share {statistics.median(window.pss):.1f} MiB",
        )
    )
