"""Scans that somebody else's driver publishes: the message byte for byte, and what is not believed."""

from __future__ import annotations

import math

import msgspec
import pytest
from msgspec.structs import replace

from fleet.sensing.scan import packed, unpacked
from fleet.wire.codec import Refused
from fleet.wire.messages import MAJOR
from fleet.wire.scans import PublishedScan, decode_scan, encode

NOW_NS = 1_700_000_000_000_000_000
MS = 1_000_000
SAID = PublishedScan(
    MAJOR, NOW_NS - 100 * MS, 2.0, -0.01, packed([1.0, math.nan, 50.0, 0.05]), 0.1, 40.0, 1e-4, 0.5, -0.2, 0.1
)


def test_a_message_is_an_array_that_any_msgpack_library_can_write() -> None:
    plain = [1, SAID.stamp_ns, 2.0, -0.01, packed([1.0, math.nan, 50.0, 0.05]), 0.1, 40.0, 1e-4, 0.5, -0.2, 0.1]
    assert msgspec.msgpack.encode(plain) == encode(SAID)
    short = decode_scan(msgspec.msgpack.encode(plain[:7]), NOW_NS)  # the last four may be left out
    assert (short.beam_s, short.ahead_m, short.yaw_rad) == (0.0, 0.0, 0.0)


def test_what_is_believed_is_a_scan_with_no_return_where_there_is_none() -> None:
    scan = decode_scan(encode(SAID), NOW_NS, "bow")
    assert scan.stamp_ns == NOW_NS - 100 * MS
    assert (scan.first_rad, scan.increment_rad, scan.range_max_m, scan.beam_s) == (2.0, -0.01, 40.0, 1e-4)
    assert (scan.ahead_m, scan.starboard_m, scan.yaw_rad, scan.scanner) == (0.5, -0.2, 0.1, "bow")
    assert [one for one in unpacked(scan.ranges) if not math.isnan(one)] == [1.0]


def test_a_scan_without_a_stamp_was_measured_just_before_it_came() -> None:
    scan = decode_scan(encode(replace(SAID, stamp_ns=0, beam_s=0.01)), NOW_NS)
    assert scan.stamp_ns == NOW_NS - 30 * MS


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"major": 2}, "another wire version"),
        ({"stamp_ns": NOW_NS - 1100 * MS}, "old, or from the future"),
        ({"stamp_ns": NOW_NS + 300 * MS}, "old, or from the future"),
        ({"stamp_ns": -5}, "old, or from the future"),
        ({"first_rad": math.nan}, "impossible scan"),
        ({"increment_rad": 0.0}, "impossible scan"),
        ({"increment_rad": 3.0}, "impossible scan"),
        ({"ranges": b"12345"}, "impossible scan"),
        ({"ranges": b""}, "impossible scan"),
        ({"range_min_m": 40.0}, "impossible range"),
        ({"range_min_m": math.nan}, "impossible range"),
        ({"range_max_m": math.inf}, "impossible scan"),
        ({"beam_s": 1.0}, "impossible scan"),
        ({"ahead_m": 1e6}, "impossible scan"),
        ({"ranges": bytes(1 << 16)}, "too large"),
    ],
)
def test_a_scan_that_cannot_be_true_is_refused_with_the_reason(wrong: dict[str, object], why: str) -> None:
    with pytest.raises(Refused, match=why):
        decode_scan(encode(replace(SAID, **wrong)), NOW_NS)


@pytest.mark.parametrize("payload", [b"", b"\x00", b"not msgpack", msgspec.msgpack.encode([1, "now"]), b"\xdc\xff\xff"])
def test_what_does_not_decode_is_refused(payload: bytes) -> None:
    with pytest.raises(Refused, match="does not decode"):
        decode_scan(payload, NOW_NS)
