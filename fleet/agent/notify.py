"""What a service manager is told: ready, still alive, what it is about. The protocol of sd_notify(3).

A datagram to the socket that `NOTIFY_SOCKET` names; without one nothing is sent. The watchdog is fed by whoever calls
`whole_tick`, and by nobody else: there is no timer here.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Mapping

TOLD_NS = 1_000_000_000  # between two texts of STATUS=
READY_NS = 10_000_000_000  # a boat out of reach of everybody is ready after so long, and says so
LONGEST = 200  # of a text, characters


class Notifier:
    """The service manager of this process, if there is one. Sending never blocks and never raises."""

    def __init__(self, environment: Mapping[str, str] | None = None) -> None:
        given = os.environ if environment is None else environment
        self._address = _address(given.get("NOTIFY_SOCKET", ""))
        self._feed_ns = _feed_ns(given)
        self._socket: socket.socket | None = None
        if self._address is not None:
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
            self._socket.setblocking(False)
        self._fed_ns = self._told_ns = 0
        self._began_ns = 0
        self._text = ""
        self.ready = False

    @property
    def listens(self) -> bool:
        """Whether anybody does."""
        return self._socket is not None

    def send(self, *lines: str) -> bool:
        """One message of `NAME=value` lines; whether it went out."""
        if self._socket is None or self._address is None:
            return False
        try:
            self._socket.sendto("\n".join(lines).encode(), self._address)
        except OSError:  # a full queue, or a manager that is gone: the loop does not wait for it
            return False
        return True

    def whole_tick(self, in_reach: bool, text: str, now_ns: int | None = None) -> None:
        """A whole tick is over: feed the watchdog, three times in its period, and say what the boat does.

        Args:
            in_reach: connected, and alone under its name; the boat is ready then, or after 10 s without
            text: for a person, a line
            now_ns: of the monotonic clock; now when None
        """
        if self._socket is None:
            return
        now_ns = time.monotonic_ns() if now_ns is None else now_ns
        self._began_ns = self._began_ns or now_ns
        lines = []
        if not self.ready and (in_reach or now_ns - self._began_ns >= READY_NS):
            self.ready = True
            lines.append("READY=1")
        if self._feed_ns and now_ns - self._fed_ns >= self._feed_ns:
            lines.append("WATCHDOG=1")
        if lines or (text != self._text and now_ns - self._told_ns >= TOLD_NS):
            text = " ".join(text.split())[:LONGEST]
            if self.send(*lines, f"STATUS={text}"):
                self._text, self._told_ns = text, now_ns
                self._fed_ns = now_ns if "WATCHDOG=1" in lines else self._fed_ns
            else:
                self.ready = self.ready and "READY=1" not in lines

    def ends(self) -> None:
        """The process ends in good order."""
        self.send("STOPPING=1", "STATUS=ends")


def _address(text: str) -> str | bytes | None:
    """A path, or an abstract name written with @; None where there is none, or one of another kind."""
    if text.startswith("@"):
        return b"\0" + text[1:].encode()
    return text if text.startswith("/") else None


def _feed_ns(environment: Mapping[str, str]) -> int:
    """A third of the watchdog's period; 0: there is no watchdog, or it is another process's."""
    try:
        period_us = int(environment.get("WATCHDOG_USEC", "0"))
        pid = int(environment.get("WATCHDOG_PID", "0"))
    except ValueError:
        return 0
    return period_us * 1000 // 3 if period_us > 0 and pid in (0, os.getpid()) else 0
