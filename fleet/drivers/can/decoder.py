"""Bytes to values. Nothing is believed for being well-formed: check sums, counters, and what a boat can do."""

from __future__ import annotations

import binascii
import math
from typing import Any, Literal

from msgspec import Struct

from fleet.drivers.can.frames import (
    CRC_BYTES,
    FAULTS,
    FIX_3D,
    FIX_RTK,
    MODES,
    NO_HEADING,
    NO_RATE,
    NO_VELOCITY,
    Battery,
    Frames,
    Navigation,
    Said,
    Status,
    Watchdog,
    crc16,
)
from fleet.guidance.thrust import Thrusts

SPEED_MOST_MPS, YAW_RATE_MOST_RADPS = 15.0, 3.0  # faster is not believed of such a boat


class Counts(Struct):
    """What became of every frame."""

    accepted: int = 0
    waiting: int = 0  # Position and Motion, which count only with their NavCheck
    foreign: int = 0  # not for us: other identifiers, extended, remote
    length: int = 0
    check: int = 0  # the check sum is wrong, or a navigation set is not whole
    repeated: int = 0  # its counter has not moved
    implausible: int = 0

    @property
    def refused(self) -> int:
        """Frames for us that were not believed."""
        return self.length + self.check + self.repeated + self.implausible


Side = Literal["agent", "controller"]
HEARD: dict[Side, tuple[str, ...]] = {
    "agent": ("Status", "Position", "Motion", "NavCheck", "Battery"),
    "controller": ("Watchdog", "Thrust"),
}


class Decoder:
    """Bytes to values on one side of the bus; whatever comes, it counts and goes on."""

    def __init__(self, frames: Frames, side: Side) -> None:
        self.counts = Counts()
        self._frames = frames
        self._heard = {frames.message(name).frame_id: name for name in HEARD[side]}
        self._lengths = {frames.message(name).frame_id: frames.message(name).length for name in HEARD[side]}
        self._last: dict[str, int] = {}
        self._place = self._moves = b""

    def take(self, identifier: int, payload: bytes, *, plain: bool = True) -> Said | None:
        """What a frame says; None when it says nothing yet, is not for us, or is not believed.

        Args:
            identifier: of 11 bits
            payload: its bytes
            plain: a data frame with an identifier of 11 bits
        """
        name = self._heard.get(identifier) if plain else None
        counts = self.counts
        if name is None:
            counts.foreign += 1
        elif len(payload) != self._lengths[identifier]:
            counts.length += 1
        elif name == "Position":
            self._place = payload
            counts.waiting += 1
        elif name == "Motion":
            self._moves = payload
            counts.waiting += 1
        elif name == "NavCheck":
            return self._navigation(payload)
        elif crc16(identifier, payload[:-CRC_BYTES]) != int.from_bytes(payload[-CRC_BYTES:], "little"):
            counts.check += 1
        else:
            return self._single(name, self._frames.message(name).decode(payload, decode_choices=False))
        return None

    def _single(self, name: str, s: dict[str, Any]) -> Said | None:
        if "Counter" in s and self._repeated(name, s["Counter"]):
            return None
        said: Said | None = None
        if name == "Watchdog":
            said = Watchdog(s["Counter"], s["Run"] == 1)
        elif name == "Thrust":
            said = Thrusts(s["RearPort"], s["RearStarboard"], s["SidePort"], s["SideStarboard"])
        elif name == "Status" and s["Mode"] < len(MODES):
            faults = frozenset(words for signal, words in FAULTS.items() if s[signal])
            said = Status(s["Counter"], s["Mode"], s["RcOverride"] == 1, s["WatchdogSeen"] == 1, faults)
        elif name == "Battery" and (s["Percent"] <= 100 or s["Percent"] == 255):
            percent = math.nan if s["Percent"] == 255 else float(s["Percent"])
            said = Battery(s["Counter"], percent, s["Voltage"], s["Current"])
        return self._count(said)

    def _navigation(self, check: bytes) -> Navigation | None:
        place, moves = self._place, self._moves
        self._place = self._moves = b""
        whole = binascii.crc32(place + moves + check[:4]) == int.from_bytes(check[4:], "little")
        if not (place and moves and whole):
            self.counts.check += 1
            return None
        decoded = {
            **self._decoded("Position", place),
            **self._decoded("Motion", moves),
            **self._decoded("NavCheck", check),
        }
        if self._repeated("NavCheck", decoded["Counter"]):
            return None
        nav = _navigation(decoded)
        self._count(nav if plausible(nav) else None)
        return nav if plausible(nav) else None

    def _decoded(self, name: str, payload: bytes) -> dict[str, Any]:
        decoded: dict[str, Any] = self._frames.message(name).decode(payload, decode_choices=False)
        return decoded

    def _repeated(self, name: str, counter: int) -> bool:
        again = self._last.get(name) == counter
        self._last[name] = counter
        self.counts.repeated += again
        return again

    def _count(self, said: Said | None) -> Said | None:
        if said is None:
            self.counts.implausible += 1
        else:
            self.counts.accepted += 1
        return said


def plausible(nav: Navigation) -> bool:
    """A boat can be there, and move like that."""
    at_zero = nav.lat_deg == nav.lon_deg == 0.0
    off_the_globe = abs(nav.lat_deg) > 90.0 or abs(nav.lon_deg) > 180.0
    too_fast = math.hypot(nav.v_north_mps, nav.v_east_mps) > SPEED_MOST_MPS
    spins = abs(nav.yaw_rate_radps) > YAW_RATE_MOST_RADPS or nav.heading_rad > 6.28325
    return not (at_zero or off_the_globe or too_fast or spins) and nav.fix <= FIX_RTK


def _navigation(s: dict[str, Any]) -> Navigation:
    """A 2D fix is none: its height is guessed, and its position is wrong by as much."""
    fixed = s["Fix"] >= FIX_3D
    return Navigation(
        counter=s["Counter"],
        fix=s["Fix"],
        fused=s["Fused"] == 1,
        lat_deg=s["Latitude"] if fixed else math.nan,
        lon_deg=s["Longitude"] if fixed else math.nan,
        heading_rad=s["Heading"] if s["Heading"] < NO_HEADING - 1e-5 else math.nan,
        yaw_rate_radps=s["YawRate"] if s["YawRate"] > NO_RATE + 1e-5 else math.nan,
        v_north_mps=s["VelocityNorth"] if fixed and s["VelocityNorth"] > NO_VELOCITY + 1e-4 else math.nan,
        v_east_mps=s["VelocityEast"] if fixed and s["VelocityEast"] > NO_VELOCITY + 1e-4 else math.nan,
        position_error_m=s["PositionError"],
    )
