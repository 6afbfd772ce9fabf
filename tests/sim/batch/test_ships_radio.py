"""What boats hear of each other: lost, late, doubled, and what a follower does without its leader."""

from __future__ import annotations

import pytest
from msgspec import structs

from fleet.avoidance.foreign import Reason
from fleet.sim.batch.hearing import Message
from fleet.sim.batch.ships import ShipCase
from fleet.sim.batch.ships_cases import formation
from fleet.sim.batch.ships_judge import judge
from fleet.sim.batch.ships_radio import Radio, Said, Words
from fleet.sim.batch.ships_sail import sail


def words(k: int, boat: int = 0) -> Words:
    """A boat at 2 m/s to the north, at tick k."""
    told = Message(float(k), 0.2 * k, 5.0, 2.0, 0.0, 1.0, 0.0, 2.0, 1.0, 0.0, 1e3, 0.2 * k, 0.0, 0.0, 0.0, 0.0)
    return Words(0.1 * k, boat, told, 0.0, 0.0, 0.0, False, None)


def said(radio: Radio, boats: int = 2) -> Said:
    """A radio of boats that know of each other's start."""
    return Said(radio, [words(0, boat) for boat in range(boats)], 1, 1)


def test_a_perfect_radio_tells_everybody_but_the_speaker_at_once() -> None:
    air = said(Radio(), 3)
    air.say(10, words(10))
    assert air.heard(10, 1)[0] == air.heard(10, 2)[0] == words(10)
    assert sorted(air.heard(10, 0)) == [1, 2]


def test_a_message_that_is_late_comes_after_half_of_the_delay_at_least() -> None:
    air = said(Radio(delay_s=1.0))
    air.say(10, words(10))
    assert air.heard(14, 1)[0].t == 0.0
    assert air.heard(26, 1)[0].t == 1.0


def test_what_comes_out_of_order_or_twice_never_makes_a_boat_older() -> None:
    air, last = said(Radio(delay_s=1.0, loss=0.2)), -1.0
    heard = 0
    for k in range(400):
        air.say(k, words(k))
        known = air.heard(k, 1)[0]
        assert known.t >= last
        heard += known.t > last
        last = known.t
    assert 100 < heard < 400


def test_of_ten_messages_as_many_are_lost_as_the_radio_loses() -> None:
    air = said(Radio(loss=0.3))
    for k in range(2000):
        air.say(k, words(k))
    assert len(air._air) == pytest.approx(2000 * 0.7 * 1.05, rel=0.05)  # one in twenty comes twice


def scene(radio: Radio) -> ShipCase:
    """A formation of three that has to act."""
    return structs.replace(next(formation(21, 1, boats=3)), radio=radio)


def test_an_order_that_is_late_is_sailed_and_keeps_clear() -> None:
    case = scene(Radio(delay_s=0.5, loss=0.3))
    voyage = sail(case)
    outcome = judge(case, voyage)
    assert not outcome.contact
    assert (outcome.dom >= 1.0, outcome.alone) == (True, 0)
    begun = [d for d in voyage.decisions if d.acting > 0.5]
    first, orders = begun[0], [d for d in begun if d.boat != case.leader][:2]
    assert first.boat == case.leader == 2  # the foremost
    assert {d.boat for d in orders} == {0, 1}
    assert all(d.reason == Reason.ORDER and 0.0 < d.t - first.t < 2.0 for d in orders)


def test_boats_that_hear_nobody_decide_for_themselves() -> None:
    voyage = sail(scene(Radio(loss=1.0)))
    deciders = {d.boat for d in voyage.decisions if d.acting > 0.5}
    assert all(d.reason != Reason.ORDER for d in voyage.decisions)
    assert len(deciders) >= 2
