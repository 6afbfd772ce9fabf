"""What an attacker, or an unlucky network, puts before one boat's door: each case once, in lock-step, in memory."""

from __future__ import annotations

import math
import random
import threading
from pathlib import Path
from typing import Any

import msgspec
import pytest

from fleet.agent.background import MOST, Background
from fleet.agent.examine import apart
from fleet.agent.modes import Goal, Mode, Reason
from fleet.agent.serve import PATIENCE_S
from fleet.mission.check import check
from fleet.mission.load import encode as encode_mission
from fleet.mission.model import Sine, Through
from fleet.wire import keys
from fleet.wire.bus import Answer
from fleet.wire.codec import encode
from fleet.wire.messages import MAJOR, BoatState, Command, FormationOrder, Held, MissionOrder, Revision, Signed
from tests.agent.harness import Sea, forged, mission, sailing


def members(sea: Sea) -> list[int]:
    """Boats in the sums of each, itself apart."""
    return [sea.members(boat) for boat in sea.agents()]


def flooded(sea: Sea, name: str, seconds: float, make: Any, each_tick: int = 20) -> list[int]:
    """Sail on while forged states arrive before and after every true one; the least members of each boat."""
    rng = random.Random(7)
    least = members(sea)
    for _ in range(round(seconds * 10.0)):
        for _ in range(each_tick):
            sea.say_as(name, make(sea.state(name), rng))
        sea.tick()
        least = [min(a, b) for a, b in zip(least, members(sea), strict=True)]
    return least


# -- states ----------------------------------------------------------------------------------------------------------
def leaps(state: BoatState, rng: random.Random) -> bytes:
    return forged(state, seq=state.seq + rng.choice((20, 500, 900, 2**20, 2**60)))


def starts_anew(state: BoatState, rng: random.Random) -> bytes:
    return forged(state, epoch=rng.getrandbits(60), seq=rng.randrange(1, 1000), stamp_ns=state.stamp_ns + 10**18)


def jumps(state: BoatState, rng: random.Random) -> bytes:
    return forged(state, seq=state.seq + 1, lat_deg=state.lat_deg + 0.01)


@pytest.mark.parametrize("make", [leaps, starts_anew, jumps])
def test_no_lie_about_a_boat_that_speaks_takes_it_out_of_the_sums(tmp_path: Path, make: Any) -> None:
    sea = sailing(tmp_path, mission(3))
    before = {boat: sea.agent(boat).picture.refused.total() for boat in ("b1", "b3")}
    assert flooded(sea, "b2", 3.0, make) == [2, 2, 2]
    assert not sea.reasons("b1") & (Reason.PEER_SILENT | Reason.IDENTITY_CLASH | Reason.AVOIDING)
    for boat, count in before.items():
        assert sea.agent(boat).picture.refused.total() - count == 600, "all counted"


def test_a_boat_whose_number_truly_leapt_is_believed_again(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3))
    sea.agent("b2").reporter._seq += 5000
    sea.run(4.0)
    assert members(sea) == [2, 2, 2]


def test_two_processes_that_go_on_speaking_are_a_clash_within_a_second_and_a_half(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3))
    epoch = sea.now_ns
    for seq in range(1, 16):
        sea.say_as("b2", forged(sea.state("b2"), epoch=epoch, seq=seq, stamp_ns=sea.now_ns), to=("b1",))
        sea.tick()
    assert Reason.IDENTITY_CLASH in sea.reasons("b1")
    assert sea.members("b1") == 1
    assert sum(math.floor(peer.number) == 1 for peer in sea.agent("b1").peers) == 2, "both are obstacles"


def test_a_restarted_boat_replaces_its_old_self_within_two_ticks(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3))
    sea.restart("b2")
    sea.run(0.3)
    track = sea.agent("b1").picture.others["b2"].track
    assert track is not None
    assert track.state.epoch == sea.state("b2").epoch


IMPOSSIBLE: list[dict[str, Any]] = [
    {"position_error_m": 1e300},
    {"s_m": 1e300},
    {"s_m": -1e300},
    {"straight_s": 1e300},
    {"yaw_rate_radps": 1e300},
    {"cross_track_m": 1e300},
    {"nearest_m": 1e300},
    {"length_m": 1e300},
    {"length_m": -1.0},
    {"decided_speed_mps": 1e6},
    {"lat_deg": -44.38, "lon_deg": 8.93},
]


@pytest.mark.parametrize("values", IMPOSSIBLE, ids=str)
def test_impossible_values_are_refused_even_of_a_boat_heard_for_the_first_time(
    tmp_path: Path, values: dict[str, Any]
) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    sea.agent("b1").bus.watch("ghost")
    sea.say_as("ghost", forged(sea.state("b2"), boat="ghost", **values), to=("b1",))
    sea.tick()
    assert sea.agent("b1").picture.refused.total() == 1
    assert "ghost" not in sea.agent("b1").picture.others or sea.agent("b1").picture.others["ghost"].track is None


def test_who_is_not_of_the_mission_has_no_word_in_who_controls_it(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    sea.agent("b1").bus.watch("ghost")
    sea.say_as("ghost", forged(sea.state("b2"), boat="ghost", control=Revision(900, "mallory")), to=("b1",))
    sea.tick()
    assert sea.agent("b1").orders.control.operator == "anna"


def test_hearing_the_own_words_again_is_no_other_boat_with_the_own_name(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 2.0)
    for _ in range(20):
        sea.say_as("b1", sea.raw["b1"], to=("b1",))
        sea.say_as("b1", forged(sea.state("b1"), epoch=5, seq=3), to=("b1",))
        sea.tick()
    assert Reason.IDENTITY_CLASH not in sea.reasons("b1")
    assert sea.agent("b1").picture.refused.total() == 40
    for number in range(5):
        sea.say_as("b1", forged(sea.state("b1"), epoch=5, seq=10 + number, stamp_ns=sea.now_ns), to=("b1",))
        sea.tick()
    assert Reason.IDENTITY_CLASH in sea.reasons("b1"), "another process, and it goes on speaking"


def test_the_first_word_of_another_does_not_say_where_the_datum_is(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2), ashore=("b1",))
    sea.run(0.5)
    station = sea.stations["b1"]
    station.driver.spoil = lambda reading: msgspec.structs.replace(reading, stamp_ns=0)  # no fix yet
    station.switch_on()
    sea.agent("b1").bus.watch("b2")
    sea.say_as("b2", forged(sea.state("b2"), lat_deg=89.9, seq=sea.state("b2").seq + 1), to=("b1",))
    sea.run(0.2)
    station.driver.spoil = lambda reading: reading
    sea.run(0.5)
    plane = sea.agent("b1").plane
    assert plane is not None
    assert abs(plane.lat_deg - 44.38) < 0.1


def test_whatever_is_believed_of_a_peer_the_boat_decides_on(tmp_path: Path) -> None:
    """Every field at every edge, in the message that comes next: no tick raises, every set-point is finite."""
    sea = sailing(tmp_path, mission(2, method="scoring"), 2.0)
    edges: list[Any] = [0.0, -0.0, 1e-300, 1e9, -1e9, 1e308, -1e308, math.inf, math.nan, 29.0, -3.2, 90.0, -180.0]
    whole = [0, -1, 1, 7, 255, 2**31, 2**40 - 1, 2**62]
    for field in msgspec.structs.fields(BoatState):
        state = sea.state("b2")
        values = edges if field.type is float or field.type == "float" else whole
        if isinstance(getattr(state, field.name), (str, tuple, bool, Revision)):
            continue
        for value in values:
            lie = {field.name: value} if field.name == "seq" else {field.name: value, "seq": sea.state("b2").seq + 1}
            sea.say_as("b2", forged(sea.state("b2"), **lie), to=("b1",))
            sea.tick()
            assert math.isfinite(sea.agent("b1").decision.u_d + sea.agent("b1").decision.r_d), lie


# -- commands --------------------------------------------------------------------------------------------------------
def command(sea: Sea, **values: Any) -> bytes:
    """A command as bytes, with values that no operator's program writes."""
    sea.ids += 1
    base = Command(MAJOR, f"x{sea.ids}", "mallory", "hold", (), stamp_ns=sea.now_ns)
    return encode(msgspec.structs.replace(base, **values))


@pytest.mark.parametrize(
    "values",
    [
        {"kind": "x" * 500_000},
        {"names": ("x" * 500_000,)},
        {"boats": ("x" * 500_000,)},
        {"mission_id": "x" * 500_000},
        {"id": "\U0001f6a4" * 64},
        {"id": "a\nb"},
    ],
    ids=["kind", "names", "boats", "mission", "emoji", "lines"],
)
def test_huge_or_strange_words_in_a_command_are_refused_in_few_words(tmp_path: Path, values: dict[str, Any]) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    answers = sea.ask_raw(command(sea, **values))
    sea.tick()
    assert not answers["b1"].ok
    assert len(encode(answers["b1"])) < 600
    assert sea.agent("b1").orders.goal == Goal.FOLLOW


def test_an_old_id_with_another_content_is_refused_and_not_acknowledged_as_done(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    assert all(a.ok for a in sea.command("hold", command_id="one").values())
    assert all(a.ok for a in sea.command("resume", text="nearest").values())
    answers = sea.command("abort", command_id="one")
    assert not any(a.ok for a in answers.values())
    assert sea.holds_mission("b1")


def test_a_flood_of_refused_commands_does_not_make_an_old_one_new(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    recorded = encode(Command(MAJOR, "recorded", "anna", "hold", (), stamp_ns=sea.now_ns))
    sea.ask_raw(recorded)
    sea.tick()
    assert sea.mode("b1") == Mode.HOLD
    sea.command("resume", text="nearest")
    sea.run(1.0)
    for _ in range(30):
        for _ in range(20):
            sea.ask_raw(command(sea, kind="return"))
        sea.tick()
    answers = sea.ask_raw(recorded)
    sea.run(0.5)
    assert answers["b1"].ok, "acknowledged again"
    assert sea.mode("b1") == Mode.FOLLOW, "but not done again"


def test_a_flood_of_refused_commands_is_counted_but_not_told_one_by_one(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    told, counted = len(sea.says("b1", "refused")), sea.agent("b1").desk.refused.total()
    for _ in range(20):
        for _ in range(50):
            sea.ask_raw(command(sea, kind=f"kind-{sea.ids}", names=(f"n{sea.ids}",)))
        sea.tick()
    assert sea.agent("b1").desk.refused.total() - counted == 1000
    assert 1 <= len(sea.says("b1", "refused")) - told <= 20
    assert len(sea.agent("b1").desk.refused) <= 64


@pytest.mark.parametrize("spacing_m", [1e308, -1e308, 1e7])
def test_an_absurd_spacing_is_refused(tmp_path: Path, spacing_m: float) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    assert not any(ack.ok for ack in sea.change(spacing_m=spacing_m).values())


@pytest.mark.parametrize("who", ["mission_id", "operator", "based"])
def test_huge_words_inside_an_order_are_refused_in_few_words(tmp_path: Path, who: str) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    held = sea.agent("b1").orders.sailing
    assert held is not None
    order = FormationOrder(MAJOR, held.order.mission_id, Revision(1, "anna"), Revision(0, ""), 15.0, 1.0)
    long = "x" * 100_000
    changes: dict[str, Any] = {
        "mission_id": {"mission_id": long},
        "operator": {"revision": Revision(1, long)},
        "based": {"based_on": Revision(0, long)},
    }[who]
    words = Signed(encode(msgspec.structs.replace(order, **changes)))
    answers = sea.command("set", order=words)
    assert not answers["b1"].ok
    assert len(encode(answers["b1"])) < 600


# -- missions --------------------------------------------------------------------------------------------------------
def wrong_missions() -> dict[str, bytes]:
    """Bytes in the place of a mission."""
    good = msgspec.to_builtins(mission(2))
    wave = Sine(start=(0.0, 0.0), end=(1000.0, 0.0), amplitude_m=1e-9, wavelength_m=1e-3)
    far = tuple((100.0 * (i % 2), 0.4 * i) for i in range(20_000))
    pack = msgspec.msgpack.encode
    return {
        "empty": b"",
        "nothing": pack(None),
        "deep": b"\x91" * 200_000,
        "many misfits": pack({**good, "boats": [None] * 200_000}),
        "many boats": pack({**good, "boats": [good["boats"][0]] * 3000}),
        "endless sine": pack({**good, "paths": {"path": msgspec.to_builtins(wave)}}),
        "endless curve": pack({**good, "paths": {"path": msgspec.to_builtins(Through(points=far))}}),
        "many paths": pack(
            {**good, "paths": {f"p{i}": msgspec.to_builtins(Through(points=far[:500])) for i in range(100)}}
        ),
        "nan": pack({**good, "formation": {"spacing_m": math.nan, "cruise_mps": 1.0}}),
        "random": random.Random(3).randbytes(5000),
    }


@pytest.mark.timeout(20)
@pytest.mark.parametrize("name", sorted(wrong_missions()))
def test_a_mission_that_cannot_be_is_refused_quickly_and_in_few_words(tmp_path: Path, name: str) -> None:
    sea = Sea(tmp_path, mission(2))
    sea.run(0.5)
    order = MissionOrder(MAJOR, "m1", "anna", sea.now_ns, wrong_missions()[name], 2.0)
    answers = sea.command("launch", order=Signed(encode(order)))
    assert not answers["b1"].ok
    assert len(encode(answers["b1"])) < 1500
    assert not sea.holds_mission("b1")


@pytest.mark.parametrize("remaining_s", [math.nan, math.inf, -math.inf, -1e308, 1e308])
@pytest.mark.parametrize("what", [keys.MISSION, keys.FORMATION])
def test_no_time_that_a_neighbour_hands_on_ends_the_boat(tmp_path: Path, what: str, remaining_s: float) -> None:
    sea = Sea(tmp_path, mission(2))
    sea.run(0.5)
    words = sea.mission_words()
    if what == keys.FORMATION:
        sea.launch()
        sea.run(1.0)
        held = sea.agent("b1").orders.sailing
        assert held is not None
        order = FormationOrder(MAJOR, held.order.mission_id, Revision(1, "anna"), Revision(0, ""), 15.0, 1.0)
        words = Signed(encode(order))
    bus = sea.stations["b1"].bus
    assert bus is not None
    bus._answers.append(Answer("b2", what, encode(Held(MAJOR, words, remaining_s))))
    sea.run(0.5)


def test_a_bug_in_taking_a_message_costs_that_message_and_not_the_boat(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    agent = sea.agent("b1")
    obey = agent.orders.obey

    def fails(command: Command, now_ns: int) -> Any:
        if command.text == "bad":
            raise ZeroDivisionError
        return obey(command, now_ns)

    monkeypatch.setattr(agent.orders, "obey", fails)
    sea.ask("hold", boats=("b1",), text="bad")
    answers = sea.command("hold", boats=("b1",))
    assert answers["b1"].ok
    monkeypatch.setattr(agent.picture, "hear", lambda message: 1 / 0)
    sea.run(0.5)
    assert sea.mode("b1") == Mode.HOLD


def test_many_refusals_with_ever_other_words_fill_no_memory(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2), 1.0)
    bus = sea.stations["b1"].bus
    assert bus is not None
    for i in range(300):
        order = FormationOrder(MAJOR, "m", Revision(1, "anna"), Revision(0, ""), 15.0, 1.0 + i, apply_in_s=-1.0)
        bus._answers.append(Answer("b2", keys.FORMATION, encode(Held(MAJOR, Signed(encode(order)), 0.0))))
        sea.tick()
    assert len(sea.agent("b1").desk.refused) <= 64


# -- what takes long -------------------------------------------------------------------------------------------------
def test_missions_read_ahead_are_not_read_again_in_the_loop_however_many_are_done_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sea = Sea(tmp_path, mission(2))
    sea.run(0.5)
    orders = sea.agent("b1").orders
    commands = [Command(MAJOR, f"l{i}", "anna", "launch", (), sea.mission_words(mission_id=f"m{i}")) for i in range(3)]
    for work in [orders.work(command, sea.now_ns) for command in commands]:
        assert work is not None
        work()
    monkeypatch.setattr(orders, "read_mission", lambda words, now_ns: pytest.fail("read in the loop"))
    assert [orders.obey(command, sea.now_ns).ok for command in commands] == [True, True, True]


def test_a_piece_of_background_work_that_fails_ends_nothing_and_too_many_are_turned_away() -> None:
    background, gate, done = Background(threaded=True), threading.Event(), []
    assert background.submit(lambda: 1 / 0 and None, lambda: done.append(0))  # type: ignore[func-returns-value]
    assert background.submit(lambda: gate.wait(10.0) and None, lambda: done.append(1))
    taken = [background.submit(lambda: None, lambda: done.append(2)) for _ in range(MOST + 2)]
    assert [piece is not None for piece in taken] == [True, True, False, False, False, False]
    gate.set()
    while len(done) < 4:
        background.finish()
    assert done == [0, 1, 2, 2]


def test_a_command_that_waits_too_long_is_turned_away_in_time_and_not_obeyed_afterwards(tmp_path: Path) -> None:
    """Its answer would come after the operator has given it up, and the boat would do what nobody expects any more."""
    sea = Sea(tmp_path, mission(1))
    sea.run(0.5)
    agent, gate, done = sea.agent("b1"), threading.Event(), []
    agent.background = Background(threaded=True)
    assert agent.background.submit(lambda: gate.wait(10.0) and None, lambda: done.append("dear"))
    answers = sea.ask("launch", order=sea.mission_words(mission_id="m1"))
    sea.run(PATIENCE_S)
    assert answers == {}  # it may still be begun in time
    sea.run(0.2)
    ack = answers["b1"]
    assert (ack.ok, ack.reason) == (False, "busy with other commands; say it again")
    gate.set()
    agent.background.submit(lambda: None, lambda: done.append("after"))
    while "after" not in done:
        sea.tick()
    assert not sea.holds_mission("b1")
    agent.background = Background(threaded=False)
    assert sea.command("launch", order=sea.mission_words(mission_id="m1"))["b1"].ok


def test_a_command_that_is_begun_in_time_is_answered_when_it_is_done(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(1))
    sea.run(0.5)
    agent, gate, begun = sea.agent("b1"), threading.Event(), threading.Event()
    agent.background = Background(threaded=True)
    read = agent.orders.read_mission

    def slow(words: Signed, now_ns: int) -> Any:
        begun.set()
        gate.wait(10.0)
        return read(words, now_ns)

    agent.orders.read_mission = slow  # type: ignore[method-assign]
    answers = sea.ask("launch", order=sea.mission_words(mission_id="m1"))
    sea.tick()
    assert begun.wait(10.0)
    sea.run(2.0 * PATIENCE_S)
    assert answers == {}
    gate.set()
    while not answers:
        sea.tick()
    assert answers["b1"].ok


def test_a_mission_is_checked_apart_with_the_same_result() -> None:
    assert apart(encode_mission(mission(2))) == ()
    near = mission(2, 3.0)
    assert apart(encode_mission(near)) == check(near).problems[:3] != ()


@pytest.mark.parametrize(
    ("key", "boat"),
    [
        ("fleet/sim/b1/alive", "b1"),
        ("fleet/**", ""),
        ("fleet/sim/**", ""),
        ("fleet/sim/*/alive", ""),
        ("fleet/sim/UPPER/alive", ""),
        ("**", ""),
        ("fleet/sim/a$*/alive", ""),
        ("", ""),
    ],
)
def test_a_key_that_is_nobodys_belongs_to_nobody(key: str, boat: str) -> None:
    assert keys.boat_of(key) == boat
    assert keys.operator_of(key.replace("/b1/", "/operator/b1/")) == boat
