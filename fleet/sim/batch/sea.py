"""A sea of scenarios, tick by tick: `BatchSea` for many on arrays, `LoneSea` for one on floats; the same laws."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from itertools import combinations
from typing import Any

import msgspec
import numpy as np
from msgspec import Struct, structs

from fleet import ops
from fleet.agent.step import Order, start
from fleet.hulls import HULLS, HullState, Water
from fleet.ops import FloatArray
from fleet.paths import Path
from fleet.paths.table import PathTable
from fleet.sim.batch import draws, tally
from fleet.sim.batch.block import Block, Rules, decide, sail
from fleet.sim.batch.hearing import TICK_S, Column
from fleet.sim.batch.mail import BatchMail, LoneMail, Mail, others
from fleet.sim.batch.scenarios import IntArray, Scenarios
from fleet.sim.batch.tally import Apart, Tally

SHOWN = tuple(name for name in Tally.__struct_fields__ if name != "marks")
TRACED = ("x", "y", "psi", "u", "s", "e", "y_e", "u_d", "r_d", "mode", "avoiding")


def taken(value: Any, lanes: IntArray) -> Any:
    """Some lanes of a value, Struct or tuple; the last axis of an array."""
    if isinstance(value, msgspec.Struct):
        return type(value)(*(taken(field, lanes) for field in structs.astuple(value)))
    if isinstance(value, tuple):
        return tuple(taken(v, lanes) for v in value)
    if hasattr(value, "take_lanes"):
        return value.take_lanes(lanes)
    return value[..., lanes] if getattr(value, "ndim", 0) else value


class Counted(Struct, frozen=True):
    """What has been counted; arrays are (B, K), those of pairs (B,)."""

    boats: dict[str, FloatArray]  # fields of Tally
    least_sq: FloatArray
    inside: FloatArray


def traced(block: Block[Any]) -> tuple[Any, ...]:
    """What a trace keeps of a block's lanes, in the order of `TRACED`."""
    d, hull = block.decision, block.hull
    assert d is not None
    return (hull.x, hull.y, hull.psi, hull.u, d.s, d.e, d.y_e, d.u_d, d.r_d, d.mode, d.avoiding)


class Sea(ABC):
    """What both kinds share."""

    blocks: list[Block[Any]]
    tallies: list[Tally[Any]]
    pairs: list[Apart[Any]]
    mail: Mail

    def __init__(self, scenarios: Scenarios, rules: Rules) -> None:
        self.scenarios, self.rules = scenarios, rules
        self._ticks = [np.ceil(change.at_s / TICK_S - 1e-6) for change in scenarios.changes]
        self._due = {int(t) for ticks in self._ticks for t in ticks if np.isfinite(t)}
        self.watch: Callable[[int], None] | None = None  # told of every tick when decided, before the hulls move

    def tick(self, now: int) -> None:
        """Orders, messages, decisions, hulls; then everything is counted."""
        if now in self._due:
            self._order(now)
        told = self.mail.deliver(now)
        clean = self.mail.clean
        self.mail.post(
            now,
            [decide(block, held, now, clean, self.rules) for block, held in zip(self.blocks, told, strict=True)],
        )
        errors = self._errors() if self.rules.formation else [None] * len(self.blocks)
        for k, (block, e) in enumerate(zip(self.blocks, errors, strict=True)):
            assert block.decision is not None
            self.tallies[k] = tally.count(self.tallies[k], block.decision, e, float(now))
        if self.watch is not None:
            self.watch(now)
        for block in self.blocks:
            sail(block, self.rules)
        radius_m = self.rules.radius_m
        self.pairs = [
            tally.part(a, dx, dy, radius_m) for a, (dx, dy) in zip(self.pairs, self._ranges(), strict=True)
        ]

    def check(self) -> None:
        """Every 5 s: who stands still."""
        self.tallies = [
            tally.check(t, block.decision, block.order)
            for t, block in zip(self.tallies, self.blocks, strict=True)
            if block.decision is not None
        ]

    def _apart(self) -> list[Apart[Any]]:
        """The pairs at the start."""
        return [Apart(dx, dy, dx * dx + dy * dy, ops.zero(dx)) for dx, dy in self._ranges()]

    @property
    @abstractmethod
    def rows(self) -> IntArray:
        """Numbers of the scenarios that are still sailed."""

    @abstractmethod
    def seen(self) -> FloatArray:
        """What a trace keeps of this tick: (field of `TRACED`, boat, scenario)."""

    @abstractmethod
    def counted(self) -> Counted:
        """What has been counted so far."""

    @abstractmethod
    def keep(self, columns: IntArray) -> None:
        """Go on with some of the scenarios only."""

    @abstractmethod
    def _order(self, now: int) -> None:
        """Put the changes of this tick into force."""

    @abstractmethod
    def _ranges(self) -> list[tuple[Any, Any]]:
        """(dx, dy) of the pairs, from the lower to the higher number [m]."""

    @abstractmethod
    def _errors(self) -> list[Any]:
        """True formation errors, one for each block [m]."""


class BatchSea(Sea):
    """All boats of all scenarios are lanes of one block: lane = boat * B + scenario."""

    def __init__(self, scenarios: Scenarios, rules: Rules) -> None:
        super().__init__(scenarios, rules)
        boats, count = scenarios.boats, scenarios.count
        self._rows: IntArray = np.arange(count)
        self._shape = (boats, count)
        self.mail = self._mail = BatchMail(scenarios)
        self._others = others(boats)
        first, second = np.array(list(combinations(range(boats), 2)), dtype=np.intp).reshape(-1, 2).T
        self._first, self._second = first, second
        sc, flat, tile = scenarios, self._flat, self._tile
        zero = np.zeros(boats * count)
        table = PathTable(sc.paths, flat(sc.path))
        order = Order(
            flat(sc.goal),
            flat(sc.offset),
            flat(sc.cruise),
            flat(sc.u_min),
            flat(sc.u_max),
            np.full_like(zero, sc.gain_per_m),
            flat(sc.s_end),
        )
        number = np.repeat(np.arange(boats), count)
        self._member = flat(sc.member)
        columns = tuple(self._column(c, table, order.offset) for c in range(boats - 1))
        block: Block[Any] = Block(
            hull=HullState(flat(sc.x), flat(sc.y), flat(sc.psi), flat(sc.u), zero, zero, zero, zero),
            state=start(zero, flat(sc.s), rules.method.start(zero, boats - 1)),
            order=order,
            water=Water(tile(sc.current_n), tile(sc.current_e), tile(sc.wind_n), tile(sc.wind_e)),
            path=table,
            columns=columns,
            weights=(zero,) * (boats - 1),
            revision=zero,
            error_n=zero,
            error_e=zero,
            hash=draws.begin(sc.seed, tile(sc.case), number, number),
        )
        self.blocks = [block]
        self.tallies = [
            tally.begin(zero, flat(sc.goal_m), tile(np.ceil(sc.measure_s / TICK_S - 1e-6)), block.state.s)
        ]
        self._changes = [
            (tile(ticks), flat(c.goal), flat(c.offset), flat(c.cruise))
            for ticks, c in zip(self._ticks, sc.changes, strict=True)
        ]
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
            fields, pairs.least_sq.min(axis=0) if some else none, pairs.inside.max(axis=0) if some else np.zeros_like(none)
        )

    def _flat(self, value: Any) -> Any:
        """(B, K) as lanes."""
        return np.ascontiguousarray(value.T).reshape(-1)

    def _tile(self, value: Any) -> Any:
        """(B,) as lanes."""
        return np.tile(value, self._shape[0])

    def _lanes_of(self, c: int) -> IntArray:
        """For each lane the lane of its other boat number c."""
        boats, count = self._shape
        lanes: IntArray = (self._others[c][:, None] * count + np.arange(count)).reshape(-1)
        return lanes

    def _column(self, c: int, table: PathTable, offset: FloatArray) -> Column[FloatArray]:
        lanes = self._lanes_of(c)
        return Column(
            number=np.repeat(self._others[c].astype(float), self._shape[1]),
            avoided=self._flat(self.scenarios.avoids),
            member=self._member * self._member[lanes],
            offset=offset[lanes],
            path=table.take_lanes(lanes),
            delay_s=self._tile(self.scenarios.delay_s),
        )

    def _order(self, now: int) -> None:
        block = self.blocks[0]
        for ticks, goal, offset, cruise in self._changes:
            due = ticks == now
            o = block.order
            block.order = structs.replace(
                o,
                goal=np.where(due, goal, o.goal),
                offset=np.where(due, offset, o.offset),
                cruise=np.where(due, cruise, o.cruise),
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
        return [np.concatenate(tally.formation_errors(list(z), list(self._member.reshape(self._shape))))]

    def keep(self, columns: IntArray) -> None:
        """Go on with some scenarios only."""
        boats, count = self._shape
        lanes = (np.arange(boats)[:, None] * count + columns).reshape(-1)
        self.blocks = [taken(self.blocks[0], lanes)]
        self.tallies = [taken(self.tallies[0], lanes)]
        self.pairs = [taken(self.pairs[0], columns)]
        self._member = self._member[lanes]
        self._changes = [taken(change, lanes) for change in self._changes]
        self._mail.keep(columns)
        self._rows, self._shape = self._rows[columns], (boats, len(columns))


class LoneSea(Sea):
    """The boats of one scenario, each a block of floats."""

    def __init__(self, scenarios: Scenarios, rules: Rules) -> None:
        super().__init__(scenarios, rules)
        sc = scenarios
        boats = sc.boats
        self.mail = LoneMail(sc)
        self._others: list[list[int]] = others(boats).T.tolist()
        hull = HULLS[rules.hull]

        def of(name: str) -> list[Any]:
            values: list[Any] = getattr(sc, name)[0].tolist()
            return values

        paths: list[Path] = [sc.paths[k] for k in of("path")]
        x, y, psi, u, s = of("x"), of("y"), of("psi"), of("u"), of("s")
        goal, offset, cruise = of("goal"), of("offset"), of("cruise")
        u_min, u_max, s_end = of("u_min"), of("u_max"), of("s_end")
        self._member: list[float] = of("member")
        avoids = of("avoids")
        water = Water(*(float(getattr(sc, name)[0]) for name in ("current_n", "current_e", "wind_n", "wind_e")))
        seed_case = draws.more(draws.more(0, sc.seed), int(sc.case[0]))
        delay_s = float(sc.delay_s[0])
        self.blocks = [
            Block(
                hull=hull.start(x[i], y[i], psi[i], u[i]),
                state=start(0.0, s[i], rules.method.start(0.0, boats - 1)),
                order=Order(goal[i], offset[i], cruise[i], u_min[i], u_max[i], sc.gain_per_m, s_end[i]),
                water=water,
                path=paths[i],
                columns=tuple(
                    Column(
                        float(j), avoids[i], self._member[i] * self._member[j], offset[j], paths[j], delay_s
                    )
                    for j in self._others[i]
                ),
                weights=(0.0,) * (boats - 1),
                revision=0.0,
                error_n=0.0,
                error_e=0.0,
                hash=draws.more(draws.more(seed_case, i), i),
            )
            for i in range(boats)
        ]
        measure = float(np.ceil(sc.measure_s[0] / TICK_S - 1e-6))
        self.tallies = [tally.begin(0.0, g, measure, s_i) for g, s_i in zip(of("goal_m"), s, strict=True)]
        self.pairs = self._apart()

    def _order(self, now: int) -> None:
        for ticks, change in zip(self._ticks, self.scenarios.changes, strict=True):
            if ticks[0] != now:
                continue
            goal, offset, cruise = change.goal[0].tolist(), change.offset[0].tolist(), change.cruise[0].tolist()
            for i, block in enumerate(self.blocks):
                block.order = structs.replace(block.order, goal=goal[i], offset=offset[i], cruise=cruise[i])
                block.revision += 1.0
                block.columns = tuple(
                    structs.replace(column, offset=offset[j])
                    for j, column in zip(self._others[i], block.columns, strict=True)
                )

    def _ranges(self) -> list[tuple[Any, Any]]:
        hulls = [block.hull for block in self.blocks]
        return [(b.x - a.x, b.y - a.y) for a, b in combinations(hulls, 2)]

    def _errors(self) -> list[Any]:
        z = [block.decision.s - block.order.offset for block in self.blocks if block.decision is not None]
        return tally.formation_errors(z, self._member)

    @property
    def rows(self) -> IntArray:
        """As `Sea.rows`."""
        return np.arange(1)

    def seen(self) -> FloatArray:
        """As `Sea.seen`."""
        return np.array([traced(block) for block in self.blocks]).T[:, :, None]

    def counted(self) -> Counted:
        """As `Sea.counted`."""
        fields = {name: np.array([[getattr(t, name) for t in self.tallies]]) for name in SHOWN}
        least_sq = min((a.least_sq for a in self.pairs), default=np.inf)
        return Counted(fields, np.array([least_sq]), np.array([max((a.inside for a in self.pairs), default=0.0)]))

    def keep(self, columns: IntArray) -> None:
        """As `Sea.keep`: there is only one."""
