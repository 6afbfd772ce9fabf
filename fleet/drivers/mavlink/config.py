"""What a boat's configuration says about its autopilot."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

from fleet.drivers.mavlink.link import link_to
from fleet.errors import ConfigError


class MavlinkConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`[driver.mavlink]`; what a schema cannot say is said by `check`."""

    endpoint: str = ""  # udp:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT or serial:DEVICE:BAUD
    sysid: Annotated[int, Meta(ge=1, le=255)] = 1  # of the autopilot: MAV_SYSID
    own_sysid: Annotated[int, Meta(ge=1, le=255)] = 254  # ours: MAV_GCS_SYSID, for the ground station failsafe
    arm: Literal["never", "operator"] = "never"  # whether we may arm the boat when an operator sets it off
    stop: Literal["loiter", "hold"] = "loiter"  # how a boat that is stopped is left: on station, or without thrust
    signing_key: str = ""  # file with a passphrase; empty: nothing is signed
    forward: Literal["off", "out", "both"] = "off"  # the autopilot's frames to `fleet gcs`; "both": and back

    def check(self) -> None:
        """ConfigError when it cannot work."""
        if not self.endpoint:
            raise ConfigError(
                "driver.mavlink.endpoint: missing; expected where the autopilot is, such as udp:127.0.0.1:14550"
            )
        link_to(self.endpoint)
        if self.sysid == self.own_sysid:
            raise ConfigError(f"driver.mavlink.own_sysid = {self.own_sysid}: the autopilot's sysid; expected another")
