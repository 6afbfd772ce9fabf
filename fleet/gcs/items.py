"""Items of a MAVLink mission: what a ground station uploads, and what a path looks like to it. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from msgspec import Struct

from fleet.errors import FleetError
from fleet.gcs import numbers as n
from fleet.mission.model import Geographic, Place, Polyline
from fleet.mission.plan import Plan, metres

SUPPORTED = frozenset((n.WAYPOINT, n.LOITER_UNLIMITED, n.DO_JUMP, n.DO_CHANGE_SPEED))
EVERY_M, MOST_SHOWN = 10.0, 200  # a curve is shown by points so far apart, and by so many at most
E7 = 1e7


class Item(Struct, frozen=True):
    """One item, with the numbers that it came with."""

    seq: int
    frame: int
    command: int
    current: int
    autocontinue: int
    params: tuple[float, float, float, float]
    x: int  # latitude [1e-7 deg]
    y: int  # longitude [1e-7 deg]
    z: float


class Course(Struct, frozen=True):
    """What the items say."""

    points: tuple[Geographic, ...]
    seqs: tuple[int, ...]  # item of each point
    closed: bool = False
    cruise_mps: float | None = None


class WrongItem(FleetError):
    """A mission that is not one of ours: the item and why."""

    def __init__(self, result: int, text: str) -> None:
        self.result = result
        super().__init__(text)


def item_of(m: Any) -> Item:
    """The item of a MISSION_ITEM_INT or a MISSION_ITEM."""
    x, y = (m.x, m.y) if m.get_type() == "MISSION_ITEM_INT" else (_e7(m.x), _e7(m.y))
    params = (m.param1, m.param2, m.param3, m.param4)
    return Item(m.seq, m.frame, m.command, m.current, m.autocontinue, params, x, y, m.z)


def _e7(degrees: float) -> int:
    return round(degrees * E7) if abs(degrees) <= 214.0 else 2**31 - 1  # not on Earth either way


def place_of(x: int, y: int) -> Geographic | None:
    """Where that is; None: nowhere on Earth, or where receivers without a fix say that they are."""
    lat, lon = x / E7, y / E7
    return Geographic(lat_deg=lat, lon_deg=lon) if abs(lat) <= 90.0 and abs(lon) <= 180.0 and (x or y) else None


def refusal(item: Item, *, home: bool) -> tuple[int, str]:
    """(result, words) for an item that cannot be sailed wherever it stands; (ACCEPTED, '') for one that can."""
    if home:
        return n.MISSION_ACCEPTED, ""
    if item.command not in SUPPORTED:
        return n.MISSION_UNSUPPORTED, f"item {item.seq}: command {item.command} cannot be sailed"
    if item.command in (n.WAYPOINT, n.LOITER_UNLIMITED):
        if item.frame not in n.GLOBAL_FRAMES:
            return n.BAD_FRAME, f"item {item.seq}: frame {item.frame}; expected latitude and longitude"
        if place_of(item.x, item.y) is None:
            wrong = n.BAD_LATITUDE if abs(item.x) > 90 * E7 else n.BAD_LONGITUDE
            return wrong, f"item {item.seq}: {item.x / E7:g}, {item.y / E7:g} is no position"
    return n.MISSION_ACCEPTED, ""


def course_of(items: Sequence[Item], *, home_first: bool) -> Course:
    """The way that items describe; WrongItem where they describe none.

    Waypoints, one speed (DO_CHANGE_SPEED), in the end perhaps LOITER_UNLIM, or DO_JUMP to the first waypoint for ever,
    which makes it a circuit.

    Args:
        items: as uploaded
        home_first: item 0 is home and no waypoint, as ArduPilot has it
    """
    points: list[Geographic] = []
    seqs: list[int] = []
    closed, cruise = False, None
    for item in items[1:] if home_first else items:
        result, why = refusal(item, home=False)
        if result:
            raise WrongItem(result, why)
        if closed or (seqs and items[seqs[-1]].command == n.LOITER_UNLIMITED):
            raise WrongItem(n.MISSION_UNSUPPORTED, f"item {item.seq}: comes after the end")
        if item.command == n.DO_CHANGE_SPEED:
            cruise = _speed(item, cruise)
        elif item.command == n.DO_JUMP:
            target, times = item.params[0], item.params[1]
            if not seqs or target != seqs[0] or times >= 0:
                where = f"{seqs[0]}, -1 times" if seqs else "a waypoint before it"
                raise WrongItem(n.MISSION_UNSUPPORTED, f"item {item.seq}: jumps; only to item {where}")
            closed = True
        else:
            place = place_of(item.x, item.y)
            assert place is not None
            points.append(place)
            seqs.append(item.seq)
    if len(points) < 2:
        raise WrongItem(n.INVALID, f"{len(points)} waypoints; expected at least 2")
    return Course(tuple(points), tuple(seqs), closed, cruise)


def _speed(item: Item, before: float | None) -> float | None:
    speed = item.params[1]
    if speed == -1.0:  # no change
        return before
    if not 0.0 < speed < math.inf:
        raise WrongItem(8, f"item {item.seq}: speed {speed:g} m/s; expected more than 0")
    if before is not None and speed != before:
        raise WrongItem(n.MISSION_UNSUPPORTED, f"item {item.seq}: a second speed; a mission has one")
    return speed


def items_of(plan: Plan, boat: str, *, home_first: bool) -> tuple[Item, ...]:
    """A mission as waypoints of a boat: corners of a polyline, points of other curves every 10 m or farther apart."""
    mission = plan.mission
    own = plan.boat(boat)
    spec = mission.paths[own.path_name]
    if isinstance(spec, Polyline):
        places = [_geographic(point, plan) for point in spec.points]
    else:
        count = min(MOST_SHOWN, max(2, math.ceil(own.path.length / EVERY_M) + 1))
        at = (own.path.at(own.path.length * i / (count - 1)) for i in range(count))
        places = [plan.plane.to_geographic(p.x, p.y) for p in at]
    start = _geographic(mission.home, plan) if mission.home is not None else places[0]
    cruise = mission.formation.cruise_mps
    items = [_waypoint(0, start)] if home_first else []
    items.append(Item(len(items), 3, n.DO_CHANGE_SPEED, 0, 1, (1.0, cruise, -1.0, 0.0), 0, 0, 0.0))
    first = len(items)
    for place in places:
        items.append(_waypoint(len(items), place))
    if own.path.closed:
        items.append(Item(len(items), 3, n.DO_JUMP, 0, 1, (float(first), -1.0, 0.0, 0.0), 0, 0, 0.0))
    return tuple(items)


def _geographic(place: Place, plan: Plan) -> tuple[float, float]:
    if isinstance(place, Geographic):
        return place.lat_deg, place.lon_deg
    return plan.plane.to_geographic(*metres(place, plan.plane))


def _waypoint(seq: int, place: tuple[float, float]) -> Item:
    return Item(seq, 3, n.WAYPOINT, 0, 1, (0.0, 0.0, 0.0, 0.0), round(place[0] * E7), round(place[1] * E7), 0.0)


def milestones(items: Sequence[Item], plan: Plan, boat: str, *, home_first: bool) -> tuple[tuple[float, int], ...]:
    """(abscissa [m], item) of the waypoints on a boat's path, rising."""
    path = plan.boat(boat).path
    found: list[tuple[float, int]] = []
    last = 0.0
    for item in items[1:] if home_first else items:
        place = place_of(item.x, item.y) if item.command in (n.WAYPOINT, n.LOITER_UNLIMITED) else None
        if place is not None:
            x, y = plan.plane.to_local(place.lat_deg, place.lon_deg)
            last = path.project(x, y, last, path.length)
            found.append((last, item.seq))
    return tuple(found)
