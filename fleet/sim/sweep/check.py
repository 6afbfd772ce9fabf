"""What cannot work in a family that has the right shape: all of it at once, before anything is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
from msgspec import Struct, inspect, structs

from fleet.avoidance import METHODS
from fleet.guidance.limits import Limits
from fleet.hulls import HULLS
from fleet.mission.misfit import CRUISE_MARGIN_MPS
from fleet.mission.problem import Key, Problem, hint
from fleet.sim.sweep.checks import check_problems
from fleet.sim.sweep.distributions import Drawn, Spread, support, unfit
from fleet.sim.sweep.fits import gap_for, layout_problems, shown
from fleet.sim.sweep.layouts import Crowded, nearest
from fleet.sim.sweep.model import (
    Anywhere,
    Circle,
    Circuit,
    Column,
    Formation,
    Formations,
    Imazu,
    Layout,
    Meeting,
    Merging,
    Spec,
    Trouble,
    Vessels,
    Wingman,
)
from fleet.sim.sweep.scenes import scenes
from fleet.sim.sweep.ships import foreign
from fleet.sim.sweep.ships_check import ships_problems

FARTHEST = 100_000.0  # of any number, in its own unit
TRIED = np.arange(64)  # cases laid on trial
TRIES = 100  # of each, to begin far enough apart


def check(spec: Spec) -> list[Problem]:
    """Everything that is wrong with a family at one point of its grid."""
    found = [*_numbers(spec, ())]
    if not found and foreign(spec):
        return [*_settings(spec), *ships_problems(spec), *check_problems(spec.checks, True)]
    if not found:
        found += [*_settings(spec), *_speeds(spec), *_formation(spec), *_timeline(spec), *_trouble(spec)]
        found += check_problems(spec.checks, False)
    if not found:
        found += layout_problems(spec)
    if not found:
        found += _starts(spec)
    return found


def _numbers(part: Struct, where: Key) -> Iterator[Problem]:
    """Distributions that are none, and numbers that can come to lie beyond the bounds of their place."""
    for field in _fields(type(part)):
        value, key = getattr(part, field.name), (*where, field.encode_name)
        if isinstance(value, Spread):
            wrong = unfit(value)
            least, most = (0.0, 0.0) if wrong else value.support
            low, high = _bounds(field.type)
            if wrong:
                yield Problem(key, wrong)
            elif least < low or most > high:
                yield Problem(key, f"numbers from {least:g} to {most:g} can come; expected {_from_to(low, high)}")
        elif isinstance(value, Struct):
            yield from _numbers(value, key)
        elif isinstance(value, tuple):
            for i, item in enumerate(value):
                if isinstance(item, Struct):
                    yield from _numbers(item, (*key, i))
        elif isinstance(value, float) and abs(value) > FARTHEST:
            yield Problem(key, f"expected {_from_to(-FARTHEST, FARTHEST)}", value)


@lru_cache
def _fields(kind: Any) -> tuple[structs.FieldInfo, ...]:
    """Names and types of a table's keys."""
    return structs.fields(kind)


@lru_cache
def _bounds(kind: Any) -> tuple[float, float]:
    """Least and highest number that a key takes."""
    of = inspect.type_info(kind)
    options = of.types if isinstance(of, inspect.UnionType) else (of,)
    number = next(option for option in options if isinstance(option, inspect.FloatType))
    least = number.ge if number.ge is not None else number.gt
    return -FARTHEST if least is None else least, FARTHEST if number.le is None else number.le


def _from_to(low: float, high: float) -> str:
    return f"{low:g} to {high:g}"


def _settings(spec: Spec) -> Iterator[Problem]:
    """Names that nobody has, and values that do not go together."""
    if not spec.title.isprintable():
        yield Problem(("title",), "expected one line of printable text", spec.title)
    yield from _hulls(spec)
    keep, length = spec.keeping_clear, spec.limits.length_m
    if keep.radius_m <= length:
        yield Problem(
            ("keeping_clear", "radius_m"), f"hulls of {length:g} m touch within it; expected more", keep.radius_m
        )
    low, high = spec.limits.speed_min_mps, spec.limits.speed_max_mps
    if low + 2.0 * CRUISE_MARGIN_MPS > high + 1e-9:
        wrong = f"expected at least {2.0 * CRUISE_MARGIN_MPS:g} m/s below speed_max_mps = {high:g}"
        yield Problem(("limits", "speed_min_mps"), wrong, low)
    if keep.method not in METHODS:
        yield Problem(("keeping_clear", "method"), f"no such method{hint(keep.method, METHODS)}", keep.method)
        return
    tuning = {f.name: f for f in structs.fields(METHODS[keep.method].params(keep.radius_m, keep.side))}
    known = [name for name, f in tuning.items() if isinstance(f.default, float | int)]
    for name, value in keep.params.items():
        if name not in known:
            wrong = f"{keep.method} has no such number to tune{hint(name, known)}"
            yield Problem(("keeping_clear", "params", name), wrong, value)


def _hulls(spec: Spec) -> Iterator[Problem]:
    """Hulls that there are not."""
    named: list[tuple[Key, str]] = [(("hull",), spec.hull)]
    named += [(("hulls", i), name) for i, name in enumerate(spec.hulls)]
    for key, name in named:
        if name not in HULLS:
            yield Problem(key, f"no such hull{hint(name, HULLS)}", name)
        elif len(key) > 1 and name in spec.hulls[: int(key[1])]:
            yield Problem(key, "a hull before it is the same", name)


def _speeds(spec: Spec) -> Iterator[Problem]:
    """Cruise speeds that the boats cannot sail."""
    low, high = spec.limits.speed_min_mps, spec.limits.speed_max_mps
    layout, formation = spec.layout, spec.formation
    if formation is not None:
        key: Key = ("formation", "cruise_mps")
        low, high = _formation_speeds(spec, formation)
        yield from _outside(key, formation.cruise_mps, low + CRUISE_MARGIN_MPS, high - CRUISE_MARGIN_MPS)
    if isinstance(layout, Formations):
        return
    if isinstance(layout, Wingman):
        yield from _outside(
            ("layout", "cruise_mps"), layout.cruise_mps, low + CRUISE_MARGIN_MPS, high - CRUISE_MARGIN_MPS
        )
    elif isinstance(layout, Column | Circuit):
        if formation is not None and support(layout.speed_share)[1] * support(formation.cruise_mps)[1] > (
            spec.limits.speed_max_mps + 1e-9
        ):
            wrong = f"begins faster than speed_max_mps = {spec.limits.speed_max_mps:g}"
            yield Problem(("layout", "speed_share"), wrong, shown(layout.speed_share))
    elif layout.cruise_mps is not None:
        yield from _outside(("layout", "cruise_mps"), layout.cruise_mps, low, high)


def _formation_speeds(spec: Spec, formation: Formation) -> tuple[float, float]:
    """Between which speeds a boat keeps its place."""
    low, high = formation.speed_min_mps, formation.speed_max_mps
    return (
        spec.limits.speed_min_mps if low is None else max(low, spec.limits.speed_min_mps),
        spec.limits.speed_max_mps if high is None else min(high, spec.limits.speed_max_mps),
    )


def _outside(key: Key, value: Drawn, low: float, high: float) -> Iterator[Problem]:
    """A speed that can come to lie outside what boats can do."""
    least, most = support(value)
    if least < low - 1e-9 or most > high + 1e-9:
        comes = f"{least:g} to {most:g} m/s can come; " if isinstance(value, Spread) else ""
        yield Problem(key, f"{comes}expected {low:g} to {high:g} m/s, as boats can sail", shown(value))


def _formation(spec: Spec) -> Iterator[Problem]:
    """A formation where there can be none, none where there must be one; slots too near each other."""
    layout, formation = spec.layout, spec.formation
    kind = type(layout).__struct_config__.tag
    if isinstance(layout, Wingman) and spec.duration_s is None:
        yield Problem(("duration_s",), f"missing, a {kind} has no goal and sails until the time is up")
    if isinstance(layout, Meeting | Circle | Anywhere | Wingman | Vessels | Imazu):
        if formation is not None and isinstance(layout, Wingman):
            wrong = "layout.cruise_mps of a wingman's leader counts; expected none"
            yield Problem(("formation",), wrong)
        elif formation is not None:
            yield Problem(("formation",), f"boats of a {kind} sail each for itself; expected column or merging")
        return
    if formation is None:
        if isinstance(layout, Column | Formations | Circuit):
            yield Problem(("formation",), f"missing, a {kind} needs spacing_m and cruise_mps")
        elif layout.lane_m == 0.0:
            yield Problem(("formation",), "missing, boats that merge into one lane need spacing_m and cruise_mps")
        return
    if isinstance(layout, Column | Formations | Circuit) and spec.duration_s is None:
        yield Problem(("duration_s",), f"missing, a {kind} has no goal and sails until the time is up")
    if isinstance(layout, Merging) and layout.cruise_mps is not None:
        yield Problem(("layout", "cruise_mps"), "formation.cruise_mps counts; expected one of the two")
    if spec.boats > 1:
        yield from _gap(("formation", "spacing_m"), spec, *support(formation.spacing_m), formation.spacing_m)


def _gap(key: Key, spec: Spec, low: float, high: float, value: Drawn) -> Iterator[Problem]:
    """Slots on one path that can come nearer than boats may be."""
    env, layout = spec.environment, spec.layout
    every = (layout.paths or spec.boats) if isinstance(layout, Merging) and layout.lane_m > 0.0 else 1
    need = gap_for(spec.keeping_clear.radius_m, math.hypot(env.gnss_sigma_m, env.gnss_white_m))
    least = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high)) * every
    if least < need - 1e-9 and spec.boats > every:
        yield Problem(key, f"boats can come to be {least:g} m apart on one path; at least {need:.1f} m", shown(value))


def _timeline(spec: Spec) -> Iterator[Problem]:
    """Commands that nobody can obey."""
    for i, event in enumerate(spec.timeline):
        key: Key = ("timeline", i)
        if isinstance(spec.layout, Formations):
            yield Problem(key, "two formations take no commands; expected none")
            continue
        if spec.formation is None:
            if not isinstance(spec.layout, Column | Circuit):  # which lacks one
                yield Problem(key, "only a formation takes commands; expected none")
            continue
        if spec.duration_s is not None and event.at_s >= spec.duration_s:
            yield Problem((*key, "at_s"), f"after the end, duration_s = {spec.duration_s:g}", event.at_s)
        if any(other.at_s == event.at_s for other in spec.timeline[:i]):
            yield Problem((*key, "at_s"), "an entry before it has this time", event.at_s)
        given = [name for name in ("value", "times") if getattr(event, name) is not None]
        sets = event.do in ("set spacing", "set speed")
        if sets != (len(given) == 1):
            wanted = "exactly one of value and times" if sets else "neither value nor times"
            yield Problem(key, f"{event.do}: expected {wanted}")
        elif sets:
            yield from _told(spec, spec.formation, i)


def _told(spec: Spec, formation: Formation, number: int) -> Iterator[Problem]:
    """A spacing or speed that an event sets."""
    event = spec.timeline[number]
    drawn = formation.spacing_m if event.do == "set spacing" else formation.cruise_mps
    name = "value" if event.value is not None else "times"
    told: float = event.value if event.value is not None else event.times or 0.0
    ends = sorted([told, told] if name == "value" else [told * end for end in support(drawn)])
    key: Key = ("timeline", number, name)
    if event.do == "set spacing" and spec.boats > 1:
        yield from _gap(key, spec, ends[0], ends[1], told)
    elif event.do == "set speed":
        low, high = (_formation_speeds(spec, formation)[k] + (1 - 2 * k) * CRUISE_MARGIN_MPS for k in (0, 1))
        if ends[0] < low - 1e-9 or ends[1] > high + 1e-9:
            yield Problem(key, f"expected {low:g} to {high:g} m/s, as boats can sail in formation", told)


def _trouble(spec: Spec) -> Iterator[Problem]:
    """Boats in trouble that are not there."""
    trouble = spec.trouble
    for name in ("not_avoiding", "stopped", "mute"):
        for i, number in enumerate(getattr(trouble, name)):
            if number > spec.boats:
                yield Problem(("trouble", name, i), f"no such boat; they are numbered 1 to {spec.boats}", number)
    if trouble.stopped and not isinstance(spec.layout, Meeting | Circle):
        yield Problem(("trouble", "stopped"), "expected layout meeting or circle, where boats meet at a point")
    if bool(trouble.mute) != (trouble.mute_at_s is not None):
        missing = "mute_at_s" if trouble.mute else "mute"
        yield Problem(("trouble", missing), "missing: which boats are mute, and from when on, go together")


def _starts(spec: Spec) -> Iterator[Problem]:
    """The first cases are laid: do boats begin clear of each other?"""
    least, crowded = _tried(spec.layout, spec.formation, spec.trouble, spec.limits, spec.boats, spec.seed)
    radius = spec.keeping_clear.radius_m
    if crowded is not None:
        share = len(crowded.cases) / len(TRIED)
        wrong = f"in {share:.0%} of cases none of {TRIES} draws begins with all boats {crowded.apart_m:g} m apart"
        yield Problem(("boats",), wrong, spec.boats)
    elif least < radius:
        yield Problem(("layout",), f"boats can begin {least:.1f} m apart; at least the safety radius, {radius:g} m")


@lru_cache(maxsize=64)
def _tried(
    layout: Layout, formation: Formation | None, trouble: Trouble, limits: Limits, boats: int, seed: int
) -> tuple[float, Crowded | None]:
    """Least distance of two boats at the start of the cases tried; and those that are not laid at all."""
    spec = Spec(title="trial", boats=boats, cases=1, layout=layout, formation=formation, trouble=trouble, limits=limits)
    try:
        tried = scenes("trial", spec, seed, TRIED, TRIES)
    except Crowded as crowded:
        return 0.0, crowded
    return float(nearest(tried.x, tried.y).min()), None
