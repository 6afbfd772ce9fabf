"""Speed and yaw-rate loops: from set-points and what the boat's sensors say to a surge force and a yaw moment.

Integral on the error, proportional on the measured speed itself, in steps:

    X += m (K_i (u_d - u) dt - K_p (u - u_before)) + drag(u) - drag(u_before)
    N += I (K_i (r_d - r) dt - K_p (r - r_before))

The memory is what the thrusters were really asked to give, after limits. So nothing winds up while they are saturated.
With the drag of the hull made up for, speed follows its set-point with the lag K_p / K_i.
"""

from __future__ import annotations

import math
from typing import Annotated

from msgspec import Meta, Struct

from fleet.guidance.thrust import Thrusters, Thrusts, allocate, resultant

NO_THRUST: Thrusts[float] = Thrusts(0.0, 0.0, 0.0, 0.0)


class LoopParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The boat and its gains; defaults are those of the simulated catamaran."""

    mass_kg: Annotated[float, Meta(gt=0.0, le=1e5)] = 60.0  # with added mass, surge
    inertia_kgm2: Annotated[float, Meta(gt=0.0, le=1e6)] = 12.0  # with added mass, yaw
    surge_p_per_s: Annotated[float, Meta(ge=0.0, le=20.0)] = 3.0
    surge_i_per_s2: Annotated[float, Meta(gt=0.0, le=20.0)] = 1.5
    yaw_p_per_s: Annotated[float, Meta(ge=0.0, le=20.0)] = 4.0
    yaw_i_per_s2: Annotated[float, Meta(gt=0.0, le=50.0)] = 9.0
    drag_kg_per_s: Annotated[float, Meta(ge=0.0, le=1e4)] = 15.0  # linear part of the drag along the hull
    drag_kg_per_m: Annotated[float, Meta(ge=0.0, le=1e4)] = 36.0  # quadratic part
    acceleration_max_mps2: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.3


class Loops(Struct, frozen=True, gc=False):
    """Memory: force [N] and moment [Nm] asked of the thrusters last, and the speeds measured then [m/s, rad/s]."""

    force: float = 0.0
    moment: float = 0.0
    u: float = 0.0
    r: float = 0.0


def drag(u: float, params: LoopParams) -> float:
    """Force that the water takes at a speed, + when ahead [N]."""
    return (params.drag_kg_per_s + params.drag_kg_per_m * abs(u)) * u


def begin(u: float, r: float, u_d: float, params: LoopParams) -> Loops:
    """Loops of a boat without thrust so far: with what keeps the slower of the speeds it has and is asked for."""
    slower = math.copysign(min(abs(u), abs(u_d)), u) if u * u_d > 0.0 else 0.0
    return Loops(drag(slower, params), 0.0, u, r)


def drive(
    loops: Loops, u_d: float, r_d: float, u: float, r: float, dt: float, params: LoopParams, thrusters: Thrusters
) -> tuple[Loops, Thrusts[float]]:
    """The thrusts for the next dt seconds.

    Args:
        loops: memory
        u_d, r_d: set-points: surge over ground [m/s], yaw rate, + to starboard [rad/s]
        u, r: measured [m/s, rad/s]
        dt: since the last call [s]
        params: boat and gains
        thrusters: their limits and arms
    """
    p, most = params, params.surge_p_per_s * params.acceleration_max_mps2
    e_u = min(max(p.surge_i_per_s2 * (u_d - u), -most), most)
    e_r = p.yaw_i_per_s2 * (r_d - r)
    force = loops.force + p.mass_kg * (e_u * dt - p.surge_p_per_s * (u - loops.u)) + drag(u, p) - drag(loops.u, p)
    moment = loops.moment + p.inertia_kgm2 * (e_r * dt - p.yaw_p_per_s * (r - loops.r))
    thrusts = allocate(force, moment, thrusters)
    force, moment = resultant(thrusts, thrusters)
    return Loops(force, moment, u, r), thrusts
