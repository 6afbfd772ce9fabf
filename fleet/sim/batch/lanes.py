"""Many scenarios on arrays: all boats of all of them are lanes of one block."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import msgspec
import numpy as np
from msgspec import structs

from fleet.agent.step import Order, start
from fleet.hulls import HullState, Water
from fleet.ops import FloatArray
from fleet.paths.table import PathTable
from fleet.sim.batch import draws, tally
from fleet.sim.batch.block import Block, Rules
from fleet.sim.batch.hearing import TICK_S, Column, half_lap_m
from fleet.sim.batch.mail import BatchMail, others
from fleet.sim.batch.scenarios import IntArray, Scenarios
from fleet.sim.batch.sea import SHOWN, WATER, Counted, Sea, traced


def taken(value: Any, lanes: IntArray) -> Any:
    """Some lanes of a value, Struct or tuple; the last axis of an array. Paths are laid anew."""
    if isinstance(value, msgspec.Struct):
        return type(value)(*(taken(field, lanes) for field in structs.astuple(value)))
    if isinstance(value, tuple):
        return tuple(taken(v, lanes) for v in value)
    return value[..., lanes] if getattr(value, "ndim", 0) else value


def joined(a: Any, b: Any, boats: int) -> Any:
    """The lanes of both; lane = boat * B + scenario."""
    if isinstance(a, msgspec.Struct):
        return type(a)(*(joined(p, q, boats) for p, q in zip(structs.astuple(a), structs.astuple(b), strict=True)))
    if isinstance(a, tuple):
        return tuple(joined(p, q, boats) for p, q in zip(a, b, strict=True))
    if getattr(a, "ndim", 0):
        return np.concatenate((a.reshape(boats, -1), b.reshape(boats, -1)), axis=1).reshape(-1)
    return a


def table_of(scenarios: Scenarios) -> PathTable:
    """The paths of all lanes."""
    return PathTable(scenarios.paths, scenarios.path.T.reshape(-1))


class BatchSea(Sea):
    """All boats of all scenarios are lanes of one block: lane = boat * B + scenario."""

    def __init__(self, scenarios: Scenarios, rules: Rules, rows: IntArray, table: PathTable, slots: int) -> None:
        """Some rows of the scenarios; `table` and `slots` (of the ring of messages) are the same for all chunks."""
        super().__init__(scenarios, rules)
        boats, count = scenarios.boats, len(rows)
        self._rows = rows
        self._shape = (boats, count)
        self._table = table
        self._nowhere: Any = None
        self.mail = self._mail = BatchMail(scenarios, rows, slots)
        self._others = others(boats)
        pairs = np.array(list(combinations(range(boats), 2)), dtype=np.intp).reshape(-1, 2)
        self._first, self._second = pairs.T
        sc, flat, tile = scenarios, self._flat, self._tile
        zero = np.zeros(boats * count)
        number = np.repeat(np.arange(boats), count)
        self._member = flat(sc.member)
        self._half_lap_m = np.array([half_lap_m(p) for p in sc.paths])
        block: Block[Any] = Block(
            hull=HullState(flat(sc.x), flat(sc.y), flat(sc.psi), flat(sc.u), zero, zero, zero, zero),
            state=start(zero, flat(sc.s), rules.method.start(zero, boats - 1)),
            order=Order(
                flat(sc.goal),
                flat(sc.offset),
                flat(sc.cruise),
                flat(sc.u_min),
                flat(sc.u_max),
                np.full_like(zero, sc.gain_per_m),
                flat(sc.s_end),
            ),
            water=Water(*(tile(v) if np.any(v) else 0.0 for v in (getattr(sc, name) for name in WATER))),
            path=table,
            columns=(),
            weights=(zero,) * (boats - 1),
            revision=zero,
            error_n=zero,
            error_e=zero,
            hash=draws.begin(sc.seed, tile(sc.case), number, number),
            model=flat(sc.hull),
        )
        block.columns = tuple(self._column(c, flat(sc.offset)) for c in range(boats - 1))
        self.blocks = [block]
        self._lay_paths()
        measure = tile(np.ceil(sc.measure_s / TICK_S - 1e-6))
        hull = block.hull
        self.tallies = [tally.begin(zero, flat(sc.goal_m), measure, block.state.s, hull.x, hull.y)]
        self.pairs = self._apart()

    @property
    def rows(self) -> IntArray:
        """As `Sea.rows`."""
        return self._rows

    def seen(self) -> FloatArray:
        """As `Sea.seen`."""
        return np.stack([value.reshape(self._shape) for value in traced(self.blocks[0])])

    def counted(self) -> Counted:
        """As `Sea.counted`."""
        t, pairs = self.tallies[0], self.pairs[0]
        fields = {name: getattr(t, name).reshape(self._shape).T for name in SHOWN}
        none = np.full(self._shape[1], np.inf)
        some = len(pairs.dx) > 0
        return Counted(
            fields,
            pairs.least_sq.min(axis=0) if some else none,
            pairs.inside.max(axis=0) if some else np.zeros_like(none),
        )

    def _flat(self, value: Any) -> Any:
        """(B, K) of all scenarios as lanes."""
        return np.ascontiguousarray(value[self._rows].T).reshape(-1)

    def _tile(self, value: Any) -> Any:
        """(B,) of all scenarios as lanes."""
        return np.tile(value[self._rows], self._shape[0])

    def _lanes_of(self, c: int) -> IntArray:
        """For each lane the lane of its other boat number c."""
        count = self._shape[1]
        lanes: IntArray = (self._others[c][:, None] * count + np.arange(count)).reshape(-1)
        return lanes

    def _column(self, c: int, offset: FloatArray) -> Column[FloatArray]:
        lanes = self._lanes_of(c)
        path = self._flat(self.scenarios.path)
        return Column(
            number=np.repeat(self._others[c].astype(float), self._shape[1]),
            avoided=self._flat(self.scenarios.avoids),
            member=np.where((self._member > 0.0) & (self._member == self._member[lanes]), 1.0, 0.0),
            offset=offset[lanes],
            path=self._nowhere,
            delay_s=self._tile(self.scenarios.delay_s),
            near_m=np.where(path == path[lanes], self._half_lap_m[path], 0.0),
        )

    def _lay_paths(self) -> None:
        """Every lane its path, and those of the others where somebody may fall silent."""
        block, boats = self.blocks[0], self._shape[0]
        own = self._table.take_lanes((np.arange(boats)[:, None] * self.scenarios.count + self._rows).reshape(-1))
        block.path = own
        if not self._mail.clean:
            block.columns = tuple(
                structs.replace(column, path=own.take_lanes(self._lanes_of(c)))
                for c, column in enumerate(block.columns)
            )

    def _order(self, now: int) -> None:
        block = self.blocks[0]
        for ticks, change in zip(self._ticks, self.scenarios.changes, strict=True):
            due = self._tile(ticks) == now
            o = block.order
            block.order = structs.replace(
                o,
                goal=np.where(due, self._flat(change.goal), o.goal),
                offset=np.where(due, self._flat(change.offset), o.offset),
                cruise=np.where(due, self._flat(change.cruise), o.cruise),
            )
            block.revision = np.where(due, block.revision + 1.0, block.revision)
        offset = block.order.offset
        block.columns = tuple(
            structs.replace(column, offset=offset[self._lanes_of(c)]) for c, column in enumerate(block.columns)
        )

    def _ranges(self) -> list[tuple[Any, Any]]:
        hull = self.blocks[0].hull
        x, y = hull.x.reshape(self._shape), hull.y.reshape(self._shape)
        return [(x[self._second] - x[self._first], y[self._second] - y[self._first])]

    def _errors(self) -> list[Any]:
        block = self.blocks[0]
        assert block.decision is not None
        z = (block.decision.s - block.order.offset).reshape(self._shape)
        members = list(self._member.reshape(self._shape))
        return [np.concatenate(tally.formation_errors(list(z), members, self.rules.formations))]

    def keep(self, columns: IntArray) -> None:
        """As `Sea.keep`."""
        boats, count = self._shape
        lanes = (np.arange(boats)[:, None] * count + columns).reshape(-1)
        self.blocks = [taken(self.blocks[0], lanes)]
        self.tallies = [taken(self.tallies[0], lanes)]
        self.pairs = [taken(self.pairs[0], columns)]
        self._member = self._member[lanes]
        self._mail.keep(columns)
        self._rows, self._shape = self._rows[columns], (boats, len(columns))
        self._lay_paths()

    def take_in(self, other: BatchSea) -> None:
        """The scenarios of another chunk of the same set, at the same tick, sail on in this one."""
        boats = self._shape[0]
        self.blocks = [joined(self.blocks[0], other.blocks[0], boats)]
        self.tallies = [joined(self.tallies[0], other.tallies[0], boats)]
        self.pairs = [joined(self.pairs[0], other.pairs[0], max(len(self._first), 1))]
        self.pairs = [type(p)(*(v.reshape(len(self._first), -1) for v in structs.astuple(p))) for p in self.pairs]
        self._member = joined(self._member, other._member, boats)
        self._mail.take_in(other._mail)
        self._rows = np.concatenate((self._rows, other._rows))
        self._shape = (boats, len(self._rows))
        self._lay_paths()
