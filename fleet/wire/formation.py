"""A formation on the wire, and as missions know it."""

from __future__ import annotations

from fleet.mission.model import Mission
from fleet.mission.pattern import PATTERNS, Shape
from fleet.mission.plan import shape_of
from fleet.wire.codec import Refused
from fleet.wire.messages import MAJOR, FormationOrder, Revision


def shape_in(order: FormationOrder, mission: Mission) -> Shape:
    """The formation that an order asks for; Refused where it does not fit the mission's roster.

    An order without a pattern is of an operator who knows none: pattern, lateral distance and slots are the mission's.
    """
    launched = shape_of(mission)
    if not order.pattern:
        return Shape(launched.pattern, order.spacing_m, launched.lateral_m, order.cruise_mps, launched.slots)
    if order.pattern not in PATTERNS:
        raise Refused(f"is for a pattern {order.pattern!r} that is not known here")
    slots = dict(order.slots)
    names = [boat.name for boat in mission.boats]
    if len(slots) != len(order.slots) or slots.keys() != set(names):
        raise Refused("gives slots to other boats than the roster's")
    places = tuple(slots[name] for name in names)
    return Shape(order.pattern, order.spacing_m, order.lateral_m, order.cruise_mps, places)


def order_for(
    shape: Shape,
    mission: Mission,
    mission_id: str,
    revision: Revision,
    based_on: Revision,
    apply_in_s: float,
    stamp_ns: int,
) -> FormationOrder:
    """The order that asks for a formation."""
    names = (boat.name for boat in mission.boats)
    return FormationOrder(
        MAJOR,
        mission_id,
        revision,
        based_on,
        shape.spacing_m,
        shape.cruise_mps,
        apply_in_s,
        stamp_ns,
        shape.pattern,
        shape.lateral_m,
        tuple(zip(names, shape.slots, strict=True)),
    )
