"""The seam between an agent and a boat's hardware."""

from __future__ import annotations

import math
from typing import Protocol

from msgspec import Struct


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
