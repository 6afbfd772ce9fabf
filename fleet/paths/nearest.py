"""The nearest point of a path, for joining it: whole cells are ruled out by a bound, the rest solved by Newton."""

from __future__ import annotations

import math
from collections.abc import Sequence

from fleet.paths.curve import Cell, PathPoint


class Best:
    """The nearest abscissa found so far to a point (x, y)."""

    __slots__ = ("d_sq", "s", "x", "y")

    def __init__(self, x: float, y: float) -> None:
        self.x, self.y = x, y
        self.s, self.d_sq = 0.0, math.inf

    def try_ray(self, end: PathPoint[float], s_end: float, low: float, high: float) -> None:
        """The straight continuation at an end, within [low, high]."""
        along = (self.x - end.x) * end.tx + (self.y - end.y) * end.ty
        s = min(max(s_end + along, low), high)
        dx = end.x + (s - s_end) * end.tx - self.x
        dy = end.y + (s - s_end) * end.ty - self.y
        self._offer(s, dx * dx + dy * dy)

    def try_cells(self, cells: Sequence[Cell[float]], low: float, high: float, offset: float) -> None:
        """Neighbouring cells, within [low, high]; `offset` is added to what is found."""
        middles: list[float] = []
        bound = math.sqrt(self.d_sq)
        for cell in cells:
            dx = cell.x0 + 0.5 * (cell.x1 + 0.5 * (cell.x2 + 0.5 * cell.x3)) - self.x
            dy = cell.y0 + 0.5 * (cell.y1 + 0.5 * (cell.y2 + 0.5 * cell.y3)) - self.y
            middles.append(math.sqrt(dx * dx + dy * dy))
        bound = min(bound, min(middles) + 1e-9) if low <= cells[0].s0 and _end(cells[-1]) <= high else bound
        for cell, middle in zip(cells, middles, strict=True):
            half = 0.505 / cell.per_m
            if middle - half <= bound:
                first = max((low - cell.s0) * cell.per_m, 0.0)
                last = min((high - cell.s0) * cell.per_m, 1.0)
                t, d_sq = nearest_in_cell(cell, self.x, self.y, first, last)
                self._offer(offset + cell.s0 + t / cell.per_m, d_sq)
                bound = min(bound, math.sqrt(d_sq) + 1e-9)

    def _offer(self, s: float, d_sq: float) -> None:
        if d_sq < self.d_sq:
            self.s, self.d_sq = s, d_sq


def _end(cell: Cell[float]) -> float:
    """Abscissa of the end of a cell; a hair less, for rounding."""
    return cell.s0 + 0.999999 / cell.per_m


def nearest_in_cell(cell: Cell[float], x: float, y: float, low: float, high: float) -> tuple[float, float]:
    """(t, squared distance) of the point of a cell nearest to (x, y), t within [low, high]."""
    best_t, best = low, _gap(cell, x, y, low)
    for t in (0.5 * (low + high), high):
        gap = _gap(cell, x, y, t)
        if gap < best:
            best_t, best = t, gap
    t = best_t
    for _ in range(12):
        dx = cell.x0 + t * (cell.x1 + t * (cell.x2 + t * cell.x3)) - x
        dy = cell.y0 + t * (cell.y1 + t * (cell.y2 + t * cell.y3)) - y
        vx = cell.x1 + t * (2.0 * cell.x2 + 3.0 * cell.x3 * t)
        vy = cell.y1 + t * (2.0 * cell.y2 + 3.0 * cell.y3 * t)
        speed_sq = vx * vx + vy * vy
        slope = dx * vx + dy * vy
        bend = speed_sq + dx * (2.0 * cell.x2 + 6.0 * cell.x3 * t) + dy * (2.0 * cell.y2 + 6.0 * cell.y3 * t)
        move = slope / (bend if bend > 0.1 * speed_sq else speed_sq)
        previous, t = t, min(max(t - move, low), high)
        if abs(t - previous) < 1e-12:
            break
    gap = _gap(cell, x, y, t)
    return (t, gap) if gap <= best else (best_t, best)


def _gap(cell: Cell[float], x: float, y: float, t: float) -> float:
    """Squared distance of (x, y) from the point of the cell at t [m^2]."""
    dx = cell.x0 + t * (cell.x1 + t * (cell.x2 + t * cell.x3)) - x
    dy = cell.y0 + t * (cell.y1 + t * (cell.y2 + t * cell.y3)) - y
    return dx * dx + dy * dy
