"""A scanner in its place on the boat: blind sectors and ranges taken out. Pure."""

from __future__ import annotations

import math

from msgspec.structs import replace

from fleet.drivers.lidar.config import Mounting
from fleet.sensing.scan import Scan, cleaned

TURN = 2.0 * math.pi


def mounted(scan: Scan, mounting: Mounting) -> Scan:
    """The scan as the boat has it.

    Args:
        scan: in the scanner's own frame; where it says a place on the boat, that is kept and the mounting added
        mounting: where the scanner is
    """
    sign = -1.0 if mounting.inverted else 1.0
    most = min(mounting.range_max_m, scan.range_max_m)
    one = replace(
        scan,
        first_rad=sign * scan.first_rad,
        increment_rad=sign * scan.increment_rad,
        ahead_m=scan.ahead_m + mounting.ahead_m,
        starboard_m=scan.starboard_m + mounting.starboard_m,
        yaw_rad=math.remainder(scan.yaw_rad + math.radians(mounting.yaw_deg), TURN),
        range_max_m=most,
    )
    least = max(mounting.range_min_m, 1e-3)
    return replace(one, ranges=_without(one, mounting.blind_deg, cleaned(one.ranges, least, most)))


def _without(scan: Scan, sectors: tuple[tuple[float, float], ...], ranges: bytes) -> bytes:
    """The ranges with NaN in blind sectors."""
    if not sectors:
        return ranges
    import numpy as np

    values = np.frombuffer(ranges, dtype="<f4").copy()
    bearing = scan.yaw_rad + scan.first_rad + scan.increment_rad * np.arange(len(values), dtype=np.float64)
    for start, end in sectors:
        width = math.radians((end - start) % 360.0) if end != start else 0.0
        inside = (bearing - math.radians(start)) % TURN <= width
        values[inside] = math.nan
    return values.tobytes()
