"""A path: its cells, and the tables that find the one of an abscissa without a search."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from itertools import pairwise

from fleet import ops
from fleet.paths import nearest
from fleet.paths.curve import Cell, PathPoint, beyond, evaluate, within_lap
from fleet.paths.errors import PathError

NEVER_M = 1e6
"""`straight` of a path that does not bend any more [m]."""
_BAND = math.radians(10.0)  # within it a course counts as straight
_MOST_BUCKETS = 1 << 17

Piece = tuple[float, float, float, float, float, float, float, float, float]
"""x0, x1, x2, x3, y0, y1, y2, y3 of a cell, and its length [m]."""


class Path:
    """A curve of abscissa s [m], open or closed; it does not change once built."""

    __slots__ = (
        "_first",
        "_last",
        "_of_bucket",
        "_per_bucket",
        "_rise",
        "_starts",
        "_stops",
        "bends",
        "cells",
        "closed",
        "hops",
        "length",
        "max_curvature",
    )

    def __init__(self, pieces: Sequence[Piece], closed: bool) -> None:
        if not pieces:
            raise PathError("path has no length; expected at least one piece")
        self.closed = closed
        self.cells: list[Cell[float]] = []
        self._starts: list[float] = []
        s = sharpest = 0.0
        port, starboard = (0.0, 0.0), (0.0, 0.0)
        turns: list[float] = []
        for x0, x1, x2, x3, y0, y1, y2, y3, length in pieces:
            self.cells.append(Cell(x0, x1, x2, x3, y0, y1, y2, y3, s, 1.0 / length))
            self._starts.append(s)
            s += length
            if x2 == 0.0 == y2 and x3 == 0.0 == y3:
                turns.append(0.0)
                continue
            ex, ey = x1 + 2.0 * x2 + 3.0 * x3, y1 + 2.0 * y2 + 3.0 * y3
            turns.append(math.atan2(x1 * ey - y1 * ex, x1 * ex + y1 * ey))
            first, last = x1 * y2 - y1 * x2, ex * (y2 + 3.0 * y3) - ey * (x2 + 3.0 * x3)
            per = length * length * length
            sharpest = max(sharpest, 2.0 * max(abs(first), abs(last)) / per)
            for c, at in ((2.0 * first / per, s - length), (2.0 * last / per, s)):
                port, starboard = min(port, (c, at)), max(starboard, (c, at))
        self.length: float = s
        self.max_curvature: float = sharpest
        self.bends = port, starboard  # (curvature, abscissa) where it bends most to either side
        self._starts.append(s)
        self._first = evaluate(self.cells[0], 0.0)
        self._last = evaluate(self.cells[-1], 1.0)
        self._fill_buckets()
        self._fill_stops(turns)

    def __repr__(self) -> str:
        kind = "closed" if self.closed else "open"
        return f"Path({kind}, {self.length:.2f} m, {len(self.cells)} cells)"

    def at(self, s: float) -> PathPoint[float]:
        """The point at abscissa s [m]: straight on beyond the ends of an open path, laps counted on a closed one."""
        length = self.length
        if self.closed and not 0.0 <= s < length:
            s = within_lap(s, length)
        if 0.0 <= s < length:
            cell = self.cells[self.index(s)]
            return evaluate(cell, (s - cell.s0) * cell.per_m)
        if s < 0.0:
            return beyond(self._first, s)
        return beyond(self._last, s - length)

    def index(self, s: float) -> int:
        """Number of the cell that holds s in [0, length): one look-up and `hops` comparisons, nearly always one."""
        i = self._of_bucket[int(s * self._per_bucket)]
        starts = self._starts
        while s >= starts[i + 1]:
            i += 1
        return i

    def straight(self, s: float) -> float:
        """Metres ahead of s along which the course stays within 10 deg of that at s; 1e6 when it never bends again."""
        length = self.length
        if self.closed:
            if not 0.0 <= s < length:
                s = within_lap(s, length)
        elif s < 0.0:
            return min(self._stops[0] - s, NEVER_M)
        if not 0.0 <= s < length:
            return NEVER_M
        i = self.index(s)
        return min(max(self._stops[i] + self._rise[i] * (s - self._starts[i]) - s, 0.0), NEVER_M)

    def project(self, x: float, y: float, low: float | None = None, high: float | None = None) -> float:
        """Abscissa of the point nearest to (x, y) [m], the lowest one of equals.

        Open: the path goes straight on beyond both ends, so s may be negative or above the length. Closed: in
        [0, length). With low or high only [low, high] is searched, laps counted.
        """
        best = nearest.Best(x, y)
        if self.closed:
            self._project_closed(best, low, high)
            return 0.0 if low is None and high is None and best.s >= self.length else best.s
        least = -math.inf if low is None else low
        most = math.inf if high is None else high
        if least <= 0.0:
            best.try_ray(self._first, 0.0, least, min(most, 0.0))
        if most > 0.0 and least < self.length:
            i, j = self._reach(max(least, 0.0), min(most, self.length))
            best.try_cells(self.cells[i : j + 1], max(least, 0.0), min(most, self.length), 0.0)
        if most >= self.length:
            best.try_ray(self._last, self.length, max(least, self.length), most)
        return best.s

    def _project_closed(self, best: nearest.Best, low: float | None, high: float | None) -> None:
        """Search a closed path, lap by lap of the window."""
        length = self.length
        least = low if low is not None else (0.0 if high is None else high - length)
        most = high if high is not None else least + length
        lap = ops.floor(least / length)
        while lap * length <= most:
            a, b = max(least - lap * length, 0.0), min(most - lap * length, length)
            if a <= b:
                i, j = self._reach(a, b)
                best.try_cells(self.cells[i : j + 1], a, b, lap * length)
            lap += 1.0

    def _reach(self, a: float, b: float) -> tuple[int, int]:
        """Numbers of the first and the last cell of [a, b] within [0, length]."""
        last = len(self.cells) - 1
        return (self.index(a) if a < self.length else last), (self.index(b) if b < self.length else last)

    def _fill_buckets(self) -> None:
        """Uniform table from s to the cell at the start of its bucket; buckets are no longer than the shortest cell."""
        starts = self._starts
        shortest = min(b - a for a, b in pairwise(starts))
        width = max(shortest, self.length / _MOST_BUCKETS)
        self._per_bucket = per = 1.0 / width
        table: list[int] = []
        for i, end in enumerate(starts[1:]):
            table.extend([i] * (math.ceil(end * per) - len(table)))
        table.append(len(starts) - 2)
        self._of_bucket = table
        last = len(table) - 1
        self.hops = max(table[min(k + 1, last)] - table[k] for k in range(len(table)))

    def _fill_stops(self, turns: list[float]) -> None:
        """For each cell, where the band of 10 deg about its first course is left, and how that grows with s."""
        laps = 2 if self.closed else 1
        course, nodes = [0.0], [0.0]
        for lap in range(laps):
            for end, turn in zip(self._starts[1:], turns, strict=True):
                course.append(course[-1] + turn)
                nodes.append(end + lap * self.length)
        stops = _leave_band(nodes, course)
        self._stops, self._rise = [], []
        for i in range(len(turns)):
            here, there, long = stops[i], stops[i + 1], nodes[i + 1] - nodes[i]
            step = there - here
            if 0.0 <= step <= 2.0 * long:  # the stop moves on with us, as on an arc
                self._stops.append(here)
                self._rise.append(step / long)
            else:
                self._stops.append(min(here, there))
                self._rise.append(0.0)


def _leave_band(nodes: list[float], course: list[float]) -> list[float]:
    """For each node the abscissa where the course first differs by 10 deg, infinite if never.

    From the last node back, keeping the nodes that are higher (lower) than all between: the first one out of the band
    is among them, and they are sorted.
    """
    stops = [math.inf] * len(nodes)
    higher: list[float] = []  # minus the course, ascending; the nearest node last
    higher_at: list[int] = []
    lower: list[float] = []
    lower_at: list[int] = []
    for i in range(len(nodes) - 1, -1, -1):
        own = course[i]
        k = bisect_left(higher, -own - _BAND) - 1
        if k >= 0:
            stops[i] = _crossing(nodes, course, higher_at[k], own + _BAND)
        k = bisect_left(lower, own - _BAND) - 1
        if k >= 0:
            stops[i] = min(stops[i], _crossing(nodes, course, lower_at[k], own - _BAND))
        while higher and higher[-1] >= -own:
            higher.pop()
            higher_at.pop()
        higher.append(-own)
        higher_at.append(i)
        while lower and lower[-1] >= own:
            lower.pop()
            lower_at.pop()
        lower.append(own)
        lower_at.append(i)
    return stops


def _crossing(nodes: list[float], course: list[float], j: int, level: float) -> float:
    """Abscissa between nodes j - 1 and j where the course passes the level."""
    share = (level - course[j - 1]) / (course[j] - course[j - 1])
    return nodes[j - 1] + share * (nodes[j] - nodes[j - 1])


def sample(path: Path, step: float) -> list[tuple[float, float]]:
    """Points of the path every `step` metres and at its end, for pictures."""
    if not step > 0.0:
        raise PathError(f"step of the sample is {step} m; expected a number > 0")
    count = math.ceil(path.length / step)
    points = [path.at(min(k * step, path.length)) for k in range(count + 1)]
    return [(p.x, p.y) for p in points]
