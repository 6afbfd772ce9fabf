"""Many paths in one table: every lane of a batch evaluates its own path, with the bits of `Path`.

For simulators only; an agent has one path and no numpy.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from fleet import ops
from fleet.ops import FloatArray
from fleet.paths.curve import Cell, PathPoint, beyond, evaluate, within_lap
from fleet.paths.path import NEVER_M, Path

IntArray = NDArray[np.intp]
_ROWS = 10  # x0..x3, y0..y3, s0, per_m: the fields of a cell


class _Cells(Struct, frozen=True):
    """The cells of all paths, one column each, and the buckets that find them."""

    rows: FloatArray  # (10, cells)
    ends: FloatArray  # abscissa where a cell ends [m]
    stops: FloatArray  # where its course has left the band of 10 deg [m]
    rises: FloatArray
    of_bucket: IntArray  # bucket -> cell
    hops: int


class _Lanes(Struct, frozen=True):
    """What a lane needs of its path."""

    bucket: IntArray  # its first one
    per_bucket: FloatArray
    length: FloatArray
    closed: NDArray[np.bool_]
    stop: FloatArray  # of its first cell
    first: PathPoint[FloatArray]
    last: PathPoint[FloatArray]
    line: NDArray[np.bool_]  # open, and one straight cell
    x1: FloatArray  # of the first cell; for lines
    y1: FloatArray
    per_m: FloatArray


class PathTable:
    """One path per lane, out of a ragged table of cubic cells."""

    __slots__ = ("_cells", "_closed", "_lanes", "_lines")

    def __init__(self, paths: Sequence[Path], lanes: Sequence[int] | IntArray) -> None:
        """paths: all that occur; lanes: number of the path of each lane."""
        self._cells = _cells(paths)
        self._set(_taken(_per_path(paths), np.asarray(lanes, dtype=np.intp)))

    def _set(self, lanes: _Lanes) -> None:
        self._lanes = lanes
        self._lines = bool(lanes.line.all())
        self._closed = bool(lanes.closed.any())

    @property
    def length(self) -> FloatArray:
        """Length of each lane's path [m]."""
        return self._lanes.length

    @property
    def closed(self) -> NDArray[np.bool_]:
        """Where the path is closed."""
        return self._lanes.closed

    def take_lanes(self, lanes: IntArray) -> PathTable:
        """The table of some lanes only; the cells are shared."""
        table = PathTable.__new__(PathTable)
        table._cells = self._cells
        table._set(_taken(self._lanes, lanes))
        return table

    def at(self, s: FloatArray) -> PathPoint[FloatArray]:
        """The points at abscissae s [m], as `Path.at`."""
        lane = self._lanes
        if self._lines:
            return self._on_lines(s)
        if self._closed:
            s = self._lap(s)
        inside = (s >= 0.0) & (s < lane.length)
        everywhere = bool(inside.all())
        within = s if everywhere else np.where(inside, s, 0.0)
        cell: Cell[FloatArray] = Cell(*self._cells.rows.take(self._index(within), axis=1))
        point = evaluate(cell, (within - cell.s0) * cell.per_m)
        return point if everywhere else _chosen(inside, point, self._beyond(s))

    def straight(self, s: FloatArray) -> FloatArray:
        """Metres ahead of s for which the course stays within 10 deg, as `Path.straight`."""
        lane, cells = self._lanes, self._cells
        if self._lines:
            return np.full_like(s, NEVER_M)
        if self._closed:
            s = self._lap(s)
        inside = (s >= 0.0) & (s < lane.length)
        within = np.where(inside, s, 0.0)
        i = self._index(within)
        ahead = cells.stops[i] + cells.rises[i] * (within - cells.rows[8, i]) - within
        ahead = ops.minimum(ops.maximum(ahead, 0.0), NEVER_M)
        before = ops.minimum(lane.stop - np.where(inside, 0.0, s), NEVER_M)
        return np.where(inside, ahead, np.where((s < 0.0) & ~lane.closed, before, NEVER_M))

    def _lap(self, s: FloatArray) -> FloatArray:
        """Laps of closed paths taken off."""
        lane = self._lanes
        round_again = lane.closed & ~((s >= 0.0) & (s < lane.length))
        if not round_again.any():
            return s
        return np.where(round_again, within_lap(s, lane.length), s)  # type: ignore[arg-type]

    def _index(self, s: FloatArray) -> IntArray:
        """Cell of an abscissa within [0, length)."""
        lane, cells = self._lanes, self._cells
        i = cells.of_bucket[lane.bucket + (s * lane.per_bucket).astype(np.intp)]
        for _ in range(cells.hops):
            i = i + (s >= cells.ends[i])
        return i

    def _beyond(self, s: FloatArray) -> PathPoint[FloatArray]:
        """Straight on before the first and after the last point."""
        lane = self._lanes
        before = s < 0.0
        return beyond(_chosen(before, lane.first, lane.last), np.where(before, s, s - lane.length))

    def _on_lines(self, s: FloatArray) -> PathPoint[FloatArray]:
        """As `evaluate`, which adds zeros to these values on a straight cell."""
        lane = self._lanes
        t = s * lane.per_m
        first = lane.first
        point = PathPoint(first.x + t * lane.x1, first.y + t * lane.y1, first.tx, first.ty, first.c)
        inside = (s >= 0.0) & (s < lane.length)
        return point if inside.all() else _chosen(inside, point, self._beyond(s))


def _chosen(cond: NDArray[np.bool_], a: PathPoint[FloatArray], b: PathPoint[FloatArray]) -> PathPoint[FloatArray]:
    return PathPoint(
        np.where(cond, a.x, b.x),
        np.where(cond, a.y, b.y),
        np.where(cond, a.tx, b.tx),
        np.where(cond, a.ty, b.ty),
        np.where(cond, a.c, b.c),
    )


def _cells(paths: Sequence[Path]) -> _Cells:
    """The tables of all paths, one after the other."""
    cells = [cell for path in paths for cell in path.cells]
    rows = np.array([[getattr(cell, name) for cell in cells] for name in Cell.__struct_fields__])
    assert len(rows) == _ROWS
    begins = np.cumsum([0, *(len(path.cells) for path in paths)])
    return _Cells(
        rows=rows,
        ends=np.array([end for path in paths for end in path._starts[1:]]),
        stops=np.array([stop for path in paths for stop in path._stops]),
        rises=np.array([rise for path in paths for rise in path._rise]),
        of_bucket=np.concatenate(
            [np.array(path._of_bucket, dtype=np.intp) + begin for path, begin in zip(paths, begins, strict=False)]
        ),
        hops=max(path.hops for path in paths),
    )


def _per_path(paths: Sequence[Path]) -> _Lanes:
    """What a lane needs, for each path."""

    def points(ends: list[PathPoint[float]]) -> PathPoint[FloatArray]:
        return PathPoint(*(np.array([getattr(p, name) for p in ends]) for name in PathPoint.__struct_fields__))

    return _Lanes(
        bucket=np.cumsum([0, *(len(path._of_bucket) for path in paths[:-1])]),
        per_bucket=np.array([path._per_bucket for path in paths]),
        length=np.array([path.length for path in paths]),
        closed=np.array([path.closed for path in paths]),
        stop=np.array([path._stops[0] for path in paths]),
        first=points([path._first for path in paths]),
        last=points([path._last for path in paths]),
        line=np.array([_is_line(path) for path in paths]),
        x1=np.array([path.cells[0].x1 for path in paths]),
        y1=np.array([path.cells[0].y1 for path in paths]),
        per_m=np.array([path.cells[0].per_m for path in paths]),
    )


def _is_line(path: Path) -> bool:
    cell = path.cells[0]
    signed = any(v == 0.0 and math.copysign(1.0, v) < 0.0 for v in (cell.x1, cell.y1))  # -0.0: no two ways agree
    return not path.closed and len(path.cells) == 1 and cell.x2 == cell.x3 == cell.y2 == cell.y3 == 0.0 and not signed


def _taken(lanes: _Lanes, index: IntArray) -> _Lanes:
    """The given lanes of everything."""

    def points(p: PathPoint[FloatArray]) -> PathPoint[FloatArray]:
        return PathPoint(p.x[index], p.y[index], p.tx[index], p.ty[index], p.c[index])

    return _Lanes(
        lanes.bucket[index],
        lanes.per_bucket[index],
        lanes.length[index],
        lanes.closed[index],
        lanes.stop[index],
        points(lanes.first),
        points(lanes.last),
        lanes.line[index],
        lanes.x1[index],
        lanes.y1[index],
        lanes.per_m[index],
    )
