"""CPU time of keeping clear of foreign vessels, tick by tick: `python -m fleet.sim.batch.ships_speed`."""

from __future__ import annotations

import math
import random
import statistics
import time
from collections.abc import Sequence

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.foreign import START, Boat, Edge, ForeignParams, keep_clear
from fleet.avoidance.foreign.decision import prepare, speed
from fleet.avoidance.foreign.rollout import left_to_turn
from fleet.guidance import Limits, follow
from fleet.paths import Path, straight
from fleet.sensing import Target

TICKS, DT_S = 300, 0.1
ALIKE = 3  # times that every scene is sailed; of each tick the least time counts, which is that of an idle machine
BANK: Edge = (-1.0e4, 15.0, 1.0e4, 15.0)
SCENES: tuple[tuple[int, int, tuple[Edge, ...]], ...] = (
    (1, 1, ()), (1, 5, ()), (1, 2, (BANK,)), (5, 1, ()), (10, 1, ()), (10, 5, ()), (10, 5, (BANK,)),
)  # fmt: skip
"""Boats in column that one leader decides for, vessels that all meet it, shores."""


class Ticks(Struct):
    """CPU time of ticks by what was done in them [ms]."""

    looks: list[float]
    decisions: list[float]  # a decision began, went on or was made
    rest: list[float]


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


def _sailed(boat: Boat, acting: bool, cx: float, cy: float, factor: float, params: ForeignParams) -> Boat:
    """A boat a tick later, on the alteration or on its path."""
    f = follow(boat.x, boat.y, boat.chi, boat.U, boat.path.at(boat.s), params.follow)
    limits = boat.limits
    wanted = params.k1 * left_to_turn(boat.chi, cx, cy, 0.0) if acting else f.r_d
    wanted = ops.clip(wanted, -limits.yaw_rate_max_radps, limits.yaw_rate_max_radps)
    r = boat.r + DT_S / limits.yaw_lag_s * (wanted - boat.r)
    U = boat.U + DT_S / limits.surge_lag_s * ((speed(boat, factor) if acting else boat.cruise) - boat.U)
    chi = boat.chi + DT_S * r
    x, y = boat.x + DT_S * U * math.cos(chi), boat.y + DT_S * U * math.sin(chi)
    return structs.replace(boat, x=x, y=y, chi=chi, U=U, r=r, s=boat.s + DT_S * f.s_dot)


def _sail(boats: int, vessels: int, edges: Sequence[Edge], seed: int) -> list[tuple[float, str]]:
    """CPU time of every tick [ms], and what was done in it."""
    path, params = straight((0.0, 0.0), (4000.0, 0.0)), ForeignParams()
    own, targets = scene(boats, vessels, seed, path)
    memory, found = START, []
    for k in range(TICKS):
        pending, due_s, began = memory.search is not None, memory.due_s, time.process_time()
        memory, advice = keep_clear(own, targets, (), edges, memory, params, DT_S * k)
        took = 1.0e3 * (time.process_time() - began)
        decides = advice.decided > 0.5 or pending or memory.search is not None
        looks = memory.glance is not None or memory.due_s != due_s
        found.append((took, "decisions" if decides else "looks" if looks else "rest"))
        acting = advice.acting > 0.5
        own = [_sailed(each, acting, advice.cx, advice.cy, advice.factor, params) for each in own]
        targets = [structs.replace(t, x=t.x + DT_S * t.vx, y=t.y + DT_S * t.vy) for t in targets]
    return found


def ticks(boats: int, vessels: int, edges: Sequence[Edge], seeds: Sequence[int], alike: int = ALIKE) -> Ticks:
    """CPU time of ticks; the boats sail what is advised, and meet all vessels at about the same time."""
    times = Ticks([], [], [])
    for seed in seeds:
        runs = [_sail(boats, vessels, edges, seed) for _ in range(alike)]
        for same in zip(*runs, strict=True):
            getattr(times, same[0][1]).append(min(took for took, _ in same))
    return times


def main() -> None:
    """Print a row for each scene."""
    prepare()
    for boats, vessels, edges in SCENES:
        times = ticks(boats, vessels, edges, range(8))
        where = ", beside a bank" if edges else ""
        looks, decisions = times.looks, times.decisions
        print(
            f"{boats:2d} boats, {vessels} vessels{where}: look {statistics.median(looks):.1f} ms,"
            f" most {max(looks):.1f}; deciding {statistics.median(decisions):.1f} ms, most {max(decisions):.1f},"
            f" {len(decisions)} ticks; others {statistics.median(times.rest):.2f} ms",
            flush=True,
        )


if __name__ == "__main__":
    main()
