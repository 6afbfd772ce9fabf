"""A path beside another, with the other's abscissa: what boats abreast sail, so that they stay abreast in turns.

Everybody counts abscissa along the path in the middle. Inside of a bend a metre of it is less than a metre of one's
own lane, outside it is more: `stretch` says by how much.
"""

from __future__ import annotations

import math

from msgspec import Struct

from fleet import ops
from fleet.ops import R
from fleet.paths.curve import PathPoint, within_lap
from fleet.paths.path import NEVER_M, Path

STEEPEST = 0.36  # tangent of the angle at which a boat changes lanes, 20 deg: it loses 6 % of its way
STEP_M = 4.0  # between the points of a lane that are tried when the nearest one is looked for
MOST = 4000  # such points


class Shift(Struct, frozen=True, array_like=True):
    """A change of lanes: from `begin` on, over `length`, from n and its slope to the lane's own offset."""

    begin: float  # abscissa [m]
    length: float  # of abscissa [m]
    n: float  # offset there, + to starboard [m]
    slope: float  # and how it grows [m/m]


def beside(p: PathPoint[R], n: R, slope: R, bend: R) -> PathPoint[R]:
    """The point n metres to starboard of p, where n grows by `slope` a metre and that by `bend`.

        P = p + n N;  P' = (1 - c n) T + n' N;  curvature = (P' x P'') / |P'|^3, the path's own c' left out

    With n' = n'' = 0 it is the parallel curve, of curvature c / (1 - c n).
    """
    a = 1.0 - p.c * n
    per = 1.0 / ops.sqrt(a * a + slope * slope)
    tx, ty = per * (a * p.tx - slope * p.ty), per * (a * p.ty + slope * p.tx)
    c = (a * (bend + p.c * a) + 2.0 * p.c * slope * slope) * per * per * per
    return PathPoint(p.x - n * p.ty, p.y + n * p.tx, tx, ty, c)


def stretch(c: R, n: R, slope: R) -> R:
    """Metres of the lane for a metre of the path: |P'| = sqrt((1 - c n)^2 + n'^2)."""
    a = 1.0 - c * n
    return ops.sqrt(a * a + slope * slope)


def shift_length(n: float, radius: float) -> float:
    """Metres that a change of lanes by n takes at least: no steeper than 20 deg, half as bent as the radius allows."""
    return max(1.5 * abs(n) / STEEPEST, math.sqrt(12.0 * abs(n) * radius), 1.0)


class Lane:
    """A path n metres to starboard of another, of the same abscissa; possibly coming over from another lane."""

    __slots__ = ("closed", "length", "n", "path", "shift")

    def __init__(self, path: Path, n: float, shift: Shift | None = None) -> None:
        self.path, self.n, self.shift = path, n, shift
        self.closed, self.length = path.closed, path.length

    def __repr__(self) -> str:
        return f"Lane({self.n:+.2f} m of {self.path!r})"

    def offset(self, s: float) -> tuple[float, float, float]:
        """n, n', n'' at abscissa s: a cubic between two lanes."""
        shift = self.shift
        if shift is None or s >= shift.begin + shift.length:
            return self.n, 0.0, 0.0
        if s <= shift.begin:
            return shift.n, 0.0, 0.0
        long, m = shift.length, shift.length * shift.slope
        u = (s - shift.begin) / long
        gap = shift.n - self.n
        n = self.n + gap * (1.0 + u * u * (2.0 * u - 3.0)) + m * u * (1.0 + u * (u - 2.0))
        slope = (gap * 6.0 * u * (u - 1.0) + m * (1.0 + u * (3.0 * u - 4.0))) / long
        return n, slope, (gap * (12.0 * u - 6.0) + m * (6.0 * u - 4.0)) / (long * long)

    def at(self, s: float) -> PathPoint[float]:
        """The point at abscissa s [m]."""
        return beside(self.path.at(s), *self.offset(s))

    def stretch(self, s: float) -> float:
        """Metres of this lane for a metre of abscissa."""
        n, slope, _ = self.offset(s)
        return stretch(self.path.at(s).c, n, slope)

    def straight(self, s: float) -> float:
        """Metres ahead of s along which the course stays within 10 deg; 0 while changing lanes."""
        shift = self.shift
        if shift is not None and shift.begin < s < shift.begin + shift.length:
            return 0.0
        return min(self.path.straight(s) * self.stretch(s), NEVER_M)

    def project(self, x: float, y: float, low: float | None = None, high: float | None = None) -> float:
        """Abscissa of the nearest point; as `Path.project`, save that an open lane is searched within its length.

        Feet of perpendiculars are the same for both curves, so the path's own search ends what a coarse one along the
        lane begins: the nearest point of the path may belong to another leg of it.
        """
        first = low if low is not None else (high - self.length if high is not None and self.closed else 0.0)
        last = high if high is not None else first + self.length
        count = min(max(math.ceil((last - first) / STEP_M), 1), MOST)
        step = (last - first) / count
        best, least = first, math.inf
        for i in range(count + 1):
            p = self.at(first + i * step)
            d_sq = (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y)
            if d_sq < least:
                best, least = first + i * step, d_sq
        round_ = self.closed and low is None and high is None  # the search goes on across the start
        a, b = best - step, best + step
        s = self.path.project(x, y, a if round_ else max(a, first), b if round_ else min(b, last))
        p = self.at(s)
        if (p.x - x) * (p.x - x) + (p.y - y) * (p.y - y) > least:
            s = best
        return within_lap(s, self.length) if round_ else s


def lane(path: Path, n: float, shift: Shift | None = None) -> Path | Lane:
    """The path itself, or the lane beside it."""
    return path if n == 0.0 and shift is None else Lane(path, n, shift)
