"""Scenarios of a family at one point of its grid: the layout, then what is around it and what goes wrong."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fleet import ops
from fleet.agent.modes import Goal
from fleet.ops import FloatArray
from fleet.sim.batch import Change, Scenarios, assemble
from fleet.sim.batch.scenarios import IntArray
from fleet.sim.sweep.anywhere import anywhere
from fleet.sim.sweep.distributions import Draw, Spread, radians
from fleet.sim.sweep.fits import gap_for
from fleet.sim.sweep.formed import circuit, formations
from fleet.sim.sweep.layouts import ATTEMPTS, Laid, circle, column, meeting, slots
from fleet.sim.sweep.merging import merging
from fleet.sim.sweep.model import Anywhere, Circle, Circuit, Column, Formations, Meeting, Merging, Spec, Wingman
from fleet.sim.sweep.wingman import wingman
from fleet.sim.world import LEEWAY


def scenes(name: str, spec: Spec, seed: int, case: IntArray, attempts: int = ATTEMPTS) -> Scenarios:
    """Some cases of a seed; each is the same with whichever others it is drawn."""
    laid, spacing = _lay(spec, seed, case, attempts)
    draw = Draw(seed, case, spec.boats, used=laid.used)
    water, given = _around(spec, draw), dict(laid.more)
    x, y = laid.x.copy(), laid.y.copy()
    _trouble(spec, draw, x, y, laid.cruise, given)
    formation = spec.formation
    if formation is not None:
        low, high = formation.speed_min_mps, formation.speed_max_mps
        given["u_min"] = spec.limits.speed_min_mps if low is None else low
        given["u_max"] = spec.limits.speed_max_mps if high is None else high
        given["gain_per_m"] = formation.gain_per_m
    if spacing is not None:
        given["changes"] = _changes(spec, laid.cruise, spacing)
    if spec.duration_s is not None:
        given["limit_s"] = spec.duration_s
    hulls = spec.hulls or (spec.hull,)
    if len(hulls) > 1:
        given["hull"] = draw.per_boat(Spread(one_of=tuple(map(float, range(len(hulls))))))
    return assemble(
        name, seed, case, laid.paths, laid.path, x, y, laid.psi,
        cruise=laid.cruise, measure_s=spec.measure_from_s, hulls=hulls, limits=spec.limits,
        gnss_sigma_m=spec.environment.gnss_sigma_m, gnss_white_m=spec.environment.gnss_white_m,
        gnss_velocity_mps=spec.environment.gnss_velocity_mps, clock_error_s=spec.radio.clock_error_s, **given, **water,
    )  # fmt: skip


def _lay(spec: Spec, seed: int, case: IntArray, attempts: int) -> tuple[Laid, FloatArray | None]:
    """What the layout says, and the spacing of a formation (B,)."""
    layout = spec.layout
    if isinstance(layout, Meeting):
        return meeting(layout, spec.boats, seed, case, attempts), None
    if isinstance(layout, Circle):
        return circle(layout, spec.boats, seed, case), None
    if isinstance(layout, Anywhere):
        return anywhere(layout, spec.limits, spec.boats, seed, case, attempts), None
    if isinstance(layout, Wingman):
        env = spec.environment
        need = gap_for(spec.keeping_clear.radius_m, math.hypot(env.gnss_sigma_m, env.gnss_white_m))
        return wingman(layout, spec.limits, need, spec.duration_s or 0.0, seed, case), None
    if isinstance(layout, Column | Formations | Circuit):
        assert spec.formation is not None, "found by check"
        if isinstance(layout, Column):
            return column(layout, spec.formation, spec.boats, seed, case)
        if isinstance(layout, Formations):
            return formations(layout, spec.formation, spec.boats, seed, case)
        return circuit(layout, spec.formation, spec.boats, seed, case)
    assert isinstance(layout, Merging), "others have foreign vessels, and are sailed by ships"
    return merging(layout, spec.formation, spec.boats, seed, case)


def _around(spec: Spec, draw: Draw) -> dict[str, FloatArray]:
    """Current, wind and radio, per scenario."""
    env, radio = spec.environment, spec.radio
    current, toward = draw.per_scenario(env.current_mps), draw.per_scenario(radians(env.current_toward_deg))
    wind, from_ = draw.per_scenario(env.wind_mps), draw.per_scenario(radians(env.wind_from_deg))
    s, c = ops.sincos(toward)
    from_s, from_c = ops.sincos(from_)
    return {
        "current_n": current * c,
        "current_e": current * s,
        "wind_n": -LEEWAY * wind * from_c,
        "wind_e": -LEEWAY * wind * from_s,
        "delay_s": draw.per_scenario(radio.delay_s),
        "loss": draw.per_scenario(radio.loss),
    }


def _trouble(spec: Spec, draw: Draw, x: FloatArray, y: FloatArray, cruise: FloatArray, given: dict[str, Any]) -> None:
    """Boats that do not do as they should; moves the stopped ones."""
    trouble, shape = spec.trouble, x.shape
    if trouble.not_avoiding:
        given["avoids"] = np.ones(shape)
        given["avoids"][:, _columns(trouble.not_avoiding)] = 0.0
    if trouble.stopped:
        lie = _columns(trouble.stopped)
        x[:, lie], y[:, lie] = draw.per_boat(trouble.stopped_m)[:, lie], draw.per_boat(trouble.stopped_m)[:, lie]
        given |= {"u": cruise.copy(), "goal": np.full(shape, float(Goal.FOLLOW))}
        given["goal_m"] = np.array(np.broadcast_to(given["goal_m"], shape))
        for name, value in (("u", 0.0), ("goal", float(Goal.NEUTRAL)), ("goal_m", np.inf)):
            given[name][:, lie] = value
    if trouble.mute and trouble.mute_at_s is not None:
        silent = _columns(trouble.mute)
        given["mute_s"] = np.full(shape, np.inf)
        given["mute_s"][:, silent] = draw.per_boat(trouble.mute_at_s)[:, silent]


def _columns(numbers: tuple[int, ...]) -> list[int]:
    """Boats are counted from 1 in files."""
    return [number - 1 for number in numbers]


def _changes(spec: Spec, cruise: FloatArray, spacing: FloatArray) -> tuple[Change, ...]:
    """The timeline as complete orders, one after the other."""
    changes = []
    now_spacing, now_cruise, goal = spacing, cruise, float(Goal.FOLLOW)
    for event in sorted(spec.timeline, key=lambda event: event.at_s):
        if event.do == "set spacing":
            now_spacing = _told(event.value, event.times, spacing)
        elif event.do == "set speed":
            now_cruise = _told(event.value, event.times, cruise)
        else:
            goal = float(Goal.HOLD if event.do == "hold" else Goal.FOLLOW)
        changes.append(
            Change(
                at_s=np.full(len(cruise), event.at_s),
                goal=np.full(cruise.shape, goal),
                offset=slots(spec.boats) * now_spacing[:, None],
                cruise=now_cruise,
            )
        )
    return tuple(changes)


def _told(value: float | None, times: float | None, drawn: FloatArray) -> FloatArray:
    """What an event sets: a value, or so many times what was drawn."""
    return np.full_like(drawn, value) if value is not None else (1.0 if times is None else times) * drawn
