"""What a velocity costs: how near it comes to each vehicle, when, and on which side.

All terms are >= 0 and rounding is monotone, so a sum over peers may be left as soon as it is enough, and a peer that
adds 0 may be left out: no bit changes.
"""

from __future__ import annotations

from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.avoidance.pair import Judged, View
from fleet.avoidance.params import ScoringParams
from fleet.avoidance.types import Own, Peer
from fleet.ops import R

_UNDER_WAY_MPS = 0.05  # slower than this a boat does not get back to its path
_NEVER_S = 1e9


class Threat(Struct, Generic[R], frozen=True, gc=False):
    """One vehicle, with everything that is the same for all candidate velocities."""

    number: R
    dx: R  # from own, north [m]
    dy: R
    vx: R  # its velocity [m/s]
    vy: R
    side: R  # +1 to be left to port, -1 to starboard, 0 open
    horizon: R  # H_j [s]
    radius: R  # R_j [m]
    radius_sq: R
    t0: R  # first moment that counts [s]: later than now when already inside the radius
    hard_radius: R  # R_h [m]
    soft: R  # weight of nearness, 1 - 0.7 n_j; 0 for a masked peer
    hard: R  # 1 - 0.5 n_j; 0 for a masked peer


class Legs(Struct, Generic[R], frozen=True, gc=False):
    """The way back to the path and along it: the wanted course until t1, then the path's."""

    ux: R  # first velocity [m/s]
    uy: R
    wx: R  # second velocity
    wy: R
    t1: R  # [s]


class Meeting(Struct, Generic[R], frozen=True, gc=False):
    """The nearest moment of an encounter, as its price."""

    soft: R  # nearness within the radius, weighted
    hard: R  # nearness within the hard radius, weighted
    wrong: R  # 1 it passes on the wrong side


def threat(own: Own[R], peer: Peer[R], seen: View[R], judged: Judged[R], params: ScoringParams) -> Threat[R]:
    """The peer as all candidates meet it.

    n_j = min(1, d / (max(u_d, 0.3) + u_j) / H_j)     the earliest possible meeting, as a share of the horizon

    A boat that turns when we turn is met on its plan as we are on ours: that both still sail as before is no encounter.
    """
    vx, vy = peer.vx, peer.vy
    if ops.some(peer.together == 1.0):
        one = peer.together == 1.0
        vx, vy = ops.where(one, peer.u_d * peer.gx, vx), ops.where(one, peer.u_d * peer.gy, vy)
    cruise = ops.maximum(own.u_d, params.least_cruise_mps)
    n = ops.minimum(seen.d / (cruise + seen.speed) / judged.horizon, 1.0)
    radius_sq = judged.radius * judged.radius
    return Threat(
        peer.number,
        seen.dx,
        seen.dy,
        vx,
        vy,
        peer.present * judged.pair.side,
        judged.horizon,
        judged.radius,
        radius_sq,
        ops.where(seen.d_sq < radius_sq, params.opening_s, 0.0),
        params.hard_m + params.hard_sigmas * seen.sigma + peer.widen,
        peer.present * (1.0 - params.decay * n),
        peer.present * (1.0 - params.decay_hard * n),
    )


class Beside(Struct, Generic[R], frozen=True, gc=False):
    """A vehicle so near that turning through its bearing has a price."""

    dx: R  # from own, north [m]
    dy: R
    price: R


def swept(
    speed: R, threats: tuple[Threat[R], ...], yaw_rate_max_radps: float, params: ScoringParams
) -> tuple[Beside[R], ...]:
    """The vehicles that lie within the hard radius of our turning circle's breadth, 2 u / r_max.

    A velocity is not had at once: who turns through the bearing of another sails towards it meanwhile.
    """
    breadth = speed * (2.0 / yaw_rate_max_radps)
    found = []
    for each in threats:
        reach = each.hard_radius + breadth
        near = each.dx * each.dx + each.dy * each.dy < reach * reach
        if ops.some(near):
            d = ops.sqrt(each.dx * each.dx + each.dy * each.dy)
            weight = ops.flag(each.soft > 0.0, d)
            price = ops.where(near, params.sweep * weight * (1.0 - d / reach), 0.0)
            found.append(Beside(each.dx, each.dy, price))
    return tuple(found)


def sweep_price(ex: R, ey: R, cx: R, cy: R, beside: tuple[Beside[R], ...]) -> R:
    """The most that turning from course e to course c, the short way, costs by what lies between."""
    turn = ex * cy - ey * cx
    most = ops.zero(turn)
    for each in beside:
        from_own = ex * each.dy - ey * each.dx
        to_new = each.dx * cy - each.dy * cx
        between = ((turn > 0.0) & (from_own > 0.0) & (to_new > 0.0)) | (
            (turn < 0.0) & (from_own < 0.0) & (to_new < 0.0)
        )
        most = ops.maximum(most, ops.where(between, each.price, 0.0))
    return most


def widened(threat: Threat[R], extra: R, params: ScoringParams) -> Threat[R]:
    """The same threat with a radius larger by `extra` [m]."""
    radius = threat.radius + extra
    radius_sq = radius * radius
    return Threat(
        threat.number,
        threat.dx,
        threat.dy,
        threat.vx,
        threat.vy,
        threat.side,
        threat.horizon,
        radius,
        radius_sq,
        ops.where(threat.dx * threat.dx + threat.dy * threat.dy < radius_sq, params.opening_s, 0.0),
        threat.hard_radius,
        threat.soft,
        threat.hard,
    )


def returned(threat: Threat[R], peer: Peer[R], alike: R, params: ScoringParams) -> Threat[R]:
    """The same vehicle as if it were back on its path, at the speed its plan wants.

    Only one that publishes a plan and is neither a companion nor near and bound as we are (alike 1); of others nothing
    counts.
    """
    dx, dy = threat.dx + peer.y_e * peer.ty, threat.dy - peer.y_e * peer.tx
    counts = (peer.known == 1.0) & (alike == 0.0)
    return Threat(
        threat.number,
        dx,
        dy,
        peer.u_d * peer.tx,
        peer.u_d * peer.ty,
        threat.side,
        threat.horizon,
        threat.radius,
        threat.radius_sq,
        ops.where(dx * dx + dy * dy < threat.radius_sq, params.opening_s, 0.0),
        threat.hard_radius,
        ops.where(counts, threat.soft, 0.0),
        ops.where(counts, threat.hard, 0.0),
    )


def legs(own: Own[R], u: R) -> Legs[R]:
    """How the boat gets back to its path at speed u [m/s]: t1 = |y_e| / (u max(|sin(gamma - chi_p)|, 0.05))."""
    slope = ops.maximum(abs(own.tx * own.gy - own.ty * own.gx), 0.05)
    back = abs(own.y_e) / (ops.maximum(u, _UNDER_WAY_MPS) * slope)
    t1 = ops.where(u > _UNDER_WAY_MPS, back, _NEVER_S)
    return Legs(u * own.gx, u * own.gy, u * own.tx, u * own.ty, t1)


def _priced(threat: Threat[R], t: R, c_sq: R, m: R) -> Meeting[R]:
    """The meeting at time t [s], range squared c_sq [m2], passing with the sign of m (> 0: it is left to port)."""
    c = ops.sqrt(c_sq)
    return Meeting(
        ops.where(c_sq < threat.radius_sq, (1.0 - c / threat.radius) * threat.soft, 0.0),
        ops.maximum(1.0 - c / threat.hard_radius, 0.0) * threat.hard,
        ops.flag((threat.side * m < 0.0) & (t > 0.1) & (t < threat.horizon), t),
    )


def meet_on_legs(threat: Threat[R], way: Legs[R]) -> Meeting[R]:
    """The nearest moment on the way back to the path and along it.

    The first leg counts from t0 to t1, the second from there to the horizon; a first leg that outlasts the horizon is
    the only one, and one that ends before t0 does not count.
    """
    qx, qy = way.ux - threat.vx, way.uy - threat.vy
    two = way.t1 < threat.horizon
    end = ops.where(two, way.t1, threat.horizon)
    t_a = (threat.dx * qx + threat.dy * qy) / (qx * qx + qy * qy + 1e-6)
    t_a = ops.minimum(ops.maximum(t_a, threat.t0), end)
    ax, ay = threat.dx - qx * t_a, threat.dy - qy * t_a
    a_sq = ax * ax + ay * ay

    px, py = threat.dx - qx * end, threat.dy - qy * end
    ox, oy = way.wx - threat.vx, way.wy - threat.vy
    t_b = (px * ox + py * oy) / (ox * ox + oy * oy + 1e-6)
    t_b = ops.minimum(ops.maximum(t_b, ops.maximum(threat.t0 - end, 0.0)), threat.horizon - end)
    bx, by = px - ox * t_b, py - oy * t_b
    b_sq = bx * bx + by * by

    second = two & ((b_sq < a_sq) | (way.t1 < threat.t0))
    return _priced(
        threat,
        ops.where(second, end + t_b, t_a),
        ops.where(second, b_sq, a_sq),
        ops.where(second, px * oy - py * ox, threat.dx * qy - threat.dy * qx),
    )


def total(own_price: R, worst: R, crowd: R, hardest: R, wrong: R, params: ScoringParams) -> R:
    """own price + 30 (max soft + 0.3 sum soft + 4 max hard) + 3 (number of wrong sides)."""
    return own_price + (
        params.collision * (worst + params.crowd * crowd + params.hard * hardest) + params.wrong_side * wrong
    )


def price_on_legs(own_price: R, way: Legs[R], threats: tuple[Threat[R], ...], least: R, params: ScoringParams) -> R:
    """Price of a way back to the path, or anything >= least where it is not below `least`."""
    none = ops.zero(own_price)
    worst, crowd, hardest, wrong, price = none, none, none, none, own_price
    for each in threats:
        met = meet_on_legs(each, way)
        worst, hardest = ops.maximum(worst, met.soft), ops.maximum(hardest, met.hard)
        crowd, wrong = crowd + met.soft, wrong + met.wrong
        price = total(own_price, worst, crowd, hardest, wrong, params)
        if ops.every(price >= least):
            break
    return price


def price_straight(own_price: R, ux: R, uy: R, threats: tuple[Threat[R], ...], least: R, params: ScoringParams) -> R:
    """Price of holding the velocity (ux, uy) [m/s], or anything >= least where it is not below `least`.

    t = clip(p . q / (q . q + 1e-6), t0, H_j), q = own velocity - peer's; the range then is |p - q t|.
    """
    none = ops.zero(own_price)
    worst, crowd, hardest, wrong, price = none, none, none, none, own_price
    for each in threats:
        qx, qy = ux - each.vx, uy - each.vy
        nearing = each.dx * qx + each.dy * qy
        if ops.every((nearing <= 0.0) & (each.t0 == 0.0)):  # opens, and outside: adds 0
            continue
        t = ops.minimum(ops.maximum(nearing / (qx * qx + qy * qy + 1e-6), each.t0), each.horizon)
        cx, cy = each.dx - qx * t, each.dy - qy * t
        c_sq = cx * cx + cy * cy
        m = each.dx * qy - each.dy * qx
        if not ops.some((c_sq < each.radius_sq) | (each.side * m < 0.0)):  # passes clear, on its side: adds 0
            continue
        met = _priced(each, t, c_sq, m)
        worst, hardest = ops.maximum(worst, met.soft), ops.maximum(hardest, met.hard)
        crowd, wrong = crowd + met.soft, wrong + met.wrong
        price = total(own_price, worst, crowd, hardest, wrong, params)
        if ops.every(price >= least):
            break
    return price
