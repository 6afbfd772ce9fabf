"""What every hull takes and gives: the seam behind which models of boats are exchanged."""

from __future__ import annotations

from typing import Generic, Protocol

from msgspec import Struct

from fleet.guidance.limits import Limits
from fleet.ops import R

STEP_S = 0.02
"""Hulls are integrated at 50 Hz [s]."""


class HullState(Struct, Generic[R], frozen=True, gc=False):
    """A boat in the water, with the memory of its inner loops."""

    x: R  # north [m]
    y: R  # east [m]
    psi: R  # heading, in [-pi, pi] [rad]
    u: R  # surge: velocity over ground along the heading [m/s]
    v: R  # sway: velocity over ground to starboard [m/s]
    r: R  # yaw rate, + to starboard [rad/s]
    i_u: R  # integral of the surge loop [m/s2]
    i_r: R  # integral of the yaw loop [rad/s2]


class Water(Struct, Generic[R], frozen=True, gc=False):
    """What moves the boat besides itself, where the boat is."""

    current_n: R  # velocity of the water over ground, north [m/s]
    current_e: R
    wind_n: R  # leeway: what the wind adds to the drift of the hull at rest in the water, north [m/s]
    wind_e: R


class Hull(Protocol):
    """A model of a boat that takes surge over ground along the heading, and yaw rate."""

    @property
    def description(self) -> str:
        """One sentence for lists."""

    def start(self, x: float, y: float, psi: float, u: float) -> HullState[float]:
        """A boat on its course, at speed u."""

    def velocity(self, state: HullState[R], water: Water[R]) -> tuple[R, R]:
        """(vx, vy): velocity over ground, north and east [m/s]."""

    def advance(
        self, state: HullState[R], u_d: R, r_d: R, water: Water[R], limits: Limits, dt: float, powered: R | float = 1.0
    ) -> HullState[R]:
        """The boat dt seconds later; powered 1 obeys the set-points, 0 has no thrust and drifts."""

    def advance_by(
        self,
        steps: int,
        state: HullState[R],
        u_d: R,
        r_d: R,
        water: Water[R],
        limits: Limits,
        dt: float,
        powered: R | float,
    ) -> HullState[R]:
        """`steps` times `advance`, with equal bits."""


CALM: Water[float] = Water(0.0, 0.0, 0.0, 0.0)
"""Neither current nor wind."""


def start(x: float, y: float, psi: float, u: float) -> HullState[float]:
    """A boat on its course, at speed u."""
    return HullState(float(x), float(y), float(psi), float(u), 0.0, 0.0, 0.0, 0.0)
