"""The water around a foreign vessel that is kept free, and how near a way comes to it.

The core of the domain is a segment on the vessel's course, from -0.4 L to +0.4 L and a bow zone ahead. Clear means a
distance from the own centre to the core of at least C, which grows with the uncertainty of the track.
"""

from __future__ import annotations

from msgspec import Struct

from fleet import ops
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.types import TargetLike
from fleet.ops import R


class Guess(Struct, frozen=True, gc=False):
    """One hypothesis of how the vessel moves on."""

    vx: float  # [m/s]
    vy: float
    ex: float  # unit vector of its course
    ey: float


class Domain(Struct, frozen=True, gc=False):
    """A vessel and the water around it, now."""

    number: float
    x: float
    y: float
    guesses: tuple[Guess, ...]  # the present velocity, and the turned one where it turns
    U: float  # speed [m/s]
    slow: float  # 1 its course is unknown: the core is a point
    astern: float  # the core's ends on the course, from its centre [m]
    ahead: float
    half: float  # ends of the core without the bow zone [m]
    C: float  # clearance now [m]
    grow: float  # sigma_v: how fast C grows [m/s]
    most: float  # and by how much at most [m]
    hull: float  # radius about the half core within which hulls may touch [m]
    sigma_v: float  # [m/s]
    sigma_p: float  # [m]
    T_gw: float  # time before entry at which a give-way boat acts [s]
    T_so: float  # time before entry at which a stand-on boat acts [s]
    H: float  # how far ahead it is looked at [s]
    vague: float = 0.0  # by how much its course is unknown, 0 to 1; 1 where it is slow


def domain(target: TargetLike, cruise: float, extent: float, params: ForeignParams) -> Domain:
    """The domain of a vessel for boats at that cruise speed [m/s].

        c = clip(0.4 L, 6, 30);  C0 = 1.2 + 0.1 L + c;  C = C0 + min(sigma_p, 0.5 c)
        T_need = 4 + (C + extent) / u_c;  T_gw = 2 T_need + 10;  T_so = 1.2 T_need + 2;  H = 1.5 T_gw

    Args:
        extent: half the largest distance between boats of the formation, 0 alone [m]
    """
    L, vx, vy = target.length, target.vx, target.vy
    U = ops.hypot(vx, vy)
    sigma_p, sigma_v = ops.sqrt(target.P11), ops.sqrt(target.P22)
    slow_below = ops.maximum(params.slow_mps, ops.minimum(params.slow_max_mps, 2.0 * sigma_v))
    slow = slow_below > U
    c = ops.clip(params.margin_per_m * L, params.margin_min_m, params.margin_max_m)
    blur = ops.minimum(sigma_p, 0.5 * c)
    vague = _vague(U, slow_below, sigma_v, params)
    half, round_it = (1.0 - vague) * params.half_share * L, vague * params.half_share * L
    C = params.own_m + params.beam_share * L + c + round_it + blur
    T_need = params.react_s + (C + extent) / ops.maximum(cruise, params.least_speed_mps)
    T_gw = 2.0 * T_need + params.give_way_s
    return Domain(
        number=target.number,
        x=target.x,
        y=target.y,
        guesses=_guesses(target, U, slow, 1.0 - vague * _noise(U, sigma_v), params),
        U=U,
        slow=1.0 if slow else 0.0,
        astern=-half,
        ahead=half + (1.0 - vague) * ops.minimum(params.bow_s * U, params.bow_lengths * L),
        half=half,
        C=C,
        grow=sigma_v,
        most=0.5 * c - blur,
        hull=params.hull_m + params.beam_share * L + round_it,
        sigma_v=sigma_v,
        sigma_p=sigma_p,
        T_gw=T_gw,
        T_so=params.stand_on_factor * T_need + params.stand_on_s,
        H=params.horizon_factor * T_gw,
        vague=vague,
    )


def _vague(U: float, slow_below: float, sigma_v: float, params: ForeignParams) -> float:
    """1 below the speed at which a course is known, 0 three standard deviations above it, and between them in between.

    A vessel of about that speed would otherwise have a large round domain at one look and a narrow one at the next.
    """
    if slow_below > U:
        return 1.0
    fade = params.vague_sigmas * sigma_v
    return ops.maximum(1.0 - (U - slow_below) / fade, 0.0) if fade > 0.0 else 0.0


def _noise(U: float, sigma_v: float) -> float:
    """How much of a velocity is likely to be noise: 2 sigma_v^2 / (U^2 + 2 sigma_v^2)."""
    noise = 2.0 * sigma_v * sigma_v
    return noise / (U * U + noise) if noise > 0.0 else 0.0


def _guesses(target: TargetLike, U: float, slow: bool, share: float, params: ForeignParams) -> tuple[Guess, ...]:
    """Straight on, and where it turns also by its turn rate times 6 s.

    Args:
        share: of its velocity that is believed; one that lies still would otherwise wander off by its noise
    """
    vx, vy = target.vx, target.vy
    if U <= 0.0:
        return (Guess(0.0, 0.0, 1.0, 0.0),)
    straight = Guess(share * vx, share * vy, vx / U, vy / U)
    if target.om == 0.0 or slow:
        return (straight,)
    s, c = ops.sincos(target.om * params.turn_s)
    tx, ty = vx * c - vy * s, vx * s + vy * c
    return straight, Guess(share * tx, share * ty, tx / U, ty / U)


def clearance(d: Domain, t: R, growth: float = 1.0) -> R:
    """C(t) = C + min(sigma_v t, what is left of 0.5 c): the clearance t seconds ahead [m]."""
    return d.C + growth * ops.minimum(d.grow * t, d.most)


def gap(x0: R, y0: R, x1: R, y1: R, low: R | float, high: R | float) -> tuple[R, R]:
    """(least distance, where): of the leg from (x0, y0) to (x1, y1) to the segment [low, high] of the x axis [m].

    The distance to a segment is convex along a leg, so the least one is at an end of the leg, abreast of an end of the
    segment, or where the leg crosses the axis. `where` is the share of the leg in [0, 1].
    """
    dx, dy = x1 - x0, y1 - y0
    length_sq = dx * dx + dy * dy
    per = 1.0 / ops.where(length_sq > 0.0, length_sq, 1.0)
    level = dy * dy > 0.0
    crossing = ops.clip(-y0 / ops.where(level, dy, 1.0), 0.0, 1.0)
    best, where = _square(x0, y0, low, high), ops.zero(x0)
    for share in (
        ops.clip(((low - x0) * dx - y0 * dy) * per, 0.0, 1.0),
        ops.clip(((high - x0) * dx - y0 * dy) * per, 0.0, 1.0),
        crossing,
    ):
        here = _square(x0 + share * dx, y0 + share * dy, low, high)
        nearer = here < best
        best, where = ops.where(nearer, here, best), ops.where(nearer, share, where)
    last = _square(x1, y1, low, high)
    nearer = last < best
    return ops.sqrt(ops.where(nearer, last, best)), ops.where(nearer, 1.0, where)


def _square(x: R, y: R, low: R | float, high: R | float) -> R:
    """Squared distance of a point to the segment [low, high] of the x axis [m2]."""
    over = x - ops.clip(x, low, high)
    return over * over + y * y
