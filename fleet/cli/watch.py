"""What `fleet sim` shows while the mission sails: a picture on a terminal, lines elsewhere."""

from __future__ import annotations

import sys
import time
from collections import Counter
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol, Self

from fleet.cli import say
from fleet.cli.boats import cells, facts, mode_shown

if TYPE_CHECKING:
    from fleet.operator import BoatView, Outcome
    from fleet.sim.sail import Progress

SCREEN_S, LINES_S = 0.25, 3.0
EVENTS = 4
AROUND = 10  # lines of the picture that are not boats
MANY = 3  # boats from which on a line counts them


class Watcher(Protocol):
    """Gets the progress fifty times a second, and ends with the run."""

    def __call__(self, progress: Progress) -> None: ...
    def __enter__(self) -> Self: ...
    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None: ...


def watcher(warp: float) -> Watcher:
    """The one that fits where stderr goes."""
    return Picture(warp) if sys.stderr.isatty() else Lines(warp)


def answers(outcome: Outcome) -> str:
    """`b1, b2 acknowledged; b3 refused: why; b4 not answered`."""
    parts = [f"{', '.join(outcome.acknowledged)} acknowledged"] if outcome.acknowledged else []
    parts += [f"{boat} refused: {reason}" for boat, reason in outcome.refused.items()]
    parts += [f"{', '.join(outcome.silent)} not answered"] if outcome.silent else []
    parts += [outcome.note] if outcome.note and not outcome.acks else []
    return "; ".join(parts)


def told(outcome: Outcome) -> str:
    """The command, old and new value, and who acknowledged."""
    change = f" {outcome.old or '-'} -> {outcome.new or '-'}" if outcome.old or outcome.new else ""
    return f"{outcome.command}{change}: {answers(outcome)}"


def _views(progress: Progress) -> list[BoatView]:
    """The boats in the order of the mission, with those that were never heard."""
    from fleet.operator import BoatView

    heard = progress.fleet.boats
    return [heard.get(boat.name) or BoatView(boat.name) for boat in progress.plan.boats]


def _formation(rows: list[dict[str, Any]]) -> str:
    """The formation in force, where the boats agree; else what each group has."""
    held = Counter(
        f"{row['pattern'] or ''}, spacing {row['spacing_m']:g} m, cruise {row['cruise_mps']:g} m/s, "
        f"revision {row['formation_in_force']}".removeprefix(", ")
        for row in rows
        if row["alive"] and row.get("spacing_m") is not None
    )
    if not held:
        return ""
    if len(held) == 1:
        return f"formation: {next(iter(held))}"
    return "formation: " + "; ".join(f"{say.count(boats, 'boat')} with {words}" for words, boats in held.items())


class Lines:
    """A line every few seconds, and one for every command."""

    def __init__(self, warp: float) -> None:
        self._warp, self._next, self._told = warp, 0.0, 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        pass

    def __call__(self, progress: Progress) -> None:
        """Say what is new."""
        while self._told < len(progress.outcomes):
            say.note(f"{max(0.0, progress.t_s):7.1f} s  {told(progress.outcomes[self._told])}")
            self._told += 1
        now = time.monotonic()
        if now < self._next or progress.note == "starting":
            return
        self._next = now + LINES_S
        rows = [facts(view, self._warp) for view in _views(progress)]
        if len(rows) > MANY:
            modes = Counter(mode_shown(row) for row in rows)
            words = ", ".join(f"{number} {mode}" for mode, number in modes.items())
        else:
            words = "   ".join(" ".join(self._brief(row)) for row in rows)
        note = f"  ({progress.note})" if progress.note else ""
        clock = f"{progress.t_s:7.1f} of {progress.duration_s:g} s" if progress.t_s >= 0.0 else "about to begin"
        say.note(f"{clock}  {words}{note}")

    def _brief(self, row: dict[str, Any]) -> list[str]:
        boat, mode, s, speed, along, *_ = cells(row)
        return [boat, mode, f"s {s} m", f"{speed} m/s", f"error {along} m"]


class Picture:
    """A table that is drawn four times a second."""

    def __init__(self, warp: float) -> None:
        from fleet.cli.live import Screen

        self._warp = warp
        self._screen = Screen(SCREEN_S)
        self._last: Progress | None = None
        self._told: list[tuple[float, Outcome]] = []
        self._start_ns = 0

    def __enter__(self) -> Self:
        self._screen.__enter__()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._last is not None:
            self._draw(self._last)
        self._screen.__exit__(kind, error, at)

    def __call__(self, progress: Progress) -> None:
        """Draw again when it is time."""
        self._last = progress
        self._told += [(progress.t_s, outcome) for outcome in progress.outcomes[len(self._told) :]]
        if self._screen.due():
            self._draw(progress)

    def _draw(self, progress: Progress) -> None:
        from rich.text import Text

        from fleet.cli import live

        mission = progress.plan.mission
        rows = [facts(view, self._warp) for view in _views(progress)]
        table = live.boats_table(
            rows, self._screen.width, max(3, self._screen.height - AROUND - EVENTS), mission.keeping_clear.radius_m
        )
        now_ns = self._now_ns(progress)
        t_s, total_s = (now_ns - self._start_ns) * 1e-9 if now_ns else 0.0, progress.duration_s
        clock = f"{t_s:.1f} of {total_s:g} s" + (f", {self._warp:g} times as fast" if self._warp != 1.0 else "")
        command = ""
        if self._told:
            at_s, outcome = self._told[-1]
            command = f"{max(0.0, at_s):7.1f} s  {told(outcome)}"
        self._screen.draw(
            Text(mission.title, style="bold", no_wrap=True, overflow="ellipsis"),
            live.bar(t_s, total_s, f"{clock}{'; ' + progress.note if progress.note else ''}"),
            Text(_formation(rows) or " ", no_wrap=True, overflow="ellipsis"),
            Text(),
            table,
            live.signs(),
            Text(f"\nlast command\n{command or ' '}", no_wrap=True, overflow="ellipsis"),
            Text("\n".join(["last events", *self._events(progress)]), no_wrap=True, overflow="ellipsis"),
        )

    def _events(self, progress: Progress) -> list[str]:
        """The last things that boats told, by the clock of the mission; always as many lines."""
        lines = []
        for event in progress.fleet.events[-EVENTS:]:
            at_s = max(0.0, (event.stamp_ns - self._start_ns) * 1e-9)
            lines.append(f"{at_s:7.1f} s  {event.boat}  {event.kind}: {event.text}")
        return lines + [" "] * (EVENTS - len(lines))

    def _now_ns(self, progress: Progress) -> int:
        """The boats' time, from their states; 0 before the mission began."""
        if progress.t_s <= 0.0:
            return 0
        states = [view.state for view in progress.fleet.boats.values() if view.state is not None]
        now_ns = max((state.stamp_ns for state in states), default=0)
        self._start_ns = self._start_ns or now_ns - int(progress.t_s * 1e9)
        return max(now_ns, self._start_ns)
