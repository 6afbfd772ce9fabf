"""Where a boat will be: following its path, or holding an alteration, with the lags it really has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.avoidance.foreign.banks import bend
from fleet.avoidance.foreign.domain import Domain, clearance, gap
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.types import NEVER_S, Afloat, Boat, Edge
from fleet.guidance import follow
from fleet.ops import R

ON_PATH_M = 0.3
ALIGNED = 0.05  # rad, about 3 deg
COARSE_S = 2.0  # between the vertices of a way along the path, once its lags have settled


class Way(Struct, Generic[R], frozen=True, gc=False):
    """A way ahead as a polyline: at time t[k] the boat is at x[k], y[k]."""

    t: list[float]
    x: list[R]
    y: list[R]


class Motion(Struct, Generic[R], frozen=True, gc=False):
    """A boat as it moves now."""

    x: R
    y: R
    chi: R  # course over ground [rad]
    U: R
    r: R
    r_max: R
    a_max: R
    yaw_lag: R
    surge_lag: R


def motion(boat: Afloat) -> Motion[float]:
    """Of one boat."""
    limits = boat.limits
    return Motion(
        boat.x, boat.y, boat.chi, boat.U, boat.r,
        limits.yaw_rate_max_radps, limits.acceleration_max_mps2, limits.yaw_lag_s, limits.surge_lag_s,
    )  # fmt: skip


def following(boat: Boat, horizon: float, params: ForeignParams) -> Way[float]:
    """The way of a boat that follows its path at cruise speed.

    Steps of 0.5 s with the real lags for 10 s, then the course that path-following wants, without lag. On its path,
    where that stays straight, a boat goes straight on.
    """
    path, limits = boat.path, boat.limits
    x, y, chi, U, r, s = boat.x, boat.y, boat.chi, boat.U, boat.r, boat.s
    way = Way([0.0], [x], [y])
    t, dt = 0.0, params.fine_s
    point = path.at(s)
    while t < min(params.fine_for_s, horizon):
        f = follow(x, y, chi, U, point, params.follow)
        settled = abs(f.y1) < ON_PATH_M and abs(f.beta) < ALIGNED and abs(U - boat.cruise) < ALIGNED
        if settled and path.straight(s) > boat.cruise * (horizon - t):
            break
        r_d = ops.clip(f.r_d, -limits.yaw_rate_max_radps, limits.yaw_rate_max_radps)
        r += dt / limits.yaw_lag_s * (r_d - r)
        U += dt * ops.clip(
            (boat.cruise - U) / limits.surge_lag_s, -limits.acceleration_max_mps2, limits.acceleration_max_mps2
        )
        sin_chi, cos_chi = ops.sincos(chi + 0.5 * dt * r)
        x, y, chi = x + dt * U * cos_chi, y + dt * U * sin_chi, chi + dt * r
        s += dt * f.s_dot
        t += dt
        point = path.at(s)
        _append(way, t, x, y)
    U = boat.cruise
    while t < horizon:
        dx, dy = x - point.x, y - point.y
        y1 = point.tx * dy - point.ty * dx
        s += point.tx * dx + point.ty * dy  # the foot of the boat on the path
        dt = min(COARSE_S, horizon - t)
        if abs(y1) < ON_PATH_M and path.straight(s) > U * (horizon - t):
            break
        sin_phi, cos_phi = ops.sincos(-params.follow.psi_a_rad * ops.tanh(params.follow.k_phi_per_m * y1))
        x += dt * U * (point.tx * cos_phi - point.ty * sin_phi)
        y += dt * U * (point.ty * cos_phi + point.tx * sin_phi)
        s += dt * U * cos_phi
        t += dt
        point = path.at(s)
        _append(way, t, x, y)
    while t < horizon:
        dt = min(COARSE_S, horizon - t)
        x, y, t = x + dt * U * point.tx, y + dt * U * point.ty, t + dt
        _append(way, t, x, y)
    return way


def time_back(boat: Boat, params: ForeignParams) -> float:
    """How long it takes to get back onto the path: |y| / (u_c sin psi_a), limited [s]."""
    point = boat.path.at(boat.s)
    y1 = point.tx * (boat.y - point.y) - point.ty * (boat.x - point.x)
    sin_a, _ = ops.sincos(params.follow.psi_a_rad)
    return min(abs(y1) / (max(boat.cruise, params.least_speed_mps) * sin_a), params.back_s)


def left_to_turn(chi: R, cx: R, cy: R, sense: R) -> R:
    """What is left to turn from course chi to the unit vector, by the named way where there is one [rad].

    Up to 20 deg beyond the course wanted the boat turns back instead of round again.
    """
    s, c = ops.sincos(chi)
    left = ops.atan2(c * cy - s * cx, c * cx + s * cy)
    return ops.where(left * sense < -0.35, left + sense * ops.TWO_PI, left)


class Sailing(Struct, Generic[R], frozen=True, gc=False):
    """A way on an alteration, worked out so far."""

    m: Motion[R]
    left: R  # to turn [rad]
    cx: R  # course to hold, unit vector
    cy: R
    u_d: R
    horizon: float
    U: R  # at the last vertex [m/s]
    r: R
    turned: R  # since the start [rad]
    hx: R  # unit vector of its course of late, by which it goes along banks
    hy: R
    way: Way[R]

    @property
    def done(self) -> bool:
        """Up to the horizon."""
        return not self.way.t[-1] < self.horizon


def set_out(m: Motion[R], left: R, cx: R, cy: R, u_d: R, horizon: float) -> Sailing[R]:
    """The start of the way of a boat that turns by `left` [rad] to the course (cx, cy) and holds it at speed u_d."""
    hy, hx = ops.sincos(m.chi)
    return Sailing(m, left, cx, cy, u_d, horizon, m.U, m.r, ops.zero(left), hx, hy, Way([0.0], [m.x], [m.y]))


def sail_on(one: Sailing[R], edges: Sequence[Edge], steps: float, params: ForeignParams) -> Sailing[R]:
    """At most so many more steps of the way.

    Steps of 0.5 s with the real lags for 10 s, then 4 s straight on; along the banks where the course leads to one.
    """
    m, left, cx, cy, u_d, horizon = one.m, one.left, one.cx, one.cy, one.u_d, one.horizon
    U, r, turned, hx, hy = one.U, one.r, one.turned, one.hx, one.hy
    way = Way(list(one.way.t), list(one.way.x), list(one.way.y))
    t, x, y = way.t[-1], way.x[-1], way.y[-1]
    last, dt = len(way.t) + steps, params.fine_s
    stir, push = dt / m.yaw_lag, 1.0 / m.surge_lag
    while t < min(params.fine_for_s, horizon) and len(way.t) < last:
        off, u_now = left - turned, u_d
        if edges:
            bent = bend(x, y, cx, cy, hx, hy, U, m.r_max, edges, params)
            if ops.some(bent.bent > 0.5):
                s, c = ops.sincos(m.chi + turned)
                aside = ops.atan2(c * bent.cy - s * bent.cx, c * bent.cx + s * bent.cy)
                off, u_now = ops.where(bent.bent > 0.5, aside, off), u_now * bent.free
        r = r + stir * (ops.clip(params.k1 * off, -m.r_max, m.r_max) - r)
        U = U + dt * ops.clip((u_now - U) * push, -m.a_max, m.a_max)
        hy, hx = ops.sincos(m.chi + (turned + 0.5 * dt * r))
        x, y, turned = x + dt * U * hx, y + dt * U * hy, turned + dt * r
        t += dt
        _append(way, t, x, y)
    coarse = COARSE_S if edges else params.coarse_s  # in longer steps it could get ashore before it turns
    while t < horizon and len(way.t) < last:
        dt = min(coarse, horizon - t)
        vx, vy = U * cx, U * cy
        if edges:
            bent = bend(x, y, cx, cy, hx, hy, U, m.r_max, edges, params)
            u_now, hx, hy = U * bent.free, bent.cx, bent.cy
            vx, vy = u_now * bent.cx, u_now * bent.cy
        x, y = x + dt * vx, y + dt * vy
        t += dt
        _append(way, t, x, y)
    return Sailing(m, left, cx, cy, u_d, horizon, U, r, turned, hx, hy, way)


def holding(
    m: Motion[R],
    left: R,
    cx: R,
    cy: R,
    u_d: R,
    edges: Sequence[Edge],
    horizon: float,
    params: ForeignParams,
) -> Way[R]:
    """The way of a boat that turns by `left` [rad] to the course (cx, cy) and holds it at speed u_d."""
    return sail_on(set_out(m, left, cx, cy, u_d, horizon), edges, NEVER_S, params).way


def _append(way: Way[R], t: float, x: R, y: R) -> None:
    way.t.append(t)
    way.x.append(x)
    way.y.append(y)


def entry(way: Way[float], d: Domain, horizon: float, factor: float, growth: float, opening: float) -> float:
    """First time at which the way is nearer to the core than factor C(t), NEVER_S if that is not before the horizon.

    Every guess of the vessel's velocity counts. Legs are tested whole, so nothing slips through between two vertices.

    Args:
        factor: of the clearance
        growth: share of its growth with time
        opening: when already inside, from when on it counts [s]
    """
    first = NEVER_S
    for g in d.guesses:
        px, py = way.x[0] - d.x, way.y[0] - d.y
        x0, y0, t0 = px * g.ex + py * g.ey, py * g.ex - px * g.ey, 0.0
        from_then = opening if opening > 0.0 and _inside(x0, y0, d, factor * d.C) else 0.0
        for k in range(1, len(way.t)):
            t1 = way.t[k]
            if t0 >= min(first, horizon):
                break
            px, py = way.x[k] - d.x - t1 * g.vx, way.y[k] - d.y - t1 * g.vy
            x1, y1 = px * g.ex + py * g.ey, py * g.ex - px * g.ey
            C = factor * clearance(d, t1, growth)
            away = (
                (y0 > C and y1 > C)
                or (y0 < -C and y1 < -C)
                or (x0 > d.ahead + C and x1 > d.ahead + C)
                or (x0 < d.astern - C and x1 < d.astern - C)
            )
            if not away and t1 > from_then:
                least, share = gap(x0, y0, x1, y1, d.astern, d.ahead)
                there = t0 + share * (t1 - t0)
                over = factor * clearance(d, there, growth) - least
                if over > 0.0:
                    room, _ = gap(x0, y0, x0, y0, d.astern, d.ahead)
                    room -= factor * clearance(d, t0, growth)
                    first = min(first, t0 if room <= 0.0 else t0 + (there - t0) * room / (room + over))
                    break
            x0, y0, t0 = x1, y1, t1
    return first if first < horizon else NEVER_S


def _inside(x: float, y: float, d: Domain, C: float) -> bool:
    """Nearer than C to the core, in the vessel's frame."""
    return gap(x, y, x, y, d.astern, d.ahead)[0] < C


def distance(x: float, y: float, d: Domain) -> float:
    """From (x, y) to the core now [m]."""
    g = d.guesses[0]
    px, py = x - d.x, y - d.y
    along, across = px * g.ex + py * g.ey, py * g.ex - px * g.ey
    return gap(along, across, along, across, d.astern, d.ahead)[0]
