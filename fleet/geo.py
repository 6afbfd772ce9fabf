"""WGS 84 positions to and from the local plane: north and east of a datum, in metres.

Points lie on the ellipsoid (height 0). A point is projected along the vertical of the datum onto the plane that touches
the ellipsoid there: what surveyors call NED about the datum, without D. Both ways are closed formulas; the trigonometry
of the datum is worked out once, in its `Plane`.
"""

from __future__ import annotations

import math
from functools import lru_cache

from msgspec import Struct

from fleet import ops
from fleet.errors import UsageError
from fleet.ops import R

SEMI_MAJOR_M = 6378137.0  # WGS 84, NIMA TR8350.2
FLATTENING = 1.0 / 298.257223563
_E_SQ = FLATTENING * (2.0 - FLATTENING)
_POLAR = 1.0 - _E_SQ  # (b / a)^2
_RAD = math.pi / 180.0
_DEG = 180.0 / math.pi


class Datum(Struct, frozen=True):
    """Where the local frame touches the ellipsoid."""

    lat_deg: float
    lon_deg: float


class Plane(Struct, frozen=True, gc=False):
    """A datum with its trigonometry, in the meridian frame: rho from the axis, east, z along the axis."""

    lat_deg: float
    lon_deg: float
    sin_lat: float
    cos_lat: float
    normal_m: float  # radius of curvature in the prime vertical
    rho_m: float
    z_m: float

    def to_local(self, lat_deg: R, lon_deg: R) -> tuple[R, R]:
        """(x, y): metres north and east of the datum."""
        s, c = ops.sincos(lat_deg * _RAD)
        s_lon, c_lon = ops.sincos((lon_deg - self.lon_deg) * _RAD)
        normal = SEMI_MAJOR_M / ops.sqrt(1.0 - _E_SQ * s * s)
        rho = normal * c * c_lon
        x = (_POLAR * normal * s - self.z_m) * self.cos_lat - (rho - self.rho_m) * self.sin_lat
        return x, normal * c * s_lon

    def to_geographic(self, x: R, y: R) -> tuple[R, R]:
        """(lat_deg, lon_deg) of the point of the ellipsoid below (x, y), longitude in [-180, 180].

        Its depth d below the plane solves a d^2 - 2 b d + c = 0: the ellipsoid, cut by the vertical through (x, y).
        """
        s, k = self.sin_lat, self.cos_lat
        a = k * k + s * s / _POLAR
        b = self.normal_m + x * (s * k * (1.0 / _POLAR - 1.0))
        c = x * x * (s * s + k * k / _POLAR) + y * y
        depth = c / (b + ops.sqrt(ops.maximum(b * b - a * c, 0.0)))
        rho = self.rho_m - x * s - depth * k
        z = self.z_m + x * k - depth * s
        lat = ops.atan2(z, _POLAR * ops.hypot(rho, y))
        lon = ops.wrap(self.lon_deg * _RAD + ops.atan2(y, rho))
        return lat * _DEG, lon * _DEG


@lru_cache(maxsize=64)
def plane_of(datum: Datum) -> Plane:
    """The plane about a datum; refuses what is no position."""
    lat_deg, lon_deg = datum.lat_deg, datum.lon_deg
    if not (abs(lat_deg) <= 90.0 and abs(lon_deg) <= 180.0):
        raise UsageError(
            f"datum is no position: lat_deg {lat_deg}, lon_deg {lon_deg}; expected within [-90, 90] and [-180, 180]"
        )
    s, c = ops.sincos(float(lat_deg) * _RAD)
    normal = SEMI_MAJOR_M / ops.sqrt(1.0 - _E_SQ * s * s)
    return Plane(
        lat_deg=float(lat_deg),
        lon_deg=float(lon_deg),
        sin_lat=s,
        cos_lat=c,
        normal_m=normal,
        rho_m=normal * c,
        z_m=_POLAR * normal * s,
    )


def to_local(datum: Datum, lat_deg: R, lon_deg: R) -> tuple[R, R]:
    """(x, y): metres north and east of the datum."""
    return plane_of(datum).to_local(lat_deg, lon_deg)


def to_geographic(datum: Datum, x: R, y: R) -> tuple[R, R]:
    """(lat_deg, lon_deg) of the point (x, y) metres north and east of the datum."""
    return plane_of(datum).to_geographic(x, y)
