"""Scans that somebody else's driver publishes under the boat's own name: the message, and what of it is believed.

The message is a msgpack array, as all others; ranges are float32 with the low byte first, so that a driver hands on the
memory that it has. Angles are + to starboard: who has them the other way round, as ROS has, changes the sign of both.
"""

from __future__ import annotations

import math
from typing import Final

import msgspec
from msgspec import Struct

from fleet.sensing.scan import Scan, cleaned, problem
from fleet.wire.codec import Refused
from fleet.wire.messages import MAJOR

LARGEST = 1 << 16
OLD_S, EARLY_S = 1.0, 0.2


class PublishedScan(Struct, frozen=True, array_like=True, gc=False):
    """One turn of a planar scanner, or a part of one."""

    major: int
    stamp_ns: int  # UTC when the first beam was measured; 0: just before it arrived
    first_rad: float  # bearing of the first beam from the scanner's front, + to starboard
    increment_rad: float  # from beam to beam, + to starboard
    ranges: bytes  # float32 each, low byte first [m]; NaN, infinite or out of the two below: no return
    range_min_m: float
    range_max_m: float
    beam_s: float = 0.0  # from beam to beam
    ahead_m: float = 0.0  # where the scanner is, from the point whose position is the boat's
    starboard_m: float = 0.0
    yaw_rad: float = 0.0  # bearing of its front from the bow, + to starboard


_decoder: Final = msgspec.msgpack.Decoder(PublishedScan)
encode: Final = msgspec.msgpack.Encoder().encode
"""A message as bytes."""


def decode_scan(payload: bytes, at_ns: int, scanner: str = "") -> Scan:
    """The scan in the payload; Refused, with the reason in a word or two, when it cannot be true.

    Args:
        payload: as it came
        at_ns: when it came, by the agent's clock
        scanner: its name
    """
    if len(payload) > LARGEST:
        raise Refused("too large")
    try:
        said = _decoder.decode(payload)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        raise Refused("does not decode") from None
    if said.major != MAJOR:
        raise Refused("another wire version")
    if not (math.isfinite(said.range_min_m) and 0.0 <= said.range_min_m < said.range_max_m):
        raise Refused("impossible range")
    scan = Scan(
        stamp_ns=said.stamp_ns,
        first_rad=said.first_rad,
        increment_rad=said.increment_rad,
        ranges=said.ranges,
        range_max_m=said.range_max_m,
        beam_s=said.beam_s,
        ahead_m=said.ahead_m,
        starboard_m=said.starboard_m,
        yaw_rad=said.yaw_rad,
        scanner=scanner,
    )
    if problem(scan):
        raise Refused("impossible scan")
    stamp_ns = said.stamp_ns or at_ns - round(scan.seconds * 1e9)
    age_s = (at_ns - stamp_ns) * 1e-9
    if not -EARLY_S <= age_s <= OLD_S:
        raise Refused("old, or from the future")
    ranges = cleaned(said.ranges, max(said.range_min_m, 1e-3), said.range_max_m)
    return msgspec.structs.replace(scan, stamp_ns=stamp_ns, ranges=ranges)
