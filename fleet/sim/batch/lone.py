"""One scenario on floats: a block for each boat."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
from msgspec import structs

from fleet.agent.step import Order, start
from fleet.agent.wing import ALL_TURN
from fleet.hulls import HULLS, Water
from fleet.mission.beside import ABEAM
from fleet.ops import FloatArray
from fleet.paths import Path
from fleet.sim.batch import draws, tally
from fleet.sim.batch.block import Block, Rules
from fleet.sim.batch.hearing import TICK_S, Column, half_lap_m
from fleet.sim.batch.mail import LoneMail, others
from fleet.sim.batch.scenarios import IntArray, Scenarios
from fleet.sim.batch.sea import SHOWN, WATER, Counted, Sea, traced
from fleet.sim.batch.winging import Winged


class LoneSea(Sea):
    """The boats of one scenario, each a block of floats."""

    def __init__(self, scenarios: Scenarios, rules: Rules) -> None:
        super().__init__(scenarios, rules)
        sc = scenarios
        boats = sc.boats
        self.mail = LoneMail(sc)
        self._leaders: list[int] = []
        self._others: list[list[int]] = others(boats).T.tolist()

        def of(name: str) -> list[Any]:
            values: list[Any] = getattr(sc, name)[0].tolist()
            return values

        paths: list[Path] = [sc.paths[k] for k in of("path")]
        x, y, psi, u, s = of("x"), of("y"), of("psi"), of("u"), of("s")
        goal, offset, cruise = of("goal"), of("offset"), of("cruise")
        u_min, u_max, s_end = of("u_min"), of("u_max"), of("s_end")
        self._member: list[float] = of("member")
        avoids, model = of("avoids"), of("hull")
        water = Water(*(float(getattr(sc, name)[0]) for name in WATER))
        seed_case = draws.more(draws.more(0, sc.seed), int(sc.case[0]))
        delay_s = float(sc.delay_s[0])
        self.blocks = [
            Block(
                hull=HULLS[sc.hulls[int(model[i])]].start(x[i], y[i], psi[i], u[i]),
                state=start(0.0, s[i], rules.method.start(0.0, boats - 1)),
                order=Order(goal[i], offset[i], cruise[i], u_min[i], u_max[i], sc.gain_per_m, s_end[i]),
                water=water,
                path=paths[i],
                columns=tuple(
                    Column(
                        float(j),
                        avoids[i],
                        self._together(i, j),
                        offset[j],
                        paths[j],
                        delay_s,
                        half_lap_m(paths[i]) if sc.path[0, i] == sc.path[0, j] else 0.0,
                    )
                    for j in self._others[i]
                ),
                weights=(0.0,) * (boats - 1),
                revision=0.0,
                error_n=0.0,
                error_e=0.0,
                hash=draws.more(draws.more(seed_case, i), i),
                model=model[i],
            )
            for i in range(boats)
        ]
        if sc.winged:
            self._fly(of("leader"), of("room"), paths, rules)
        measure = float(np.ceil(sc.measure_s[0] / TICK_S - 1e-6))
        begins = zip(of("goal_m"), s, x, y, strict=True)
        self.tallies = [tally.begin(0.0, goal_m, measure, s_i, x_i, y_i) for goal_m, s_i, x_i, y_i in begins]
        self.pairs = self._apart()
        self._rows: IntArray = np.arange(1)

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

    def _fly(self, leaders: list[float], rooms: list[float], paths: list[Path], rules: Rules) -> None:
        """What wingmen and leaders know of each other."""
        sc = self.scenarios
        room_of = {i: sc.rooms[int(k)] for i, k in enumerate(rooms) if leaders[i] >= 0.0}
        pairs = {frozenset((i, int(leaders[i]))) for i, room in room_of.items() if room.rates}
        keep_on = {i for i, room in room_of.items() if not room.rates and rules.method.name != ALL_TURN}
        for i, block in enumerate(self.blocks):
            other = self._others[i]
            leader = int(leaders[i])
            block.wing = Winged(
                column=other.index(leader) if leader >= 0 else -1,
                path=paths[leader],
                room=room_of.get(i, ABEAM),
                lag_s=sc.limits.surge_lag_s,
                apart=frozenset(c for c, j in enumerate(other) if frozenset((i, j)) in pairs),
                mine=frozenset(c for c, j in enumerate(other) if j in keep_on and leaders[j] == i),
            )
        self._leaders = [int(leader) for leader in leaders]

    def _abeam(self, i: int) -> float:
        """How far a wingman really is behind abeam of its leader [m]; 0 for the leader."""
        leader = self._leaders[i]
        if leader < 0:
            return 0.0
        one, d, hull = self.blocks[leader].hull, self.blocks[leader].decision, self.blocks[i].hull
        assert d is not None
        return float(d.tx * (one.x - hull.x) + d.ty * (one.y - hull.y))

    def _errors(self) -> list[Any]:
        if self._leaders:
            return [self._abeam(i) for i in range(len(self.blocks))]
        z = [block.decision.s - block.order.offset for block in self.blocks if block.decision is not None]
        return tally.formation_errors(z, self._member, self.rules.formations)

    def _together(self, i: int, j: int) -> float:
        """1 where both are of one formation."""
        return 1.0 if self._member[i] > 0.0 and self._member[i] == self._member[j] else 0.0

    @property
    def rows(self) -> IntArray:
        """As `Sea.rows`."""
        return self._rows

    def seen(self) -> FloatArray:
        """As `Sea.seen`."""
        return np.array([traced(block) for block in self.blocks]).T[:, :, None]

    def counted(self) -> Counted:
        """As `Sea.counted`."""
        fields = {name: np.array([[getattr(t, name) for t in self.tallies]]) for name in SHOWN}
        least_sq = min((a.least_sq for a in self.pairs), default=np.inf)
        return Counted(fields, np.array([least_sq]), np.array([max((a.inside for a in self.pairs), default=0.0)]))

    def keep(self, columns: IntArray) -> None:
        """As `Sea.keep`: the one, or none."""
        self._rows = self._rows[columns]
