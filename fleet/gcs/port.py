"""UDP sockets to ground stations: the one file of the bridge that has any.

udp:HOST:PORT      we speak first, to a ground station that listens there; only that address is heard
udpin:HOST:PORT    we listen there; who speaks is answered, and told everything while it goes on speaking
"""

from __future__ import annotations

import contextlib
import ipaddress
import select
import socket
from collections.abc import Iterable, Iterator, Sequence

from fleet.errors import ConfigError
from fleet.gcs.seat import Peer

DEFAULT = ("udp:127.0.0.1:14550",)
LARGEST = 65535
LARGEST_SENT = 1400  # of several frames in one datagram: whole on every network that has packets of 1500 bytes
MOST_DATAGRAMS = 256  # of one socket in one look
GUEST_S = 10.0  # who said nothing for so long is told nothing more
MOST_GUESTS = 8
REFUSED_S = 0.5  # a station that is not there is tried again after so long

Address = tuple[str, int]


def parse(text: str) -> tuple[bool, Address]:
    """(whether we listen, where) of an endpoint; ConfigError when it is none."""
    kind, _, rest = text.partition(":")
    host, _, port = rest.rpartition(":")
    if kind in ("udp", "udpin") and host and port.isdigit() and int(port) < 65536 and (int(port) or kind == "udpin"):
        return kind == "udpin", (host.strip("[]"), int(port))
    raise ConfigError(f"endpoint {text!r}: expected udp:HOST:PORT or udpin:HOST:PORT, such as {DEFAULT[0]}")


def is_loopback(host: str) -> bool:
    """Whether nobody else can reach, or be reached, there."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def joined(outgoing: Iterable[tuple[Peer | None, bytes]]) -> Iterator[tuple[Peer | None, bytes]]:
    """The same bytes in fewer datagrams: frames to one peer that follow one another go together, as far as they fit."""
    to: Peer | None = None
    waiting: list[bytes] = []
    size = 0
    for peer, frame in outgoing:
        if waiting and (peer != to or size + len(frame) > LARGEST_SENT):
            yield to, b"".join(waiting)
            waiting, size = [], 0
        to = peer
        waiting.append(frame)
        size += len(frame)
    if waiting:
        yield to, b"".join(waiting)


class _Socket:
    """One endpoint."""

    def __init__(self, text: str) -> None:
        self.listens, address = parse(text)
        try:
            family, *_, where = socket.getaddrinfo(*address, type=socket.SOCK_DGRAM)[0]
            self.socket = socket.socket(family, socket.SOCK_DGRAM)
            self.socket.setblocking(False)
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
            self.socket.bind(where) if self.listens else self.socket.connect(where)
        except OSError as error:
            raise ConfigError(f"endpoint {text}: {error.strerror}") from None
        self.guests: dict[Address, float] = {}
        self.mute_until_s = 0.0

    def receive(self, now_s: float) -> list[tuple[Address | None, bytes]]:
        """(guest, datagram) that arrived; the guest is None at an endpoint of ours."""
        found: list[tuple[Address | None, bytes]] = []
        for _ in range(MOST_DATAGRAMS):
            try:
                payload, address = self.socket.recvfrom(LARGEST)
            except BlockingIOError:
                break
            except OSError:  # nobody listens there just now
                self.mute_until_s = now_s + REFUSED_S
                continue
            found.append((address if self.listens else None, payload))
        return found

    def send(self, datagram: bytes, guest: Address | None, now_s: float) -> None:
        """To the station, or to one guest; what cannot leave now does not leave."""
        if now_s < self.mute_until_s:
            return
        try:
            if guest is not None:
                self.socket.sendto(datagram, guest)
            else:
                self.socket.send(datagram)
        except ConnectionRefusedError:
            self.mute_until_s = now_s + REFUSED_S
        except OSError:
            return

    def present(self, now_s: float) -> list[Address | None]:
        """Whom to tell everything."""
        if not self.listens:
            return [None]
        self.guests = {guest: s for guest, s in self.guests.items() if now_s - s < GUEST_S}
        return list(self.guests)


class Port:
    """All endpoints of a bridge."""

    def __init__(self, endpoints: Sequence[str]) -> None:
        """ConfigError when one cannot be had."""
        self._sockets: list[_Socket] = []
        self._numbers: dict[int, int] = {}  # of sockets, by descriptor
        self._poll = select.poll()
        try:
            for text in endpoints:
                self._sockets.append(_Socket(text))
        except ConfigError:
            self.close()
            raise
        for i, one in enumerate(self._sockets):
            self._poll.register(one.socket, select.POLLIN)
            self._numbers[one.socket.fileno()] = i

    @property
    def numbers(self) -> list[int]:
        """Local ports."""
        return [one.socket.getsockname()[1] for one in self._sockets]

    def wait(self, seconds: float) -> None:
        """Until something arrives, or so long."""
        self._poll.poll(max(0.0, seconds * 1e3))

    def receive(self, now_s: float) -> list[tuple[Peer, bytes]]:
        """(peer, datagram) that arrived."""
        ready = sorted(self._numbers[descriptor] for descriptor, _ in self._poll.poll(0))
        return [((i, guest), payload) for i in ready for guest, payload in self._sockets[i].receive(now_s)]

    def welcome(self, peer: Peer, now_s: float) -> None:
        """A peer said something in MAVLink."""
        i, guest = peer
        guests = self._sockets[i].guests
        if guest is not None and (guest in guests or len(guests) < MOST_GUESTS):
            guests[guest] = now_s

    def send(self, outgoing: Sequence[tuple[Peer | None, bytes]], now_s: float) -> None:
        """Frames to their peers; None: to all."""
        everybody = [(one, guest) for one in self._sockets for guest in one.present(now_s)]
        for peer, datagram in joined(outgoing):
            if peer is None:
                for one, guest in everybody:
                    one.send(datagram, guest, now_s)
            else:
                i, guest = peer
                self._sockets[i].send(datagram, guest, now_s)

    def close(self) -> None:
        """Free the ports."""
        for one in self._sockets:
            with contextlib.suppress(OSError):
                one.socket.close()
