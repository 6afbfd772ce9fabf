"""The seam between an agent and a boat's hardware."""

from __future__ import annotations

import math
from typing import Protocol

from msgspec import Struct


class Sighting(Struct, frozen=True, array_like=True, gc=False):
    """One report of a vessel that is not of the fleet."""

    stamp_ns: int  # when it was measured, by the agent's clock
    source: str  # "ais": the vessel's own words; "positions": seen by a sensor of ours
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
