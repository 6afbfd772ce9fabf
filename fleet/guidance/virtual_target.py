"""Path-following with a virtual target that slides along the path, in its Serret-Frenet frame.

The target is free: it is not the closest point but runs after the boat at its own speed, so nothing is singular where
the boat is as far off as the centre of the path's curvature.
"""

from __future__ import annotations

from typing import Annotated, Generic

from msgspec import Meta, Struct

from fleet import ops
from fleet.ops import R
from fleet.paths import PathPoint

STILL_MPS = 0.05
"""Below this speed over ground the course is noise, and the heading takes its place [m/s]."""


class FollowParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Tuning of path-following."""

    k1_per_s: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.8  # course error to yaw rate
    k2_per_s: Annotated[float, Meta(gt=0.0, le=5.0)] = 1.0  # how fast the target runs after the boat
    psi_a_rad: Annotated[float, Meta(gt=0.0, lt=1.5708)] = 1.05  # approach angle far from the path
    k_phi_per_m: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.20  # how early the approach bends onto the path
    # The target moves no faster than this, either way, which bounds the feed-forward c s_dot. From the centre of a 15 m
    # circle at 1 to 1.5 m/s it would peak at 6.4 to 9.4 m/s; limited to 2, 3 or 5.5 m/s the unicycle is on the circle
    # in 26 s all the same, the Otter in 43, 40 and 30 s.
    s_dot_max_mps: Annotated[float, Meta(ge=2.0, le=50.0)] = 5.5


class Follow(Struct, Generic[R], frozen=True, gc=False):
    """What path-following wants now."""

    s1: R  # boat ahead of its virtual target, along the tangent [m]
    y1: R  # boat to starboard of the path, in the target's frame [m]
    s_dot: R  # speed of the virtual target along the path [m/s]
    r_d: R  # yaw rate wanted, + to starboard; not yet held within the hull's limits [rad/s]
    gx: R  # unit vector of the course wanted, gamma = chi_p + phi
    gy: R
    y_e: R  # cross-track error, + to starboard of the path: y1 [m]
    beta: R  # course over ground less that of the path, in [-pi, pi] [rad]


def course_over_ground(vx: R, vy: R, psi: R) -> tuple[R, R]:
    """(chi, U): course [rad] and speed [m/s] of the velocity (vx, vy); the heading psi below 0.05 m/s."""
    speed = ops.hypot(vx, vy)
    return ops.where(speed >= STILL_MPS, ops.atan2(vy, vx), psi), speed


def follow(x: R, y: R, chi: R, U: R, point: PathPoint[R], params: FollowParams) -> Follow[R]:
    """Yaw rate and target speed that bring a boat onto its path and keep it there.

        s_dot = U cos(beta) + k2 s1
        phi   = -psi_a tanh(k_phi y1)
        r_d   = phi_dot - k1 wrap(beta - phi) + c s_dot

    with y1_dot = -c s_dot s1 + U sin(beta), in phi_dot. Course feedback leaves no error in a cross current.

    Args:
        x, y: position, north and east [m]
        chi: course over ground [rad]
        U: speed over ground [m/s]
        point: the path at the virtual target
        params: tuning

    Source: Bibuli et al. (2014), eq. 1-3, with the course over ground for the heading and the term phi_dot.
    """
    tx, ty, c = point.tx, point.ty, point.c
    dx, dy = x - point.x, y - point.y
    s1 = tx * dx + ty * dy
    y1 = tx * dy - ty * dx
    ch_y, ch_x = ops.sincos(chi)
    most = params.s_dot_max_mps
    s_dot = ops.clip(U * (ch_x * tx + ch_y * ty) + params.k2_per_s * s1, -most, most)
    y1_dot = U * (ch_y * tx - ch_x * ty) - c * s_dot * s1
    bent = ops.tanh(params.k_phi_per_m * y1)
    phi = -params.psi_a_rad * bent
    phi_dot = -params.psi_a_rad * params.k_phi_per_m * (1.0 - bent * bent) * y1_dot
    sin_phi, cos_phi = ops.sincos(phi)
    gx, gy = tx * cos_phi - ty * sin_phi, ty * cos_phi + tx * sin_phi
    off = ops.atan2(gx * ch_y - gy * ch_x, gx * ch_x + gy * ch_y)  # wrap(beta - phi)
    return Follow(
        s1=s1,
        y1=y1,
        s_dot=s_dot,
        r_d=phi_dot - params.k1_per_s * off + c * s_dot,
        gx=gx,
        gy=gy,
        y_e=y1,
        beta=ops.wrap(off + phi),
    )
