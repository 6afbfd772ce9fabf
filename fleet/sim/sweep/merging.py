"""The layout of paths from both sides that bend into parallel lanes."""

from __future__ import annotations

import math

import numpy as np
from msgspec import Struct

from fleet.ops import FloatArray
from fleet.paths import Path, polyline, straight
from fleet.sim.batch.scenarios import IntArray
from fleet.sim.sweep.distributions import Draw, radians
from fleet.sim.sweep.layouts import LONG_M, Laid, slots
from fleet.sim.sweep.model import Formation, Merging

LEAST_ARC_M = 0.5  # gentler corners are rounded more gently than asked, as `fleet.paths.polyline` does
BEND_M = 300.0  # abscissa at which every path passes where its lane begins


class Bend(Struct, frozen=True):
    """One path: a straight leg at an angle, an arc, a lane to the north; all have the abscissa BEND_M at x = 0."""

    lane_y: float
    side: float  # + comes from starboard, - from port, 0 straight
    angle: float
    before_m: float  # of straight leg from its start to the corner

    def path(self, corner_radius_m: float) -> Path:
        """The curve."""
        if self.angle == 0.0:
            return straight((-BEND_M, self.lane_y), (LONG_M, self.lane_y))
        start = (-self.before_m * math.cos(self.angle), self.lane_y + self.side * self.before_m * math.sin(self.angle))
        return polyline((start, (0.0, self.lane_y), (LONG_M, self.lane_y)), corner_radius_m)


def bend(number: int, paths: int, lane_m: float, angle: float, corner_radius_m: float) -> Bend:
    """Path `number` of `paths`, from port to starboard."""
    place = number - 0.5 * (paths - 1)
    side = float(np.sign(place))
    angle = angle if side != 0.0 and angle > 1e-9 else 0.0
    cut, arc = corner(angle, corner_radius_m)
    return Bend(lane_y=place * lane_m, side=side, angle=angle, before_m=BEND_M + 2.0 * cut - arc)


def corner(angle: float, corner_radius_m: float) -> tuple[float, float]:
    """What an arc takes from both its legs, and its length [m]."""
    if angle == 0.0:
        return 0.0, 0.0
    radius = max(corner_radius_m, LEAST_ARC_M / angle)
    return radius * math.tan(0.5 * angle), radius * angle


def merging(
    layout: Merging, formation: Formation | None, boats: int, seed: int, case: IntArray
) -> tuple[Laid, FloatArray | None]:
    """Boats on their ways to the bend, and the spacing of each case (B,) where they are a formation [m].

    Source of the lengths: a corner of angle a and radius r takes r tan(a / 2) from both legs, its arc is r a long.
    """
    draw, count = Draw(seed, case, boats), layout.paths or boats
    spacing = draw.per_scenario(formation.spacing_m) if formation else None
    angles = draw.per_boat(radians(layout.angle_deg))[:, :count]
    if formation:
        cruise = np.repeat(draw.per_scenario(formation.cruise_mps)[:, None], boats, axis=1)
    else:
        cruise = draw.per_boat(1.0 if layout.cruise_mps is None else layout.cruise_mps)
    goal = np.full(cruise.shape, BEND_M + layout.after_m)
    s = BEND_M - cruise * (layout.meet_s + draw.per_boat(layout.late_s))
    across = draw.per_boat(layout.across_m)
    more: dict[str, FloatArray | float] = {}
    if spacing is None:
        s -= np.arange(boats) // count * layout.rank_m
    else:
        offset = slots(boats) * spacing[:, None]
        behind = offset - offset[:, :1]
        s, goal = s + behind, goal + behind
        more = {"offset": offset, "member": 1.0}
    table = [
        [bend(k, count, layout.lane_m, angle, layout.corner_radius_m) for k, angle in enumerate(row)]
        for row in angles.tolist()
    ]
    paths = tuple(one.path(layout.corner_radius_m) for row in table for one in row)
    on = np.arange(boats) % count
    side, angle, lane_y, before = (
        np.array([[getattr(one, name) for one in row] for row in table])[:, on]
        for name in ("side", "angle", "lane_y", "before_m")
    )
    left = before - s  # of straight leg to the corner
    sin, cos = np.sin(angle), np.cos(angle)
    laid = Laid(
        paths=paths,
        path=np.arange(len(paths)).reshape(len(case), count)[:, on],
        x=-left * cos + side * sin * across,
        y=lane_y + side * left * sin + cos * across,
        psi=-side * angle,
        cruise=cruise,
        more={**more, "s": s, "goal_m": goal},
        used=draw.used,
    )
    return laid, spacing
