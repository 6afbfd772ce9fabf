"""One page a run, in one file: opens in any browser without scripts, network or fonts of its own."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

from fleet.analysis import report_tables as tables
from fleet.analysis.canvas import svg, unique_ids
from fleet.analysis.chart import chart_of
from fleet.analysis.figures import map_figure, time_figure
from fleet.analysis.figures_time import panels
from fleet.analysis.html import STYLE, figure, verdict
from fleet.analysis.metrics import Summary, mission_tree, summarise
from fleet.analysis.report_glance import glance, notes, what_sailed
from fleet.analysis.separation import approaches
from fleet.analysis.series import Series, load
from fleet.errors import UsageError

PANELS = {
    "separations": "separations of centres",
    "vessels": "distances to other vessels",
    "speeds": "speeds over ground and asked for",
    "along": "along-path errors",
    "cross": "cross-track errors",
    "modes": "modes",
}


def write_report(
    folder: Path | str, out: Path | str | None = None, summary: Summary | None = None, series: Series | None = None
) -> Path:
    """Write the page of the run in a folder, by default `report.html` in it.

    Args:
        folder: a run folder
        out: the page
        summary: its figures; otherwise computed
        series: the run, if it was loaded already

    Raises:
        RecordingError: there is no run to read
    """
    series = load(folder) if series is None else series
    shown = summary if summary is not None else summarise(folder, series=series)
    tree = mission_tree(Path(folder))
    target = Path(out) if out is not None else Path(folder) / "report.html"
    draft = target.with_name(target.name + ".part")
    draft.write_text(page(series, shown, pictures(series, tree), tree), encoding="utf-8")
    draft.replace(target)
    return target


def pictures(series: Series, tree: dict[str, Any]) -> str:
    """Map and time series as SVG to stand in the page, or a line that says why there are none."""
    chart = chart_of(tree)
    try:
        drawn = svg(map_figure(series, chart), _said_of_map(series))
        over_time = unique_ids(svg(time_figure(series, chart), _said_of_times(series)), "t")
    except UsageError as error:
        return f'<p class="note">{escape(str(error))}</p>'
    marks = "Hulls are drawn at the times written, larger than they are where too small to see; circles are starts."
    times = "Dotted lines: changes of the formation, and troubles. Times in the tables count from the same moment."
    return figure(drawn, marks) + figure(over_time, times)


def _said_of_map(series: Series) -> str:
    pairs = approaches(series.tracks)
    nearest = ""
    if pairs:
        one = pairs[0]
        nearest = f" Closest approach: {one.first} and {one.second}, {one.distance_m:.2f} m at {one.at_s:.1f} s."
    vessels = f", other vessels {', '.join(sorted(series.traffic))}" if series.traffic else ""
    return f"Map of the tracks of {', '.join(sorted(series.tracks)) or 'no boat'}{vessels}.{nearest}"


def _said_of_times(series: Series) -> str:
    return "Time series: " + ", ".join(PANELS[name] for name, _ in panels(series)) + ". The tables give their extremes."


def page(series: Series, summary: Summary, drawn: str, tree: dict[str, Any] | None = None) -> str:
    """The page as HTML.

    Args:
        series: the run
        summary: its figures
        drawn: its pictures as HTML
        tree: its mission as TOML
    """
    tree = tree or {}
    title = escape(summary.mission)
    words = ("passed" if summary.passed else "failed") if summary.checks else "no checks"
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{title}</title><style>{STYLE}</style></head><body>",
        f"<h1>{title} {verdict(words, summary.passed if summary.checks else None)}</h1>",
        f'<p class="run">{escape(Path(summary.run).name)}</p>',
        what_sailed(series, tree),
        notes(series, tree),
        glance(series, summary),
        drawn,
        tables.checks(summary),
        tables.closest(series),
        tables.vessels(series),
        tables.decided(series),
        tables.boats(series),
        tables.figures(summary),
        tables.events(series),
        _mission(series),
        "</body></html>\n",
    ]
    return "\n".join(part for part in parts if part)


def _mission(series: Series) -> str:
    try:
        text = (series.folder / "mission.toml").read_text(encoding="utf-8")
    except (OSError, ValueError):
        return ""
    return f"<h2>Mission</h2><pre>{escape(text)}</pre>"
