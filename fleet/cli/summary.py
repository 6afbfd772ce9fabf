"""The summary of a run in the terminal: the figures of `summary.json`, with their units, and the checks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fleet.cli import say

if TYPE_CHECKING:
    from fleet.analysis.metrics import Summary


def print_summary(summary: Summary) -> None:
    """Print figures, checks and the verdict."""
    from fleet.analysis.html import shown
    from fleet.analysis.metrics import FIGURES
    from fleet.mission.checks import CHECKS

    say.out(say.paint(summary.mission, "bold"))
    say.out(f"boats: {', '.join(summary.boats)}")
    say.out()
    rows = [(name, *_split(shown(getattr(summary, name), unit))) for name, (_, unit) in FIGURES.items()]
    for line in say.aligned(rows, right=(1,), indent="  "):
        say.out(line)
    if not summary.checks:
        say.out("\nno checks in the mission")
        return
    say.out()
    table = []
    for one in summary.checks:
        unit = FIGURES.get(one.name, ("", ""))[1]
        name = f"{one.name} ({one.by})" if one.by else one.name
        limit = f"{CHECKS[one.name].direction if one.name in CHECKS else ''} {one.limit:g} {unit}".strip()
        table.append((name, *_split(shown(one.value, unit)), limit, "ok" if one.ok else "NOT OK"))
    for line, one in zip(say.aligned(table, right=(1,), indent="  "), summary.checks, strict=True):
        say.out(line if one.ok else say.paint(line, "red"))
    say.out()
    failed = [one.name for one in summary.checks if not one.ok]
    if failed:
        say.out(say.paint(f"FAILED: {', '.join(failed)}", "red"))
    else:
        say.out(say.paint(f"passed: {say.count(len(summary.checks), 'check')} hold", "green"))


def _split(text: str) -> tuple[str, str]:
    value, _, unit = text.partition(" ")
    return value, unit
