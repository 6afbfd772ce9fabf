"""Which alteration is chosen, and that leaving candidates out does not change it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest
from msgspec import msgpack, structs

from fleet.avoidance.foreign import FOLLOW_PATH, NEVER_S, Action, Boat, Edge, Encounter, Kind, Reason, nearness
from fleet.avoidance.foreign import decision as decisions
from fleet.avoidance.foreign.decision import Scene, Search, begin, candidates, choose, go_on, outermost
from fleet.avoidance.foreign.domain import domain, gap
from fleet.avoidance.foreign.encounter import bearing, look
from fleet.avoidance.foreign.nearness import part, stacked
from fleet.avoidance.foreign.rollout import entry as entry_of
from fleet.avoidance.foreign.rollout import following, holding, left_to_turn, motion, sail_on
from fleet.avoidance.foreign.types import Afloat
from fleet.sensing import Target

from .scenes import P, boat, meeting, target


def scene(
    targets: Sequence[Target],
    boats: Sequence[Boat] = (boat(),),
    held: Action = FOLLOW_PATH,
    edges: Sequence[Edge] = (),
    acting: float = 1.0,
) -> Scene:
    """What is to be decided about these vessels, all of them met."""
    own, domains = bearing(boats[0]), [domain(t, 1.0, 0.0, P) for t in targets]
    way = following(boats[0], 200.0, P)
    met: list[Encounter] = []
    for d in domains:
        found = look(None, own, d, entry_of(way, d, d.H, 1.0, 1.0, 0.0), P)
        if found is not None:
            met.append(structs.replace(found, acting=acting))
    return Scene(tuple(boats), own, tuple(domains), tuple(met), (), tuple(edges), held)


def chosen(
    targets: Sequence[Target],
    boats: Sequence[Boat] = (boat(),),
    held: Action = FOLLOW_PATH,
    edges: Sequence[Edge] = (),
    acting: float = 1.0,
) -> Action:
    """The alteration for these vessels."""
    return choose(scene(targets, boats, held, edges, acting), P)


def priced(crew: Sequence[int], whole: Scene) -> list[float]:
    """What every candidate costs these boats by where it leads."""
    trials = begin(whole, 1.0, Reason.GIVE_WAY, P).trials
    ways = stacked(sail_on(decisions._set_out(whole, trials, P), whole.edges, NEVER_S, P).way)
    return decisions._consequences(part(ways, crew, range(len(trials))), whole, trials, P)


def test_nothing_smaller_than_30_degrees_or_half_the_speed_is_tried() -> None:
    table = candidates(1.5, P)
    assert len(table) == 63
    assert all(abs(c.a) >= math.radians(30.0) - 1e-9 or c.factor <= 0.5 or c.a == 0.0 for c in table)
    assert {round(math.degrees(c.a)) for c in table if c.sense == 1.0} == {150, 180, 210, 240}
    assert all(c.a != 0.0 for c in table if c.factor == 1.5)
    assert len(candidates(1.0, P)) == 43  # who cruises at full speed has no emergency speed


def test_the_smallest_turn_to_starboard_that_clears_a_vessel_ahead() -> None:
    action = chosen([meeting(180.0, 3.0, 40.0)])
    assert (action.a, action.factor) == (math.radians(30.0), 1.0)
    assert (action.cx, action.cy) == (pytest.approx(math.cos(action.a)), pytest.approx(math.sin(action.a)))


def test_the_courses_are_relative_to_the_path_not_to_the_bow() -> None:
    turned = chosen([meeting(180.0, 3.0, 40.0)], (boat(chi=0.2),))
    assert turned.cy == pytest.approx(0.5)


def test_a_vessel_to_port_that_does_not_give_way_is_not_met_by_a_turn_to_port() -> None:
    """Rule 17 c. The vessel passes ahead of us to starboard: to port behind it would be shorter."""
    crossing = meeting(90.0, 3.0, 22.0)
    assert chosen([crossing]).a >= 0.0 or chosen([crossing]).factor == 0.0
    free = chosen([structs.replace(crossing, number=3.0)], acting=0.0)
    assert free.a < 0.0 or free == chosen([crossing])


def test_a_bank_to_starboard_closes_the_turn_that_would_lead_there() -> None:
    t = [meeting(180.0, 2.0, 60.0)]
    assert chosen(t).a > 0.0
    ashore = chosen(t, edges=((-500.0, 1.5, 500.0, 1.5),))
    assert ashore.a <= 0.0 or ashore.sense < 0.0


def test_an_action_that_serves_is_not_changed() -> None:
    held = structs.replace(chosen([meeting(180.0, 3.0, 40.0)]), at=0.0)
    later = [meeting(180.0, 3.0, 38.0)]
    turned = (boat(chi=held.a),)
    again = chosen(later, turned, held)
    assert (again.a, again.factor) == (held.a, held.factor)


SCENES = [
    ([meeting(180.0, 3.0, 40.0)], 1),
    ([meeting(-90.0, 5.0, 30.0), meeting(150.0, 3.0, 35.0, number=2.0)], 1),
    ([meeting(60.0 * k - 170.0, 2.0 + k, 20.0 + k, number=float(k)) for k in range(6)], 1),
    ([meeting(-90.0, 4.0, 35.0, 60.0), target(60.0, 20.0, number=2.0)], 4),
    ([meeting(60.0 * k - 170.0, 2.0 + k, 25.0 + k, number=float(k)) for k in range(4)], 3),
]


@pytest.mark.parametrize(("targets", "count"), SCENES)
def test_leaving_dear_candidates_out_changes_nothing(
    targets: list[Target], count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    boats = tuple(boat(x=12.0 * k, y=3.0 * k) for k in range(count))
    few = chosen(targets, boats)
    monkeypatch.setattr(decisions, "AT_ONCE", 1)
    one_by_one = chosen(targets, boats)
    all_at_once = scene(targets, boats)
    trials = begin(all_at_once, 1.0, Reason.GIVE_WAY, P).trials
    prices = priced(range(count), all_at_once)
    _, best = min((each.price + extra, i) for i, (each, extra) in enumerate(zip(trials, prices, strict=True)))
    assert few == one_by_one == trials[best].action


def test_what_the_outermost_boats_pay_all_of_them_pay_at_least() -> None:
    boats = tuple(boat(x=12.0 * k, y=3.0 * k) for k in range(5))
    assert outermost(boats) == (0, 4)
    whole = scene(SCENES[4][0], boats)
    few, all_of_them = (priced(crew, whole) for crew in (outermost(boats), range(5)))
    assert all(a <= b for a, b in zip(few, all_of_them, strict=True))


def test_legs_left_out_as_far_off_change_no_price(monkeypatch: pytest.MonkeyPatch) -> None:
    for targets, count in SCENES:
        boats = tuple(boat(x=12.0 * k, y=3.0 * k) for k in range(count))
        whole = scene(targets, boats)
        without = priced(range(count), whole)
        with monkeypatch.context() as patch:
            patch.setattr(nearness, "_gaps", lambda x0, y0, x1, y1, low, high, far: gap(x0, y0, x1, y1, low, high))
            assert priced(range(count), whole) == without


FIVE = [meeting(60.0 * k - 170.0, 2.0 + k, 25.0 + k, number=float(k)) for k in range(5)]
BANKS = ((-500.0, 15.0, 500.0, 15.0), (-500.0, -20.0, 500.0, -20.0))
COLUMN = [boat(x=12.0 * k) for k in range(10)]


@pytest.mark.parametrize("edges", [(), BANKS[:1], BANKS])
def test_a_large_decision_goes_on_for_some_ticks_and_no_tick_does_more_than_its_share(edges: tuple[Edge, ...]) -> None:
    search = begin(scene(FIVE, COLUMN, edges=edges), 1.0, Reason.GIVE_WAY, P)
    count, ticks, moves = 10 * len(search.trials), 0, []
    while decisions.chosen(search) is None:
        before, search = search, go_on(search, P)
        new = set(search.known) - set(before.known)
        legs = sum(10 if level == 2 else 2 for _, _, level in new) * search.steps * 5
        steps = search.steps - before.steps
        assert steps or new  # it goes on
        step = (1.0 + count / decisions.WAYS) * (decisions.BANKED_STEP if edges else decisions.FREE_STEP)
        assert steps * step + decisions.LEG * legs < decisions.WORK
        moves.append(steps)
        ticks += 1
    assert 3 <= ticks <= (30 if not edges else 45)
    assert sum(moves) == search.steps


@pytest.mark.parametrize("edges", [(), BANKS])
def test_how_the_work_is_spread_over_ticks_changes_neither_price_nor_choice(
    edges: tuple[Edge, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = scene(FIVE[:3], COLUMN[:3], edges=edges)
    found = []
    for work in (25.0, decisions.WORK, 1e6):
        monkeypatch.setattr(decisions, "WORK", work)
        found.append(choose(whole, P))
    assert found[0] == found[1] == found[2]


def test_a_decision_that_was_recorded_and_read_goes_on_as_if_it_had_not_been() -> None:
    """The ways are not in what is recorded: they are worked out anew, with the same bits."""
    afloat = tuple(Afloat(*(getattr(each, name) for name in Afloat.__struct_fields__)) for each in COLUMN)
    whole = structs.replace(scene(FIVE, COLUMN, edges=BANKS[:1]), boats=afloat)
    search = begin(whole, 1.0, Reason.GIVE_WAY, P)
    for _ in range(12):
        written = msgpack.encode(search)
        assert len(written) < 20_000
        search, read = go_on(search, P), go_on(msgpack.decode(written, type=Search), P)
        assert msgpack.encode(read) == msgpack.encode(search)
    assert any(level > 0 for _, _, level in search.known)


def test_every_boat_of_a_formation_counts() -> None:
    """The alteration of a leader clears the boat that is 40 m to starboard of it, too."""
    t = [meeting(180.0, 3.0, 50.0)]
    assert chosen(t).a == math.radians(30.0)
    abreast = chosen(t, (boat(), boat(y=-40.0)))
    assert (abreast.a, abreast.factor) != (math.radians(30.0), 1.0)


def test_with_no_way_out_the_least_bad_one_is_taken() -> None:
    ring = [meeting(40.0 * k - 160.0, 6.0, 6.0, 60.0, float(k)) for k in range(9)]
    action = chosen(ring)
    assert action.acting == 1.0
    assert chosen(ring) == action


def test_no_domain_is_given_up_for_a_side_that_no_rule_asks_for() -> None:
    """Rules 14 and 15 ask for one; a tenth of the domain is worth more than any other side."""
    sides = {}
    for kind in (Kind.OVERTAKEN, Kind.HEAD_ON):
        given = scene([target(100.0, 0.0, 180.0, 1.0)])
        met = tuple(structs.replace(e, kind=float(kind), side=-1.0) for e in given.encounters)
        sides[kind] = decisions._sides(structs.replace(given, encounters=met), P)[1.0]
    assert sides == {Kind.OVERTAKEN: (-1.0, P.other_side), Kind.HEAD_ON: (-1.0, P.wrong_side)}
    assert P.other_side < 0.1 * (P.worst + P.each) < P.wrong_side


def test_a_review_changes_what_still_serves_only_for_a_good_deal_less() -> None:
    held = structs.replace(FOLLOW_PATH, acting=1.0, a=math.radians(45.0), cx=math.cos(0.7854), cy=math.sin(0.7854))
    best = {}
    for cause in (Reason.HELD_FAILS, Reason.REVIEW):
        search = begin(scene([meeting(180.0, 3.0, 60.0)], held=held), 1.0, cause, P)
        while (found := decisions.chosen(search)) is None:
            search = go_on(search, P)
        best[cause] = round(math.degrees(found.a))
    assert best == {Reason.HELD_FAILS: 30, Reason.REVIEW: 45}


@pytest.mark.parametrize("chi", [0.0, 2.6, math.pi])
def test_within_a_metre_of_a_bank_no_way_is_taken_that_leads_over_it(chi: float) -> None:
    """All ways begin too near to it; they differ by how near they come."""
    bank, here = (-500.0, 15.0, 500.0, 15.0), boat(y=14.2, chi=chi)
    action = chosen([meeting(180.0, 1.0, 60.0)], (here,), edges=(bank,))
    left = left_to_turn(chi, action.cx, action.cy, action.sense)
    way = holding(motion(here), left, action.cx, action.cy, action.factor, (bank,), 40.0, P)
    assert max(way.y) < 15.0
