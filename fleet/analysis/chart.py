"""What was planned, for the pictures: paths, fence, safety radius; from a run's mission file."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
from msgspec import Struct, field

from fleet.analysis.series import Floats
from fleet.errors import FleetError
from fleet.mission.model import KeepingClear, Mission

STEP_M = 1.0


class Chart(Struct, frozen=True, kw_only=True):
    """What a mission planned."""

    paths: dict[str, tuple[Floats, Floats]] = field(default_factory=dict)  # north, east [m]
    path_of: dict[str, str] = field(default_factory=dict)  # by boat
    fence: tuple[tuple[float, float], ...] = ()  # north, east of the corners [m]
    radius_m: float = KeepingClear().radius_m  # R
    pattern: str = "column"


def chart_of(tree: dict[str, Any]) -> Chart:
    """The chart of a mission as TOML; without paths and fence if it is none that can be built."""
    from fleet.mission.plan import build

    try:
        plan = build(msgspec.convert(tree, Mission))
    except (FleetError, msgspec.ValidationError):
        return Chart(radius_m=_radius_m(tree))
    paths = {}
    for name, path in plan.paths.items():
        points = [path.at(s) for s in np.linspace(0.0, path.length, 2 + int(path.length / STEP_M)).tolist()]
        paths[name] = (np.array([one.x for one in points]), np.array([one.y for one in points]))
    mission = plan.mission
    return Chart(
        paths=paths,
        path_of={boat.name: boat.path for boat in mission.boats},
        fence=plan.fence,
        radius_m=mission.keeping_clear.radius_m,
        pattern=mission.formation.pattern,
    )


def _radius_m(tree: dict[str, Any]) -> float:
    try:
        return msgspec.convert(tree.get("keeping_clear", {}), KeepingClear).radius_m
    except msgspec.ValidationError:
        return KeepingClear().radius_m
