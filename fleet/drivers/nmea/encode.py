"""What a GNSS receiver, a compass and a turn indicator would say: sentences from values. Pure."""

from __future__ import annotations

import math

from fleet.drivers.nmea.codec import KNOT_MPS, framed


def _angle(degrees: float, width: int, sides: str) -> str:
    """Degrees and minutes with seven digits (0.2 mm), and the side."""
    side = sides[0] if degrees >= 0.0 else sides[1]
    minutes = round(abs(degrees) * 60.0 * 1e7)
    whole, rest = divmod(minutes, 600_000_000)
    return f"{whole:0{width}d}{rest // 10_000_000:02d}.{rest % 10_000_000:07d},{side}"


def place(lat_deg: float, lon_deg: float) -> str:
    """Four fields: latitude, N or S, longitude, E or W."""
    return f"{_angle(lat_deg, 2, 'NS')},{_angle(lon_deg, 3, 'EW')}"


def time_of_day(stamp_ns: int) -> str:
    """hhmmss.sss of a UTC stamp."""
    ms = stamp_ns // 1_000_000 % 86_400_000
    return f"{ms // 3_600_000:02d}{ms // 60_000 % 60:02d}{ms // 1000 % 60:02d}.{ms % 1000:03d}"


def date_of(stamp_ns: int) -> str:
    """ddmmyy of a UTC stamp."""
    from datetime import UTC, datetime

    return datetime.fromtimestamp(stamp_ns // 1_000_000_000, UTC).strftime("%d%m%y")


def gga(stamp_ns: int, lat_deg: float, lon_deg: float, quality: int, hdop: float, talker: str = "GN") -> bytes:
    """Position; NaN: no fix."""
    if not math.isfinite(lat_deg + lon_deg):
        return framed(f"{talker}GGA,{time_of_day(stamp_ns)},,,,,0,00,99.99,,,,,,")
    fields = f"{time_of_day(stamp_ns)},{place(lat_deg, lon_deg)},{quality},12,{hdop:.2f},0.0,M,0.0,M,,"
    return framed(f"{talker}GGA,{fields}")


def rmc(
    stamp_ns: int, lat_deg: float, lon_deg: float, v_north_mps: float, v_east_mps: float, talker: str = "GN"
) -> bytes:
    """Position, speed and course; NaN: void."""
    time, date = time_of_day(stamp_ns), date_of(stamp_ns)
    if not math.isfinite(lat_deg + lon_deg):
        return framed(f"{talker}RMC,{time},V,,,,,,,{date},,,N,V")
    knots = math.hypot(v_north_mps, v_east_mps) / KNOT_MPS
    course = math.degrees(math.atan2(v_east_mps, v_north_mps)) % 360.0
    return framed(f"{talker}RMC,{time},A,{place(lat_deg, lon_deg)},{knots:.4f},{course % 360.0:.3f},{date},,,D,V")


def hdt(heading_rad: float, talker: str = "HE") -> bytes:
    """Heading from true north; NaN: not available."""
    text = "" if math.isnan(heading_rad) else f"{math.degrees(heading_rad) % 360.0:.3f}"
    return framed(f"{talker}HDT,{text},T")


def rot(yaw_rate_radps: float, talker: str = "TI") -> bytes:
    """Rate of turn; NaN: not available."""
    if math.isnan(yaw_rate_radps):
        return framed(f"{talker}ROT,,V")
    return framed(f"{talker}ROT,{math.degrees(yaw_rate_radps) * 60.0:.3f},A")
