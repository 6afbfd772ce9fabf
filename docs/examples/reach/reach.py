"""A third way of keeping clear, small enough to be read at one go, whole enough to be sailed: velocity obstacles.

Of 75 velocities the boat takes the one nearest to its plan with which it comes within the radius of nobody for a while,
everybody else going straight on; turns to port cost more than those to starboard. It remembers its choice, so that it
does not change its mind for nothing. There is no agreement about sides, no plan of the others, no brake.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Generic

from msgspec import Meta, Struct, structs

from fleet import ops
from fleet.avoidance import Method
from fleet.avoidance.types import Advice, Own, Peer
from fleet.guidance.limits import Limits
from fleet.ops import R

STEP_RAD = math.radians(15.0)
TURNS = sorted((k * STEP_RAD for k in range(-12, 13)), key=lambda a: (abs(a), -a))  # to starboard first
FACTORS = (1.0, 0.5, 0.0)
SLOWEST = 0.3  # m/s: a boat that has to wait may still get out of the way
COURSES = [(math.sin(a), math.cos(a), a) for a in TURNS]
Positive = Annotated[float, Meta(gt=0.0)]


class ReachParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What may be tuned: `[keeping_clear.params]` of a family, by these names."""

    radius_m: Positive = 6.0  # R
    horizon_s: Positive = 30.0  # so far ahead
    late: Positive = 40.0  # price of coming within R at once; a meeting at the horizon costs nothing
    turn: Positive = 1.0  # of a turn by a radian
    port: Positive = 0.6  # more, of a turn to port
    slow: Positive = 1.5  # of stopping
    change: Positive = 0.4  # of another course than that of the last tick, by a radian
    k1: Positive = 0.8  # how hard it steers [1/s]


class ReachMemory(Struct, Generic[R], frozen=True, gc=False):
    """Numbers only, so that a run can be recorded and replayed."""

    away: R  # 1 it left its plan
    cx: R  # the course it chose, as a unit vector
    cy: R


def start(like: R, n_peers: int = 0) -> ReachMemory[R]:  # noqa: ARG001 - nothing is remembered of the others
    """A boat on its plan; `like` is a number, or an array of as many lanes as there are."""
    return ReachMemory(ops.zero(like), ops.full(like, 1.0), ops.zero(like))


def keep_clear(
    own: Own[R],
    peers: Sequence[Peer[R]],
    memory: ReachMemory[R],
    limits: Limits,
    params: ReachParams,
    dt: float,  # noqa: ARG001 - every method is called alike
) -> tuple[ReachMemory[R], Advice[R]]:
    """One tick, written once for a boat and for an array of boats: `ops`, and no `if` on what differs between lanes."""
    reach = max(limits.speed_max_mps, 0.3) * 2.0 * params.horizon_s + 2.0 * params.radius_m
    near = tuple(p for p in peers if ops.some(_within(own, p, reach)))
    zero = ops.zero(own.x)
    worst, who = _late(own, near, own.u_d * own.gx, own.u_d * own.gy, reach, params)

    def searched(own: Own[R], near: tuple[Peer[R], ...], memory: ReachMemory[R]) -> tuple[R, R, R]:
        return _search(own, near, memory, reach, params)

    plan: tuple[R, R, R] = (own.gx, own.gy, ops.full(zero, 1.0))
    bx, by, f = ops.when((worst > 0.0) | (memory.away > 0.5), searched, plan, own, near, memory)
    off = (f < 1.0) | (bx != own.gx) | (by != own.gy)
    away, turned = ops.flag(off, zero), _angle(own.gx, own.gy, bx, by)
    sin_chi, cos_chi = ops.sincos(own.chi)
    most = limits.yaw_rate_max_radps
    r_d = ops.clip(params.k1 * _angle(cos_chi, sin_chi, bx, by), -most, most)
    advice = Advice(
        avoiding=away,
        steers=away,
        r_d=ops.where(off, r_d, 0.0),
        u_d=ops.where(off, ops.clip(f * ops.maximum(own.u_d, SLOWEST), 0.0, limits.speed_max_mps), own.u_d),
        braking=zero,
        target=ops.where(off, who, -1.0),
        side=ops.where(off, ops.where(turned >= 0.0, 1.0, -1.0), 0.0),
    )
    return ReachMemory(away, bx, by), advice


def _search(
    own: Own[R], peers: Sequence[Peer[R]], memory: ReachMemory[R], reach: float, params: ReachParams
) -> tuple[R, R, R]:
    """The cheapest velocity: its course as a unit vector, and its speed as a share of the planned one."""
    least = ops.full(own.x, 1e9)
    bx, by, bf = own.gx, own.gy, ops.full(own.x, 1.0)
    for s, c, turn in COURSES:
        tx, ty = own.gx * c - own.gy * s, own.gx * s + own.gy * c
        price = abs(turn) * (params.turn + (params.port if turn < 0.0 else 0.0))
        changed = ops.where(memory.away > 0.5, params.change * abs(_angle(memory.cx, memory.cy, tx, ty)), 0.0)
        for f in FACTORS:
            u = own.u_d if turn == 0.0 and f == 1.0 else f * ops.maximum(own.u_d, SLOWEST)
            worst, _ = _late(own, peers, u * tx, u * ty, reach, params)
            cost = price + params.slow * (1.0 - f) + changed + params.late * worst
            better = cost < least
            least = ops.where(better, cost, least)
            bx, by, bf = ops.where(better, tx, bx), ops.where(better, ty, by), ops.where(better, f, bf)
    return bx, by, bf


def _within(own: Own[R], peer: Peer[R], reach: float) -> Any:
    """Whether a vehicle matters; one that does not leaves no trace in the bits."""
    dx, dy = peer.x - own.x, peer.y - own.y
    return (peer.present == 1.0) & (dx * dx + dy * dy < reach * reach)


def _late(own: Own[R], peers: Sequence[Peer[R]], vx: R, vy: R, reach: float, params: ReachParams) -> tuple[R, R]:
    """How soon, at this velocity, somebody is within R: 1 now, 0 not before the horizon; and who."""
    worst, who = ops.zero(own.x), ops.full(own.x, -1.0)
    for p in peers:
        dx, dy = p.x - own.x, p.y - own.y
        wx, wy = vx - p.vx, vy - p.vy
        radius = params.radius_m + p.widen + 2.0 * ops.hypot(own.sigma, p.sigma)
        closing, w_sq = dx * wx + dy * wy, wx * wx + wy * wy + 1e-9
        d_sq = dx * dx + dy * dy
        root = closing * closing - w_sq * (d_sq - radius * radius)  # eq. 9 of the paper, with a moving circle
        t = (closing - ops.sqrt(ops.maximum(root, 0.0))) / w_sq
        hits = (root > 0.0) & (closing > 0.0) & (t < params.horizon_s) & _within(own, p, reach)
        soon = ops.where(hits, 1.0 - ops.clip(t / params.horizon_s, 0.0, 1.0), 0.0)
        more = soon > worst
        worst, who = ops.where(more, soon, worst), ops.where(more, p.number, who)
    return worst, who


def _angle(ax: R, ay: R, bx: R, by: R) -> R:
    """From a to b, + to starboard [rad]."""
    return ops.atan2(ax * by - ay * bx, ax * bx + ay * by)


METHOD = Method(
    name="reach",
    description="velocity obstacles: nearest velocity to the plan with which nobody comes within R (an example)",
    params=lambda radius_m, side: ReachParams(radius_m=radius_m),
    start=start,
    keep_clear=keep_clear,
    memory=ReachMemory[float],
    align=lambda memory, old_numbers, new_numbers: memory,
    closer=lambda params: structs.replace(params, radius_m=3.5 / 6.0 * params.radius_m, horizon_s=12.0),
)
