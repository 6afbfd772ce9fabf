"""Layouts that cannot be laid with so many boats, or with what the boats can do."""

from __future__ import annotations

import math
from collections.abc import Iterator

from msgspec import UNSET

from fleet.coordination.wingman import LEAST_COS
from fleet.mission.formation import BETWEEN_SLOTS_M
from fleet.mission.problem import Problem
from fleet.sim.sweep.distributions import Drawn, Spread, support
from fleet.sim.sweep.formed import circuit_path
from fleet.sim.sweep.layouts import circle_radius
from fleet.sim.sweep.merging import corner
from fleet.sim.sweep.model import Anywhere, Circle, Circuit, Formations, Meeting, Merging, Spec, Wingman


def gap_for(radius_m: float, sigma_m: float) -> float:
    """Least distance between two slots [m]: R + 2, or R + 0.5 and the margin for two position errors."""
    return max(radius_m + BETWEEN_SLOTS_M, radius_m + 0.5 + 2.0 * math.sqrt(2.0) * sigma_m)


def shown(value: Drawn) -> object:
    """As messages repeat it: a distribution not at all."""
    return UNSET if isinstance(value, Spread) else value


def layout_problems(spec: Spec) -> Iterator[Problem]:
    """Layouts that cannot be laid with so many boats."""
    layout, boats = spec.layout, spec.boats
    if isinstance(layout, Meeting) and layout.relative_deg is not None and boats < 2:
        yield Problem(("layout", "relative_deg"), "needs a second boat; expected boats of at least 2")
    if isinstance(layout, Circle) and boats > 1:
        radius = circle_radius(boats) if layout.radius_m is None else layout.radius_m
        apart, need = 2.0 * radius * math.sin(math.pi / boats), gap_for(spec.keeping_clear.radius_m, 0.0)
        if apart < need:
            wrong = f"{boats} boats begin {apart:.1f} m apart; at least {need:.1f} m"
            yield Problem(("layout", "radius_m"), wrong, radius)
    if isinstance(layout, Merging):
        if layout.paths is not None and layout.paths > boats:
            yield Problem(("layout", "paths"), f"more than boats = {boats}", layout.paths)
        if 0.0 < layout.lane_m < spec.limits.length_m:
            yield Problem(
                ("layout", "lane_m"), f"hulls of {spec.limits.length_m:g} m touch; expected more", layout.lane_m
            )
        cut, arc = corner(math.radians(support(layout.angle_deg)[1]), layout.corner_radius_m)
        cruise = spec.formation.cruise_mps if spec.formation else layout.cruise_mps
        way = support(1.0 if cruise is None else cruise)[0] * (layout.meet_s + support(layout.late_s)[0])
        if way < arc - cut:
            yield Problem(("layout", "meet_s"), "boats begin in the bend; expected more", layout.meet_s)
        tightest = spec.limits.speed_max_mps / spec.limits.yaw_rate_max_radps
        if layout.corner_radius_m < tightest:
            speed, rate = spec.limits.speed_max_mps, spec.limits.yaw_rate_max_radps
            wrong = f"boats need {tightest:.1f} m ({speed:g} m/s at {rate:g} rad/s)"
            yield Problem(("layout", "corner_radius_m"), wrong, layout.corner_radius_m)
    if isinstance(layout, Formations):
        yield from _formations(spec, layout)
    if isinstance(layout, Circuit):
        yield from _circuit(spec, layout)
    if isinstance(layout, Anywhere):
        yield from _anywhere(spec, layout)
    if isinstance(layout, Wingman):
        yield from _wingman(spec, layout)


def _need(spec: Spec) -> float:
    """Least distance between two slots [m]."""
    env = spec.environment
    return gap_for(spec.keeping_clear.radius_m, math.hypot(env.gnss_sigma_m, env.gnss_white_m))


def _formations(spec: Spec, layout: Formations) -> Iterator[Problem]:
    """Formations of nobody, and boats abreast too near each other."""
    if spec.boats < 4:
        yield Problem(("boats",), "two formations; expected at least 4", spec.boats)
    need = _need(spec)
    if support(layout.abreast)[1] >= 0.5 and layout.lateral_m < need - 1e-9:
        yield Problem(("layout", "lateral_m"), f"boats abreast; at least {need:.1f} m", layout.lateral_m)


def _circuit(spec: Spec, layout: Circuit) -> Iterator[Problem]:
    """Corners that do not fit, and circuits that are too short for their boats."""
    tightest = spec.limits.speed_max_mps / spec.limits.yaw_rate_max_radps
    if not tightest <= layout.corner_radius_m <= 0.5 * min(layout.north_m, layout.east_m):
        most = 0.5 * min(layout.north_m, layout.east_m)
        wrong = f"expected {tightest:.1f} m, as boats turn, to {most:g} m, half of the shorter side"
        yield Problem(("layout", "corner_radius_m"), wrong, layout.corner_radius_m)
        return
    lap, boats = circuit_path(layout).length, spec.boats
    if boats * layout.apart_m > lap:
        yield Problem(("layout", "apart_m"), f"{boats} boats on a lap of {lap:.1f} m; expected less", layout.apart_m)
    if spec.formation is not None and boats > 1:
        room = lap - (boats - 1) * max(map(abs, support(spec.formation.spacing_m)))
        if room < _need(spec):
            wrong = f"round the lap the last boat is {room:.1f} m before the first; at least {_need(spec):.1f} m"
            yield Problem(("formation", "spacing_m"), wrong, shown(spec.formation.spacing_m))


def _wingman(spec: Spec, layout: Wingman) -> Iterator[Problem]:
    """Curves that a wingman cannot sail, or that run across its leader's path."""
    if spec.boats != 2:
        yield Problem(("boats",), "a leader and its wingman; expected 2", spec.boats)
    k = 2.0 * math.pi / layout.wavelength_m
    amplitude = support(layout.amplitude_m)[1]
    tightest = spec.limits.speed_max_mps / spec.limits.yaw_rate_max_radps
    wrong = ""
    if amplitude * k * k * tightest > 1.0:
        wrong = f"bends with {1.0 / (amplitude * k * k):.1f} m; boats need {tightest:.1f} m"
    elif 1.0 / math.hypot(1.0, amplitude * k) < LEAST_COS:
        wrong = f"runs {math.degrees(math.atan(amplitude * k)):.0f} deg off the leader's path; at most 72 deg"
    if wrong:
        yield Problem(("layout", "amplitude_m"), wrong, shown(layout.amplitude_m))


def _anywhere(spec: Spec, layout: Anywhere) -> Iterator[Problem]:
    """Bends that boats cannot take."""
    way = support(layout.cruise_mps)[0] * (support(layout.meet_s)[0] + layout.after_s)
    most = max(map(abs, support(layout.turn_deg)))
    tightest = spec.limits.speed_max_mps / spec.limits.yaw_rate_max_radps
    if most > 0.0 and way < math.radians(most) * tightest:
        radius = way / math.radians(most)
        wrong = f"paths can bend with {radius:.1f} m; boats need {tightest:.1f} m"
        yield Problem(("layout", "turn_deg"), wrong, shown(layout.turn_deg))
