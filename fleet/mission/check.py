"""What cannot work in a mission, all of it at once, before anything moves."""

from __future__ import annotations

import math
from collections.abc import Iterator

from msgspec import Struct

from fleet.avoidance import METHODS
from fleet.hulls import HULLS
from fleet.mission.checks import CHECKS
from fleet.mission.formation import check_formation, gap_needed, misfits, near_places, smallest_gap
from fleet.mission.misfit import CRUISE_MARGIN_MPS
from fleet.mission.model import Mission
from fleet.mission.plan import Plan, attempt
from fleet.mission.problem import Lines, Problem, hint, texts
from fleet.mission.timeline import shapes, timeline_problems, timeline_warnings
from fleet.mission.traffic import course_problems, traffic_problems
from fleet.mission.waters import water_problems, water_warnings

__all__ = ["Findings", "check", "check_formation"]


class Findings(Struct, frozen=True):
    """What was found about a mission, in words."""

    problems: tuple[str, ...]
    """It cannot be sailed."""
    warnings: tuple[str, ...]
    """It can, but perhaps not as meant."""


def check(mission: Mission, lines: Lines | None = None) -> Findings:
    """Everything that is wrong or odd in a mission that has the right shape.

    Args:
        mission: what to look at
        lines: line of each key in its file, for the messages; 0 for an override
    """
    plan, problems = attempt(mission)
    found = [*_names(mission), *problems, *_limits(mission), *_settings(mission)]
    warnings: list[Problem] = list(_unused(mission))
    found += traffic_problems(mission)
    if plan.boats:
        found += [*_formation(plan), *water_problems(plan), *_checks(plan), *course_problems(plan)]
    found += timeline_problems(plan)
    if not found:
        warnings += [*_nearness(plan), *water_warnings(plan), *timeline_warnings(plan)]
    return Findings(problems=texts(found, lines), warnings=texts(warnings, lines))


def _names(mission: Mission) -> Iterator[Problem]:
    """Names that nobody has, or that two have; slots that two boats share on one path."""
    seen: set[str] = set()
    slots: dict[tuple[str, float], str] = {}
    for i, boat in enumerate(mission.boats):
        if boat.name in seen:
            yield Problem(("boats", i, "name"), "a boat before it has this name", boat.name)
        seen.add(boat.name)
        if boat.path not in mission.paths:
            yield Problem(("boats", i, "path"), f"no such path{hint(boat.path, mission.paths)}", boat.path)
        elif (taken := slots.setdefault((boat.path, boat.slot), boat.name)) != boat.name:
            yield Problem(("boats", i, "slot"), f"{taken} has this slot on path {boat.path}", boat.slot)
        if boat.hull not in HULLS:
            why = HULLS.why(boat.hull) or f"no such hull{hint(boat.hull, HULLS)}"
            yield Problem(("boats", i, "hull"), why, boat.hull)
    method = mission.keeping_clear.method
    if method not in METHODS:
        why = METHODS.why(method) or f"no such method{hint(method, METHODS)}"
        yield Problem(("keeping_clear", "method"), why, method)
    if not mission.paths:
        yield Problem(("paths",), "expected at least one path")


def _limits(mission: Mission) -> Iterator[Problem]:
    """Limits of boats that contradict each other."""
    longest = max(boat.limits.length_m for boat in mission.boats)
    radius = mission.keeping_clear.radius_m
    if radius <= longest:
        yield Problem(("keeping_clear", "radius_m"), f"hulls of {longest:g} m touch within it; expected more", radius)
    for i, boat in enumerate(mission.boats):
        low, high = boat.limits.speed_min_mps, boat.limits.speed_max_mps
        if low + 2.0 * CRUISE_MARGIN_MPS > high + 1e-9:
            wrong = f"expected at least {2.0 * CRUISE_MARGIN_MPS:g} m/s below speed_max_mps = {high:g}"
            yield Problem(("boats", i, "limits", "speed_min_mps"), wrong, low)
        if boat.start.speed_mps > high:
            wrong = f"faster than speed_max_mps = {high:g}"
            yield Problem(("boats", i, "start", "speed_mps"), wrong, boat.start.speed_mps)


def _settings(mission: Mission) -> Iterator[Problem]:
    """Values that do not go together."""
    if not mission.title.isprintable():
        yield Problem(("title",), "expected one line of printable text", mission.title)
    battery = mission.battery
    if battery.critical_percent > battery.reserve_percent:
        wrong = f"above reserve_percent = {battery.reserve_percent:g}"
        yield Problem(("battery", "critical_percent"), wrong, battery.critical_percent)
    if mission.home is None:
        if mission.lost.operator == "return":
            yield Problem(("home",), "missing, needed because lost.operator is return")
        if any(event.do == "return" for event in mission.timeline):
            yield Problem(("home",), "missing, needed because the timeline has a return")


def _formation(plan: Plan) -> Iterator[Problem]:
    """The formation at launch."""
    shape = plan.shape
    values = {"cruise_mps": shape.cruise_mps, "spacing_m": shape.spacing_m, "lateral_m": shape.lateral_m}
    for misfit in misfits(plan, shape):
        if misfit.key != "slots":  # named already, with the boat
            yield Problem(("formation", misfit.key), misfit.text, values.get(misfit.key, shape.pattern))


def _checks(plan: Plan) -> Iterator[Problem]:
    """Checks that do not exist, or that no run can pass."""
    mission = plan.mission
    gap = min(smallest_gap(plan, shape) for shape in (plan.shape, *(shape for _, _, shape in shapes(plan))))
    cruise = mission.formation.cruise_mps
    for name, limit in mission.checks.items():
        key = ("checks", name)
        known = CHECKS.get(name)
        if known is None:
            yield Problem(key, f"no such check{hint(name, CHECKS)}", limit)
        elif limit < 0.0 or limit > (known.highest or math.inf):
            yield Problem(key, "expected at least 0" if limit < 0.0 else f"expected at most {known.highest:g}", limit)
        elif name == "finished" and limit != 1.0:
            yield Problem(key, "expected 1", limit)
        elif name == "min_separation_m" and limit > gap:
            yield Problem(key, f"cannot be kept: slots are {gap:g} m apart", limit)
        elif (name == "speed_min_mps" and limit > cruise) or (name == "speed_max_mps" and limit < cruise):
            yield Problem(key, f"cannot be kept: cruise is {cruise:g} m/s", limit)


def _unused(mission: Mission) -> Iterator[Problem]:
    """Paths that nobody sails."""
    used = {boat.path for boat in mission.boats}
    for name in mission.paths:
        if name not in used:
            yield Problem(("paths", name), "no boat sails this path")


def _nearness(plan: Plan) -> Iterator[Problem]:
    """Where boats that hold their places pass so near that keeping clear will move them aside."""
    shape, spacing = plan.shape, plan.mission.formation.spacing_m
    if shape.pattern == "wingman":  # they give each other room on purpose
        return
    need = gap_needed(plan.mission)
    for near in near_places(plan, shape, need, shared=True):
        where = f"the places of {near.first} and {near.second} come within {near.least_m:.1f} m of each other"
        wrong = f"{where}, {near.first} at {near.s_m:.0f} m of its path; below {need:.1f} m they keep clear first"
        yield Problem(("formation", "spacing_m"), wrong, spacing)
