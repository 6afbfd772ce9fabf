"""CPU time of keeping clear of foreign vessels, tick by tick: `python -m fleet.sim.batch.ships_speed`."""

from __future__ import annotations

import math
import random
import statistics
import time
from collections.abc import Sequence

from msgspec import structs

from fleet.avoidance.foreign import START, Boat, Edge, ForeignParams, keep_clear
from fleet.avoidance.foreign.decision import prepare
from fleet.guidance import Limits
from fleet.paths import Path, straight
from fleet.sensing import Target

TICKS, DT_S = 200, 0.1
LOOK_TICKS = 5
BANK: Edge = (-1.0e4, 15.0, 1.0e4, 15.0)
SCENES: tuple[tuple[int, int, tuple[Edge, ...]], ...] = (
    (1, 1, ()), (1, 5, ()), (1, 2, (BANK,)), (5, 1, ()), (10, 1, ()), (10, 5, ()),
)  # fmt: skip
"""Boats in column that one leader decides for, vessels that all meet it, shores."""


def scene(boats: int, vessels: int, seed: int, path: Path) -> tuple[list[Boat], list[Target]]:
    """Boats 10 m apart at 1 m/s, vessels that would be on the first one in 40 to 90 s."""
    draw = random.Random(seed)
    targets = []
    for k in range(vessels):
        U, chi = draw.uniform(0.5, 6.0), draw.uniform(-math.pi, math.pi)
        L, t = draw.uniform(8.0, 60.0), draw.uniform(40.0, 90.0)
        vx, vy = U * math.cos(chi), U * math.sin(chi)
        targets.append(Target(float(k), t - vx * t, -vy * t, vx, vy, 4.0, 0.1, 0.04, 0.0, L, 1.0, 1.0))
    own = [Boat(10.0 * i, 0.0, 0.0, 1.0, 0.0, 10.0 * i, 1.0, Limits(), path) for i in range(boats)]
    return own, targets


def ticks(boats: int, vessels: int, edges: Sequence[Edge], seeds: Sequence[int]) -> tuple[list[float], list[float]]:
    """CPU time of the ticks with a look alone, and of those in which a decision goes on [ms].

    Boats and vessels go straight on, so that they end in a crowd: the dearest that can come.
    """
    path, params = straight((0.0, 0.0), (4000.0, 0.0)), ForeignParams()
    looks: list[float] = []
    decisions: list[float] = []
    for seed in seeds:
        own, targets = scene(boats, vessels, seed, path)
        memory = START
        for k in range(TICKS):
            pending, began = memory.search is not None, time.process_time()
            memory, advice = keep_clear(own, targets, (), edges, memory, params, DT_S * k)
            took = 1.0e3 * (time.process_time() - began)
            if advice.decided > 0.5 or pending:
                decisions.append(took)
            elif k % LOOK_TICKS == 0:
                looks.append(took)
            own = [structs.replace(each, x=each.x + DT_S, s=each.s + DT_S) for each in own]
            targets = [structs.replace(t, x=t.x + DT_S * t.vx, y=t.y + DT_S * t.vy) for t in targets]
    return looks, decisions


def main() -> None:
    """Print a row for each scene."""
    prepare()
    for boats, vessels, edges in SCENES:
        looks, decisions = ticks(boats, vessels, edges, range(8))
        where = ", beside a bank" if edges else ""
        print(
            f"{boats:2d} boats, {vessels} vessels{where}: look {statistics.median(looks):.1f} ms,"
            f" most {max(looks):.1f};"
            f" deciding {statistics.median(decisions):.1f} ms, most {max(decisions):.1f}, {len(decisions)} ticks"
        )


if __name__ == "__main__":
    main()
