"""The seam between an agent and a boat's hardware."""

from __future__ import annotations

import math
from typing import Protocol, runtime_checkable

from msgspec import Struct

from fleet.sensing.scan import Scan

__all__ = ["Driver", "Observed", "Reading", "Scan", "Sensor", "Sighting"]


class Sighting(Struct, frozen=True, array_like=True, gc=False):
    """One report of a vessel that is not of the fleet."""

    stamp_ns: int  # when it was measured, by the agent's clock
    source: str  # "ais": the vessel's own words; "positions": seen by a sensor of ours; "scan": by a laser scanner
    name: str  # of the vessel; "": a bare position, and whose it is must be found out
    lat_deg: float
    lon_deg: float
    position_error_m: float  # 1 sigma per axis
    v_north_mps: float = math.nan  # velocity over ground
    v_east_mps: float = math.nan
    length_m: float = math.nan


class Reading(Struct, frozen=True, gc=False):
    """What a driver knows of its boat; the stamp tells how old it is."""

    stamp_ns: int  # when it was measured, by the agent's clock; 0 nothing yet
    lat_deg: float = math.nan
    lon_deg: float = math.nan
    heading_rad: float = math.nan
    v_north_mps: float = math.nan  # velocity over ground
    v_east_mps: float = math.nan
    yaw_rate_radps: float = math.nan
    position_error_m: float = 0.0  # 1 sigma
    battery_percent: float = math.nan
    authority: str = ""  # who commands the boat if we do not: "pilot", "failsafe RTL", ...
    trouble: str = ""  # why the boat cannot be commanded
    sightings: tuple[Sighting, ...] = ()  # reports since the last reading
    raw: bool = False  # straight from the sensors, to be fused: each may be missing (NaN), and has its error and stamp
    velocity_error_mps: float = 0.0  # 1 sigma per axis
    heading_error_rad: float = 0.0  # 1 sigma
    heading_stamp_ns: int = 0  # when the heading was measured; 0: with the rest
    yaw_rate_stamp_ns: int = 0
    scans: tuple[Scan, ...] = ()  # since the last reading
    amiss: tuple[str, ...] = ()  # sensors that give nothing, and why; the boat sails on with the others


class Observed(Struct, frozen=True, gc=False):
    """What one sensor has to say since it was asked last; nothing is said twice. Unknown is NaN, a stamp 0."""

    fix_ns: int = 0  # when position and velocity were measured, by the agent's clock; 0: no new one
    lat_deg: float = math.nan
    lon_deg: float = math.nan
    position_error_m: float = math.nan  # 1 sigma per axis
    v_north_mps: float = math.nan  # velocity over ground; NaN where the sensor has positions only
    v_east_mps: float = math.nan
    velocity_error_mps: float = math.nan  # 1 sigma per axis
    heading_ns: int = 0
    heading_rad: float = math.nan
    heading_error_rad: float = math.nan  # 1 sigma
    yaw_rate_ns: int = 0
    yaw_rate_radps: float = math.nan  # + to starboard
    sightings: tuple[Sighting, ...] = ()
    scans: tuple[Scan, ...] = ()
    trouble: str = ""  # why it gives nothing, in words that stay the same while it lasts


class Sensor(Protocol):
    """Something that measures, beside the driver that steers. Nothing here blocks, nothing raises while under way."""

    gives: frozenset[str]
    """Of "fix", "heading", "yaw-rate", "traffic", "scan"; what it may ever give."""

    def open(self) -> None:
        """Connect; ConfigError when that can never work. One that is absent for now is trouble, and tried again."""

    def read(self, now_ns: int) -> Observed:
        """What is new."""

    def close(self) -> None:
        """Disconnect."""


@runtime_checkable
class Informed(Protocol):
    """A driver that steers by how the boat moves, and whose hardware may not know it: the agent tells it every tick."""

    def moves(self, stamp_ns: int, surge_mps: float, yaw_rate_radps: float) -> None:
        """How the boat moves: over ground along the heading, and turning."""


class Driver(Protocol):
    """A boat that can be steered. Nothing here blocks, nothing raises while under way."""

    simulated: bool

    def open(self) -> None:
        """Connect; FleetError when the configuration cannot work."""

    def read(self) -> Reading:
        """The newest reading."""

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command surge over ground along the heading, and yaw rate; '' or why it could not be done."""

    def neutral(self) -> None:
        """No thrust; the boat drifts."""

    def close(self) -> None:
        """Leave the boat in neutral and disconnect."""


@runtime_checkable
class PassesOn(Protocol):
    """A driver whose autopilot speaks MAVLink, and may be seen by ground stations as it is."""

    @property
    def sysid(self) -> int:
        """Of the autopilot; 0: nothing is passed on."""

    @property
    def takes_frames(self) -> bool:
        """Whether ground stations may speak to it."""

    def hand_in(self, frames: bytes) -> str:
        """A ground station listens; its frames for the autopilot, if any. '' or why they do not go on."""

    def handed_on(self) -> bytes:
        """Frames of the autopilot since the last call, as they came."""
