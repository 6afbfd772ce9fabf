"""The tables of a run's page: checks, figures, boats, approaches, other vessels, decisions, events."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from fleet.analysis.canvas import look
from fleet.analysis.decisions import TURN_DEG, Decision, decisions
from fleet.analysis.html import html_table, shown
from fleet.analysis.metrics import FIGURES, Summary, counted
from fleet.analysis.separation import approaches
from fleet.analysis.series import Series
from fleet.analysis.traffic import passings
from fleet.mission.checks import CHECKS

MOST_EVENTS, MOST_PAIRS, MOST_DECISIONS = 500, 50, 300


def checks(summary: Summary) -> str:
    """What the mission asked for, and what it got."""
    if not summary.checks:
        return ""
    rows = []
    for one in summary.checks:
        unit = FIGURES.get(one.name, ("", ""))[1]
        said = '<span class="ok">ok</span>' if one.ok else '<span class="bad">not ok</span>'
        known = CHECKS.get(one.name)
        limit = f"{known.direction} " if known is not None else ""
        meaning = f'<span class="means">{escape(known.meaning)}</span>' if known is not None else ""
        rows.append((escape(one.name), shown(one.value, unit), f"{limit}{one.limit:g} {unit}".strip(), said, meaning))
    return "<h2>Checks</h2>" + html_table(("check", "value", "limit", "", "what it asks"), rows)


def figures(summary: Summary) -> str:
    """Every figure of the run with its meaning."""
    rows = [
        (name, shown(getattr(summary, name), unit), f'<span class="means">{escape(meaning)}</span>')
        for name, (meaning, unit) in FIGURES.items()
    ]
    return "<h2>Figures</h2>" + html_table(("figure", "value", "what it means"), rows)


def boats(series: Series) -> str:
    """A row for each boat."""
    rows = []
    for name in series.boats:
        track, one = series.tracks.get(name), series.said.get(name)
        moved = track is not None and len(track.t) > 0
        far = float(np.sum(np.hypot(np.diff(track.x), np.diff(track.y)))) if track is not None and moved else None
        row = [_named(series, name), shown(far, "m"), shown(_mean(track.speed) if track is not None else None, "m/s")]
        if one is None:
            row += ["none"] * 4
        else:
            step = float(np.median(np.diff(one.t))) if len(one.t) > 1 else 0.0
            avoided = float(np.count_nonzero(one.avoiding)) * step
            row += [
                escape(one.mode[-1]) if one.mode else "none",
                shown(_last(one.e_s), "m"),
                shown(_largest(one.y_e), "m"),
                shown(avoided, "s"),
            ]
        mine = {name: series.statuses.get(name, [])}
        row += [shown(counted(mine, kind)) for kind in ("ticks", "ticks_late", "messages_lost", "messages_refused")]
        rows.append(row)
    heads = (
        "boat",
        "sailed",
        "mean speed",
        "mode at the end",
        "along-path error at the end",
        "largest cross-track error",
    )
    counters = ("keeping clear", "ticks", "late", "messages lost", "refused")
    return "<h2>Boats</h2>" + html_table((*heads, *counters), rows) if rows else ""


def _named(series: Series, name: str) -> str:
    """A boat's name with its colour."""
    if name not in series.boats and name not in series.tracks:
        return escape(name)
    return f'<span class="key" style="background:{look(series, name)["color"]}"></span>{escape(name)}'


def _mean(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else None


def _last(values: np.ndarray) -> float | None:
    return float(values[-1]) if len(values) else None


def _largest(values: np.ndarray) -> float | None:
    known = np.abs(values[np.isfinite(values)])
    return float(known.max()) if len(known) else None


def mode_at(series: Series, boat: str, t: float) -> str:
    """What a boat was doing at a time; empty where it had not said."""
    one = series.said.get(boat)
    k = -1 if one is None else int(np.searchsorted(one.t, t + 1e-6, side="right")) - 1
    return one.mode[k] if one is not None and k >= 0 else ""


def closest(series: Series) -> str:
    """Closest approach of every pair, with what both were doing."""
    pairs = approaches(series.tracks)
    if not pairs:
        return ""
    rows = [
        (
            f"{escape(one.first)} - {escape(one.second)}",
            f"{one.distance_m:.2f} m",
            f"{one.at_s:.1f} s",
            escape(", ".join(f"{name} {mode_at(series, name, one.at_s) or '?'}" for name in (one.first, one.second))),
            f'<span class="bad">touched {one.touches} times</span>' if one.touches else "",
        )
        for one in pairs[:MOST_PAIRS]
    ]
    heads = ("pair", "distance", "at", "modes", "")
    return "<h2>Closest approaches</h2>" + html_table(heads, rows) + _more(pairs, MOST_PAIRS)


def vessels(series: Series) -> str:
    """How every boat passed every vessel that is not of the fleet."""
    found = passings(series.tracks, series.traffic)
    if not found:
        return ""
    rows = [
        (
            f"{escape(one.boat)} - {escape(one.vessel)}",
            f"{one.hull_m:.1f} m",
            f"{one.at_s:.1f} s",
            escape(mode_at(series, one.boat, one.at_s)),
            f"{one.domain:.2f}",
            f"{one.domain_at_s:.1f} s",
            f'<span class="bad">touched {one.contacts} times</span>'
            if one.contacts
            else '<span class="bad">inside</span>'
            if one.domain < 1.0
            else "",
        )
        for one in found[:MOST_PAIRS]
    ]
    heads = ("boat - vessel", "between hulls", "at", "mode", "share of the distance kept", "at", "")
    return "<h2>Other vessels</h2>" + html_table(heads, rows) + _more(found, MOST_PAIRS)


def decided(series: Series) -> str:
    """What each boat decided, when, why, until when, and what came of it."""
    found = decisions(series)
    if not found:
        return "<h2>Decisions</h2><p>none</p>"
    rows = [
        (
            f"{one.at_s:.1f} s",
            f"{one.until_s:.1f} s" if one.until_s is not None else "the end",
            _named(series, one.boat),
            escape(one.why or one.text),
            escape(one.met),
            escape(one.what),
            _came_of_it(one),
        )
        for one in found[:MOST_DECISIONS]
    ]
    heads = ("at", "until", "boat", "why", "how it was met", "decided", "what came of it")
    return "<h2>Decisions</h2>" + html_table(heads, rows) + _more(found, MOST_DECISIONS)


def _came_of_it(one: Decision) -> str:
    """Turn, speed asked for, least distance: from the tracks."""
    parts = []
    if one.turned_deg is not None:
        port, starboard = one.turned_deg
        turns = [f"{starboard:.0f} deg to starboard"] if starboard >= TURN_DEG else []
        turns += [f"{-port:.0f} deg to port"] if port <= -TURN_DEG else []
        parts.append("turned up to " + " and ".join(turns) if turns else "held its course")
    if one.asked_mps is not None:
        low, high = one.asked_mps
        parts.append(f"{low:.2f} m/s" if high - low < 0.005 else f"{low:.2f} to {high:.2f} m/s")
    if one.nearest_m is not None:
        parts.append(f"{escape(one.other)} no nearer than {one.nearest_m:.2f} m, at {one.nearest_s:.1f} s")
    return ", ".join(parts)


def events(series: Series) -> str:
    """Everything that was told, and every command with its answers."""
    lines = [(one.stamp_ns, one.boat, one.kind, one.text, ", ".join(one.reasons)) for one in series.events]
    for one in series.commands:
        change = f"{one.old} -> {one.new}" if one.old or one.new else ""
        acks = "; ".join(f"{boat}: {text}" for boat, text in sorted(one.acks.items()))
        lines.append((one.stamp_ns, "", "command", f"{one.command} {change}".strip(), acks))
    if not lines:
        return ""
    rows = [
        (f"{series.seconds(stamp):.1f} s", _named(series, boat), escape(kind), escape(text), escape(why))
        for stamp, boat, kind, text, why in sorted(lines)[:MOST_EVENTS]
    ]
    table = html_table(("at", "boat", "kind", "what", "why, answers"), rows)
    return "<h2>Events and commands</h2>" + table + _more(lines, MOST_EVENTS)


def _more(all_of: Sequence[object], most: int) -> str:
    return f'<p class="means">and {len(all_of) - most} more</p>' if len(all_of) > most else ""
