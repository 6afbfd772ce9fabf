"""Voyages of wingmen, worked out before they are needed: for kilometres of path that takes longer than a tick may."""

from __future__ import annotations

from msgspec import Struct

from fleet.mission.formation import gap_needed
from fleet.mission.pattern import Shape
from fleet.mission.plan import Plan
from fleet.mission.wingman import Wingman, apart, wingmen

KEPT = 4


class Flight(Struct, frozen=True):
    """Every wingman of a mission in one formation."""

    plan: Plan
    shape: Shape
    wingmen: dict[int, Wingman]
    apart: tuple[tuple[int, int], ...]  # boats whose places keep far enough from each other all the way

    def mates(self, number: int) -> frozenset[int]:
        """Whose places keep apart from that of a boat."""
        return frozenset(two if one == number else one for one, two in self.apart if number in (one, two))


class Flights:
    """The latest of them. `prepare` is for a thread that has time; what it finds is taken by the one that decides."""

    def __init__(self) -> None:
        self._known: tuple[Flight, ...] = ()

    def prepare(self, plan: Plan, shape: Shape) -> Flight:
        """Work one out, unless it is there."""
        for flight in self._known:
            if flight.plan is plan and flight.shape == shape:
                return flight
        need = gap_needed(plan.mission)
        found = wingmen(plan, shape, need)
        pairs: tuple[tuple[int, int], ...] = ()
        if plan.mission.formation.crossing == "give-room":
            pairs = tuple((one, two) for one, two, least, _, _ in apart(found, need) if least >= need - 1.0)
        flight = Flight(plan, shape, found, pairs)
        self._known = (*self._known[-KEPT + 1 :], flight)
        return flight
