"""The UDP port of a simulated autopilot: real MAVLink on loopback."""

from __future__ import annotations

import socket
from typing import Any

from fleet.drivers.mavlink import words
from fleet.drivers.mavlink.frames import Frames
from fleet.sim.autopilot.rover import Rover
from fleet.sim.autopilot.telemetry import speak

MOST_DATAGRAMS = 256


class Port:
    """Speaks for a Rover with everybody who spoke to it; each peer is a link of its own, with rates of its own."""

    def __init__(self, mavlink: Any, rover: Rover, key: bytes = b"") -> None:
        """Args: key: of 32 bytes, for signed frames only."""
        self.rover = rover
        self._frames = Frames(mavlink)
        self._codec = mavlink.MAVLink(None, srcSystem=rover.sysid, srcComponent=words.AUTOPILOT_COMPONENT)
        for codec in (self._frames.codec, self._codec) if key else ():
            codec.signing.secret_key, codec.signing.sign_outgoing = key, True
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)

    @property
    def number(self) -> int:
        """Of the port."""
        number: int = self._socket.getsockname()[1]
        return number

    def hear(self) -> None:
        """Hand what arrived to the autopilot."""
        for _ in range(MOST_DATAGRAMS):
            try:
                payload, peer = self._socket.recvfrom(65535)
            except BlockingIOError:
                return
            except OSError:  # a peer's port is closed; UDP does not say whose
                continue
            for message in self._frames.datagram(payload):
                self.rover.hear(peer, message)
            ours, theirs = self._codec.signing, self._frames.codec.signing
            ours.timestamp = max(ours.timestamp, theirs.timestamp)  # it learns the time from whoever signs well

    def speak(self) -> None:
        """Send what it has to say."""
        peer: Any
        for peer, message in speak(self.rover):
            frame = bytes(message.pack(self._codec))
            self._codec.seq = (self._codec.seq + 1) % 256
            try:
                self._socket.sendto(frame, peer)
            except BlockingIOError:
                return
            except OSError:
                self.rover.streams.lose(peer)

    def close(self) -> None:
        """Free the port."""
        self._socket.close()
