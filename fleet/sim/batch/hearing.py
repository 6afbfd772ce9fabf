"""What a boat believes of another one by its last message: `fleet.agent.picture` in numbers, for floats and arrays."""

from __future__ import annotations

from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.agent.modes import Mode
from fleet.agent.picture import AHEAD_S, GROWS_MPS, RETURN_RAMP_S, SILENT_PERIODS
from fleet.agent.step import PathLike
from fleet.avoidance.reckoning import reckoned
from fleet.avoidance.types import Peer
from fleet.coordination import Member
from fleet.ops import R
from fleet.paths import Path
from fleet.sim.batch.scenarios import ENDLESS

TICK_S = 0.1
FOLLOW, AVOID, HOLD, ALONE = float(Mode.FOLLOW), float(Mode.AVOID), float(Mode.HOLD), float(Mode.ALONE)
_SILENT_S = SILENT_PERIODS * TICK_S + 1e-9


class Message(Struct, Generic[R], frozen=True, gc=False):
    """What a boat publishes every tick."""

    stamp: R  # tick, -1 nothing was ever heard
    x: R
    y: R
    vx: R
    vy: R
    gx: R
    gy: R
    u_d: R
    tx: R
    ty: R
    straight: R
    s: R
    sigma: R
    mode: R
    revision: R  # of the formation in force
    y_e: R  # its cross-track error [m]
    e: R = 0.0  # type: ignore[assignment]  # its along-path error [m]
    r: R = 0.0  # type: ignore[assignment]  # its yaw rate, + to starboard [rad/s]


class Column(Struct, Generic[R], frozen=True, gc=False):
    """What stays of one other boat, as every lane sees it."""

    number: R
    avoided: R  # 1 the lane keeps clear of it
    member: R  # 1 both belong to the formation
    offset: R  # of its slot [m]
    path: PathLike[R]
    delay_s: R  # of its messages
    near_m: R  # so far ahead or astern counts as in order: half a lap of the path of both; 0 on another path


class Believed(Struct, Generic[R], frozen=True, gc=False):
    """A message, aged."""

    age: R  # at most 10 s count
    full_age: R
    silent: R  # 1 heard once, but not for 7 periods


def age(message: Message[R], column: Column[R], now: float, clean: bool) -> Believed[R]:
    """How old a message is at tick `now`; in a clean radio nobody is ever silent."""
    full_age = (now - message.stamp) * TICK_S
    if clean:
        return Believed(ops.minimum(full_age, AHEAD_S), full_age, ops.zero(full_age))
    silent = ops.flag((message.stamp >= 0.0) & (full_age - column.delay_s > _SILENT_S), full_age)
    return Believed(ops.minimum(full_age, AHEAD_S), full_age, silent)


def peer(
    message: Message[R],
    column: Column[R],
    aged: Believed[R],
    own_x: R,
    own_y: R,
    radius_m: float,
    clock_error_s: float,
) -> Peer[R]:
    """The other boat as a vehicle to keep clear of, dead-reckoned; a silent one stands where it may be nearest."""
    here = ops.where(message.stamp >= 0.0, column.avoided, 0.0)
    silent = aged.silent == 1.0
    x, y, vx, vy = reckoned(message.x, message.y, message.vx, message.vy, message.r, aged.age)
    widen = clock_error_s * ops.hypot(message.vx, message.vy) if clock_error_s > 0.0 else ops.zero(x)
    u_d, straight = message.u_d, message.straight
    known = (message.mode >= FOLLOW) & (message.mode <= ALONE)
    if ops.some(silent):
        x, y, widen = ops.when(silent, _lost, (x, y, widen), message, aged, own_x, own_y, column.path, radius_m)
        vx, vy = ops.where(silent, 0.0, vx), ops.where(silent, 0.0, vy)
        u_d, straight = ops.where(silent, 0.0, u_d), ops.where(silent, 0.0, straight)
        known = known & ops.no(silent)
    return Peer(
        column.number,
        here,
        x,
        y,
        vx,
        vy,
        ops.flag(known, x),
        message.gx,
        message.gy,
        u_d,
        message.tx,
        message.ty,
        straight,
        message.sigma,
        widen,
        y_e=ops.where(message.mode == HOLD, 0.0, message.y_e),
        r=ops.where(silent, 0.0, message.r),
    )


def _lost(
    message: Message[R], aged: Believed[R], own_x: R, own_y: R, path: PathLike[R], radius_m: float
) -> tuple[R, R, R]:
    """Where a silent boat is kept clear of: nearest to us between its last position and its prediction; and widening.

    The prediction is along its path, or straight on where it was off it, or held its station.
    """
    speed = ops.hypot(message.vx, message.vy)
    point = path.at(message.s + speed * aged.age)
    on_x, on_y = message.x + message.vx * aged.age, message.y + message.vy * aged.age
    far = ops.hypot(point.x - message.x, point.y - message.y) > speed * aged.age + 5.0
    off = far | (message.mode == HOLD)
    dx = ops.where(off, on_x, point.x) - message.x
    dy = ops.where(off, on_y, point.y) - message.y
    length_sq = dx * dx + dy * dy
    long = length_sq > 1e-9
    share = ((own_x - message.x) * dx + (own_y - message.y) * dy) / ops.where(long, length_sq, 1.0)
    share = ops.where(long, ops.clip(share, 0.0, 1.0), 0.0)
    widen = ops.minimum(GROWS_MPS * aged.full_age, 0.5 * radius_m)
    return message.x + share * dx, message.y + share * dy, widen


def weigh(message: Message[R], column: Column[R], aged: Believed[R], weight: R, revision: R) -> R:
    """Its weight in the formation: away at once, back within two seconds."""
    present = (
        (message.stamp >= 0.0)
        & (aged.silent == 0.0)
        & (message.revision == revision)
        & ((message.mode == FOLLOW) | (message.mode == AVOID))
        & (column.member == 1.0)
    )
    return ops.where(present, ops.minimum(weight + TICK_S / RETURN_RAMP_S, 1.0), 0.0)


def member(message: Message[R], column: Column[R], aged: Believed[R], weight: R) -> Member[R]:
    """The other boat as one of the formation, its abscissa dead-reckoned."""
    s = message.s + aged.age * (message.vx * message.tx + message.vy * message.ty)
    return Member(weight, s - column.offset)


def half_lap_m(path: Path) -> float:
    """Within so much of their path boats are ahead or astern of each other [m]; without end on an open one."""
    return 0.5 * path.length if path.closed else ENDLESS


def in_order(other: Member[R], column: Column[R], own_s: R, own_offset: R, radius_m: float) -> R:
    """1 where a boat of the formation, on the own path, is ahead or astern as its slot is."""
    gap = other.z + column.offset - own_s
    there = (gap * (column.offset - own_offset) > 0.0) & (abs(gap) > radius_m) & (abs(gap) < column.near_m)
    return ops.flag(there & (other.weight > 0.0), gap)
