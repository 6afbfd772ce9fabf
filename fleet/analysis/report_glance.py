"""The top of a run's page: what sailed, and the worst numbers with who and when."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape
from typing import Any

import numpy as np

from fleet.analysis.canvas import look
from fleet.analysis.html import cards, shown
from fleet.analysis.metrics import Summary, launch_s
from fleet.analysis.separation import approaches
from fleet.analysis.series import KEEPS_FORMATION, Series
from fleet.analysis.traffic import passings

SHORT_S = 1.0  # a run that ends so much before its mission was cut short
Card = tuple[str, str, str, bool | None]


def what_sailed(series: Series, tree: dict[str, Any]) -> str:
    """Boats in their colours, formation, how they keep clear, other vessels, duration: one line."""
    boats = " ".join(
        f'<span class="key" style="background:{look(series, name)["color"]}"></span>{escape(name)}'
        for name in series.boats
    )
    parts = [boats] if boats else []
    formation, keeping = tree.get("formation", {}), tree.get("keeping_clear", {})
    if isinstance(formation, dict) and "spacing_m" in formation:
        parts.append(
            f"{escape(str(formation.get('pattern', 'column')))}, spacing {escape(str(formation['spacing_m']))} m, "
            f"cruise {escape(str(formation.get('cruise_mps', '?')))} m/s"
        )
    if isinstance(keeping, dict) and tree:
        parts.append(
            f"keeping clear: {escape(str(keeping.get('method', 'scoring')))}, "
            f"R = {escape(str(keeping.get('radius_m', 6.0)))} m"
        )
    if series.traffic:
        parts.append("other vessels: " + escape(", ".join(sorted(series.traffic))))
    parts.append(f"{series.end_s:.0f} s")
    more = [f"{escape(key)} {escape(series.header[key])}" for key in ("seed", "way", "version") if key in series.header]
    return f'<p class="run">{"; ".join([*parts, *more])}</p>'


def notes(series: Series, tree: dict[str, Any]) -> str:
    """What a reader must know before the figures: damage, a run cut short, boats without a position."""
    lines = []
    if series.unreadable:
        lines.append(f"{series.unreadable} messages of the recording do not decode and are left out.")
    lasts = tree.get("duration_s")
    if isinstance(lasts, int | float) and series.tracks and series.end_s < lasts - SHORT_S:
        lines.append(f"The run ended after {series.end_s:.1f} s; its mission lasts {lasts:g} s.")
    if not series.tracks:
        lines.append("Nothing was recorded of any boat.")
    blind = [name for name, track in sorted(series.tracks.items()) if not len(track.t)]
    if blind:
        lines.append(f"No position is known of {escape(', '.join(blind))}.")
    return "".join(f'<p class="note">{line}</p>' for line in lines)


def glance(series: Series, summary: Summary) -> str:
    """The main figures, each with who and when."""
    judged = {one.name: one.ok for one in summary.checks}
    return cards(_cards(series, summary, judged))


def _cards(series: Series, summary: Summary, judged: dict[str, bool]) -> Iterator[Card]:
    if summary.checks:
        failed = [one.name for one in summary.checks if not one.ok]
        held = len(summary.checks) - len(failed)
        words = f"not: {escape(', '.join(failed))}" if failed else "all hold"
        yield "checks", f"{held} of {len(summary.checks)}", words, not failed
    pairs = approaches(series.tracks)
    if pairs:
        who = f"{escape(pairs[0].first)} - {escape(pairs[0].second)} at {pairs[0].at_s:.1f} s"
        yield "closest approach", shown(summary.min_separation_m, "m"), who, judged.get("min_separation_m")
    if summary.collisions is not None:
        yield "collisions", shown(summary.collisions), "hulls that touched", summary.collisions == 0
    met = passings(series.tracks, series.traffic)
    if met:
        who = f"{escape(met[0].boat)} - {escape(met[0].vessel)} at {met[0].at_s:.1f} s, between hulls"
        yield "nearest other vessel", shown(summary.min_traffic_m, "m"), who, not summary.contacts
        deep = min(met, key=lambda one: one.domain)
        who = f"of what is kept; {escape(deep.boat)} - {escape(deep.vessel)} at {deep.domain_at_s:.1f} s"
        yield "deepest in a domain", f"{deep.domain:.2f}", who, deep.domain >= 1.0
    for name, title in (("e_s", "largest along-path error"), ("y_e", "largest cross-track error")):
        peak = largest(series, name)
        if peak is not None:
            yield title, shown(peak[0], "m"), f"{escape(peak[1])} at {peak[2]:.1f} s", None
    if summary.speed_min_mps is not None:
        ok = [judged[name] for name in ("speed_min_mps", "speed_max_mps") if name in judged]
        speeds = f"{summary.speed_min_mps:.2f} to {shown(summary.speed_max_mps, 'm/s')}"
        yield "speeds after the run-up", speeds, "", all(ok) if ok else None
    if summary.reformed_s is not None:
        yield "in formation after", shown(summary.reformed_s, "s"), "of the last change", judged.get("reformed_s")
    if summary.ticks is not None:
        late = f"{shown(summary.ticks_late)} late ticks, {shown(summary.messages_lost)} messages lost"
        yield "ticks", shown(summary.ticks), late, None


def largest(series: Series, name: str) -> tuple[float, str, float] | None:
    """Largest magnitude of an error of boats that follow or avoid, from launch: value, boat, when [s]."""
    begin = launch_s(series.said)
    found = []
    for boat, one in series.said.items():
        values = np.abs(getattr(one, name))
        values = np.where(one.within(*KEEPS_FORMATION) & (one.t >= begin), values, np.nan)
        if np.isfinite(values).any():
            k = int(np.nanargmax(values))
            found.append((float(values[k]), boat, float(one.t[k])))
    return max(found, default=None)
