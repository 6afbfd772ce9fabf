"""A block of lanes that decide together: all boats of all scenarios (arrays), or one boat (floats). One tick of it."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Generic

from msgspec import Struct, structs

from fleet import ops
from fleet.agent.step import Decision, Nav, Order, PathLike, State, StepParams, step
from fleet.avoidance import Method
from fleet.hulls import HULLS, STEP_S, HullState, Water
from fleet.ops import R
from fleet.sensing import drift
from fleet.sensing.drift import Cov, Drifting, Gains
from fleet.sim.batch import draws
from fleet.sim.batch.draws import Purpose
from fleet.sim.batch.hearing import TICK_S, Column, Message, age, in_order, member, peer, weigh
from fleet.sim.batch.winging import Winged, beside, minded

STEPS = round(TICK_S / STEP_S)
CORRELATION_S = 60.0  # of the slow part of the GNSS error


class Rules(Struct, frozen=True, kw_only=True):
    """What is the same for all lanes of a run."""

    method: Method
    params: StepParams
    hulls: tuple[str, ...]
    radius_m: float
    formations: int  # of a scenario, at most
    clock_error_s: float
    gnss_sigma_m: float
    gnss_white_m: float
    gnss_velocity_mps: float

    @property
    def noisy(self) -> bool:
        """Positions or velocities are not exact."""
        return self.gnss_sigma_m > 0.0 or self.gnss_white_m > 0.0 or self.gnss_velocity_mps > 0.0


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
    model: R  # number of its hull
    decision: Decision[R] | None = None  # of the last tick
    wing: Winged | None = None  # of a wingman or its leader
    known: Drifting[R] | None = None  # what its sensors have said


def sense(block: Block[R], now: int, rules: Rules) -> Nav[R]:
    """What the sensors say; where the velocity is noisy the boat fuses them, as on board (`fleet.sensing.drift`)."""
    hull = block.hull
    vx, vy = HULLS[rules.hulls[0]].velocity(hull, block.water)
    for k, name in enumerate(rules.hulls[1:], start=1):
        other_vx, other_vy = HULLS[name].velocity(hull, block.water)
        vx, vy = ops.where(block.model == k, other_vx, vx), ops.where(block.model == k, other_vy, vy)
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
    if rules.gnss_velocity_mps > 0.0:
        vx = vx + rules.gnss_velocity_mps * draws.normal(h, Purpose.VELOCITY_N)
        vy = vy + rules.gnss_velocity_mps * draws.normal(h, Purpose.VELOCITY_E)
    told = ops.hypot(rules.gnss_sigma_m, rules.gnss_white_m)
    if rules.gnss_velocity_mps <= 0.0:
        return Nav(one, x, y, hull.psi, vx, vy, hull.r, ops.full(one, told))
    known = block.known
    if known is None:
        zero = ops.zero(one)
        known = Drifting(x, y, vx, vy, zero, zero)
    sigma = told
    if now > 0:
        gains = _gains(told, rules.gnss_velocity_mps, now)
        known, sigma = drift.seen(known, x, y, vx, vy, hull.r, TICK_S, gains), gains.sigma
    block.known = known
    return Nav(one, known.x, known.y, hull.psi, known.vx, known.vy, hull.r, ops.full(one, sigma))


def _gains(fix_sigma: float, velocity_sigma: float, now: int) -> Gains:
    """Of the look at tick `now` > 0: the same for all boats that have looked at every tick."""
    looks = _looks(fix_sigma, velocity_sigma)
    while len(looks) <= now:
        looks.append(drift.look(looks[-1][0], TICK_S, fix_sigma, velocity_sigma))
    gains = looks[now][1]
    assert gains is not None
    return gains


@lru_cache(maxsize=16)
def _looks(fix_sigma: float, velocity_sigma: float) -> list[tuple[Cov, Gains | None]]:
    """Covariance after each tick, and its gains; what is not there yet is added."""
    return [(drift.first(fix_sigma, velocity_sigma), None)]


def decide(block: Block[R], told: tuple[Message[R], ...], now: int, clean: bool, rules: Rules) -> Message[R]:
    """One tick of `step`; keeps the decision in the block's state and returns what is published."""
    nav = sense(block, now, rules)
    aged = [age(m, column, float(now), clean) for m, column in zip(told, block.columns, strict=True)]
    all_three = list(zip(told, block.columns, aged, strict=True))
    peers = [peer(m, column, a, nav.x, nav.y, rules.radius_m, rules.clock_error_s) for m, column, a in all_three]
    members = []
    leader: Any = None
    if block.wing is not None:
        leader, peers = _winged(block, nav, told, aged, peers, rules.radius_m)
    if rules.formations:
        block.weights = tuple(
            weigh(m, column, a, w, block.revision) for (m, column, a), w in zip(all_three, block.weights, strict=True)
        )
        members = [member(m, column, a, w) for (m, column, a), w in zip(all_three, block.weights, strict=True)]
        peers = [
            structs.replace(p, ordered=in_order(one, c, block.state.s, block.order.offset, rules.radius_m))
            for p, one, c in zip(peers, members, block.columns, strict=True)
        ]
    block.state, d = step(
        block.state, nav, members, peers, block.order, block.path, rules.method, rules.params, TICK_S, leader=leader
    )
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
        d.y_e,
        d.e,
        nav.r,
    )


def _winged(block: Any, nav: Any, told: Any, aged: Any, peers: Any, radius_m: float) -> tuple[Any, Any]:
    """The leader of a wingman, and the others as wingmen and leaders see them; of one boat, on floats."""
    seen = minded(block.wing, peers, told, block.decision, (nav.x, nav.y), radius_m)
    return beside(block.wing, told, aged, block.state), seen


def sail(block: Block[R], rules: Rules) -> None:
    """The hulls until the next tick."""
    d = block.decision
    assert d is not None
    powered: Any = 1.0 if ops.every(d.powered == 1.0) else d.powered
    limits = rules.params.limits
    if len(rules.hulls) == 1 or type(block.model) is float:
        hull = HULLS[rules.hulls[0 if len(rules.hulls) == 1 else int(block.model)]]
        block.hull = hull.advance_by(STEPS, block.hull, d.u_d, d.r_d, block.water, limits, STEP_S, powered)
        return
    model: Any = block.model
    after = [model.copy() for _ in HullState.__struct_fields__]
    for k, name in enumerate(rules.hulls):
        lanes = (model == k).nonzero()[0]
        state, u_d, r_d, water, power = (_some(v, lanes) for v in (block.hull, d.u_d, d.r_d, block.water, powered))
        moved = HULLS[name].advance_by(STEPS, state, u_d, r_d, water, limits, STEP_S, power)
        for values, part in zip(after, structs.astuple(moved), strict=True):
            values[lanes] = part
    block.hull = HullState(*after)


def _some(value: Any, lanes: Any) -> Any:
    """Some lanes of an array, or of a Struct of them; a number is that of all."""
    if isinstance(value, Struct):
        return type(value)(*(_some(field, lanes) for field in structs.astuple(value)))
    return value if type(value) is float else value[lanes]
