"""Keeping clear of vessels that are not of the fleet (COLREGS 8, 13 to 17): commit to one action and hold it."""

from fleet.avoidance.foreign.law import START, keep_clear, order_of, sail_order
from fleet.avoidance.foreign.memory import Memory
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.types import (
    FOLLOW_PATH,
    NEVER_S,
    Action,
    Advice,
    Boat,
    Contact,
    Edge,
    Encounter,
    Kind,
    Mate,
    Order,
    PathLike,
    Reason,
    Role,
    TargetLike,
)

__all__ = [
    "FOLLOW_PATH",
    "NEVER_S",
    "START",
    "Action",
    "Advice",
    "Boat",
    "Contact",
    "Edge",
    "Encounter",
    "ForeignParams",
    "Kind",
    "Mate",
    "Memory",
    "Order",
    "PathLike",
    "Reason",
    "Role",
    "TargetLike",
    "keep_clear",
    "order_of",
    "sail_order",
]
