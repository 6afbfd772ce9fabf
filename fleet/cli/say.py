"""What the command line prints: data on stdout, messages on stderr, colour only on a terminal that wants it."""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Iterable, Sequence
from typing import IO, Any

from fleet.errors import FleetError, UsageError

COLOURS = {"red": "31", "green": "32", "yellow": "33", "bold": "1", "faint": "2"}


def coloured(stream: IO[str]) -> bool:
    """Whether colour is wanted there."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def paint(text: str, colour: str, stream: IO[str] | None = None) -> str:
    """The text in a colour, where the stream shows any."""
    return f"\x1b[{COLOURS[colour]}m{text}\x1b[0m" if coloured(stream or sys.stdout) else text


def out(text: str = "") -> None:
    """A line of data."""
    print(text, flush=True)


def out_json(value: Any, indent: int | None = 2) -> None:
    """One JSON object, on one line when it is one of a stream; what is not finite is null."""
    print(json.dumps(finite(value), indent=indent, ensure_ascii=False), flush=True)


def finite(value: Any) -> Any:
    """The value, with null for what is not finite."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    return value


def note(text: str) -> None:
    """A message."""
    print(text, file=sys.stderr, flush=True)


def _each(word: str, colour: str, text: str) -> None:
    for line in text.splitlines() or [""]:
        note(f"{paint(word, colour, sys.stderr)}: {line}")


def error(text: str) -> None:
    """What went wrong, one line a problem."""
    _each("error", "red", text)


def warning(text: str) -> None:
    """What may not be as meant."""
    _each("warning", "yellow", text)


def hint(text: str) -> None:
    """What to do next."""
    _each("hint", "faint", text)


def aligned(rows: Iterable[Sequence[str]], right: Iterable[int] = (), indent: str = "") -> list[str]:
    """Rows in columns, two spaces apart; the columns in `right` end together."""
    cells = [list(row) for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)] if cells else []
    to_right = set(right)
    lines = []
    for row in cells:
        padded = [c.rjust(w) if i in to_right else c.ljust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))]
        lines.append((indent + "  ".join(padded)).rstrip())
    return lines


# -- asking ------------------------------------------------------------------------------------------------------------
def must_be_able_to_ask(what: str, yes: bool) -> None:
    """Refuse what needs a yes where nobody can be asked."""
    if not yes and not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise UsageError(f"{what} asks before it is sent, and there is no terminal to ask on: expected --yes")


def confirm(question: str, yes: bool) -> None:
    """Show target and change, and go on only after a yes."""
    if yes:
        return
    print(f"{question}\nGo on? [y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in ("y", "yes"):
        raise FleetError("not confirmed: nothing was sent")


def count(number: int, what: str) -> str:
    """`1 boat`, `2 boats`."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def number(text: str, what: str, unit: str, expected: str = "a number") -> float:
    """A finite number, or UsageError: `spacing 'x' m: expected a number`."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UsageError(f"{what} {text!r}: expected {expected}" + (f" in {unit}" if unit else ""))
    return value
