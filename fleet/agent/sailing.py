"""A mission as a boat holds it: the operator's words, the plan, the formation in force and the next one."""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import Struct

from fleet.mission.pattern import Place, Shape
from fleet.mission.plan import Plan
from fleet.mission.redraw import Redrawing
from fleet.wire.messages import FormationOrder, MissionOrder, Revision, Signed


class Sailing(Struct):
    """A mission that this boat holds."""

    order: MissionOrder
    words: Signed
    plan: Plan
    number: int  # of this boat in the roster
    starts_ns: int  # when it begins to follow
    formation: FormationOrder  # in force
    shape: Shape  # what it asks for
    drawn: tuple[Place, ...]  # where everybody's place is in it, ahead of slot 0 and to starboard of the path [m]
    redrawing: Redrawing | None = None  # how the fleet comes from the formation before to this one
    formation_words: Signed | None = None  # None: revision 0, which the mission's words carry
    pending: FormationOrder | None = None
    pending_words: Signed | None = None
    pending_ns: int = 0
    switched_ns: int = 0

    def ahead(self, number: int, now_ns: int) -> float:
        """o_i: where a boat's place is now, ahead of slot 0 [m]."""
        if self.redrawing is None:
            return self.drawn[number][0]
        return self.redrawing.ahead(number, (now_ns - self.switched_ns) * 1e-9)

    def places(self, now_ns: int) -> tuple[Place, ...]:
        """Where everybody's place is now, ahead of slot 0 and to starboard of the path [m]."""
        if self.redrawing is None:
            return self.drawn
        return self.redrawing.places((now_ns - self.switched_ns) * 1e-9)

    @property
    def held(self) -> Revision:
        """Newest formation that this boat holds."""
        return self.pending.revision if self.pending is not None else self.formation.revision


def formation_words(order: FormationOrder, launched: Shape) -> str:
    """A formation; pattern and slots where they are not as they were at launch."""
    words = f"spacing {order.spacing_m:g} m, cruise {order.cruise_mps:g} m/s"
    now = (order.pattern, order.lateral_m, tuple(slot for _, slot in order.slots))
    if not order.pattern or now == (launched.pattern, launched.lateral_m, launched.slots):
        return words
    slots = ", ".join(f"{boat}={slot:g}" for boat, slot in order.slots)
    return f"{words}, {order.pattern}, lateral {order.lateral_m:g} m, slots {slots}"


def joined(names: Iterable[str]) -> str:
    """Names with commas."""
    return ", ".join(names)
