"""Tuning of keeping clear of foreign vessels. Metres, seconds, radians; found by simulation, see docs/colregs.md."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from fleet.guidance import FollowParams

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
Share = Annotated[float, Meta(ge=0.0, le=1.0)]


class ForeignParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Tuning of the law for foreign vessels."""

    # the domain
    margin_per_m: Positive = 0.4  # c as a share of the other's length
    margin_min_m: Positive = 6.0
    margin_max_m: Positive = 30.0
    own_m: Positive = 1.2  # half the own length
    beam_share: Positive = 0.1  # half the other's beam, as a share of its length
    half_share: Positive = 0.4  # half the core, as a share of its length
    bow_s: NotNegative = 10.0  # the core reaches ahead by its way in this time,
    bow_lengths: NotNegative = 3.0  # but no more lengths than this
    slow_mps: Positive = 0.3  # below it a course is unknown; up to
    slow_max_mps: Positive = 0.6  # when the velocity is uncertain
    vague_sigmas: NotNegative = 3.0  # standard deviations of the velocity above that, up to which a course is in doubt
    turn_s: NotNegative = 6.0  # of turning at its rate: the second guess of its velocity

    # times
    react_s: Positive = 4.0
    least_speed_mps: Positive = 0.5  # for the times; slower boats plan as if they went this fast
    give_way_s: Positive = 10.0  # T_gw = 2 T_need + this
    stand_on_s: Positive = 2.0  # T_so = 1.2 T_need + this
    stand_on_factor: Positive = 1.2
    horizon_factor: Positive = 1.5  # H = 1.5 T_gw
    period_s: Positive = 0.5
    opening_s: NotNegative = 4.0  # already inside a domain: judge from then on

    # when
    acting_factor: Positive = 1.1  # of C in every price
    clear_factor: Positive = 1.25  # of C on the path while acting: what is resumed is not given up again for noise
    near_m: Positive = 30.0  # at risk and this near: give way now
    confirm_s: Positive = 1.5
    urgent_s: Positive = 8.0
    clear_s: Positive = 6.0  # no risk while opening: past and clear; path clear: resume
    beside_s: Positive = 20.0  # the path's course clear beside the path: go on so
    review_s: Positive = 60.0  # an action is held no longer than this without being chosen again
    back_s: Positive = 120.0  # at most so much is added to the horizon for the way back to the path
    calm_s: Positive = 10.0  # no risk at all: past and clear where nothing was done
    turned_rad: Positive = 0.4363323129985824  # 25 deg: it has turned, classify again
    doubt_rad: NotNegative = 0.2617993877991494  # 15 deg: a course is so far wrong at most, for rule 14 c
    unsure_rad: Positive = 0.1  # one standard deviation of a course, above which a class is made anew at every look
    overtaking_miss_m: NotNegative = 4.0
    held_factor: Positive = 0.92
    held_bad_s: Positive = 1.0
    held_least_s: Positive = 5.0
    held_urgent_s: Positive = 4.0

    # prices
    turn: NotNegative = 2.0  # of (|a| / 180 deg)^2, |a| at most 200 deg
    slow: NotNegative = 1.5  # of (1 - f)^2
    port: NotNegative = 0.02
    round_turn: NotNegative = 10.0
    emergency: NotNegative = 8.0
    delay_s: Positive = 20.0
    worst: NotNegative = 100.0  # of the domain most violated
    each: NotNegative = 30.0  # of every one
    half: NotNegative = 300.0  # of the half domain
    hull: NotNegative = 1000.0
    half_radius: Share = 0.6  # of C
    hull_m: Positive = 3.2  # + half the other's beam
    wrong_side: NotNegative = 40.0  # where rule 14 or 15 asks for a side
    other_side: NotNegative = 10.0  # where either is right: not the one on which it would pass anyhow
    port_turn: NotNegative = 20.0  # forbidden by rules 14, 15, 17 c
    change: NotNegative = 0.3  # of |change of course| / pi while acting
    change_speed: NotNegative = 0.2
    flip: NotNegative = 2.0
    review_gain: NotNegative = 1.0  # what another action must be better by where the one held still keeps clear
    aground: NotNegative = 3000.0

    # mates that decide for themselves
    mate_m: Positive = 6.0
    mate_hull: Share = 0.6  # of mate_m
    mate_s: Positive = 20.0

    # banks
    bank_m: NotNegative = 2.0
    bank_s: NotNegative = 0.6
    ashore_m: NotNegative = 1.5  # nearer to an edge than this counts as aground

    # roll-outs and steering
    fine_s: Positive = 0.5
    fine_for_s: Positive = 10.0
    coarse_s: Positive = 4.0
    k1: Positive = 0.8  # gain on the course error [1/s]
    follow: FollowParams = FollowParams()  # how the boat follows its path

    # formations
    order_wait_s: NotNegative = 4.0  # a leader confirms for 1.5 s, decides, and is heard some messages later
    slot_m: Positive = 10.0  # farther out of its slot a boat decides for itself
    latency_s: NotNegative = 0.7  # from a leader's decision to sailing it
