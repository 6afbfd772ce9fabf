"""The pictures of a sweep: separations, delays, maps over a grid, tracks of a case."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fleet.analysis.canvas import ALARM, COLOURS, FAINT, INK, STYLES, canvas
from fleet.ops import FloatArray
from fleet.sim.batch import Results
from fleet.sim.sweep import ships_results
from fleet.sim.sweep.alone import closest
from fleet.sim.sweep.family import Point

BINS = 60
MOST_LEGEND = 10
TRACK_EVERY = 5  # ticks between points that are drawn
MARK_EVERY_S = 20.0
NEAR_S = 20.0  # before and after the closest approach, drawn enlarged
MAPS = {
    "collisions": "cases with a collision",
    "standstills": "cases with a standstill",
    "min_separation_m": "least separation [m]",
    "delay_p95_s": "delay, 95 % are below [s]",
    "formation_rms_m": "formation error, rms [m]",
    "off_place": "time 2 m off the place",
    "separation_median_m": "least separation, median [m]",
    "cross_track_rms_m": "distance from the path, rms [m]",
}
"""Figures that are drawn over a grid: the first four that the grid changes."""
MOST_MAPS = 4


def distributions(results: Sequence[Results]) -> Any:
    """Least separations of the cases, and delays of the boats that arrived."""
    figure_of, style = canvas()
    with style():
        figure = figure_of(figsize=(11.0, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        _separations(left, results)
        _times(right, results)
    return figure


def _separations(axis: Any, results: Sequence[Results]) -> None:
    least = np.concatenate([one.least_m for one in results])
    least = least[np.isfinite(least)]
    axis.set_title("Least separation of a case")
    axis.set_xlabel("least separation of two centres [m]")
    axis.set_ylabel("cases")
    if not len(least):
        axis.text(0.5, 0.5, "one boat alone", transform=axis.transAxes, ha="center")
        return
    radii = sorted({one.radius_m for one in results})
    hull = results[0].hull_m
    far = float(max(np.percentile(least, 99.0), 1.5 * radii[-1]))
    _bars(axis, least, 0.0, far)
    marks = [(hull, ALARM, f"hulls touch: {hull:g} m")] + [(r, INK, f"R = {r:g} m") for r in radii[:3]]
    for place, colour, words in marks:
        axis.axvline(place, color=colour, linewidth=1.2, linestyle=(0, (6, 3)))
        _said(axis, place, words, colour)


def _times(axis: Any, results: Sequence[Results]) -> None:
    """Delays; where no boat has a goal, how long boats of a formation are off their places."""
    if any(np.isfinite(one.nominal_s).any() for one in results):
        _delays(axis, results)
        return
    away = np.concatenate([np.ravel(one.off_place) for one in results])
    away = 100.0 * away[away >= 0.0]
    axis.set_title("Time of a boat off its place")
    axis.set_xlabel("share of the time 2 m or more from its place, of a wingman from abeam [%]")
    axis.set_ylabel("boats")
    if len(away):
        _bars(axis, away, 0.0, max(float(away.max()), 1.0))
    else:
        axis.text(0.5, 0.5, "no boat has a goal, or a place", transform=axis.transAxes, ha="center")


def _delays(axis: Any, results: Sequence[Results]) -> None:
    delay = np.concatenate([np.ravel(one.delay_s) for one in results])
    goals, delay = int((~np.isnan(delay)).sum()), delay[np.isfinite(delay)]
    axis.set_title("Delay of a boat" + (f"; {goals - len(delay)} never arrived" if goals > len(delay) else ""))
    axis.set_xlabel("arrival later than with nobody in the way [s]")
    axis.set_ylabel("boats")
    if not len(delay):
        axis.text(0.5, 0.5, "no boat arrived", transform=axis.transAxes, ha="center")
        return
    low, high = float(delay.min()), float(np.percentile(delay, 99.5))
    _bars(axis, delay, min(low, 0.0), max(high, low + 1.0))
    for share, words in ((50.0, "median"), (95.0, "95 %")):
        place = float(np.percentile(delay, share))
        axis.axvline(place, color=INK, linewidth=1.2, linestyle=(0, (6, 3)))
        _said(axis, place, f"{words}: {place:.1f} s", INK)


def _said(axis: Any, place: float, words: str, colour: str) -> None:
    """Words along a line across the picture, readable on bars."""
    from matplotlib.patheffects import withStroke

    how = {"color": colour, "fontsize": 8, "rotation": 90, "ha": "left", "va": "top", "textcoords": "offset points"}
    halo = [withStroke(linewidth=2.5, foreground="white")]
    axis.annotate(words, (place, 1.0), xycoords=("data", "axes fraction"), xytext=(3, -2), path_effects=halo, **how)


def _bars(axis: Any, values: FloatArray, low: float, high: float) -> None:
    """A histogram; what lies beyond is counted in the last bar, and said."""
    counts, edges = np.histogram(np.clip(values, low, high), bins=BINS, range=(low, high))
    axis.bar(edges[:-1], counts, width=np.diff(edges), align="edge", color=COLOURS[0], alpha=0.75)
    axis.set_xlim(low, high)
    axis.set_ylim(0.0, 1.25 * max(1, counts.max()))
    beyond = int((values > high).sum())
    if beyond:
        axis.text(1.0, 1.02, f"{beyond} beyond, in the last bar", transform=axis.transAxes, ha="right", fontsize=7.5)


def maps(points: Sequence[Point], tables: Sequence[dict[str, Any]]) -> Any | None:
    """Main figures over a grid: a map over two quantities, curves over one; None for other grids."""
    numbers = [dict(point.values) for point in points]
    names = list(numbers[0]) if numbers else []
    if not 1 <= len(names) <= 2 or len(points) < 2:
        return None
    titles = ships_results.MAPS if "contacts" in tables[0] else MAPS
    shown = [name for name in titles if len({one[name] for one in tables}) > 1][:MOST_MAPS] or list(titles)[:1]
    figure_of, style = canvas()
    with style():
        across = len(shown) if len(names) == 1 else min(len(shown), 2)
        down = -(-len(shown) // across)
        figure = figure_of(figsize=(11.0, 2.8 * down), layout="constrained")
        axes = list(figure.subplots(down, across, squeeze=False).flat)
        for axis in axes[len(shown) :]:
            axis.set_axis_off()
        for axis, name in zip(axes, shown, strict=False):
            values = [one[name] for one in tables]
            if len(names) == 1:
                _curve(axis, names[0], [one[names[0]] for one in numbers], values, titles[name])
            else:
                _map(figure, axis, names, numbers, values, titles[name])
    return figure


def _curve(axis: Any, name: str, across: list[Any], values: list[Any], title: str) -> None:
    known = [(place, float(value)) for place, value in enumerate(values) if value is not None]
    axis.plot([one for one, _ in known], [one for _, one in known], "o-", color=COLOURS[0])
    axis.set_xticks(range(len(across)), [_brief(one) for one in across])
    axis.set_xlabel(name)
    axis.set_title(title)
    low, high = min((one for _, one in known), default=0.0), max((one for _, one in known), default=1.0)
    axis.set_ylim(min(0.0, 1.08 * low), max(1.08 * high, 1e-3))


def _map(
    figure: Any, axis: Any, names: list[str], numbers: list[dict[str, Any]], values: list[Any], title: str
) -> None:
    rows = list(dict.fromkeys(_brief(one[names[0]]) for one in numbers))
    columns = list(dict.fromkeys(_brief(one[names[1]]) for one in numbers))
    table = np.full((len(rows), len(columns)), np.nan)
    for one, value in zip(numbers, values, strict=True):
        if value is not None:
            table[rows.index(_brief(one[names[0]])), columns.index(_brief(one[names[1]]))] = value
    image = axis.imshow(table, aspect="auto", origin="lower", cmap="viridis")
    axis.grid(False)
    axis.set_xticks(range(len(columns)), columns)
    axis.set_yticks(range(len(rows)), rows)
    axis.set_xlabel(names[1])
    axis.set_ylabel(names[0])
    axis.set_title(title)
    middle = (np.nanmin(table) + np.nanmax(table)) / 2.0 if np.isfinite(table).any() else 0.0
    for i, row in enumerate(table.tolist()):
        for j, value in enumerate(row):
            if np.isfinite(value):
                colour = "white" if value <= middle else "black"
                axis.text(j, i, f"{value:.4g}", ha="center", va="center", color=colour, fontsize=8)
    figure.colorbar(image, ax=axis)


def _brief(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float | int) and not isinstance(value, bool) else str(value)


def tracks(results: Results, title: str) -> Any:
    """The tracks of one case sailed with its trace: all of them, the closest approach enlarged, separations in time."""
    trace = results.traces[0]
    near = closest(trace)
    figure_of, style = canvas()
    with style():
        figure = figure_of(figsize=(11.0, 4.4), layout="constrained")
        figure.suptitle(title, fontsize=11, fontweight="bold", color=INK)
        whole, close, apart = figure.subplots(1, 3)
        _tracks(whole, results, slice(0, None, TRACK_EVERY))
        whole.set_title("Tracks, a dot every 20 s")
        if whole.get_legend_handles_labels()[0] and trace.x.shape[1] <= MOST_LEGEND:
            whole.legend(fontsize=7, loc="best")
        if near is None:
            close.set_axis_off()
            apart.set_axis_off()
            return figure
        about = np.flatnonzero(abs(trace.t - near.t_s) <= NEAR_S)
        _tracks(close, results, slice(int(about[0]), int(about[-1]) + 1))
        _circles(close, results, near.first - 1, near.second - 1, near.t_s)
        close.set_title(f"Closest: boats {near.first}, {near.second}, {results.least_m[0]:.2f} m at {near.t_s:.1f} s")
        _apart(apart, results)
    return figure


def _tracks(axis: Any, results: Results, ticks: slice) -> None:
    trace = results.traces[0]
    every = round(MARK_EVERY_S / float(trace.t[1] - trace.t[0])) if len(trace.t) > 1 else 1
    for k in range(trace.x.shape[1]):
        look = {"color": COLOURS[k % 7], "linestyle": STYLES[k // 7 % 4]}
        axis.plot(trace.y[ticks, k], trace.x[ticks, k], **look, linewidth=1.2, label=f"boat {k + 1}")
        axis.plot(trace.y[:1, k], trace.x[:1, k], "o", color=look["color"], markerfacecolor="white")
        dots = np.arange(len(trace.t))[ticks]
        dots = dots[dots % every == 0]
        axis.plot(trace.y[dots, k], trace.x[dots, k], ".", color=look["color"], markersize=4)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("east [m]")
    axis.set_ylabel("north [m]")


def _circles(axis: Any, results: Results, i: int, j: int, t_s: float) -> None:
    """The two nearest boats with R and hull, when they were nearest; the picture is about them."""
    from matplotlib.patches import Circle

    trace = results.traces[0]
    places = [
        (float(np.interp(t_s, trace.t, trace.y[:, k])), float(np.interp(t_s, trace.t, trace.x[:, k]))) for k in (i, j)
    ]
    for k, place in zip((i, j), places, strict=True):
        colour = COLOURS[k % 7]
        axis.add_patch(Circle(place, results.radius_m, facecolor=colour, alpha=0.10, edgecolor="none"))
        axis.add_patch(Circle(place, results.hull_m / 2.0, fill=False, edgecolor=colour))
        axis.plot(*place, "x", color=colour)
    half = 2.5 * results.radius_m
    east, north = (places[0][0] + places[1][0]) / 2.0, (places[0][1] + places[1][1]) / 2.0
    axis.set_aspect("equal", adjustable="box")
    axis.set_xlim(east - half, east + half)
    axis.set_ylim(north - half, north + half)


def _apart(axis: Any, results: Results) -> None:
    """The nearest pair at every moment."""
    trace = results.traces[0]
    nearest = np.full(len(trace.t), np.inf)
    for i in range(trace.x.shape[1]):
        for j in range(i):
            nearest = np.minimum(nearest, np.hypot(trace.x[:, i] - trace.x[:, j], trace.y[:, i] - trace.y[:, j]))
    axis.plot(trace.t, nearest, color=INK, linewidth=1.2)
    for level, colour, words in (
        (results.radius_m, FAINT, f"R = {results.radius_m:g} m"),
        (results.hull_m, ALARM, f"hulls touch: {results.hull_m:g} m"),
    ):
        axis.axhline(level, color=colour, linewidth=1.0, linestyle=(0, (6, 3)))
        axis.text(1.0, level, words, transform=axis.get_yaxis_transform(), ha="right", va="bottom", fontsize=7.5,
                  color=INK if colour == FAINT else colour)  # fmt: skip
    axis.set_ylim(0.0, min(float(nearest.max()), 6.0 * results.radius_m) * 1.05)
    axis.set_xlim(0.0, float(trace.t[-1]))
    axis.set_xlabel("time [s]")
    axis.set_ylabel("[m]")
    axis.set_title("Separation of the nearest pair")
