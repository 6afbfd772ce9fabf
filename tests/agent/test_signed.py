"""Words are obeyed once, and only when an operator of the roster signed them; no relay changes that."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from fleet.agent.guard import CHECKS_A_TICK
from fleet.agent.modes import Goal, Mode
from fleet.mission.load import encode as encode_mission
from fleet.mission.model import Mission
from fleet.wire import keys
from fleet.wire.codec import decode, encode
from fleet.wire.messages import MAJOR, Command, FormationOrder, MissionOrder, Revision, Signed
from tests.agent.harness import BEGIN_NS, Sea, mission
from tests.wire.credentials.fleet_of import Issued

UNDER_WAY = {Mode.FOLLOW, Mode.AVOID}
pytestmark = pytest.mark.usefixtures("logged")


@pytest.fixture
def logged(caplog: pytest.LogCaptureFixture) -> Iterator[None]:
    with caplog.at_level(logging.WARNING):
        yield


@pytest.fixture(scope="module")
def issued(tmp_path_factory: pytest.TempPathFactory) -> Issued:
    one = Issued(tmp_path_factory.mktemp("a"), lambda: BEGIN_NS * 1e-9, operators=("anna", "bert", "oscar"))
    one.authority.issue("operator", "old", BEGIN_NS * 1e-9 - 86400.0, days=0.9999)
    return one


def afloat(folder: Path, issued: Issued, what: Mission | None = None, launched: bool = True, **more: object) -> Sea:
    """A fleet with credentials, launched by anna."""
    signers = {name: issued.operator(name) for name in ("anna", "bert")}
    sea = Sea(folder, what, trust=issued.boat, signers=signers, **more)  # type: ignore[arg-type]
    sea.run(0.5)
    if launched:
        acks = sea.launch()
        assert acks
        assert all(ack.ok for ack in acks.values()), acks
        sea.run(3.0)
    return sea


def refused(sea: Sea, boat: str = "b1") -> list[str]:
    return sea.says(boat, "refused")


# -- as without --------------------------------------------------------------------------------------------------------
def test_signed_words_are_obeyed_as_others_are(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    assert set(sea.modes()) <= UNDER_WAY
    assert all(ack.ok for ack in sea.change(spacing_m=15.0).values())
    sea.run(3.0)
    assert [sea.spacing(boat) for boat in sea.agents()] == [15.0] * 3
    for kind in ("hold", "resume", "return", "take", "abort"):
        acks = sea.command(kind)
        assert all(ack.ok for ack in acks.values()), (kind, acks)
    assert all(ack.ok for ack in sea.command("stop-now", command_id="s1").values())
    assert all(ack.ok for ack in sea.command("release", names=("s1",)).values())
    assert not [event for _, event in sea.events if event.kind == "refused"]


def test_a_late_boat_takes_mission_and_formation_from_its_neighbours(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued, ashore=("b3",))
    sea.change(spacing_m=15.0)
    sea.run(3.0)
    sea.stations["b3"].switch_on()
    sea.run(4.0)
    assert sea.mode("b3") in UNDER_WAY
    assert sea.spacing("b3") == 15.0


# -- who said it -------------------------------------------------------------------------------------------------------
def test_a_word_that_is_not_signed_is_refused_and_named(
    tmp_path: Path, issued: Issued, caplog: pytest.LogCaptureFixture
) -> None:
    sea = afloat(tmp_path, issued)
    acks = sea.command("abort", operator="eve")
    assert {ack.reason for ack in acks.values()} == {
        "the command is not signed; this boat obeys signed words only: --credentials FOLDER"
    }
    assert set(sea.modes()) <= UNDER_WAY
    assert refused(sea) == ["abort of eve is not signed"]
    assert "refused: abort of eve is not signed" in caplog.text
    sea.run(1.5)
    assert any("command: is not signed" in text for text in sea.statuses["b1"].refusals)


@pytest.mark.parametrize("kind", ["hold", "abort", "stop-now", "release", "take", "resume", "return", "forget"])
def test_a_boats_word_is_no_operators(tmp_path: Path, issued: Issued, kind: str) -> None:
    sea = afloat(tmp_path, issued)
    sea.signers["anna"] = issued.boat("b3")
    before = [(agent.orders.goal, agent.orders.control, dict(agent.orders.stops)) for agent in sea.agents().values()]
    acks = sea.command(kind)
    assert not any(ack.ok for ack in acks.values())
    assert refused(sea) == [f"{kind} of anna is signed by boat b3: only operators command"]
    after = [(agent.orders.goal, agent.orders.control, dict(agent.orders.stops)) for agent in sea.agents().values()]
    assert after == before


def test_an_operator_in_anothers_name_a_revoked_one_and_one_whose_time_is_over(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    own = issued.operator("oscar")
    sea.signers["oscar"] = own
    sea.signers["anna"] = own
    sea.command("abort")
    assert "abort of anna is signed by operator oscar" in refused(sea)[-1]
    issued.authority.revoke("oscar", BEGIN_NS * 1e-9)
    for agent in sea.agents().values():
        assert agent.guard.trust is not None
        agent.guard.trust.look()
    sea.command("abort", operator="oscar")
    assert f"abort of oscar is signed by operator oscar ({own.common_name[-16:]}), revoked" in refused(sea)[-1]
    folder = issued.folder / "old"
    from fleet.wire.credentials.trust import load

    sea.signers["old"] = load(folder, "f", "operator", now=lambda: BEGIN_NS * 1e-9 - 1800.0)
    sea.run(0.3)
    sea.command("abort", operator="old")
    assert ", expired 2023-11-1" in refused(sea)[-1]
    assert set(sea.modes()) <= UNDER_WAY


def test_a_launch_that_carries_another_signers_mission_is_refused(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued, launched=False)
    words = sea.mission_words()
    acks = sea.command("launch", operator="bert", order=words)
    assert not any(ack.ok for ack in acks.values())
    assert not any(sea.holds_mission(boat) for boat in sea.agents())
    forged = msgspec.structs.replace(words, body=words.body + b"x")
    acks = sea.command("launch", order=forged)
    assert "order in the launch of anna does not bear the signature of operator anna" in refused(sea)[-1]
    assert not any(sea.holds_mission(boat) for boat in sea.agents())


# -- relayed -----------------------------------------------------------------------------------------------------------
def faster(words: Signed) -> bytes:
    """The same mission, at another speed."""
    from fleet.mission.load import decode as decode_mission
    from fleet.wire.codec import decode_mission_order

    order: MissionOrder = decode_mission_order(words)
    plan = decode_mission(order.mission)
    formation = msgspec.structs.replace(plan.formation, cruise_mps=1.2)
    return encode(
        msgspec.structs.replace(order, mission=encode_mission(msgspec.structs.replace(plan, formation=formation)))
    )


@pytest.mark.parametrize("how", ["altered", "signed by the boat", "not signed"])
def test_a_mission_that_a_boat_alters_while_it_relays_it_is_not_sailed(
    tmp_path: Path, issued: Issued, how: str
) -> None:
    sea = afloat(tmp_path, issued, ashore=("b3",))
    for boat in ("b1", "b2"):
        sailing = sea.agent(boat).orders.sailing
        assert sailing is not None
        body = faster(sailing.words)
        sailing.words = {
            "altered": Signed(body, sailing.words.signature, sailing.words.signer),
            "signed by the boat": issued.boat(boat).sign("mission", body),
            "not signed": Signed(body),
        }[how]
    sea.stations["b3"].switch_on()
    sea.run(4.0)
    assert not sea.holds_mission("b3")
    assert sea.mode("b3") == Mode.STANDBY
    why = {
        "altered": "does not bear the signature of operator anna",
        "signed by the boat": "is signed by boat b1: only operators command",
        "not signed": "mission of anna from b1 is not signed",
    }[how]
    assert any(why in text for text in refused(sea, "b3"))
    assert len(refused(sea, "b3")) <= 4, "said once in a while, not with every try"


def test_a_formation_that_a_boat_alters_while_it_relays_it_is_not_sailed(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    sailing = sea.agent("b1").orders.sailing
    assert sailing is not None
    for by, sign in (("anna", issued.boat("b1").sign), ("b1", issued.boat("b1").sign)):
        order = FormationOrder(MAJOR, sailing.order.mission_id, Revision(1, by), Revision(), 30.0, 1.0, 2.0, sea.now_ns)
        sea.agent("b1").orders.expect(order, sign("formation", encode(order)), sea.now_ns + 2_000_000_000)
        sea.run(3.0)
        assert sea.spacing("b1") == 30.0, "it believes itself"
        assert [sea.spacing(boat) for boat in ("b2", "b3")] == [12.0, 12.0]
    assert any("formation of anna from b1 is signed by boat b1" in text for text in refused(sea, "b2"))
    assert any("is a boat's, and more than closing up" in text for text in refused(sea, "b2"))


def test_boats_may_close_up_where_the_mission_says_so_and_do_nothing_else(tmp_path: Path, issued: Issued) -> None:
    plan = mission(3)
    plan = msgspec.structs.replace(plan, formation=msgspec.structs.replace(plan.formation, vacancies="close-up"))
    sea = afloat(tmp_path, issued, plan)
    sea.run(15.0)
    sea.kill("b2")
    sea.run(20.0)
    for boat in ("b1", "b3"):
        sailing = sea.agent(boat).orders.sailing
        assert sailing is not None
        assert sailing.formation.revision == Revision(1, "b1")
        assert sailing.shape.slots[2] == -1.0


def test_a_stop_reaches_who_was_out_of_reach_in_the_operators_own_words(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    sea.cut("b3")
    sea.divide(("b1", "b2"), ("b3",))
    sea.operators["anna"] = 0
    acks = sea.command("stop-now", command_id="all-1")
    assert set(acks) == {"b1", "b2"}
    sea.run(1.0)
    sea.mend("b3")
    sea.divide()
    sea.run(2.0)
    assert sea.mode("b3") == Mode.NEUTRAL
    assert list(sea.agent("b3").orders.stops) == ["all-1"]
    sea.restart("b3")
    sea.run(1.0)
    assert list(sea.agent("b3").orders.stop_words) == ["all-1"], "to be handed on by it, too"


def test_a_stop_that_nobody_said_stops_nobody(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    orders = sea.agent("b1").orders
    orders.stops["all-forged"] = None
    command = Command(MAJOR, "all-forged", "anna", "stop-now", (), stamp_ns=sea.now_ns)
    orders.stop_words["all-forged"] = issued.boat("b1").sign("command", encode(command))
    sea.run(2.0)
    assert sea.mode("b2") in UNDER_WAY
    assert not sea.agent("b2").orders.stops
    assert any(
        "stop of anna from b1 is signed by boat b1: only operators command" in text for text in refused(sea, "b2")
    )
    other = issued.operator().sign("command", encode(msgspec.structs.replace(command, kind="hold")))
    orders.stop_words["all-forged"] = other
    sea.run(11.0)
    assert any("is no stop of the whole fleet but 'hold'" in text for text in refused(sea, "b2"))
    assert not sea.agent("b2").orders.stops


def test_a_neighbour_cannot_give_control_to_somebody_who_is_no_operator(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    sea.agent("b1").orders.control = Revision(9, "eve")
    sea.run(1.0)
    assert sea.agent("b2").orders.control.operator == "anna"


# -- once --------------------------------------------------------------------------------------------------------------
def said(sea: Sea, kind: str, **more: object) -> bytes:
    """A word of anna's, as somebody on the way could have kept it."""
    command = Command(MAJOR, f"old-{kind}", "anna", kind, (), stamp_ns=sea.now_ns, **more)  # type: ignore[arg-type]
    return encode(sea.sign("command", encode(command), "anna"))


def test_an_old_word_played_again_is_not_obeyed_not_even_after_a_restart(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    old = said(sea, "resume")
    sea.ask_raw(old)
    sea.tick()
    sea.command("hold")
    assert sea.agent("b1").orders.goal == Goal.HOLD
    sea.ask_raw(old)
    sea.tick()
    assert sea.agent("b1").orders.goal == Goal.HOLD, "answered again, done once"
    sea.restart("b1")
    sea.run(1.0)
    goal = sea.agent("b1").orders.goal
    acks = sea.ask_raw(old)
    sea.tick()
    assert not acks["b1"].ok
    assert "older than the last word of its signer: played again" in acks["b1"].reason
    assert sea.agent("b1").orders.goal == goal


def test_a_word_that_never_arrived_is_not_obeyed_two_minutes_later(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    late = said(sea, "return")
    sea.run(119.0)
    sea.command("hold", operator="bert")
    sea.run(2.0)
    acks = sea.ask_raw(late)
    sea.tick()
    assert {ack.reason for ack in acks.values()} == {"the command is 121 s old, at most 120: played again?"}
    assert sea.agent("b1").orders.goal == Goal.HOLD


def test_a_boat_that_does_not_know_the_time_asks_for_no_age_but_for_the_order(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued, clock_ns=10**9)
    late = said(sea, "return")
    sea.run(130.0)
    acks = sea.ask_raw(late)
    sea.tick()
    assert all(ack.ok for ack in acks.values())
    earlier = said(sea, "take")
    sea.tick()
    sea.command("hold")
    acks = sea.ask_raw(earlier)
    sea.tick()
    assert not any(ack.ok for ack in acks.values())


def test_no_wrong_clock_stands_in_the_way_of_a_stop_but_a_released_one_does_not_come_back(
    tmp_path: Path, issued: Issued
) -> None:
    sea = afloat(tmp_path, issued)
    command = Command(MAJOR, "all-7", "anna", "stop-now", (), stamp_ns=1)
    words = encode(sea.sign("command", encode(command), "anna"))
    acks = sea.ask_raw(words)
    sea.tick()
    assert all(ack.ok for ack in acks.values())
    assert all(ack.ok for ack in sea.command("release", names=("all-7",)).values())
    for boat in ("b1", "b2", "b3"):
        sea.restart(boat)
    sea.run(1.0)
    acks = sea.ask_raw(words)
    sea.tick()
    assert {ack.reason for ack in acks.values()} == {"the command is a stop that was released: played again"}
    assert not any(sea.agent(boat).orders.stops for boat in sea.agents())


def test_a_mission_of_before_is_not_taken_from_a_neighbour(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued, launched=False)
    old = sea.mission_words()
    sea.run(1.0)
    sea.launch()
    sea.run(2.0)
    sea.command("abort", boats=("b3",))
    one = sea.agent("b1").orders.sailing
    assert one is not None
    sea.command("abort", boats=("b1", "b2"))
    sea.agent("b3").orders.stand_by(sea.agent("b3").orders.why)
    with pytest.raises(Exception, match="older than one that this boat held: played again"):
        sea.agent("b3").guard.mission(old, "b1", sea.now_ns)


# -- what it costs, and rosters ----------------------------------------------------------------------------------------
def test_a_flood_of_forged_words_costs_so_many_signatures_a_tick(
    tmp_path: Path, issued: Issued, monkeypatch: pytest.MonkeyPatch
) -> None:
    sea = afloat(tmp_path, issued)
    checked: list[str] = []
    trust = sea.agent("b1").guard.trust
    assert trust is not None
    signer = trust.signer
    monkeypatch.setattr(trust, "signer", lambda purpose, words: checked.append(purpose) or signer(purpose, words))
    forged = issued.boat("b3")
    for k in range(100):
        command = Command(MAJOR, f"f{k}", "anna", "abort", (), stamp_ns=sea.now_ns)
        sea.water.boats["b1"].deposit_request(
            keys.COMMAND, encode(forged.sign("command", encode(command))), lambda answer: None
        )
    sea.tick()
    assert 0 < len(checked) <= CHECKS_A_TICK
    assert sea.mode("b1") in UNDER_WAY


def test_an_operator_brings_a_roster_and_an_older_one_changes_nothing(tmp_path: Path, issued: Issued) -> None:
    sea = afloat(tmp_path, issued)
    before = (issued.folder / "roster.json").read_bytes()
    issued.authority.issue("boat", "b11", BEGIN_NS * 1e-9)
    number = issued.authority.roster.number
    newer = (issued.folder / "roster.json").read_bytes()
    acks = sea.ask_raw(newer, what=keys.ROSTER)
    sea.tick()
    assert {(ack.ok, ack.new) for ack in acks.values()} == {(True, str(number))}
    acks = sea.ask_raw(before, what=keys.ROSTER)
    sea.tick()
    assert {(ack.ok, ack.reason, ack.new) for ack in acks.values()} == {(True, "not newer", str(number))}
    acks = sea.ask_raw(newer.replace(b"e", b"f"), what=keys.ROSTER)
    sea.tick()
    assert not any(ack.ok for ack in acks.values())
    sea.run(1.0)
    assert sea.statuses["b1"].roster == number


def test_without_credentials_signed_words_are_words(tmp_path: Path, issued: Issued) -> None:
    sea = Sea(tmp_path, signers={"anna": issued.operator()})
    sea.run(0.5)
    assert all(ack.ok for ack in sea.launch().values())
    words = sea.sign("command", b"", "anna")
    assert decode(encode(words), Signed) == words
