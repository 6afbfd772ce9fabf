"""A wingman in its place beside its leader, and how far from abeam that is where the paths come near each other.

Where they cross, strictly abeam would be on top of the leader. There the wingman falls back, or goes ahead, just in
time and no farther than the least distance asks for, and comes up again as fast as its speeds and accelerations allow.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Protocol

from msgspec import Struct

from fleet.coordination.wingman import LEAST_COS
from fleet.guidance.limits import Limits
from fleet.paths import Path, PathPoint

STEP_M = 1.0  # of a voyage
FINE_M = 0.5  # of the table of room
MOST = 50_000  # steps along one path: at most 2 m each
SPARE_MPS = 0.1  # speed left for corrections
STEERS = 0.4  # of cruise: a boat that is slower steers badly
ACCELERATES, LANDS = 0.7, 0.55  # shares of what the boat can that are planned with; while coming abeam
LEAST_MPS = 0.3  # for the acceleration of one that hardly moves


class Room(Struct, frozen=True):
    """How far ahead of abeam a wingman wants to be, for each abscissa of its path."""

    first: float  # abscissa of the first value [m]
    step: float
    values: tuple[float, ...]  # + ahead [m]
    rates: tuple[float, ...] = ()  # metres of its path for one of the leader's, in that place; empty: not worked out

    def at(self, s: float) -> tuple[float, float]:
        """Metres ahead of abeam at abscissa s, and how that grows [m/m]."""
        place = (s - self.first) / self.step
        if not 0.0 <= place < len(self.values) - 1:
            return (self.values[0] if place < 0.0 else self.values[-1]), 0.0
        i = int(place)
        a, b = self.values[i], self.values[i + 1]
        return a + (place - i) * (b - a), (b - a) / self.step

    def gains(self, s: float, u: float, lag_s: float) -> float:
        """By how much the place at abscissa s, of a leader at u [m/s], will be faster when the speed has followed.

        A boat whose surge lags by T follows a speed that changes evenly without falling behind if it is told the
        speed of T later.
        """
        here = self._rate(s)
        return u * (self._rate(s + u * here * lag_s) - here) if self.rates else 0.0

    def _rate(self, s: float) -> float:
        if not self.rates:
            return 1.0
        place = min(max((s - self.first) / self.step, 0.0), len(self.rates) - 1.0)
        i = min(int(place), len(self.rates) - 2)
        return self.rates[i] + (place - i) * (self.rates[i + 1] - self.rates[i])


ABEAM = Room(0.0, 1.0, (0.0,))


class OnPath(Protocol):
    """A boat on its path."""

    @property
    def path(self) -> Path:
        """Which."""

    @property
    def s(self) -> float:
        """Where it begins [m]."""


class Beside(Struct, frozen=True):
    """One moment of a wingman in its place."""

    s1: float  # of the leader [m]
    s2: float  # of the wingman, both along their own paths [m]
    abeam: float  # wingman to starboard of the leader's path [m]
    cos_beta: float
    rate: float  # metres of its path for one of the leader's, abeam
    leader: PathPoint[float]
    own: PathPoint[float]


def sail(boat: OnPath, leader: OnPath, room: Room = ABEAM) -> Iterator[Beside]:
    """The wingman in its place, step by step of the leader, until one of the paths ends; closed ones for a lap."""
    path1, path2 = leader.path, boat.path
    s1, s2 = leader.s, abeam_of(path2, boat.s, path1.at(leader.s))
    last = s1 + path1.length if path1.closed else path1.length
    step = max(STEP_M, (last - s1) / MOST)
    while s1 <= last + 1e-9 and (path2.closed or s2 <= path2.length):
        p, q = path1.at(s1), path2.at(s2)
        cos_beta = p.tx * q.tx + p.ty * q.ty
        along = p.tx * (q.x - p.x) + p.ty * (q.y - p.y)
        abeam = p.tx * (q.y - p.y) - p.ty * (q.x - p.x)
        wanted, slope = room.at(s2)
        divisor = max(cos_beta - slope, LEAST_COS)
        rate = (1.0 - p.c * abeam) / divisor
        yield Beside(s1, s2, abeam, cos_beta, rate, p, q)
        s1 += step
        s2 += step * rate - 0.5 * (along - wanted) / divisor


def abeam_of(path: Path, s: float, leader: PathPoint[float]) -> float:
    """Abscissa near s of the point abeam of a leader; s where there is none near."""
    found = s
    for _ in range(20):
        q = path.at(found)
        cos_beta = max(leader.tx * q.tx + leader.ty * q.ty, LEAST_COS)
        along = leader.tx * (q.x - leader.x) + leader.ty * (q.y - leader.y)
        found -= min(max(along / cos_beta, -5.0), 5.0)
        if abs(along) < 1e-6:
            return found
    return found if path.closed or 0.0 <= found <= path.length else s


class _Place(Struct, frozen=True):
    """What holds at one abscissa of the wingman's path."""

    least: float  # of room, to either side [m]
    cos_beta: float
    advance: float  # cruise speed of the leader, along its path beside which the wingman is [m/s]


def room_beside(voyage: Sequence[Beside], limits: Limits, cruise_mps: float, need: float, side: float) -> Room:
    """Far enough behind (side -1) or ahead (+1) that the two are never nearer than `need` [m].

    Where the wingman is n abeam that is sqrt(need^2 - n^2). On both sides of where it is largest it shrinks as fast as
    the boat can: with room' metres a metre the wingman goes cos(beta) / (cos(beta) - room') times as fast as abeam,
    which must be within its limits, and changes no faster than it can. Coming abeam it brakes in time.
    """
    if not voyage:
        return ABEAM
    first, last = voyage[0].s2, voyage[-1].s2
    step = max(FINE_M, (last - first) / MOST)
    places = list(_places(voyage, first, step, math.ceil((last - first) / step) + 1, cruise_mps, need))
    room = [place.least for place in places]
    _shrink(room, places, range(len(room) - 1, -1, -1), side, step, limits, cruise_mps)
    _shrink(room, places, range(len(room)), -side, step, limits, cruise_mps)
    values = [side * value for value in room]
    slopes = [(values[min(i + 1, len(values) - 1)] - values[max(i - 1, 0)]) / (2.0 * step) for i in range(len(values))]
    rates = [p.advance / cruise_mps / max(p.cos_beta - d, LEAST_COS) for p, d in zip(places, slopes, strict=True)]
    return Room(first, step, tuple(values), tuple(rates))


def _places(
    voyage: Sequence[Beside], first: float, step: float, count: int, cruise_mps: float, need: float
) -> Iterator[_Place]:
    """The voyage at even abscissae of the wingman."""
    k = 0
    for i in range(count):
        s = first + i * step
        while k + 2 < len(voyage) and voyage[k + 1].s2 < s:
            k += 1
        a, b = voyage[k], voyage[min(k + 1, len(voyage) - 1)]
        share = min(max((s - a.s2) / (b.s2 - a.s2), 0.0), 1.0) if b.s2 > a.s2 else 0.0
        n = a.abeam + share * (b.abeam - a.abeam)
        cos_beta = max(a.cos_beta + share * (b.cos_beta - a.cos_beta), LEAST_COS)
        turn = 1.0 - a.leader.c * n
        yield _Place(math.sqrt(max(need * need - n * n, 0.0)), cos_beta, cruise_mps * max(turn, 0.1))


def _shrink(
    room: list[float],
    places: Sequence[_Place],
    order: Iterable[int],
    sign: float,
    step: float,
    limits: Limits,
    cruise_mps: float,
) -> None:
    """Let the room shrink along `order` no faster than the boat can, nor below what it must be.

    sign: +1 where the wingman is faster than abeam while it does
    """
    low = max(limits.speed_min_mps + SPARE_MPS, STEERS * cruise_mps)
    high = limits.speed_max_mps - SPARE_MPS
    a = ACCELERATES * limits.acceleration_max_mps2
    landing = 2.0 * LANDS * limits.acceleration_max_mps2
    slope, before = 0.0, -1
    for i in order:
        if before >= 0 and (room[before] > 0.0 or room[i] > 0.0):
            cos_beta, advance = places[i].cos_beta, places[i].advance
            u = advance / max(cos_beta - sign * slope, LEAST_COS)
            fastest = min(cos_beta - advance / high, cos_beta - LEAST_COS) if sign > 0.0 else advance / low - cos_beta
            sooner = max(slope, 0.0) + a * advance / max(u, LEAST_MPS) ** 3 * step  # du/dt = u^3 room'' / U
            steepest = max(min(fastest, sooner, math.sqrt(landing * room[before]) / u), 0.0)
            value = max(room[i], room[before] - steepest * step)
            slope = (room[before] - value) / step
            room[i] = value
        else:
            slope = 0.0
        before = i
