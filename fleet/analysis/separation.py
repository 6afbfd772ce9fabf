"""How close two hulls came, exactly: between samples both move in straight lines."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from msgspec import Struct

from fleet.analysis.series import Floats, Track


class Approach(Struct, frozen=True, kw_only=True):
    """The closest approach of two hulls."""

    first: str
    second: str
    distance_m: float  # between centres
    at_s: float
    touches: int  # times the hulls came to overlap: centres nearer than the sum of half lengths


class Distance(Struct, frozen=True):
    """Distance of two hulls over time."""

    t: Floats
    d: Floats  # at t [m]
    least_t: Floats
    least: Floats  # smallest from each t to the next, and when [m, s]


def distance(a: Track, b: Track) -> Distance | None:
    """Distance of two tracks while both are known; None if they never are together."""
    if not len(a.t) or not len(b.t):
        return None
    begin, end = max(a.t[0], b.t[0]), min(a.t[-1], b.t[-1])
    if begin > end:
        return None
    t = np.union1d(a.t, b.t)
    t = np.union1d(t[(t >= begin) & (t <= end)], [begin, end])
    dx = np.interp(t, b.t, b.x) - np.interp(t, a.t, a.x)
    dy = np.interp(t, b.t, b.y) - np.interp(t, a.t, a.y)
    d = np.hypot(dx, dy)
    if len(t) == 1:
        return Distance(t, d, t, d)
    wx, wy = np.diff(dx), np.diff(dy)
    moved = wx * wx + wy * wy
    share = np.clip(-(dx[:-1] * wx + dy[:-1] * wy) / np.where(moved > 0.0, moved, 1.0), 0.0, 1.0)
    least = np.hypot(dx[:-1] + share * wx, dy[:-1] + share * wy)
    return Distance(t, d, t[:-1] + share * np.diff(t), least)


def touches(apart: Distance, limit_m: float) -> int:
    """How often the distance fell below a limit; once if it began there."""
    if np.isnan(limit_m):
        return 0
    began = int(apart.d[0] < limit_m)
    if len(apart.t) == 1:
        return began
    return began + int(np.count_nonzero((apart.d[:-1] >= limit_m) & (apart.least < limit_m)))


def approaches(tracks: dict[str, Track]) -> list[Approach]:
    """Closest approach of every pair, nearest first."""
    found = []
    for (first, a), (second, b) in combinations(sorted(tracks.items()), 2):
        apart = distance(a, b)
        if apart is None:
            continue
        k = int(np.argmin(apart.least))
        found.append(
            Approach(
                first=first,
                second=second,
                distance_m=float(apart.least[k]),
                at_s=float(apart.least_t[k]),
                touches=touches(apart, 0.5 * (a.length_m + b.length_m)),
            )
        )
    return sorted(found, key=lambda one: one.distance_m)
