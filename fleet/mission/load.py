"""Missions from files, by ready name, with overrides, for N boats; and to and from bytes for the wire."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from fleet.errors import MissionError
from fleet.mission.check import Findings, check
from fleet.mission.model import Mission
from fleet.mission.multiply import multiply
from fleet.mission.overrides import apply, apply_option
from fleet.mission.problem import Key, texts
from fleet.mission.structure import problems
from fleet.mission.toml_file import parse, ready_files, text_at
from fleet.mission.toml_lines import key_lines

__all__ = ["Source", "decode", "encode", "examine", "load", "multiply", "read", "ready", "text_of"]


class Source(Struct, frozen=True):
    """A mission file as read: not yet known to make sense."""

    name: str
    """The path or the ready name, as messages call it."""
    tree: dict[str, Any]
    lines: dict[Key, int]
    """Line of every key; 0 for what an override set."""


def load(where: str | Path, overrides: Sequence[str] = (), boats: int | None = None) -> Mission:
    """The mission at a path or of a ready name, found to be sailable; MissionError with every problem."""
    mission, findings = examine(where, overrides, boats)
    if findings.problems:
        raise MissionError(str(where), findings.problems)
    return mission


def examine(
    where: str | Path, overrides: Sequence[str] = (), boats: int | None = None, method: str | None = None
) -> tuple[Mission, Findings]:
    """The mission and what was found about it; MissionError only where it cannot even be read.

    Args:
        where: path of a file, or a ready name
        overrides: `dotted.key=value`, applied before anything is checked
        boats: sail with so many boats instead of those written (see `multiply`)
        method: how boats keep clear, instead of what is written
    """
    source = read(where)
    keys, refused = apply(source.tree, overrides)
    lines: dict[Key, int | str] = {**source.lines, **dict.fromkeys(keys, 0)}
    if method is not None:
        refused += apply_option(source.tree, "keeping_clear.method", method, "--method", lines)
    found = (*refused, *problems(source.tree, Mission))
    if found:
        raise MissionError(source.name, texts(found, lines))
    mission = _convert(source.tree, source.name)
    if boats is not None:
        mission = multiply(mission, boats)
    return mission, check(mission, lines)


def read(where: str | Path) -> Source:
    """The tree of values in a mission file, with the line of each."""
    text = text_of(where)
    tree = parse(text, str(where), MissionError)
    return Source(name=str(where), tree=tree, lines=key_lines(text))


def text_of(where: str | Path) -> str:
    """The text of a mission file, or of a ready mission: something to copy and change."""
    return text_at(where, ready_files("fleet.mission", "ready"), "mission", MissionError)


def ready() -> dict[str, str]:
    """Names of the missions that come with fleet, with their titles."""
    known = ready_files("fleet.mission", "ready")
    return {name: tomllib.loads(known[name].read_text(encoding="utf-8"))["title"] for name in sorted(known)}


def encode(mission: Mission) -> bytes:
    """The mission for the wire: equal missions give equal bytes."""
    return msgspec.msgpack.encode(mission, order="sorted")


def decode(content: bytes) -> Mission:
    """The mission in `encode`d bytes; MissionError for what has not the shape of one.

    Whether it makes sense is for `check` to say: a boat does so before it accepts a mission.
    """
    try:
        tree = msgspec.msgpack.decode(content)
    except (msgspec.DecodeError, RecursionError, ValueError) as error:
        raise MissionError("received mission", (f"not msgpack: {error}",)) from None
    found = problems(tree, Mission)
    if found:
        raise MissionError("received mission", texts(found))
    return _convert(tree, "received mission")


def _convert(tree: Any, name: str) -> Mission:
    """A tree that was found to have the shape of a mission."""
    try:
        return msgspec.convert(tree, Mission)
    except (msgspec.ValidationError, OverflowError) as error:  # something that `problems` does not know
        raise MissionError(name, (str(error),)) from None
