"""Position and velocity from fixes whose error drifts slowly, and from a velocity that is far better than they are.

A receiver's position is off by an error that lasts for a minute, and by a little noise; its velocity has noise only. So
the way sailed is known to decimetres, and what the slow error does meanwhile is seen and learnt. Per axis the state is
position x, velocity v and slow error b; north and east are alike and independent, and one covariance serves both. The
covariance does not depend on what is measured: boats that have looked at the same times share it.
"""

from __future__ import annotations

from typing import Annotated, Generic, TypeAlias

from msgspec import Meta, Struct

from fleet import ops
from fleet.ops import R

Positive = Annotated[float, Meta(gt=0.0)]
Gain: TypeAlias = tuple[float, float, float]
"""How much of an innovation goes to x, v and b."""
_LEAST = 1e-6  # variance of noise that is said to be none


class DriftParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is believed of a receiver and of a boat."""

    slow_s: Positive = 60.0  # for so long the slow error is correlated (Gauss-Markov)
    white: Positive = 0.5  # noise of a fix as a share of its slow error, taken too large; never less than 0.02 m
    q: Positive = 0.002  # spectral density of the acceleration that turning does not explain [m2/s3]
    least: Positive = 0.5  # share of the receiver's own error below which a position is never said to be


PARAMS = DriftParams()


class Cov(Struct, frozen=True, gc=False):
    """Covariance of x, v and b of one axis."""

    xx: float  # [m2]
    xv: float  # [m2/s]
    xb: float  # [m2]
    vv: float  # [m2/s2]
    vb: float  # [m2/s]
    bb: float  # [m2]


class Drifting(Struct, Generic[R], frozen=True, gc=False):
    """What is known of both axes."""

    x: R  # north [m]
    y: R  # east [m]
    vx: R  # [m/s]
    vy: R
    bx: R  # slow error of the fixes, fix less position [m]
    by: R


class Gains(Struct, frozen=True, gc=False):
    """Of one look at position and velocity together."""

    keep: float  # what is left of the slow error since the last look
    fix: Gain
    velocity: Gain
    sigma: float  # 1-sigma error of the position afterwards, per axis [m]


def first(fix_sigma: float, velocity_sigma: float, params: DriftParams = PARAMS) -> Cov:
    """After the first fix and velocity: the fix is the position, and all of its error is in it."""
    slow, white = fix_sigma * fix_sigma, white_of(fix_sigma, params)
    return Cov(slow + white, 0.0, -slow, velocity_sigma * velocity_sigma, 0.0, slow)


def white_of(fix_sigma: float, params: DriftParams = PARAMS) -> float:
    """Variance of a fix's noise [m2]."""
    noise = max(params.white * fix_sigma, 0.02)
    return noise * noise


def left(dt: float, params: DriftParams = PARAMS) -> float:
    """What is left of the slow error after dt: 1 - dt / 60 s, never below 0."""
    return max(1.0 - dt / params.slow_s, 0.0)


def predicted(P: Cov, fix_sigma: float, dt: float, params: DriftParams = PARAMS) -> Cov:
    """After dt: the position moves on, the velocity wanders, the slow error fades and is renewed."""
    keep, q = left(dt, params), params.q
    return Cov(
        P.xx + dt * (2.0 * P.xv + dt * (P.vv + q * dt / 3.0)),
        P.xv + dt * (P.vv + 0.5 * q * dt),
        keep * (P.xb + dt * P.vb),
        P.vv + q * dt,
        keep * P.vb,
        keep * keep * P.bb + (1.0 - keep * keep) * fix_sigma * fix_sigma,
    )


def by_fix(P: Cov, variance: float) -> tuple[Cov, Gain]:
    """After a fix x + b with noise of a variance [m2], and its gain."""
    return _measured(P, P.xx + P.xb, P.xv + P.vb, P.xb + P.bb, P.xx + 2.0 * P.xb + P.bb + variance)


def by_velocity(P: Cov, variance: float) -> tuple[Cov, Gain]:
    """After a velocity with noise of a variance [m2/s2], and its gain."""
    return _measured(P, P.xv, P.vv, P.vb, P.vv + variance)


def _measured(P: Cov, x: float, v: float, b: float, total: float) -> tuple[Cov, Gain]:
    """(x, v, b): covariance of the state with what was measured, whose innovation has variance `total`."""
    kx, kv, kb = x / total, v / total, b / total
    after = Cov(P.xx - kx * x, P.xv - kx * v, P.xb - kx * b, P.vv - kv * v, P.vb - kv * b, P.bb - kb * b)
    return after, (kx, kv, kb)


def look(P: Cov, dt: float, fix_sigma: float, velocity_sigma: float, params: DriftParams = PARAMS) -> tuple[Cov, Gains]:
    """The covariance after dt, a fix and a velocity, and their gains."""
    P, fix = by_fix(predicted(P, fix_sigma, dt, params), white_of(fix_sigma, params))
    P, velocity = by_velocity(P, max(velocity_sigma * velocity_sigma, _LEAST))
    return P, Gains(left(dt, params), fix, velocity, said(P, fix_sigma, params))


def said(P: Cov, fix_sigma: float, params: DriftParams = PARAMS) -> float:
    """The 1-sigma error of the position that the boat tells, per axis [m].

    At least half of the receiver's: a model of its errors is not to be trusted any further.
    """
    return max(ops.sqrt(max(P.xx, 0.0)), params.least * fix_sigma)


def moved(known: Drifting[R], r: R, dt: float, keep: float) -> Drifting[R]:
    """After dt without a look: the velocity turns with the boat at r [rad/s], the slow error fades."""
    s, c = ops.sincos(r * dt)
    vx, vy = c * known.vx - s * known.vy, s * known.vx + c * known.vy
    x, y = known.x + 0.5 * (known.vx + vx) * dt, known.y + 0.5 * (known.vy + vy) * dt
    return Drifting(x, y, vx, vy, keep * known.bx, keep * known.by)


def corrected(known: Drifting[R], gain: Gain, dn: R, de: R) -> Drifting[R]:
    """The state moved by an innovation (dn, de) times its gain."""
    kx, kv, kb = gain
    return Drifting(
        known.x + kx * dn,
        known.y + kx * de,
        known.vx + kv * dn,
        known.vy + kv * de,
        known.bx + kb * dn,
        known.by + kb * de,
    )


def seen(known: Drifting[R], x: R, y: R, vx: R, vy: R, r: R, dt: float, gains: Gains) -> Drifting[R]:
    """What is known after dt and a look: a fix (x, y) [m] with its velocity (vx, vy) [m/s]."""
    known = moved(known, r, dt, gains.keep)
    known = corrected(known, gains.fix, x - known.x - known.bx, y - known.y - known.by)
    return corrected(known, gains.velocity, vx - known.vx, vy - known.vy)
