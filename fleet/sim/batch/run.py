"""Sail a set of scenarios: in chunks of lanes that stay in the cache, or one by one on floats where they are few."""

from __future__ import annotations

import time
from collections.abc import Collection
from typing import Any

from fleet.agent.step import StepParams
from fleet.avoidance import METHODS, Side
from fleet.guidance import FollowParams, StationParams
from fleet.sim.batch.block import Rules
from fleet.sim.batch.results import Results
from fleet.sim.batch.scenarios import Scenarios
from fleet.sim.batch.voyage import Voyage

LANES = 8192  # of a chunk: its arrays of 32 KiB stay in the second-level cache
AT_ONCE = 16  # chunks that sail side by side, so that their last scenarios can be put together
FLOATS_BELOW = 20  # lanes; arrays and floats cost the same about there


def run(
    scenarios: Scenarios,
    method: str = "scoring",
    *,
    radius_m: float = 6.0,
    side: Side = "closest",
    params: Any = None,
    record: Collection[int] = (),
    lanes: int = LANES,
    floats: bool | None = None,
) -> Results:
    """Sail every scenario until all its boats have arrived, or its time is up.

    A scenario gives the same bits in any chunk, and on floats.

    Args:
        scenarios: what to sail
        method: way of keeping clear, of `fleet.avoidance.METHODS`
        radius_m: safety radius R
        side: rule of the side, for methods that have one
        params: tuning of the method; its own for that radius if None
        record: cases whose trajectories are kept
        lanes: boats in one chunk of arrays
        floats: True one by one on floats, False on arrays; None: whichever is faster; wingmen only on floats
    """
    began = time.perf_counter()
    rules = Rules(
        method=METHODS[method],
        params=StepParams(
            follow=FollowParams(),
            station=StationParams(),
            limits=scenarios.limits,
            keep=METHODS[method].params(radius_m, side) if params is None else params,
        ),
        hulls=scenarios.hulls,
        radius_m=radius_m,
        formations=int(scenarios.member.max(initial=0.0)),
        clock_error_s=scenarios.clock_error_s,
        gnss_sigma_m=scenarios.gnss_sigma_m,
        gnss_white_m=scenarios.gnss_white_m,
        gnss_velocity_mps=scenarios.gnss_velocity_mps,
    )
    if floats is None:
        floats = scenarios.winged or scenarios.count * scenarios.boats < FLOATS_BELOW
    size = 1 if floats else max(1, AT_ONCE * lanes // scenarios.boats)
    parts = []
    for first in range(0, scenarios.count, size):
        voyage = Voyage(scenarios.part(slice(first, first + size)), rules, record)
        parts.append(voyage.sail(None if floats else max(1, lanes // scenarios.boats)))
    results = parts[0] if len(parts) == 1 else Results.joined(parts)
    results.wall_s = time.perf_counter() - began
    return results
