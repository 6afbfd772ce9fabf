"""The reference hull: goes where its bow points, with lags in surge and yaw; water and wind carry it sideways.

Its own controller achieves surge over ground, so a current ahead or astern costs nothing and one abeam sets it down.
"""

from __future__ import annotations

from typing import Any

from fleet import ops
from fleet.guidance.limits import Limits
from fleet.hulls.types import HullState, Water, start
from fleet.ops import R

__all__ = ["advance", "advance_by", "description", "start", "velocity"]

description = "unicycle with first-order lags in surge and yaw rate; drifts across its heading with current and wind"


def velocity(state: HullState[R], water: Water[R]) -> tuple[R, R]:
    """(vx, vy): velocity over ground, north and east [m/s]."""
    s, c = ops.sincos(state.psi)
    v = (water.current_e + water.wind_e) * c - (water.current_n + water.wind_n) * s
    return state.u * c - v * s, state.u * s + v * c


def advance(
    state: HullState[R], u_d: R, r_d: R, water: Water[R], limits: Limits, dt: float, powered: R | float = 1.0
) -> HullState[R]:
    """The boat dt seconds later.

        u_dot = (u_d - u) / T_u within +-a_max,  r_dot = (r_d - r) / T_r

    Without power (powered 0) u_d is the drift along the heading and r_d is zero: the boat coasts to rest in the water.
    """
    dn, de = water.current_n + water.wind_n, water.current_e + water.wind_e
    u_max, r_max, a_max = limits.speed_max_mps, limits.yaw_rate_max_radps, limits.acceleration_max_mps2
    driven = _is(powered, 1.0)
    r_aim, u_aim = ops.clip(r_d, -r_max, r_max), ops.clip(u_d, -u_max, u_max)
    r = state.r + dt * (((r_aim if driven else powered * r_aim) - state.r) / limits.yaw_lag_s)
    s, c = ops.sincos(state.psi + 0.5 * dt * r)  # heading at the middle of the step
    if not driven:
        u_aim = powered * u_aim + (1.0 - powered) * (dn * c + de * s)
    u = state.u + dt * ops.clip((u_aim - state.u) / limits.surge_lag_s, -a_max, a_max)
    vx, vy, v = u * c, u * s, ops.zero(u)
    if not (_is(dn, 0.0) and _is(de, 0.0)):
        v = de * c - dn * s
        vx, vy = vx - v * s, vy + v * c
    return HullState(
        x=state.x + dt * vx,
        y=state.y + dt * vy,
        psi=ops.wrap(state.psi + dt * r),
        u=u,
        v=v,
        r=r,
        i_u=state.i_u,
        i_r=state.i_r,
    )


def advance_by(
    steps: int, state: HullState[Any], u_d: Any, r_d: Any, water: Water[Any], limits: Limits, dt: float, powered: Any
) -> HullState[Any]:
    """`steps` times `advance`, with equal bits.

    Neither surge nor yaw rate hang on the heading while there is power: lanes then take all sines and cosines at once.
    """
    if type(state.x) is float or not _is(powered, 1.0):
        for _ in range(steps):
            state = advance(state, u_d, r_d, water, limits, dt, powered)
        return state
    import numpy as np

    u_max, r_max, a_max = limits.speed_max_mps, limits.yaw_rate_max_radps, limits.acceleration_max_mps2
    r_aim, u_aim = ops.clip(r_d, -r_max, r_max), ops.clip(u_d, -u_max, u_max)
    x, y, psi, u, r = state.x, state.y, state.psi, state.u, state.r
    middle, surge = np.empty((steps, len(psi))), np.empty((steps, len(psi)))
    for k in range(steps):
        r = r + dt * ((r_aim - r) / limits.yaw_lag_s)
        middle[k] = psi + 0.5 * dt * r
        u = surge[k] = u + dt * ops.clip((u_aim - u) / limits.surge_lag_s, -a_max, a_max)
        psi = ops.wrap(psi + dt * r)
    s, c = ops.sincos(middle)
    v = ops.zero(u)
    vx, vy = surge * c, surge * s
    dn, de = water.current_n + water.wind_n, water.current_e + water.wind_e
    if not (_is(dn, 0.0) and _is(de, 0.0)):
        drift = de * c - dn * s
        vx, vy, v = vx - drift * s, vy + drift * c, drift[-1]
    for north, east in zip(dt * vx, dt * vy, strict=True):
        x, y = x + north, y + east
    return HullState(x=x, y=y, psi=psi, u=u, v=v, r=r, i_u=state.i_u, i_r=state.i_r)


def _is(value: Any, number: float) -> bool:
    """It is one number for all lanes, and this one: what then adds 0 or is multiplied by 1 is left out."""
    return type(value) is float and value == number
