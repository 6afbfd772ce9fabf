"""One tick as a function: from the boat's memory and what it knows now to what it does. No clock, no wire, no device.

Written once for a boat (floats) and for a batch (arrays), with equal bits. What the shell around it decides (who is
present, ages, goals) enters as numbers and is recorded, so that a run replays exactly.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, Protocol, TypeVar

from msgspec import Struct

from fleet import ops
from fleet.agent.modes import Goal, Mode
from fleet.avoidance import Method
from fleet.avoidance.types import Advice, Own, Peer
from fleet.coordination import Member, along_path_error, formation_speed
from fleet.guidance import FollowParams, Limits, Station, StationParams, course_over_ground, follow, keep_station
from fleet.ops import R
from fleet.paths import PathPoint

M = TypeVar("M")
NAVIGATION_GOOD_FOR_S = 3.0
FAR = 1.0e6
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
    cruise: R  # commanded speed C [m/s]
    u_min: R  # slowest speed in formation [m/s]
    u_max: R  # fastest speed in formation [m/s]
    gain: R  # k_u [1/m]
    s_end: R  # abscissa at which the mission ends for this boat [m]


class State(Struct, Generic[R, M], frozen=True, gc=False):
    """What a boat remembers from tick to tick."""

    s: R  # abscissa of the virtual target at the tick before, cumulative over laps [m]
    s_dot: R  # its speed from then on [m/s]
    good: R  # seconds for which navigation has been good
    held: R  # 1 while a station is kept
    x_h: R  # the station [m]
    y_h: R
    ended: R  # 1 once the boat has come to its end of the path
    keep: M  # memory of the way of keeping clear


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
) -> tuple[State[R, M], Decision[R]]:
    """Decide this tick.

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
    x, y = ops.where(sound, nav.x, point.x), ops.where(sound, nav.y, point.y)
    psi, sigma = ops.where(sound, nav.psi, 0.0), ops.where(sound, nav.sigma, 0.0)
    vx, vy = ops.where(sound, nav.vx, 0.0), ops.where(sound, nav.vy, 0.0)
    good = ops.where(sound, ops.minimum(state.good + dt, FAR), 0.0)
    fault = good < NAVIGATION_GOOD_FOR_S

    chi, U = course_over_ground(vx, vy, psi)
    f = follow(x, y, chi, U, point, params.follow)
    e = along_path_error(s - order.offset, members)
    alone = (order.goal == ALONE) | (order.goal == RETURN)
    u_path = ops.where(alone, order.cruise, formation_speed(e, order.cruise, order.u_min, order.u_max, order.gain))
    under_way = (order.goal == FOLLOW) | alone
    ended = ops.flag((state.ended > 0.5) | (under_way & (s >= order.s_end)), x)
    hold = (order.goal == HOLD) | (under_way & (ended > 0.5))
    fresh = hold & (state.held < 0.5)
    x_h, y_h = ops.where(fresh, x, state.x_h), ops.where(fresh, y, state.y_h)

    def kept(x: R, y: R, psi: R, x_h: R, y_h: R) -> Station[R]:
        return keep_station(x, y, psi, x_h, y_h, limits, params.station)

    station = ops.when(hold, kept, Station(u_path, f.r_d, f.gx, f.gy), x, y, psi, x_h, y_h)

    u_plan = ops.clip(ops.where(hold, station.u_d, u_path), 0.0, limits.speed_max_mps)
    gx, gy = ops.where(hold, station.gx, f.gx), ops.where(hold, station.gy, f.gy)
    tx, ty = ops.where(hold, gx, point.tx), ops.where(hold, gy, point.ty)
    straight = ops.where(hold, FAR, path.straight(s) / ops.maximum(u_plan, 0.3))
    y_e = ops.where(hold, 0.0, f.y_e)
    own = Own(x, y, vx, vy, chi, gx, gy, u_plan, tx, ty, y_e, straight, sigma)
    keep, advice = method.keep_clear(own, peers, state.keep, limits, params.keep, dt)

    idle = fault | (order.goal == NEUTRAL) | (order.goal == STANDBY)
    u_d, r_d = _setpoint(
        advice, ops.where(hold, station.r_d, f.r_d), idle, limits.speed_max_mps, limits.yaw_rate_max_radps
    )
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
    s_dot = ops.where(moving, f.s_dot, 0.0)
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
    return State(s=s, s_dot=s_dot, good=good, held=held, x_h=x_h, y_h=y_h, ended=ended, keep=keep), decision


def _setpoint(advice: Advice[R], r_plan: R, idle: Any, u_max: float, r_max: float) -> tuple[R, R]:
    """Surge and yaw rate within the limits; nothing reaches a driver that has not passed here."""
    r_d = ops.clip(ops.where(advice.steers > 0.5, advice.r_d, r_plan), -r_max, r_max)
    u_d = ops.clip(advice.u_d, 0.0, u_max)
    return ops.where(idle, 0.0, u_d), ops.where(idle, 0.0, r_d)
