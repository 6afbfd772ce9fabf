"""Bytes from a sensor: a serial line, a TCP connection, datagrams; in a thread of its own, opened again when lost.

    serial:DEVICE:BAUD
    tcp:HOST:PORT      we connect
    udp:HOST:PORT      we listen there; beyond loopback only where that is said to be meant

A thread, because the time at which bytes arrive is the time of the measurement, and because names and connections may
take their time.
"""

from __future__ import annotations

import contextlib
import ipaddress
import logging
import select
import socket
import threading
import time
from collections.abc import Callable
from typing import Any, Literal, NamedTuple, cast

from fleet.errors import ConfigError

log = logging.getLogger("fleet.sensors")
LARGEST = 65535
WAKE_S = 0.2  # a port that is to be closed notices so soon
GATHER_S = 0.01  # a serial line gives a byte at a time: so long for more of them
CONNECT_S = 3.0
AGAIN_S = 1.0  # between two tries to open it
DEAD_S = 10  # a TCP peer that answers nothing at all for so long is gone
EXPECTED = "serial:DEVICE:BAUD, tcp:HOST:PORT or udp:HOST:PORT, such as serial:/dev/ttyUSB0:38400"
Kind = Literal["serial", "tcp", "udp"]


class Endpoint(NamedTuple):
    """Where a sensor is."""

    kind: Kind
    where: str  # device or host
    number: int  # baud or port

    def __str__(self) -> str:
        return f"{self.kind}:{self.where}:{self.number}"

    @property
    def beyond_loopback(self) -> bool:
        """Whether strangers may send to it."""
        if self.kind != "udp" or self.where == "localhost":
            return False
        try:
            return not ipaddress.ip_address(self.where.strip("[]")).is_loopback
        except ValueError:
            return True


def endpoint(
    text: str, who: str, *, insecure: bool = False, kinds: tuple[Kind, ...] = ("serial", "tcp", "udp")
) -> Endpoint:
    """The endpoint that a text means; ConfigError, with the sensor's name, when it means none or may not be."""
    kind, _, rest = text.partition(":")
    where, _, number = rest.rpartition(":")
    right = kind in kinds and where != "" and number.isascii() and number.isdigit() and len(number) < 9
    if not right or (kind != "serial" and not 0 < int(number) < 65536) or int(number) == 0:
        raise ConfigError(f"driver.sensors, {who}: endpoint {text!r}: expected {_expected(kinds)}")
    found = Endpoint(cast("Kind", kind), where, int(number))
    if found.beyond_loopback and not insecure:
        raise ConfigError(
            f"driver.sensors, {who}: endpoint {text!r}: anybody on the network could tell this boat where it is; "
            "expected udp:127.0.0.1:PORT, or insecure = true where it is meant"
        )
    if kind == "serial":
        must_have_serial(who)
    return found


def _expected(kinds: tuple[Kind, ...]) -> str:
    return EXPECTED if len(kinds) > 1 else f"{kinds[0]}:HOST:PORT"


def must_have_serial(who: str) -> None:
    """ConfigError where pyserial is not installed."""
    try:
        import serial  # noqa: F401
    except ImportError:
        raise ConfigError(
            f"driver.sensors, {who}: a serial line needs pyserial, which is not installed; "
            "pip install 'fleet-usv[sensors]'"
        ) from None


class Port:
    """See the module.

    `take(payload, stamp_ns)` is called in the port's thread with what arrived and when; `begun()` whenever the port was
    opened, so that what is left of before may be forgotten and a greeting sent.
    """

    def __init__(
        self,
        where: Endpoint,
        now_ns: Callable[[], int],
        take: Callable[[bytes, int], None],
        begun: Callable[[], None] = lambda: None,
    ) -> None:
        self.where = where
        self.trouble = ""  # why it is not open; "" when it is, and before the first try
        self.opened = 0  # how often
        self._now_ns, self._take, self._begun = now_ns, take, begun
        self._line: Line | None = None
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"port {where}", daemon=True)

    def open(self) -> None:
        """Begin."""
        if self.where.beyond_loopback:
            log.warning("%s: anybody on the network can write to this sensor", self.where, extra={"event": "insecure"})
        self._thread.start()

    def send(self, payload: bytes) -> bool:
        """Write, if the port is open; whether it could be."""
        line = self._line
        try:
            return line is not None and line.send(payload)
        except OSError:
            return False

    def close(self) -> None:
        """End."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(CONNECT_S + 1.0)

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                with contextlib.closing(opened(self.where)) as line:
                    self._line = line
                    self.trouble = ""
                    self.opened += 1
                    self._begun()
                    self._listen(line)
            except (OSError, ValueError) as error:  # pyserial's errors are OSErrors too
                self.trouble = words(error)
            finally:
                self._line = None
            self._stop.wait(AGAIN_S)

    def _listen(self, line: Line) -> None:
        while not self._stop.is_set():
            if not select.select([line.file], [], [], WAKE_S)[0]:
                continue
            stamp_ns = self._now_ns()
            if line.gathers:
                time.sleep(GATHER_S)
            payload = line.receive()
            if payload:
                self._take(payload, stamp_ns)


class Line:
    """Something open that can be waited for."""

    gathers = False

    def __init__(self, file: Any) -> None:
        self.file = file

    def receive(self) -> bytes:
        """What is there; OSError when the other end is gone."""
        return bytes(self.file.recv(LARGEST))

    def send(self, payload: bytes) -> bool:
        """Write."""
        self.file.sendall(payload)
        return True

    def close(self) -> None:
        """Free it."""
        self.file.close()


class _Stream(Line):
    def receive(self) -> bytes:
        payload = super().receive()
        if not payload:
            raise ConnectionResetError("the other end has closed")
        return payload


class _Serial(Line):
    gathers = True

    def receive(self) -> bytes:
        payload = bytes(self.file.read(LARGEST))
        if not payload:
            raise ConnectionResetError("the line is gone")
        return payload

    def send(self, payload: bytes) -> bool:
        self.file.write(payload)
        return True


class _Datagrams(Line):
    def send(self, payload: bytes) -> bool:  # noqa: ARG002 - there is nobody to send to
        return False


def opened(where: Endpoint) -> Line:
    """The endpoint, opened; OSError or ValueError when that is not possible now."""
    if where.kind == "serial":
        import serial

        return _Serial(serial.Serial(where.where, where.number, timeout=0, write_timeout=WAKE_S, exclusive=True))
    address = (where.where.strip("[]"), where.number)
    if where.kind == "udp":
        family, *_, bind = socket.getaddrinfo(*address, type=socket.SOCK_DGRAM)[0]
        listener = socket.socket(family, socket.SOCK_DGRAM)
        try:
            listener.bind(bind)
        except OSError:
            listener.close()
            raise
        return _Datagrams(listener)
    connection = socket.create_connection(address, timeout=CONNECT_S)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in (("TCP_KEEPIDLE", DEAD_S // 2), ("TCP_KEEPINTVL", DEAD_S // 5), ("TCP_KEEPCNT", 3)):
        if hasattr(socket, option):
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)
    return _Stream(connection)


def words(error: Exception) -> str:
    """Why a port is not open, without what changes from try to try."""
    if isinstance(error, TimeoutError):
        return "no answer"
    text = getattr(error, "strerror", None) or str(error)
    return " ".join(str(text).split())
