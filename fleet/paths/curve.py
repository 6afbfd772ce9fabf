"""The law that every path shares: a cubic cell, evaluated.

Whatever a path was drawn from, it is rows of cells: cubics x(t), y(t) for t in [0, 1], made so that t grows evenly with
the abscissa. A boat evaluates one row, a batch one row per lane, with equal bits.
"""

from __future__ import annotations

from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.ops import R


class PathPoint(Struct, Generic[R], frozen=True, gc=False):
    """A point of a path."""

    x: R  # north [m]
    y: R  # east [m]
    tx: R  # unit tangent, in the direction of growing s
    ty: R
    c: R  # curvature, > 0 bends to starboard [1/m]


class Cell(Struct, Generic[R], frozen=True, gc=False):
    """One row: x = x0 + x1 t + x2 t^2 + x3 t^3, y alike, t = (s - s0) * per_m."""

    x0: R
    x1: R
    x2: R
    x3: R
    y0: R
    y1: R
    y2: R
    y3: R
    s0: R  # abscissa of its start [m]
    per_m: R  # 1 / length [1/m]


def evaluate(cell: Cell[R], t: R) -> PathPoint[R]:
    """Point, unit tangent and curvature of a cell at t in [0, 1]."""
    x2, x3, y2, y3 = cell.x2, cell.x3, cell.y2, cell.y3
    bx, by = x3 * t, y3 * t
    ax, ay = x2 + bx, y2 + by
    dx = cell.x1 + t * (2.0 * ax + bx)
    dy = cell.y1 + t * (2.0 * ay + by)
    per = 1.0 / ops.sqrt(dx * dx + dy * dy)
    tx, ty = dx * per, dy * per
    bend = 2.0 * (tx * (ay + 2.0 * by) - ty * (ax + 2.0 * bx))
    return PathPoint(
        cell.x0 + t * (cell.x1 + t * ax),
        cell.y0 + t * (cell.y1 + t * ay),
        tx,
        ty,
        bend * per * per,
    )


def beyond(end: PathPoint[R], d: R) -> PathPoint[R]:
    """The point d metres from an end of a path, straight on along its tangent; d < 0 before it."""
    return PathPoint(end.x + d * end.tx, end.y + d * end.ty, end.tx, end.ty, ops.zero(d))


def within_lap(s: R, length: float) -> R:
    """The abscissa of a closed path with its laps taken off, in [0, length) [m]."""
    rest = s - ops.floor(s / length) * length
    return ops.maximum(ops.where(rest >= length, rest - length, rest), 0.0)
