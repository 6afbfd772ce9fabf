"""Points inside and outside a fence."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from fleet.paths import Lane, Path, Point

STEP_M = 1.0  # between the points of a path that are held against the fence
MOST = 4000  # such points on one path


def inside(point: Point, corners: Sequence[Point]) -> bool:
    """Whether a point lies within a simple polygon; on its edge either way."""
    x, y = point
    within = False
    for (x1, y1), (x2, y2) in zip(corners, (*corners[1:], corners[0]), strict=True):
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) * (x2 - x1) / (y2 - y1):
            within = not within
    return within


def samples(path: Path | Lane) -> Iterator[tuple[float, Point]]:
    """Points along a path, one a metre."""
    count = min(max(math.ceil(path.length / STEP_M), 1), MOST)
    for i in range(count + 1):
        s = path.length * i / count
        point = path.at(s)
        yield s, (point.x, point.y)
