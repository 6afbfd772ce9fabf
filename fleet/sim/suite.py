"""The sensors of a simulated boat as they are on the water: sentences of NMEA 0183 and AIS, to a port of its agent.

The agent then reads them as it would a real receiver's. Its link to the world keeps what has no sentence: battery,
thrusters that do not answer, the weather of the radio, bare positions of other vessels.
"""

from __future__ import annotations

import contextlib
import math
import socket
from typing import Any, Literal
from zlib import crc32

from fleet.drivers.ais import codec as ais
from fleet.drivers.nmea import encode as nmea
from fleet.drivers.seam import Reading, Sighting
from fleet.mission.model import Environment

SensorKind = Literal["simulated", "nmea"]
FIX_EVERY = 2  # readings of 20 Hz: a receiver of 10 Hz; compass and turn indicator speak with each
STATIC_EVERY = 10  # reports of a vessel: its name and size with every tenth
CLASS_A_M = 20.0  # longer vessels have a transponder of class A
ACCURATE_M = 4.0
SILENT_S = 3.0
LEAST_MPS, LEAST_DEG = 0.02, 0.3
FIXED_M, DGPS_M, FREE_M = 0.02, 0.8, 1.5  # errors at HDOP 1 that the agent takes by default
FOREIGN_FIRST, FOREIGN_COUNT = 247_000_000, 1_000_000


def must_have_sensors(kind: SensorKind) -> None:
    """ConfigError where the libraries are not installed."""
    if kind == "nmea":
        ais.must_have_pyais("nmea")


def mmsi_of(vessel: str) -> int:
    """The identity of a vessel that is not of the fleet."""
    return FOREIGN_FIRST + crc32(vessel.encode()) % FOREIGN_COUNT


class Spoken:
    """What one boat's receiver, compass, turn indicator and AIS receiver say on one line."""

    def __init__(self) -> None:
        self._readings = 0
        self._reports: dict[str, int] = {}

    def say(self, reading: Reading) -> tuple[list[bytes], Reading]:
        """The sentences that are due with a reading; what is left for the link to the world."""
        self._readings += 1
        lines = self._fix(reading) if self._readings % FIX_EVERY == 0 else []
        lines += [nmea.hdt(reading.heading_rad), nmea.rot(reading.yaw_rate_radps)]
        rest = []
        for one in reading.sightings:
            if one.source == "ais":
                lines += self._ais(one)
            else:
                rest.append(one)
        left = Reading(
            0, battery_percent=reading.battery_percent, trouble=reading.trouble, sightings=tuple(rest), raw=True
        )
        return lines, left

    def _fix(self, reading: Reading) -> list[bytes]:
        error_m = reading.position_error_m
        quality, at_one = (4, FIXED_M) if error_m < 0.06 else (2, DGPS_M) if error_m < 2.0 else (1, FREE_M)
        stamp_ns, lat, lon = reading.stamp_ns, reading.lat_deg, reading.lon_deg
        return [
            nmea.gga(stamp_ns, lat, lon, quality, max(error_m / at_one, 0.5)),
            nmea.rmc(stamp_ns, lat, lon, reading.v_north_mps, reading.v_east_mps),
        ]

    def _ais(self, one: Sighting) -> list[bytes]:
        """A vessel's report, now and then with its name and size."""
        mmsi, count = mmsi_of(one.name), self._reports.get(one.name, 0)
        self._reports[one.name] = count + 1
        sized = math.isfinite(one.length_m)
        class_a = sized and one.length_m > CLASS_A_M
        lines = []
        if sized and count % STATIC_EVERY == 0:
            lines += ais.static_report(mmsi, one.name, one.length_m, 0.25 * one.length_m, class_a=class_a)
        accurate, second = one.position_error_m <= ACCURATE_M, one.stamp_ns // 1_000_000_000
        lines += ais.position_report(
            mmsi, one.lat_deg, one.lon_deg, one.v_north_mps, one.v_east_mps, math.nan,
            accurate=accurate, second=second, class_a=class_a,
        )  # fmt: skip
        return lines


class Suite:
    """The same on a port of the boat's agent."""

    def __init__(self, environment: Environment, warp: float = 1.0) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.connect(("127.0.0.1", _free_udp_port()))
        self._spoken = Spoken()
        port = self._socket.getpeername()[1]
        options = {
            "velocity_error_mps": max(environment.gnss_velocity_mps, LEAST_MPS),
            "heading_error_deg": max(environment.heading_noise_deg, LEAST_DEG),
        }
        where = f"udp:127.0.0.1:{port}"
        silent_s = max(SILENT_S, warp)  # a busy machine may stall for a second
        self.keys: list[dict[str, Any]] = [
            {"kind": "nmea", "endpoint": where, "silent_s": silent_s, "options": options}
        ]

    def tell(self, reading: Reading) -> Reading:
        """Say what has a sentence; what is left for the link to the world."""
        lines, left = self._spoken.say(reading)
        own = b"".join(line for line in lines if line.startswith(b"$"))
        for payload in (own, *(line for line in lines if not line.startswith(b"$"))):
            with contextlib.suppress(BlockingIOError, ConnectionRefusedError):
                self._socket.send(payload)
        return left

    def close(self) -> None:
        """Free the port."""
        self._socket.close()


def _free_udp_port() -> int:
    """A port that nobody uses just now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
