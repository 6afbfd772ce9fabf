"""From waypoints to a mission: whose roster, which limits, how round the corners. Pure; `check` has the last word."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct, structs

from fleet.errors import FleetError
from fleet.gcs.items import Course
from fleet.geo import Datum, plane_of
from fleet.mission.model import (
    Boat,
    Fence,
    Formation,
    Geographic,
    KeepingClear,
    Mission,
    PathSpec,
    Place,
    Polyline,
    Start,
    Straight,
)
from fleet.mission.pattern import PATTERNS as PATTERN_KINDS
from fleet.mission.pattern import Shape, slots_of
from fleet.mission.plan import build

PATH = "uploaded"
SPACING_M, CRUISE_MPS = 15.0, 1.0
ROOM = 1.05  # of the least radius: arcs are cut into pieces, and one of them may bend a little more
LONGER = 3.0  # times the way at cruise speed: what a mission is given, in a simulation
AT_LEAST_S = 600.0
PATTERNS = tuple(PATTERN_KINDS)
"""By their numbers in the parameter FLT_PATTERN."""


class Pose(Struct, frozen=True):
    """Where a boat lies."""

    lat_deg: float
    lon_deg: float
    heading_deg: float


class Draft(Struct):
    """What a ground station set for the next mission; None: as it is."""

    spacing_m: float | None = None
    lateral_m: float | None = None
    cruise_mps: float | None = None
    pattern: str | None = None
    gain_per_m: float | None = None
    radius_m: float | None = None


class Basis(Struct, frozen=True):
    """What a new path is laid into."""

    boats: Mapping[str, Pose]  # those that are heard
    mission: Mission | None = None  # held by the boats, or the template: roster, limits, fence, home
    shape: Shape | None = None  # the formation in force, where it is held


def formation_of(basis: Basis, draft: Draft) -> tuple[Formation, float]:
    """The formation of the next mission, without slots, and R [m]."""
    mission = basis.mission
    base = mission.formation if mission is not None else Formation(spacing_m=SPACING_M, cruise_mps=CRUISE_MPS)
    radius_m = mission.keeping_clear.radius_m if mission is not None else KeepingClear().radius_m
    shape = basis.shape
    if shape is not None:
        base = structs.replace(
            base,
            spacing_m=shape.spacing_m,
            lateral_m=shape.lateral_m,
            cruise_mps=shape.cruise_mps,
            pattern=shape.pattern,
        )
    names = ("spacing_m", "lateral_m", "cruise_mps", "pattern", "gain_per_m")
    wanted = {name: value for name in names if (value := getattr(draft, name)) is not None}
    return structs.replace(base, **wanted), radius_m if draft.radius_m is None else draft.radius_m


def chart(course: Course, boat: str, basis: Basis, draft: Draft, *, alone: bool, title: str = "") -> Mission:
    """The mission that a ground station asks for; FleetError when it asks for something that does not fit.

    Args:
        course: the way
        boat: to which it was sent
        basis: who sails it, and within what
        draft: what was set for it
        alone: for that boat only
        title: of the mission
    """
    if boat not in basis.boats:
        raise FleetError(f"{boat} is not heard")
    roster = _roster(boat, basis, draft, alone=alone)
    formation, radius_m = formation_of(basis, draft)
    if alone:
        formation = structs.replace(formation, pattern="column", lateral_m=None)
    if course.cruise_mps is not None:
        formation = structs.replace(formation, cruise_mps=course.cruise_mps)
    datum = course.points[0]
    base = basis.mission
    mission = Mission(
        title=title or (f"{boat} alone, from a ground station" if alone else "From a ground station"),
        datum=datum,
        paths={PATH: Straight(start=course.points[0], end=course.points[-1])},
        boats=roster,
        formation=formation,
        duration_s=AT_LEAST_S,
    )
    if base is not None:
        clear = structs.replace(base.keeping_clear, radius_m=radius_m)
        mission = structs.replace(
            mission,
            keeping_clear=clear,
            fence=_moved_fence(base),
            home=_geographic(base.home, base) if base.home is not None else None,
            battery=base.battery,
            lost=base.lost,
            state_hz=base.state_hz,
            environment=base.environment,
        )
    elif radius_m != mission.keeping_clear.radius_m:
        mission = structs.replace(mission, keeping_clear=KeepingClear(radius_m=radius_m))
    mission = structs.replace(mission, paths={PATH: _path(course, mission)})
    long = build(mission).paths[PATH].length
    return structs.replace(mission, duration_s=max(AT_LEAST_S, LONGER * long / formation.cruise_mps))


def turning_radius_m(mission: Mission) -> float:
    """What every boat of the roster can turn within at its fastest, inside a bend too [m].

    A boat that catches up sails faster than cruise; one beside the path has the tighter bend.
    """
    radius_m = ROOM * max(boat.limits.speed_max_mps / boat.limits.yaw_rate_max_radps for boat in mission.boats)
    formation = mission.formation
    if not PATTERN_KINDS[formation.pattern].lateral:
        return radius_m
    lateral = abs(formation.spacing_m) if formation.lateral_m is None else abs(formation.lateral_m)
    return radius_m + lateral * max(abs(boat.slot) for boat in mission.boats)


def _path(course: Course, mission: Mission) -> PathSpec:
    points = course.points
    if len(points) == 2 and not course.closed:
        return Straight(start=points[0], end=points[1])
    return Polyline(points=points, corner_radius_m=round(turning_radius_m(mission), 2), closed=course.closed)


def _roster(boat: str, basis: Basis, draft: Draft, *, alone: bool) -> tuple[Boat, ...]:
    """The boats that sail it, each where it lies."""
    known = {one.name: one for one in basis.mission.boats} if basis.mission is not None else {}
    if not alone and known and boat not in known:
        raise FleetError(f"{boat} is not in the roster ({', '.join(known)}); FLT_ALONE 1 sends it by itself")
    names = [boat] if alone else list(known) or sorted(basis.boats)
    pattern = draft.pattern or "column"
    fresh = dict(zip(names, slots_of(pattern, len(names)), strict=True))
    if basis.shape is not None and basis.mission is not None and not alone:
        held = dict(zip((one.name for one in basis.mission.boats), basis.shape.slots, strict=True))
        same = draft.pattern in (None, basis.shape.pattern)
        slots = held if same else fresh
    elif known and not alone and draft.pattern in (None, basis.mission.formation.pattern if basis.mission else None):
        slots = {name: known[name].slot for name in names}
    else:
        slots = fresh
    roster = []
    for name in names:
        pose = basis.boats.get(name) or basis.boats[boat]
        position = Geographic(lat_deg=pose.lat_deg, lon_deg=pose.lon_deg)
        start = Start(position=position, heading_deg=pose.heading_deg)
        slot = 0.0 if alone else slots[name]
        one = known.get(name) or Boat(name=name, path=PATH, slot=slot, start=start)
        roster.append(structs.replace(one, path=PATH, slot=slot, start=start))
    return tuple(roster)


def _geographic(place: Place, mission: Mission) -> Geographic:
    """A place of a mission, whatever the datum."""
    if isinstance(place, Geographic):
        return place
    plane = plane_of(Datum(mission.datum.lat_deg, mission.datum.lon_deg))
    lat, lon = plane.to_geographic(*place)
    return Geographic(lat_deg=lat, lon_deg=lon)


def _moved_fence(mission: Mission) -> Fence | None:
    fence = mission.fence
    if fence is None:
        return None
    return structs.replace(fence, points=tuple(_geographic(point, mission) for point in fence.points))


def straight_to(pose: Pose, target: Geographic, cruise_mps: float | None) -> Course:
    """From where a boat lies to a place."""
    here = Geographic(lat_deg=pose.lat_deg, lon_deg=pose.lon_deg)
    return Course((here, target), (0, 1), cruise_mps=cruise_mps)
