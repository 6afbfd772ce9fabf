"""The Maritime Robotics Otter, a catamaran of 2 m and two propellers, in surge, sway and yaw.

    M nu_r_dot + C(nu_r) nu_r + D(nu_r) nu_r = tau

with nu_r the velocity through the water (moved by current and leeway). Figures: T. I. Fossen, Marine Systems Simulator
(MSS), `otter.m`, revision of 2024: hull 55 kg with 25 kg of payload amidships, Munk moment kept; cross-flow drag of one
pontoon by strips there, here its sway and yaw alone (the coupling of both is left out). Top speed 3.1 m/s, so 1.5 m/s
is well covered; the propellers turn it at 0.30 (stopped) to 0.33 rad/s at most, and then leave 1.25 m/s of speed.
Its inner loops are ours: PI on surge over ground and on yaw rate, yaw served first when thrust runs out.
"""

from __future__ import annotations

from fleet import ops
from fleet.guidance.limits import Limits
from fleet.hulls.types import HullState, Water, start
from fleet.ops import R

__all__ = ["advance", "advance_by", "description", "start", "velocity"]

description = "Otter catamaran of 2 m (Fossen, MSS): surge, sway and yaw with two propellers and PI inner loops"

_G, _RHO, _LENGTH = 9.81, 1025.0, 2.0
_HULL, _PAYLOAD = 55.0, 25.0  # [kg]
_MASS = _HULL + _PAYLOAD
_XG = _HULL * 0.2 / _MASS  # centre of gravity ahead of amidships [m]
_IZ = _HULL * (0.25 * _LENGTH) * (0.25 * _LENGTH) + _HULL * _XG * _XG  # [kg m2]
_X_UDOT, _Y_VDOT, _N_RDOT = -5.29, -1.5 * _HULL, -1.7 * _IZ  # added mass; surge by Soeding's formula [kg, kg, kg m2]
_M11, _M22, _M23 = _MASS - _X_UDOT, _MASS - _Y_VDOT, _MASS * _XG
_M33 = _IZ + _MASS * _XG * _XG - _N_RDOT
_DET = _M22 * _M33 - _M23 * _M23
_X_U = -24.4 * _G / (6.0 * 0.5144)  # full thrust gives 6 knots [kg/s]
_Y_V, _N_R = -_M22 / 1.0, -_M33 / 1.0  # time constants of 1 s [kg/s, kg m2/s]
_N_RR = 10.0 * _N_R  # [kg m2]
_DRAUGHT = _MASS / _RHO / (2.0 * 0.4 * 0.25 * _LENGTH)  # block coefficient 0.4, beam of a pontoon 0.25 m [m]
_CROSS = 0.5 * _RHO * _DRAUGHT * 1.004  # Hoerner's coefficient for beam / (2 draught) = 0.64 [kg/m2]
_Y_VV = -_CROSS * _LENGTH  # [kg/m]
_N_CROSS = -_CROSS * _LENGTH * _LENGTH * _LENGTH * _LENGTH / 32.0  # integral of |x| x^2 along the hull [kg m2]
_THRUST_MAX, _THRUST_MIN = 0.5 * 24.4 * _G, -0.5 * 13.6 * _G  # of one propeller, bollard [N]
_ARM = 0.395  # of a propeller [m]
_MOMENT_MAX = -2.0 * _ARM * _THRUST_MIN  # [Nm]
_K_U, _I_U = 1.0, 0.2  # surge loop [1/s, 1/s2]
_K_R, _I_R = 2.0, 1.0  # yaw loop [1/s, 1/s2]
_I_U_MAX, _I_R_MAX = 0.3, 0.6  # the integrals stay within [m/s2, rad/s2]


def velocity(state: HullState[R], water: Water[R]) -> tuple[R, R]:  # noqa: ARG001 - the state moves over ground
    """(vx, vy): velocity over ground, north and east [m/s]."""
    s, c = ops.sincos(state.psi)
    return state.u * c - state.v * s, state.u * s + state.v * c


def propel(surge: R, yaw: R) -> tuple[R, R]:
    """(X, N) that two propellers give of the force [N] and moment [Nm] asked for.

    The moment is served first, up to what one propeller balances astern: a harder turn would push the boat ahead.
    """
    moment = ops.clip(yaw, -_MOMENT_MAX, _MOMENT_MAX)
    half = abs(moment) * (0.5 / _ARM)
    return 2.0 * ops.clip(0.5 * surge, _THRUST_MIN + half, _THRUST_MAX - half), moment


def accelerations(u: R, v: R, r: R, surge: R, yaw: R) -> tuple[R, R, R]:
    """(u_dot, v_dot, r_dot) of velocities through the water under a force [N] and a moment [Nm]."""
    sideways = _M22 * v + _M23 * r
    x = surge + _X_U * u + sideways * r
    y = (_Y_V + _Y_VV * abs(v)) * v - _M11 * u * r
    n = yaw + (_N_R + (_N_RR + _N_CROSS) * abs(r)) * r - sideways * u + _M11 * u * v
    return x / _M11, (_M33 * y - _M23 * n) / _DET, (_M22 * n - _M23 * y) / _DET


def advance(
    state: HullState[R], u_d: R, r_d: R, water: Water[R], limits: Limits, dt: float, powered: R | float = 1.0
) -> HullState[R]:
    """The boat dt seconds later; without power (powered 0) it has no thrust and its integrals are emptied."""
    u_max, r_max, a_max = limits.speed_max_mps, limits.yaw_rate_max_radps, limits.acceleration_max_mps2
    dn, de = water.current_n + water.wind_n, water.current_e + water.wind_e
    s, c = ops.sincos(state.psi + 0.5 * dt * state.r)
    u_c, v_c = dn * c + de * s, de * c - dn * s
    u_r, v_r = state.u - u_c, state.v - v_c

    e_u = ops.clip(u_d, -u_max, u_max) - state.u
    e_r = ops.clip(r_d, -r_max, r_max) - state.r
    push = _M11 * (ops.clip(_K_U * e_u, -a_max, a_max) + state.i_u) - _X_U * u_r
    turn = _M33 * (_K_R * e_r + state.i_r) - (_N_R + _N_RR * abs(state.r)) * state.r
    force, moment = propel(push, turn)
    force, moment = powered * force, powered * moment
    # an integral waits while the error is large, or while its propellers cannot follow and it would only ask for more
    grow_u = ops.where((abs(e_u) < 0.3) & ((abs(force - push) < 1e-6) | (e_u * push < 0.0)), e_u, 0.0)
    grow_r = ops.where((abs(e_r) < 0.1) & ((abs(moment - turn) < 1e-6) | (e_r * turn < 0.0)), e_r, 0.0)
    i_u = powered * ops.clip(state.i_u + dt * _I_U * grow_u, -_I_U_MAX, _I_U_MAX)
    i_r = powered * ops.clip(state.i_r + dt * _I_R * grow_r, -_I_R_MAX, _I_R_MAX)

    u_dot, v_dot, r_dot = accelerations(u_r, v_r, state.r, force, moment)
    u = state.u + dt * (u_dot + state.r * v_c)  # a steady current turns in the frame of the body
    v = state.v + dt * (v_dot - state.r * u_c)
    r = state.r + dt * r_dot
    return HullState(
        x=state.x + dt * (u * c - v * s),
        y=state.y + dt * (u * s + v * c),
        psi=ops.wrap(state.psi + dt * r),
        u=u,
        v=v,
        r=r,
        i_u=i_u,
        i_r=i_r,
    )


def advance_by(
    steps: int, state: HullState[R], u_d: R, r_d: R, water: Water[R], limits: Limits, dt: float, powered: R | float
) -> HullState[R]:
    """`steps` times `advance`."""
    for _ in range(steps):
        state = advance(state, u_d, r_d, water, limits, dt, powered)
    return state
