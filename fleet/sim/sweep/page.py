"""One page a sweep, in one file: opens in any browser without scripts, network or fonts of its own."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from msgspec import Struct

from fleet.analysis.canvas import svg, unique_ids
from fleet.analysis.html import STYLE, cards, figure, html_table, shown
from fleet.analysis.html import verdict as ground
from fleet.errors import UsageError
from fleet.sim.batch import Results
from fleet.sim.sweep import pictures, ships_alone, ships_pictures, ships_results
from fleet.sim.sweep.alone import reasons, sail_case
from fleet.sim.sweep.checks import CHECKS
from fleet.sim.sweep.family import case_name
from fleet.sim.sweep.ships_results import ShipResults
from fleet.sim.sweep.store import Store, write_text
from fleet.sim.sweep.table import MEANINGS, Figures

MOST_NAMED, MOST_DRAWN = 10, 2
COLUMNS = {
    "cases": "cases",
    "collisions": "collisions",
    "standstills": "standstills",
    "arrived": "boats arrived",
    "inside_radius": "inside R",
    "min_separation_m": "least sep. [m]",
    "separation_median_m": "median sep. [m]",
    "delay_median_s": "delay median [s]",
    "delay_p95_s": "delay 95 % [s]",
    "cross_track_rms_m": "cross-track rms [m]",
    "formation_rms_m": "formation rms [m]",
}
"""Columns of the table of points."""
_MORE = ".wide td:first-child { white-space: nowrap; }"


class Chosen(Struct, frozen=True):
    """A case that is drawn."""

    point: int
    case: int
    why: str


def write_page(store: Store, results: Sequence[Results | None], summary: Figures) -> None:
    """Write `report.html` into a sweep's folder; the cases that it draws are sailed again.

    Raises:
        RecordingError: it cannot be written
    """
    write_text(store.report_file, page(store, results, summary))


def page(store: Store, results: Sequence[Results | None], summary: Figures) -> str:
    """The page as HTML."""
    sweep = store.sweep
    passed = summary["passed"]
    verdict = "passed" if passed else "failed" if summary["complete"] else "not complete"
    if passed and not store.family.checks:
        verdict = "no checks"
    title = escape(store.family.title)
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{title}</title><style>{STYLE}{_MORE}</style></head><body>",
        f"<h1>{title} {ground(verdict, None if verdict in ('no checks', 'not complete') else passed)}</h1>",
        f'<p class="run">{escape(store.folder.resolve().name)}: {len(sweep.points)} x {sweep.cases} cases, '
        f"seed {sweep.seed}, method {escape(str(summary['method']))}, fleet {escape(sweep.version)}</p>",
        _lost(summary),
        _glance(store, results, summary),
        _checks(summary),
        _drawn(store, results, summary),
        _points(summary),
        _failed(store, summary),
        _figures(summary),
        f"<h2>What was sailed</h2><p><code>{escape(sweep.command)}</code>; laws <code>{sweep.laws}</code></p>",
        f"<pre>{escape(sweep.text)}</pre></body></html>\n",
    ]
    return "\n".join(part for part in parts if part)


def _lost(summary: Figures) -> str:
    lines = [escape(one) for one in summary["lost"]]
    if not summary["complete"]:
        lines.insert(0, "Parts are missing: the figures are of the others.")
    return f'<p class="note">{"<br>".join(lines)}</p>' if lines else ""


def _glance(store: Store, results: Sequence[Results | None], summary: Figures) -> str:
    """How many went wrong, and the worst numbers with the case they are of."""
    there = [(point, one) for point, one in enumerate(results) if one is not None]
    if not there:
        return ""
    if store.family.foreign:
        return cards(ships_alone.glance(summary))
    point, worst = min(there, key=lambda one: float(one[1].least_m.min()))
    case = case_name(store.family, store.sweep.seed, point, int(worst.case[worst.least_m.argmin()]))
    judged = [one for tables in summary["points"] for one in tables["checks"]]
    held = sum(bool(one["ok"]) for one in judged)
    collisions, stuck, arrived = (summary[name] for name in ("collisions", "standstills", "arrived"))
    content: list[tuple[str, str, str, bool | None]] = [
        ("cases", shown(summary["cases"]), f"of {escape(str(summary['boats']))} boats", None),
        ("collisions", shown(collisions), "cases in which hulls met", collisions == 0),
        ("standstills", shown(stuck), "cases in which a boat made less than 6 m good in 60 s", stuck == 0),
        ("least separation", shown(summary["min_separation_m"], "m"), f"case {escape(case)}", None),
    ]
    if summary["boats_with_goal"]:
        content += [
            ("delay", shown(summary["delay_p95_s"], "s"), "95 % of the boats that arrived are below", None),
            ("arrived", shown(arrived), f"of {shown(summary['boats_with_goal'])} boats", None),
        ]
    if judged:
        content.insert(0, ("checks", f"{held} of {len(judged)}", "hold, all points together", held == len(judged)))
    return cards(content)


def _drawn(store: Store, results: Sequence[Results | None], summary: Figures) -> str:
    """The pictures, or a line that says why there are none."""
    there: list[Any] = [one for one in results if one is not None]
    if not there:
        return ""
    try:
        if store.family.foreign:
            whole = _picture(ships_pictures.distributions(there), "d", "What is left of the domains, and delays")
        else:
            whole = _picture(pictures.distributions(there), "d", "Least separations and delays of the boats")
    except UsageError as error:
        return f'<p class="note">{escape(str(error))}</p>'
    parts = ["<h2>Distributions</h2>", figure(whole, "")]
    grid = pictures.maps([store.family.points[one["point"]] for one in summary["points"]], summary["points"])
    if grid is not None:
        parts += ["<h2>Over the grid</h2>", figure(_picture(grid, "g", "Main figures over the points of the grid"), "")]
    parts.append("<h2>Cases</h2>")
    for number, chosen in enumerate(chosen_cases(results)):
        name = case_name(store.family, store.sweep.seed, chosen.point, chosen.case)
        drawn = _picture(_tracks(store, chosen), f"c{number}", f"Tracks and separations of case {name}: {chosen.why}")
        parts.append(figure(drawn, f"<code>{escape(_alone(store, name))}</code>"))
    return "\n".join(parts)


def _picture(drawn: Any, prefix: str, said: str) -> str:
    """A figure as SVG whose names are its own in the page."""
    return unique_ids(svg(drawn, said), prefix)


def _alone(store: Store, name: str) -> str:
    """The command that sails one case alone."""
    return f"fleet sim --case {store.folder}:{name}"


def _tracks(store: Store, chosen: Chosen) -> Any:
    family, seed = store.family, store.sweep.seed
    if family.foreign:
        return ships_alone.drawn(family, seed, chosen.point, chosen.case, chosen.why)
    sailed = sail_case(family, seed, chosen.point, chosen.case, floats=None)
    point = family.points[chosen.point]
    label = f", {point.label}" if point.label else ""
    why = "; ".join(reasons(sailed)) or chosen.why
    return pictures.tracks(sailed, f"{case_name(family, seed, chosen.point, chosen.case)}{label}: {why}")


def chosen_cases(results: Sequence[Results | None]) -> list[Chosen]:
    """The case of the least separation, and the first ones with a standstill and with a collision."""
    there: list[tuple[int, Any]] = [(point, one) for point, one in enumerate(results) if one is not None]
    if isinstance(there[0][1], ShipResults):
        return [Chosen(*one) for one in ships_alone.chosen_cases(there)]
    point, worst = min(there, key=lambda one: float(one[1].least_m.min()))
    chosen = {(point, int(worst.case[worst.least_m.argmin()])): "least separation"}
    for what, name in (("standstill", "standstill"), ("collision", "collided")):
        failed = [(number, int(case)) for number, one in there for case in one.case[getattr(one, name) > 0.0]]
        for key in [one for one in failed if one not in chosen][:MOST_DRAWN]:
            chosen[key] = what
    return [Chosen(number, case, why) for (number, case), why in chosen.items()]


def _checks(summary: Figures) -> str:
    """A row for each check; with a grid, at how many points it holds and where it is worst."""
    points = summary["points"]
    if not points or not points[0]["checks"]:
        return ""
    rows = []
    for i, one in enumerate(points[0]["checks"]):
        name, unit = one["name"], CHECKS[one["name"]].unit
        there = [(point["checks"][i]["value"], point["label"]) for point in points]
        known = [pair for pair in there if pair[0] is not None]
        worst = (max if CHECKS[name].at_most else min)(known, key=lambda pair: float(pair[0]), default=(None, ""))
        held = sum(point["checks"][i]["ok"] for point in points)
        said = "ok" if len(points) == 1 else f"holds at {held} of {len(points)} points"
        if held < len(points):
            said = f'<span class="bad">{"not ok" if len(points) == 1 else said}</span>'
        side = "at most" if CHECKS[name].at_most else "at least"
        rows.append((escape(name), shown(worst[0], unit), f"{side} {one['limit']:g} {unit}", said, escape(worst[1])))
    many = len(points) > 1
    return "<h2>Checks</h2>" + html_table(
        ("check", "worst" if many else "value", "limit", "", "worst at" if many else ""), rows
    )


def _points(summary: Figures) -> str:
    """A row for each point of the grid."""
    if len(summary["points"]) < 2:
        return ""
    points = summary["points"]
    columns = ships_results.COLUMNS if "contacts" in points[0] else COLUMNS
    used = [name for name in columns if any(point[name] is not None for point in points)]
    rows = [[escape(point["label"]), *(shown(point[name]) for name in used)] for point in points]
    table = html_table(("point", *(escape(columns[name]) for name in used)), rows)
    return f'<h2>Points of the grid</h2><div class="wide">{table}</div>'


def _figures(summary: Figures) -> str:
    rows = [
        (name, shown(summary[name], unit), f'<span class="means">{escape(meaning)}</span>')
        for name, (meaning, unit) in (ships_results.MEANINGS if "contacts" in summary else MEANINGS).items()
        if summary.get(name) is not None
    ]
    speed = summary["boat_ticks_per_s"]
    if speed is not None and np.isfinite(speed):
        rows.append(("boat_ticks_per_s", shown(round(speed)), '<span class="means">decisions in a second</span>'))
        rows.append(("wall_s", shown(summary["wall_s"], "s"), '<span class="means">it took</span>'))
    return "<h2>Figures</h2>" + html_table(("figure", "value", "what it means"), rows)


def _failed(store: Store, summary: Figures) -> str:
    names = summary["failed_seeds"]
    if not names:
        return "<h2>Failing cases</h2><p>none</p>"
    lines = "\n".join(_alone(store, name) for name in names[:MOST_NAMED])
    more = f"\nand {len(names) - MOST_NAMED} more: see summary.json" if len(names) > MOST_NAMED else ""
    return f"<h2>Failing cases: {len(names)}</h2><pre>{escape(lines + more)}</pre>"
