"""TOML files by path or ready name, with messages that say what cannot be read and where."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from fleet.errors import FileError
from fleet.mission.problem import hint

LARGEST = 1_000_000  # bytes of a file; a mission of 100 boats has 20 kB


def ready_files(package: str, folder: str) -> dict[str, Any]:
    """TOML files that come with a package, by name."""
    there = resources.files(package) / folder
    return {file.name.removesuffix(".toml"): file for file in there.iterdir() if file.name.endswith(".toml")}


def text_at(where: str | Path, known: Mapping[str, Any], what: str, error: type[FileError]) -> str:
    """The text of the file at a path, or of a ready one.

    Args:
        where: the path, or a name in `known`
        known: the ready files
        what: how messages call such a file: `mission`
        error: what is raised, with the reason
    """
    name = str(where)
    if name in known:
        return str(known[name].read_text(encoding="utf-8"))
    try:
        content = Path(where).read_bytes()
    except (OSError, ValueError) as trouble:
        raise error(name, (_unreadable(trouble, name, what, list(known)),)) from None
    if len(content) > LARGEST:
        raise error(name, (f"{len(content)} bytes: expected at most {LARGEST}",))
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as trouble:
        line = content.count(b"\n", 0, trouble.start) + 1
        raise error(name, (f"line {line}: byte {content[trouble.start]:#04x} is not UTF-8 text",)) from None


def parse(text: str, name: str, error: type[FileError]) -> dict[str, Any]:
    """The tree of values in a text; `name` is how messages call it."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as trouble:
        raise error(name, (_syntax(str(trouble), text),)) from None
    except RecursionError:
        raise error(name, ("nested too deep",)) from None


def _unreadable(trouble: Exception, name: str, what: str, known: list[str]) -> str:
    """Why a file cannot be read, and what may have been meant."""
    if isinstance(trouble, FileNotFoundError):
        return f"neither a file nor a ready {what}{hint(name, sorted(known))}"
    return f"cannot be read: {getattr(trouble, 'strerror', None) or trouble}"


def _syntax(message: str, text: str) -> str:
    """tomllib's message with the place in front, and the line as it stands."""
    found = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", message, re.DOTALL)
    if found is None:
        return message
    if found[2] is None:
        return f"end of file: {found[1]}"
    written = text.split("\n")[int(found[2]) - 1].strip()
    return f"line {found[2]}, column {found[3]}: {found[1]}, in: {written[:60]}"
