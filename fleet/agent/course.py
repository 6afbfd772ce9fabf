"""Which path the boat is on: its mission's, back along its own track, or none; and where on it it begins."""

from __future__ import annotations

import math
from collections.abc import Sequence

from msgspec import Struct

from fleet.agent.sailing import Sailing
from fleet.mission.pattern import Shape
from fleet.mission.plan import Plan
from fleet.paths import Lane, Path, PathError, Shift, lane, shift_length, straight, through

ENDLESS = 1.0e18
TRACK_STEP_M = 10.0
LARGEST_TRACK = 400
WINDOW_M = 50.0  # a boat that resumes is looked for this far around where its virtual target was

Point = tuple[float, float]


class Course(Struct, frozen=True):
    """A path and where it ends."""

    kind: str  # "mission", "track" or "point"
    path: Path | Lane
    points: tuple[Point, ...] = ()  # of a track or a point, so that a replay can build it again

    @property
    def abeam(self) -> float:
        """Metres to starboard of the mission's path."""
        return self.path.n if isinstance(self.path, Lane) else 0.0

    @property
    def shift(self) -> Shift | None:
        """The change of lanes on the way, if there was one."""
        return self.path.shift if isinstance(self.path, Lane) else None

    def stretch(self, s: float) -> float:
        """Metres of this path for a metre of abscissa."""
        return self.path.stretch(s) if isinstance(self.path, Lane) else 1.0


def at_point(x: float, y: float) -> Course:
    """No path: somewhere to be while there is no mission."""
    return Course("point", straight((x, y), (x + 100.0, y)), ((x, y),))


def along_mission(sailing: Sailing) -> Course:
    """The boat's path in its mission, or the lane of its slot beside it."""
    return Course("mission", sailing.plan.boats[sailing.number].lane(sailing.shape))


def over_to(course: Course, n: float, s: float, length: float, radius: float) -> Course:
    """The same path, over to the lane n metres to starboard of it, from abscissa s on.

    Args:
        course: as it was
        n: the new lane's offset [m]
        s: abscissa now [m]
        length: within which the others change lanes; more is taken where the boat needs it [m]
        radius: that the boat can turn [m]
    """
    path = course.path
    before, slope, _ = path.offset(s) if isinstance(path, Lane) else (0.0, 0.0, 0.0)
    if n == before and slope == 0.0:
        return course
    base = path.path if isinstance(path, Lane) else path
    return Course("mission", lane(base, n, Shift(s, max(length, shift_length(n - before, radius)), before, slope)))


def back_along(track: Sequence[Point], here: Point, home: Point | None) -> Course | None:
    """The travelled track backwards from here, then home; None when there is nowhere to go."""
    points: list[Point] = [here]
    for point in (*reversed(track), *([home] if home is not None else [])):
        if math.dist(point, points[-1]) >= TRACK_STEP_M * 0.5:
            points.append(point)
    if len(points) < 2:
        return None
    return of_track(tuple(points))


def of_track(points: tuple[Point, ...]) -> Course | None:
    """A smooth path through the points of a track."""
    try:
        path = straight(points[0], points[1]) if len(points) == 2 else through(points)
    except PathError:
        return None
    return Course("track", path, points)


class Track:
    """Where the boat has been: a point every 10 m; when there are many, every second one is dropped."""

    def __init__(self, points: Sequence[Point] = ()) -> None:
        self.points: list[Point] = list(points)

    def add(self, x: float, y: float) -> None:
        """The boat is here now."""
        points = self.points
        if points and math.dist(points[-1], (x, y)) < TRACK_STEP_M:
            return
        points.append((x, y))
        if len(points) > LARGEST_TRACK:
            del points[1:-1:2]


def start_abscissa(
    sailing: Sailing, x: float, y: float, reference: tuple[float, float] | None, around: float | None = None
) -> float:
    """Abscissa at which a boat at (x, y) begins or goes on.

    Args:
        sailing: the mission
        x, y: position [m]
        reference: (abscissa, offset) of the lowest slot present, which tells the lap on a closed path; None: lap 0
        around: where its virtual target was; only the neighbourhood is searched
    """
    path = along_mission(sailing).path
    if around is not None:
        return path.project(x, y, around - WINDOW_M, around + WINDOW_M)
    raw = path.project(x, y)
    if not path.closed or reference is None:
        return raw
    s_ref, o_ref = reference
    offset = sailing.shape.ahead(sailing.number)
    return raw + path.length * math.floor((s_ref + offset - o_ref - raw) / path.length + 0.5)


def end_abscissa(plan: Plan, number: int, shape: Shape) -> float:
    """Where the mission ends for a boat: in its slot, when the foremost slot is at the end of its path.

    A wingman's own path ends where it ends: it stops beside its leader before.
    """
    boat = plan.boats[number]
    if boat.path.closed:
        return ENDLESS
    if shape.pattern == "wingman":
        return boat.path.length
    first = min(other.path.length - shape.ahead(other.number) for other in plan.boats if not other.path.closed)
    return min(first + shape.ahead(number), boat.path.length)


def inside(polygon: Sequence[Point], x: float, y: float) -> bool:
    """Whether a point lies in a simple polygon (even-odd rule); an empty polygon holds everything."""
    if not polygon:
        return True
    result = False
    x0, y0 = polygon[-1]
    for x1, y1 in polygon:
        if (y0 > y) != (y1 > y) and x < (x1 - x0) * (y - y0) / (y1 - y0) + x0:
            result = not result
        x0, y0 = x1, y1
    return result
