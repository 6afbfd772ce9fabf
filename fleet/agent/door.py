"""What a boat does not look at closely: missions whose mere checking would take its memory or its time."""

from __future__ import annotations

import math
from itertools import pairwise

import msgspec

from fleet.geo import Datum, plane_of
from fleet.mission.load import decode
from fleet.mission.model import Mission, Polyline, Sine, Through
from fleet.mission.plan import metres
from fleet.wire.codec import Refused

LARGEST = 400_000  # bytes; ten thousand points are 260 kB
MOST_BOATS = 128
MOST_PATHS = 128
MOST_POINTS = 10_000
MOST_EVENTS = 1000
MOST_WAVES = 10_000
LONGEST_CURVES_M = 100_000.0  # sines and splines of a mission together: a cell a metre, half a kilobyte each

HEAVY_CURVES_M = 5_000.0  # from here on, or from so many points or paths, checking takes longer than a tick
HEAVY_POINTS = 1000
HEAVY_PATHS = 10

_decoder = msgspec.msgpack.Decoder(Mission)


def read(content: bytes) -> Mission:
    """The mission in the bytes; Refused, or MissionError, when it cannot be one that a boat would sail."""
    if len(content) > LARGEST:
        raise Refused(f"has {len(content)} bytes, at most {LARGEST}")
    try:
        mission = _decoder.decode(content)  # the first misfit ends it: a list of all could be as long as the message
    except msgspec.ValidationError as error:
        raise Refused(f"does not fit: {error}") from None
    except (msgspec.DecodeError, RecursionError, ValueError):
        raise Refused("does not decode") from None
    _within_bounds(mission)
    return decode(content)


def heavy(mission: Mission) -> bool:
    """Whether checking it takes long."""
    return _points(mission) > HEAVY_POINTS or len(mission.paths) > HEAVY_PATHS or _curves_m(mission) > HEAVY_CURVES_M


def _points(mission: Mission) -> int:
    points = len(mission.fence.points) if mission.fence is not None else 0
    return points + sum(len(spec.points) for spec in mission.paths.values() if isinstance(spec, Polyline | Through))


def _within_bounds(mission: Mission) -> None:
    for count, most, what in (
        (len(mission.boats), MOST_BOATS, "boats"),
        (len(mission.paths), MOST_PATHS, "paths"),
        (_points(mission), MOST_POINTS, "points"),
        (len(mission.timeline) + len(mission.checks), MOST_EVENTS, "events and checks"),
    ):
        if count > most:
            raise Refused(f"has {count} {what}, at most {most}")
    curves = _curves_m(mission)
    if not curves <= LONGEST_CURVES_M:
        raise Refused(f"has curves of {curves / 1000:.0f} km, at most {LONGEST_CURVES_M / 1000:.0f}")


def _curves_m(mission: Mission) -> float:
    """Length of all sines and splines together, roughly [m]."""
    plane = plane_of(Datum(mission.datum.lat_deg, mission.datum.lon_deg))
    total = 0.0
    for spec in mission.paths.values():
        if isinstance(spec, Through):
            total += sum(math.dist(metres(a, plane), metres(b, plane)) for a, b in pairwise(spec.points))
        elif isinstance(spec, Sine):
            long = math.dist(metres(spec.start, plane), metres(spec.end, plane))
            waves = long / spec.wavelength_m
            if not waves <= MOST_WAVES:
                raise Refused(f"has a sine of {waves:.0f} waves, at most {MOST_WAVES}")
            total += long * (1.0 + 4.0 * abs(spec.amplitude_m) / spec.wavelength_m)
    return total
