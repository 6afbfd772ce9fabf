"""A mission in metres: what agents, the world and pictures work with."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from msgspec import Struct

from fleet import ops
from fleet.errors import MissionError
from fleet.geo import Datum, Plane, plane_of
from fleet.guidance.limits import Limits
from fleet.mission.model import Arc, Boat, Geographic, Mission, PathSpec, Place, Polyline, Sine, Start, Steady, Straight
from fleet.mission.pattern import Shape
from fleet.mission.problem import Key, Problem, texts
from fleet.paths import Lane, Path, PathError, arc, lane, polyline, sine, straight, through

FARTHEST_M = 50_000.0  # from the datum; a flat sea is good for so much
LONGEST_M = 100_000.0  # one path; a day at 1.2 m/s
TIGHTEST_M = 0.5  # radius of a sine's bends; the paths' own builders refuse tighter curves, but only after long work

Point = tuple[float, float]
"""North, east of the datum [m]."""


class BoatPlan(Struct, frozen=True):
    """One boat of the roster, ready to sail."""

    number: int
    """Place in the roster, from 0."""
    name: str
    path_name: str
    path: Path
    slot: float
    limits: Limits
    hull: str
    s: float
    """Abscissa at which it begins [m]."""
    x: float
    y: float
    psi: float
    u: float
    """Start pose: north, east [m], heading [rad], surge speed [m/s]."""
    starts_late: bool
    """Its agent is not started at the beginning: the timeline starts it before it ever kills it."""

    def lane(self, shape: Shape) -> Path | Lane:
        """What it sails in a formation: its path, or the lane of its slot beside it."""
        return lane(self.path, shape.abeam(self.number))


class Plan(Struct, frozen=True):
    """A mission in metres on the tangent plane at its datum."""

    mission: Mission
    plane: Plane
    paths: dict[str, Path]
    boats: tuple[BoatPlan, ...]
    fence: tuple[Point, ...]
    """Corners; empty: no fence."""
    home: Point | None

    def boat(self, name: str) -> BoatPlan:
        """The boat of that name; KeyError if there is none."""
        for boat in self.boats:
            if boat.name == name:
                return boat
        raise KeyError(name)

    @property
    def shape(self) -> Shape:
        """The formation at launch."""
        return shape_of(self.mission)


def shape_of(mission: Mission) -> Shape:
    """The formation that a mission begins with."""
    formation = mission.formation
    return Shape(
        pattern=formation.pattern,
        spacing_m=formation.spacing_m,
        lateral_m=abs(formation.spacing_m) if formation.lateral_m is None else formation.lateral_m,
        cruise_mps=formation.cruise_mps,
        slots=tuple(boat.slot for boat in mission.boats),
    )


def build(mission: Mission) -> Plan:
    """The plan of a mission; MissionError where it has none. Whether it can be sailed is for `check` to say."""
    plan, problems = attempt(mission)
    if problems:
        raise MissionError("mission", texts(problems))
    return plan


def attempt(mission: Mission) -> tuple[Plan, tuple[Problem, ...]]:
    """As much of the plan as can be built, and why the rest cannot."""
    plane = plane_of(Datum(mission.datum.lat_deg, mission.datum.lon_deg))
    problems = list(_far(mission, plane))
    paths: dict[str, Path] = {}
    if not problems:
        for name, spec in mission.paths.items():
            wrong = _absurd(spec, plane)
            try:
                if wrong is None:
                    paths[name] = _path(spec, plane)
            except PathError as error:
                wrong = str(error)
            if wrong is not None:
                problems.append(Problem(("paths", name), wrong))
    late = _late(mission)
    shape = shape_of(mission)
    boats = []
    for number, boat in enumerate(mission.boats):
        misfits = tuple(_start_problems(boat.start, ("boats", number, "start")))
        problems.extend(misfits)
        if boat.path in paths and not misfits:
            path = paths[boat.path]
            boats.append(_boat(number, boat, path, lane(path, shape.abeam(number)), plane, boat.name in late))
    plan = Plan(
        mission=mission,
        plane=plane,
        paths=paths,
        boats=tuple(boats),
        fence=tuple(metres(place, plane) for place in mission.fence.points) if mission.fence else (),
        home=None if mission.home is None else metres(mission.home, plane),
    )
    return plan, tuple(problems)


def metres(place: Place, plane: Plane) -> Point:
    """A place of a mission on the tangent plane."""
    if isinstance(place, Geographic):
        return plane.to_local(place.lat_deg, place.lon_deg)
    return place


def places(mission: Mission) -> Iterator[tuple[Key, Place]]:
    """Every position written in a mission, and where."""
    for name, spec in mission.paths.items():
        key: Key = ("paths", name)
        if isinstance(spec, Straight | Sine):
            yield (*key, "start"), spec.start
            yield (*key, "end"), spec.end
        elif isinstance(spec, Arc):
            yield (*key, "centre"), spec.centre
        else:
            yield from (((*key, "points", i), point) for i, point in enumerate(spec.points))
    for i, boat in enumerate(mission.boats):
        if boat.start.position is not None:
            yield ("boats", i, "start", "position"), boat.start.position
    for i, vessel in enumerate(mission.traffic):
        if isinstance(vessel.track, Steady):
            yield ("traffic", i, "track", "start"), vessel.track.start
        else:
            yield from ((("traffic", i, "track", "points", j), point) for j, point in enumerate(vessel.track.points))
    if mission.fence is not None:
        yield from ((("fence", "points", i), point) for i, point in enumerate(mission.fence.points))
    if mission.home is not None:
        yield ("home",), mission.home


def _far(mission: Mission, plane: Plane) -> Iterator[Problem]:
    """Positions that cannot be meant: too far from the datum."""
    for key, place in places(mission):
        away = math.hypot(*metres(place, plane))
        if not away <= FARTHEST_M:
            shown = [place.lat_deg, place.lon_deg] if isinstance(place, Geographic) else place
            swapped = "; are latitude and longitude swapped?" if isinstance(place, Geographic) else ""
            yield Problem(
                key, f"{away / 1000:.0f} km from the datum; at most {FARTHEST_M / 1000:.0f} km{swapped}", shown
            )


def _absurd(spec: PathSpec, plane: Plane) -> str | None:
    """What a slip of the pen must not make us build, for it would take the memory or the day."""
    long = _rough_length(spec, plane)
    if not long <= LONGEST_M:
        return f"about {long / 1000:.0f} km long; at most {LONGEST_M / 1000:.0f} km"
    if isinstance(spec, Sine):
        bend = abs(spec.amplitude_m) * (math.tau / spec.wavelength_m) ** 2
        if bend * TIGHTEST_M > 1.0:
            return f"bends with a radius of {1.0 / bend:.2g} m; at least {TIGHTEST_M:g} m"
    return None


def _rough_length(spec: PathSpec, plane: Plane) -> float:
    """Length of a curve before it is built, to a factor of two [m]."""
    if isinstance(spec, Arc):
        return spec.radius_m * math.radians(abs(spec.turn_deg))
    if isinstance(spec, Straight | Sine):
        long = math.dist(metres(spec.start, plane), metres(spec.end, plane))
        return long * (1.0 + 4.0 * abs(spec.amplitude_m) / spec.wavelength_m) if isinstance(spec, Sine) else long
    return sum(math.dist(metres(a, plane), metres(b, plane)) for a, b in pairwise(spec.points))


def _path(spec: PathSpec, plane: Plane) -> Path:
    """The curve that a mission describes."""
    if isinstance(spec, Straight):
        return straight(metres(spec.start, plane), metres(spec.end, plane))
    if isinstance(spec, Arc):
        return arc(metres(spec.centre, plane), spec.radius_m, math.radians(spec.from_deg), math.radians(spec.turn_deg))
    if isinstance(spec, Sine):
        start, end = metres(spec.start, plane), metres(spec.end, plane)
        return sine(start, end, spec.amplitude_m, spec.wavelength_m)
    points = [metres(point, plane) for point in spec.points]
    if isinstance(spec, Polyline):
        return polyline(points, spec.corner_radius_m, spec.closed)
    return through(points, spec.closed)


def _start_problems(start: Start, key: Key) -> Iterator[Problem]:
    """A start is either a position with a heading, or an abscissa with an offset."""
    if start.position is None and start.s_m is None:
        yield Problem(key, "expected position and heading_deg, or s_m on its path")
    elif start.position is not None and start.s_m is not None:
        yield Problem(key, "expected either position and heading_deg or s_m, not both")
    elif start.position is not None and start.heading_deg is None:
        yield Problem((*key, "heading_deg"), "missing, needed with position: degrees clockwise from north")
    elif start.position is not None and start.offset_m != 0.0:
        yield Problem((*key, "offset_m"), "only with s_m: position says where the boat lies", start.offset_m)
    elif start.s_m is not None and start.heading_deg is not None:
        yield Problem(
            (*key, "heading_deg"), "only with position: with s_m the boat heads along its path", start.heading_deg
        )


def _boat(number: int, boat: Boat, path: Path, own: Path | Lane, plane: Plane, late: bool) -> BoatPlan:
    """One boat with its start pose, on the lane that it sails."""
    start = boat.start
    if start.s_m is not None:
        s = start.s_m % path.length if path.closed else start.s_m
        point = own.at(s)
        x, y = point.x - point.ty * start.offset_m, point.y + point.tx * start.offset_m
        psi = ops.atan2(point.ty, point.tx)
    else:
        assert start.position is not None
        x, y = metres(start.position, plane)
        s = own.project(x, y, 0.0, path.length)
        psi = math.radians(start.heading_deg or 0.0)
    return BoatPlan(
        number=number,
        name=boat.name,
        path_name=boat.path,
        path=path,
        slot=boat.slot,
        limits=boat.limits,
        hull=boat.hull,
        s=s,
        x=x,
        y=y,
        psi=ops.wrap(psi),
        u=start.speed_mps,
        starts_late=late,
    )


def _late(mission: Mission) -> set[str]:
    """Boats that are started before they are ever killed."""
    first: dict[str, str] = {}
    for event in sorted(mission.timeline, key=lambda event: event.at_s):
        if event.do in ("kill", "start"):
            for name in event.boats or [boat.name for boat in mission.boats]:
                first.setdefault(name, event.do)
    return {name for name, do in first.items() if do == "start"}
