"""Vessels that are not of the fleet, and what a scanner sees of them: whose each thing is, and what of it is motion.

Pure, but that `is_mate` counts in a vessel.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from msgspec import Struct, structs

from fleet import ops
from fleet.drivers.seam import Sighting
from fleet.sensing import Track, TrackParams, predict, update_position

UNKNOWN_M = 20.0  # length of a vessel that does not tell it
GATE = 16.0  # a position so many mean squares from where a vessel should be is another one's
FARTHEST_GATE_M = 60.0
MATE_M = 4.0  # a new position so near to a boat of the fleet is that boat
SURE = 3  # bare positions that agree make a vessel; fewer are forgotten after
BESIDE = 6  # such looks, and it is the boat
SAME_MPS = 0.6
SLIDES = 0.5  # of its length, by which the middle of what is seen of a hull may move along it

Placed = tuple[Sighting, float, float, float]
"""A sighting, x, y, and when [s]."""


class Mate(NamedTuple):
    """A boat of the fleet, as its own messages tell."""

    x: float
    y: float
    error: float  # by so much more it may be elsewhere [m]
    vx: float = 0.0
    vy: float = 0.0


class Vessel(Struct):
    """One vessel."""

    name: str
    track: Track
    told: bool  # it says its name: AIS
    reports: int = 1
    beside: int = 0  # looks of a scanner, one after the other, at which it was where a boat of the fleet is
    sized: bool = False  # a sensor of ours saw how long it is, or it told

    @property
    def sure(self) -> bool:
        """Whether it is there at all, and no false echo."""
        return self.told or self.reports >= SURE


def length_of(one: Sighting) -> float:
    """Its length as it is told, else what an unknown one has [m]."""
    return one.length_m if math.isfinite(one.length_m) else UNKNOWN_M


def matched(
    vessels: Mapping[float, Vessel], turn: Sequence[Placed], params: TrackParams
) -> dict[int, tuple[Vessel, float]]:
    """By place in the turn, the vessel that a thing is, and how far off that is [m]: the likeliest pairs first.

    A thing is not farther from its vessel than both their hulls reach, and three times the errors.
    """
    when = max(at for _, _, _, at in turn)
    pairs: list[tuple[float, int, float, float]] = []
    for number, vessel in vessels.items():
        here = predict(vessel.track, when, params)
        for i, (one, x, y, _) in enumerate(turn):
            away, sigma = ops.hypot(x - here.x, y - here.y), max(one.position_error_m, params.sigma_min_m)
            off = 0.5 * away * away / (here.P11 + sigma * sigma)
            reach = 0.5 * (here.length + length_of(one)) + 3.0 * (sigma + ops.sqrt(here.P11))
            if off < GATE and away < min(reach, FARTHEST_GATE_M):
                pairs.append((off, i, number, away))
    found: dict[int, tuple[Vessel, float]] = {}
    taken: set[float] = set()
    for _, i, number, away in sorted(pairs):
        if i not in found and number not in taken:
            taken.add(number)
            found[i] = (vessels[number], away)
    return found


def passed(track: Track, one: Sighting, x: float, y: float, at: float, params: TrackParams) -> Track:
    """The track of a hull of which more or less shows as it is passed; that is no motion.

    Where more of it shows than before, its middle is elsewhere than was thought, by at most half of what is new.
    Where less shows, that may be any part of it. What shows changes slowly: the same error is in many turns, and
    the filter is told a larger one, half the length.
    """
    here = predict(track, at, params)
    dx, dy = x - here.x, y - here.y
    more = 0.5 * (length_of(one) - track.length)
    share = min(abs(more) / max(ops.hypot(dx, dy), 1e-9), 1.0)
    if more > 0.0:
        track = structs.replace(track, x=track.x + share * dx, y=track.y + share * dy)
    else:
        x, y = x - share * dx, y - share * dy
    error = math.hypot(one.position_error_m, SLIDES * max(length_of(one), track.length))
    return update_position(track, x, y, error, at, params)


def is_mate(vessel: Vessel, one: Sighting, places: Iterable[Mate]) -> bool:
    """A vessel without a name that stays where a boat of the fleet is, and goes as it goes, is that boat."""
    t = vessel.track
    near, as_fast = MATE_M + 3.0 * one.position_error_m, SAME_MPS + 2.0 * ops.sqrt(t.P22)
    same = any(
        ops.hypot(t.x - mate.x, t.y - mate.y) < near + mate.error
        and ops.hypot(t.vx - mate.vx, t.vy - mate.vy) < as_fast
        for mate in places
    )
    vessel.beside = vessel.beside + 1 if same and not vessel.told else 0
    return vessel.beside >= BESIDE
