"""Tuning of velocity scoring. Lengths are those of a safety radius of 6 m and a hull of 2.4 m; angles in radians.

Every figure was found on families of simulated encounters (two to 32 boats, unicycle with a surge lag of 2 s, a yaw lag
of 0.6 s, 0.35 rad/s, 0.3 m/s2), each boat running this law; none comes from a rule book.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

from msgspec import Meta, Struct, structs

REFERENCE_RADIUS_M = 6.0

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
Share = Annotated[float, Meta(ge=0.0, le=1.0)]


class ScoringParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Tuning of velocity scoring."""

    # distances kept, between centres [m]; `for_radius` scales them
    wanted_m: Positive = 7.5  # R_s, 1.25 R
    companion_m: Positive = 6.5  # R_c, kept from boats with the same plan
    hard_m: Positive = 3.5  # R_h, below it a collision is near
    brake_m: Positive = 3.2  # D_sh, between the stopping segments
    hysteresis_m: NotNegative = 0.7  # the plan must miss by this much more before an avoidance ends

    stand_on_share: Share = 0.92  # of R_s: the boat that must give way moves first
    # standard deviations of the relative position that are added
    wanted_sigmas: NotNegative = 2.5  # to R_s
    sigmas: NotNegative = 2.0  # to R_c
    hard_sigmas: NotNegative = 2.0  # to R_h
    brake_sigmas: NotNegative = 3.0  # to D_sh
    least_cruise_mps: Positive = 0.3  # a boat that wants to go slower is judged as if it went this fast

    # how far ahead to look [s]
    horizon_max_s: Positive = 150.0
    horizon_min_s: Positive = 30.0
    horizon_unknown_s: Positive = 60.0  # for a vehicle that publishes no plan
    opening_s: NotNegative = 3.0  # t0: when already inside the radius, judge where we are after this time
    late_s: NotNegative = 15.0  # a peer this near in time may be left to starboard

    # boats with the same plan: difference of plan velocities, as a share of the faster; range [m]
    companion_share: Share = 0.15
    companion_leave_share: Share = 0.30
    companion_range_m: Positive = 30.0
    companion_leave_range_m: Positive = 39.0

    # boats that sail one decision about a foreign vessel keep the hard radius, and look only so far ahead
    together_s: Positive = 12.0

    # two boats that hold each other off their paths, side by side
    escort_speed_mps: Positive = 0.25  # relative speed below which they escort each other
    escort_ahead_rad: Positive = 0.35  # a peer nearer to the bow than this is no escort
    escort_astern_rad: Positive = 2.9
    held_off_rad: Positive = 0.17  # course this far off the wanted one: held off
    escort_companion_s: Positive = 20.0
    escort_other_s: Positive = 45.0
    yield_s: Positive = 10.0
    yield_companion_factor: Share = 0.25  # to a companion: going faster than this has a price, `hurry`
    yield_other_factor: Share = 0.5  # to another: only factors up to this one are candidates

    # candidates: courses about the wanted one, speed factors
    course_port_deg: Positive = 120.0
    course_starboard_deg: Positive = 180.0
    course_step_deg: Positive = 7.5
    factors: tuple[float, ...] = (1.0, 0.75, 0.5, 0.25, 0.0)

    # prices
    collision: NotNegative = 30.0
    crowd: NotNegative = 0.3  # of the sum over the peers, beside the worst of them
    hard: NotNegative = 4.0
    wrong_side: NotNegative = 3.0
    turn_per_rad2: NotNegative = 0.24
    port_per_rad: NotNegative = 0.15
    slow: NotNegative = 2.7
    sweep: NotNegative = 12.0  # of turning through the bearing of a vehicle as near as the turning circle is broad
    hurry: NotNegative = 6.0  # of going on while it is time to yield to a companion
    back: NotNegative = 1.5  # of going straight back along the path at the speed wanted
    turn_beside_per_rad2: NotNegative = 0.4052847345693511  # 4 / pi^2, while a boat near is bound the same way
    slow_beside: NotNegative = 1.8
    change_per_rad: NotNegative = 0.3
    decay: Share = 0.7  # of the collision price at the horizon
    decay_hard: Share = 0.5
    free: NotNegative = 1e-9  # a plan below this price is taken

    period_s: Positive = 0.5  # Tc
    k1: Positive = 0.8  # gain on the course error while steering off the plan [1/s]

    # the last-moment brake
    reaction_s: NotNegative = 0.2
    brake_gain_m: NotNegative = 0.02  # advancing must bring it nearer by this much
    brake_samples: Annotated[int, Meta(ge=2)] = 7


@lru_cache(maxsize=64)
def beside(params: ScoringParams) -> ScoringParams:
    """The same with the prices that hold while a boat near is bound the same way."""
    return structs.replace(params, turn_per_rad2=params.turn_beside_per_rad2, slow=params.slow_beside)


def for_radius(radius_m: float) -> ScoringParams:
    """The defaults with every radius scaled to the mission's safety radius R [m] (they belong to 6 m)."""
    scale = radius_m / REFERENCE_RADIUS_M
    base = ScoringParams()
    return ScoringParams(
        wanted_m=base.wanted_m * scale,
        companion_m=base.companion_m * scale,
        hard_m=base.hard_m * scale,
        brake_m=base.brake_m * scale,
        hysteresis_m=base.hysteresis_m * scale,
    )
