"""Bytes to and from an autopilot: UDP, TCP or a serial line, without a thread and without waiting.

    udp:HOST:PORT      we speak first, to that address
    udpin:HOST:PORT    we listen there, and answer whoever spoke last
    tcp:HOST:PORT
    serial:DEVICE:BAUD

What cannot leave at once is not sent at all: a set-point that waited in a queue is an old command.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import socket
import struct
import termios
import tty
from typing import Protocol

from fleet.errors import ConfigError

LARGEST = 65535
MOST_DATAGRAMS = 128  # in one look; the rest waits for the next
MOST_BYTES = 1 << 16  # so; 4 ms of work if all of it is noise
MOST_UNSENT = 256  # bytes: five set-points; 44 ms at 57,600 baud
CONNECT_S, AGAIN_S = 3.0, 0.05  # for a TCP connection: the first one, and one after a loss
EXPECTED = "udp:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT or serial:DEVICE:BAUD, such as udp:127.0.0.1:14550"


class Link(Protocol):
    """A way to an autopilot."""

    datagrams: bool
    """Whether each piece received holds whole frames."""

    @property
    def up(self) -> bool:
        """Whether it is open; a stream that was lost is not."""

    def open(self) -> None:
        """Connect; ConfigError when that cannot work."""

    def receive(self) -> list[bytes]:
        """What arrived."""

    def send(self, frame: bytes) -> str:
        """Send a whole frame now or not at all; '' or why not."""

    def close(self) -> None:
        """Disconnect."""


def link_to(endpoint: str) -> Link:
    """The link that an endpoint means; ConfigError when it means none."""
    kind, _, rest = endpoint.partition(":")
    where, _, number = rest.rpartition(":")
    if kind in ("udp", "udpin", "tcp") and where and number.isdigit() and 0 <= int(number) < 65536:
        address = (where.strip("[]"), int(number))
        if address[1] > 0 or kind == "udpin":
            return TcpLink(address) if kind == "tcp" else UdpLink(address, listens=kind == "udpin")
    if kind == "serial" and where and number.isdigit() and f"B{number}" in dir(termios):
        return SerialLink(where, int(number))
    raise ConfigError(f"driver.mavlink.endpoint {endpoint!r}: expected {EXPECTED}")


class UdpLink:
    """Datagrams."""

    datagrams = True

    def __init__(self, address: tuple[str, int], *, listens: bool) -> None:
        self._address, self._listens = address, listens
        self._peer: tuple[str, int] | None = None if listens else address
        self._socket: socket.socket | None = None

    @property
    def up(self) -> bool:
        """Whether it is open."""
        return self._socket is not None

    @property
    def port(self) -> int:
        """Where we listen."""
        assert self._socket is not None
        port: int = self._socket.getsockname()[1]
        return port

    def open(self) -> None:
        """Take a port."""
        try:
            family, *_, address = socket.getaddrinfo(*self._address, type=socket.SOCK_DGRAM)[0]
            self._socket = socket.socket(family, socket.SOCK_DGRAM)
            self._socket.setblocking(False)
            if self._listens:
                self._socket.bind(address)
            else:
                self._socket.connect(address)
        except OSError as error:
            where = f"driver.mavlink.endpoint udp {self._address[0]}:{self._address[1]}"
            raise ConfigError(f"{where}: {error.strerror}") from None

    def receive(self) -> list[bytes]:
        """What arrived."""
        found: list[bytes] = []
        if self._socket is None:
            return found
        room = MOST_BYTES
        for _ in range(MOST_DATAGRAMS):
            if room <= 0:
                break
            try:
                payload, peer = self._socket.recvfrom(LARGEST)
            except BlockingIOError:
                break
            except OSError:  # nobody listens there just now
                continue
            if self._listens:
                self._peer = peer
            found.append(payload)
            room -= len(payload)
        return found

    def send(self, frame: bytes) -> str:
        """Send a frame."""
        if self._socket is None:
            return "not connected to the autopilot"
        if self._peer is None:
            return "no autopilot has spoken yet"
        try:
            self._socket.sendto(frame, self._peer) if self._listens else self._socket.send(frame)
        except ConnectionRefusedError:
            return "the autopilot's port is closed"
        except BlockingIOError:
            return "the link to the autopilot is jammed"
        except OSError as error:  # an address that is ours no more, a socket that was shut: a new one is opened
            self.close()
            return f"the autopilot cannot be reached: {error.strerror}"
        return ""

    def close(self) -> None:
        """Free the port."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class _Stream:
    """Bytes in order through a file descriptor; whole frames go out or none."""

    datagrams = False

    def __init__(self) -> None:
        self._file = -1
        self._trouble = "not connected to the autopilot"
        self._cut = b""  # what is left of a frame of which a part has left

    @property
    def up(self) -> bool:
        """Whether it is open and not lost."""
        return self._file >= 0

    def open(self) -> None:
        """Connect."""
        raise NotImplementedError

    def receive(self) -> list[bytes]:
        """What arrived."""
        if self._file < 0:
            return []
        try:
            payload = os.read(self._file, MOST_BYTES)
        except BlockingIOError:
            return []
        except OSError as error:
            self._lose(error.strerror or "error")
            return []
        if not payload:
            self._lose("the other end has closed")
        return [payload] if payload else []

    def send(self, frame: bytes) -> str:
        """Send a frame, if nothing older waits."""
        if self._file < 0:
            return self._trouble
        try:
            if self._unsent() > MOST_UNSENT:
                return "the link to the autopilot is jammed"
            if self._cut:
                self._cut = self._cut[os.write(self._file, self._cut) :]
            if self._cut:
                return "the link to the autopilot is jammed"
            self._cut = frame[os.write(self._file, frame) :]
        except BlockingIOError:
            return "the link to the autopilot is jammed"
        except OSError as error:
            self._lose(error.strerror or "error")
            return self._trouble
        return ""

    def _unsent(self) -> int:
        """Bytes that wait in the kernel."""
        count: int = struct.unpack("i", fcntl.ioctl(self._file, termios.TIOCOUTQ, b"\0\0\0\0"))[0]
        return count

    def _lose(self, why: str) -> None:
        self.close()
        self._trouble = f"the link to the autopilot is lost: {why}"

    def close(self) -> None:
        """Disconnect."""
        if self._file >= 0:
            with contextlib.suppress(OSError):
                os.close(self._file)
        self._file, self._cut = -1, b""


class TcpLink(_Stream):
    """A TCP connection."""

    def __init__(self, address: tuple[str, int]) -> None:
        super().__init__()
        self._address, self._patience_s = address, CONNECT_S

    def open(self) -> None:
        """Connect; again, after a loss, without waiting for longer than half a tick."""
        where = f"driver.mavlink.endpoint tcp {self._address[0]}:{self._address[1]}"
        try:
            connection = socket.create_connection(self._address, timeout=self._patience_s)
        except OSError as error:
            raise ConfigError(f"{where}: {error.strerror or 'no answer'}") from None
        finally:
            self._patience_s = AGAIN_S
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._file = connection.detach()


class SerialLink(_Stream):
    """A serial line, 8N1, without flow control."""

    def __init__(self, device: str, baud: int) -> None:
        super().__init__()
        self._device, self._baud = device, baud

    def open(self) -> None:
        """Take the line."""
        try:
            self._file = os.open(self._device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            tty.setraw(self._file)
            mode = termios.tcgetattr(self._file)
            speed = getattr(termios, f"B{self._baud}")
            mode[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
            mode[4] = mode[5] = speed
            mode[6][termios.VMIN], mode[6][termios.VTIME] = 1, 0  # an empty read is then the end of the line
            termios.tcsetattr(self._file, termios.TCSANOW, mode)
        except (OSError, termios.error) as error:
            self.close()
            words = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
            if isinstance(error, termios.error) or getattr(error, "errno", 0) == errno.ENOTTY:
                words = "not a serial line"
            raise ConfigError(f"driver.mavlink.endpoint serial {self._device}: {words}") from None
