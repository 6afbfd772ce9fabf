"""Names and keys: `fleet/<fleet>/<boat>/<what>`, operators under `fleet/<fleet>/operator/<id>`."""

from __future__ import annotations

import re
from functools import lru_cache

from fleet.errors import UsageError

NAME = re.compile(r"[a-z0-9-]{1,32}")
OPERATOR = "operator"  # no boat may be called so

STATE, STATUS, ALIVE, COMMAND, MISSION, FORMATION, EVENT, ECHO, STOPS, ROSTER, MAVLINK = (
    "state",
    "status",
    "alive",
    "command",
    "mission",
    "formation",
    "event",
    "echo",
    "stops",
    "roster",
    "mavlink",
)
ASKED = (COMMAND, MISSION, FORMATION, ECHO, STOPS, ROSTER, MAVLINK)
"""What a boat answers when it is asked. MAVLINK is published too: frames of the boat's own autopilot."""


def valid_name(what: str, name: str) -> str:
    """The name, if it may stand in a key; UsageError otherwise."""
    if not NAME.fullmatch(name):
        raise UsageError(f"{what} {name!r}: expected 1 to 32 of a-z, 0-9 and -")
    if name == OPERATOR:
        raise UsageError(f"{what} {name!r}: this name is kept for operators")
    return name


def key(fleet: str, boat: str, what: str) -> str:
    """The key of one thing of one boat; `*` for all boats."""
    return f"fleet/{fleet}/{boat}/{what}"


def operator_key(fleet: str, operator: str) -> str:
    """The key of an operator's liveliness token; `*` for all operators."""
    return f"fleet/{fleet}/{OPERATOR}/{operator}/alive"


@lru_cache(maxsize=1024)
def boat_of(key_expr: str) -> str:
    """The boat that a key belongs to; `` for a key that is nobody's, such as one with wildcards."""
    parts = key_expr.split("/", 3)
    return parts[2] if len(parts) == 4 and NAME.fullmatch(parts[2]) else ""


def operator_of(key_expr: str) -> str:
    """The operator that a key belongs to; `` for a key that is nobody's."""
    parts = key_expr.split("/", 4)
    return parts[3] if len(parts) == 5 and NAME.fullmatch(parts[3]) else ""
