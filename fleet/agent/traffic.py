"""The picture of vessels that are not of the fleet: a track each, from AIS and from bare positions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

from msgspec import structs

from fleet import ops
from fleet.agent.scanned import (
    FARTHEST_GATE_M,
    GATE,
    MATE_M,
    Mate,
    Placed,
    Vessel,
    is_mate,
    length_of,
    matched,
    passed,
)
from fleet.agent.step import FOREIGN_FROM
from fleet.drivers.seam import Sighting
from fleet.sensing import Target, Track, TrackParams, begin, lost, predict, seen, update_ais, update_position

MOST_VESSELS = 64
LONGEST_M, SHORTEST_M = 500.0, 2.0
DOUBTED_S = 10.0
SHRINKS = 0.02  # of the difference, with every report of a shorter length
OLD_S = 10.0  # reports older than that are passed over
FASTEST_MPS = 60.0
FARTHEST_M = 100_000.0
SCAN = "scan"  # source of what the boat's own scanners see


class Traffic:
    """Vessels by number."""

    def __init__(self, roster: Callable[[], Iterable[str]], epoch_ns: int) -> None:
        self._roster, self._epoch_ns = roster, epoch_ns
        self.vessels: dict[float, Vessel] = {}
        self.refused = 0  # reports that cannot be true
        self.mates = 0  # bare positions of boats of the fleet
        self.parts = 0  # things within the length of a vessel that a scanner sees already
        self._count = 0
        self._params = TrackParams()

    def __bool__(self) -> bool:
        return bool(self.vessels)

    def name_of(self, number: float) -> str:
        """The vessel's name; '' for a number that nobody has."""
        vessel = self.vessels.get(number)
        return vessel.name if vessel is not None else ""

    def number_of(self, name: str) -> float:
        """The vessel of a name, -1 for none."""
        return next((number for number, vessel in self.vessels.items() if vessel.name == name), -1.0)

    def hear(
        self,
        sightings: Iterable[Sighting],
        to_local: Callable[[float, float], tuple[float, float]],
        mates: Iterable[Mate],
        now_ns: int,
    ) -> None:
        """Take in reports; `mates` are where boats of the fleet are, for a sensor sees them too.

        A bare position near a mate, and nearer to it than to any vessel known, is the mate. Of a scanner, all reports
        are of one turn.
        """
        places: list[Mate] | None = None
        turn: list[Placed] = []
        for one in sightings:
            x, y = _place(one, to_local)
            if not (abs(x) + abs(y) <= FARTHEST_M and _plausible(one)) or not -0.5 < _age(one, now_ns) < OLD_S:
                self.refused += 1
                continue
            at = self._seconds(one.stamp_ns)
            if one.name:
                self._told(one, x, y, at)
                continue
            places = list(mates) if places is None else places
            if one.source == SCAN:
                turn.append((one, x, y, at))
            else:
                self._seen(one, x, y, at, places)
        if turn:
            self._scanned(turn, places or ())

    def targets(self, now_ns: int) -> tuple[Target, ...]:
        """All that are sure now, by number; those without data for two minutes are forgotten."""
        now = self._seconds(now_ns)
        for number, vessel in list(self.vessels.items()):
            doubted = not vessel.sure and now - vessel.track.heard > DOUBTED_S
            if doubted or lost(vessel.track, now, self._params):
                del self.vessels[number]
        return tuple(seen(vessel.track, now, self._params) for _, vessel in sorted(self.vessels.items()) if vessel.sure)

    def move(self, place: Callable[[float, float], tuple[float, float]]) -> None:
        """Another local frame: `place` gives the new coordinates of a point."""
        for vessel in self.vessels.values():
            x, y = place(vessel.track.x, vessel.track.y)
            vessel.track = structs.replace(vessel.track, x=x, y=y)

    # -- whose report it is ----------------------------------------------------------------------------------------
    def _told(self, one: Sighting, x: float, y: float, at: float) -> None:
        """A report with a name."""
        if one.name in self._roster():
            return
        knows_v = math.isfinite(one.v_north_mps + one.v_east_mps)
        for vessel in self.vessels.values():
            if vessel.name == one.name:
                error, vx, vy = one.position_error_m, one.v_north_mps, one.v_east_mps
                if knows_v:
                    vessel.track = update_ais(vessel.track, x, y, error, vx, vy, at, self._params)
                else:
                    vessel.track = update_position(vessel.track, x, y, error, at, self._params)
                _size(vessel, one)
                return
        velocity = (one.v_north_mps, one.v_east_mps) if knows_v else None
        track = begin(self._next(), x, y, one.position_error_m, at, length_of(one), velocity, self._params)
        self._add(one.name, track, one)

    def _seen(self, one: Sighting, x: float, y: float, at: float, places: Iterable[Mate]) -> None:
        """A bare position."""
        vessel, away = self._nearest(x, y, one.position_error_m, at)
        if _mate(x, y, MATE_M + 3.0 * one.position_error_m, places) < away:
            self.mates += 1
        elif vessel is not None:
            vessel.track = update_position(vessel.track, x, y, one.position_error_m, at, self._params)
            _size(vessel, one)
            vessel.reports += 1
        else:
            self._begin(one, x, y, at)

    def _scanned(self, turn: Sequence[Placed], places: Iterable[Mate]) -> None:
        """Things that a scanner sees in one turn. A vessel is one of them; more within its length are parts of it."""
        theirs = matched(self.vessels, turn, self._params)
        news: list[Placed] = []
        for i, (one, x, y, at) in enumerate(turn):
            vessel, away = theirs.get(i, (None, math.inf))
            if _mate(x, y, MATE_M + 3.0 * one.position_error_m, places) < away:
                self.mates += 1
            elif vessel is None:
                news.append(turn[i])
            else:
                vessel.track = passed(vessel.track, one, x, y, at, self._params)
                _size(vessel, one)
                vessel.reports += 1
                if is_mate(vessel, one, places):
                    self.mates += 1
                    self.vessels.pop(vessel.track.number, None)
        seen_now = [vessel.track for vessel, _ in theirs.values()]
        for one, x, y, at in news:
            reach = 0.5 * length_of(one) + 1.0
            if any(ops.hypot(x - track.x, y - track.y) < 0.5 * track.length + reach for track in seen_now):
                self.parts += 1
            else:
                self._begin(one, x, y, at)

    def greet(self, mate: Mate) -> None:
        """A boat of the fleet is heard for the first time: what was taken for a vessel there is that boat."""
        for number, vessel in list(self.vessels.items()):
            track = vessel.track
            if not vessel.told and ops.hypot(track.x - mate.x, track.y - mate.y) < MATE_M + mate.error:
                self.mates += 1
                del self.vessels[number]

    def _nearest(self, x: float, y: float, sigma: float, at: float) -> tuple[Vessel | None, float]:
        """The vessel that a bare position belongs to: the nearest in terms of what is uncertain, within the gate.

        With it how far off it should be [m]; infinite for none.
        """
        best, least, away = None, GATE, math.inf
        for vessel in self.vessels.values():
            here = predict(vessel.track, at, self._params)
            dx, dy = x - here.x, y - here.y
            off = 0.5 * (dx * dx + dy * dy) / (here.P11 + max(sigma, self._params.sigma_min_m) ** 2)
            if off < least and ops.hypot(dx, dy) < FARTHEST_GATE_M:
                best, least, away = vessel, off, ops.hypot(dx, dy)
        return best, away

    def _begin(self, one: Sighting, x: float, y: float, at: float) -> None:
        """A vessel from its first bare position."""
        track = begin(self._next(), x, y, one.position_error_m, at, length_of(one), None, self._params)
        self._add("", track, one)

    def _next(self) -> float:
        self._count += 1
        return FOREIGN_FROM + self._count

    def _add(self, name: str, track: Track, one: Sighting) -> None:
        if len(self.vessels) >= MOST_VESSELS:
            oldest = min(self.vessels, key=lambda number: (self.vessels[number].sure, self.vessels[number].track.heard))
            del self.vessels[oldest]
        called = name or f"vessel-{int(track.number - FOREIGN_FROM)}"
        self.vessels[track.number] = Vessel(called, track, bool(name), sized=math.isfinite(one.length_m))

    def _seconds(self, stamp_ns: int) -> float:
        return (stamp_ns - self._epoch_ns) * 1e-9


def _age(one: Sighting, now_ns: int) -> float:
    return (now_ns - one.stamp_ns) * 1e-9


def _place(one: Sighting, to_local: Callable[[float, float], tuple[float, float]]) -> tuple[float, float]:
    """Where it is; NaN where that cannot be on Earth."""
    if not (abs(one.lat_deg) <= 90.0 and abs(one.lon_deg) <= 180.0):
        return math.nan, math.nan
    return to_local(one.lat_deg, one.lon_deg)


def _plausible(one: Sighting) -> bool:
    """Whether error, velocity and length may be true; NaN is not known."""
    fast = math.hypot(one.v_north_mps, one.v_east_mps) > FASTEST_MPS
    odd = one.length_m < SHORTEST_M or one.length_m > LONGEST_M
    return 0.0 <= one.position_error_m <= 1000.0 and not fast and not odd


def _mate(x: float, y: float, near: float, places: Iterable[Mate]) -> float:
    """How far off the nearest boat of the fleet is, of those that it may be [m]; infinite for none."""
    there = ((math.hypot(x - mate.x, y - mate.y), mate.error) for mate in places)
    return min((away for away, error in there if away < near + error), default=math.inf)


def _size(vessel: Vessel, one: Sighting) -> None:
    """Its length as it is told, or the longest that a scanner saw of late: end-on, little of a hull shows."""
    if not math.isfinite(one.length_m) or (one.source == SCAN and vessel.told and vessel.sized):
        return
    length = one.length_m
    if one.source == SCAN and vessel.sized and length < vessel.track.length:
        length = vessel.track.length + SHRINKS * (length - vessel.track.length)
    vessel.track = structs.replace(vessel.track, length=length)
    vessel.sized = True
