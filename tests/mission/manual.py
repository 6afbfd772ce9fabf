"""The tables that docs/missions.md must print, made from the code."""

from __future__ import annotations

from fleet.mission.checks import CHECKS
from fleet.mission.load import ready
from fleet.mission.timeline import ACTIONS


def ready_table() -> str:
    """The ready missions."""
    rows = [f"| `{name}` | {title} |" for name, title in ready().items()]
    return "\n".join(["| name | what happens |", "|---|---|", *rows])


def action_table() -> str:
    """What a timeline can order."""
    rows = [f"| `{name}` | {action.by} | {action.value or ''} | {action.meaning} |" for name, action in ACTIONS.items()]
    return "\n".join(["| do | by | value | meaning |", "|---|---|---|---|", *rows])


def check_table() -> str:
    """What a run can be judged by."""
    rows = [f"| `{name}` | {check.direction} | {check.unit} | {check.meaning} |" for name, check in CHECKS.items()]
    return "\n".join(["| check | limit | unit | meaning |", "|---|---|---|---|", *rows])
