"""One look around: it goes on over some ticks where there is much to see, and sees what will be met later."""

from __future__ import annotations

import math

import msgspec
from msgspec import structs

from fleet.avoidance.foreign import FOLLOW_PATH, NEVER_S, START, Boat, Memory
from fleet.avoidance.foreign.rollout import entry, following
from fleet.avoidance.foreign.watch import LOOK_WORK, Picture, foreseen, look_on
from fleet.sensing import Target

from .scenes import P, boat, meeting, target

COLUMN = tuple(boat(10.0 * k, 6.0, chi=0.6) for k in range(10))
FIVE = [meeting(35.0 + 70.0 * k, 3.0, 80.0, number=float(k)) for k in range(5)]
SAILED = structs.replace(FOLLOW_PATH, acting=1.0, a=1.0, cx=math.cos(1.0), cy=math.sin(1.0), factor=1.0)
ACTING = structs.replace(START, ordered=SAILED, sailed=SAILED)


def looks(boats: tuple[Boat, ...], targets: list[Target], memory: Memory) -> tuple[Picture, Memory, list[float]]:
    """The picture, and how many boats were done after each tick before it was there."""
    done: list[float] = []
    while True:
        picture, memory = look_on(boats, targets, (), memory, P, 10.0)
        if picture is not None:
            return picture, memory, done
        assert memory.glance is not None
        done.append(memory.glance.done)


def test_one_boat_is_looked_at_in_one_tick_whatever_there_is_to_see() -> None:
    _, memory, done = looks(COLUMN[:1], FIVE, ACTING)
    assert (done, memory.glance) == ([], None)


def test_a_look_at_ten_boats_goes_on_over_some_ticks_and_sees_the_same_as_at_once() -> None:
    picture, memory, done = looks(COLUMN, FIVE, ACTING)
    assert 2 <= len(done) + 1 <= 5  # over before the next look is due
    assert done == sorted(set(done))
    assert memory.due_s > 10.0
    ways = [following(each, 400.0, P) for each in COLUMN]
    for d in picture.domains:
        first = min(entry(way, d, 400.0, P.clear_factor, 1.0, 0.0) for way in ways)
        (met,) = (e for e in picture.encounters if e.number == d.number)
        assert abs(met.entry - first) < 1e-9


def test_a_boat_that_leaves_in_the_middle_of_a_look_has_it_begun_anew() -> None:
    _, memory = look_on(COLUMN, FIVE, (), ACTING, P, 10.0)
    assert memory.glance is not None
    _, memory = look_on(COLUMN[1:], FIVE, (), memory, P, 10.1)
    assert memory.glance is not None
    assert memory.glance.boats == 9.0
    assert memory.glance.done <= LOOK_WORK


def test_a_vessel_that_goes_out_of_sight_in_the_middle_of_a_look_is_left_out() -> None:
    _, memory = look_on(COLUMN, FIVE, (), ACTING, P, 10.0)
    picture, _, _ = looks(COLUMN, FIVE[1:], memory)
    assert [e.number for e in picture.encounters] == [1.0, 2.0, 3.0, 4.0]


def test_a_look_under_way_is_recorded_and_read_again() -> None:
    _, memory = look_on(COLUMN, FIVE, (), ACTING, P, 10.0)
    assert memory.glance is not None
    assert msgspec.json.decode(msgspec.json.encode(memory), type=Memory) == memory


def test_a_vessel_that_is_met_later_counts_with_its_side_as_soon_as_something_is_decided() -> None:
    """A lying ship of 60 m is looked at over two minutes and more; a small one head-on much less far ahead."""
    near, far = target(100.0, 0.0, length=60.0, number=1.0), meeting(180.0, 2.0, 120.0, 6.0, number=2.0)
    picture, _, _ = looks((boat(),), [near, far], START)
    assert [e.number for e in picture.encounters] == [1.0]
    assert foreseen(boat(), picture, P) == ((2.0, 1.0),)
    passing = structs.replace(far, y=far.y + 80.0)
    picture, _, _ = looks((boat(),), [near, passing], START)
    assert foreseen(boat(), picture, P) == ()
    assert all(e.entry < NEVER_S for e in picture.encounters)
