"""A formation on the wire and as missions know it: there and back, from older operators, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest
from msgspec import structs

from fleet.mission.load import load
from fleet.mission.pattern import PATTERNS, Shape, slots_of
from fleet.wire.codec import Refused, decode_formation, encode
from fleet.wire.formation import order_for, shape_in
from fleet.wire.messages import FormationOrder, Revision, Signed

MISSION = load("swath")


def order(shape: Shape) -> FormationOrder:
    return order_for(shape, MISSION, "m", Revision(1, "anna"), Revision(), 2.0, 3)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_formation_comes_back_as_it_went(pattern: str) -> None:
    shape = Shape(pattern, -12.0, 9.5, 1.1, slots_of(pattern, 5))
    assert shape_in(decode_formation(Signed(encode(order(shape)))), MISSION) == shape


def test_an_order_of_an_operator_who_knows_no_patterns_keeps_the_missions() -> None:
    old = structs.replace(order(Shape("wedge", 12.0, 9.0, 0.8, slots_of("wedge", 5))), pattern="", slots=())
    assert shape_in(old, MISSION) == Shape("abreast", 12.0, 10.0, 0.8, (0.0, 1.0, -1.0, 2.0, -2.0))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"lateral_m": math.nan}, "not finite"),
        ({"slots": (("b1", math.inf),)}, "not finite"),
        ({"slots": (("b1", math.inf), ("b2", -math.inf))}, "not finite"),
        ({"lateral_m": 1e6}, "too long"),
        ({"slots": (("b1", 1e30),)}, "too long"),
        ({"pattern": "wedge\n"}, "impossible order"),
    ],
)
def test_what_cannot_be_a_formation_is_refused_at_the_door(change: dict[str, Any], why: str) -> None:
    spoilt = structs.replace(order(Shape("wedge", 12.0, 9.0, 0.8, slots_of("wedge", 5))), **change)
    with pytest.raises(Refused, match=why):
        decode_formation(Signed(encode(spoilt)))


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"pattern": "spiral"}, "a pattern 'spiral' that is not known here"),
        ({"slots": (("b1", 0.0),)}, "other boats than the roster's"),
        ({"slots": tuple((f"b{i}", float(i)) for i in range(2, 7))}, "other boats than the roster's"),
        ({"slots": tuple(("b1", float(i)) for i in range(5))}, "other boats than the roster's"),
    ],
)
def test_what_does_not_fit_the_mission_is_refused(change: dict[str, Any], why: str) -> None:
    spoilt = structs.replace(order(Shape("wedge", 12.0, 9.0, 0.8, slots_of("wedge", 5))), **change)
    with pytest.raises(Refused, match=why):
        shape_in(spoilt, MISSION)
