"""How far a sweep is: a bar on a terminal, lines elsewhere, on stderr."""

from __future__ import annotations

import sys
import threading
import time
from types import TracebackType
from typing import TYPE_CHECKING, Self

from fleet.cli import say

if TYPE_CHECKING:
    from fleet.sim.sweep.run import Progress

DRAW_S, LINES_S = 0.5, 5.0


def watcher() -> Bar | Lines:
    """The one that fits where stderr goes; to be used with `with`, and called with the progress."""
    return Bar() if sys.stderr.isatty() else Lines()


class Bar:
    """A bar on a terminal, drawn twice a second by a thread of its own: parts come seldom."""

    def __init__(self) -> None:
        from fleet.cli.live import Screen

        self._screen = Screen(DRAW_S)
        self._last: Progress | None = None
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._go_on, daemon=True)

    def __enter__(self) -> Self:
        self._screen.__enter__()
        self._thread.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._over.set()
        self._thread.join()
        self._draw()
        self._screen.__exit__(kind, error, at)

    def __call__(self, progress: Progress) -> None:
        """Take note; it is drawn soon."""
        self._last = progress

    def _go_on(self) -> None:
        while not self._over.wait(DRAW_S):
            self._draw()

    def _draw(self) -> None:
        from fleet.cli.live import bar

        if self._last is not None:
            self._screen.draw(bar(self._last.cases, self._last.total, words(self._last)))


class Lines:
    """A line every few seconds elsewhere, and one at the end."""

    def __init__(self) -> None:
        self._next = 0.0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        pass

    def __call__(self, progress: Progress) -> None:
        """Say how far it is, when it is time."""
        now = time.monotonic()
        if now >= self._next or progress.cases == progress.total:
            self._next = now + LINES_S
            say.note(words(progress))


def words(progress: Progress) -> str:
    """`512 of 10000 cases, 3 failing, ends 19:45 in 2:10`: fits on a line with the bar."""
    share = f"{progress.cases} of {progress.total} cases, {progress.failures} failing"
    if progress.cases == progress.total or progress.left_s is None:
        return share
    minutes, seconds = divmod(round(progress.left_s), 60)
    hours, minutes = divmod(minutes, 60)
    left = f"{hours}:{minutes:02}:{seconds:02}" if hours else f"{minutes}:{seconds:02}"
    ends = time.strftime("%H:%M", time.localtime(time.time() + progress.left_s))
    return f"{share}, ends {ends} in {left}"
