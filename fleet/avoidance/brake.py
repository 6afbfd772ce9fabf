"""The last-moment brake: every tick, after everything else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.avoidance.params import ScoringParams
from fleet.avoidance.types import Own, Peer
from fleet.guidance.limits import Limits
from fleet.ops import R

_MOST_TURN_RAD = 0.6
_ROUNDING_M = 1.0e-3


class Brake(Struct, Generic[R], frozen=True, gc=False):
    """Whether to stop, and for whom."""

    braking: R  # 1 stop
    target: R  # number of the nearest vehicle that it is for, -1 for none


def _stopping_s(speed: R, limits: Limits, params: ScoringParams) -> R:
    """Time at the present speed that covers the way to a stop [s]: max(T_u, u / 2a) + 0.2 s."""
    return ops.maximum(speed / (2.0 * limits.acceleration_max_mps2), limits.surge_lag_s) + params.reaction_s


def brake(own: Own[R], peers: Sequence[Peer[R]], limits: Limits, params: ScoringParams) -> Brake[R]:
    """Stop where the own stopping segment comes too near to a peer's and advancing makes it worse than staying.

    A stopping segment is max(u T_u, u^2 / 2a) + 0.2 u long; peers are taken to stop as we do. It lies along the
    velocity, and both are looked at once more turned by half of what the boats turn by meanwhile: two that turn towards
    each other are not found on straight segments before it is late (of 20,020 encounters with noise one touched, in
    three sizes of its crowd). Too near is D_sh, with its margin and the widening, and never less than the own hull.
    """
    braking, target = ops.zero(own.x), ops.full(own.x, -1.0)
    nearest = ops.full(own.x, 1e300)
    speed = ops.hypot(own.vx, own.vy)
    time = _stopping_s(speed, limits, params)
    length = speed * time
    least = max(params.brake_m, limits.length_m)
    for peer in peers:
        dx, dy = peer.x - own.x, peer.y - own.y
        d_sq = dx * dx + dy * dy
        its_speed = ops.hypot(peer.vx, peer.vy)
        its_time = _stopping_s(its_speed, limits, params)
        keep = least + peer.widen + params.brake_sigmas * ops.hypot(own.sigma, peer.sigma)
        reach = length + its_speed * its_time + keep + 0.1  # 0.1 m: rounding
        near = (peer.present == 1.0) & (d_sq < reach * reach)
        if not ops.some(near):
            continue
        a = (own.vx * time, own.vy * time, own.r * time)
        b = (peer.vx * its_time, peer.vy * its_time, peer.r * its_time)
        given = (keep, dx, dy, a, b, params.brake_gain_m, params.brake_samples)
        stops = ops.when(near, _comes_too_near, ops.zero(dx), *given) == 1.0
        braking = ops.where(stops, 1.0, braking)
        first = stops & (d_sq < nearest)
        target, nearest = ops.where(first, peer.number, target), ops.where(first, d_sq, nearest)
    return Brake(braking, target)


def _comes_too_near(keep: R, dx: R, dy: R, own: tuple[R, R, R], peer: tuple[R, R, R], gain: float, samples: int) -> R:
    """1 where advancing comes nearer than `keep`, and by `gain` nearer than staying, straight on or turning.

    Args:
        own, peer: segment from start to end, north and east [m], and the turn made on it [rad]
    """
    (ax, ay, turn), (bx, by, its_turn) = own, peer
    stay, advance = _segments(dx, dy, ax, ay, bx, by, samples)
    nearer = (advance < keep) & (advance < stay - gain)
    # turned by half of that, no point of a segment moves farther than this: most pairs need no second look
    moved = 0.5 * (ops.hypot(ax, ay) * abs(turn) + ops.hypot(bx, by) * abs(its_turn))
    open_yet = ops.no(nearer) & (moved > 0.0) & (advance < keep + moved + _ROUNDING_M)
    turns = ops.when(open_yet, _turning_too_near, ops.zero(dx), keep, dx, dy, own, peer, gain, samples) == 1.0
    return ops.flag(nearer | turns, dx)


def _turning_too_near(keep: R, dx: R, dy: R, own: tuple[R, R, R], peer: tuple[R, R, R], gain: float, samples: int) -> R:
    """The same along the turns alone."""
    stay, advance = _segments(dx, dy, *_turned(*own), *_turned(*peer), samples)
    return ops.flag((advance < keep) & (advance < stay - gain), dx)


def _turned(x: R, y: R, by: R) -> tuple[R, R]:
    """A segment turned by half of the turn made on it, + to starboard [rad], at most 0.6."""
    s, c = ops.sincos(ops.clip(0.5 * by, -_MOST_TURN_RAD, _MOST_TURN_RAD))
    return c * x - s * y, s * x + c * y


def _segments(dx: R, dy: R, ax: R, ay: R, bx: R, by: R, samples: int) -> tuple[R, R]:
    """Least distances [m] from the start of the own segment, and from its later samples, to the samples of the peer's.

    Args:
        dx, dy: from own to the peer [m]
        ax, ay: the own segment, start to end [m]
        bx, by: the peer's segment [m]
        samples: points on each segment, ends included
    """
    last = samples - 1
    others = [(dx + bx * (k / last), dy + by * (k / last)) for k in range(samples)]
    stay = dx * dx + dy * dy
    for px, py in others[1:]:
        stay = ops.lesser(stay, px * px + py * py)
    advance = ops.full(dx, 1e300)
    for i in range(1, samples):
        sx, sy = ax * (i / last), ay * (i / last)
        for px, py in others:
            ex, ey = px - sx, py - sy
            advance = ops.lesser(advance, ex * ex + ey * ey)
    return ops.sqrt(stay), ops.sqrt(advance)
