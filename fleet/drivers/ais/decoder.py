"""AIS messages to sightings of other vessels. Pure."""

from __future__ import annotations

import math
from collections import Counter
from typing import Any

from msgspec import Struct

from fleet.drivers.ais.codec import read
from fleet.drivers.ais.options import AisOptions
from fleet.drivers.ais.sentences import Assembler, Message
from fleet.drivers.nmea.codec import KNOT_MPS, Unusable
from fleet.drivers.seam import Sighting
from fleet.drivers.sensors.jumps import EARTH_M

CLASS_A = (1, 2, 3)
SLOW_KNOTS = 0.3  # slower vessels need no course
SURE_KNOTS = 1.0  # a faster one heads where it goes, nearly
AGAIN_NS = 2_000_000_000  # the same message within this was heard twice
MOST_KNOWN = 2000  # vessels of which sizes are remembered
MOST_WAITING = 512  # sightings that nobody has asked for


class Size(Struct, frozen=True):
    """Of a vessel: from its antenna to bow, stern, port and starboard [m]."""

    bow: float
    stern: float
    port: float
    starboard: float

    @property
    def length(self) -> float:
        """Over all [m]."""
        return self.bow + self.stern

    @property
    def placed(self) -> bool:
        """Whether it is known where on board the antenna is."""
        return self.bow > 0.0 or self.port > 0.0


class Listener:
    """Everything that one line says about other vessels."""

    def __init__(self, options: AisOptions) -> None:
        self._options = options
        self._assembler = Assembler()
        self.counts: Counter[str] = Counter()  # sentences, by what came of them
        self._sizes: dict[int, Size] = {}
        self._said: dict[int, tuple[bytes, int]] = {}
        self._waiting: list[Sighting] = []

    def take(self, line: bytes, stamp_ns: int) -> None:
        """A sentence arrives."""
        abandoned = self._assembler.abandoned
        try:
            message = self._assembler.take(line, stamp_ns)
            used = self._hear(message, stamp_ns) if message is not None else "waiting"
        except Unusable as error:
            used = str(error)
        self.counts[used] += 1
        if self._assembler.abandoned > abandoned:
            self.counts["messages abandoned"] += self._assembler.abandoned - abandoned

    def heard(self) -> tuple[Sighting, ...]:
        """Sightings since the last call."""
        if not self._waiting:
            return ()
        found, self._waiting = tuple(self._waiting), []
        return found

    def _hear(self, message: Message, stamp_ns: int) -> str:
        said = read(message)
        mmsi = int(said.mmsi)
        first, last = self._options.ignore_range
        if not 0 < mmsi <= 999_999_999:
            raise Unusable("no MMSI")
        if mmsi in self._options.ignore_mmsi or first <= mmsi <= last:
            raise Unusable("of the fleet")
        if said.msg_type in (5, 19) or (said.msg_type == 24 and hasattr(said, "to_bow")):
            self._remember(mmsi, said)
        if said.msg_type in (5, 24):
            return "accepted"
        payload, at_ns = self._said.get(mmsi, (b"", 0))
        if payload == message.payload and stamp_ns - at_ns < AGAIN_NS:
            raise Unusable("heard twice")
        _keep(self._said, mmsi, (message.payload, stamp_ns))
        if len(self._waiting) >= MOST_WAITING:
            raise Unusable("too many at once")
        self._waiting.append(self._sighting(said, mmsi, stamp_ns))
        return "accepted"

    def _remember(self, mmsi: int, said: Any) -> None:
        size = Size(*(float(getattr(said, key) or 0) for key in ("to_bow", "to_stern", "to_port", "to_starboard")))
        if size.length >= 2.0:
            _keep(self._sizes, mmsi, size)

    def _sighting(self, said: Any, mmsi: int, stamp_ns: int) -> Sighting:
        """A position report; Unusable where it has no position."""
        lat_deg, lon_deg = float(said.lat), float(said.lon)
        if abs(lat_deg) > 90.0 or abs(lon_deg) > 180.0:
            raise Unusable("no position")
        if lat_deg == 0.0 and lon_deg == 0.0:
            raise Unusable("position 0, 0")
        options, size = self._options, self._sizes.get(mmsi)
        error_m = options.accurate_m if said.accuracy else options.inaccurate_m
        v_north, v_east = velocity(float(said.speed), float(said.course))
        if size is not None and size.placed:
            psi = _heading(said)
            ahead, starboard = 0.5 * (size.bow - size.stern), 0.5 * (size.starboard - size.port)
            if math.isfinite(psi):
                c, s = math.cos(psi), math.sin(psi)
                north, east = ahead * c - starboard * s, ahead * s + starboard * c
                lat_deg += math.degrees(north / EARTH_M)
                lon_deg += math.degrees(east / (EARTH_M * max(math.cos(math.radians(lat_deg)), 0.01)))
            else:
                error_m = math.hypot(error_m, ahead)
        unknown_m = options.class_a_m if said.msg_type in CLASS_A else math.nan
        return Sighting(
            stamp_ns=stamp_ns,
            source="ais",
            name=f"mmsi-{mmsi:09d}",
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            position_error_m=error_m,
            v_north_mps=v_north,
            v_east_mps=v_east,
            length_m=size.length if size is not None else unknown_m,
        )


def velocity(knots: float, course_deg: float) -> tuple[float, float]:
    """Velocity north and east [m/s]; NaN where speed (102.3) or course (360) is not available."""
    if knots > 102.25:
        return math.nan, math.nan
    if not 0.0 <= course_deg < 360.0:
        return (0.0, 0.0) if knots < SLOW_KNOTS else (math.nan, math.nan)
    course, speed = math.radians(course_deg), knots * KNOT_MPS
    return speed * math.cos(course), speed * math.sin(course)


def _heading(said: Any) -> float:
    """Where the bow points [rad]: the compass, else the course of a vessel under way, else NaN."""
    if 0 <= said.heading < 360:
        return math.radians(said.heading)
    if SURE_KNOTS < said.speed < 102.25 and 0.0 <= said.course < 360.0:
        return math.radians(said.course)
    return math.nan


def _keep(table: dict[int, Any], mmsi: int, value: Any) -> None:
    """Remember the newest; of too many the oldest is forgotten."""
    table.pop(mmsi, None)
    if len(table) >= MOST_KNOWN:
        del table[next(iter(table))]
    table[mmsi] = value
