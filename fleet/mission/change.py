"""Changes of a formation under way, as an operator words them: what it is afterwards."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from msgspec import Struct, structs

from fleet.errors import UsageError
from fleet.mission.pattern import PATTERNS, Shape, redrawn
from fleet.mission.problem import hint

MOST_SLOT = 1000.0


class Kind(Struct, frozen=True):
    """One thing about a formation that can be changed."""

    value: str
    """What its value is."""
    unit: str = ""


CHANGES: dict[str, Kind] = {
    "spacing": Kind("metres", "m"),
    "lateral": Kind("metres", "m"),
    "speed": Kind("m/s", "m/s"),
    "pattern": Kind("one of " + ", ".join(PATTERNS)),
    "leader": Kind("a boat, which exchanges slots with the present leader"),
    "slots": Kind("b1=0,b2=-1: the slots of some boats; the others keep theirs"),
}
"""What `set` can change."""


def changed(names: Sequence[str], shape: Shape, what: str, value: float | str) -> Shape:
    """The formation after a change; UsageError for a value that means nothing. Whether it can be sailed is not asked.

    Args:
        names: of the boats, in the order of the roster
        shape: the formation before
        what: a key of `CHANGES`
        value: metres, metres a second, or words
    """
    if what not in CHANGES:
        raise UsageError(f"set {what!r}: expected one of {', '.join(CHANGES)}")
    if what == "pattern":
        return _pattern(shape, str(value))
    if what == "leader":
        return _leader(names, shape, str(value))
    if what == "slots":
        return _slots(names, shape, str(value))
    field = {"spacing": "spacing_m", "lateral": "lateral_m", "speed": "cruise_mps"}[what]
    return structs.replace(shape, **{field: _number(what, value)})


def words(names: Sequence[str], shape: Shape, what: str) -> str:
    """What `what` is in a formation: `20 m`, `wedge`, `b1=0, b2=-1`."""
    if what == "pattern":
        return shape.pattern
    if what == "leader":
        return names[shape.leading]
    if what == "slots":
        return ", ".join(f"{name}={slot:g}" for name, slot in zip(names, shape.slots, strict=True))
    number = {"spacing": shape.spacing_m, "lateral": shape.lateral_m, "speed": shape.cruise_mps}[what]
    return f"{number:g} {CHANGES[what].unit}"


def _number(what: str, value: float | str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UsageError(f"{what} {value!r}: expected a number of {CHANGES[what].value}")
    return number


def _pattern(shape: Shape, name: str) -> Shape:
    """Another pattern, its slots taken by the boats that are nearest; the same one leaves all as it is."""
    if name not in PATTERNS:
        raise UsageError(f"pattern {name!r}: no such pattern{hint(name, PATTERNS)}")
    return shape if name == shape.pattern else redrawn(shape, name)


def _leader(names: Sequence[str], shape: Shape, name: str) -> Shape:
    """The boat and the one that leads exchange their slots."""
    one, two = _known(names, name, "leader"), shape.leading
    slots = list(shape.slots)
    slots[one], slots[two] = slots[two], slots[one]
    return structs.replace(shape, slots=tuple(slots))


def _slots(names: Sequence[str], shape: Shape, text: str) -> Shape:
    """Other slots for the boats named."""
    slots = list(shape.slots)
    given: set[str] = set()
    for part in re.split(r"[,\s]+", text.strip()):
        name, equals, number = part.partition("=")
        i = _known(names, name, "slots")
        try:
            slot = float(number)
        except ValueError:
            slot = math.nan
        if not equals or not abs(slot) <= MOST_SLOT:
            raise UsageError(f"slots {part!r}: expected BOAT=SLOT, such as {names[0]}=0, a number up to {MOST_SLOT:g}")
        if name in given:
            raise UsageError(f"slots {text!r}: {name} is named twice")
        given.add(name)
        slots[i] = slot + 0.0
    return structs.replace(shape, slots=tuple(slots))


def _known(names: Sequence[str], name: str, what: str) -> int:
    if name not in names:
        raise UsageError(f"{what} {name!r}: no such boat{hint(name, names)}")
    return list(names).index(name)
