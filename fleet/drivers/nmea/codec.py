"""NMEA 0183 sentences to values, and values to sentences. Pure.

An empty field means "not available" (IEC 61162-1, 7.2.3.4) and becomes NaN or None, never zero. Numbers are read
strictly: what Python would read as a number besides ("1e5", "nan", "1_0") is none.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import reduce
from operator import xor
from typing import NamedTuple

LONGEST = 256  # the standard allows 82; receivers with long positions make more
KNOT_MPS = 1852.0 / 3600.0
FASTEST_MPS = 50.0
FASTEST_TURN_RADPS = 2.0
VALID_MODES = frozenset("ADFRP")  # autonomous, differential, float RTK, RTK, precise; not E, M, S, N
_NUMBER = re.compile(r"-?\d{1,6}(\.\d{1,12})?")
_TIME = re.compile(r"([01]\d|2[0-3])([0-5]\d)([0-5]\d|60)(\.\d{1,6})?")
_LATITUDE = re.compile(r"(\d{2})([0-5]\d(?:\.\d{1,10})?)")
_LONGITUDE = re.compile(r"(\d{3})([0-5]\d(?:\.\d{1,10})?)")
_ADDRESS = re.compile(r"[A-Z]{2}[A-Z]{3}")


class Unusable(ValueError):
    """A sentence that says nothing, and why in a word or two."""


class Gga(NamedTuple):
    """Position and its quality."""

    time_s: float  # UTC, of the day
    lat_deg: float
    lon_deg: float
    quality: int  # 1 GPS, 2 differential, 3 PPS, 4 RTK fixed, 5 RTK float
    hdop: float  # NaN not available
    satellites: float


class Rmc(NamedTuple):
    """Position, speed and course."""

    time_s: float
    lat_deg: float
    lon_deg: float
    v_north_mps: float  # over ground; NaN not available
    v_east_mps: float


class Vtg(NamedTuple):
    """Speed and course."""

    v_north_mps: float
    v_east_mps: float


class Gst(NamedTuple):
    """What the receiver thinks its error is."""

    time_s: float
    sigma_m: float  # 1 sigma per axis


class Heading(NamedTuple):
    """From true north, or from magnetic north."""

    heading_rad: float
    magnetic: bool
    variation_rad: float = math.nan  # + east; where the sentence tells it


class Rot(NamedTuple):
    """Rate of turn."""

    yaw_rate_radps: float  # + to starboard


Sentence = Gga | Rmc | Vtg | Gst | Heading | Rot


def checksum(body: bytes) -> int:
    """The exclusive or of all bytes between $ or ! and *."""
    return reduce(xor, body, 0)


def framed(body: str, start: str = "$") -> bytes:
    """A whole sentence with its checksum and line end."""
    return f"{start}{body}*{checksum(body.encode('ascii')):02X}\r\n".encode("ascii")


def unframed(line: bytes, start: bytes = b"$") -> list[str]:
    """The fields of a sentence, the address first; Unusable where start, characters or checksum are wrong."""
    if not line.startswith(start):
        raise Unusable("no sentence")
    if len(line) > LONGEST:
        raise Unusable("too long")
    body, star, digits = line[1:].rpartition(b"*")
    if not star or len(digits) != 2:
        raise Unusable("no checksum")
    try:
        right = int(digits, 16) == checksum(body) and digits.isalnum()
    except ValueError:
        raise Unusable("no checksum") from None
    if not right:
        raise Unusable("checksum")
    if not body.isascii() or not body.decode("ascii").isprintable():
        raise Unusable("characters")
    return body.decode("ascii").split(",")


def decode(line: bytes) -> Sentence:
    """What a sentence says; Unusable with the reason, when it says nothing that is to be believed."""
    address, *fields = unframed(line)
    if address.startswith("P") or not _ADDRESS.fullmatch(address):
        raise Unusable("not used")
    read = _READ.get(address[2:])
    if read is None:
        raise Unusable("not used")
    return read(fields)


def _field(fields: list[str], i: int) -> str:
    return fields[i] if i < len(fields) else ""


def _number(fields: list[str], i: int) -> float:
    """A number; NaN where the field is empty; Unusable where it holds something else."""
    text = _field(fields, i)
    if not text:
        return math.nan
    if not _NUMBER.fullmatch(text):
        raise Unusable("not a number")
    return float(text)


def _time(text: str) -> float:
    """hhmmss.ss as seconds of the day."""
    if not text:
        raise Unusable("no time")
    match = _TIME.fullmatch(text)
    if match is None:
        raise Unusable("not a time")
    h, m, s, fraction = match.groups()
    return int(h) * 3600.0 + int(m) * 60.0 + int(s) + float(fraction or 0.0)


def _place(fields: list[str], i: int) -> tuple[float, float]:
    """Latitude and longitude from four fields [deg]; 0, 0 is what receivers say that know nothing."""
    lat, north, lon, east = (_field(fields, i + k) for k in range(4))
    if not (lat and north and lon and east):
        raise Unusable("no position")
    a, b = _LATITUDE.fullmatch(lat), _LONGITUDE.fullmatch(lon)
    if a is None or b is None or north not in ("N", "S") or east not in ("E", "W"):
        raise Unusable("not a position")
    lat_deg, lon_deg = int(a[1]) + float(a[2]) / 60.0, int(b[1]) + float(b[2]) / 60.0
    if lat_deg > 90.0 or lon_deg > 180.0:
        raise Unusable("not a position")
    if lat_deg == 0.0 and lon_deg == 0.0:
        raise Unusable("position 0, 0")
    return (lat_deg if north == "N" else -lat_deg), (lon_deg if east == "E" else -lon_deg)


def _velocity(knots: float, course_deg: float) -> tuple[float, float]:
    """Speed and course as velocity north and east; a boat at rest has no course [m/s]."""
    speed = knots * KNOT_MPS
    if math.isnan(speed):
        return math.nan, math.nan
    if math.isnan(course_deg):
        return (0.0, 0.0) if 0.0 <= speed < 0.1 else (math.nan, math.nan)
    if not 0.0 <= speed <= FASTEST_MPS or not 0.0 <= course_deg <= 360.0:
        raise Unusable("implausible")
    course = math.radians(course_deg)
    return speed * math.cos(course), speed * math.sin(course)


def _gga(fields: list[str]) -> Gga:
    time_s = _time(_field(fields, 0))
    quality = _field(fields, 5)
    if quality not in ("1", "2", "3", "4", "5"):
        raise Unusable("no fix" if quality in ("", "0") else "not a measured fix")
    lat_deg, lon_deg = _place(fields, 1)
    hdop = _number(fields, 7)
    return Gga(time_s, lat_deg, lon_deg, int(quality), hdop if hdop > 0.0 else math.nan, _number(fields, 6))


def _rmc(fields: list[str]) -> Rmc:
    time_s = _time(_field(fields, 0))
    if _field(fields, 1) != "A" or (len(fields) > 11 and fields[11] not in VALID_MODES):
        raise Unusable("void")
    lat_deg, lon_deg = _place(fields, 2)
    return Rmc(time_s, lat_deg, lon_deg, *_velocity(_number(fields, 6), _number(fields, 7)))


def _vtg(fields: list[str]) -> Vtg:
    if len(fields) > 8 and fields[8] not in VALID_MODES:
        raise Unusable("void")
    knots, kmph = _number(fields, 4), _number(fields, 6)
    return Vtg(*_velocity(kmph / 1.852 if math.isnan(knots) else knots, _number(fields, 0)))


def _gst(fields: list[str]) -> Gst:
    time_s = _time(_field(fields, 0))
    sigma_m = math.hypot(_number(fields, 5), _number(fields, 6)) / math.sqrt(2.0)
    if not sigma_m > 0.0:
        raise Unusable("no error")
    return Gst(time_s, sigma_m)


def _heading_of(degrees: float) -> float:
    if math.isnan(degrees):
        raise Unusable("no heading")
    if not 0.0 <= degrees <= 360.0:
        raise Unusable("implausible")
    return math.remainder(math.radians(degrees), 2.0 * math.pi)


def _hdt(fields: list[str]) -> Heading:
    if _field(fields, 1) != "T":
        raise Unusable("void")
    return Heading(_heading_of(_number(fields, 0)), False)


def _ths(fields: list[str]) -> Heading:
    if _field(fields, 1) != "A":
        raise Unusable("void")
    return Heading(_heading_of(_number(fields, 0)), False)


def _signed(fields: list[str], i: int) -> float:
    """Degrees with E or W, as radians, + east."""
    value, side = _number(fields, i), _field(fields, i + 1)
    if math.isnan(value) or side not in ("E", "W"):
        return math.nan
    if not 0.0 <= value <= 180.0:
        raise Unusable("implausible")
    return math.radians(value if side == "E" else -value)


def _hdg(fields: list[str]) -> Heading:
    deviation = _signed(fields, 1)
    heading = _heading_of(_number(fields, 0)) + (0.0 if math.isnan(deviation) else deviation)
    return Heading(math.remainder(heading, 2.0 * math.pi), True, _signed(fields, 3))


def _hdm(fields: list[str]) -> Heading:
    if _field(fields, 1) != "M":
        raise Unusable("void")
    return Heading(_heading_of(_number(fields, 0)), True)


def _rot(fields: list[str]) -> Rot:
    if _field(fields, 1) != "A":
        raise Unusable("void")
    rate = math.radians(_number(fields, 0) / 60.0)
    if math.isnan(rate):
        raise Unusable("no rate")
    if abs(rate) > FASTEST_TURN_RADPS:
        raise Unusable("implausible")
    return Rot(rate)


_READ: dict[str, Callable[[list[str]], Sentence]] = {
    "GGA": _gga,
    "RMC": _rmc,
    "VTG": _vtg,
    "GST": _gst,
    "HDT": _hdt,
    "THS": _ths,
    "HDG": _hdg,
    "HDM": _hdm,
    "ROT": _rot,
}
