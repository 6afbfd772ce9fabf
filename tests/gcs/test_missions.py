"""Missions up and down: item by item, whole or not at all, through the checks of mission files, and back exactly."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs

from fleet.errors import MissionError
from fleet.gcs.chart import Basis, Draft, Pose, chart
from fleet.gcs.items import Item, WrongItem, course_of, items_of
from fleet.mission.check import check
from fleet.mission.load import load
from fleet.mission.model import Geographic, Polyline, Straight
from fleet.mission.plan import build
from tests.gcs.deck import LAT, LON, NORTH, Deck, mission, waypoint

ACCEPTED, BAD_FRAME, UNSUPPORTED, NO_SPACE, INVALID, WRONG_SEQUENCE, DENIED, CANCELLED = 0, 2, 3, 4, 5, 13, 14, 15
SQUARE = mission((0.0, 0.0), (200.0, 0.0), (200.0, 100.0), (0.0, 100.0))


def test_an_upload_is_asked_for_item_by_item_checked_and_comes_back_exactly() -> None:
    deck = Deck("b1", "b2")
    assert deck.station.upload(1, SQUARE) == -1, "no answer before the fleet's own checks"
    wish = deck.wish("chart")
    assert not check(wish.value).problems
    deck.answer(wish)
    assert deck.station.last("MISSION_ACK").type == ACCEPTED
    for sysid in (1, 2):  # it is the formation's
        back = deck.station.download(sysid)
        assert [(m.seq, m.frame, m.command, m.x, m.y, m.z) for m in back] == [
            (i.seq, i.frame, i.command, i.x, i.y, i.z) for i in SQUARE
        ]


def test_waypoints_become_a_path_with_corners_that_the_hulls_can_turn() -> None:
    deck = Deck("b1", "b2")
    deck.station.upload(1, SQUARE)
    plan = deck.wish("chart").value
    path = plan.paths["uploaded"]
    assert isinstance(path, Polyline)
    assert len(path.points) == 4, "home is no waypoint"
    assert path.corner_radius_m >= 1.5 / 0.35
    assert build(plan).paths["uploaded"].max_curvature <= 0.35 / 1.5


def test_what_the_checks_find_is_said_and_nothing_is_stored() -> None:
    deck = Deck("b1")
    deck.station.upload(1, SQUARE)
    deck.does("chart", ok=False, text="paths.uploaded: leaves the fence at 60 m")
    assert deck.station.last("MISSION_ACK").type == INVALID
    assert deck.station.texts() == ["mission refused: paths.uploaded: leaves the fence at 60 m"]
    assert deck.station.download(1) == []


def test_a_leg_that_is_too_short_for_its_corners_is_named() -> None:
    deck = Deck("b1")
    assert deck.station.upload(1, mission((0.0, 0.0), (50.0, 0.0), (50.0, 3.0), (0.0, 3.0))) == INVALID
    assert "leg from point 2" in deck.station.texts()[0]
    assert not deck.wishes


@pytest.mark.parametrize(
    ("spoilt", "result", "words"),
    [
        (structs.replace(SQUARE[2], command=84), UNSUPPORTED, "item 2: command 84"),
        (structs.replace(SQUARE[2], frame=1), BAD_FRAME, "item 2: frame 1"),
        (structs.replace(SQUARE[2], x=int(91e7)), 10, "item 2: 91"),
        (structs.replace(SQUARE[2], x=0, y=0), 11, "item 2: 0, 0 is no position"),
    ],
)
def test_an_item_that_cannot_be_sailed_ends_the_upload(spoilt: Item, result: int, words: str) -> None:
    deck = Deck("b1")
    assert deck.station.upload(1, [*SQUARE[:2], spoilt, *SQUARE[3:]]) == result
    assert words in deck.station.texts()[0]
    assert deck.station.download(1) == []


def test_a_wrong_sequence_is_said_and_one_sent_twice_is_not() -> None:
    deck = Deck("b1")
    s = deck.station
    s.say("mission_count", 1, 1, 3, 0)
    s.send_item(1, SQUARE[2])
    assert s.last("MISSION_ACK").type == WRONG_SEQUENCE
    s.clear()
    s.send_item(1, SQUARE[0])
    s.send_item(1, SQUARE[0])
    assert not s.all("MISSION_ACK")
    assert s.last("MISSION_REQUEST_INT").seq == 1


def test_it_asks_again_after_a_second_and_gives_up_after_eight() -> None:
    deck = Deck("b1")
    s = deck.station
    s.say("mission_count", 1, 1, 3, 0)
    deck.run(3.0)
    assert 3 <= len(s.all("MISSION_REQUEST_INT")) <= 4
    deck.run(6.0)
    assert s.last("MISSION_ACK").type == CANCELLED
    s.clear()
    deck.run(3.0)
    assert not s.all("MISSION_REQUEST_INT")


def test_one_uploads_at_a_time() -> None:
    deck = Deck("b1")
    second = deck.join(sysid=254)
    deck.station.say("mission_count", 1, 1, 3, 0)
    second.say("mission_count", 1, 1, 2, 0)
    assert second.last("MISSION_ACK").type == DENIED
    assert second.texts() == ["another ground station is uploading"]


def test_more_than_fits_is_refused_and_so_are_fences() -> None:
    deck = Deck("b1")
    deck.station.say("mission_count", 1, 1, 501, 0)
    assert deck.station.last("MISSION_ACK").type == NO_SPACE
    deck.station.say("mission_count", 1, 1, 4, 1)
    assert (deck.station.last("MISSION_ACK").type, deck.station.last("MISSION_ACK").mission_type) == (UNSUPPORTED, 1)


def test_clearing_takes_back_what_waits() -> None:
    deck = Deck("b1")
    deck.station.upload(1, SQUARE)
    deck.does("chart")
    deck.station.say("mission_clear_all", 1, 1, 0)
    assert deck.station.last("MISSION_ACK").type == ACCEPTED
    assert deck.station.download(1) == []
    deck.station.mode(1, 10)
    assert "no mission" in deck.station.texts()[-1]


def test_a_mission_launched_by_others_is_downloaded_as_waypoints() -> None:
    deck = Deck("b1", "b2", "b3", "b4", "b5")
    deck.sails(load("survey-column"), "5000-anna")
    items = deck.station.download(1)
    assert [m.command for m in items] == [16, 178] + [16] * 8, "home, speed, the corners"
    assert items[0].x == round(build(load("survey-column")).plane.to_geographic(-30.0, 0.0)[0] * 1e7)


def test_progress_is_told_item_by_item() -> None:
    deck = Deck("b1", "b2", "b3", "b4", "b5")
    deck.sails(load("survey-column"), "5000-anna")
    seen = []
    for s_m in (1.0, 60.0, 112.0, 134.0):
        deck.change("b1", s_m=s_m)
        deck.run(1.5)
        seen.append(deck.station.last("MISSION_CURRENT", 1).seq)
    assert seen == [3, 3, 4, 5]
    assert [m.seq for m in deck.station.all("MISSION_ITEM_REACHED", 1)] == [3, 4]


def test_an_upload_for_one_boat_alone_leaves_the_others() -> None:
    deck = Deck("b1", "b2")
    deck.station.set(2, "FLT_ALONE", 1.0)
    deck.station.upload(2, SQUARE)
    wish = deck.does("chart")
    assert [boat.name for boat in wish.value.boats] == ["b2"]
    assert deck.station.download(1) == []
    deck.station.mode(2, 10)
    assert [boat.name for boat in deck.does("start", value="1-gcs").value.boats] == ["b2"]


def test_the_template_gives_roster_limits_fence_and_home() -> None:
    template = load("harbour")
    names = [boat.name for boat in template.boats]
    deck = Deck(*names, template=template)
    deck.station.upload(1, SQUARE)
    made = deck.wish("chart").value
    assert [(b.name, b.slot, b.limits) for b in made.boats] == [(b.name, b.slot, b.limits) for b in template.boats]
    assert (made.fence is None) == (template.fence is None)
    assert made.formation.spacing_m == template.formation.spacing_m


def test_a_formation_in_force_is_kept_by_the_next_mission() -> None:
    deck = Deck("b1", "b2", "b3", "b4", "b5")
    held = load("survey-column")
    deck.sails(held, "5000-anna")
    for view in deck.views.values():
        assert view.status is not None
        view.status = structs.replace(view.status, spacing_m=22.0, slot=-view.status.slot)
    deck.station.upload(1, SQUARE)
    made = deck.wish("chart").value
    assert made.formation.spacing_m == 22.0
    assert [b.slot for b in made.boats] == [-b.slot for b in held.boats]


def test_without_home_first_as_generic_stations_have_it_every_item_is_a_waypoint() -> None:
    deck = Deck("b1", autopilot=0)
    deck.station.upload(1, mission((200.0, 0.0)))
    path = deck.wish("chart").value.paths["uploaded"]
    assert isinstance(path, Straight)


def test_a_jump_back_to_the_first_waypoint_for_ever_is_a_circuit() -> None:
    jump = Item(5, 3, 177, 0, 1, (1.0, -1.0, 0.0, 0.0), 0, 0, 0.0)
    assert course_of([*SQUARE, jump], home_first=True).closed
    with pytest.raises(WrongItem, match="jumps; only to item 1, -1 times"):
        course_of([*SQUARE, structs.replace(jump, params=(2.0, -1.0, 0.0, 0.0))], home_first=True)


def test_a_speed_is_the_cruise_speed() -> None:
    speed = Item(1, 3, 178, 0, 1, (1.0, 0.8, -1.0, 0.0), 0, 0, 0.0)
    course = course_of([SQUARE[0], speed, *SQUARE[1:]], home_first=True)
    assert course.cruise_mps == 0.8
    wrong = structs.replace(speed, params=(1.0, math.nan, 0.0, 0.0))
    with pytest.raises(WrongItem, match="speed nan m/s"):
        course_of([SQUARE[0], wrong, *SQUARE[1:]], home_first=True)


POINTS = st.lists(st.tuples(st.integers(-20, 20), st.integers(-20, 20)), min_size=2, max_size=6, unique=True)


@given(POINTS, st.booleans())
@settings(max_examples=25, deadline=None)
def test_whatever_is_uploaded_is_a_sound_mission_or_refused_in_words(
    points: list[tuple[int, int]], jumps: bool
) -> None:
    items = mission(*((60.0 * north, 60.0 * east) for north, east in points))
    if jumps:
        items.append(Item(len(items), 3, 177, 0, 1, (1.0, -1.0, 0.0, 0.0), 0, 0, 0.0))
    deck = Deck("b1", "b2")
    result = deck.station.upload(1, items)
    if result == -1:
        made = deck.wish("chart").value
        assert made.paths["uploaded"]
        build(made)
    else:
        assert result in (ACCEPTED, UNSUPPORTED, INVALID)
        assert deck.station.texts()


@given(POINTS)
@settings(max_examples=25, deadline=None)
def test_a_path_shown_as_items_is_the_course_that_it_came_from(points: list[tuple[int, int]]) -> None:
    places = tuple(Geographic(lat_deg=LAT + 80 * a * NORTH, lon_deg=LON + 80 * b * NORTH) for a, b in points)
    course = course_of([waypoint(0, 0.0, 0.0), *_items(places)], home_first=True)
    basis = Basis({"b1": Pose(LAT, LON, 0.0)})
    try:
        plan = build(chart(course, "b1", basis, Draft(), alone=False))
    except MissionError:  # corners that do not fit
        return
    shown = course_of(items_of(plan, "b1", home_first=True), home_first=True)
    assert shown.cruise_mps == 1.0
    if len(points) > 2:
        assert shown.points == course.points


def _items(places: tuple[Geographic, ...]) -> list[Item]:
    none = (0.0, 0.0, 0.0, 0.0)
    return [
        Item(i + 1, 3, 16, 0, 1, none, round(p.lat_deg * 1e7), round(p.lon_deg * 1e7), 0.0)
        for i, p in enumerate(places)
    ]


def test_who_does_not_command_does_not_exchange_what_waits() -> None:
    deck = Deck("b1")
    second = deck.join(sysid=254)
    deck.station.upload(1, SQUARE)
    deck.does("chart")
    assert second.upload(1, mission((0.0, 0.0), (50.0, 0.0))) == DENIED
    assert second.texts() == ["mission refused: another ground station commands; FLT_CONTROL 1 takes over"]
    second.say("mission_clear_all", 1, 1, 0)
    assert second.last("MISSION_ACK").type == DENIED
    assert len(deck.station.download(1)) == len(SQUARE)


def test_a_boat_that_is_not_in_the_roster_does_not_start_the_others() -> None:
    held = load("harbour")
    deck = Deck(*(boat.name for boat in held.boats), "stranger")
    deck.sails(held, "5000-anna")
    deck.station.upload(1, SQUARE)
    deck.does("chart")
    deck.station.mode(len(held.boats) + 1, 10)
    assert "AUTO refused: what was uploaded is for b1" in deck.station.texts(len(held.boats) + 1)[-1]
    assert not deck.wishes
