"""Can boats sail beside their path: in its bends, at their speeds, within the fence?"""

from __future__ import annotations

from collections.abc import Iterator

from fleet.mission.fence import inside, samples
from fleet.mission.misfit import CRUISE_MARGIN_MPS, Misfit
from fleet.mission.pattern import PATTERNS, Shape
from fleet.mission.plan import BoatPlan, Plan
from fleet.paths import Path


def lane_misfits(plan: Plan, shape: Shape) -> Iterator[Misfit]:
    """Lanes that nobody can sail, the worst of each path and side, and where."""
    if not PATTERNS[shape.pattern].lateral:
        return
    for name, path in plan.paths.items():
        boats = [boat for boat in plan.boats if boat.path_name == name and shape.abeam(boat.number) != 0.0]
        boats.sort(key=lambda boat: shape.abeam(boat.number))
        for boat in {b.number: b for b in (boats[:1] + boats[-1:])}.values():
            wrong = _bend(boat, path, shape) or _speed(boat, path, shape) or _outside(plan, boat, shape)
            if wrong:
                yield Misfit("lateral_m", wrong)


def _bend(boat: BoatPlan, path: Path, shape: Shape) -> str:
    """The tightest bend of a lane, where it is tighter than the boat can turn.

    A lane n to starboard of a bend to starboard of radius r has the radius r - n there, and a cusp where that is 0.
    """
    n = shape.abeam(boat.number)
    c, s = path.bends[n > 0.0]
    need = boat.limits.speed_max_mps / boat.limits.yaw_rate_max_radps
    if c * n <= 0.0:
        return ""
    radius = 1.0 / abs(c) - abs(n)
    if radius >= need - 1e-9:
        return ""
    where = f"{_lane(boat, n)} bends with a radius of {max(radius, 0.0):.1f} m {_at(path, s)}"
    rates = f"{boat.limits.speed_max_mps:g} m/s at {boat.limits.yaw_rate_max_radps:g} rad/s"
    return f"{where}; {boat.name} needs {need:.1f} m ({rates})"


def _speed(boat: BoatPlan, path: Path, shape: Shape) -> str:
    """Speeds on the lane, slower inside a bend and faster outside it, that the boat cannot keep."""
    n = shape.abeam(boat.number)
    for c, s in path.bends:
        u = shape.cruise_mps * (1.0 - c * n)
        low = boat.limits.speed_min_mps + CRUISE_MARGIN_MPS
        high = boat.limits.speed_max_mps - CRUISE_MARGIN_MPS
        if not low - 1e-9 <= u <= high + 1e-9:
            where = f"{_lane(boat, n)} asks for {u:.2f} m/s {_at(path, s)}"
            return f"{where}; {boat.name} needs {low:g} to {high:g} m/s to keep its place"
    return ""


def _outside(plan: Plan, boat: BoatPlan, shape: Shape) -> str:
    """Where a lane leaves the fence."""
    for s, (x, y) in samples(boat.lane(shape)) if plan.fence else ():
        if not inside((x, y), plan.fence):
            return f"{_lane(boat, shape.abeam(boat.number))} leaves the fence at {s:.0f} m, at [{x:.1f}, {y:.1f}] m"
    return ""


def _lane(boat: BoatPlan, n: float) -> str:
    return f"the lane {abs(n):g} m to {'starboard' if n > 0.0 else 'port'} of path {boat.path_name}"


def _at(path: Path, s: float) -> str:
    p = path.at(s)
    return f"at {s:.0f} m, at [{p.x:.1f}, {p.y:.1f}] m"
