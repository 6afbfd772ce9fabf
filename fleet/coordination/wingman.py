"""A wingman sails its own path beside its leader: a coordinated virtual target (CVT) runs abeam of the leader's target,
and the wingman keeps up with it (Bibuli 2014, eq. 5-6, signs and feed-forward put right).
"""

from __future__ import annotations

from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.ops import R
from fleet.paths import PathPoint

K2 = 0.5  # how fast the CVT comes abeam [1/s]
K_U = 0.6  # most by which a wingman is faster or slower than its CVT [m/s]
K_E = 0.2  # formation error to speed [1/m]
LEAST_COS = 0.3  # paths that part by more than 72 deg have no point abeam
CALM_S = 5.0  # after keeping clear nobody catches up for so long


class Leader(Struct, Generic[R], frozen=True, gc=False):
    """What a wingman knows of its leader now."""

    good: R  # 1 heard, and sailing its path or stopped on it; 0 lost: the last good speed is held
    stopped: R  # 1 it keeps station, drifts or has ended: stop beside it
    x: R  # its virtual target, north [m]
    y: R  # east [m]
    tx: R  # its path there: unit tangent
    ty: R
    c: R  # and curvature [1/m]
    U: R  # speed of its virtual target [m/s]
    room: R  # how far ahead of abeam the CVT runs on purpose, where the paths come near, - behind [m]
    slope: R  # how that grows along the wingman's path [m/m]
    gains: R = 0.0  # type: ignore[assignment]  # by how much the CVT will be faster when surge has followed [m/s]


def cvt_speed(cvt: PathPoint[R], leader: Leader[R]) -> R:
    """Speed of the CVT along the wingman's path [m/s].

        s_cvt_dot = (U1 (1 - c1 n) - k2 (s1_bar - room)) / (cos(beta_bar) - room')

    with s1_bar the CVT ahead of the leader's target and n to starboard of it, both in the LEADER's frame, and beta_bar
    the angle between the paths. The divisor is limited to 0.3.

    Args:
        cvt: the wingman's path at the CVT
        leader: at its own target

    Source: Bibuli et al. (2014), eq. 5, with the exact feed-forward; as printed a wingman on a sine is 0.94 m off.
    """
    dx, dy = cvt.x - leader.x, cvt.y - leader.y
    s1_bar = leader.tx * dx + leader.ty * dy
    n = leader.tx * dy - leader.ty * dx
    cos_beta = leader.tx * cvt.tx + leader.ty * cvt.ty
    abeam = leader.U * (1.0 - leader.c * n) - K2 * (s1_bar - leader.room)
    return abeam / ops.maximum(cos_beta - leader.slope, LEAST_COS)


def wingman_speed(s_cvt_dot: R, e: R, calm: R, u_min: R, u_max: R) -> R:
    """Speed of the wingman [m/s].

        u2 = s_cvt_dot + k_u tanh(k_e (s_cvt - s2)), within u_min .. u_max

    Args:
        s_cvt_dot: speed of its CVT, where it is known beforehand that of a surge lag later [m/s]
        e: s_cvt - s2, + when the wingman is behind its place [m]
        calm: time since it kept clear of anybody: for 5 s it does not catch up [s]
        u_min: slowest speed in formation [m/s]
        u_max: fastest speed in formation [m/s]

    Source: Bibuli et al. (2014), eq. 6, with the CVT's speed for the leader's as feed-forward.
    """
    behind = ops.where(calm < CALM_S, ops.minimum(e, 0.0), e)
    return ops.clip(s_cvt_dot + K_U * ops.tanh(K_E * behind), u_min, u_max)
