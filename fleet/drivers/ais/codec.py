"""AIS messages in six-bit ASCII to fields, and values to AIVDM sentences. The one file that imports pyais, late."""

from __future__ import annotations

import math
from typing import Any

from fleet.drivers.ais.sentences import Message
from fleet.drivers.nmea.codec import KNOT_MPS, Unusable
from fleet.errors import ConfigError

BITS = {1: 168, 2: 168, 3: 168, 5: 422, 18: 168, 19: 312, 24: 160}
"""Messages that are read, and how long they are at least; a shorter one is cut."""
NO_LATITUDE, NO_LONGITUDE, NO_SPEED, NO_COURSE, NO_HEADING = 91.0, 181.0, 102.3, 360.0, 511
FASTEST_KNOTS = 102.2
SAIL, UNDERWAY = 36, 0


def must_have_pyais(who: str, *, needed: bool = True) -> bool:
    """Whether pyais is installed; ConfigError where it is not and must be."""
    try:
        import pyais  # noqa: F401
    except ImportError:
        if not needed:
            return False
        raise ConfigError(
            f"driver.sensors, {who}: AIS needs pyais, which is not installed; pip install 'fleet-usv[sensors]'"
        ) from None
    return True


def read(message: Message) -> Any:
    """A message as pyais has it; Unusable where it is of no use, cut, or nothing that pyais can read."""
    from pyais.bit_vector import bit_vector
    from pyais.messages import MSG_CLASS

    kind = message.payload[0] - 48 - (8 if message.payload[0] > 87 else 0)
    if kind not in BITS:
        raise Unusable("not used")
    if 6 * len(message.payload) - message.fill < BITS[kind]:
        raise Unusable("cut short")
    try:
        return MSG_CLASS[kind].from_vector(bit_vector(message.payload, message.fill))
    except Exception:  # noqa: BLE001 - whatever a stranger's sentence makes of pyais, it is one bad sentence
        raise Unusable("not readable") from None


def position_report(
    mmsi: int,
    lat_deg: float,
    lon_deg: float,
    v_north_mps: float,
    v_east_mps: float,
    heading_rad: float,
    *,
    accurate: bool,
    second: int,
    class_a: bool = False,
) -> list[bytes]:
    """Where a vessel is and how it goes: message 18, or 1 for class A. NaN is not available."""
    speed = _tenth(math.hypot(v_north_mps, v_east_mps) / KNOT_MPS)
    course = _tenth(math.degrees(math.atan2(v_east_mps, v_north_mps))) % 360.0 if speed >= 0.1 else NO_COURSE
    there = math.isfinite(lat_deg + lon_deg)
    return _said(
        {
            "type": 1 if class_a else 18,
            "mmsi": mmsi,
            "lat": lat_deg if there else NO_LATITUDE,
            "lon": lon_deg if there else NO_LONGITUDE,
            "speed": min(speed, FASTEST_KNOTS) if math.isfinite(speed) else NO_SPEED,
            "course": course if math.isfinite(speed) else NO_COURSE,
            "heading": round(math.degrees(heading_rad)) % 360 if math.isfinite(heading_rad) else NO_HEADING,
            "accuracy": accurate,
            "second": second % 60,
            "raim": False,
            **({"status": UNDERWAY} if class_a else {"cs": True}),
        },
        mmsi,
    )


def static_report(mmsi: int, name: str, length_m: float, beam_m: float, *, class_a: bool = False) -> list[bytes]:
    """Name and size, the antenna amidships: message 24 in two parts, or 5 for class A."""
    half, side = max(1, min(round(0.5 * length_m), 255)), max(1, min(round(0.5 * beam_m), 31))
    size = {"to_bow": half, "to_stern": half, "to_port": side, "to_starboard": side}
    words = {"mmsi": mmsi, "shipname": name.upper()[:20], "ship_type": SAIL}
    if class_a:
        return _said({"type": 5, **words, **size}, mmsi)
    parts = ({"type": 24, "partno": 0, **words}, {"type": 24, "partno": 1, **words, **size})
    return [line for part in parts for line in _said(part, mmsi)]


def _tenth(value: float) -> float:
    """Rounded to tenths, and a little more: pyais cuts off what is below a tenth."""
    return round(value, 1) + 1e-3 if math.isfinite(value) else value


def _said(fields: dict[str, Any], mmsi: int) -> list[bytes]:
    """The sentences of a message; those of two vessels are told apart by the sequence number."""
    from pyais.encode import encode_dict

    lines = encode_dict(fields, talker_id="AI", sentence_type="VDM", radio_channel="A", seq_id=mmsi % 10)
    return [line.encode("ascii") + b"\r\n" for line in lines]
