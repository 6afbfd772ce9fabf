"""Where the boats begin, how their paths bend, and whether all of it lies inside the fence."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

from fleet.mission.fence import inside, samples
from fleet.mission.formation import gap_needed
from fleet.mission.plan import BoatPlan, Plan, Point
from fleet.mission.problem import Problem


def water_problems(plan: Plan) -> Iterator[Problem]:
    """Start poses, bends and fence."""
    yield from _starts(plan)
    yield from _bends(plan)
    if plan.fence:
        yield from _fence(plan)


def water_warnings(plan: Plan) -> Iterator[Problem]:
    """What will work, but not comfortably."""
    need = gap_needed(plan.mission)
    for boat, other, away in _neighbours(plan):
        if away < need - 1e-9:
            wrong = f"{boat.name} begins {away:.1f} m from {other.name}; slots need {need:.1f} m"
            yield Problem(("boats", boat.number, "start"), wrong)
    environment = plan.mission.environment
    slowest = min(boat.limits.speed_max_mps for boat in plan.boats)
    if environment.current_mps >= slowest:
        wrong = f"boats that make {slowest:g} m/s cannot stem it"
        yield Problem(("environment", "current_mps"), wrong, environment.current_mps)
    radius = plan.mission.keeping_clear.radius_m
    for name in {boat.path_name: None for boat in plan.boats} if plan.fence else ():
        near, s = min((_from_fence(point, plan.fence), s) for s, point in samples(plan.paths[name]))
        if near < radius:
            wrong = (
                f"{near:.1f} m from the fence at {s:.0f} m of its length; keeping clear needs {radius:g} m to move in"
            )
            yield Problem(("paths", name), wrong)


def _starts(plan: Plan) -> Iterator[Problem]:
    """Boats that begin off their path's length, or in each other's safety circle."""
    radius = plan.mission.keeping_clear.radius_m
    for boat in plan.boats:
        s = plan.mission.boats[boat.number].start.s_m
        if s is not None and not 0.0 <= s <= boat.path.length:
            wrong = f"path {boat.path_name} goes from 0 to {boat.path.length:.1f} m"
            yield Problem(("boats", boat.number, "start", "s_m"), wrong, s)
    for boat, other, away in _neighbours(plan):
        if away < radius - 1e-9:
            wrong = f"{boat.name} begins {away:.1f} m from {other.name}; at least the safety radius, {radius:.1f} m"
            yield Problem(("boats", boat.number, "start"), wrong)


def _neighbours(plan: Plan) -> Iterator[tuple[BoatPlan, BoatPlan, float]]:
    """Every boat but the first, the nearest one of those before it in the roster, and the metres between them."""
    for i, boat in enumerate(plan.boats):
        if i:
            away = [math.hypot(boat.x - other.x, boat.y - other.y) for other in plan.boats[:i]]
            yield boat, plan.boats[away.index(min(away))], min(away)


def _bends(plan: Plan) -> Iterator[Problem]:
    """Paths that bend more than the boats on them can turn at their highest speed."""
    for name, path in plan.paths.items():
        tight = []
        for boat in plan.boats:
            needed = boat.limits.speed_max_mps / boat.limits.yaw_rate_max_radps
            if boat.path_name == name and path.max_curvature * needed > 1.0 + 1e-9:
                tight.append((needed, boat))
        if tight:
            needed, boat = max(tight, key=lambda item: item[0])
            more = f" (and {len(tight) - 1} more)" if len(tight) > 1 else ""
            rates = f"{boat.limits.speed_max_mps:g} m/s at {boat.limits.yaw_rate_max_radps:g} rad/s"
            bend = 1.0 / path.max_curvature
            wrong = f"bends with a radius of {bend:.1f} m; {boat.name}{more} needs {needed:.1f} m ({rates})"
            yield Problem(("paths", name), wrong)


def _fence(plan: Plan) -> Iterator[Problem]:
    """A fence that crosses itself; starts, home and paths outside it."""
    crossing = _crosses_itself(plan.fence)
    if crossing is not None:
        wrong = f"crosses itself: the edges that begin at points {crossing[0] + 1} and {crossing[1] + 1} meet"
        yield Problem(("fence", "points"), wrong)
        return
    if plan.home is not None and not inside(plan.home, plan.fence):
        yield Problem(("home",), "outside the fence", plan.home)
    for boat in plan.boats:
        if not inside((boat.x, boat.y), plan.fence):
            yield Problem(("boats", boat.number, "start"), f"outside the fence, at [{boat.x:.1f}, {boat.y:.1f}] m")
    for name in {boat.path_name: None for boat in plan.boats}:
        for s, point in samples(plan.paths[name]):
            if not inside(point, plan.fence):
                wrong = f"leaves the fence at {s:.0f} m of its length, at [{point[0]:.1f}, {point[1]:.1f}] m"
                yield Problem(("paths", name), wrong)
                break


def _from_fence(point: Point, corners: Sequence[Point]) -> float:
    """Distance to the nearest edge [m]."""
    x, y = point
    least = math.inf
    for (x1, y1), (x2, y2) in zip(corners, (*corners[1:], corners[0]), strict=True):
        ax, ay = x2 - x1, y2 - y1
        square = ax * ax + ay * ay
        t = ((x - x1) * ax + (y - y1) * ay) / square if square > 0.0 else 0.0
        t = min(max(t, 0.0), 1.0)
        least = min(least, math.hypot(x - x1 - t * ax, y - y1 - t * ay))
    return least


def _crosses_itself(corners: Sequence[Point]) -> tuple[int, int] | None:
    """Numbers of two edges that meet although they are not neighbours."""
    count = len(corners)
    edges = [(corners[i], corners[(i + 1) % count]) for i in range(count)]
    for i, j in combinations(range(count), 2):
        if j - i in (1, count - 1):
            continue
        (a, b), (c, d) = edges[i], edges[j]
        if _side(a, b, c) * _side(a, b, d) <= 0.0 and _side(c, d, a) * _side(c, d, b) <= 0.0:
            return i, j
    return None


def _side(a: Point, b: Point, p: Point) -> float:
    """+1 when p lies to starboard of a to b, -1 to port, 0 on the line."""
    cross = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
    return float((cross > 0.0) - (cross < 0.0))
