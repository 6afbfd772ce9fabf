"""`--set formation.spacing_m=15`: a value of a mission changed without touching its file."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

from fleet.mission.problem import Key, Problem, dotted, hint


def apply(tree: dict[str, Any], overrides: Sequence[str]) -> tuple[list[Key], list[Problem]]:
    """Change `tree` in place; the keys that were set, and what could not be.

    An override is `dotted.key=value`. Entries of a list are called by their number from 0, boats also by their name:
    `boats.b1.limits.speed_max_mps=2`, `timeline.0.value=-15`. The value is TOML; what is not is taken as text.
    """
    keys: list[Key] = []
    problems: list[Problem] = []
    for override in overrides:
        name, sign, value = override.partition("=")
        parts = [part.strip().strip('"') for part in name.split(".")]
        if not sign or not all(parts):
            problems.append(Problem(("--set",), "expected dotted.key=value", override))
            continue
        outcome = put(tree, parts, _value(value))
        if isinstance(outcome, Problem):
            problems.append(outcome)
        else:
            keys.append(outcome)
    return keys, problems


def apply_option(
    tree: dict[str, Any], name: str, value: Any, option: str, lines: dict[Key, int | str]
) -> list[Problem]:
    """Set what an option of the command line says, and note in `lines` that it said so; what could not be."""
    outcome = put(tree, name.split("."), value)
    if isinstance(outcome, Problem):
        return [outcome]
    lines[outcome] = option
    return []


def _value(text: str) -> Any:
    """A TOML value, else the text itself."""
    if "\n" not in text:
        try:
            return tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            pass
    return text.strip()


def put(tree: dict[str, Any], parts: list[str], value: Any) -> Key | Problem:
    """Set one value; its key, or what was in the way. Tables that are not there yet are made."""
    here: Any = tree
    key: Key = ()
    for i, part in enumerate(parts):
        last = i == len(parts) - 1
        if isinstance(here, list):
            index = _entry(here, part)
            if index is None:
                names = [str(item["name"]) for item in here if isinstance(item, dict) and "name" in item]
                count = f"it has {len(here)} entries, counted from 0"
                return Problem((*key, part), f"no such entry in {dotted(key)}: {count}{hint(part, names)}")
            key = (*key, index)
            if last:
                here[index] = value
            here = here[index]
        elif isinstance(here, dict):
            key = (*key, part)
            if last:
                here[part] = value
            here = value if last else here.setdefault(part, {})
        else:
            return Problem((*key, part), f"cannot be set: {dotted(key)} is a single value")
    return key


def _entry(entries: list[Any], part: str) -> int | None:
    """Place of the list entry called `part`: its name, or its number from 0."""
    for i, item in enumerate(entries):
        if isinstance(item, dict) and item.get("name") == part:
            return i
    if part.isascii() and part.isdigit() and int(part) < len(entries):
        return int(part)
    return None
