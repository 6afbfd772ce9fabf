"""Replay: what was decided is decided again, bit for bit; and where not, it is said."""

from __future__ import annotations

import random
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from fleet.agent.report import Laid
from fleet.analysis.replay import replay
from fleet.analysis.replayed import Difference
from fleet.errors import RecordingError
from fleet.mission.load import load
from fleet.mission.model import Event
from fleet.recording.reader import read
from fleet.recording.seam import Message
from fleet.recording.writer import Recorder
from fleet.sim.lockstep import sail_lockstep
from fleet.sim.share import Options
from tests.sim.sailed import sail


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short run in lock-step in which much happens."""
    mission = replace(
        load("comes-back"),
        duration_s=40.0,
        timeline=(
            Event(at_s=3.0, do="kill", boats=("b2",)),
            Event(at_s=15.0, do="start", boats=("b2",)),
            Event(at_s=22.0, do="hold", boats=("b1",)),
            Event(at_s=28.0, do="return", boats=("b3",)),
            Event(at_s=32.0, do="abort", boats=("b2",)),
        ),
    )
    root = tmp_path_factory.mktemp("replay")
    return sail_lockstep(mission, "replay", Options(root=str(root))).folder


def rewrite(source: Path, target: Path, change: object = None, drop: range = range(0)) -> Path:
    """The recording again, with every message passed through `change`; messages of places in `drop` are left out."""
    recorder = Recorder(target, {"version": "0"}, wait=True)
    for place, message in enumerate(read(source)):
        recorder.channel(message.topic, "", message.encoding)
        if place not in drop:
            recorder.put(message.topic, message.stamp_ns, change(message) if callable(change) else message.payload)
    recorder.close()
    return target


def test_a_run_in_lockstep_replays_alike_with_restart_hold_return_and_abort(run_folder: Path) -> None:
    found = replay(run_folder)
    assert found.exit_code == 0
    assert found.same
    assert found.differences == []
    by_name = {boat.boat: boat for boat in found.boats}
    assert by_name["b2"].starts == 2
    assert all(boat.replayed == boat.ticks and not boat.skipped and not boat.missing for boat in found.boats)


def test_what_the_shell_changed_is_told_apart(run_folder: Path) -> None:
    found = replay(run_folder)
    assert {change.why for change in found.changes} == {"path laid"}
    b3 = [change for change in found.changes if change.boat == "b3"]
    assert "s" in b3[-1].fields  # it begins at 0 of the way back


def test_one_boats_recording_is_enough(run_folder: Path) -> None:
    found = replay(run_folder / "boats" / "b3.mcap")
    assert [boat.boat for boat in found.boats] == ["b3"]
    assert found.same


def test_a_decision_that_differs_is_named_by_boat_tick_field_and_both_values(run_folder: Path, tmp_path: Path) -> None:
    ticks = iter(range(1, 100_000))

    def change(message: Message) -> bytes:
        if not message.topic.endswith("/decision") or next(ticks) != 200:
            return message.payload
        decision = msgspec.msgpack.decode(message.payload)
        return msgspec.msgpack.encode({**decision, "u_d": decision["u_d"] + 1e-15})

    found = replay(rewrite(run_folder / "boats" / "b1.mcap", tmp_path / "b1.mcap", change))
    assert found.exit_code == 1
    (one,) = found.differences
    assert isinstance(one, Difference)
    assert (one.boat, one.tick, one.field) == ("b1", 200, "u_d")
    assert 0.0 < one.size < 1e-14
    assert any("u_d: first at tick 200" in line for line in found.lines())


def test_a_state_that_did_not_follow_from_the_tick_before_is_a_difference(run_folder: Path, tmp_path: Path) -> None:
    ticks = iter(range(1, 100_000))

    def change(message: Message) -> bytes:
        if not message.topic.endswith("/inputs") or next(ticks) != 100:
            return message.payload
        tick, dt, state, *rest = msgspec.msgpack.decode(message.payload)
        return msgspec.msgpack.encode((tick, dt, {**state, "s": state["s"] + 1e-9}, *rest))

    found = replay(rewrite(run_folder / "boats" / "b1.mcap", tmp_path / "b1.mcap", change))
    assert ("b1", 99, "next.s") in {(one.boat, one.tick, one.field) for one in found.differences}


def test_a_recording_of_another_version_says_so_and_is_replayed(run_folder: Path, tmp_path: Path) -> None:
    def change(message: Message) -> bytes:
        if not message.topic.endswith("/laid"):
            return message.payload
        return msgspec.msgpack.encode(replace(msgspec.msgpack.decode(message.payload, type=Laid), version="0.0.1"))

    found = replay(rewrite(run_folder / "boats" / "b1.mcap", tmp_path / "b1.mcap", change))
    assert found.same
    assert any("0.0.1" in note for note in found.notes)


def test_a_gap_is_counted_and_the_rest_is_replayed(run_folder: Path, tmp_path: Path) -> None:
    found = replay(rewrite(run_folder / "boats" / "b1.mcap", tmp_path / "b1.mcap", drop=range(300, 340)))
    assert found.same
    assert found.boats[0].missing > 5


def test_a_recording_that_begins_later_waits_until_it_knows_the_path(run_folder: Path, tmp_path: Path) -> None:
    found = replay(rewrite(run_folder / "boats" / "b1.mcap", tmp_path / "b1.mcap", drop=range(100)))
    (boat,) = found.boats
    assert found.same
    assert boat.skipped == {"the path is not known: the recording begins later": sum(boat.skipped.values())}
    assert boat.replayed > 100  # from the hold on, where a path is laid


def test_a_damaged_recording_is_replayed_as_far_as_it_goes(run_folder: Path, tmp_path: Path) -> None:
    whole = (run_folder / "boats" / "b3.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) * 3 // 4])
    found = replay(cut)
    assert found.same
    assert any("not closed" in note for note in found.notes)
    draw = random.Random(1)
    broken = tmp_path / "broken.mcap"
    for _ in range(20):
        content = bytearray(whole)
        for _ in range(3):
            content[draw.randrange(2000, len(content))] = draw.randrange(256)
        broken.write_bytes(content)
        try:
            replay(broken)  # whatever is left; it must not break
        except RecordingError:
            continue


def test_nothing_to_replay_is_said(tmp_path: Path, run_folder: Path) -> None:
    with pytest.raises(RecordingError, match="no boat recorded itself"):
        replay(tmp_path)
    with pytest.raises(RecordingError, match="no inputs of a boat"):
        replay(run_folder / "run.mcap")
    with pytest.raises(RecordingError, match=r"missing\.mcap: no such file"):
        replay(tmp_path / "missing.mcap")


@pytest.mark.sails
def test_a_run_of_real_agents_replays_alike(tmp_path: Path) -> None:
    sailed = sail("overtaking", tmp_path, "duration_s=40", "timeline=[]", warp=8.0)
    found = replay(sailed.folder)
    assert found.same, found.lines()
    assert found.ticks > 500
