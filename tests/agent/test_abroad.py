"""Boats that sail one decision about a foreign vessel, and come back from it, by hand."""

from __future__ import annotations

import pytest
from msgspec import structs

from fleet.agent.abroad import ALONE, FOLLOWS, LEADS, Abroad, Sea, Watch, together, watch
from fleet.avoidance.foreign import FOLLOW_PATH, START, Action, Memory, Order, keep_clear
from fleet.avoidance.types import Peer
from tests.avoidance.foreign.scenes import P, boat
from tests.avoidance.scenes import peer_at

SEA = Sea(P, ())
EAST = Action(acting=1.0, a=1.5707963267948966, factor=0.5, cx=0.0, cy=1.0, sense=0.0, at=0.0)
SAILED = structs.replace(START, sailed=EAST, ordered=EAST)


def abroad(part: float, heard: Action | None = None) -> Abroad:
    """Boats 1 and 2 sail the same decision; boat 3 does not."""
    order = None if heard is None else Order(0.0, 1.0, heard, -1.0, 0.0)
    return Abroad(0.0, (), part, (), order, (), (1.0, 2.0))


def watched(memory: Memory, returns: float = 0.0) -> Watch:
    """What a boat remembers, and was advised for it."""
    return Watch(*keep_clear((boat(),), (), (), (), memory, P, 0.0), returns)


PEERS = [peer_at(number, 10.0 * number, 0.0, 0.0) for number in (1.0, 2.0, 3.0)]


def marked(found: object) -> list[float]:
    assert isinstance(found, list)
    return [p.number for p in found if isinstance(p, Peer) and p.together == 1.0]


def test_while_a_decision_is_sailed_those_who_sail_it_are_on_its_course_whatever_they_said() -> None:
    found = together(PEERS, abroad(LEADS), watched(SAILED))
    assert marked(found) == [1.0, 2.0]
    assert [(p.gx, p.gy, p.tx, p.ty, p.u_d) for p in found[:2]] == [(0.0, 1.0, 0.0, 1.0, 0.5)] * 2
    assert [(p.vx, p.vy) for p in found] == [(p.vx, p.vy) for p in PEERS]  # the brake needs what is
    assert found[2] == PEERS[2]


def test_on_the_way_back_they_are_on_the_plans_that_they_tell() -> None:
    found = together(PEERS, abroad(FOLLOWS), watched(START, returns=1.0))
    assert marked(found) == [1.0, 2.0]
    assert [structs.replace(p, together=0.0) for p in found] == PEERS


def test_who_decides_alone_or_follows_its_path_turns_with_nobody() -> None:
    assert marked(together(PEERS, abroad(ALONE), watched(SAILED))) == []
    assert marked(together(PEERS, abroad(FOLLOWS), watched(structs.replace(SAILED, alone=1.0)))) == []
    assert marked(together(PEERS, abroad(FOLLOWS), watched(START))) == []
    assert marked(together(PEERS, abroad(FOLLOWS), None)) == []


@pytest.mark.parametrize(("part", "returns"), [(FOLLOWS, 1.0), (ALONE, 0.0)])
def test_a_boat_that_was_told_to_resume_returns_until_it_is_back_on_its_path(part: float, returns: float) -> None:
    off, on = structs.replace(boat(), y=20.0), structs.replace(boat(), y=0.9)
    before = watched(SAILED)
    told = abroad(part, FOLLOW_PATH)
    if part == ALONE:
        before = watched(structs.replace(SAILED, ordered=FOLLOW_PATH))
    after = watch(told, before, off, (), 0.0, SEA)
    assert (0.0 if after is None else after.returns) == returns
    if after is not None:
        later = watch(told, after, off, (), 0.0, SEA)
        assert later is not None
        assert later.returns == 1.0
        assert watch(told, after, on, (), 0.0, SEA) is None  # nothing is left to remember
