"""Can a boat have come from the last fix to this one? Pure."""

from __future__ import annotations

import math

EARTH_M = 6_371_000.0
JUMP_M = 20.0  # and what the boat may have gone in the time
AGREED = 5  # fixes after a jump that agree with each other are the truth

Place = tuple[float, float, int]
"""Latitude, longitude [deg], and when [ns]."""


def distance_m(lat0: float, lon0: float, lat1: float, lon1: float) -> float:
    """How far apart two places are, on a sphere and for small distances [m]."""
    north = math.radians(lat1 - lat0)
    east = math.radians((lon1 - lon0 + 180.0) % 360.0 - 180.0) * math.cos(math.radians(0.5 * (lat0 + lat1)))
    return EARTH_M * math.hypot(north, east)


class Jumps:
    """Remembers the last fix, and one that jumped until others agree with it."""

    def __init__(self, fastest_mps: float) -> None:
        self._fastest_mps = fastest_mps
        self._last: Place | None = None
        self._stray: Place | None = None
        self._agreed = 0

    def plausible(self, place: Place) -> bool:
        """Whether a boat can have come here; after five fixes that agree with each other it has."""
        if self._last is None or self._near(self._last, place):
            self._last, self._stray = place, None
            return True
        self._agreed = self._agreed + 1 if self._stray is not None and self._near(self._stray, place) else 1
        self._stray = place
        if self._agreed < AGREED:
            return False
        self._last, self._stray = place, None
        return True

    def _near(self, before: Place, place: Place) -> bool:
        reach_m = JUMP_M + self._fastest_mps * abs(place[2] - before[2]) * 1e-9
        return distance_m(*before[:2], *place[:2]) <= reach_m
