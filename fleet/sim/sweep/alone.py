"""One case of a sweep sailed alone on floats, with its trace: the same bits as its lane."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from msgspec import Struct

from fleet.sim.batch import Results, Trace, run
from fleet.sim.batch.hearing import TICK_S
from fleet.sim.sweep import ships_results
from fleet.sim.sweep.family import Family, case_name
from fleet.sim.sweep.ships_results import ShipResults
from fleet.sim.sweep.table import figures


class Closest(Struct, frozen=True):
    """When which two boats were nearest; boats count from 1."""

    first: int
    second: int
    t_s: float
    distance_m: float


def sail_case(family: Family, seed: int, point: int, case: int, floats: bool | None = True) -> Results:
    """One case with its trace.

    Args:
        family: its family
        seed: of the sweep
        point: number of the grid point
        case: number of the case
        floats: None: on arrays where that is faster
    """
    chosen = family.points[point]
    scenarios = family.scenarios(seed, chosen, np.array([case]))
    return run(scenarios, record=(case,), floats=floats, **family.run_options(chosen))


def closest(trace: Trace) -> Closest | None:
    """Of a trace, between ticks too, as both moved in straight lines; None for a single boat."""
    pairs = list(combinations(range(trace.x.shape[1]), 2))
    if not pairs:
        return None
    best = Closest(1, 2, 0.0, np.inf)
    for i, j in pairs:
        dx, dy = trace.x[:, j] - trace.x[:, i], trace.y[:, j] - trace.y[:, i]
        wx, wy = np.diff(dx), np.diff(dy)
        moved = wx * wx + wy * wy
        share = np.clip(-(dx[:-1] * wx + dy[:-1] * wy) / np.where(moved > 0.0, moved, 1.0), 0.0, 1.0)
        apart = np.append(np.hypot(dx[:-1] + share * wx, dy[:-1] + share * wy), np.hypot(dx[-1], dy[-1]))
        k = int(apart.argmin())
        if apart[k] < best.distance_m:
            into = float(share[k]) if k < len(share) else 0.0
            best = Closest(i + 1, j + 1, float(trace.t[k]) + into * TICK_S, float(apart[k]))
    return best


def reasons(results: Any) -> list[str]:
    """Why the one case failed; none if it did not."""
    if isinstance(results, ShipResults):
        return ships_results.reasons(results)
    found = []
    if results.collided[0]:
        found.append(f"collision: {results.least_m[0]:.2f} m, hulls are {results.hull_m:g} m long")
    boats = [f"boat {k + 1}" for k in np.flatnonzero(results.stood[0])]
    if boats:
        found.append(f"standstill: {', '.join(boats)}")
    never = np.isfinite(results.nominal_s[0]) & ~np.isfinite(results.arrived_s[0])
    if never.any():
        found.append(f"not arrived: {', '.join(f'boat {k + 1}' for k in np.flatnonzero(never))}")
    return found


def told(family: Family, seed: int, point: int, results: Results) -> dict[str, Any]:
    """Everything about one case, for `--json` and the table."""
    near = closest(results.traces[0]) if results.traces else None
    boats = [
        {
            "boat": k + 1,
            "nominal_s": float(results.nominal_s[0, k]),
            "arrived_s": float(results.arrived_s[0, k]),
            "delay_s": float(results.delay_s[0, k]),
            "switches": int(results.switches[0, k]),
            "cross_track_rms_m": float(results.cross_track_rms_m[0, k]),
            "formation_rms_m": float(results.formation_rms_m[0, k]),
            "stood": bool(results.stood[0, k]),
        }
        for k in range(results.stood.shape[1])
    ]
    why = reasons(results)
    return {
        "case": f"{family.name}:{case_name(family, seed, point, int(results.case[0]))}",
        "method": results.method,
        "radius_m": results.radius_m,
        "hull_m": results.hull_m,
        **figures([results]),
        "closest": None
        if near is None
        else {"boats": [near.first, near.second], "at_s": near.t_s, "distance_m": float(results.least_m[0])},
        "inside_s": float(results.inside_s[0]),
        "ended_s": float(results.ended_s[0]),
        "boats": boats,
        "failed": bool(why),
        "why": why,
    }
