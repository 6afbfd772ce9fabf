"""Work that would make a tick late, such as building a mission's paths, done in a thread of its own, piece after piece.

What came of it is taken in by the thread that decides, at its next tick. Without a thread it is done at once: for
lock-step simulation and for tests.
"""

from __future__ import annotations

import logging
import queue
import sys
import threading
from collections import deque
from collections.abc import Callable

log = logging.getLogger("fleet.agent")
MOST = 4  # pieces that wait; who asks for more is told to ask again
SWITCH_S = 0.0001  # so long the loop waits for the interpreter while a piece is worked on; Python's own is 5 ms


class Piece:
    """Work that waits until the worker begins it, or who asked for it withdraws it: whoever is first."""

    def __init__(self, work: Callable[[], None], then: Callable[[], None]) -> None:
        self.work, self.then = work, then
        self._free = [True]  # taking it out is one step of the interpreter

    def claim(self) -> bool:
        """Whether it is the caller's now: to be worked on, or, by who asked for it, not to be worked on any more."""
        try:
            return self._free.pop()
        except IndexError:
            return False


class Background:
    """One worker and its queue."""

    def __init__(self, *, threaded: bool) -> None:
        self._threaded = threaded
        self._queue: queue.SimpleQueue[Piece] = queue.SimpleQueue()
        self._done: deque[Callable[[], None]] = deque()
        self._waiting = 0
        self._thread: threading.Thread | None = None

    def submit(self, work: Callable[[], None], then: Callable[[], None]) -> Piece | None:
        """Do `work` there, and `then` here, at a later tick; None when too much waits already.

        Who claims the piece before it is begun has withdrawn it: neither is done.
        """
        piece = Piece(work, then)
        if not self._threaded:
            piece.claim()
            _guarded(work)
            then()
            return piece
        if self._waiting >= MOST:
            return None
        self._waiting += 1
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="background", daemon=True)
            self._thread.start()
        self._queue.put(piece)
        return piece

    def finish(self) -> None:
        """Take in what is done."""
        while self._done:
            self._waiting -= 1
            self._done.popleft()()

    def _run(self) -> None:
        while True:
            piece = self._queue.get()
            if not piece.claim():
                self._done.append(lambda: None)
                continue
            usual = sys.getswitchinterval()
            sys.setswitchinterval(SWITCH_S)
            try:
                _guarded(piece.work)
            finally:
                sys.setswitchinterval(usual)
            self._done.append(piece.then)


def _guarded(work: Callable[[], None]) -> None:
    """Run `work`; whatever it raises is said, and ends nothing else."""
    try:
        work()
    except Exception:
        log.exception("background work failed", extra={"event": "background"})
