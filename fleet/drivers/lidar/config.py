"""What a boat's configuration says about a laser scanner."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

Metres = Annotated[float, Meta(ge=-50.0, le=50.0)]
Degrees = Annotated[float, Meta(ge=-360.0, le=360.0)]
Bearing = Annotated[float, Meta(ge=-180.0, le=180.0)]


class Mounting(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the scanner is, and what of it is blind."""

    ahead_m: Metres = 0.0  # from the point whose position is the boat's
    starboard_m: Metres = 0.0
    yaw_deg: Degrees = 0.0  # bearing of its front from the bow, + to starboard
    inverted: bool = False  # it hangs upside down
    range_min_m: Annotated[float, Meta(ge=0.0, le=100.0)] = 0.0  # nearer returns are none
    range_max_m: Annotated[float, Meta(gt=0.0, le=1000.0)] = 1000.0  # farther ones too
    blind_deg: tuple[tuple[Bearing, Bearing], ...] = ()  # sectors from the bow, + to starboard, clockwise from-to


class LidarOptions(Mounting, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`options` of a sensor of kind `lidar`."""

    rate_hz: Annotated[float, Meta(gt=0.0, le=100.0)] = 10.0  # of scans, at most; the scanner leaves out the others
    command: Literal["MD", "MS", "ME", "GD", "GS", "GE"] = "MD"  # M goes on by itself, G is asked each time
    cluster: Annotated[int, Meta(ge=1, le=99)] = 1  # so many steps give one distance, the least
    from_deg: Bearing = -180.0  # what is measured, from the scanner's front, + to its starboard
    to_deg: Bearing = 180.0
    synchronise: bool = True  # ask the scanner for its time before it measures


class ScanOptions(Mounting, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`options` of a sensor of kind `scan`: somebody else's driver publishes."""

    key: Annotated[str, Meta(pattern=r"^[a-z0-9-]{1,32}(/[a-z0-9-]{1,32})?\Z")] = "scan"  # under the boat's own name
