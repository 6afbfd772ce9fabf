"""How boats passed vessels that are not of the fleet, from true tracks: hulls, and the domain about a vessel."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from msgspec import Struct

from fleet.analysis.series import Floats, Track

BOAT_BEAM = 0.5  # of its length
VESSEL_BEAM = 0.2
SLOW_MPS = 0.3  # a vessel as slow as that has no bow to keep clear of


class Passing(Struct, frozen=True, kw_only=True):
    """One boat passes one vessel."""

    boat: str
    vessel: str
    hull_m: float  # least distance between the hulls; 0 where they touch
    at_s: float
    contacts: int  # times that they came to touch
    domain: float  # least distance from the boat's centre to the vessel's core, over C0; below 1 it was entered
    domain_at_s: float


def passings(boats: Mapping[str, Track], vessels: Mapping[str, Track]) -> list[Passing]:
    """Every boat with every vessel while both are known, by distance of hulls."""
    found = []
    for boat, own in sorted(boats.items()):
        for vessel, other in sorted(vessels.items()):
            passing = _passing(boat, own, vessel, other)
            if passing is not None:
                found.append(passing)
    return sorted(found, key=lambda one: (one.hull_m, one.domain))


def _passing(boat: str, own: Track, vessel: str, other: Track) -> Passing | None:
    t = np.union1d(own.t, other.t)
    if not len(own.t) or not len(other.t):
        return None
    t = t[(t >= max(own.t[0], other.t[0])) & (t <= min(own.t[-1], other.t[-1]))]
    if not len(t):
        return None
    hull = hull_distance(own, other, t)
    domain = domain_ratio(own, other, t)
    touching = hull <= 0.0
    nearest, deepest = int(np.argmin(hull)), int(np.argmin(domain))
    return Passing(
        boat=boat,
        vessel=vessel,
        hull_m=float(hull[nearest]),
        at_s=float(t[nearest]),
        contacts=int(touching[0]) + int(np.count_nonzero(touching[1:] & ~touching[:-1])),
        domain=float(domain[deepest]),
        domain_at_s=float(t[deepest]),
    )


def hull_distance(own: Track, other: Track, t: Floats) -> Floats:
    """Distance between the hulls, capsules of their lengths; a boat's beam is half of it, a vessel's a fifth [m]."""
    length = own.length_m if np.isfinite(own.length_m) else 0.0
    apart = _apart(own, other, t, length * (1.0 - BOAT_BEAM), other.length_m * (1.0 - VESSEL_BEAM))
    beams = 0.5 * (BOAT_BEAM * length + VESSEL_BEAM * other.length_m)
    return np.asarray(np.maximum(apart - beams, 0.0))


def domain_ratio(own: Track, other: Track, t: Floats) -> Floats:
    """Distance of the boat's centre from the vessel's core over C0 = 1.2 m + 0.1 L + clip(0.4 L, 6 m, 30 m).

    The core is the middle line of the vessel and, ahead of it, what it covers in 10 s, at most 3 lengths.
    """
    L = other.length_m
    C0 = 1.2 + 0.1 * L + float(np.clip(0.4 * L, 6.0, 30.0))
    dx = np.interp(t, own.t, own.x) - np.interp(t, other.t, other.x)
    dy = np.interp(t, own.t, own.y) - np.interp(t, other.t, other.y)
    U = np.interp(t, other.t, other.speed)
    ex, ey = _heading(other, t)
    ahead = 0.4 * L + np.minimum(10.0 * U, 3.0 * L)
    along = np.clip(dx * ex + dy * ey, -0.4 * L, ahead)
    moving = np.hypot(dx - along * ex, dy - along * ey) / C0
    return np.where(U < SLOW_MPS, np.hypot(dx, dy) / (C0 + 0.4 * L), moving)


def _heading(track: Track, t: Floats) -> tuple[Floats, Floats]:
    """Unit vector of the heading."""
    psi = np.interp(t, track.t, np.unwrap(np.nan_to_num(track.psi)))
    return np.cos(psi), np.sin(psi)


def _apart(own: Track, other: Track, t: Floats, own_m: float, other_m: float) -> Floats:
    """Distance between the middle lines of two hulls, so long each [m]."""
    ax, ay = _heading(own, t)
    bx, by = _heading(other, t)
    px = np.interp(t, other.t, other.x) - np.interp(t, own.t, own.x)
    py = np.interp(t, other.t, other.y) - np.interp(t, own.t, own.y)
    a, b = 0.5 * own_m, 0.5 * other_m
    ends = [_to_line(px + k * b * bx, py + k * b * by, ax, ay, a) for k in (-1.0, 1.0)]
    ends += [_to_line(k * a * ax - px, k * a * ay - py, bx, by, b) for k in (-1.0, 1.0)]
    cross = ax * by - ay * bx
    divisor = np.where(np.abs(cross) > 1e-9, cross, 1.0)
    meets = (
        (np.abs(cross) > 1e-9)
        & (np.abs((px * by - py * bx) / divisor) <= a)
        & (np.abs((px * ay - py * ax) / divisor) <= b)
    )
    return np.where(meets, 0.0, np.minimum.reduce(ends))


def _to_line(x: Floats, y: Floats, ex: Floats, ey: Floats, half: float) -> Floats:
    """Distance of a point from a line about the origin, `half` to each end [m]."""
    along = np.clip(x * ex + y * ey, -half, half)
    return np.hypot(x - along * ex, y - along * ey)
