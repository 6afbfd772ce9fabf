"""Missions, formations with their revisions, control: what operators say and neighbours hand on (DESIGN section 4)."""

from __future__ import annotations

import itertools
from pathlib import Path

import msgspec
import pytest

from fleet.agent.modes import Goal, Mode, Reason
from fleet.wire import keys
from fleet.wire.codec import encode
from fleet.wire.messages import MAJOR, Command, FormationOrder, Held, Revision, Signed
from tests.agent.harness import Sea, mission, sailing


def refusals(acks: dict) -> set[str]:  # type: ignore[type-arg]
    assert not any(ack.ok for ack in acks.values()), acks
    return {ack.reason for ack in acks.values()}


def picture_of_orders(sea: Sea, boat: str) -> tuple[object, ...]:
    """Everything that a refused command must leave as it was."""
    orders = sea.agent(boat).orders
    held = orders.sailing
    return (
        orders.goal,
        orders.why,
        orders.control,
        tuple(orders.stops),
        None if held is None else (held.order.mission_id, held.formation, held.pending),
        orders.revision_of_goal,
    )


# -- launch ------------------------------------------------------------------------------------------------------------
def test_a_launch_makes_revision_zero_and_all_boats_begin_together(tmp_path: Path) -> None:
    sea = Sea(tmp_path)
    sea.run(0.5)
    acks = sea.launch(apply_in_s=2.0)
    assert all(ack.ok and ack.old == "none" for ack in acks.values())
    began: dict[str, float] = {}

    def look() -> None:
        for boat in sea.agents():
            if sea.mode(boat) != Mode.STANDBY:
                began.setdefault(boat, sea.time_s)

    sea.each_tick.append(look)
    sea.run(3.0)
    assert list(began.values()) == [pytest.approx(2.6)] * 3
    assert {sea.revision(boat) for boat in sea.agents()} == {Revision(0, "")}


def test_a_boat_waits_in_standby_without_thrust(tmp_path: Path) -> None:
    sea = Sea(tmp_path)
    sea.run(5.0)
    assert sea.modes() == [Mode.STANDBY] * 3
    assert not any(sea.powered(boat) for boat in sea.agents())
    assert Reason.NO_MISSION in sea.reasons("b1")


def test_a_boat_that_is_not_in_the_roster_refuses_a_launch(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(3))
    sea.run(0.5)
    acks = sea.launch(mission(2))
    assert acks["b1"].ok
    assert acks["b3"].reason == "not in the roster b1, b2"


def test_a_real_boat_refuses_a_mission_without_a_fence(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2, fence=None), real=True)
    sea.run(0.5)
    assert refusals(sea.launch()) == {"no fence: a real boat sails only inside one"}
    assert not sea.holds_mission("b1")


def test_a_simulated_boat_may_sail_without_a_fence(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2, fence=None))
    sea.run(0.5)
    assert all(ack.ok for ack in sea.launch().values())


def test_a_mission_that_cannot_be_sailed_is_refused_on_board_too(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2))
    sea.run(0.5)
    (reason,) = refusals(sea.launch(msgspec.structs.replace(mission(2), boats=mission(2, 3.0).boats)))
    assert "b2 begins 3.0 m from b1" in reason
    assert sea.modes() == [Mode.STANDBY] * 2


@pytest.mark.parametrize("body", [b"", b"\xc1", b"\x90", encode((2, "m", "anna", 0, b"", 2.0)), b"x" * 1000])
def test_a_launch_of_rubbish_is_refused(tmp_path: Path, body: bytes) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    before = picture_of_orders(sea, "b1")
    refusals(sea.command("launch", order=Signed(body)))
    assert picture_of_orders(sea, "b1") == before


def test_another_launch_takes_the_place_of_the_mission(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    old = sea.state("b1").mission_id
    acks = sea.launch(mission(title="Another one"))
    assert all(ack.ok and ack.old == old for ack in acks.values())
    sea.run(3.0)
    assert sea.state("b1").mission_id != old
    assert sea.members("b1") == 2


def test_a_launch_that_was_heard_before_is_not_obeyed_again_under_another_id(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    yesterday = sea.agent("b1").orders.sailing
    assert yesterday is not None
    sea.change(spacing_m=15.0)
    sea.run(5.0)
    acks = sea.command("launch", order=yesterday.words)
    assert {ack.reason for ack in acks.values()} == {"held already"}
    sea.run(3.0)
    assert sea.spacing("b1") == 15.0, "nothing was started anew"
    sea.command("abort")
    (reason,) = refusals(sea.command("launch", order=yesterday.words))
    assert "launched before" in reason


def test_an_operator_cannot_launch_in_anothers_name(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2))
    sea.run(0.5)
    words = sea.mission_words(operator="anna")
    assert refusals(sea.command("launch", operator="bob", order=words)) == {
        "the mission was written by anna, not by bob"
    }


# -- commands that are refused -----------------------------------------------------------------------------------------
def test_what_does_not_decode_is_refused_counted_and_changes_nothing(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    before = picture_of_orders(sea, "b1")
    good = encode(Command(MAJOR, "x", "anna", "hold", ()))
    for payload in (b"", b"\x00", good[:-1], good + b"\x00", b"\xff" * 100, encode((99, "x", "anna", "hold", ()))):
        answers = sea.ask_raw(payload)
        sea.tick()
        assert refusals(answers) <= {"the command does not decode", "the command another wire version"}
    assert picture_of_orders(sea, "b1") == before
    assert sea.agent("b1").desk.refused.total() == 6


@pytest.mark.parametrize("operator", ["", "Anna", "a/b", "*", "x" * 33])
def test_a_command_of_an_impossible_operator_is_refused(tmp_path: Path, operator: str) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    before = picture_of_orders(sea, "b1")
    refusals(sea.command("hold", operator=operator))
    assert picture_of_orders(sea, "b1") == before


def test_an_unknown_command_is_refused_with_the_version_of_the_boat(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    before = picture_of_orders(sea, "b1")
    (reason,) = refusals(sea.command("self-destruct"))
    assert reason.startswith("unknown command 'self-destruct'; this boat runs fleet ")
    assert picture_of_orders(sea, "b1") == before


def test_a_command_for_another_mission_is_refused(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    (reason,) = refusals(sea.command("hold", mission_id="of-yesterday"))
    assert reason.startswith("it is for mission of-yesterday; this boat holds ")
    assert Mode.HOLD not in sea.modes()


def test_a_refusal_is_published(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    sea.command("self-destruct")
    assert sea.says("b1", "refused")[0].startswith("self-destruct of anna: unknown command")


def test_the_same_command_twice_is_done_once_and_acknowledged_twice(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    first = sea.command("hold", command_id="h1")
    sea.command("resume")
    goal = sea.agent("b1").orders.revision_of_goal
    second = sea.command("hold", command_id="h1")
    assert first == second
    assert sea.agent("b1").orders.revision_of_goal == goal
    assert sea.mode("b1") in (Mode.FOLLOW, Mode.AVOID)


def test_a_command_for_one_boat_leaves_the_others_alone(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    acks = sea.command("hold", boats=("b3",))
    sea.run(1.0)
    assert acks["b3"].ok
    assert not acks["b1"].ok
    assert sea.mode("b3") == Mode.HOLD
    assert sea.mode("b1") in (Mode.FOLLOW, Mode.AVOID)
    assert sea.members("b1") == 1, "a boat that holds is not in the sums"


# -- changes of the formation ------------------------------------------------------------------------------------------
def test_a_change_takes_effect_on_all_boats_within_a_tick(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    switched: dict[str, int] = {}

    def look() -> None:
        for boat in sea.agents():
            if sea.spacing(boat) == 15.0:
                switched.setdefault(boat, sea.now_ns)

    sea.each_tick.append(look)
    acks = sea.change(spacing_m=15.0)
    assert all(
        ack.ok and ack.old.startswith("spacing 12 m") and ack.new.startswith("spacing 15 m") for ack in acks.values()
    )
    sea.run(3.0)
    assert len(switched) == 3
    assert max(switched.values()) - min(switched.values()) <= 100_000_000


def test_a_change_is_sailed(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3, 12.0))
    sea.change(spacing_m=15.0)
    sea.run(60.0)
    xs = [sea.where(boat)[0] for boat in sea.agents()]
    assert [a - b for a, b in itertools.pairwise(xs)] == [pytest.approx(15.0, abs=0.3)] * 2
    assert {sea.revision(boat) for boat in sea.agents()} == {Revision(1, "anna")}


def test_a_change_outlives_its_operator(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.change(spacing_m=15.0)
    sea.operators.clear()
    sea.run(5.0)
    assert {sea.spacing(boat) for boat in sea.agents()} == {15.0}


def test_a_change_based_on_an_older_revision_is_refused_and_says_which_is_held_and_whose(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.change(spacing_m=15.0)
    sea.run(3.0)
    before = picture_of_orders(sea, "b1")
    (reason,) = refusals(sea.change(spacing_m=20.0, based_on=Revision(0, "")))
    assert reason == "based on revision 0:launch, but 1:anna is held"
    assert picture_of_orders(sea, "b1") == before


def test_a_change_based_on_one_not_yet_in_force_is_a_change_of_that(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.change(spacing_m=15.0, apply_in_s=5.0)
    assert all(ack.ok for ack in sea.change(spacing_m=16.0, apply_in_s=1.0).values())
    sea.run(8.0)
    assert {sea.spacing(boat) for boat in sea.agents()} == {16.0}


def test_a_counter_more_than_a_thousand_ahead_is_refused(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    (reason,) = refusals(sea.change(spacing_m=15.0, counter=1001 + 1))
    assert "more than 1000 ahead" in reason
    assert all(ack.ok for ack in sea.change(spacing_m=15.0, counter=1000).values())


def test_a_neighbours_counter_more_than_a_thousand_ahead_is_refused_too(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.change(spacing_m=16.0)
    sea.run(4.0)
    orders = sea.agent("b1").orders
    assert orders.sailing is not None
    assert orders.sailing.held.counter == 1
    order = FormationOrder(
        MAJOR, orders.sailing.order.mission_id, Revision(5000, "bob"), Revision(4999, "bob"), 15.0, 1.0
    )
    assert "more than 1000 ahead" in orders.handed_on(Signed(encode(order)), 0.0, sea.now_ns)
    assert orders.sailing.pending is None


def test_a_boat_that_has_heard_of_no_change_takes_the_thousandth_from_its_neighbours(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    orders = sea.agent("b1").orders
    assert orders.sailing is not None
    order = FormationOrder(
        MAJOR, orders.sailing.order.mission_id, Revision(5000, "bob"), Revision(4999, "bob"), 15.0, 1.0
    )
    assert orders.handed_on(Signed(encode(order)), 0.0, sea.now_ns) == ""


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"spacing_m": 7.0}, "at least 8.0 m"),
        ({"spacing_m": 600.0}, "long"),
        ({"cruise_mps": 1.45}, "to keep its place"),
        ({"cruise_mps": 0.05}, "to keep its place"),
        ({"spacing_m": float("nan")}, "not finite"),
        ({"spacing_m": float("inf")}, "not finite"),
        ({"spacing_m": 1e308}, "long"),
        ({"apply_in_s": -1.0}, "impossible"),
        ({"apply_in_s": 1e9}, "impossible"),
        ({"mission_id": "of-yesterday"}, "it is for mission of-yesterday"),
        ({"signer": "bob"}, "does not follow"),
        ({"counter": 0}, "does not follow"),
    ],
)
def test_a_change_that_cannot_be_is_refused_with_its_reason(tmp_path: Path, changes: dict, words: str) -> None:  # type: ignore[type-arg]
    sea = sailing(tmp_path)
    before = picture_of_orders(sea, "b1")
    (reason,) = refusals(sea.change(**changes))
    assert words in reason
    assert picture_of_orders(sea, "b1") == before


def test_a_place_beyond_the_end_of_the_path_says_whose_and_where(tmp_path: Path) -> None:
    sea = sailing(tmp_path)  # the boats are 100 m from the beginning of their path
    acks = sea.change(spacing_m=100.0)
    assert not any(ack.ok for ack in acks.values())
    assert any("the place of b3 would be at -" in ack.reason for ack in acks.values()), acks
    assert all(ack.safety for ack in acks.values())


def test_slots_too_near_are_named(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    (reason,) = refusals(sea.change(spacing_m=-5.0))
    assert "b1 and b2 are 5.0 m apart" in reason


# -- out of reach ------------------------------------------------------------------------------------------------------
def test_a_boat_that_was_out_of_reach_of_a_change_gets_it_from_its_neighbours(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.cut("b3")
    sea.run(1.0)
    acks = sea.change(spacing_m=15.0)
    assert "b3" not in acks
    sea.operators.clear()
    sea.run(10.0)
    assert sea.spacing("b3") == 12.0
    sea.mend("b3")
    sea.run(1.0)
    assert sea.spacing("b3") == 15.0
    assert sea.revision("b3") == Revision(1, "anna")
    assert not sea.says("b3", "superseded"), "nobody's change vanished"


def test_what_is_left_of_the_time_to_apply_is_passed_on(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.cut("b3")
    sea.run(1.0)
    sea.change(spacing_m=15.0, apply_in_s=10.0)
    sea.run(4.0)
    sea.mend("b3")
    switched: dict[str, float] = {}

    def look() -> None:
        for boat in sea.agents():
            if sea.spacing(boat) == 15.0:
                switched.setdefault(boat, sea.time_s)

    sea.each_tick.append(look)
    sea.run(8.0)
    assert len(switched) == 3
    assert max(switched.values()) - min(switched.values()) <= 0.21, "together with the others"


def test_a_boat_that_missed_several_changes_gets_the_newest(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.cut("b3")
    sea.run(1.0)
    for spacing in (13.0, 14.0, 15.0):
        sea.change(spacing_m=spacing)
        sea.run(3.0)
    sea.mend("b3")
    sea.run(1.0)
    assert sea.revision("b3") == Revision(3, "anna")
    assert sea.spacing("b3") == 15.0


def test_a_boat_that_was_out_of_reach_of_the_launch_gets_the_mission_from_its_neighbours(tmp_path: Path) -> None:
    sea = Sea(tmp_path)
    sea.cut("b3")
    sea.run(0.5)
    sea.launch()
    sea.run(10.0)
    sea.change(spacing_m=15.0)
    sea.run(5.0)
    assert not sea.holds_mission("b3")
    sea.operators.clear()
    sea.mend("b3")
    sea.run(2.0)
    assert sea.mode("b3") in (Mode.FOLLOW, Mode.AVOID)
    assert sea.spacing("b3") == 15.0
    assert sea.members("b1") == 2


def test_a_boat_that_misses_the_launch_by_a_second_begins_with_the_others(tmp_path: Path) -> None:
    sea = Sea(tmp_path)
    sea.cut("b3")
    sea.run(0.5)
    sea.launch(apply_in_s=5.0)
    sea.run(1.0)
    sea.mend("b3")
    began: dict[str, float] = {}

    def look() -> None:
        for boat in sea.agents():
            if sea.mode(boat) != Mode.STANDBY:
                began.setdefault(boat, sea.time_s)

    sea.each_tick.append(look)
    sea.run(6.0)
    assert len(began) == 3
    assert max(began.values()) - min(began.values()) <= 0.21


def test_a_boat_in_a_mission_does_not_take_anothers(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.cut("b3")
    sea.run(0.5)
    old = sea.agent("b3").orders.sailing
    sea.launch(mission(title="Another one"))
    sea.run(3.0)
    sea.mend("b3")
    sea.run(5.0)
    assert sea.agent("b3").orders.sailing is old
    assert Reason.PEER_ELSEWHERE in sea.reasons("b3")
    assert sea.members("b1") == 1


def test_operators_words_are_handed_on_unaltered(tmp_path: Path) -> None:
    sea = Sea(tmp_path, ashore=("b3",))
    sea.run(0.5)
    sea.launch()
    sea.run(3.0)
    sea.change(spacing_m=15.0)
    sea.run(3.0)
    sea.stations["b3"].switch_on()
    sea.run(3.0)
    one, three = sea.agent("b1").orders.sailing, sea.agent("b3").orders.sailing
    assert one is not None
    assert three is not None
    assert three.words == one.words
    assert three.formation_words == one.formation_words


def test_an_answer_that_is_poisoned_hurts_nobody(tmp_path: Path) -> None:
    sea = Sea(tmp_path, ashore=("b3",))
    sea.run(0.5)
    sea.launch()
    sea.run(3.0)
    sea.change(spacing_m=15.0)
    sea.stations["b3"].switch_on()
    sea.tick()
    agent = sea.agent("b3")
    words = sea.agent("b1").orders.sailing
    assert words is not None
    bus = sea.stations["b3"].bus
    assert bus is not None
    from fleet.wire.bus import Answer

    for remaining in (float("nan"), float("inf"), -1e300):
        for what in (keys.MISSION, keys.FORMATION):
            bus._answers.append(Answer("b1", what, encode(Held(MAJOR, words.words, remaining))))
    bus._answers.append(Answer("b1", keys.ECHO, encode((MAJOR, -(1 << 63)))))
    bus._answers.append(Answer("b1", keys.MISSION, b"\xc1"))
    bus._answers.append(Answer("b9", "nonsense", b""))
    sea.run(3.0)
    assert agent.desk.refused.total() >= 3
    assert sea.mode("b3") in (Mode.FOLLOW, Mode.AVOID)


# -- two operators -----------------------------------------------------------------------------------------------------
def divided(folder: Path) -> Sea:
    """b1, b2 with anna on one side, b3, b4 with bob on the other, who took control there."""
    sea = sailing(folder, mission(4, 12.0))
    sea.operators = {"anna": 0, "bob": 1}
    sea.divide(("b1", "b2"), ("b3", "b4"))
    sea.run(1.0)
    assert all(ack.ok for ack in sea.command("take", operator="bob").values())
    return sea


def test_of_two_operators_at_once_one_is_refused_on_every_boat_or_outvoted_on_every_boat(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.command("take", operator="bob")
    assert {ack.reason for ack in sea.change(spacing_m=14.0, operator="anna").values()} == {
        "bob holds control; `fleet take` takes it over"
    }
    sea.change(spacing_m=15.0, operator="bob")
    sea.run(3.0)
    assert {sea.spacing(boat) for boat in sea.agents()} == {15.0}


@pytest.mark.parametrize("bobs", [1, 2, 3])
@pytest.mark.parametrize("annas", [1, 2])
def test_after_a_partition_the_larger_revision_wins_and_who_had_switched_says_so(
    tmp_path: Path, annas: int, bobs: int
) -> None:
    sea = divided(tmp_path)
    for k in range(annas):
        assert all(ack.ok for ack in sea.change(spacing_m=14.0 + k, operator="anna", of="b1").values())
        sea.run(2.5)
    for k in range(bobs):
        assert all(ack.ok for ack in sea.change(spacing_m=20.0 + k, operator="bob", of="b3").values())
        sea.run(2.5)
    assert sea.spacing("b2") == 13.0 + annas
    assert sea.spacing("b4") == 19.0 + bobs
    sea.divide()
    sea.run(2.0)
    bob_wins = Revision(bobs, "bob") > Revision(annas, "anna")
    winner = 19.0 + bobs if bob_wins else 13.0 + annas
    assert {sea.spacing(boat) for boat in sea.agents()} == {winner}
    losers, winners = (("b1", "b2"), ("b3", "b4")) if bob_wins else (("b3", "b4"), ("b1", "b2"))
    for boat in losers:
        (text,) = sea.says(boat, "superseded")
        assert f"spacing {13 + annas} m" in text
        assert f"spacing {19 + bobs} m" in text
    for boat in winners:
        assert sea.says(boat, "superseded") == []


def test_after_a_partition_control_is_where_it_was_taken_last(tmp_path: Path) -> None:
    sea = divided(tmp_path)
    sea.divide()
    sea.run(1.0)
    assert {sea.agent(boat).orders.control.operator for boat in sea.agents()} == {"bob"}


def test_who_holds_control_is_shown(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    assert sea.statuses["b1"].controller == "anna"
    sea.command("take", operator="bob")
    sea.run(1.2)
    assert {status.controller for status in sea.statuses.values()} == {"bob"}


def test_another_operator_may_hold_abort_and_stop_but_not_command(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    for kind in ("resume", "return", "release", "forget"):
        assert refusals(sea.command(kind, operator="bob")) == {"anna holds control; `fleet take` takes it over"}
    for kind in ("hold", "stop-now", "abort"):
        assert all(ack.ok for ack in sea.command(kind, operator="bob").values())
    assert {sea.agent(boat).orders.control.operator for boat in sea.agents()} == {"anna"}, "nor is control taken by it"


def test_a_refused_command_does_not_take_control(tmp_path: Path) -> None:
    sea = Sea(tmp_path)
    sea.run(0.5)
    refusals(sea.command("resume", operator="bob"))
    assert {sea.agent(boat).orders.control.operator for boat in sea.agents()} == {""}
    assert all(ack.ok for ack in sea.launch(operator="anna").values())


# -- hold, abort, return -----------------------------------------------------------------------------------------------
def test_hold_keeps_station_within_two_radii_and_resume_goes_on(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.command("hold")
    places = {boat: sea.where(boat) for boat in sea.agents()}
    sea.run(60.0)
    assert sea.modes() == [Mode.HOLD] * 3
    for boat, (x, y) in places.items():
        here = sea.where(boat)
        assert ((here[0] - x) ** 2 + (here[1] - y) ** 2) ** 0.5 < 12.0
    sea.command("resume")
    sea.run(30.0)
    assert set(sea.modes()) <= {Mode.FOLLOW, Mode.AVOID}
    assert max(abs(sea.agent(boat).decision.e) for boat in sea.agents()) < 1.0


def test_abort_ends_the_mission_and_holds(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    acks = sea.command("abort")
    assert all(ack.ok and ack.new == "none, hold" for ack in acks.values())
    sea.run(5.0)
    assert sea.modes() == [Mode.HOLD] * 3
    assert not any(sea.holds_mission(boat) for boat in sea.agents())


def test_a_boat_that_was_told_to_abort_does_not_take_the_mission_again_from_its_neighbours(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.command("abort", boats=("b3",))
    sea.run(20.0)
    assert sea.mode("b3") == Mode.HOLD
    assert not sea.holds_mission("b3")
    sea.restart("b3")
    sea.run(20.0)
    assert sea.mode("b3") == Mode.STANDBY, "nor after a restart"
    assert not sea.holds_mission("b3")


def test_return_goes_back_along_the_track_to_home_and_holds(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 40.0)
    sea.command("return", boats=("b2",))
    sea.run(1.0)
    assert sea.mode("b2") == Mode.RETURN
    sea.run_until(lambda: sea.mode("b2") == Mode.HOLD, 300.0)
    x, y = sea.where("b2")
    assert (x**2 + (y + 20.0) ** 2) ** 0.5 < 6.0
    assert sea.least_m > 3.0


def test_return_after_abort_is_obeyed(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 40.0)
    x, _ = sea.where("b2")
    sea.command("abort")
    sea.run(1.0)
    assert sea.command("return", boats=("b2",))["b2"].ok
    sea.run(30.0)
    assert sea.where("b2")[0] < x - 10.0


def test_hold_without_a_mission_holds(tmp_path: Path) -> None:
    sea = Sea(tmp_path)
    sea.run(0.5)
    assert all(ack.ok for ack in sea.command("hold").values())
    sea.run(1.0)
    assert sea.modes() == [Mode.HOLD] * 3


def test_goals_are_numbers_that_modes_share() -> None:
    assert all(Mode(goal).name == goal.name for goal in Goal)
