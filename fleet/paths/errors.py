"""What cannot be a path."""

from __future__ import annotations

import math

from fleet.errors import UsageError

Point = tuple[float, float]
"""(north, east) [m]."""


class PathError(UsageError):
    """A path that cannot be drawn."""


def show(point: Point) -> str:
    """A point as messages write it."""
    return f"[{point[0]:.2f}, {point[1]:.2f}] m"


def need_finite(value: float, name: str) -> float:
    """The value as a float; refuses NaN and infinity."""
    if not math.isfinite(value):
        raise PathError(f"{name} is {value}; expected a finite number")
    return float(value)


def need_positive(value: float, name: str, unit: str = "m") -> float:
    """The value as a float; refuses what is not above zero."""
    if not (math.isfinite(value) and value > 0.0):
        raise PathError(f"{name} is {value} {unit}; expected a number > 0")
    return float(value)


def need_points(points: tuple[Point, ...], least: int, closed: bool, same_below: float = 1e-3) -> tuple[Point, ...]:
    """The points as floats; refuses too few, not finite ones, and neighbours that coincide."""
    if len(points) < least:
        raise PathError(f"path has {len(points)} points; expected at least {least}")
    checked = tuple(
        (need_finite(x, f"north of point {i}"), need_finite(y, f"east of point {i}"))
        for i, (x, y) in enumerate(points, start=1)
    )
    for i in range(len(checked) if closed else len(checked) - 1):
        a, b = checked[i], checked[(i + 1) % len(checked)]
        if math.hypot(b[0] - a[0], b[1] - a[1]) < same_below:
            hint = " (a closed path ends at its first point by itself)" if i + 1 == len(checked) else ""
            raise PathError(
                f"points {i + 1} and {(i + 1) % len(checked) + 1} coincide at {show(a)}; "
                f"expected neighbours apart from each other{hint}"
            )
    return checked
