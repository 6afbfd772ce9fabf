"""Scenarios on their way: chunks of them sail side by side, and their results come in as they end."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from fleet.ops import FloatArray
from fleet.sim.batch.block import Rules
from fleet.sim.batch.hearing import TICK_S
from fleet.sim.batch.lanes import BatchSea, table_of
from fleet.sim.batch.lone import LoneSea
from fleet.sim.batch.mail import delay_ticks
from fleet.sim.batch.results import PER_BOAT, PER_SCENARIO, Results, Trace
from fleet.sim.batch.scenarios import IntArray, Scenarios
from fleet.sim.batch.sea import TRACED, Counted, Sea
from fleet.sim.batch.tally import CHECK_TICKS, SETTLED_M

ROOM_FROM = 8  # scenarios that have ended are left out when they are more than one in so many
ROUND_TICKS = 6 * CHECK_TICKS  # after which chunks that have shrunk are put together


class Voyage:
    """A set of scenarios, sailed together."""

    def __init__(self, scenarios: Scenarios, rules: Rules, record: Collection[int]) -> None:
        shape = (scenarios.count, scenarios.boats)
        self._scenarios, self._rules = scenarios, rules
        self._limit = np.ceil(scenarios.limit_s / (TICK_S * CHECK_TICKS) - 1e-6) * CHECK_TICKS
        self._over = np.zeros(shape[0], dtype=bool)
        self._has_place = scenarios.leader >= 0.0 if scenarios.winged else scenarios.member > 0.0
        self._steps: dict[int, list[FloatArray]] = {
            row: [] for row in range(shape[0]) if int(scenarios.case[row]) in record
        }
        arrays: dict[str, Any] = {name: np.zeros(shape) for name in PER_BOAT}
        arrays |= {name: np.zeros(shape[0]) for name in PER_SCENARIO}
        self._results = Results(
            family=scenarios.family,
            method=rules.method.name,
            seed=scenarios.seed,
            hull_m=scenarios.limits.length_m,
            radius_m=rules.radius_m,
            case=scenarios.case,
            traces=[],
            **arrays,
        )
        self._results.nominal_s = scenarios.nominal_s

    def sail(self, size: int | None) -> Results:
        """Until all have ended, in chunks of `size` scenarios; None: one alone, on floats."""
        now = 0
        seas = self._seas(size)
        while seas:
            for sea in seas:
                self._sail_round(sea, now)
            now += ROUND_TICKS
            seas = [sea for sea in seas if len(sea.rows)]
            if size is not None:
                seas = _together(seas, size)
        return self._finished()

    def _seas(self, size: int | None) -> list[Sea]:
        scenarios, rules = self._scenarios, self._rules
        if size is None:
            return [LoneSea(scenarios, rules)]
        table = table_of(scenarios)
        slots = int(delay_ticks(scenarios.delay_s).max()) + 1
        rows = np.arange(scenarios.count)
        chunks = (rows[first : first + size] for first in range(0, scenarios.count, size))
        return [BatchSea(scenarios, rules, chunk, table, slots) for chunk in chunks]

    def _sail_round(self, sea: Sea, begin: int) -> None:
        """Some time of one chunk."""
        sea.watch = (lambda _now: self._trace(sea)) if self._steps else None
        for check in range(begin, begin + ROUND_TICKS, CHECK_TICKS):
            if not len(sea.rows):
                return
            for now in range(check, check + CHECK_TICKS):
                sea.tick(now)
            self._results.boat_ticks += CHECK_TICKS * len(sea.rows) * self._scenarios.boats
            sea.check()
            self._check(sea, check + CHECK_TICKS)

    def _check(self, sea: Sea, ticks: int) -> None:
        """Who has ended? Their results are taken now, and they make room when they are many."""
        counted = sea.counted()
        was = self._over[sea.rows]
        over = was | (counted.boats["arrived"] < np.inf).all(axis=1) | (ticks >= self._limit[sea.rows])
        fresh = np.flatnonzero(over & ~was)
        if len(fresh):
            self._take(sea.rows[fresh], fresh, ticks, counted)
        self._over[sea.rows] = over
        if over.sum() * ROOM_FROM > len(over) or over.all():
            sea.keep(np.flatnonzero(~over))

    def _trace(self, sea: Sea) -> None:
        """A tick of the scenarios that are recorded."""
        seen: FloatArray | None = None
        for column, row in enumerate(sea.rows.tolist()):
            if row in self._steps and not self._over[row]:
                seen = sea.seen() if seen is None else seen
                self._steps[row].append(seen[:, :, column])

    def _take(self, rows: IntArray, columns: IntArray, ticks: int, counted: Counted) -> None:
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
        of_place = self._has_place[rows]
        r.off_path[rows] = np.where(of_place, t["off_path"] / measured, -1.0)
        r.off_place[rows] = np.where(of_place, t["off_place"] / measured, -1.0)
        r.stood[rows] = t["stood"]
        r.stopped[rows] = t["stopped"]

    def _finished(self) -> Results:
        """With the traces."""
        for row, kept in sorted(self._steps.items()):
            steps = np.array(kept)
            fields: dict[str, Any] = {name: steps[:, k] for k, name in enumerate(TRACED)}
            t: FloatArray = np.arange(len(steps), dtype=float) * TICK_S
            self._results.traces.append(Trace(case=int(self._scenarios.case[row]), t=t, **fields))
        return self._results


def _together(seas: list[Sea], size: int) -> list[Sea]:
    """Chunks that fit into one become one."""
    result: list[Sea] = []
    for sea in seas:
        last = result[-1] if result else None
        if isinstance(last, BatchSea) and isinstance(sea, BatchSea) and len(last.rows) + len(sea.rows) <= size:
            last.take_in(sea)
        else:
            result.append(sea)
    return result
