"""Updates of a Kalman filter for constant velocity: axes north and east independent, one covariance for both."""

from __future__ import annotations

from typing import Any, TypeVar

from msgspec import Struct, structs

F = TypeVar("F", bound=Struct)
"""A filter with fields x, y [m], vx, vy [m/s], P11 [m2], P12 [m2/s], P22 [m2/s2]."""


def by_position(known: F, dx: float, dy: float, R: float) -> F:
    """After a position with variance R per axis [m2] that is off by (dx, dy) [m].

    K = (P11, P12) / (P11 + R)
    """
    f: Any = known
    per = 1.0 / (f.P11 + R)
    return _corrected(known, f.P11 * per, f.P12 * per, dx, dy, f.P11, f.P12)


def by_velocity(known: F, dvx: float, dvy: float, R: float) -> F:
    """After a velocity with variance R per axis [m2/s2] that is off by (dvx, dvy) [m/s].

    K = (P12, P22) / (P22 + R)
    """
    f: Any = known
    per = 1.0 / (f.P22 + R)
    return _corrected(known, f.P12 * per, f.P22 * per, dvx, dvy, f.P12, f.P22)


def _corrected(known: F, K1: float, K2: float, dn: float, de: float, row1: float, row2: float) -> F:
    """State moved by K times the innovation, P less K times the row of P that was measured."""
    f: Any = known
    return structs.replace(
        known,
        x=f.x + K1 * dn,
        y=f.y + K1 * de,
        vx=f.vx + K2 * dn,
        vy=f.vy + K2 * de,
        P11=f.P11 - K1 * row1,
        P12=f.P12 - K1 * row2,
        P22=f.P22 - K2 * row2,
    )
