"""The live picture in a terminal: rich is imported here, and this module only when there is something to draw."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Literal, Self

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from fleet.cli.boats import HEADS, OLD_S, RIGHT, SIGNS, UNITS, WIDTHS, cells, mode_shown, why

WIDE = 100  # columns from which on the reasons have a column of their own
STYLES = {
    "follow": "green",
    "avoid": "yellow",
    "hold": "cyan",
    "return": "cyan",
    "standby": "dim",
    "alone": "bold magenta",
    "neutral": "bold red",
    "fault": "bold red",
    "lost": "bold red",
    "unheard": "dim",
}


def boats_table(facts: Sequence[dict[str, Any]], width: int, rows: int, radius_m: float = 0.0) -> RenderableType:
    """The boats, at most so many rows; what does not fit is counted by mode."""
    table = Table(box=None, padding=(0, 1), header_style="bold", pad_edge=False)
    for i, (head, unit) in enumerate(zip(HEADS, UNITS, strict=True)):
        side: Literal["left", "right"] = "right" if i in RIGHT else "left"
        table.add_column(Text(f"{head}\n{unit}", justify=side), justify=side, no_wrap=True, min_width=WIDTHS[i])
    if width >= WIDE:
        table.add_column(Text("why\n"), no_wrap=True, overflow="ellipsis", ratio=1)
    shown = list(facts) if len(facts) <= rows else list(facts)[: max(1, rows - 1)]
    for fact in shown:
        texts = [Text(cell) for cell in cells(fact)]
        texts[1].stylize(STYLES.get(mode_shown(fact), ""))
        near = fact.get("nearest_m")
        if near is not None and near < 2.0 * radius_m:
            texts[7].stylize("bold red" if near < radius_m else "yellow")
        if fact["age_s"] is None or fact["age_s"] > OLD_S:
            texts[8].stylize("bold red")
        table.add_row(*texts, *([Text(why(fact))] if width >= WIDE else []))
    if len(shown) == len(facts):
        return table
    rest = Counter(mode_shown(fact) for fact in facts[len(shown) :])
    words = ", ".join(f"{number} {mode}" for mode, number in rest.items())
    return Group(table, Text(f"and {len(facts) - len(shown)} more boats: {words}", style="dim"))


def signs() -> Text:
    """How to read the signs."""
    return Text(SIGNS, style="dim")


def bar(done: float, total: float, words: str) -> Table:
    """A progress bar with words behind it."""
    row = Table.grid(padding=(0, 1))
    row.add_row(ProgressBar(total=total, completed=min(max(done, 0.0), total), width=30), Text(words))
    return row


class Screen:
    """A part of the terminal that is drawn again and again, on stderr."""

    def __init__(self, every_s: float) -> None:
        self._console = Console(stderr=True)
        self._live = Live(console=self._console, auto_refresh=False, vertical_overflow="crop")
        self._every_s, self._next = every_s, 0.0

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._live.stop()

    @property
    def width(self) -> int:
        """Columns."""
        return self._console.width

    @property
    def height(self) -> int:
        """Lines."""
        return self._console.height

    def due(self) -> bool:
        """Whether it is time to draw again."""
        now = time.monotonic()
        if now < self._next:
            return False
        self._next = now + self._every_s
        return True

    def draw(self, *parts: RenderableType) -> None:
        """Draw it."""
        self._live.update(Group(*parts), refresh=True)
