"""Other ends of ports, on loopback and on a pseudo-terminal; and waiting until something is so."""

from __future__ import annotations

import os
import socket
import time
import tty
from collections.abc import Callable
from typing import Self

from fleet.drivers.seam import Observed, Sensor

PATIENCE_S = 10.0


def until(so: Callable[[], bool]) -> None:
    """Wait until it is so."""
    deadline = time.monotonic() + PATIENCE_S
    while not so():
        assert time.monotonic() < deadline, "it never came to be"
        time.sleep(0.002)


def said(sensor: Sensor, so: Callable[[Observed], bool], keep: Callable[[], None] = lambda: None) -> Observed:
    """Ask the sensor until it says something that is so."""
    found: list[Observed] = []

    def ask() -> bool:
        keep()
        found.append(sensor.read(time.time_ns()))
        return so(found[-1])

    until(ask)
    return found[-1]


def free_port(kind: int = socket.SOCK_STREAM) -> int:
    """A port that nobody uses just now."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class Server:
    """A TCP server with one client at a time."""

    def __init__(self, port: int = 0) -> None:
        self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.settimeout(PATIENCE_S)
        self.port: int = self._listener.getsockname()[1]
        self.client: socket.socket | None = None

    def accept(self) -> socket.socket:
        """Wait for a client."""
        self.client, _ = self._listener.accept()
        self.client.settimeout(PATIENCE_S)
        return self.client

    def close(self) -> None:
        """End, with the client's connection."""
        if self.client is not None:
            self.client.close()
        self._listener.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Pty:
    """A serial line: what is written to it comes out at `device`."""

    def __init__(self) -> None:
        self._ours, self._theirs = os.openpty()
        tty.setraw(self._theirs)
        self.device = os.ttyname(self._theirs)

    def write(self, payload: bytes) -> None:
        """Send."""
        os.write(self._ours, payload)

    def close(self) -> None:
        """Pull the plug."""
        for one in (self._ours, self._theirs):
            if one >= 0:
                os.close(one)
        self._ours = self._theirs = -1
