"""Time series of a run on one time axis: separations, speeds, errors, modes, and what happened."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np

from fleet.analysis.canvas import ALARM, FAINT, INK, STYLES, legend, look, runs_of, thinned, words_on
from fleet.analysis.metrics import FORMED_M
from fleet.analysis.separation import Distance, distance
from fleet.analysis.series import Floats, Series
from fleet.analysis.traffic import hull_distance

MOST_PAIRS = 3  # that are told apart; of more, the nearest pair stands out
MOST_LINES = 60  # pairs that are drawn at all, nearest first
MOST_MARKS = 12  # happenings that are written
MODES: dict[str, tuple[str, str]] = {  # colour, hatch
    "standby": ("#f0f0f0", ""),
    "follow": ("#cfe3f3", ""),
    "avoid": ("#E69F00", ""),
    "hold": ("#a9a9a9", ""),
    "return": ("#009E73", ""),
    "alone": ("#CC79A7", ""),
    "neutral": ("#ffffff", "////"),
    "fault": ("#B00020", ""),
}
MARKED = {"formation": INK, "trouble": ALARM, "stop": ALARM, "kill": ALARM, "fault": ALARM}
"""Kinds of events that are marked, with their colours."""
SHORT = 28  # letters of an event that are written


def panels(series: Series) -> list[tuple[str, float]]:
    """Which panels there are, from top to bottom, and their heights as shares."""
    chosen = [("separations", 1.3)] if len(series.tracks) > 1 else []
    chosen += [("vessels", 1.0)] if series.traffic else []
    chosen.append(("speeds", 1.3))
    if series.said:
        chosen += [("along", 1.0), ("cross", 1.0), ("modes", 0.25 + 0.17 * len(series.said))]
    return chosen


def draw_panels(axes: Sequence[Any], series: Series, radius_m: float) -> None:
    """Draw the panels of `panels`, one an axis; all share the time."""
    for axis, (name, _) in zip(axes, panels(series), strict=True):
        _DRAWN[name](axis, series, radius_m)
    _marks(axes, series)
    for axis in axes:
        axis.set_xlim(0.0, max(series.end_s, 1.0))
        axis.tick_params(labelbottom=axis is axes[-1])
    axes[-1].set_xlabel("time since the beginning of the run [s]")


def line(axis: Any, t: Floats, values: Floats, **how: Any) -> None:
    """A line with as many points as can be seen."""
    axis.plot(*thinned(t, values), **how)


def separations(axis: Any, series: Series, radius_m: float) -> None:
    """Distances of centres, with R and where hulls touch."""
    axis.set_title("Separation of centres")
    axis.set_ylabel("[m]")
    pairs: list[tuple[str, Distance]] = []
    for first, second in combinations(sorted(series.tracks), 2):
        apart = distance(series.tracks[first], series.tracks[second])
        if apart is not None:
            pairs.append((f"{first} - {second}", apart))
    if not pairs:
        return
    few = len(pairs) <= MOST_PAIRS
    nearest = sorted(pairs, key=lambda one: float(one[1].least.min()))[: None if few else MOST_LINES]
    for number, (label, apart) in enumerate(sorted(nearest, key=lambda one: one[0])):
        how = {"color": INK, "linestyle": STYLES[number % 4], "label": label, "linewidth": 1.3}
        line(axis, apart.t, apart.d, **(how if few else {"color": "#c4c4c4", "linewidth": 0.7}))
    if not few:
        t = np.unique(np.concatenate([one.t for _, one in nearest]))
        t = t[:: max(1, len(t) // 4000)]
        least = np.full(len(t), np.inf)
        for _, one in nearest:
            least = np.fmin(least, np.interp(t, one.t, one.d, left=np.inf, right=np.inf))
        line(axis, t, least, color=INK, label="nearest pair")
    top = max(float(one.d.max()) for _, one in (pairs if few else nearest[:1]))
    axis.set_ylim(0.0, min(1.08 * max(top, radius_m), max(8.0 * radius_m, 1.0) if not few else np.inf))
    level(axis, radius_m, f"R = {radius_m:g} m", INK)
    lengths = [one.length_m for one in series.tracks.values()]
    if not np.isnan(lengths).any():
        hull = sum(sorted(lengths)[-2:]) / 2.0
        level(axis, hull, f"hulls can touch: {hull:g} m", ALARM, left=True)
    legend(axis)


def level(axis: Any, value: float, words: str, colour: str, *, left: bool = False) -> None:
    """A line across, and what it means, at its right or left end."""
    axis.axhline(value, color=colour, linewidth=1.0, linestyle=(0, (6, 3)))
    end = {"ha": "left", "xytext": (2, 2)} if left else {"ha": "right", "xytext": (-2, 2)}
    words_on(axis, (0.0 if left else 1.0, value), words, xycoords=axis.get_yaxis_transform(), color=colour, **end)


def vessels(axis: Any, series: Series, _: float) -> None:
    """Distance of each boat's hull from that of the nearest vessel."""
    axis.set_title("Distance to the nearest other vessel, between hulls")
    axis.set_ylabel("[m]")
    top = 0.0
    for name, own in sorted(series.tracks.items()):
        least = np.full(len(own.t), np.inf)
        for other in series.traffic.values():
            if len(other.t):
                there = (own.t >= other.t[0]) & (own.t <= other.t[-1])
                least[there] = np.minimum(least[there], hull_distance(own, other, own.t[there]))
        least[np.isinf(least)] = np.nan
        if np.isfinite(least).any():
            line(axis, own.t, least, **look(series, name), label=name)
            top = max(top, 4.0 * float(np.nanmin(least)) + 60.0)
    axis.set_ylim(0.0, top or 1.0)


def speeds(axis: Any, series: Series, _: float) -> None:
    """Speed over ground, and thin what the boats asked for."""
    axis.set_title("Speed over ground; thin: asked for")
    axis.set_ylabel("[m/s]")
    for name, track in sorted(series.tracks.items()):
        line(axis, track.t, track.speed, **look(series, name), label=name)
    for name, one in sorted(series.said.items()):
        line(axis, one.t, one.u_d, color=look(series, name)["color"], linewidth=0.7, alpha=0.65)
    top = max(
        (float(np.nanmax(one.speed)) for one in series.tracks.values() if np.isfinite(one.speed).any()), default=0.0
    )
    axis.set_ylim(0.0, 1.08 * top or 1.0)
    legend(axis)


def along(axis: Any, series: Series, _: float) -> None:
    """Along-path error: that of the formation."""
    axis.set_title(f"Along-path (formation) error, + behind its slot; shaded: within {FORMED_M:g} m")
    axis.axhspan(-FORMED_M, FORMED_M, color="#009E73", alpha=0.12, linewidth=0.0)
    axis.set_ylabel("[m]")
    for name, one in sorted(series.said.items()):
        line(axis, one.t, one.e_s, **look(series, name))


def cross(axis: Any, series: Series, _: float) -> None:
    """Cross-track error."""
    axis.set_title("Cross-track error, + to starboard of the path")
    axis.set_ylabel("[m]")
    for name, one in sorted(series.said.items()):
        line(axis, one.t, one.y_e, **look(series, name))


def modes(axis: Any, series: Series, _: float) -> None:
    """A bar a boat, coloured by what it was doing."""
    from matplotlib.patches import Patch

    axis.set_title("Mode of each boat")
    used: list[str] = []
    names = sorted(series.said)
    for row, name in enumerate(names):
        one = series.said[name]
        words = np.array(one.mode)
        for mode in sorted(set(one.mode)):
            if mode not in used:
                used.append(mode)
            colour, hatch = MODES.get(mode, ("#ffffff", "..."))
            bars = []
            for begin, end in runs_of(words == mode):
                until = one.t[end] if end < len(one.t) else one.t[-1]
                bars.append((float(one.t[begin]), max(float(until - one.t[begin]), 0.2)))
            axis.broken_barh(bars, (row - 0.4, 0.8), facecolor=colour, hatch=hatch, edgecolor=FAINT, linewidth=0.3)
    axis.set_yticks(range(len(names)), names)
    for label, name in zip(axis.get_yticklabels(), names, strict=True):
        label.set_color(look(series, name)["color"])
        label.set_fontweight("bold")
    axis.set_ylim(len(names) - 0.5, -0.5)
    axis.grid(visible=False, axis="y")
    order = [one for one in MODES if one in used] + [one for one in used if one not in MODES]
    patches = [Patch(facecolor=MODES.get(one, ("#ffffff", "..."))[0], hatch=MODES.get(one, ("", "..."))[1],
                     edgecolor=FAINT, linewidth=0.5, label=one) for one in order]  # fmt: skip
    legend(axis, handles=patches)


_DRAWN = {"separations": separations, "vessels": vessels, "speeds": speeds, "along": along, "cross": cross,
          "modes": modes}  # fmt: skip


def happenings(series: Series) -> list[tuple[float, str, str]]:
    """Formation changes and troubles: when [s], what in few words, colour; the same on several boats once.

    A formation is told in full by its event; what it has in common with the one before is left out.
    """
    found: dict[tuple[float, str], tuple[str, list[str]]] = {}
    before: dict[str, list[str]] = {}
    for event in sorted(series.events, key=lambda one: one.stamp_ns):
        if event.kind not in MARKED:
            continue
        parts = event.text.split(", revision")[0].split(", ")
        if event.kind == "formation":
            parts, before[event.boat] = [one for one in parts if one not in before.get(event.boat, [])] or parts, parts
        key = (round(series.seconds(event.stamp_ns), 1), ", ".join(parts))
        found.setdefault(key, (MARKED[event.kind], []))[1].append(event.boat)
    marks = []
    for (at, words), (colour, boats) in found.items():
        who = "" if len(boats) > 1 or not boats[0] else f"{boats[0]}: "
        marks.append((at, who + words, colour))
    return marks


def _marks(axes: Sequence[Any], series: Series) -> None:
    """A line across all panels for each happening, with words in the top one."""
    marks = happenings(series)
    for number, (at, words, colour) in enumerate(marks):
        for axis in axes:
            axis.axvline(at, color=colour, linewidth=1.0, linestyle=(0, (2, 2)), zorder=1.5)
        if number < MOST_MARKS:
            cut = words if len(words) <= SHORT else words[: SHORT - 3] + "..."
            words_on(axes[0], (at, 0.0), cut, xycoords=("data", "axes fraction"), xytext=(3, 3), rotation=90,
                     fontsize=6.5, color=colour, ha="left", va="bottom")  # fmt: skip
