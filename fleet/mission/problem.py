"""One thing that is wrong in a mission: where it stands, the value, what was expected."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from typing import Any

from msgspec import UNSET, Struct

Key = tuple[str | int, ...]
"""Where a value stands: ("boats", 1, "start", "s_m")."""
Lines = Mapping[Key, int | str]
"""Where each key was written: a line of the file, 0 an override, or the option of the command line that set it."""

SHOWN = 40  # characters of a wrong value that a message repeats


class Problem(Struct, frozen=True):
    """One thing that is wrong; `value` is UNSET where nothing is written."""

    where: Key
    wrong: str
    value: Any = UNSET

    def text(self, lines: Lines | None = None) -> str:
        """`boats[1].start.s_m = -5 (line 34): expected ...`."""
        value = "" if self.value is UNSET else f" = {show(self.value)}"
        return f"{dotted(self.where)}{value}{_place(self.where, lines or {})}: {self.wrong}"


def texts(problems: Iterable[Problem], lines: Lines | None = None) -> tuple[str, ...]:
    """The problems in words, each once."""
    return tuple(dict.fromkeys(problem.text(lines) for problem in problems))


def dotted(key: Key) -> str:
    """`boats[1].start.s_m`; `mission` for the whole file."""
    words = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in key)
    return words.removeprefix(".") or "mission"


def show(value: Any) -> str:
    """A value as TOML would have it, shortened; whole numbers without their point."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        text = f'"{value}"' if value.isprintable() else repr(value)
    elif isinstance(value, float):
        text = f"{value:.6g}"
    elif isinstance(value, int):
        text = str(value) if abs(value) < 10**SHOWN else f"a number of {value.bit_length()} bits"
    elif isinstance(value, list | tuple):
        text = "[" + ", ".join(show(item) for item in value[:4]) + (", ..." if len(value) > 4 else "") + "]"
    elif isinstance(value, dict):
        return "a table"
    else:
        text = str(value)
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 3]}..."


def hint(word: str, known: Iterable[str]) -> str:
    """`; did you mean "x"?`, or `; known: a, b` where nothing is near."""
    names = list(known)
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    if near:
        return f'; did you mean "{near[0]}"?'
    return f"; known: {', '.join(names)}" if names else ""


def _place(where: Key, lines: Lines) -> str:
    """` (line 34)`, ` (--set)`, ` (--cases)`: of the key itself, else of the nearest table or list around it."""
    for length in range(len(where), 0, -1):
        line = lines.get(where[:length])
        if isinstance(line, str):
            return f" ({line})"
        if line is not None:
            return f" (line {line})" if line > 0 else " (--set)"
        if isinstance(where[length - 1], int):  # an entry that no file has: made by `multiply`
            break
    return ""
