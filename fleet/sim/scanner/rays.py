"""What a scanner's beams meet: hulls as capsules; boat and hulls move during the turn. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from msgspec import Struct

if TYPE_CHECKING:
    import numpy as np

    Numbers = np.ndarray[Any, np.dtype[np.float64]]

NOWHERE = math.inf


class Body(Struct, frozen=True):
    """A hull, now: all points within `radius` of a line along it."""

    x: float  # north [m]
    y: float  # east [m]
    psi: float  # heading [rad]
    vx: float  # over ground, north [m/s]
    vy: float  # over ground, east [m/s]
    half: float  # length of the line to either side of the middle [m]
    radius: float  # [m]


def vessel(x: float, y: float, psi: float, vx: float, vy: float, length: float) -> Body:
    """A vessel, five times as long as wide: the hull by which encounters are judged."""
    return Body(x, y, psi, vx, vy, 0.4 * length, 0.1 * length)


def boat(x: float, y: float, psi: float, vx: float, vy: float, length: float) -> Body:
    """A boat of the fleet, twice as long as wide."""
    return Body(x, y, psi, vx, vy, 0.25 * length, 0.25 * length)


class Turn(Struct, frozen=True):
    """The scanner at the end of a turn, and how it moved until then."""

    x: float  # of the scanner, north [m]
    y: float  # east [m]
    psi: float  # heading of its front [rad]
    vx: float  # over ground [m/s]
    vy: float
    r: float  # yaw rate [rad/s]
    beam_s: float  # from beam to beam


def ranges(turn: Turn, bearings: Numbers, bodies: Iterable[Body], most_m: float) -> Numbers:
    """To the nearest hull along each beam [m]; infinite beyond `most_m`.

    Args:
        turn: where the scanner is at the last beam
        bearings: of the beams from its front, in the order of measuring [rad]
        bodies: the hulls as they are at the last beam
        most_m: the scanner's reach
    """
    import numpy as np

    before: Numbers = turn.beam_s * np.arange(
        len(bearings) - 1.0, -1.0, -1.0, dtype=np.float64
    )  # the time from each beam to the last
    heading: Numbers = turn.psi - turn.r * before + bearings
    dx: Numbers = np.cos(heading)
    dy: Numbers = np.sin(heading)
    nearest = np.full(len(bearings), NOWHERE)
    for body in bodies:
        px, py = turn.x - body.x, turn.y - body.y
        away = math.hypot(px, py)
        if away - body.half - body.radius > most_m:
            continue
        ox: Numbers = px - (turn.vx - body.vx) * before  # the scanner, seen from the hull's middle
        oy: Numbers = py - (turn.vy - body.vy) * before
        met = _capsule(ox, oy, dx, dy, body)
        np.minimum(nearest, met, out=nearest)
    return np.where(nearest <= most_m, nearest, NOWHERE)


def _capsule(ox: Numbers, oy: Numbers, dx: Numbers, dy: Numbers, body: Body) -> Numbers:
    """Along each beam to the hull; the two round ends, and the two sides between them."""
    import numpy as np

    s, c = math.sin(body.psi), math.cos(body.psi)
    x, y = ox * c + oy * s, oy * c - ox * s
    ux, uy = dx * c + dy * s, dy * c - dx * s
    met = np.minimum(_round(x - body.half, y, ux, uy, body.radius), _round(x + body.half, y, ux, uy, body.radius))
    with np.errstate(divide="ignore", invalid="ignore"):
        for side in (-body.radius, body.radius):
            along = (side - y) / uy
            on = (along > 0.0) & (abs(x + along * ux) <= body.half)
            met = np.where(on, np.minimum(met, along), met)
    return met


def _round(x: Numbers, y: Numbers, ux: Numbers, uy: Numbers, radius: float) -> Numbers:
    """Along each beam to a circle about the origin; from inside, to its far side."""
    import numpy as np

    b = x * ux + y * uy
    under = b * b - (x * x + y * y - radius * radius)
    root = np.sqrt(np.maximum(under, 0.0))
    near, far = -b - root, -b + root
    along = np.where(near > 0.0, near, far)
    return np.where((under >= 0.0) & (along > 0.0), along, NOWHERE)
