"""A catamaran of 2 m with two rear and two side thrusters, after VIAM-USV2000, in surge, sway and yaw.

    m11 u_dot = X + m22 v r + (X_u + X_uu |u|) u
    m22 v_dot = -m11 u r + (Y_v + Y_vv |v|) v
    m33 r_dot = N - (m22 - m11) u v + (N_r + N_rr |r|) r

with u, v the velocity through the water (moved by current and leeway). Tran et al., Machines 2021, 9, 133, print the
thrusters (`fleet.guidance.thrust`) and a radius of turning of 4 m, but no masses and no damping. Those here are derived
from the size: 55 kg afloat and 9 to 36 % of added mass; sway and yaw die out in 0.8 and 0.6 s; full thrust gives
2.5 m/s. So derived the boat turns tighter than the printed 4 m.

Under plain set-points its inner loops are ours: integral on the error, proportional on the speed itself,

    X_dot = m11 (K_i (u_d - u) - K_p u_dot) - drag_dot,  N_dot = m33 (K_i (r_d - r) - K_p r_dot)

allocated to the thrusters, yaw first, each within its limits and its rate. Force and moment really given are the memory
of these loops (`i_u`, per mass; `i_r`, per inertia), so nothing winds up. Kept as two numbers, the thrusts behind them
are always as `allocate` shares them; the simulated controller, which is told thrusts, keeps all four (`push`).
"""

from __future__ import annotations

from fleet import ops
from fleet.guidance.limits import Limits
from fleet.guidance.thrust import Thrusters, allocate, resultant, slew
from fleet.hulls.types import HullState, Water
from fleet.ops import R

__all__ = ["THRUSTERS", "advance", "advance_by", "description", "push", "start", "velocity"]

description = "catamaran of 2 m after VIAM-USV2000: surge, sway and yaw, two rear and two side thrusters, goes astern"

THRUSTERS = Thrusters()
M11, M22, M33 = 60.0, 75.0, 12.0  # with added mass [kg, kg, kg m2]
X_U, Y_V, N_R = -15.0, -90.0, -20.0  # [kg/s, kg/s, kg m2/s]
X_UU, Y_VV, N_RR = -36.0, -150.0, -10.0  # [kg/m, kg/m, kg m2]
_K_U, _I_U = 3.0, 1.5  # surge loop: lag K/I = 2 s [1/s, 1/s2]
_K_R, _I_R = 4.0, 9.0  # yaw loop: lag with the hull's own damping 0.6 s [1/s, 1/s2]


def start(x: float, y: float, psi: float, u: float) -> HullState[float]:
    """A boat on its course, at speed u, with the thrust that keeps it."""
    u = float(u)
    return HullState(float(x), float(y), float(psi), u, 0.0, 0.0, -drag(u) / M11, 0.0)


def velocity(state: HullState[R], water: Water[R]) -> tuple[R, R]:  # noqa: ARG001 - the state moves over ground
    """(vx, vy): velocity over ground, north and east [m/s]."""
    s, c = ops.sincos(state.psi)
    return state.u * c - state.v * s, state.u * s + state.v * c


def drag(u: R) -> R:
    """Force of the water along the hull at a speed through it, against it [N]."""
    return (X_U + X_UU * abs(u)) * u


def push(state: HullState[R], surge: R, yaw: R, water: Water[R], dt: float) -> HullState[R]:
    """The boat dt seconds later under a force along the hull [N] and a yaw moment [Nm]; no loops."""
    dn, de = water.current_n + water.wind_n, water.current_e + water.wind_e
    s, c = ops.sincos(state.psi + 0.5 * dt * state.r)
    u_c, v_c = dn * c + de * s, de * c - dn * s
    u, v, r = state.u - u_c, state.v - v_c, state.r
    u_dot = (surge + M22 * v * r + drag(u)) / M11
    v_dot = (-M11 * u * r + (Y_V + Y_VV * abs(v)) * v) / M22
    r_dot = (yaw - (M22 - M11) * u * v + (N_R + N_RR * abs(r)) * r) / M33
    surge_after = state.u + dt * (u_dot + r * v_c)  # a steady current turns in the frame of the body
    sway_after = state.v + dt * (v_dot - r * u_c)
    r_after = r + dt * r_dot
    return HullState(
        x=state.x + dt * (surge_after * c - sway_after * s),
        y=state.y + dt * (surge_after * s + sway_after * c),
        psi=ops.wrap(state.psi + dt * r_after),
        u=surge_after,
        v=sway_after,
        r=r_after,
        i_u=state.i_u,
        i_r=state.i_r,
    )


def advance(
    state: HullState[R], u_d: R, r_d: R, water: Water[R], limits: Limits, dt: float, powered: R | float = 1.0
) -> HullState[R]:
    """The boat dt seconds later; without power (powered 0) it has no thrust, and its loops begin anew."""
    u_max, r_max, a_max = limits.speed_max_mps, limits.yaw_rate_max_radps, limits.acceleration_max_mps2
    given = allocate(M11 * state.i_u, M33 * state.i_r, THRUSTERS)
    force, moment = resultant(given, THRUSTERS)
    after = push(state, powered * force, powered * moment, water, dt)
    e_u = ops.clip(_I_U * (ops.clip(u_d, -u_max, u_max) - state.u), -_K_U * a_max, _K_U * a_max)
    e_r = _I_R * (ops.clip(r_d, -r_max, r_max) - state.r)
    wanted = allocate(
        force + M11 * (dt * e_u - _K_U * (after.u - state.u)) - (drag(after.u) - drag(state.u)),
        moment + M33 * (dt * e_r - _K_R * (after.r - state.r)),
        THRUSTERS,
    )
    force, moment = resultant(slew(given, wanted, THRUSTERS, dt), THRUSTERS)
    return HullState(
        x=after.x,
        y=after.y,
        psi=after.psi,
        u=after.u,
        v=after.v,
        r=after.r,
        i_u=powered * force / M11,
        i_r=powered * moment / M33,
    )


def advance_by(
    steps: int, state: HullState[R], u_d: R, r_d: R, water: Water[R], limits: Limits, dt: float, powered: R | float
) -> HullState[R]:
    """`steps` times `advance`."""
    for _ in range(steps):
        state = advance(state, u_d, r_d, water, limits, dt, powered)
    return state
