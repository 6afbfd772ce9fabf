"""Boats of the fleet meet foreign vessels: what a scenario is, and the truth of one that was sailed.

Vessels follow their scripts and see nobody. Every random number is a hash of (seed, case, vessel, number, purpose).
"""

from __future__ import annotations

import math

import numpy as np
from msgspec import Struct

from fleet.avoidance.foreign import Edge
from fleet.guidance import Limits
from fleet.ops import FloatArray
from fleet.paths import Lane, Path, polyline, straight
from fleet.sim.batch.ships_radio import DT_S, Radio

LIMITS = Limits()


class Ship(Struct, frozen=True, kw_only=True):
    """A foreign vessel and its script."""

    x: float  # at the start [m]
    y: float
    chi: float  # course [rad]
    U: float  # [m/s]
    length: float  # [m]
    turns_s: float = math.inf  # when it begins to turn
    turn: float = 0.0  # by how much, + to starboard [rad]
    rate: float = 0.05  # how fast [rad/s]
    sensor: str = "exact"  # exact, ais, positions


class Bend(Struct, frozen=True, kw_only=True):
    """Where the path of the boats bends: a corner, rounded."""

    at_m: float  # from the start
    turn: float  # + to starboard [rad]
    radius_m: float = 20.0


class ShipCase(Struct, frozen=True, kw_only=True):
    """One scenario. Every boat sails at cruise speed along its path.

    Boats of a formation sail side by side to the north, on a path that is bent once if at all. With `courses` each
    boat sails alone on a straight path of its own.
    """

    suite: str
    seed: int
    case: int
    cruise: float  # [m/s]
    paths: tuple[tuple[float, float, float], ...]  # of each boat: north and east of its start, abscissa of its slot
    ships: tuple[Ship, ...]
    meet_s: float  # about when they meet
    limit_s: float
    edges: tuple[Edge, ...] = ()
    bend: Bend | None = None
    hull: str = "unicycle"
    limits: Limits = LIMITS
    current: tuple[float, float] = (0.0, 0.0)  # north, east [m/s]
    radio: Radio = Radio()
    radius_m: float = 6.0  # boats of the fleet keep it from each other
    courses: tuple[float, ...] = ()  # of boats that sail each alone [rad]

    @property
    def leader(self) -> int:
        """Who decides for a formation: the foremost boat, of several the first."""
        return max(range(len(self.paths)), key=lambda i: (self.paths[i][2], -i))

    @property
    def parties(self) -> tuple[tuple[int, ...], ...]:
        """Boats that decide together: a formation, or each alone. The first of a party decides for it."""
        boats = range(len(self.paths))
        if self.courses:
            return tuple((i,) for i in boats)
        return ((self.leader, *(i for i in boats if i != self.leader)),)

    def path(self) -> Path:
        """The path of the first boat; the others sail beside it."""
        x, y, _ = self.paths[0]
        far = self._far
        if self.bend is None:
            return straight((x, y), (x + far, y))
        corner, turn = x + self.bend.at_m, self.bend.turn
        end = (corner + far * math.cos(turn), y + far * math.sin(turn))
        return polyline([(x, y), (corner, y), end], self.bend.radius_m)

    def path_of(self, boat: int) -> Path | Lane:
        """That of any boat."""
        if self.courses:
            (x, y, _), chi = self.paths[boat], self.courses[boat]
            return straight((x, y), (x + self._far * math.cos(chi), y + self._far * math.sin(chi)))
        aside = self.paths[boat][1] - self.paths[0][1]
        return self.path() if aside == 0.0 else Lane(self.path(), aside)

    @property
    def _far(self) -> float:
        """Farther than any boat comes [m]."""
        return 2.0 * self.limit_s * self.limits.speed_max_mps + 1000.0

    def begins_at(self, boat: int) -> float:
        """Abscissa of a boat at the start, on its own path [m]."""
        return 0.0 if self.courses else self.paths[boat][0] - self.paths[0][0]


class Decided(Struct, frozen=True, gc=False):
    """A decision of a boat."""

    t: float
    boat: int
    acting: float
    a: float
    factor: float
    target: float
    range_m: float  # to that vessel, true
    reason: float


class Voyage(Struct, frozen=True):
    """The truth of a scenario; arrays are (tick, boat) or (tick, ship)."""

    t: FloatArray
    x: FloatArray
    y: FloatArray
    psi: FloatArray
    u: FloatArray
    ship_x: FloatArray
    ship_y: FloatArray
    ship_chi: FloatArray
    decisions: tuple[Decided, ...]
    complete: bool  # over before its time was up


def ship_track(ship: Ship, ticks: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(x, y, course) of a vessel at every tick."""
    t = np.arange(ticks) * DT_S
    begun = np.clip(t - ship.turns_s, 0.0, None) if math.isfinite(ship.turns_s) else np.zeros(ticks)
    turned = np.minimum(begun * ship.rate, abs(ship.turn)) * math.copysign(1.0, ship.turn)
    chi = ship.chi + turned
    x = ship.x + np.concatenate([[0.0], np.cumsum(ship.U * np.cos(chi[:-1]) * DT_S)])
    y = ship.y + np.concatenate([[0.0], np.cumsum(ship.U * np.sin(chi[:-1]) * DT_S)])
    return x, y, chi
