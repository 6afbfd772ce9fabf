"""One scenario after the other with foreign vessels, on floats: boats decide by `fleet.agent.step`, as on board.

The law for foreign vessels goes first and keeping clear within the fleet starts from what it advises. Boats tell each
other what they do, and the leader what it orders, by the radio of `ships_radio`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import structs

from fleet.agent.abroad import ALONE, FOLLOWS, LEADS, Abroad, Fellow, Sea, course_of
from fleet.agent.lookout import AGES_S, IN_SLOT_M, PATIENCE_S
from fleet.agent.modes import Goal, Mode
from fleet.agent.step import Decision, Nav, Order, State, StepParams, start, step
from fleet.avoidance import METHODS
from fleet.avoidance.foreign import ForeignParams, order_of
from fleet.coordination import Member
from fleet.guidance import StationParams
from fleet.hulls import HULLS, STEP_S, HullState, Water
from fleet.ops import FloatArray
from fleet.paths import Lane
from fleet.sensing import Target
from fleet.sim.batch.hearing import Believed, Column, Message, age, half_lap_m, in_order, member, peer, weigh
from fleet.sim.batch.scenarios import ENDLESS
from fleet.sim.batch.ships import Decided, ShipCase, Voyage, ship_track
from fleet.sim.batch.ships_radio import DT_S, Said, Words
from fleet.sim.batch.ships_sensors import Tracks

GAIN_PER_M = 0.3
HULL_STEPS = round(DT_S / STEP_S)
DONE_M = 1.0  # off its path, and
DONE_S = 5.0  # for this long clear of everybody: the scenario is over
SOUND, EXACT_M = 1.0, 0.0
METHOD = METHODS["scoring"]


class _Boat:
    """One boat of the fleet while it sails."""

    def __init__(self, case: ShipCase, number: int, params: StepParams, alone: bool) -> None:
        x, y, slot = case.paths[number]
        self.case, self.number, self.params = case, number, params
        self.formed = len(case.paths) > 1 and not case.courses
        self.led = self.formed and not alone  # by one decision for all
        self.path = case.path_of(number)
        self.model = HULLS[case.hull]
        self.water = Water(*case.current, 0.0, 0.0)
        psi = case.courses[number] if case.courses else 0.0
        self.hull: HullState[float] = self.model.start(x, y, psi, case.cruise)
        self.columns = tuple(self._column(i) for i in range(len(case.paths)) if i != number)
        keep = METHOD.start(0.0, len(self.columns))
        self.state: State[float, Any] = start(0.0, case.begins_at(number), keep)
        self.weights = tuple(1.0 for _ in self.columns)
        limits = case.limits
        self.order = Order(
            float(Goal.FOLLOW if self.formed else Goal.ALONE), slot, case.cruise,
            limits.speed_min_mps, limits.speed_max_mps, GAIN_PER_M, ENDLESS,
        )  # fmt: skip
        self.decision: Decision[float] | None = None
        self.told_s = 0.0  # when a leader last told of foreign vessels
        self.part = ALONE

    def _column(self, other: int) -> Column[float]:
        case = self.case
        near = half_lap_m(case.path()) if self.formed and self._one_path(other) else 0.0
        formed, slot = 1.0 if self.formed else 0.0, case.paths[other][2]
        return Column(float(other), 1.0, formed, slot, case.path_of(other), case.radio.delay_s, near)

    def _one_path(self, other: int) -> bool:
        """Whether both sail on the same lane of the path."""
        return self.case.paths[other][1] == self.case.paths[self.number][1]

    def nav(self) -> Nav[float]:
        """What it knows of itself: everything, exactly."""
        h = self.hull
        vx, vy = self.model.velocity(h, self.water)
        return Nav(SOUND, h.x, h.y, h.psi, vx, vy, h.r, EXACT_M)

    def first_words(self) -> Words:
        """What the others know of it at the start: it sails along its path."""
        nav, s = self.nav(), self.state.s
        point = self.path.at(s)
        told = Message(
            0.0, nav.x, nav.y, nav.vx, nav.vy, point.tx, point.ty, self.case.cruise, point.tx, point.ty,
            self.path.straight(s) / self.case.cruise, s, nav.sigma, float(Mode.FOLLOW), 0.0, 0.0, r=nav.r,
        )  # fmt: skip
        return Words(0.0, self.number, told, nav.psi, nav.r, 0.0, not self.led, None)

    def say(self, k: int) -> Words:
        """What it tells the others at the end of a tick."""
        nav, d, watched = self.nav(), self.decision, self.state.foreign
        assert d is not None
        told = Message(
            float(k), nav.x, nav.y, nav.vx, nav.vy, d.gx, d.gy, d.u_plan, d.tx, d.ty, d.straight, d.s, nav.sigma,
            d.mode, 0.0, d.y_e, r=nav.r,
        )  # fmt: skip
        order = order_of(watched.memory, float(self.number)) if watched is not None else None
        alone = watched is not None and (self.part == ALONE or watched.memory.alone > 0.5)
        return Words(DT_S * k, self.number, told, nav.psi, nav.r, d.e, alone, order)

    def decide(self, heard: dict[int, Words], targets: Sequence[Target], k: int) -> None:
        """One tick of `step`."""
        nav, case = self.nav(), self.case
        there = [(heard[int(c.number)], c) for c in self.columns]
        aged = {w.boat: age(w.told, c, float(k), clean=case.radio.perfect) for w, c in there}
        peers = [peer(w.told, c, aged[w.boat], nav.x, nav.y, case.radius_m, 0.0) for w, c in there]
        members: list[Member[float]] = []
        present: dict[int, Words] = {}
        if self.formed:
            self.weights = tuple(
                weigh(w.told, c, aged[w.boat], weight, 0.0) for (w, c), weight in zip(there, self.weights, strict=True)
            )
            members = [
                member(w.told, c, aged[w.boat], weight) for (w, c), weight in zip(there, self.weights, strict=True)
            ]
            peers = [
                structs.replace(p, ordered=in_order(m, c, self.state.s, self.order.offset, case.radius_m))
                for p, m, (_, c) in zip(peers, members, there, strict=True)
            ]
            present = {w.boat: w for (w, _), weight in zip(there, self.weights, strict=True) if weight > 0.0}
        stretch = self.path.stretch(self.state.s) if isinstance(self.path, Lane) else 1.0
        order = structs.replace(self.order, stretch=stretch, cruise=self.order.cruise * stretch)
        self.state, self.decision = step(
            self.state, nav, members, peers, order, self.path, METHOD, self.params, DT_S,
            self._abroad(present, aged, targets, DT_S * k),
        )  # fmt: skip

    def _abroad(
        self, present: dict[int, Words], aged: dict[int, Believed[float]], targets: Sequence[Target], now: float
    ) -> Abroad | None:
        """What `step` is told of foreign vessels, as `fleet.agent.lookout` does."""
        if not targets and self.state.foreign is None:
            self.told_s = now
            return None
        fellows: tuple[Fellow, ...] = ()
        self.part, order = ALONE, None
        if self.led and present:
            leader = max((self.number, *present), key=lambda i: (self.case.paths[i][2], -i))
            if leader == self.number:
                self.part, fellows = LEADS, tuple(self._fellows(present, aged))
            else:
                order = present[leader].order
                self.told_s = now if order is not None else self.told_s
                self.part = FOLLOWS if now - self.told_s < PATIENCE_S else ALONE
        party = tuple(float(w.boat) for w in present.values() if not w.alone) if self.led else ()
        return Abroad(now, tuple(targets), self.part, fellows, order, self.case.edges, party)

    def _fellows(self, present: dict[int, Words], aged: dict[int, Believed[float]]) -> list[Fellow]:
        """The boats that this one decides for."""
        fellows = []
        for w in present.values():
            if w.alone or abs(w.e) > IN_SLOT_M:
                continue
            told, old = w.told, min(aged[w.boat].age, AGES_S)
            chi, U = course_of(told.vx, told.vy, w.psi)
            s = told.s + aged[w.boat].age * (told.vx * told.tx + told.vy * told.ty)
            aside = self.case.paths[w.boat][1] - self.case.paths[0][1]
            fellows.append(Fellow(float(w.boat), aside, told.x + told.vx * old, told.y + told.vy * old, chi, U, w.r, s))
        return fellows

    def move(self) -> None:
        """To the next tick."""
        d = self.decision
        assert d is not None
        self.hull = self.model.advance_by(
            HULL_STEPS, self.hull, d.u_d, d.r_d, self.water, self.case.limits, STEP_S, d.powered
        )

    def at_rest(self) -> bool:
        """It follows a path that is clear, and is on it."""
        watched, d = self.state.foreign, self.decision
        clear = watched is None or (watched.memory.sailed.acting < 0.5 and not watched.memory.encounters)
        return clear and d is not None and d.avoiding < 0.5 and abs(d.y_e) < DONE_M


def _fleet(case: ShipCase, params: ForeignParams | None, alone: bool) -> list[_Boat]:
    """All boats of a scenario, at its start."""
    params = ForeignParams() if params is None else params
    keep = METHOD.params(case.radius_m, "starboard")
    paths = [case.path() if not case.courses else case.path_of(i) for i in range(len(case.paths))]
    sea = Sea(params, tuple((path, case.limits) for path in paths if not isinstance(path, Lane)))
    stays = StepParams(
        follow=params.follow,
        station=StationParams(),
        limits=case.limits,
        keep=keep,
        closer=METHOD.closer(keep),
        sea=sea,
    )
    return [_Boat(case, i, stays, alone) for i in range(len(case.paths))]


def sail(case: ShipCase, params: ForeignParams | None = None, alone: bool = False) -> Voyage:
    """Sail one scenario until everybody is past and the boats are back on their paths, or its time is up.

    Args:
        params: of the law; its defaults if None
        alone: the boats of a formation decide each for itself, with the mates as discs
    """
    ticks = round(case.limit_s / DT_S)
    truth = [ship_track(ship, ticks) for ship in case.ships]
    watch, fleet = Tracks(case, truth), _fleet(case, params, alone)
    said = Said(case.radio, [boat.first_words() for boat in fleet], case.seed, case.case)
    rows: list[list[HullState[float]]] = []
    decisions: list[Decided] = []
    done = 0.0
    for k in range(ticks):
        now = k * DT_S
        rows.append([boat.hull for boat in fleet])
        watch.take(k, fleet[0].hull.x, fleet[0].hull.y)
        targets = watch.targets(now)
        for boat in fleet:
            boat.decide(said.heard(k, boat.number), targets, k)
            told = boat.state.foreign
            if told is not None and told.advice.decided > 0.5:
                decisions.append(_decided(now, boat, truth, k))
        for boat in fleet if len(fleet) > 1 else ():
            said.say(k, boat.say(k))
        for boat in fleet:
            boat.move()
        done = done + DT_S if now > case.meet_s and all(boat.at_rest() for boat in fleet) else 0.0
        if done >= DONE_S:
            break
    kept = len(rows)
    x, y, psi, u = (np.array([[getattr(h, name) for h in row] for row in rows]) for name in ("x", "y", "psi", "u"))
    columns = [np.stack([track[n][:kept] for track in truth], axis=1) for n in range(3)]
    return Voyage(
        t=np.arange(kept, dtype=float) * DT_S,
        x=x,
        y=y,
        psi=psi,
        u=u,
        ship_x=columns[0],
        ship_y=columns[1],
        ship_chi=columns[2],
        decisions=tuple(decisions),
        complete=done >= DONE_S,
    )


def _decided(now: float, boat: _Boat, truth: Sequence[tuple[FloatArray, FloatArray, FloatArray]], k: int) -> Decided:
    """A decision, with the true range to the vessel that it is for."""
    watched = boat.state.foreign
    assert watched is not None
    memory, range_m = watched.memory, math.nan
    action = memory.ordered
    if memory.target >= 0.0:
        x, y, _ = truth[int(memory.target)]
        range_m = math.hypot(x[k] - boat.hull.x, y[k] - boat.hull.y)
    return Decided(now, boat.number, action.acting, action.a, action.factor, memory.target, range_m, memory.reason)
