"""What was measured, as rows of one table."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from msgspec import Struct, to_builtins


class Row(Struct, frozen=True, kw_only=True):
    """One figure, what it is divided by, and what it should be."""

    group: str
    name: str
    value: float
    unit: str
    ratio: float | None = None  # to `over`, in the same run
    over: str = ""
    aim: float | None = None  # the largest `value`, or `ratio` if `aim_is_ratio`, that is good
    aim_is_ratio: bool = False
    scale: float = 1.0  # how much slower this machine is just now than the reference: the aim is as much longer
    note: str = ""

    @property
    def missed(self) -> bool:
        """Whether the aim is missed; a row without an aim misses nothing."""
        if self.aim is None:
            return False
        return (self.ratio or 0.0) > self.aim if self.aim_is_ratio else self.value > self.aim * self.scale

    @property
    def aim_text(self) -> str:
        """The aim in words."""
        if self.aim is None:
            return ""
        return f"<= {self.aim:g} x" if self.aim_is_ratio else f"<= {self.aim:g} {self.unit}"


def number(value: float) -> str:
    """Three digits that matter, without an exponent."""
    if value == 0.0 or abs(value) >= 100.0:
        return f"{value:.0f}"
    return f"{value:.1f}" if abs(value) >= 10.0 else f"{value:.2f}"


def line(row: Row) -> str:
    """A row as it is printed."""
    ratio = f"{number(row.ratio)} x {row.over}" if row.ratio is not None else ""
    mark = "MISSED" if row.missed else ("ok" if row.aim is not None else "")
    figure = f"{number(row.value)} {row.unit}"
    return f"{row.name:<50} {figure:>13}  {ratio:<30} {row.aim_text:<12} {mark:<6} {row.note}".rstrip()


class Table:
    """Prints rows as they come, and keeps them."""

    def __init__(self) -> None:
        self.rows: list[Row] = []
        self._group = ""

    def add(self, row: Row) -> None:
        """Print and keep a row."""
        if row.group != self._group:
            self._group = row.group
            print(f"\n{row.group}", flush=True)
        self.rows.append(row)
        print("  " + line(row), flush=True)

    def say(self, text: str) -> None:
        """Something on the way, not part of the table."""
        print(text, file=sys.stderr, flush=True)

    def write(self, path: Path, facts: dict[str, object]) -> None:
        """All rows as one JSON object."""
        rows = [{**to_builtins(row), "missed": row.missed} for row in self.rows]
        path.write_text(json.dumps({**facts, "rows": rows}, indent=1) + "\n", encoding="utf-8")
