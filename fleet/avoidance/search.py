"""The least dear of the candidate velocities."""

from __future__ import annotations

from functools import lru_cache
from typing import Generic, NamedTuple

from msgspec import Struct

from fleet import ops
from fleet.avoidance.cost import Beside, Threat, legs, price_on_legs, price_straight, sweep_price
from fleet.avoidance.params import ScoringParams
from fleet.avoidance.types import Own
from fleet.ops import R

_NONE_YET = 1e300


class Choice(Struct, Generic[R], frozen=True, gc=False):
    """A decided velocity."""

    cx: R  # unit vector of the course
    cy: R
    factor: R  # of the wanted speed
    steers: R  # 1 the course is off the wanted one


class Stance(Struct, Generic[R], frozen=True, gc=False):
    """What the boat is at when it decides: part of the price of a candidate."""

    turned: R  # wanted course minus the course decided last, in [-pi, pi] [rad]
    avoiding: R  # 1 the last decision left the plan: changing the mind then has a price
    yielding: R  # 1 only candidates of half speed and less
    waiting: R  # 1 it is time to yield to a companion: going faster than a quarter of the speed wanted has a price
    ex: R  # unit vector of the own course
    ey: R
    beside: tuple[Beside[R], ...]  # vehicles through whose bearings turning has a price


class Candidate(NamedTuple):
    """A velocity to try, relative to the plan."""

    price: float  # for leaving the plan, apart from changing the mind
    cos_a: float  # of the course offset
    sin_a: float
    a: float  # [rad]
    factor: float
    place: int  # of its course among all courses


@lru_cache(maxsize=64)
def candidates(params: ScoringParams) -> tuple[Candidate, ...]:
    """All candidates, the cheapest first; among equals from port to starboard, the faster first."""
    steps = int((params.course_port_deg + params.course_starboard_deg) / params.course_step_deg + 1e-9) + 1
    table = []
    for place in range(steps):
        a = (-params.course_port_deg + place * params.course_step_deg) * (ops.PI / 180.0)
        sin_a, cos_a = ops.sincos(a)
        turn = params.turn_per_rad2 * a * a + (params.port_per_rad * -a if a < 0.0 else 0.0)
        for factor in params.factors:
            slow = params.slow * (1.0 - factor) * (1.0 - factor)
            table.append(Candidate(turn + slow, cos_a, sin_a, a, factor, place))
    return tuple(sorted(table, key=lambda each: each.price))


def speed_of(u_d: R, factor: R | float, u_min: float, params: ScoringParams) -> R:
    """max(f max(u_d, 0.3), u_min) [m/s]."""
    return ops.maximum(factor * ops.maximum(u_d, params.least_cruise_mps), u_min)


def back_of(own: Own[R], cx: R, cy: R, params: ScoringParams) -> R:
    """Price of going back along the path on course (cx, cy) at the speed wanted: 1.5 max(0, -cos(theta - chi_p))."""
    return params.back * ops.maximum(-(cx * own.tx + cy * own.ty), 0.0)


def change_of(stance: Stance[R], a: R | float, cx: R, cy: R, params: ScoringParams) -> R:
    """Price of changing the mind to course (cx, cy), a off the wanted one, and of what lies in the way of the turn."""
    change = stance.avoiding * (params.change_per_rad * abs(ops.wrap(stance.turned + a)))
    return change + sweep_price(stance.ex, stance.ey, cx, cy, stance.beside)


def search(
    own: Own[R], threats: tuple[Threat[R], ...], stance: Stance[R], u_min: float, params: ScoringParams
) -> Choice[R]:
    """The candidate of least price; of equals the one that leaves the plan least.

    Args:
        u_min: slowest speed under way [m/s]
    """
    if type(own.x) is not float:
        from fleet.avoidance import search_lanes

        return search_lanes.search(own, threats, stance, u_min, params)
    least = ops.full(own.x, _NONE_YET)
    best = Choice(own.gx, own.gy, ops.full(own.x, 1.0), ops.zero(own.x))
    courses: dict[int, tuple[R, R, R, R]] = {}
    speeds: dict[float, R] = {}
    for each in candidates(params):
        if ops.every(least <= each.price):
            break
        if each.place not in courses:
            cx, cy = own.gx * each.cos_a - own.gy * each.sin_a, own.gx * each.sin_a + own.gy * each.cos_a
            courses[each.place] = (
                cx,
                cy,
                change_of(stance, each.a, cx, cy, params),
                back_of(own, cx, cy, params),
            )
        cx, cy, change, back = courses[each.place]
        own_price = each.price + change + each.factor * back
        if each.factor > params.yield_companion_factor:
            own_price = own_price + params.hurry * stance.waiting
        held_back = (stance.yielding == 1.0) & (each.factor > params.yield_other_factor)
        if ops.every((least <= own_price) | held_back):
            continue
        if each.factor not in speeds:
            speeds[each.factor] = speed_of(own.u_d, each.factor, u_min, params)
        u = speeds[each.factor]
        if each.a == 0.0:
            price = price_on_legs(own_price, legs(own, u), threats, least, params)
        else:
            price = price_straight(own_price, u * cx, u * cy, threats, least, params)
        better = (price < least) & ops.no(held_back)
        if ops.some(better):
            least = ops.where(better, price, least)
            best = Choice(
                ops.where(better, cx, best.cx),
                ops.where(better, cy, best.cy),
                ops.where(better, each.factor, best.factor),
                ops.where(better, 0.0 if each.a == 0.0 else 1.0, best.steers),
            )
    return best
