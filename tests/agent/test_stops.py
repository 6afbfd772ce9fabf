"""Stops are a set that nothing but a release shortens (DESIGN section 4, Stops)."""

from __future__ import annotations

from pathlib import Path

import msgspec

from fleet.agent.modes import Goal, Mode, Reason
from fleet.agent.store import Store
from tests.agent.harness import Sea, mission, sailing


def on_disk(sea: Sea, boat: str) -> tuple[str, ...]:
    return Store(sea.stations[boat].folder, threaded=False).stops()


def test_a_stop_takes_the_thrust_away_in_the_tick_that_hears_it(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    acks = sea.command("stop-now", command_id="s1")
    assert all(ack.ok and ack.new == "s1" for ack in acks.values())
    assert sea.modes() == [Mode.NEUTRAL] * 3
    assert not any(sea.powered(boat) for boat in sea.agents())
    assert Reason.STOPPED in sea.reasons("b1")


def test_a_stop_is_on_disk_before_it_is_acknowledged(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    seen: list[tuple[str, ...]] = []
    answers = sea.ask("stop-now", command_id="s1")
    for boat, bus in sea.water.boats.items():
        for k, request in enumerate(bus._requests):

            def reply(answer: bytes, boat: str = boat, old=request.reply) -> None:
                seen.append(on_disk(sea, boat))
                old(answer)

            bus._requests[k] = request._replace(reply=reply)
    sea.tick()
    assert len(answers) == 2
    assert seen == [("s1",), ("s1",)]


def test_a_stop_that_cannot_be_written_is_obeyed_but_not_acknowledged(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    store = sea.agent("b2").store
    folder, store._folder = store._folder, tmp_path / "gone"
    acks = sea.command("stop-now", command_id="s1")
    sea.run(2.0)
    assert set(acks) == {"b1"}
    assert sea.mode("b2") == Mode.NEUTRAL
    assert Reason.STORE in sea.reasons("b2")
    store._folder = folder
    acks = sea.command("stop-now", command_id="s1")
    assert acks["b2"].ok, "asked again, with a disk"
    assert on_disk(sea, "b2") == ("s1",)


def test_a_stop_is_repeated_in_every_state(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    sea.command("stop-now", command_id="s1")
    for _ in range(5):
        assert sea.state("b1").stops == ("s1",)
        sea.tick()


def test_a_stop_holds_across_restarts_and_another_boot(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    sea.command("stop-now", command_id="s1", boats=("b2",))
    sea.restart("b2")
    sea.run(3.0)
    assert sea.mode("b2") == Mode.NEUTRAL
    sea.restart("b2", boot_id="boot-2", after_s=100.0)
    sea.run(3.0)
    assert sea.mode("b2") == Mode.NEUTRAL
    assert sea.state("b2").stops == ("s1",)
    assert not sea.powered("b2")


def test_a_stop_holds_while_nobody_can_be_heard(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    sea.command("stop-now", boats=("b2",))
    sea.cut("b2")
    sea.run(60.0)
    assert sea.mode("b2") == Mode.NEUTRAL


def test_two_stops_are_two_and_both_must_be_released(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    sea.command("stop-now", command_id="s1")
    sea.command("stop-now", command_id="s2", operator="bob")
    acks = sea.command("release", names=("s1",))
    assert all(ack.ok and ack.new == "s2" for ack in acks.values())
    sea.run(1.0)
    assert sea.modes() == [Mode.NEUTRAL] * 2
    sea.command("release", names=("s2",))
    sea.run(0.2)
    assert Mode.NEUTRAL not in sea.modes()
    assert on_disk(sea, "b1") == ()


def test_a_released_boat_holds_until_it_is_resumed(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 5.0)
    sea.command("stop-now", command_id="s1")
    sea.run(5.0)
    sea.command("release", names=("s1",))
    sea.run(5.0)
    assert sea.modes() == [Mode.HOLD] * 2
    sea.command("resume")
    sea.run(1.0)
    assert set(sea.modes()) <= {Mode.FOLLOW, Mode.AVOID}


def test_a_release_is_on_disk_before_it_is_acknowledged(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    sea.command("stop-now", command_id="s1")
    store = sea.agent("b2").store
    store._folder = tmp_path / "gone"
    assert set(sea.command("release", names=("s1",))) == {"b1"}


def test_a_release_of_what_was_never_stopped_says_so(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    acks = sea.command("release", names=("s9",))
    assert {ack.reason for ack in acks.values()} == {"did not know s9"}


def test_while_stopped_nothing_starts_the_boat(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    sea.command("stop-now", command_id="s1")
    for kind in ("resume", "return"):
        assert {ack.reason for ack in sea.command(kind).values()} == {"stopped by s1; release first"}
    assert {ack.reason for ack in sea.launch().values()} == {"stopped by s1; release first"}
    sea.command("hold")
    sea.change(spacing_m=15.0)
    sea.run(5.0)
    assert sea.modes() == [Mode.NEUTRAL] * 2


def test_a_stopped_boat_takes_no_mission_from_its_neighbours(tmp_path: Path) -> None:
    sea = Sea(tmp_path, ashore=("b3",))
    sea.run(0.5)
    sea.launch()
    sea.run(3.0)
    sea.stations["b3"].switch_on()
    sea.command("stop-now", boats=("b3",))
    sea.run(5.0)
    assert not sea.holds_mission("b3")


def test_a_stop_for_one_boat_stops_one_boat(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.command("stop-now", boats=("b3",))
    sea.run(2.0)
    assert sea.modes()[:2] != [Mode.NEUTRAL] * 2
    assert sea.mode("b3") == Mode.NEUTRAL
    assert sea.members("b1") == 1


def test_a_stop_of_the_whole_fleet_reaches_who_was_out_of_reach_from_its_neighbours(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.cut("b3")
    sea.run(1.0)
    sea.command("stop-now", command_id="all-s1")
    sea.run(1.0)
    assert sea.mode("b3") != Mode.NEUTRAL
    sea.mend("b3")
    sea.run(0.3)
    assert sea.mode("b3") == Mode.NEUTRAL
    assert on_disk(sea, "b3") == ("all-s1",)


def test_a_stop_that_was_released_is_not_caught_again_from_a_boat_that_missed_the_release(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.command("stop-now", command_id="all-s1")
    sea.cut("b3")
    sea.run(1.0)
    sea.command("release", names=("all-s1",))
    sea.mend("b3")
    sea.run(2.0)
    assert sea.modes() == [Mode.HOLD, Mode.HOLD, Mode.NEUTRAL]
    sea.command("release", names=("all-s1",))
    sea.run(1.0)
    assert sea.modes() == [Mode.HOLD] * 3


def test_a_stop_of_one_boat_is_not_caught_by_its_neighbours(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.command("stop-now", command_id="s1", boats=("b3",))
    sea.run(3.0)
    assert Mode.NEUTRAL not in sea.modes()[:2]


def test_a_file_of_stops_that_cannot_be_read_is_a_stop(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 1.0)
    sea.kill("b2")
    (sea.stations["b2"].folder / "stops").write_bytes(b"\xc1 rubbish")
    sea.restart("b2")
    sea.run(2.0)
    assert sea.mode("b2") == Mode.NEUTRAL
    assert sea.state("b2").stops == ("unreadable-stops-file",)
    sea.command("release", names=("unreadable-stops-file",))
    sea.run(0.5)
    assert sea.agent("b2").orders.goal == Goal.STANDBY


def test_the_threaded_store_acknowledges_after_the_disk(tmp_path: Path) -> None:
    store = Store(tmp_path / "s")
    seen: list[bytes] = []
    store.save_stops(("s1",), lambda: seen.append((tmp_path / "s" / "stops").read_bytes()))
    store.close()
    assert seen == [msgspec.msgpack.encode(("s1",))]
