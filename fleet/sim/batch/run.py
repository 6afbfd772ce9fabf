"""Sail a set of scenarios: in chunks of lanes that stay in the cache, or one by one on floats where they are few."""

from __future__ import annotations

import time
from collections.abc import Collection
from typing import Any

import numpy as np

from fleet.agent.step import StepParams
from fleet.avoidance import METHODS, Side
from fleet.guidance import FollowParams, StationParams
from fleet.ops import FloatArray
from fleet.sim.batch.block import Rules
from fleet.sim.batch.hearing import TICK_S
from fleet.sim.batch.results import PER_BOAT, PER_SCENARIO, Results, Trace
from fleet.sim.batch.scenarios import Scenarios
from fleet.sim.batch.sea import TRACED, BatchSea, Counted, LoneSea, Sea
from fleet.sim.batch.tally import CHECK_TICKS, SETTLED_M

LANES = 2048  # of a chunk
ROOM_FROM = 8  # scenarios that have ended are left out when they are more than one in so many
FLOATS_BELOW = 10  # lanes; arrays and floats cost the same about there


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
        floats: True one by one on floats, False on arrays; None: whichever is faster
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
        hull=scenarios.hull,
        radius_m=radius_m,
        formation=bool((scenarios.member > 0.0).any()),
        clock_error_s=scenarios.clock_error_s,
        gnss_sigma_m=scenarios.gnss_sigma_m,
        gnss_white_m=scenarios.gnss_white_m,
    )
    if floats is None:
        floats = scenarios.count * scenarios.boats < FLOATS_BELOW
    size = 1 if floats else max(1, lanes // scenarios.boats)
    parts = []
    for first in range(0, scenarios.count, size):
        chunk = scenarios.part(slice(first, first + size))
        sea = LoneSea(chunk, rules) if floats else BatchSea(chunk, rules)
        parts.append(_Sailing(chunk, sea, rules, record).sail())
    results = parts[0] if len(parts) == 1 else Results.joined(parts)
    results.wall_s = time.perf_counter() - began
    return results


class _Sailing:
    """One chunk on its way, and its results as they come in."""

    def __init__(self, scenarios: Scenarios, sea: Sea, rules: Rules, record: Collection[int]) -> None:
        shape = (scenarios.count, scenarios.boats)
        self._scenarios, self._sea = scenarios, sea
        self._limit = np.ceil(scenarios.limit_s / (TICK_S * CHECK_TICKS) - 1e-6) * CHECK_TICKS
        self._traced = {row for row in range(shape[0]) if int(scenarios.case[row]) in record}
        self._steps: dict[int, list[FloatArray]] = {row: [] for row in self._traced}
        if self._traced:
            sea.watch = self._trace
        self._results = Results(
            family=scenarios.family,
            method=rules.method.name,
            seed=scenarios.seed,
            hull_m=scenarios.limits.length_m,
            radius_m=rules.radius_m,
            case=scenarios.case,
            traces=[],
            **{name: np.zeros(shape) for name in PER_BOAT},
            **{name: np.zeros(shape[0]) for name in PER_SCENARIO},
        )
        self._results.nominal_s = scenarios.nominal_s

    def sail(self) -> Results:
        """Until all scenarios have ended; those that have make room now and then."""
        sea, now = self._sea, 0
        ended = np.zeros(len(sea.rows), dtype=bool)
        while len(sea.rows):
            for _ in range(CHECK_TICKS):
                sea.tick(now)
                now += 1
            self._results.boat_ticks += CHECK_TICKS * len(sea.rows) * self._scenarios.boats
            sea.check()
            counted = sea.counted()
            over = (counted.boats["arrived"] < np.inf).all(axis=1) | (now >= self._limit[sea.rows])
            fresh = np.flatnonzero(over & ~ended)
            if len(fresh):
                self._take(sea.rows[fresh], fresh, now, counted)
            ended |= over
            if ended.all():
                break
            if ended.sum() * ROOM_FROM > len(ended):
                kept = np.flatnonzero(~ended)
                sea.keep(kept)
                ended = ended[kept]
        return self._finished()

    def _trace(self, _now: int) -> None:
        """A tick of the scenarios that are recorded."""
        seen = self._sea.seen()
        for column, row in enumerate(self._sea.rows.tolist()):
            if row in self._traced and self._results.ended_s[row] == 0.0:
                self._steps[row].append(seen[:, :, column])

    def _take(self, rows: Any, columns: Any, ticks: int, counted: Counted) -> None:
        """The counts of scenarios that have ended become results."""
        r = self._results
        t = {name: values[columns] for name, values in counted.boats.items()}
        measured = np.maximum(t["ticks"], 1.0)
        r.least_m[rows] = np.sqrt(counted.least_sq[columns])
        r.inside_s[rows] = counted.inside[columns] * TICK_S
        r.ended_s[rows] = ticks * TICK_S
        r.arrived_s[rows] = t["arrived"] * TICK_S
        r.switches[rows] = t["switches"]
        r.cross_track_rms_m[rows] = np.sqrt(t["y_sq"] / measured)
        r.cross_track_most_m[rows] = t["y_most"]
        r.formation_rms_m[rows] = np.sqrt(t["e_sq"] / measured)
        r.formation_most_m[rows] = t["e_most"]
        r.formation_end_m[rows] = t["e_last"]
        r.settled_s[rows] = np.where(t["e_last"] >= SETTLED_M, np.inf, (t["unsettled"] + 1.0) * TICK_S)
        r.stood[rows] = t["stood"]

    def _finished(self) -> Results:
        """With the traces."""
        for row in sorted(self._traced):
            steps = np.array(self._steps[row])
            fields = {name: steps[:, k] for k, name in enumerate(TRACED)}
            t = np.arange(len(steps)) * TICK_S
            self._results.traces.append(Trace(case=int(self._scenarios.case[row]), t=t, **fields))
        return self._results
