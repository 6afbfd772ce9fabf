"""How commands that go on until they are told end: by SIGTERM, or by Ctrl-C."""

from __future__ import annotations

import signal
import threading


class Ending:
    """Set by the first of the two, from now on."""

    def __init__(self) -> None:
        self.told = threading.Event()
        self._by = 0
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._end)

    def _end(self, number: int, _: object) -> None:
        self._by = self._by or number
        self.told.set()

    @property
    def exit_code(self) -> int:
        """130 after Ctrl-C, else 0."""
        return 130 if self._by == signal.SIGINT else 0
