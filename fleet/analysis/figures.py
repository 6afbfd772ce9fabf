"""The picture of a run: paths, speeds, along-path errors and separations, with units, in colours all can tell apart."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from fleet.analysis.metrics import changed_s, launch_s, mission_tree
from fleet.analysis.separation import Approach, approaches, distance
from fleet.analysis.series import Floats, Series, load
from fleet.errors import FleetError, UsageError
from fleet.mission.model import KeepingClear, Mission

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")  # Okabe and Ito (2008)
STYLES = ("-", "--", ":", "-.")  # the next seven boats
MARK_EVERY_S = 20.0
LONG = 2.5  # extents of the tracks of this ratio get a strip across the page
INK, FAINT, ALARM = "#333333", "#9a9a9a", "#B00020"

Planned = dict[str, tuple[Floats, Floats]]
"""Planned paths by name: north, east [m]."""


def draw(folder: Path | str, out: Path | str, planned: Planned | None = None, radius_m: float | None = None) -> Path:
    """Draw the picture of the run in a folder into an SVG, PNG or PDF file, by the ending of its name.

    Args:
        folder: a run folder
        out: the picture
        planned: planned paths; otherwise from the folder's mission.toml
        radius_m: safety radius R; otherwise from mission.toml
    """
    series = load(folder)
    tree = mission_tree(Path(folder))
    title = str(tree.get("title") or series.header.get("mission") or Path(folder).name)
    radius = radius_m if radius_m is not None else _radius_m(tree)
    figure = picture(series, planned_paths(tree) if planned is None else planned, radius, title)
    target = Path(out)
    target.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(target, dpi=130)
    return target


def planned_paths(tree: dict[str, Any], step_m: float = 1.0) -> Planned:
    """Points of the paths of a mission file; empty if it has none that can be built."""
    from fleet.mission.plan import build

    try:
        paths = build(msgspec.convert(tree, Mission)).paths
    except (FleetError, msgspec.ValidationError):
        return {}
    planned: Planned = {}
    for name, path in paths.items():
        points = [path.at(s) for s in np.linspace(0.0, path.length, 2 + int(path.length / step_m)).tolist()]
        planned[name] = (np.array([one.x for one in points]), np.array([one.y for one in points]))
    return planned


def _radius_m(tree: dict[str, Any]) -> float:
    try:
        return msgspec.convert(tree.get("keeping_clear", {}), KeepingClear).radius_m
    except msgspec.ValidationError:
        return KeepingClear().radius_m


def picture(series: Series, planned: Planned, radius_m: float, title: str) -> Any:
    """The picture as a matplotlib figure.

    Raises:
        UsageError: matplotlib is not installed
    """
    figure_of, style = _matplotlib()
    with style():
        long, flip = _shape(series)
        figure = figure_of(figsize=(11.0, 7.2 if long else 8.0), layout="constrained")
        figure.suptitle(title, fontsize=13, fontweight="bold", color=INK)
        if long:
            grid = figure.add_gridspec(2, 3, height_ratios=(1.0, 1.35))
            places = [grid[0, :], grid[1, 0], grid[1, 1], grid[1, 2]]
        else:
            grid = figure.add_gridspec(3, 2, width_ratios=(1.35, 1.0))
            places = [grid[:, 0], grid[0, 1], grid[1, 1], grid[2, 1]]
        axes = [figure.add_subplot(place) for place in places]
        _paths(axes[0], series, planned, radius_m, flip)
        _speeds(axes[1], series)
        _errors(axes[2], series)
        _separations(axes[3], series, radius_m)
        for axis in axes[1:]:
            _time_axis(axis, series, labelled=axes[2])
    return figure


def _matplotlib() -> tuple[Any, Any]:
    """A figure that needs no screen, and the style of ours."""
    try:
        import matplotlib
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError as error:
        message = 'pictures need matplotlib, which is not installed: pip install "fleet-usv[plots]"'
        raise UsageError(message) from error
    ours: Any = {
        "font.size": 9.0,
        "axes.titlesize": 10.0,
        "axes.titlelocation": "left",
        "axes.edgecolor": FAINT,
        "axes.labelcolor": INK,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "#e6e6e6",
        "xtick.color": INK,
        "ytick.color": INK,
        "lines.linewidth": 1.6,
        "legend.frameon": False,
        "text.parse_math": False,
        "svg.fonttype": "path",
        "svg.hashsalt": "fleet",
    }

    def figure_of(**how: Any) -> Any:
        figure = Figure(**how)
        FigureCanvasAgg(figure)
        return figure

    return figure_of, lambda: matplotlib.rc_context(ours)


def look(series: Series, name: str) -> dict[str, str]:
    """Colour and line style of a boat, the same in every panel."""
    names = sorted({*series.boats, *series.tracks})
    number = names.index(name)
    return {"color": COLOURS[number % 7], "linestyle": STYLES[number // 7 % 4]}


def _shape(series: Series) -> tuple[bool, bool]:
    """Whether the tracks are long and narrow, and whether north is better drawn to the right."""
    xs = np.concatenate([one.x for one in series.tracks.values()])
    ys = np.concatenate([one.y for one in series.tracks.values()])
    north, east = float(np.ptp(xs)), float(np.ptp(ys))
    long = max(north, east) > LONG * max(min(north, east), 1.0)
    return long, long and north > east


def _paths(axis: Any, series: Series, planned: Planned, radius_m: float, flip: bool) -> None:
    """Tracks over planned paths; north is up, or to the right where that fits better."""

    def at(x: Any, y: Any) -> tuple[Any, Any]:
        return (x, y) if flip else (y, x)

    for number, (x, y) in enumerate(planned.values()):
        label = "planned" if number == 0 else None
        axis.plot(*at(x, y), color="#c4c4c4", linewidth=3.5, zorder=1, label=label, solid_capstyle="round")
    for name, track in sorted(series.tracks.items()):
        colours = look(series, name)
        axis.plot(*at(track.x, track.y), **colours, zorder=3, label=name)
        axis.plot(*at(track.x[:1], track.y[:1]), "o", color=colours["color"], markerfacecolor="white", zorder=4)
        marks = np.arange(MARK_EVERY_S, track.t[-1], MARK_EVERY_S)
        marks = marks[marks >= track.t[0]]
        places = at(np.interp(marks, track.t, track.x), np.interp(marks, track.t, track.y))
        axis.plot(*places, ".", color=colours["color"], markersize=6, zorder=4)
        _arrow(axis, at(track.x, track.y), colours["color"])
    _mark_times(axis, series, at)
    pairs = approaches(series.tracks)
    if pairs:
        _circles(axis, series, pairs[0], radius_m, at)
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.06)
    axis.set_title("Paths" + (f", closest approach {pairs[0].distance_m:.2f} m" if pairs else ""))
    horizontal, vertical = ("north [m]", "east [m]") if flip else ("east [m]", "north [m]")
    axis.set_xlabel(horizontal)
    axis.set_ylabel(vertical)
    if flip:
        axis.invert_yaxis()  # east is to the right of north: down the page
    axis.legend(loc="best", ncols=4 if flip else 1, fontsize=8)


def _arrow(axis: Any, places: tuple[Any, Any], colour: str) -> None:
    """An arrow head where a track ends."""
    across, up = places
    moved = np.hypot(across - across[-1], up - up[-1])
    far = np.flatnonzero(moved > 0.5)
    if len(far):
        start = (across[far[-1]], up[far[-1]])
        arrow = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 14}
        axis.annotate("", xy=(across[-1], up[-1]), xytext=start, arrowprops=arrow, zorder=5)


def _mark_times(axis: Any, series: Series, at: Any) -> None:
    """Say the time at the marks of the first boat."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=2.5, foreground="white")]
    if not series.boats or series.boats[0] not in series.tracks:
        return
    track = series.tracks[series.boats[0]]
    every = MARK_EVERY_S * max(1, round(track.t[-1] / MARK_EVERY_S / 8))
    for t in np.arange(every, track.t[-1], every):
        place = at(float(np.interp(t, track.t, track.x)), float(np.interp(t, track.t, track.y)))
        offset = {"xytext": (4, 7), "textcoords": "offset points"}
        axis.annotate(f"{t:.0f} s", place, **offset, fontsize=7.5, color=INK, zorder=6, path_effects=halo)


def _circles(axis: Any, series: Series, nearest: Approach, radius_m: float, at: Any) -> None:
    """The safety circles of the two boats when they were nearest."""
    from matplotlib.patches import Circle

    for name in (nearest.first, nearest.second):
        track, colour = series.tracks[name], look(series, name)["color"]
        place = at(np.interp(nearest.at_s, track.t, track.x), np.interp(nearest.at_s, track.t, track.y))
        axis.add_patch(Circle(place, radius_m, facecolor=colour, alpha=0.12, edgecolor="none", zorder=2))
        axis.add_patch(Circle(place, radius_m, fill=False, edgecolor=colour, linewidth=1.0, zorder=2))
        axis.plot(*place, "x", color=colour, zorder=5)


def _speeds(axis: Any, series: Series) -> None:
    axis.set_title("Speed over ground")
    for name, track in sorted(series.tracks.items()):
        axis.plot(track.t, track.speed, **look(series, name), label=name)
    for name, one in series.said.items():  # where a boat keeps clear: a bar along the bottom
        row = 0.015 + 0.03 * series.boats.index(name)
        height = np.where(one.avoiding, row, np.nan)
        axis.plot(one.t, height, transform=axis.get_xaxis_transform(), color=look(series, name)["color"], linewidth=4.0)
    if any(one.avoiding.any() for one in series.said.values()):
        top = 0.02 + 0.03 * len(series.said)
        axis.text(0.99, top, "bars: keeping clear", transform=axis.transAxes, ha="right", fontsize=7.5, color=INK)
    axis.set_ylabel("[m/s]")
    axis.set_ylim(bottom=0.0)


def _errors(axis: Any, series: Series) -> None:
    axis.set_title("Along-path error")
    axis.axhspan(-1.0, 1.0, color="#009E73", alpha=0.10, linewidth=0.0)
    for name, one in sorted(series.said.items()):
        axis.plot(one.t, one.e_s, **look(series, name), label=name)
    axis.set_ylabel("[m], + behind its slot")


def _separations(axis: Any, series: Series, radius_m: float) -> None:
    axis.set_title("Separation of centres")
    pairs = list(combinations(sorted(series.tracks), 2))
    few = len(pairs) <= 3
    nearest: list[tuple[Floats, Floats]] = []
    for number, (first, second) in enumerate(pairs):
        apart = distance(series.tracks[first], series.tracks[second])
        if apart is None:
            continue
        nearest.append((apart.t, apart.d))
        how = {"color": INK, "linestyle": STYLES[number % 4], "label": f"{first} - {second}"}
        axis.plot(apart.t, apart.d, **(how if few else {"color": "#c4c4c4", "linewidth": 0.8}))
    if nearest and not few:
        t = np.unique(np.concatenate([one for one, _ in nearest]))
        all_d = [np.interp(t, one, d, left=np.nan, right=np.nan) for one, d in nearest]
        axis.plot(t, np.nanmin(all_d, axis=0), color=INK, label="nearest pair")
    if pairs:
        top = max((float(d.max()) for _, d in nearest), default=1.0)
        axis.set_ylim(0.0, 1.08 * max(top, radius_m))
        axis.axhline(radius_m, color=ALARM, linewidth=1.0, linestyle=(0, (6, 3)))
        axis.text(1.0, radius_m, f"R = {radius_m:g} m ", transform=axis.get_yaxis_transform(), color=ALARM,
                  ha="right", va="bottom", fontsize=8)  # fmt: skip
        axis.legend(loc="upper right", fontsize=7.5)
    axis.set_ylabel("[m]")


def _time_axis(axis: Any, series: Series, labelled: Any) -> None:
    """Time, and when the formation was changed; one panel says what the line means."""
    axis.set_xlabel("time [s]")
    axis.set_xlim(0.0, series.end_s)
    if any(one.kind == "formation" for one in series.events):
        changed = changed_s(series, launch_s(series.said))
        axis.axvline(changed, color=FAINT, linewidth=1.0, linestyle=(0, (2, 2)))
        how = {"transform": axis.get_xaxis_transform(), "fontsize": 7, "rotation": 90, "ha": "right", "va": "top"}
        axis.text(changed, 0.99, "formation changed " if axis is labelled else "", **how, color=INK)
