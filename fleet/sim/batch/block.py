"""A block of lanes that decide together: all boats of all scenarios (arrays), or one boat (floats). One tick of it."""

from __future__ import annotations

from typing import Any, Generic

from msgspec import Struct

from fleet import ops
from fleet.agent.step import Decision, Nav, Order, PathLike, State, StepParams, step
from fleet.avoidance import Method
from fleet.hulls import HULLS, STEP_S, HullState, Water
from fleet.ops import R
from fleet.sim.batch import draws
from fleet.sim.batch.draws import Purpose
from fleet.sim.batch.hearing import TICK_S, Column, Message, age, member, peer, weigh

STEPS = round(TICK_S / STEP_S)
CORRELATION_S = 60.0  # of the slow part of the GNSS error


class Rules(Struct, frozen=True, kw_only=True):
    """What is the same for all lanes of a run."""

    method: Method
    params: StepParams
    hull: str
    radius_m: float
    formation: bool  # somebody belongs to a formation
    clock_error_s: float
    gnss_sigma_m: float
    gnss_white_m: float

    @property
    def noisy(self) -> bool:
        """Positions are not exact."""
        return self.gnss_sigma_m > 0.0 or self.gnss_white_m > 0.0


class Block(Struct, Generic[R]):
    """The lanes' memory and circumstances."""

    hull: HullState[R]
    state: State[R, Any]
    order: Order[R]
    water: Water[R]
    path: PathLike[R]
    columns: tuple[Column[R], ...]
    weights: tuple[R, ...]  # of the others in the formation
    revision: R
    error_n: R  # slow part of the GNSS error [m]
    error_e: R
    hash: Any  # where the lane's random numbers begin
    decision: Decision[R] | None = None  # of the last tick


def sense(block: Block[R], now: int, rules: Rules) -> Nav[R]:
    """What the sensors say."""
    hull = block.hull
    vx, vy = HULLS[rules.hull].velocity(hull, block.water)
    one = ops.full(hull.x, 1.0)
    if not rules.noisy:
        return Nav(one, hull.x, hull.y, hull.psi, vx, vy, hull.r, ops.zero(one))
    h = draws.more(block.hash, now)
    keep = 1.0 - TICK_S / CORRELATION_S
    kick = rules.gnss_sigma_m * ops.sqrt(1.0 - keep * keep)
    if now == 0:  # begins as it goes on
        keep, kick = 0.0, rules.gnss_sigma_m
    block.error_n = keep * block.error_n + kick * draws.normal(h, Purpose.DRIFT_N)
    block.error_e = keep * block.error_e + kick * draws.normal(h, Purpose.DRIFT_E)
    x = hull.x + block.error_n + rules.gnss_white_m * draws.normal(h, Purpose.WHITE_N)
    y = hull.y + block.error_e + rules.gnss_white_m * draws.normal(h, Purpose.WHITE_E)
    return Nav(one, x, y, hull.psi, vx, vy, hull.r, ops.full(one, ops.hypot(rules.gnss_sigma_m, rules.gnss_white_m)))


def decide(block: Block[R], told: tuple[Message[R], ...], now: int, clean: bool, rules: Rules) -> Message[R]:
    """One tick of `step`; keeps the decision in the block's state and returns what is published."""
    nav = sense(block, now, rules)
    aged = [age(m, column, float(now), clean) for m, column in zip(told, block.columns, strict=True)]
    all_three = list(zip(told, block.columns, aged, strict=True))
    peers = [peer(m, column, a, nav.x, nav.y, rules.radius_m, rules.clock_error_s) for m, column, a in all_three]
    members = []
    if rules.formation:
        block.weights = tuple(
            weigh(m, column, a, w, block.revision) for (m, column, a), w in zip(all_three, block.weights, strict=True)
        )
        members = [member(m, column, a, w) for (m, column, a), w in zip(all_three, block.weights, strict=True)]
    block.state, d = step(block.state, nav, members, peers, block.order, block.path, rules.method, rules.params, TICK_S)
    block.decision = d
    return Message(
        ops.full(nav.x, float(now)),
        nav.x,
        nav.y,
        nav.vx,
        nav.vy,
        d.gx,
        d.gy,
        d.u_plan,
        d.tx,
        d.ty,
        d.straight,
        d.s,
        nav.sigma,
        d.mode,
        block.revision,
    )


def sail(block: Block[R], rules: Rules) -> None:
    """The hulls until the next tick."""
    d = block.decision
    assert d is not None
    powered: Any = 1.0 if ops.every(d.powered == 1.0) else d.powered
    advance = HULLS[rules.hull].advance
    for _ in range(STEPS):
        block.hull = advance(block.hull, d.u_d, d.r_d, block.water, rules.params.limits, STEP_S, powered)
