"""Other vessels of a simulation: what cannot work about them, and what may not be meant."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

from fleet.mission.model import Mission, Steady, Vessel
from fleet.mission.plan import Plan, metres
from fleet.mission.problem import Key, Problem

FASTEST_MPS = 8.0


def traffic_problems(mission: Mission) -> Iterator[Problem]:
    """Vessels that cannot be simulated."""
    taken = {boat.name: "a boat" for boat in mission.boats}
    for i, vessel in enumerate(mission.traffic):
        key: Key = ("traffic", i)
        if vessel.name in taken:
            yield Problem((*key, "name"), f"{taken[vessel.name]} has this name", vessel.name)
        taken.setdefault(vessel.name, "a vessel before it")
        yield from _changes(mission, vessel, key)
        for j, gap in enumerate(vessel.sensed.gaps):
            if gap.to_s <= gap.from_s:
                yield Problem((*key, "sensed", "gaps", j, "to_s"), f"expected after from_s = {gap.from_s:g}", gap.to_s)


def _changes(mission: Mission, vessel: Vessel, key: Key) -> Iterator[Problem]:
    """Changes without their value, or with one that no vessel can do."""
    for j, change in enumerate(vessel.changes):
        where: Key = (*key, "changes", j)
        if change.at_s > mission.duration_s:
            yield Problem((*where, "at_s"), f"after the end, duration_s = {mission.duration_s:g}", change.at_s)
        if change.do == "stop":
            if change.value is not None:
                yield Problem((*where, "value"), "stop takes no value", change.value)
        elif change.value is None:
            needed = "degrees, + to starboard" if change.do == "turn" else "m/s"
            yield Problem((*where, "value"), f"missing, {change.do} needs one: {needed}")
        elif change.do == "turn" and not 0.0 < abs(change.value) <= 180.0:
            yield Problem((*where, "value"), "expected -180 to 180 degrees, and not 0", change.value)
        elif change.do == "speed" and not 0.0 <= change.value <= FASTEST_MPS:
            yield Problem((*where, "value"), f"expected a number from 0 to {FASTEST_MPS:g}", change.value)


def course_problems(plan: Plan) -> Iterator[Problem]:
    """Waypoints that coincide; vessels that begin on top of a boat."""
    for i, vessel in enumerate(plan.mission.traffic):
        key: Key = ("traffic", i, "track")
        if isinstance(vessel.track, Steady):
            first = metres(vessel.track.start, plan.plane)
        else:
            points = [metres(point, plan.plane) for point in vessel.track.points]
            first = points[0]
            for j, (a, b) in enumerate(pairwise(points)):
                if math.dist(a, b) < 1.0:
                    yield Problem((*key, "points"), f"points {j + 1} and {j + 2} are less than 1 m apart")
        for boat in plan.boats:
            away = math.hypot(boat.x - first[0], boat.y - first[1])
            room = 0.5 * (vessel.length_m + boat.limits.length_m)
            if away < room:
                yield Problem(key, f"begins {away:.1f} m from {boat.name}; their hulls need {room:.1f} m")
