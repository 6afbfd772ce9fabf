"""What boats hear of each other: lost, late, doubled, and what a follower does without its leader."""

from __future__ import annotations

import pytest
from msgspec import structs

from fleet.avoidance.foreign import Reason
from fleet.sim.batch.ships import ShipCase, sail
from fleet.sim.batch.ships_cases import formation
from fleet.sim.batch.ships_radio import LINK_S, Radio, Said, State
from fleet.sim.batch.ships_results import judge


def state(k: int, boat: int = 0) -> State:
    """A boat at 2 m/s to the north, at tick k."""
    t = 0.1 * k
    return State(t, boat, 2.0 * t, 5.0, 2.0, 0.0, 0.0, 2.0, 0.0, 2.0 * t, None)


def test_a_perfect_radio_tells_everybody_but_the_speaker_at_once() -> None:
    said = Said(Radio(), 3, 1, 1)
    said.say(10, state(10))
    assert said.heard(10, 1) == said.heard(10, 2) == [state(10)]
    assert said.heard(10, 0) == []


def test_a_message_that_is_late_is_moved_on_by_its_age() -> None:
    said = Said(Radio(delay_s=1.0), 2, 1, 1)
    said.say(10, state(10))
    assert said.heard(14, 1) == []  # half of the delay at least
    (known,) = said.heard(26, 1)
    assert (known.t, known.x) == (1.0, pytest.approx(2.0 * 2.6))


def test_what_comes_out_of_order_or_twice_never_makes_a_boat_older() -> None:
    said, last = Said(Radio(delay_s=1.0, loss=0.2), 2, 1, 1), -1.0
    heard = 0
    for k in range(400):
        said.say(k, state(k))
        for known in said.heard(k, 1):
            assert known.t >= last
            heard += known.t > last
            last = known.t
    assert 100 < heard < 400


def test_of_ten_messages_as_many_are_lost_as_the_radio_loses() -> None:
    said = Said(Radio(loss=0.3), 2, 1, 1)
    for k in range(2000):
        said.say(k, state(k))
    assert len(said._air) == pytest.approx(2000 * 0.7 * 1.05, rel=0.05)  # one in twenty comes twice


def test_a_boat_that_is_silent_is_lost_after_three_seconds() -> None:
    said = Said(Radio(), 2, 1, 1)
    said.say(10, state(10))
    assert said.heard(10 + round(LINK_S * 10), 1) != []
    assert said.heard(11 + round(LINK_S * 10), 1) == []


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
    first, orders = begun[0], [d for d in begun if d.boat > 0][:2]
    assert {d.boat for d in orders} == {1, 2}
    assert all(d.reason == Reason.ORDER and 0.0 < d.t - first.t < 2.0 for d in orders)


def test_boats_that_hear_nobody_decide_for_themselves() -> None:
    voyage = sail(scene(Radio(loss=1.0)))
    deciders = {d.boat for d in voyage.decisions if d.acting > 0.5}
    assert all(d.reason != Reason.ORDER for d in voyage.decisions)
    assert len(deciders) >= 2
