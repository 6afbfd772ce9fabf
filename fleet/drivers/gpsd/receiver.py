"""gpsd's reports to fixes, headings and yaw rates. Pure: lines and times are handed in.

Source: gpsd_json(5). TPV has position, velocity and their errors, ATT heading and rate of turn; others are passed over.
"""

from __future__ import annotations

import math
from collections import Counter
from datetime import datetime
from typing import Annotated

import msgspec
from msgspec import Meta, Struct, field
from msgspec.structs import replace

from fleet.drivers.nmea.codec import FASTEST_MPS, FASTEST_TURN_RADPS, Unusable
from fleet.drivers.nmea.delay import Delay
from fleet.drivers.seam import Observed
from fleet.drivers.sensors.jumps import Jumps

BACK_MOST = 10  # reports from the past; then it is the receiver's time that was wrong
LATE_NS = 500_000_000
SURE_95, SURE_95_2D = 2.0, 2.45  # sigmas within which 95 % lie, on an axis and in the plane
SLOW_MPS = 0.1
WATCH = b'?WATCH={"enable":true,"json":true};\n'


class GpsdOptions(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """`options` of a sensor of kind `gpsd`."""

    device: str = ""  # only what comes from this device, such as "/dev/ttyACM0"
    position_error_m: Annotated[float, Meta(ge=0.0, le=100.0)] = 0.0  # 1 sigma per axis; 0: as gpsd says (95 %)
    unknown_m: Annotated[float, Meta(gt=0.0, le=100.0)] = 3.0  # where it does not say
    velocity_error_mps: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.1  # 1 sigma per axis, at least
    fastest_mps: Annotated[float, Meta(gt=0.0, le=50.0)] = 15.0
    heading_error_deg: Annotated[float, Meta(gt=0.0, le=45.0)] = 2.0
    heading_offset_deg: Annotated[float, Meta(ge=-180.0, le=180.0)] = 0.0


class Report(Struct):
    """What of gpsd's reports is of use; None: not there."""

    kind: str = field(name="class")
    device: str = ""
    mode: int = 0  # 0 and 1 no fix, 2 2D, 3 3D
    status: int = 1  # 5 and 6 reckoned, 7 surveyed, 8 simulated
    time: str | None = None
    lat: float | None = None
    lon: float | None = None
    epx: float | None = None  # 95 %, longitude [m]
    epy: float | None = None  # 95 %, latitude [m]
    eph: float | None = None  # 95 %, in the plane [m]
    track: float | None = None  # true course [deg]
    speed: float | None = None  # [m/s]
    eps: float | None = None  # 95 % [m/s]
    heading: float | None = None  # true [deg]
    rot: float | None = None  # [deg/min]


class Greeting(Struct):
    """Any report; it may hold what the others do not mind."""

    kind: str = field(name="class")


_decode = msgspec.json.Decoder(Report).decode
_decode_any = msgspec.json.Decoder(Greeting).decode


class GpsdReceiver:
    """Everything that gpsd says about the own boat."""

    def __init__(self, options: GpsdOptions, delay_s: float = 0.0) -> None:
        self._options, self._delay_ns = options, int(delay_s * 1e9)
        self.counts: Counter[str] = Counter()
        self.why_no_fix = ""
        self._jumps = Jumps(options.fastest_mps)
        self._delay = Delay()
        self._time_s = -math.inf
        self._back = 0
        self._new = Observed()

    def take(self, line: bytes, stamp_ns: int) -> None:
        """A report arrives."""
        try:
            self.counts[self._hear(line, stamp_ns)] += 1
        except Unusable as error:
            self.counts[str(error)] += 1

    def observed(self, now_ns: int) -> Observed:  # noqa: ARG002 - as other receivers
        """What is new since the last call."""
        new, self._new = self._new, Observed()
        return new

    def _hear(self, line: bytes, stamp_ns: int) -> str:
        try:
            text = line.decode()  # msgspec does not look at what it passes over
            if _decode_any(text).kind not in ("TPV", "ATT"):
                return "not used"
            report = _decode(text)
        except (msgspec.DecodeError, UnicodeDecodeError):  # of which a value of the wrong type is one
            raise Unusable("not a report") from None
        if self._options.device and report.device != self._options.device:
            return "another device"
        if report.kind == "ATT":
            self._turn(report, stamp_ns)
            return "accepted"
        try:
            self._fix(report, stamp_ns)
        except Unusable as error:
            self.why_no_fix = str(error)
            raise
        self.why_no_fix = ""
        return "accepted"

    def _fix(self, report: Report, stamp_ns: int) -> None:
        if report.mode not in (2, 3):
            raise Unusable("no fix")
        if report.status >= 5:
            raise Unusable("not a measured fix")
        lat_deg, lon_deg = report.lat, report.lon
        if lat_deg is None or lon_deg is None:
            raise Unusable("no position")
        if not (abs(lat_deg) <= 90.0 and abs(lon_deg) <= 180.0):
            raise Unusable("not a position")
        if lat_deg == 0.0 and lon_deg == 0.0:
            raise Unusable("position 0, 0")
        sigma_m, sigma_mps = self._errors(report)
        v_north, v_east = _velocity(report)
        time_s = _seconds(report.time)
        if not self._later(time_s):
            raise Unusable("time does not advance")
        late_ns = self._delay.late_ns(time_s % 86_400.0, stamp_ns)
        if late_ns > LATE_NS:
            self.counts["late"] += 1
        at_ns = stamp_ns - late_ns - self._delay_ns
        if not self._jumps.plausible((lat_deg, lon_deg, at_ns)):
            raise Unusable("position jumps")
        self._new = replace(
            self._new,
            fix_ns=at_ns,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            position_error_m=sigma_m,
            v_north_mps=v_north,
            v_east_mps=v_east,
            velocity_error_mps=sigma_mps,
        )

    def _later(self, time_s: float) -> bool:
        """Whether time advances; after ten reports from the past it does so from there."""
        self._back = self._back + 1 if time_s < self._time_s else 0
        if time_s > self._time_s or self._back >= BACK_MOST:
            if self._back:
                self._delay, self._back = Delay(), 0
            self._time_s = time_s
            return True
        return False

    def _errors(self, report: Report) -> tuple[float, float]:
        """1-sigma errors per axis, of position [m] and velocity [m/s]."""
        options = self._options
        told = [value for value in (report.epx, report.epy) if value is not None]
        if options.position_error_m > 0.0:
            sigma_m = options.position_error_m
        elif told:
            sigma_m = max(told) / SURE_95
        else:
            sigma_m = report.eph / SURE_95_2D if report.eph is not None else options.unknown_m
        sigma_mps = max(options.velocity_error_mps, (report.eps or 0.0) / SURE_95)
        if not (0.0 < sigma_m < 1000.0 and sigma_mps < 100.0):
            raise Unusable("implausible")
        return sigma_m, sigma_mps

    def _turn(self, report: Report, stamp_ns: int) -> None:
        at_ns = stamp_ns - self._delay_ns
        if report.heading is not None:
            if not 0.0 <= report.heading <= 360.0:
                raise Unusable("implausible")
            psi = math.radians(report.heading + self._options.heading_offset_deg)
            error = math.radians(self._options.heading_error_deg)
            self._new = replace(
                self._new, heading_ns=at_ns, heading_rad=math.remainder(psi, 2.0 * math.pi), heading_error_rad=error
            )
        if report.rot is not None:
            rate = math.radians(report.rot / 60.0)
            if abs(rate) > FASTEST_TURN_RADPS:
                raise Unusable("implausible")
            self._new = replace(self._new, yaw_rate_ns=at_ns, yaw_rate_radps=rate)


def _seconds(text: str | None) -> float:
    """UTC of a report [s]."""
    if text is None:
        raise Unusable("no time")
    try:
        return datetime.fromisoformat(text).timestamp()
    except (ValueError, OverflowError, OSError):
        raise Unusable("not a time") from None


def _velocity(report: Report) -> tuple[float, float]:
    """Velocity over ground [m/s]; a boat at rest has no course."""
    speed, track = report.speed, report.track
    if speed is None:
        return math.nan, math.nan
    if not 0.0 <= speed <= FASTEST_MPS:
        raise Unusable("implausible")
    if track is None:
        return (0.0, 0.0) if speed < SLOW_MPS else (math.nan, math.nan)
    if not 0.0 <= track <= 360.0:
        raise Unusable("implausible")
    course = math.radians(track)
    return speed * math.cos(course), speed * math.sin(course)
