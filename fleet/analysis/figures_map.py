"""The map of a run: tracks over planned paths, boats at chosen instants, other vessels, fence, closest approaches."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from fleet.analysis.canvas import ALARM, FAINT, INK, legend, look, words_on
from fleet.analysis.chart import Chart
from fleet.analysis.separation import Approach, approaches
from fleet.analysis.series import Series, Track
from fleet.analysis.traffic import Passing, passings

LONG = 2.5  # extents of the tracks of this ratio get a strip across the page
INSTANTS = 8  # about so many times boats are drawn
STEPS_S = (1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0)
SYMBOL = 0.032  # least length of a boat's symbol, as a share of the picture
HULL = ((1.0, 0.0), (0.35, 0.34), (-1.0, 0.34), (-1.0, -0.34), (0.35, -0.34))  # halves of length; bow first
SHIP = ((1.0, 0.0), (0.6, 0.2), (-1.0, 0.2), (-1.0, -0.2), (0.6, -0.2))
MOST_APPROACHES = 3  # that are marked
NEAR = 2.0  # radii R: pairs farther apart are not marked

At = Callable[[Any, Any], tuple[Any, Any]]


def shape(series: Series) -> tuple[bool, bool]:
    """Whether the tracks are long and narrow, and whether north is better drawn to the right."""
    known = [one for one in series.tracks.values() if len(one.t)]
    if not known:
        return False, False
    north = float(np.ptp(np.concatenate([one.x for one in known])))
    east = float(np.ptp(np.concatenate([one.y for one in known])))
    long = max(north, east) > LONG * max(min(north, east), 1.0)
    return long, long and north > east


def instants(series: Series, about: int = INSTANTS) -> list[float]:
    """Round times at which boats are drawn [s]."""
    end = series.end_s
    step = next((one for one in STEPS_S if end / one <= about + 0.5), STEPS_S[-1])
    return [float(t) for t in np.arange(step, end + 1e-6, step)]


def draw_map(axis: Any, series: Series, chart: Chart, flip: bool, *, marks: bool = True) -> None:
    """Draw the map; north is up, or to the right where that fits better."""

    def at(x: Any, y: Any) -> tuple[Any, Any]:
        return (x, y) if flip else (y, x)

    horizontal, vertical = ("north [m]", "east [m]") if flip else ("east [m]", "north [m]")
    axis.set_xlabel(horizontal)
    axis.set_ylabel(vertical)
    axis.set_aspect("equal", adjustable="datalim")
    if flip:
        axis.invert_yaxis()  # east is to the right of north: down the page
    if not any(len(track.t) for track in series.tracks.values()):
        axis.text(0.5, 0.5, "no position is known", transform=axis.transAxes, ha="center")
        return
    for number, (x, y) in enumerate(chart.paths.values()):
        label = "planned path" if number == 0 else None
        axis.plot(*at(x, y), color="#cfcfcf", linewidth=3.0, zorder=1, label=label, solid_capstyle="round")
    for name, track in sorted(series.tracks.items()):
        if not len(track.t):
            continue
        axis.plot(*at(track.x, track.y), **look(series, name), zorder=3, label=name)
        start = at(track.x[:1], track.y[:1])
        axis.plot(*start, "o", color=look(series, name)["color"], markerfacecolor="white", zorder=4)
    _traffic(axis, series, at)
    if marks:
        approach_marks(axis, series, chart.radius_m, at)
    _limit(axis, series, chart.radius_m, at)
    _fence(axis, chart, at)
    symbols(axis, series, at, instants(series))
    legend(axis)


def _limit(axis: Any, series: Series, radius_m: float, at: At) -> None:
    """Show where the boats were, and where vessels were when a boat was nearest to them."""
    xs = np.concatenate([track.x for track in series.tracks.values()])
    ys = np.concatenate([track.y for track in series.tracks.values()])
    near = [place(series.traffic[one.vessel], one.at_s) for one in passings(series.tracks, series.traffic)]
    far = max(float(np.ptp(xs)), float(np.ptp(ys)), 50.0)
    close = [(x, y) for x, y in near if np.min(np.hypot(xs - x, ys - y)) < far]
    xs, ys = np.append(xs, [x for x, _ in close]), np.append(ys, [y for _, y in close])
    room = max(0.06 * far, 1.5 * radius_m)
    across, up = at(np.array([xs.min() - room, xs.max() + room]), np.array([ys.min() - room, ys.max() + room]))
    axis.dataLim.set_points(np.column_stack((across, up)))
    axis.margins(0.0)
    axis.autoscale_view()
    axis.apply_aspect()  # the equal scale of both directions widens one of them


def symbols(axis: Any, series: Series, at: At, times: list[float], *, all_said: bool = False) -> None:
    """Hulls at the times, to scale or larger where that could not be seen; times are written at one boat or all."""
    size = SYMBOL * _across(axis)
    said = [name for name in series.boats if name in series.tracks and len(series.tracks[name].t)]
    for name, track in sorted(series.tracks.items()):
        length = max(track.length_m if math.isfinite(track.length_m) else 0.0, size)
        colour = look(series, name)["color"]
        for t in [one for one in times if len(track.t) and track.t[0] <= one <= track.t[-1]]:
            _hull(axis, track, t, length, at, HULL, facecolor=colour, edgecolor="white", linewidth=0.6, zorder=5)
            if name in (said if all_said else said[:1]):
                words_on(axis, at(*place(track, t)), f"{t:g} s", xytext=(4, 8), color=colour if all_said else INK)


def _across(axis: Any) -> float:
    """How far the picture goes from left to right [m]."""
    low, high = axis.get_xlim()
    return abs(float(high - low))


def place(track: Track, t: float) -> tuple[float, float]:
    """Where a hull was at a time: north, east [m]."""
    return float(np.interp(t, track.t, track.x)), float(np.interp(t, track.t, track.y))


def _hull(axis: Any, track: Track, t: float, length_m: float, at: At, outline: Any, **how: Any) -> None:
    """A hull at a time, its bow where it headed."""
    from matplotlib.patches import Polygon

    x, y = place(track, t)
    psi = track.psi[int(np.argmin(np.abs(track.t - t)))]
    c, s = (math.cos(psi), math.sin(psi)) if math.isfinite(psi) else (1.0, 0.0)
    half = 0.5 * length_m
    corners = [at(x + half * (a * c - b * s), y + half * (a * s + b * c)) for a, b in outline]
    axis.add_patch(Polygon(corners, **how))


def around(series: Series, name: str) -> tuple[float, float]:
    """Where the boats were along an axis, with as much again to both sides [m]."""
    values = np.concatenate([getattr(track, name) for track in series.tracks.values()])
    low, high = float(values.min()), float(values.max())
    room = max(high - low, 100.0)
    return low - room, high + room


def _traffic(axis: Any, series: Series, at: At) -> None:
    """Tracks of other vessels within the boats' waters, with their hulls at the instants and where one was nearest."""
    near: dict[str, Passing] = {}
    for passing in passings(series.tracks, series.traffic):
        near.setdefault(passing.vessel, passing)
    south, north = around(series, "x")
    west, east = around(series, "y")
    for name, track in sorted(series.traffic.items()):
        inside = (track.x > south) & (track.x < north) & (track.y > west) & (track.y < east)
        x, y = np.where(inside, track.x, np.nan), np.where(inside, track.y, np.nan)
        length = f", {track.length_m:g} m long" if math.isfinite(track.length_m) else ""
        axis.plot(*at(x, y), color=FAINT, linewidth=1.2, linestyle=(0, (5, 2)), zorder=2, label=name + length)
        for t in instants(series):
            _vessel(axis, track, t, at, inside, facecolor="#ededed", edgecolor=FAINT, linewidth=0.6, zorder=2.2)
        if name in near:
            t = near[name].at_s
            if _vessel(axis, track, t, at, inside, facecolor="#c9c9c9", edgecolor=INK, linewidth=0.9, zorder=2.5):
                words_on(axis, at(*place(track, t)), f"{name} at {t:.0f} s", fontsize=7.5, ha="center", xytext=(0, -3))


def _vessel(axis: Any, track: Track, t: float, at: At, inside: Any, **how: Any) -> bool:
    """A vessel's hull at a time, true to scale, if it is within the picture then."""
    if not len(track.t) or not track.t[0] <= t <= track.t[-1]:
        return False
    if not inside[int(np.argmin(np.abs(track.t - t)))]:
        return False
    _hull(axis, track, t, track.length_m if math.isfinite(track.length_m) else 5.0, at, SHIP, **how)
    return True


def _fence(axis: Any, chart: Chart, at: At) -> None:
    """The fence, as much of it as is near the boats."""
    if not chart.fence:
        return
    from matplotlib.lines import Line2D

    x, y = (np.interp(np.linspace(0.0, len(one), 1000), np.arange(len(one) + 1), [*one, one[0]])
            for one in zip(*chart.fence, strict=True))  # fmt: skip
    across, up = at(x, y)
    (left, right), (low, high) = sorted(axis.get_xlim()), sorted(axis.get_ylim())
    if ((across > left) & (across < right) & (up > low) & (up < high)).any():
        axis.add_artist(
            Line2D(across, up, color=ALARM, linewidth=1.2, linestyle=(0, (1, 2)), zorder=1.5, label="fence")
        )


def approach_marks(axis: Any, series: Series, radius_m: float, at: At) -> None:
    """Where pairs were nearest: a line from one to the other; the nearest pair with its safety circles."""
    from matplotlib.patches import Circle

    pairs = [one for one in approaches(series.tracks)[:MOST_APPROACHES] if one.distance_m < NEAR * radius_m]
    for number, pair in enumerate(pairs):
        places = [at(*place(series.tracks[name], pair.at_s)) for name in (pair.first, pair.second)]
        axis.plot(*zip(*places, strict=True), color=ALARM, linewidth=1.0, marker="x", markersize=5, zorder=6,
                  label="closest approaches" if number == 0 else None)  # fmt: skip
        if number:
            continue
        for name, centre in zip((pair.first, pair.second), places, strict=True):
            colour = look(series, name)["color"]
            axis.add_patch(Circle(centre, radius_m, facecolor=colour, alpha=0.15, edgecolor="none", zorder=2))
            axis.add_patch(Circle(centre, radius_m, fill=False, edgecolor=colour, linewidth=1.0, zorder=2))
        middle = tuple(0.5 * (places[0][k] + places[1][k]) for k in (0, 1))
        words_on(axis, middle, said(pair), xytext=(6, -14), color=ALARM)


def said(pair: Approach) -> str:
    """`7.68 m at 74.5 s`."""
    return f"{pair.distance_m:.2f} m at {pair.at_s:.1f} s"
