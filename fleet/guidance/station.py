"""Keeping station: hold a point against current and wind with a hull that can only go where its bow points.

Near the point the boat stops its way and keeps its heading. The current takes it down-stream; once outside the inner
radius it points back at the hold point, which is up-stream: so the bow comes up into the current by itself, and then
surge over ground zero is rest.
"""

from __future__ import annotations

from typing import Annotated, Generic

from msgspec import Meta, Struct

from fleet import ops
from fleet.guidance.limits import Limits
from fleet.ops import R


class StationParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Tuning of keeping station."""

    inner_m: Annotated[float, Meta(gt=0.0, le=20.0)] = 2.0  # within it the boat only stops
    soften_m: Annotated[float, Meta(gt=0.0, le=10.0)] = 1.0  # over this distance beyond it, steering sets in
    k_u_per_s: Annotated[float, Meta(gt=0.0, le=2.0)] = 0.3  # distance beyond the inner radius to speed
    k_psi_per_s: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.8  # heading error to yaw rate


class Station(Struct, Generic[R], frozen=True, gc=False):
    """What keeping station wants now."""

    u_d: R  # surge over ground along the heading [m/s]
    r_d: R  # yaw rate, + to starboard [rad/s]
    gx: R  # unit vector of the course wanted: to the hold point outside the inner radius, the heading inside
    gy: R


def keep_station(x: R, y: R, psi: R, x_h: R, y_h: R, limits: Limits, params: StationParams) -> Station[R]:
    """Surge and yaw rate that keep a boat near its hold point.

        u_d = k_u (d - inner) cos(e), within [0, u_max];  r_d = k_psi e, setting in beyond the inner radius

    with d the distance and e the angle from the heading to the bearing of the hold point.

    Args:
        x, y, psi: position [m] and heading [rad]
        x_h, y_h: hold point [m]
        limits: of the hull: top speed and yaw rate
        params: tuning
    """
    dx, dy = x_h - x, y_h - y
    d = ops.hypot(dx, dy)
    s, c = ops.sincos(psi)
    outside = d > params.inner_m
    per = 1.0 / ops.where(outside, d, 1.0)
    gx, gy = ops.where(outside, dx * per, c), ops.where(outside, dy * per, s)
    ahead = c * gx + s * gy
    excess = ops.maximum(d - params.inner_m, 0.0)
    onset = ops.minimum(excess / params.soften_m, 1.0)
    r_max = limits.yaw_rate_max_radps
    u_d = ops.minimum(params.k_u_per_s * excess, limits.speed_max_mps) * ops.maximum(ahead, 0.0)
    r_d = ops.clip(params.k_psi_per_s * onset * ops.atan2(c * gy - s * gx, ahead), -r_max, r_max)
    return Station(u_d, r_d, gx, gy)
