"""The picture of vessels that are not of the fleet: a track each, from AIS and from bare positions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from msgspec import Struct, structs

from fleet import ops
from fleet.agent.step import FOREIGN_FROM
from fleet.drivers.seam import Sighting
from fleet.sensing import Target, Track, TrackParams, begin, lost, predict, seen, update_ais, update_position

MOST_VESSELS = 64
UNKNOWN_M = 20.0  # length of a vessel that does not tell it
LONGEST_M, SHORTEST_M = 500.0, 2.0
GATE = 16.0  # a position so many mean squares from where a vessel should be is another one's
FARTHEST_GATE_M = 60.0
MATE_M = 4.0  # a new position so near to a boat of the fleet is that boat
SURE = 3  # bare positions that agree make a vessel; fewer are forgotten after
DOUBTED_S = 10.0
OLD_S = 10.0  # reports older than that are passed over
FASTEST_MPS = 60.0
FARTHEST_M = 100_000.0


class Vessel(Struct):
    """One vessel."""

    name: str
    track: Track
    told: bool  # it says its name: AIS
    reports: int = 1

    @property
    def sure(self) -> bool:
        """Whether it is there at all, and no false echo."""
        return self.told or self.reports >= SURE


class Traffic:
    """Vessels by number."""

    def __init__(self, roster: Callable[[], Iterable[str]], epoch_ns: int) -> None:
        self._roster, self._epoch_ns = roster, epoch_ns
        self.vessels: dict[float, Vessel] = {}
        self.refused = 0  # reports that cannot be true
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
        mates: Iterable[tuple[float, float]],
        now_ns: int,
    ) -> None:
        """Take in reports; `mates` are where boats of the fleet are, for a sensor sees them too."""
        places: list[tuple[float, float]] | None = None
        for one in sightings:
            x, y = _place(one, to_local)
            if not (abs(x) + abs(y) <= FARTHEST_M and _plausible(one)) or not -0.5 < _age(one, now_ns) < OLD_S:
                self.refused += 1
                continue
            at = self._seconds(one.stamp_ns)
            if one.name:
                self._told(one, x, y, at)
                continue
            vessel = self._nearest(x, y, one.position_error_m, at)
            if vessel is not None:
                vessel.track = update_position(vessel.track, x, y, one.position_error_m, at, self._params)
                vessel.track = _sized(vessel.track, one)
                vessel.reports += 1
                continue
            places = list(mates) if places is None else places
            near = MATE_M + 3.0 * one.position_error_m
            if not any(math.hypot(x - mx, y - my) < near for mx, my in places):
                self._add("", begin(self._next(), x, y, one.position_error_m, at, _length(one), None, self._params))

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
                vessel.track = _sized(vessel.track, one)
                return
        velocity = (one.v_north_mps, one.v_east_mps) if knows_v else None
        self._add(
            one.name, begin(self._next(), x, y, one.position_error_m, at, _length(one), velocity, self._params)
        )  # fmt: skip

    def _nearest(self, x: float, y: float, sigma: float, at: float) -> Vessel | None:
        """The vessel that a bare position belongs to: the nearest in terms of what is uncertain, within the gate."""
        best, least = None, GATE
        for vessel in self.vessels.values():
            here = predict(vessel.track, at, self._params)
            dx, dy = x - here.x, y - here.y
            off = 0.5 * (dx * dx + dy * dy) / (here.P11 + max(sigma, self._params.sigma_min_m) ** 2)
            if off < least and ops.hypot(dx, dy) < FARTHEST_GATE_M:
                best, least = vessel, off
        return best

    def _next(self) -> float:
        self._count += 1
        return FOREIGN_FROM + self._count

    def _add(self, name: str, track: Track) -> None:
        if len(self.vessels) >= MOST_VESSELS:
            oldest = min(self.vessels, key=lambda number: self.vessels[number].track.heard)
            del self.vessels[oldest]
        self.vessels[track.number] = Vessel(name or f"vessel-{int(track.number - FOREIGN_FROM)}", track, bool(name))

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


def _length(one: Sighting) -> float:
    return one.length_m if math.isfinite(one.length_m) else UNKNOWN_M


def _sized(track: Track, one: Sighting) -> Track:
    """The track with the length that the report tells, if it does."""
    return structs.replace(track, length=one.length_m) if math.isfinite(one.length_m) else track
