"""A mission drawn before it is sailed: paths, the formation at launch, where boats begin, fence and home."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path as FilePath
from typing import Any

from fleet.errors import FleetError
from fleet.mission.model import Steady
from fleet.mission.plan import BoatPlan, Plan, Point, metres
from fleet.paths import Lane, sample

SEA, PATH, FENCE, INK, VESSEL = "#f4f8fa", "#5b7f95", "#b5473c", "#22313a", "#7d6b4f"
BOATS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5195", "#4d4d4d")
"""Colours that people with colour-blindness tell apart (Okabe and Ito), then two more; repeated for larger fleets."""


def picture(plan: Plan, where: str | FilePath) -> FilePath:
    """Draw the mission into a file, PNG or SVG by its name; returns where it is.

    North is up. A hull stands where a boat begins, with its safety circle; a ring is a boat's slot at launch, when the
    formation stands where the boats' starts say.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise FleetError("drawing needs matplotlib: pip install 'fleet-usv[plots]'") from None
    width, height = _size(plan)
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    _sea(axes, plan)
    _paths(axes, plan)
    _traffic(axes, plan)
    for boat, slot in zip(plan.boats, slots(plan), strict=True):
        _boat(axes, boat, slot, plan.mission.keeping_clear.radius_m)
    _legend(axes, plan)
    figure.savefig(where, dpi=150, bbox_inches="tight")
    return FilePath(where)


def slots(plan: Plan) -> list[Point | None]:
    """Where each boat's place is at launch; None off the ends of its path."""
    shape = plan.shape
    sailing = [boat for boat in plan.boats if not boat.starts_late]
    reference = _middle([boat.s - shape.ahead(boat.number) for boat in sailing or plan.boats])
    found: list[Point | None] = []
    for boat in plan.boats:
        s = reference + shape.ahead(boat.number)
        if boat.path.closed or 0.0 <= s <= boat.path.length:
            point = boat.lane(shape).at(s)
            found.append((point.x, point.y))
        else:
            found.append(None)
    return found


def _middle(values: Sequence[float]) -> float:
    """The median: a boat that begins far from its place does not move the others' slots."""
    ordered = sorted(values)
    half = len(ordered) // 2
    return ordered[half] if len(ordered) % 2 else 0.5 * (ordered[half - 1] + ordered[half])


def _extent(plan: Plan) -> tuple[float, float, float, float]:
    """South, north, west, east of everything drawn, with a margin [m]."""
    around = 1.5 * plan.mission.keeping_clear.radius_m
    points = [point for path in plan.paths.values() for point in sample(path, _step(path.length))]
    spots = points + [(b.x, b.y) for b in plan.boats] + list(plan.fence)
    spots += [plan.home] if plan.home is not None else []
    north, east = [x for x, _ in spots], [y for _, y in spots]
    if plan.mission.traffic:  # room to see where vessels come from
        around = max(around, 0.3 * max(max(north) - min(north), max(east) - min(east)))
    return min(north) - around, max(north) + around, min(east) - around, max(east) + around


def _size(plan: Plan) -> tuple[float, float]:
    """Width and height of the sheet [inch]: the shape of the area, within reason."""
    south, north, west, east = _extent(plan)
    shape = min(max((east - west) / max(north - south, 1.0), 0.35), 2.2)
    return (9.0, 9.0 / shape + 1.0) if shape > 1.0 else (8.0 * shape + 3.2, 8.0)


def _step(length: float) -> float:
    """Between two drawn points of a path [m]."""
    return max(length / 2000.0, 0.5)


def _sea(axes: Any, plan: Plan) -> None:
    """Frame, grid, fence and home."""
    south, north, west, east = _extent(plan)
    axes.set_facecolor(SEA)
    axes.set_aspect("equal")
    axes.set_xlim(west, east)
    axes.set_ylim(south, north)
    axes.grid(color="white", linewidth=1.0, zorder=0)
    axes.tick_params(colors=INK, labelsize=8)
    for spine in axes.spines.values():
        spine.set_visible(False)
    datum = plan.mission.datum
    axes.set_xlabel("east of the datum [m]", color=INK, fontsize=9)
    axes.set_ylabel(f"north of {datum.lat_deg:.4f}, {datum.lon_deg:.4f} [m]", color=INK, fontsize=9)
    axes.set_title(plan.mission.title, color=INK, fontsize=11, loc="left", wrap=True)
    if plan.fence:
        corners = [*plan.fence, plan.fence[0]]
        axes.plot([y for _, y in corners], [x for x, _ in corners], color=FENCE, linewidth=1.3, dashes=(6, 3), zorder=2)
    if plan.home is not None:
        axes.plot(plan.home[1], plan.home[0], marker="P", color=INK, markersize=9, markeredgecolor="white", zorder=5)
        _word(axes, plan.home, " home", INK)


def _paths(axes: Any, plan: Plan) -> None:
    """Every path with arrows the way it goes."""
    for name, path in plan.paths.items():
        points = sample(path, _step(path.length))
        axes.plot([y for _, y in points], [x for x, _ in points], color=PATH, linewidth=1.8, zorder=3)
        for share in (0.3, 0.6, 0.9):
            point = path.at(share * path.length)
            axes.annotate(
                "",
                xy=(point.y + 0.1 * point.ty, point.x + 0.1 * point.tx),
                xytext=(point.y - 0.1 * point.ty, point.x - 0.1 * point.tx),
                arrowprops={"arrowstyle": "-|>", "color": PATH, "mutation_scale": 16},
                zorder=3,
            )
        end = path.at(0.0 if path.closed else path.length)
        _word(axes, (end.x, end.y), name, PATH)
    for boat in plan.boats:
        own = boat.lane(plan.shape)
        if isinstance(own, Lane):
            step = _step(own.length)
            spots = [own.at(min(i * step, own.length)) for i in range(math.ceil(own.length / step) + 1)]
            axes.plot([p.y for p in spots], [p.x for p in spots], color=PATH, linewidth=0.7, zorder=3)


def _traffic(axes: Any, plan: Plan) -> None:
    """Other vessels' courses as their scripts begin them,; turns and giving way are not drawn."""
    for vessel in plan.mission.traffic:
        track = vessel.track
        if isinstance(track, Steady):
            (x, y), course = metres(track.start, plan.plane), math.radians(track.course_deg)
            far = vessel.speed_mps * plan.mission.duration_s
            points = [(x, y), (x + far * math.cos(course), y + far * math.sin(course))]
        else:
            points = [metres(point, plan.plane) for point in track.points]
        east, north = [y for _, y in points], [x for x, _ in points]
        axes.plot(east, north, color=VESSEL, linewidth=1.2, dashes=(5, 3), zorder=2.5, scalex=False, scaley=False)
        axes.plot(east[0], north[0], marker="s", markersize=6, color=VESSEL, zorder=4)
        across = min(max(east[0], axes.get_xlim()[0]), axes.get_xlim()[1])
        up = min(max(north[0], axes.get_ylim()[0]), axes.get_ylim()[1])
        words = f"{vessel.name}, {vessel.length_m:g} m, {vessel.speed_mps:g} m/s"
        if (across, up) != (east[0], north[0]):
            words += f", from {math.hypot(east[0] - across, north[0] - up):.0f} m away"
        _word(axes, (up, across), words, VESSEL)


def _boat(axes: Any, boat: BoatPlan, slot: Point | None, radius: float) -> None:
    """A boat where it begins, its safety circle, and its slot."""
    from matplotlib.patches import Circle, Polygon

    colour = BOATS[boat.number % len(BOATS)]
    axes.add_patch(Circle((boat.y, boat.x), radius, facecolor=colour, alpha=0.15, zorder=3.5))
    axes.add_patch(Circle((boat.y, boat.x), radius, fill=False, edgecolor=colour, linewidth=0.8, zorder=4))
    hull = Polygon(_hull(boat), facecolor="white" if boat.starts_late else colour, edgecolor=colour, zorder=6)
    axes.add_patch(hull)
    _word(axes, (boat.x, boat.y + radius), f"{boat.name}{' (late)' if boat.starts_late else ''}", colour)
    if slot is not None:
        axes.plot(slot[1], slot[0], marker="o", markersize=9, color=colour, fillstyle="none", linewidth=0, zorder=5)


def _hull(boat: BoatPlan) -> list[Point]:
    """Outline from above, (east, north), twice as large as life: a hull of 2.4 m would be a speck."""
    half = boat.limits.length_m
    c, s = math.cos(boat.psi), math.sin(boat.psi)
    outline = ((1.0, 0.0), (0.4, 0.4), (-1.0, 0.4), (-1.0, -0.4), (0.4, -0.4))
    return [(boat.y + half * (a * s + b * c), boat.x + half * (a * c - b * s)) for a, b in outline]


def _word(axes: Any, point: Point, text: str, colour: str) -> None:
    """A label to the right of a point."""
    axes.annotate(
        text,
        xy=(point[1], point[0]),
        xytext=(5, -3),
        textcoords="offset points",
        color=colour,
        fontsize=9,
        bbox={"facecolor": SEA, "edgecolor": "none", "alpha": 0.7, "pad": 1.0},
        zorder=7,
    )


def _legend(axes: Any, plan: Plan) -> None:
    """What the signs mean, and the figures that matter."""
    from matplotlib.lines import Line2D

    mission = plan.mission
    grey = "#6b7780"
    signs = [
        Line2D([], [], color=PATH, linewidth=1.8, label="path"),
        Line2D(
            [],
            [],
            color=grey,
            marker="o",
            markersize=11,
            alpha=0.5,
            linewidth=0,
            label=f"start (hull twice its size) and safety circle, R = {mission.keeping_clear.radius_m:g} m",
        ),
        Line2D(
            [],
            [],
            color=grey,
            marker="o",
            fillstyle="none",
            markersize=9,
            linewidth=0,
            label=f"slot, spacing {mission.formation.spacing_m:g} m",
        ),
    ]
    if plan.fence:
        signs.append(Line2D([], [], color=FENCE, linewidth=1.3, dashes=(6, 3), label="fence"))
    axes.legend(handles=signs, loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8, frameon=False, labelcolor=INK)
