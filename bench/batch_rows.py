"""The batch simulator and lock-step: CPU of a boat-tick, and of a simulated second, in units of the calibration loop.

`python -m bench.batch_rows CASES` sails so many scenarios and prints what they took, for the row of two processes.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec import Struct, structs

from bench.table import Row, Table
from bench.timing import CALIBRATION, REFERENCE_US, calibration
from fleet.avoidance import circle, scoring
from fleet.mission.load import load
from fleet.sim.batch import Scenarios, run
from fleet.sim.batch.families import crossing, two_boat
from fleet.sim.lockstep import sail_lockstep
from fleet.sim.share import Options
from fleet.sim.sweep.family import load as load_family

SAILED_S = 120.0  # the encounters lie within
SIZES = {2: (1, 2, 10, 100, 1000, 10_000), 8: (8, 1000, 10_000)}  # boats, by boats of a scenario
QUICK = 1000
AIM_US = {"circle": 0.5, "scoring": 1.0}  # 2 and 1 million boat-ticks a second
AIM_FROM = 1000
DECISION_TICKS = 5
APART = 1.8  # times as much on two cores as on one
LOCKSTEP_AIM = {"without recording": 300.0, "with recording": 150.0}  # times real time
LOCKSTEP_S = 60.0


class Sailed(Struct, frozen=True):
    """One run."""

    boat_ticks: int
    cpu_s: float
    wall_s: float
    unit_us: float  # the calibration loop, around it

    @property
    def us(self) -> float:
        """CPU of a boat-tick."""
        return self.cpu_s / self.boat_ticks * 1e6


def scenarios_of(boats: int, together: int) -> Scenarios:
    """So many boats in scenarios of two (one boat: alone) or of eight."""
    if together == 8:
        all_of_them = crossing(boats // 8, 1, 8)
    else:
        all_of_them = two_boat(boats // 2, 1) if boats > 1 else crossing(1, 1, 1)
    return structs.replace(all_of_them, limit_s=np.full(all_of_them.count, SAILED_S))


def sailed(scenarios: Scenarios, method: str) -> Sailed:
    """Sail them once, with the calibration loop before and after."""
    before = _unit_us()
    wall, cpu = time.perf_counter(), time.process_time()
    result = run(scenarios, method)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    return Sailed(result.boat_ticks, cpu, wall, 0.5 * (before + _unit_us()))


def _unit_us() -> float:
    began = time.thread_time_ns()
    for _ in range(500):
        calibration()
    return (time.thread_time_ns() - began) * 1e-3 / 500


def share_that_acts(scenarios: Scenarios, method: str) -> float:
    """Share of the decisions that search (scoring, twice a second) or circle (every tick), of all boats' decisions."""
    module: Any = scoring if method == "scoring" else circle
    name = "search" if method == "scoring" else "_on_circle"
    law: Callable[..., Any] = getattr(module, name)
    acted = 0

    def counted(own: Any, *rest: Any) -> Any:  # both laws take the own boat first
        nonlocal acted
        acted += int(np.size(own.x))
        return law(own, *rest)

    setattr(module, name, counted)
    try:
        result = run(scenarios, method)
    finally:
        setattr(module, name, law)
    return acted / result.boat_ticks * (DECISION_TICKS if method == "scoring" else 1)


def batch_rows(table: Table, quick: bool) -> None:
    """Boat-ticks by number of boats; lanes that search beside it."""
    for method in ("circle", "scoring"):
        for together, sizes in SIZES.items():
            for boats in sizes:
                if not quick or boats <= QUICK:
                    _batch_row(table, boats, together, method, 1 if quick or boats > QUICK else 3)
    _apart_row(table, 500 if quick else 2000)


def _batch_row(table: Table, boats: int, together: int, method: str, repetitions: int) -> None:
    scenarios = scenarios_of(boats, together)
    share = share_that_acts(scenarios.part(slice(0, min(scenarios.count, 100))), method)
    runs = [sailed(scenarios, method) for _ in range(repetitions)]
    us, unit_us = statistics.median(s.us for s in runs), statistics.median(s.unit_us for s in runs)
    acts = "search" if method == "scoring" else "circle"
    table.add(
        Row(
            group="batch, CPU of a boat-tick",
            name=f"{method}, {boats} boats" + (", eight a scenario" if together == 8 else ""),
            value=us,
            unit="us",
            ratio=statistics.median(s.us / s.unit_us for s in runs),
            over=CALIBRATION,
            aim=AIM_US[method] if boats >= AIM_FROM and together != 8 else None,
            scale=unit_us / REFERENCE_US,
            note=f"{1.0 / us:.3f} M a second; {100.0 * share:.1f} % of the decisions {acts}",
        )
    )


def _apart_row(table: Table, cases: int) -> None:
    """As much work in each of two processes at once as in one alone."""
    alone, together = [], []
    for _ in range(3):
        alone.append(_children(1, cases))
        together.append(_children(2, cases))
    wall_1, cpu_1 = (min(values) for values in zip(*alone, strict=True))
    wall_2, cpu_2 = (min(values) for values in zip(*together, strict=True))
    table.add(
        Row(
            group="batch, CPU of a boat-tick",
            name=f"scoring, {2 * cases} boats, two processes / one, each",
            value=cpu_2,
            unit="s",
            ratio=cpu_2 / cpu_1,
            over="one process",
            aim=2.0 / APART,
            aim_is_ratio=True,
            note=f"two sail {2.0 * cpu_1 / cpu_2:.2f} times as much by CPU, {2.0 * wall_1 / wall_2:.2f} by the wall",
        )
    )


def rules_row(table: Table, quick: bool) -> None:
    """Everything at once (family `fleet`: errors, current, loss, delay, two kinds of hull) beside exact encounters."""
    cases = 60 if quick else 250
    family = load_family("fleet", boats=8)
    plain = scenarios_of(8 * cases, 8)
    every = structs.replace(family.scenarios(1, 0, range(cases)), limit_s=np.full(cases, SAILED_S))
    spent = [(sailed(plain, "scoring"), sailed(every, "scoring")) for _ in range(1 if quick else 3)]
    us = statistics.median(s.us for _, s in spent)
    for name, value, ratio, over in (
        ("exact states, perfect radio", statistics.median(p.us for p, _ in spent), None, ""),
        ("all rules, errors, current, loss, delay", us, statistics.median(s.us / p.us for p, s in spent), "exact"),
    ):
        note = f"{1.0 / value:.3f} M a second"
        table.add(
            Row(group=f"sweep of {cases} encounters of eight boats, CPU of a boat-tick", name=name, value=value,
                unit="us", ratio=ratio, over=over, note=note)
        )  # fmt: skip


def _children(count: int, cases: int) -> tuple[float, float]:
    """(wall, CPU) of the slowest of so many processes, each with all the scenarios [s]."""
    command = [sys.executable, "-m", "bench.batch_rows", str(cases)]
    children = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(count)]
    said = [child.communicate()[0].split() for child in children]
    return max(float(s[0]) for s in said), max(float(s[1]) for s in said)


def lockstep_rows(table: Table, quick: bool) -> None:
    """The whole real agent, five boats in lock-step."""
    mission = structs.replace(load("survey-column"), duration_s=LOCKSTEP_S if quick else 5.0 * LOCKSTEP_S)
    boats = len(mission.boats)
    spent: dict[str, list[tuple[float, float]]] = {name: [] for name in LOCKSTEP_AIM}
    for _ in range(2 if quick else 5):
        for name, kept in spent.items():
            with tempfile.TemporaryDirectory() as folder:
                before, began = _unit_us(), time.process_time()
                sailing = sail_lockstep(mission, "bench", Options(seed=1, record=name == "with recording", root=folder))
                ms = (time.process_time() - began) * 1e3 / sailing.simulated_s
                kept.append((ms, 0.5 * (before + _unit_us())))
    for name, kept in spent.items():
        ms = min(ms for ms, _ in kept)
        unit_us = statistics.median(unit for _, unit in kept)
        table.add(
            Row(
                group=f"lock-step of {boats} real agents, CPU of a simulated second, best",
                name=name,
                value=ms,
                unit="ms",
                ratio=min(ms / unit * 1e3 for ms, unit in kept),
                over=CALIBRATION,
                aim=1e3 / LOCKSTEP_AIM[name],
                scale=unit_us / REFERENCE_US,
                note=f"{1e3 / ms:.0f} times real time, {ms * 100.0 / boats:.0f} us a boat and tick",
            )
        )


if __name__ == "__main__":
    spent = sailed(scenarios_of(2 * int(sys.argv[1]), 2), "scoring")
    print(spent.wall_s, spent.cpu_s)
