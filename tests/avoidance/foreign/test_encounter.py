"""Classes, sides, roles, and when an encounter is over."""

from __future__ import annotations

import math

import pytest
from msgspec import structs

from fleet.avoidance.foreign import NEVER_S, Boat, Encounter, Kind, Role
from fleet.avoidance.foreign.domain import domain
from fleet.avoidance.foreign.encounter import bearing, believed, classify, due, look, role
from fleet.sensing import Target

from .scenes import P, boat, target

OWN = bearing(boat())


def kind_of(t: Target, own: Boat | None = None) -> tuple[Kind, float]:
    kind, side = classify(bearing(own) if own is not None else OWN, domain(t, 1.0, 0.0, P), P)
    return Kind(int(kind)), side


@pytest.mark.parametrize(
    ("t", "kind", "side"),
    [
        (target(200.0, 0.0, 180.0, 3.0), Kind.HEAD_ON, 1.0),
        (target(200.0, 0.0, 166.0, 3.0), Kind.HEAD_ON, 1.0),
        (target(200.0, 0.0, 164.0, 3.0), Kind.CROSSING_GIVE_WAY, 1.0),  # 16 deg off the opposite course
        (target(100.0, 100.0, -90.0, 3.0), Kind.CROSSING_GIVE_WAY, 1.0),
        (target(100.0, -100.0, 90.0, 3.0), Kind.CROSSING_STAND_ON, 0.0),
        (target(100.0, 0.0, 0.0, 0.5), Kind.OVERTAKING, 1.0),
        (target(100.0, -20.0, 0.0, 0.5), Kind.OVERTAKING, 1.0),
        (target(100.0, 20.0, 0.0, 0.5), Kind.OVERTAKING, -1.0),  # it is 20 m to starboard: pass it there
        (target(100.0, 3.0, 0.0, 0.5), Kind.OVERTAKING, 1.0),
        (target(-100.0, 5.0, 0.0, 3.0), Kind.OVERTAKEN, 1.0),  # it passes to our starboard, m > 0 after the sign of w
        (target(-100.0, -5.0, 0.0, 3.0), Kind.OVERTAKEN, -1.0),
        (target(100.0, 0.0, 90.0, 0.0), Kind.STATIC, 1.0),
        (target(100.0, 0.0, 90.0, 0.2), Kind.STATIC, -1.0),  # it drifts 20 m to starboard meanwhile
    ],
)
def test_the_class_of_a_vessel_and_the_side_on_which_it_is_left(t: Target, kind: Kind, side: float) -> None:
    assert kind_of(t) == (kind, side)


@pytest.mark.parametrize("t", [target(100.0, 30.0 * k - 95.0, 50.0 * k, 0.8 + k) for k in range(7)])
@pytest.mark.parametrize("angle", [0.3, 1.9, -2.5])
def test_turning_the_scene_changes_no_class(angle: float, t: Target) -> None:
    c, s = math.cos(angle), math.sin(angle)
    turned = structs.replace(
        t, x=c * t.x - s * t.y, y=s * t.x + c * t.y, vx=c * t.vx - s * t.vy, vy=s * t.vx + c * t.vy
    )
    own = structs.replace(OWN, ex=c, ey=s)
    assert classify(own, domain(turned, 1.0, 0.0, P), P) == classify(OWN, domain(t, 1.0, 0.0, P), P)


def test_who_keeps_clear() -> None:
    give_way = {Kind.STATIC, Kind.OVERTAKING, Kind.HEAD_ON, Kind.CROSSING_GIVE_WAY}
    assert {k for k in Kind if role(k) == Role.GIVE_WAY} == give_way
    assert role(Kind.NONE) == Role.NONE
    assert role(Kind.OVERTAKEN) == Role.STAND_ON


def looks(t: Target, entries: list[float], before: Encounter | None = None) -> list[Encounter | None]:
    """The encounter after each look."""
    found = []
    d = domain(t, 1.0, 0.0, P)
    for entry in entries:
        before = look(before, OWN, d, entry, P)
        found.append(before)
    return found


def test_without_risk_there_is_no_encounter() -> None:
    assert looks(target(500.0, 100.0, -90.0, 3.0), [NEVER_S, NEVER_S]) == [None, None]


def test_the_boat_that_gives_way_acts_when_its_time_has_come_for_three_looks() -> None:
    crossing = target(100.0, 100.0, -90.0, 3.0)
    found = looks(crossing, [50.0, 40.0, 39.5, 39.0])
    assert [e is not None and due(e, P) for e in found] == [False, False, False, True]


def test_the_boat_that_stands_on_waits_until_it_can_only_just_clear_alone() -> None:
    found = looks(target(100.0, -100.0, 90.0, 3.0), [39.0, 21.0, 20.0, 19.5, 19.0])
    assert [e is not None and due(e, P) for e in found] == [False, False, False, False, True]


def test_eight_seconds_before_entry_nobody_waits() -> None:
    (first,) = looks(target(100.0, -100.0, 90.0, 3.0), [7.9])
    assert first is not None
    assert due(first, P)


def test_one_look_without_need_takes_two_looks_with_need_away() -> None:
    found = looks(target(100.0, 100.0, -90.0, 3.0), [39.0, 38.5, 50.0])
    assert [e is not None and e.count for e in found] == [0.5, 1.0, 0.0]


def test_a_vessel_that_was_acted_for_is_past_only_when_it_opens() -> None:
    ahead, astern = target(100.0, 0.0, 0.0, 0.5), target(-50.0, 20.0, 180.0, 3.0)
    (met,) = looks(ahead, [30.0])
    assert met is not None
    acted = structs.replace(met, acting=1.0)
    assert looks(ahead, [NEVER_S] * 40, acted)[-1] is not None
    assert looks(ahead, [NEVER_S] * 20, met)[-1] is None
    past = structs.replace(acted, ex=-1.0, ey=0.0)
    assert [e is None for e in looks(astern, [NEVER_S] * 12, past)] == [False] * 11 + [True]


def test_a_vessel_that_turns_is_classified_again() -> None:
    (met,) = looks(target(100.0, 100.0, -90.0, 3.0), [50.0])
    assert met is not None
    (steady,) = looks(target(100.0, 100.0, -70.0, 3.0), [50.0], met)
    (turned,) = looks(target(100.0, 100.0, 180.0, 3.0), [50.0], met)
    assert steady is not None
    assert turned is not None
    assert (met.ex, met.ey) == (steady.ex, steady.ey) != (turned.ex, turned.ey)
    for acting, side in ((0.0, 1.0), (1.0, 0.0)):  # in the middle of an action for it no side is asked of the boat
        before = structs.replace(met, acting=acting)
        behind = look(before, OWN, domain(target(-100.0, 10.0, 0.0, 3.0), 1.0, 0.0, P), 50.0, P)
        assert behind is not None
        assert (behind.kind, behind.side) == (Kind.OVERTAKEN, side)


def test_a_lying_vessel_that_gets_under_way_is_classified_again() -> None:
    (lying,) = looks(target(100.0, 5.0, 180.0, 0.1), [50.0])
    assert lying is not None
    assert lying.kind == Kind.STATIC
    (under_way,) = looks(target(100.0, 5.0, 180.0, 1.0), [50.0], lying)
    assert under_way is not None
    assert (under_way.kind, under_way.side) == (Kind.HEAD_ON, 1.0)


@pytest.mark.parametrize(("speed", "side"), [(0.4, 1.0), (0.2, -1.0)])
def test_a_slow_vessel_that_seems_to_come_from_starboard_is_left_to_port(speed: float, side: float) -> None:
    """It would be passed to port of it, by a few metres; its course is uncertain."""
    unsure = structs.replace(target(100.0, 20.0, -120.0, speed), P22=0.09)
    found = classify(OWN, domain(unsure, 1.0, 0.0, P), P)
    assert found == (Kind.STATIC, side)


@pytest.mark.parametrize(
    ("t", "kind"),
    [
        (target(200.0, -30.0, 160.0, 3.0), Kind.CROSSING_STAND_ON),  # 20 deg off the opposite course, and known to be
        (target(200.0, -30.0, 160.0, 3.0, P22=0.04), Kind.HEAD_ON),  # 20 deg, give or take 4
        (target(200.0, -30.0, 145.0, 0.6, P22=0.04), Kind.CROSSING_STAND_ON),  # 35 deg: a doubt ends at 15 + 15
        (target(200.0, -2.0, 155.0, 3.0), Kind.CROSSING_STAND_ON),
        (target(200.0, -2.0, 155.0, 3.0, P11=4.0), Kind.HEAD_ON),  # it may as well be on the starboard bow
        (target(200.0, -5.0, 155.0, 3.0, P11=4.0), Kind.CROSSING_STAND_ON),
        (target(200.0, -2.0, 120.0, 3.0, P11=4.0), Kind.CROSSING_STAND_ON),  # it crosses, at 60 deg
        (target(100.0, -80.0, 160.0, 3.0, P22=0.04), Kind.CROSSING_STAND_ON),  # not ahead
    ],
)
def test_in_doubt_a_vessel_from_port_is_head_on(t: Target, kind: Kind) -> None:
    """Rule 14 c."""
    found = believed(OWN, domain(t, 1.0, 0.0, P), P)
    assert found == (kind, 1.0 if kind == Kind.HEAD_ON else 0.0)


def test_a_class_made_on_an_uncertain_course_holds_until_it_is_known_or_acted_for() -> None:
    """1 m/s: a fifth of that is 11 deg, two tenths of it 2 deg."""
    (before,) = looks(target(200.0, -60.0, 130.0, 1.0, P22=0.04), [50.0])
    assert before is not None
    assert before.kind == Kind.CROSSING_STAND_ON
    sure, unsure = target(200.0, -20.0, 160.0, 1.0, P22=0.0016), target(200.0, -20.0, 160.0, 1.0, P22=0.04)
    for t, acting, kind in (
        (unsure, 0.0, Kind.HEAD_ON),
        (unsure, 1.0, Kind.CROSSING_STAND_ON),
        (structs.replace(sure, vx=-0.8, vy=0.6), 0.0, Kind.CROSSING_STAND_ON),
    ):
        (after,) = looks(t, [49.0], structs.replace(before, acting=acting))
        assert after is not None
        assert after.kind == kind


def test_off_its_path_for_another_vessel_a_boat_makes_no_class_anew_for_doubt() -> None:
    (before,) = looks(target(200.0, -20.0, 160.0, 1.0, P22=0.04), [50.0])
    assert before is not None
    assert before.kind == Kind.HEAD_ON
    aside = domain(target(200.0, -90.0, 160.0, 1.0, P22=0.04), 1.0, 0.0, P)  # as it looks from 70 m beside the path
    there, here = look(before, OWN, aside, 49.0, P, acts=True), look(before, OWN, aside, 49.0, P)
    assert there is not None
    assert here is not None
    assert (there.kind, here.kind) == (Kind.HEAD_ON, Kind.CROSSING_STAND_ON)


def test_the_side_that_no_rule_asks_for_is_that_on_which_the_boat_has_come_to_be() -> None:
    lies = domain(target(100.0, -10.0), 1.0, 0.0, P)
    before = look(None, OWN, lies, 50.0, P)
    assert before is not None
    acted = structs.replace(before, acting=1.0, side=-1.0)
    near, far = (
        bearing(boat(y=y)) for y in (lies.C - 11.0, lies.C - 9.0)
    )  # passed at C - 1 m and C + 1 m on its other side
    sides = [after.side for own in (near, far) if (after := look(acted, own, lies, 50.0, P, acts=True)) is not None]
    assert sides == [-1.0, 1.0]
    crossing = structs.replace(acted, kind=float(Kind.CROSSING_GIVE_WAY))
    after = look(crossing, far, lies, 50.0, P, acts=True)
    assert after is not None
    assert after.side == -1.0
