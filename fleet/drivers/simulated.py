"""The driver of a simulated boat: datagrams on loopback to and from the world process.

The world goes neutral by itself when no set-point arrives for a second, as a thruster controller does.
"""

from __future__ import annotations

import contextlib
import socket

import msgspec
from msgspec import Struct

from fleet.drivers.seam import Reading, Sighting
from fleet.errors import ConfigError

LARGEST = 32768
MOST_SIGHTINGS = 256  # kept while nobody reads


class Setpoint(Struct, frozen=True, array_like=True, tag="set"):
    """Agent to world: what the thrusters are to do."""

    boat: str
    powered: bool
    surge_mps: float
    yaw_rate_radps: float


class Sensed(Struct, frozen=True, array_like=True, tag="sensed"):
    """World to agent: what the boat's sensors and radio say."""

    reading: Reading
    radio_delay_s: float
    radio_loss: float
    radio_down: bool


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(Sensed).decode


class SimulatedDriver:
    """See `fleet.drivers.seam.Driver`."""

    simulated = True

    def __init__(self, boat: str, world: str) -> None:
        host, _, port = world.rpartition(":")
        if not host or not port.isdigit() or not 0 < int(port) < 65536:
            raise ConfigError(f"driver.world {world!r}: expected HOST:PORT of a world process, such as 127.0.0.1:5000")
        self._boat, self._world = boat, (host, int(port))
        self._socket: socket.socket | None = None
        self.sensed = Sensed(Reading(stamp_ns=0), 0.0, 0.0, False)

    def open(self) -> None:
        """Connect to the world."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.connect(self._world)
        self.neutral()

    def read(self) -> Reading:
        """The newest reading, with the sightings of those before it; datagrams that do not decode are passed over."""
        sightings: list[Sighting] = []
        if self._socket is not None:
            with contextlib.suppress(BlockingIOError, ConnectionRefusedError):
                while True:
                    payload = self._socket.recv(LARGEST)
                    with contextlib.suppress(msgspec.DecodeError):
                        self.sensed = _decode(payload)
                        sightings += self.sensed.reading.sightings
        reading = self.sensed.reading
        if not sightings and not reading.sightings:
            return reading
        return msgspec.structs.replace(reading, sightings=tuple(sightings[-MOST_SIGHTINGS:]))

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command the boat."""
        return self._send(Setpoint(self._boat, True, surge_mps, yaw_rate_radps))

    def neutral(self) -> None:
        """No thrust."""
        self._send(Setpoint(self._boat, False, 0.0, 0.0))

    def _send(self, setpoint: Setpoint) -> str:
        if self._socket is None:
            return "not connected to the world"
        try:
            self._socket.send(_encode(setpoint))
        except ConnectionRefusedError:
            return "the world does not answer"
        except OSError as error:
            return f"the world cannot be reached: {error.strerror}"
        return ""

    def close(self) -> None:
        """Leave the boat in neutral."""
        self.neutral()
        if self._socket is not None:
            self._socket.close()
            self._socket = None
