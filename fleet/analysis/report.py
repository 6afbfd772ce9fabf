"""One page a run, in one file: opens in any browser without scripts, network or fonts of its own."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

import numpy as np

from fleet.analysis.figures import draw
from fleet.analysis.metrics import FIGURES, Summary, counted, summarise
from fleet.analysis.separation import approaches
from fleet.analysis.series import Series, load
from fleet.errors import UsageError

MOST_EVENTS, MOST_PAIRS = 500, 50

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; margin: 2rem auto; max-width: 70rem; padding: 0 1rem; }
h1 { margin-bottom: 0; } h2 { margin-top: 2.2rem; font-size: 1.15rem; } .run { color: #666; margin-top: .2rem; }
table { border-collapse: collapse; } th, td { text-align: left; padding: .25rem .9rem .25rem 0; vertical-align: top; }
thead th { border-bottom: 1px solid #999; } td.n { text-align: right; font-variant-numeric: tabular-nums; }
tbody tr:nth-child(even) { background: #f5f5f5; } .ok { color: #00664b; } .bad { color: #b00020; font-weight: 600; }
.verdict { display: inline-block; padding: .15rem .7rem; border-radius: .3rem; color: #fff; background: #b00020; }
.verdict.ok { background: #00664b; color: #fff; } svg { width: 100%; height: auto; } .means { color: #666; }
.note { background: #fff4d6; padding: .5rem .8rem; }
"""


def write_report(folder: Path | str, out: Path | str | None = None, summary: Summary | None = None) -> Path:
    """Write the page of the run in a folder, by default `report.html` in it.

    Args:
        folder: a run folder
        out: the page
        summary: its figures; otherwise computed

    Raises:
        RecordingError: there is no run to read
    """
    series = load(folder)
    figures = summary if summary is not None else summarise(folder)
    target = Path(out) if out is not None else Path(folder) / "report.html"
    draft = target.with_name(target.name + ".part")
    draft.write_text(page(series, figures, _picture(Path(folder))), encoding="utf-8")
    draft.replace(target)
    return target


def _picture(folder: Path) -> str:
    """The picture as SVG to stand in the page, or a line that says why there is none."""
    with tempfile.TemporaryDirectory() as place:
        try:
            drawn = draw(folder, Path(place) / "run.svg").read_text(encoding="utf-8")
        except UsageError as error:
            return f'<p class="note">{escape(str(error))}</p>'
    drawn = re.sub(r"<metadata>.*?</metadata>", "", drawn[drawn.index("<svg") :], flags=re.DOTALL)
    return re.sub(r' xmlns:xlink="[^"]*"', "", drawn.replace("xlink:href", "href"))


def page(series: Series, summary: Summary, picture: str) -> str:
    """The page as HTML."""
    title = escape(summary.mission)
    verdict = "passed" if summary.passed else "failed"
    if not summary.checks:
        verdict = "no checks"
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{title}</title><style>{_STYLE}</style></head><body>",
        f'<h1>{title} <span class="verdict{" ok" if summary.passed else ""}">{verdict}</span></h1>',
        f'<p class="run">{escape(Path(summary.run).name)}</p>',
        _damage(series),
        picture,
        _checks(summary),
        _figures(summary),
        _boats(series),
        _approaches(series),
        _events(series),
        "</body></html>\n",
    ]
    return "\n".join(part for part in parts if part)


def _damage(series: Series) -> str:
    if not series.unreadable:
        return ""
    return f'<p class="note">{series.unreadable} messages of the recording do not decode and are left out.</p>'


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of cells that are HTML already; numbers stand to the right."""
    head = "".join(f"<th>{one}</th>" for one in heads)
    body = "".join("<tr>" + "".join(_cell(one) for one in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _cell(content: str) -> str:
    return f'<td class="n">{content}</td>' if re.fullmatch(r"[-+]?[\d.]+( \S+)?", content) else f"<td>{content}</td>"


def shown(value: float | None, unit: str = "") -> str:
    """A figure with its unit, to two places; `none` where it does not exist."""
    if value is None or not np.isfinite(value):
        return "none"
    number = f"{value:.2f}" if isinstance(value, float) and value != int(value) else f"{value:.0f}"
    return f"{number} {unit}".strip()


def _checks(summary: Summary) -> str:
    if not summary.checks:
        return ""
    rows = []
    for one in summary.checks:
        unit = FIGURES.get(one.name, ("", ""))[1]
        said = '<span class="ok">ok</span>' if one.ok else '<span class="bad">not ok</span>'
        rows.append((escape(one.name), shown(one.value, unit), shown(one.limit, unit), said))
    return "<h2>Checks</h2>" + _table(("check", "value", "limit", ""), rows)


def _figures(summary: Summary) -> str:
    rows = [
        (name, shown(getattr(summary, name), unit), f'<span class="means">{escape(meaning)}</span>')
        for name, (meaning, unit) in FIGURES.items()
    ]
    return "<h2>Figures</h2>" + _table(("figure", "value", "what it means"), rows)


def _boats(series: Series) -> str:
    rows = []
    for name in series.boats:
        track, one = series.tracks[name], series.said.get(name)
        far = float(np.sum(np.hypot(np.diff(track.x), np.diff(track.y)))) if len(track.t) else 0.0
        row = [escape(name), shown(far, "m"), shown(_mean(track.speed), "m/s")]
        if one is None:
            row += ["none"] * 4
        else:
            step = float(np.median(np.diff(one.t))) if len(one.t) > 1 else 0.0
            avoided = float(np.count_nonzero(one.avoiding)) * step
            row += [
                escape(one.mode[-1]),
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
    return "<h2>Boats</h2>" + _table((*heads, *counters), rows)


def _mean(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else None


def _last(values: np.ndarray) -> float | None:
    return float(values[-1]) if len(values) else None


def _largest(values: np.ndarray) -> float | None:
    known = np.abs(values[np.isfinite(values)])
    return float(known.max()) if len(known) else None


def _approaches(series: Series) -> str:
    pairs = approaches(series.tracks)
    if not pairs:
        return ""
    rows = [
        (
            f"{escape(one.first)} - {escape(one.second)}",
            f"{one.distance_m:.2f} m",
            f"{one.at_s:.1f} s",
            f'<span class="bad">touched {one.touches} times</span>' if one.touches else "",
        )
        for one in pairs[:MOST_PAIRS]
    ]
    return "<h2>Closest approaches</h2>" + _table(("pair", "distance", "at", ""), rows) + _more(pairs, MOST_PAIRS)


def _events(series: Series) -> str:
    lines = [(one.stamp_ns, one.boat, one.kind, one.text, ", ".join(one.reasons)) for one in series.events]
    for one in series.commands:
        change = f"{one.old} -> {one.new}" if one.old or one.new else ""
        acks = "; ".join(f"{boat}: {text}" for boat, text in sorted(one.acks.items()))
        lines.append((one.stamp_ns, "", "command", f"{one.command} {change}".strip(), acks))
    if not lines:
        return ""
    rows = [
        (f"{series.seconds(stamp):.1f} s", escape(boat), escape(kind), escape(text), escape(why))
        for stamp, boat, kind, text, why in sorted(lines)[:MOST_EVENTS]
    ]
    return "<h2>Events</h2>" + _table(("at", "boat", "kind", "what", "why, answers"), rows) + _more(lines, MOST_EVENTS)


def _more(all_of: Sequence[object], most: int) -> str:
    return f'<p class="means">and {len(all_of) - most} more</p>' if len(all_of) > most else ""
