"""A sweep in the terminal: the table of its points, checks, failing cases; and two sweeps side by side."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fleet.cli import say

if TYPE_CHECKING:
    from fleet.sim.sweep.store import Store

NAMED = 10  # failing cases; the others are in summary.json
HEADS = ("", "cases", "collisions", "standstills", "arrived", "inside R", "least", "median", "delay", "95 %", "cross-track", "formation", "off path", "off place")  # fmt: skip  # noqa: E501
UNITS = ("", "", "", "", "boats", "cases", "m", "m", "s", "s", "rms m", "rms m", "share", "share")
KEYS = ("cases", "collisions", "standstills", "arrived", "inside_radius", "min_separation_m", "separation_median_m",
        "delay_median_s", "delay_p95_s", "cross_track_rms_m", "formation_rms_m", "off_path", "off_place")  # fmt: skip
MAY_LACK = ("off_path", "off_place")  # columns only where there is something to show

SHIP_HEADS = ("", "cases", "contacts", "domain", "0.8 of it", "side", "in time", "rules", "decisions", "reversals", "again", "delay", "95 %", "boats")  # fmt: skip  # noqa: E501
SHIP_UNITS = ("", "", "", "kept", "kept", "right", "share", "right", "mean", "share", "share", "s", "s", "m")
SHIP_KEYS = ("cases", "contacts", "domain_kept", "domain_kept_08", "side_right", "in_time", "rule_right", "decisions",
             "reversals", "retriggers", "delay_median_s", "delay_p95_s", "min_separation_m")  # fmt: skip
"""Of families with foreign vessels."""


def print_sweep(store: Store, found: dict[str, Any], picture: bool) -> None:
    """The table, the checks, the failing cases and where everything is."""
    say.out(say.paint(f"{found['title']}", "bold"))
    say.out(f"method {found['method']}, {found['boats']} boats, seed {found['seed']}\n")
    for line in table_of(found["points"], found):
        say.out(line)
    judged = [(point["label"], one) for point in found["points"] for one in point["checks"]]
    for label, one in judged:
        if not one["ok"] or len(found["points"]) == 1:
            line = f"  {label}: {one['text']}" if label else f"  {one['text']}"
            say.out(line if one["ok"] else say.paint(line, "red"))
    if judged:
        say.out()
    names = found["failed_seeds"]
    if names:
        say.out(f"failing: {say.count(len(names), 'case')}")
        for name in names[:NAMED]:
            say.out(f"  fleet sim --case {shlex.quote(f'{store.folder}:{name}')}")
        if len(names) > NAMED:
            say.out(f"  and {len(names) - NAMED} more: see {store.summary_file}")
        say.out()
    verdict = "no checks in the family" if not judged else f"passed: {say.count(len(judged), 'check')} hold"
    if found["passed"]:
        say.out(say.paint(verdict, "green"))
    else:
        missing = [] if found["complete"] else ["parts are missing"]
        failed = dict.fromkeys(one["name"] for point in found["points"] for one in point["checks"] if not one["ok"])
        say.out(say.paint(f"FAILED: {', '.join([*missing, *failed])}", "red"))
    speed = found["boat_ticks_per_s"]
    if speed is not None:
        say.out(f"{found['wall_s']:.1f} s, {speed:,.0f} boat ticks a second".replace(",", " "))
    places = [("sweep", str(store.folder)), *([("report", str(store.report_file))] if picture else [])]
    for line in say.aligned(places):
        say.out(line)


def table_of(points: Sequence[dict[str, Any]], together: dict[str, Any] | None) -> list[str]:
    """A row a point, and one for all of them together where they are several."""
    foreign = any("contacts" in point for point in points)
    heads, units, keys = (SHIP_HEADS, SHIP_UNITS, SHIP_KEYS) if foreign else (HEADS, UNITS, KEYS)
    lacking = {key for key in MAY_LACK if all(point.get(key) is None for point in points)}
    columns = [column for column in zip(heads[1:], units[1:], keys, strict=True) if column[2] not in lacking]
    rows = [[point["label"], *(_shown(point.get(key)) for _, _, key in columns)] for point in points]
    if together is not None and len(points) > 1:
        rows.append(["together", *(_shown(together.get(key)) for _, _, key in columns)])
    named = [[first, *(column[i] for column in columns)] for i, first in enumerate((heads[0], units[0]))]
    return say.aligned([*named, *rows], right=range(1, len(columns) + 1), indent="  ")


def _shown(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.2f}" if isinstance(value, float) else str(value)


def compared(found: dict[str, Any]) -> list[str]:
    """Both in words."""
    lines = say.aligned(
        [
            (w, one["folder"], f"method {one['method']}", f"{one['cases']} of {one['of']} cases, seed {one['seed']}")
            for w, one in (("A", found["a"]), ("B", found["b"]))
        ]
    )
    if found["a"]["laws"] != found["b"]["laws"]:
        lines.append("sailed by different code: what changed may be the laws")
    rows = []
    many = len(found["points"]) > 1
    for point in [*found["points"], *([{"label": "together", **found["together"]}] if many else [])]:
        for word in ("a", "b"):
            if point[word] is not None:
                rows.append({"label": f"{point['label']} {word.upper()}".strip(), **point[word]})
    lines += ["", *table_of(rows, None), ""]
    if not found["comparable"]:
        return [*lines, f"not compared case by case: {'; '.join(found['why'])}"]
    return [*lines, *_pairs(found)]


def _pairs(found: dict[str, Any]) -> list[str]:
    """What became of the cases that both have."""
    pair = found["together"]["paired"]
    lines = [f"{pair['cases']} cases in both"]
    rows = [
        (
            what,
            f"{pair[what]['both']} in both",
            f"{pair[what]['only_a']} only in A",
            f"{pair[what]['only_b']} only in B",
        )
        for what in ("collisions", "standstills")
    ]
    lines += say.aligned(rows, indent="  ")
    changes = []
    for what, unit, of, less, more in (
        ("separation", "m", "cases", "nearer", "farther"),
        ("delay", "s", "boats", "sooner", "later"),
    ):
        change = pair[what]
        median = "-" if change["median"] is None else f"{change['median']:+.2f} {unit}"
        counts = f"{change['less']} {less} in B, {change['equal']} equal, {change['more']} {more}"
        changes.append((f"{what}, B less A", f"median {median}", f"{change['number']} {of}: {counts}"))
    lines += say.aligned(changes, indent="  ")
    for what, word, folder in (("worse", "fail only in B", "b"), ("better", "fail only in A", "a")):
        names = found[what]
        if names:
            lines.append(f"{say.count(len(names), 'case')} {word}:")
            lines += [
                f"  fleet sim --case {shlex.quote(found[folder]['folder'] + ':' + name)}" for name in names[:NAMED]
            ]
            lines += [f"  and {len(names) - NAMED} more: see --json"] if len(names) > NAMED else []
    return lines
