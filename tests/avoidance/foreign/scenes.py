"""A boat that sails north, and vessels that meet it."""

from __future__ import annotations

import math

from msgspec import structs

from fleet.avoidance.foreign import START, Advice, Boat, Edge, ForeignParams, Mate, Memory, keep_clear
from fleet.guidance import Limits, follow
from fleet.hulls import CALM, HullState, unicycle
from fleet.paths import Path, straight
from fleet.sensing import Target

P = ForeignParams()
LIMITS = Limits()
PATH = straight((0.0, 0.0), (5000.0, 0.0))


def target(
    x: float,
    y: float,
    course_deg: float = 0.0,
    U: float = 0.0,
    length: float = 20.0,
    number: float = 1.0,
    **given: float,
) -> Target:
    """A vessel that is known exactly."""
    vx, vy = U * math.cos(math.radians(course_deg)), U * math.sin(math.radians(course_deg))
    values = {"P11": 0.0, "P12": 0.0, "P22": 0.0, "om": 0.0, "age": 0.0, "usable": 1.0, **given}
    return Target(number=number, x=x, y=y, vx=vx, vy=vy, length=length, **values)


def boat(x: float = 0.0, y: float = 0.0, cruise: float = 1.0, path: Path = PATH, chi: float = 0.0) -> Boat:
    """A boat on its way north."""
    return Boat(x, y, chi, cruise, 0.0, path.project(x, y), cruise, LIMITS, path)


def meeting(course_deg: float, U: float, after_s: float, length: float = 20.0, number: float = 1.0) -> Target:
    """A vessel that would be on a boat at 1 m/s `after_s` from now."""
    chi = math.radians(course_deg)
    x, y = after_s - U * math.cos(chi) * after_s, -U * math.sin(chi) * after_s
    return target(x, y, course_deg, U, length, number)


class Sea:
    """One boat among vessels on straight courses, 10 ticks a second."""

    def __init__(
        self, targets: list[Target], cruise: float = 1.0, edges: tuple[Edge, ...] = (), path: Path = PATH
    ) -> None:
        self.targets, self.cruise, self.edges, self.path = targets, cruise, edges, path
        start = path.at(0.0)
        self.hull: HullState[float] = unicycle.start(start.x, start.y, math.atan2(start.ty, start.tx), cruise)
        self.s, self.t = 0.0, 0.0
        self.memory: Memory = START
        self.decisions: list[Advice] = []
        self.advice: Advice | None = None
        self.mates: tuple[Mate, ...] = ()
        self.nearest = math.inf

    def now(self) -> list[Target]:
        """The vessels where they are now."""
        return [structs.replace(t, x=t.x + self.t * t.vx, y=t.y + self.t * t.vy) for t in self.targets]

    def sail(self, seconds: float) -> Sea:
        """So much later."""
        for _ in range(round(seconds * 10)):
            hull = self.hull
            own = Boat(hull.x, hull.y, hull.psi, hull.u, hull.r, self.s, self.cruise, LIMITS, self.path)
            self.memory, advice = keep_clear((own,), self.now(), self.mates, self.edges, self.memory, P, self.t)
            self.advice = advice
            if advice.decided > 0.5:
                self.decisions.append(advice)
            f = follow(hull.x, hull.y, hull.psi, hull.u, self.path.at(self.s), P.follow)
            u_d, r_d = (advice.u_d, advice.r_d) if advice.acting > 0.5 else (self.cruise, f.r_d)
            self.hull = unicycle.advance(hull, u_d, r_d, CALM, LIMITS, 0.1)
            self.s, self.t = self.s + 0.1 * f.s_dot, self.t + 0.1
            self.nearest = min([self.nearest, *(c.distance / c.clearance for c in advice.contacts)])
        return self
