"""One turn of a planar laser scanner: the seam between what measures ranges and what makes something of them.

Bearings are positive to starboard, as everywhere. A scanner that turns to port, as most do, has a negative increment:
beams stand in the order in which they were measured.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterable

from msgspec import Struct

MOST_BEAMS = 8192
FARTHEST_M = 1000.0
TURN = 2.0 * math.pi
SLACK_RAD = 0.02  # by which a whole turn may be exceeded: angles come rounded
BYTES_A_RANGE = 4


class Scan(Struct, frozen=True, gc=False):
    """Ranges by bearing, and where on the boat they were measured from."""

    stamp_ns: int  # when the first beam was measured, by the agent's clock
    first_rad: float  # bearing of the first beam from the scanner's front, + to starboard
    increment_rad: float  # from beam to beam, + to starboard
    ranges: bytes  # float32 each, low byte first [m]; NaN: no return
    range_max_m: float  # the scanner sees no farther
    beam_s: float = 0.0  # from beam to beam
    ahead_m: float = 0.0  # where the scanner is, from the boat's centre
    starboard_m: float = 0.0
    yaw_rad: float = 0.0  # bearing of the scanner's front from the bow, + to starboard
    scanner: str = ""  # its name

    @property
    def beams(self) -> int:
        """How many."""
        return len(self.ranges) // BYTES_A_RANGE

    @property
    def seconds(self) -> float:
        """From the first beam to the last."""
        return max(self.beams - 1, 0) * self.beam_s


def packed(ranges: Iterable[float]) -> bytes:
    """Ranges [m] as a scan keeps them."""
    values = array("f", ranges)
    if _BIG_ENDIAN:
        values.byteswap()
    return values.tobytes()


def unpacked(ranges: bytes) -> list[float]:
    """The same ranges as numbers [m]."""
    values = array("f")
    values.frombytes(ranges)
    if _BIG_ENDIAN:
        values.byteswap()
    return values.tolist()


_BIG_ENDIAN = array("H", [1]).tobytes() == b"\0\1"


def problem(scan: Scan) -> str:
    """Why there cannot be such a scan, apart from its time; '' when there can."""
    if len(scan.ranges) % BYTES_A_RANGE or not 0 < scan.beams <= MOST_BEAMS:
        return f"{len(scan.ranges)} bytes of ranges: expected 4 for each of 1 to {MOST_BEAMS} beams"
    numbers = scan.first_rad + scan.increment_rad + scan.beam_s + scan.ahead_m + scan.starboard_m + scan.yaw_rad
    if not math.isfinite(numbers + scan.range_max_m):
        return "a number that is not finite"
    if abs(scan.first_rad) > TURN or abs(scan.yaw_rad) > TURN:
        return "an angle beyond a whole turn"
    if not 0.0 < abs(scan.increment_rad) <= math.pi or abs(scan.increment_rad) * (scan.beams - 1) > TURN + SLACK_RAD:
        return f"increment of {scan.increment_rad:g} rad: {scan.beams} beams of it are not part of one turn"
    if not 0.0 < scan.range_max_m <= FARTHEST_M:
        return f"range_max_m of {scan.range_max_m:g}: expected above 0 to {FARTHEST_M:g}"
    if not 0.0 <= scan.beam_s <= 1.0 or scan.seconds > 1.0:
        return f"a turn of {scan.seconds:g} s: expected 0 to 1"
    if max(abs(scan.ahead_m), abs(scan.starboard_m)) > 100.0:
        return "a scanner more than 100 m from the boat's centre"
    return ""


def cleaned(ranges: bytes, least_m: float, most_m: float) -> bytes:
    """The ranges with NaN for everything below the least or beyond the most [m], infinite ones too."""
    import numpy as np

    values = np.frombuffer(ranges, dtype="<f4")
    with np.errstate(invalid="ignore"):
        seen = (values >= least_m) & (values <= most_m)
    return np.where(seen, values, np.float32(math.nan)).astype("<f4").tobytes()
