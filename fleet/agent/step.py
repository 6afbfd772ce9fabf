"""One tick as a function: from the boat's memory and what it knows now to what it does. No clock, no wire, no device.

Written once for a boat (floats) and for a batch (arrays), with equal bits. What the shell around it decides (who is
present, ages, goals) enters as numbers and is recorded, so that a run replays exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

from msgspec import Struct, structs

from fleet import ops
from fleet.agent.abroad import Abroad, Sea, Watch, acts, instead, own_boat, side_of, together, watch
from fleet.agent.modes import Goal, Mode
from fleet.avoidance import Method
from fleet.avoidance.foreign.types import Boat
from fleet.avoidance.types import Advice, Own, Peer
from fleet.coordination import Leader, Member, along_path_error, cvt_speed, formation_speed, wingman_speed
from fleet.guidance import FollowParams, Limits, Station, StationParams, course_over_ground, follow, keep_station
from fleet.ops import R
from fleet.paths import PathPoint

M = TypeVar("M")
NAVIGATION_GOOD_FOR_S = 3.0
FAR = 1.0e6
FOREIGN_FROM = 100_000.0  # numbers of foreign vessels; boats of the fleet have smaller ones
ON_EARTH_M = 1.0e8
ABSURD = 100.0  # m/s, rad/s, rad: finite, but no boat's; sines of 1e30 rad are not
FOLLOW, HOLD, RETURN, ALONE = float(Goal.FOLLOW), float(Goal.HOLD), float(Goal.RETURN), float(Goal.ALONE)
NEUTRAL, STANDBY = float(Goal.NEUTRAL), float(Goal.STANDBY)


class Nav(Struct, Generic[R], frozen=True, gc=False):
    """Where the own boat is and how it moves, in the mission's local frame."""

    sound: R  # 1 fresh and believed, 0 stale or refused
    x: R  # north [m]
    y: R  # east [m]
    psi: R  # heading [rad]
    vx: R  # velocity over ground, north [m/s]
    vy: R  # velocity over ground, east [m/s]
    r: R  # yaw rate [rad/s]
    sigma: R  # 1-sigma error of the position [m]


class Order(Struct, Generic[R], frozen=True, gc=False):
    """What the boat is to do, operators and troubles taken together."""

    goal: R  # fleet.agent.modes.Goal
    offset: R  # of the own slot, + ahead [m]
    cruise: R  # commanded speed C, as much as the own lane is longer or shorter than the path [m/s]
    u_min: R  # slowest speed in formation [m/s]
    u_max: R  # fastest speed in formation [m/s]
    gain: R  # k_u [1/m]
    s_end: R  # abscissa at which the mission ends for this boat [m]
    stretch: R = 1.0  # type: ignore[assignment]  # metres of the own lane for a metre of abscissa


class Wing(Struct, Generic[R], frozen=True, gc=False):
    """What a wingman remembers."""

    s: R  # abscissa of its CVT on its own path [m]
    u: R  # last good speed [m/s]
    calm: R  # time since it kept clear of anybody [s]


class State(Struct, Generic[R, M], frozen=True, gc=False, omit_defaults=True):
    """What a boat remembers from tick to tick."""

    s: R  # abscissa of the virtual target at the tick before, cumulative over laps [m]
    s_dot: R  # its speed from then on [m/s]
    good: R  # seconds for which navigation has been good
    held: R  # 1 while a station is kept
    x_h: R  # the station [m]
    y_h: R
    ended: R  # 1 once the boat has come to its end of the path
    keep: M  # memory of the way of keeping clear
    foreign: Watch | None = None  # of vessels that are not of the fleet, while there are any
    wing: Wing[R] | None = None  # of a boat that sails beside a leader


class Decision(Struct, Generic[R], frozen=True, gc=False):
    """What a boat does this tick, and what it tells the others."""

    mode: R  # fleet.agent.modes.Mode
    powered: R  # 1 the set-point holds, 0 neutral
    u_d: R  # surge over ground along the heading [m/s]
    r_d: R  # yaw rate, + to starboard [rad/s]
    s: R  # abscissa of the virtual target now [m]
    e: R  # along-path error, + behind its place [m]
    y_e: R  # cross-track error, + to starboard of the path [m]
    gx: R  # course that the path law wants, unit vector
    gy: R
    u_plan: R  # speed that path and formation want [m/s]
    tx: R  # the path's tangent at the virtual target
    ty: R
    straight: R  # seconds for which the path's course stays within 10 deg
    chi: R  # course over ground [rad]
    U: R  # speed over ground [m/s]
    avoiding: R
    braking: R
    target: R  # number of the vehicle that decides, -1 none
    side: R  # +1 it is left to port


class StepParams(Struct, frozen=True, kw_only=True):
    """Everything about a boat that stays while it sails."""

    follow: FollowParams
    station: StationParams
    limits: Limits
    keep: Any  # parameters of the way of keeping clear
    closer: Any = None  # the same while a foreign vessel decides: less is kept from boats of the fleet
    sea: Sea | None = None  # None: foreign vessels are not looked at


class Plan(NamedTuple, Generic[R]):
    """What keeping clear within the fleet starts from."""

    own: Own[R]
    r_d: R  # yaw rate [rad/s]
    keep: Any  # parameters


class PathLike(Protocol[R]):
    """A path, or a table of paths with one lane each."""

    def at(self, s: R) -> PathPoint[R]:
        """Point, tangent and curvature at the abscissa."""

    def straight(self, s: R) -> R:
        """Metres for which the course stays within 10 deg."""


def start(like: R, s: R, keep: M) -> State[R, M]:
    """Memory of a boat that begins at abscissa s."""
    zero = ops.zero(like)
    good = ops.full(like, NAVIGATION_GOOD_FOR_S)
    return State(s=s, s_dot=zero, good=good, held=zero, x_h=zero, y_h=zero, ended=zero, keep=keep)


def step(
    state: State[R, M],
    nav: Nav[R],
    members: Sequence[Member[R]],
    peers: Sequence[Peer[R]],
    order: Order[R],
    path: PathLike[R],
    method: Method,
    params: StepParams,
    dt: float,
    abroad: Abroad | None = None,
    leader: Leader[R] | None = None,
) -> tuple[State[R, M], Decision[R]]:
    """Decide this tick.

    Foreign vessels come before boats of the fleet: while the law for them acts, its course and speed are the plan, and
    keeping clear within the fleet leaves it only for what comes near soon (`Method.closer`). The brake comes last.

    Args:
        state: memory of the tick before
        nav: own navigation; anything may be NaN where `sound` is 0
        members: boats of the same mission and formation, in the order of the roster
        peers: vehicles to keep clear of, dead-reckoned to now, by number; `state.keep` is aligned with them
        order: what to do
        path: the path to follow
        method: the way of keeping clear
        params: tuning and limits
        dt: time since the tick before [s]
        abroad: foreign vessels, for one boat; None where there are none
        leader: beside whom to sail; None: in the formation of the members

    Returns:
        Memory for the next tick, and the decision.
    """
    limits = params.limits
    s = state.s + state.s_dot * dt
    point = path.at(s)
    sound = (
        (nav.sound > 0.5)  # NaN fails every one of these
        & (abs(nav.x) + abs(nav.y) < ON_EARTH_M)
        & (abs(nav.psi) < ABSURD)
        & (abs(nav.vx) + abs(nav.vy) + abs(nav.r) < ABSURD)
        & (nav.sigma >= 0.0)
        & (nav.sigma < ON_EARTH_M)
    )
    sound = ops.settled(sound, expected=True)
    x, y = ops.where(sound, nav.x, point.x), ops.where(sound, nav.y, point.y)
    psi, sigma = ops.where(sound, nav.psi, 0.0), ops.where(sound, nav.sigma, 0.0)
    vx, vy = ops.where(sound, nav.vx, 0.0), ops.where(sound, nav.vy, 0.0)
    good = ops.where(sound, ops.minimum(state.good + dt, FAR), 0.0)
    fault = good < NAVIGATION_GOOD_FOR_S

    chi, U = course_over_ground(vx, vy, psi)
    f = follow(x, y, chi, U, point, params.follow)
    alone = (order.goal == ALONE) | (order.goal == RETURN)
    wing, e, u_formed = _formed(state.wing, leader, s, members, order, path, dt)
    u_path = ops.where(alone, order.cruise, u_formed)
    under_way = (order.goal == FOLLOW) | alone
    ended = ops.flag((state.ended > 0.5) | (under_way & (s >= order.s_end)), x)
    hold = (order.goal == HOLD) | (under_way & (ended > 0.5))
    if leader is not None:  # it stops where its leader is abeam, or at once where that is behind
        hold = hold | ((order.goal == FOLLOW) & (leader.stopped > 0.5) & (e <= U * limits.surge_lag_s))
    hold = ops.settled(hold, expected=False)
    fresh = hold & (state.held < 0.5)
    x_h, y_h = ops.where(fresh, x, state.x_h), ops.where(fresh, y, state.y_h)
    if leader is not None:  # where it will have lost its way, so that it need not turn round for it
        x_h, y_h = _at_point(fresh, path.at(s + U * limits.surge_lag_s), x_h, y_h)

    def kept(x: R, y: R, psi: R, x_h: R, y_h: R) -> Station[R]:
        return keep_station(x, y, psi, x_h, y_h, limits, params.station)

    station = ops.when(hold, kept, Station(u_path, f.r_d, f.gx, f.gy), x, y, psi, x_h, y_h)

    u_plan = ops.clip(ops.where(hold, station.u_d, u_path), 0.0, limits.speed_max_mps)
    gx, gy = ops.where(hold, station.gx, f.gx), ops.where(hold, station.gy, f.gy)
    tx, ty = ops.where(hold, gx, point.tx), ops.where(hold, gy, point.ty)
    straight = ops.where(hold, FAR, path.straight(s) / ops.maximum(u_plan, 0.3))
    y_e = ops.where(hold, 0.0, f.y_e)
    own = Own(x, y, vx, vy, chi, gx, gy, u_plan, tx, ty, y_e, straight, sigma, nav.r)
    plan, foreign = Plan(own, ops.where(hold, station.r_d, f.r_d), params.keep), None
    if abroad is not None:
        boat = own_boat(own, U, nav.r, s, order.cruise, hold, path, limits)
        foreign, plan = _abroad(abroad, state.foreign, plan, boat, peers, e, fault, params)
        peers = together(peers, abroad, foreign)
    keep, advice = method.keep_clear(plan.own, peers, state.keep, limits, plan.keep, dt)

    idle = ops.settled(fault | (order.goal == NEUTRAL) | (order.goal == STANDBY), expected=False)
    u_d, r_d = _setpoint(advice, plan.r_d, idle, limits.speed_max_mps, limits.yaw_rate_max_radps)
    mode = ops.select(
        (
            (order.goal == STANDBY, float(Mode.STANDBY)),
            (fault, float(Mode.FAULT)),
            (order.goal == NEUTRAL, float(Mode.NEUTRAL)),
            (hold, float(Mode.HOLD)),
            (order.goal == RETURN, float(Mode.RETURN)),
            (order.goal == ALONE, float(Mode.ALONE)),
            (advice.avoiding > 0.5, float(Mode.AVOID)),
        ),
        ops.full(x, float(Mode.FOLLOW)),
    )
    moving = sound & ops.no(hold) & (order.goal != STANDBY)
    s_dot = ops.where(moving, f.s_dot / order.stretch, 0.0)
    decision = Decision(
        mode=mode,
        powered=ops.flag(ops.no(idle), x),
        u_d=u_d,
        r_d=r_d,
        s=s,
        e=e,
        y_e=f.y_e,
        gx=gx,
        gy=gy,
        u_plan=ops.where(idle, 0.0, u_plan),
        tx=tx,
        ty=ty,
        straight=straight,
        chi=chi,
        U=U,
        avoiding=advice.avoiding,
        braking=advice.braking,
        target=advice.target,
        side=advice.side,
    )
    held = ops.flag(hold, x)
    decision = _acting(decision, plan.own, foreign, idle) if acts(foreign) else decision
    wing = _calm(wing, decision.avoiding)
    return State(s, s_dot, good, held, x_h, y_h, ended, keep, foreign, wing), decision


def _formed(
    wing: Wing[R] | None,
    leader: Leader[R] | None,
    s: R,
    members: Sequence[Member[R]],
    order: Order[R],
    path: PathLike[R],
    dt: float,
) -> tuple[Wing[R] | None, R, R]:
    """Memory of a wingman for the next tick, formation error and the speed that closes it.

    A wingman that has lost its leader goes on at its last good speed. The CVT of a boat that was no wingman before
    begins at the boat's own target.
    """
    if leader is None:
        e = along_path_error(s - order.offset, members)
        return None, e, formation_speed(e, order.cruise, order.u_min, order.u_max, order.gain)
    if wing is None:
        wing = Wing(s, order.cruise, ops.full(s, FAR))
    good = leader.good > 0.5
    s_cvt_dot = cvt_speed(path.at(wing.s), leader)
    e = ops.where(good, wing.s - s, 0.0)
    u = wingman_speed(s_cvt_dot + leader.gains, e, wing.calm, order.u_min, order.u_max)
    u = ops.where(good, u, wing.u)
    return Wing(ops.where(good, wing.s + s_cvt_dot * dt, s), u, ops.minimum(wing.calm + dt, FAR)), e, u


def _calm(wing: Wing[R] | None, avoiding: R) -> Wing[R] | None:
    """The memory of a wingman, its calm over where it keeps clear of somebody."""
    return None if wing is None else Wing(wing.s, wing.u, ops.where(avoiding > 0.5, 0.0, wing.calm))


def _at_point(cond: Any, point: PathPoint[R], x: R, y: R) -> tuple[R, R]:
    """The point where cond holds, (x, y) elsewhere."""
    return ops.where(cond, point.x, x), ops.where(cond, point.y, y)


def _abroad(
    abroad: Abroad,
    foreign: Watch | None,
    plan: Any,
    boat: Boat,
    peers: Sequence[Any],
    e: Any,
    fault: Any,
    params: StepParams,
) -> tuple[Watch | None, Any]:
    """What is remembered of foreign vessels, and the plan of a boat that may act for one."""
    if params.sea is not None and not fault:
        foreign = watch(abroad, foreign, boat, peers, e, params.sea)
    if acts(foreign):
        plan = Plan(instead(plan.own, foreign), foreign.advice.r_d, params.closer)
    return foreign, plan


def _acting(decision: Any, plan: Own[R], foreign: Watch, idle: Any) -> Any:
    """The decision while the boat keeps clear of a foreign vessel: what it tells the others is what it does."""
    within_fleet = decision.avoiding > 0.5 or decision.braking > 0.5
    return structs.replace(
        decision,
        mode=float(Mode.AVOID) if decision.mode == float(Mode.FOLLOW) else decision.mode,
        gx=plan.gx,
        gy=plan.gy,
        u_plan=0.0 if idle else plan.u_d,
        tx=plan.tx,
        ty=plan.ty,
        straight=plan.straight,
        avoiding=1.0,
        target=decision.target if within_fleet else max(foreign.advice.target, FOREIGN_FROM),
        side=decision.side if within_fleet else side_of(foreign),
    )


def _setpoint(advice: Advice[R], r_plan: R, idle: Any, u_max: float, r_max: float) -> tuple[R, R]:
    """Surge and yaw rate within the limits; nothing reaches a driver that has not passed here."""
    r_d = ops.clip(ops.where(advice.steers > 0.5, advice.r_d, r_plan), -r_max, r_max)
    u_d = ops.clip(advice.u_d, 0.0, u_max)
    return ops.where(idle, 0.0, u_d), ops.where(idle, 0.0, r_d)
