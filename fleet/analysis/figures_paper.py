"""A run in the manner of Bibuli et al. (2014), figures 5 to 10: tracks with vehicles at instants, speeds, ranges, and
the distance of each vehicle from its place on its path."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fleet.analysis.canvas import INK, canvas, look
from fleet.analysis.chart import Chart
from fleet.analysis.figures import drawn
from fleet.analysis.figures_map import approach_marks, draw_map, shape, symbols
from fleet.analysis.figures_time import line, separations, speeds
from fleet.analysis.separation import Approach, approaches
from fleet.analysis.series import Series

WIDTH_IN = 10.0
CLOSE_S = (30.0, 20.0)  # before and after the closest approach, drawn enlarged
CLOSE_STEP_S = 10.0
DPI = 100


def draw_paper(folder: Path | str, out: Path | str, series: Series | None = None) -> Path:
    """Draw the figures of a run in the paper's manner into one SVG, PNG or PDF file, by the ending of its name.

    Args:
        folder: a run folder
        out: the picture
        series: the run, if it was loaded already

    Raises:
        UsageError: matplotlib is not installed
    """
    return drawn(paper_figure, folder, out, series, DPI)


def paper_figure(series: Series, chart: Chart, title: str) -> Any:
    """Tracks (figures 5, 7, 10), speeds (6, 8), ranges, and distances from the ideal position (9)."""
    figure_of, style = canvas()
    with style():
        long, flip = shape(series)
        figure = figure_of(figsize=(WIDTH_IN, 7.4 if long else 6.0), layout="constrained")
        figure.suptitle(title, fontsize=12, fontweight="bold", color=INK)
        if long:
            grid = figure.add_gridspec(4, 2, height_ratios=(1.7, 1.0, 1.0, 1.0), width_ratios=(1.15, 1.0))
            whole, close = figure.add_subplot(grid[0, :]), figure.add_subplot(grid[1:, 0])
            side = [figure.add_subplot(grid[row, 1]) for row in (1, 2, 3)]
        else:
            grid = figure.add_gridspec(3, 2, width_ratios=(1.4, 1.0))
            whole, close = figure.add_subplot(grid[:, 0]), None
            side = [figure.add_subplot(grid[row, 1]) for row in (0, 1, 2)]
        draw_map(whole, series, chart, flip, marks=not long)
        whole.set_title("Tracks")
        if close is not None:
            _enlarged(close, series, chart, flip)
        speeds(side[0], series, 0.0)
        if side[0].get_legend() is not None:
            side[0].get_legend().remove()  # the tracks have it
        separations(side[1], series, chart.radius_m)
        _from_place(side[2], series)
        for axis, words in zip(side, ("Speeds; thin: asked for", "Ranges", "Distance from the own place"), strict=True):
            axis.set_title(words)
            axis.set_xlim(0.0, max(series.end_s, 1.0))
            axis.tick_params(labelbottom=axis is side[-1])
        side[-1].set_xlabel("time [s]")
    return figure


def _enlarged(axis: Any, series: Series, chart: Chart, flip: bool) -> None:
    """The closest approach from some time before it to some time after it."""
    pairs = approaches(series.tracks)
    if not pairs:
        axis.set_axis_off()
        return

    def at(x: Any, y: Any) -> tuple[Any, Any]:
        return (x, y) if flip else (y, x)

    nearest = pairs[0]
    axis.set_title(f"Closest approach: {nearest.distance_m:.2f} m at {nearest.at_s:.1f} s; circles: R")
    axis.set_aspect("equal", adjustable="datalim")
    if flip:
        axis.invert_yaxis()
    for x, y in chart.paths.values():
        axis.plot(*at(x, y), color="#cfcfcf", linewidth=3.0, zorder=1)
    xs, ys = [], []
    for name, track in sorted(series.tracks.items()):
        there = (track.t >= nearest.at_s - CLOSE_S[0]) & (track.t <= nearest.at_s + CLOSE_S[1])
        axis.plot(*at(track.x[there], track.y[there]), **look(series, name), zorder=3)
        xs += track.x[there].tolist()
        ys += track.y[there].tolist()
    approach_marks(axis, series, chart.radius_m, at)
    room = chart.radius_m
    across, up = at(np.array([min(xs) - room, max(xs) + room]), np.array([min(ys) - room, max(ys) + room]))
    axis.dataLim.set_points(np.column_stack((across, up)))
    axis.margins(0.0)
    axis.autoscale_view()
    axis.apply_aspect()
    symbols(axis, series, at, _times(nearest), all_said=True)
    axis.set_xlabel("north [m]" if flip else "east [m]")
    axis.set_ylabel("east [m]" if flip else "north [m]")


def _times(nearest: Approach) -> list[float]:
    """Round times about the closest approach."""
    first = np.ceil((nearest.at_s - CLOSE_S[0]) / CLOSE_STEP_S) * CLOSE_STEP_S
    return [float(t) for t in np.arange(first, nearest.at_s + CLOSE_S[1], CLOSE_STEP_S)]


def _from_place(axis: Any, series: Series) -> None:
    """Distance of each boat from its place in the formation on its path, along and across taken together."""
    axis.set_ylabel("[m]")
    for name, one in sorted(series.said.items()):
        line(axis, one.t, np.hypot(one.e_s, one.y_e), **look(series, name), label=name)
    axis.set_ylim(bottom=0.0)
