"""Bytes to and from a scanner, waiting for a short while; of a thread of its own.

tcp:HOST            port 10940, which all of Hokuyo's have
tcp:HOST:PORT
serial:DEVICE       a USB line: any speed will do
serial:DEVICE:BAUD
"""

from __future__ import annotations

import contextlib
import select

from fleet.drivers.sensors.port import Endpoint, Line, endpoint, opened, words
from fleet.errors import ConfigError

PORT, BAUD = 10940, 115200
LISTEN_S = 0.05
EXPECTED = "tcp:HOST, tcp:HOST:PORT, serial:DEVICE or serial:DEVICE:BAUD, such as tcp:192.168.0.10"


class LinkLost(Exception):
    """The link does not work; the text says why."""


def scanner_at(text: str, who: str) -> Endpoint:
    """The endpoint that a text means; ConfigError, with the sensor's name, when it means none."""
    kind, _, rest = text.partition(":")
    usual = {"tcp": PORT, "serial": BAUD}.get(kind)
    if usual is None or not rest:
        raise ConfigError(f"driver.sensors, {who}: endpoint {text!r}: expected {EXPECTED}")
    whole = rest.rpartition(":")[2].isdigit() and ":" in rest
    return endpoint(text if whole else f"{text}:{usual}", who, kinds=("tcp", "serial"))


class Link:
    """A way to a scanner."""

    def __init__(self, where: Endpoint) -> None:
        self.where = where
        self._line: Line | None = None

    def open(self) -> None:
        """Connect; LinkLost where that fails."""
        try:
            self._line = opened(self.where)
        except (OSError, ValueError) as error:
            raise LinkLost(words(error)) from None

    def receive(self) -> bytes:
        """What arrived within 50 ms; LinkLost where nothing can come any more."""
        assert self._line is not None
        try:
            return self._line.receive() if select.select([self._line.file], [], [], LISTEN_S)[0] else b""
        except (OSError, ValueError) as error:
            raise LinkLost(words(error)) from None

    def send(self, line: bytes) -> None:
        """Send all of it; LinkLost where that fails."""
        assert self._line is not None
        try:
            self._line.send(line)
        except OSError as error:
            raise LinkLost(words(error)) from None

    def close(self) -> None:
        """Disconnect."""
        line, self._line = self._line, None
        if line is not None:
            with contextlib.suppress(OSError):
                line.close()
