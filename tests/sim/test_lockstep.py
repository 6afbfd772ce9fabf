"""Lock-step: equal bits from run to run, the troubles of the simulator, and the same figures as with real processes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from msgspec.structs import replace

from fleet.agent.modes import Mode, Reason
from fleet.analysis.metrics import Summary, summarise
from fleet.analysis.series import load as load_series
from fleet.mission.load import load, ready
from fleet.mission.model import Event, Mission, Radio
from fleet.mission.plan import build
from fleet.recording.seam import MemoryRecorder
from fleet.sim.lockstep import BEGIN_NS, LockstepRun, Nature, operator, sail_lockstep
from fleet.sim.lockstep import Lockstep as Sim
from fleet.sim.share import Options
from tests.proofs.agreement import beyond, both

COLUMN = str(Path(__file__).with_name("column.toml"))


def column(*timeline: Event, seconds: float = 30.0, **changes: object) -> Mission:
    return replace(load(COLUMN), timeline=timeline, duration_s=seconds, **changes)


def run(
    mission: Mission, folder: Path, *, seed: int = 0, record: bool = True, nature: Nature | None = None
) -> LockstepRun:
    return sail_lockstep(mission, "test", Options(seed=seed, record=record, root=str(folder)), nature=nature)


def launched(mission: Mission, **more: object) -> Sim:
    """A fleet that has been told its mission."""
    sim = Sim(build(mission), **more)  # type: ignore[arg-type]
    with operator(sim) as fleet:
        assert not fleet.wait_for([boat.name for boat in mission.boats if boat.name not in _late(sim)])
        fleet.launch(mission)
        sim.sleep(sim.nature.lead_s)
    return sim


def _late(sim: Sim) -> Sequence[str]:
    return [boat.name for boat in sim.plan.boats if boat.starts_late]


def reasons(sim: Sim, boat: str) -> Reason:
    agent = sim.stations[boat].agent
    assert agent is not None
    return agent.reasons


def test_two_runs_leave_the_same_bytes(tmp_path: Path) -> None:
    mission = column(Event(at_s=5.0, do="set spacing", value=12.0), Event(at_s=8.0, do="kill", boats=("b2",)))
    runs = [run(mission, tmp_path / name) for name in "ab"]
    assert runs[0].digest == runs[1].digest
    for name in ("run.mcap", "boats/b1.mcap", "boats/b2.mcap", "boats/b3.mcap"):
        assert (runs[0].folder / name).read_bytes() == (runs[1].folder / name).read_bytes()


def test_an_operator_two_seconds_away_still_changes_the_formation(tmp_path: Path) -> None:
    mission = column(Event(at_s=5.0, do="set spacing", value=12.0), radio=Radio(delay_s=2.0))
    series = load_series(run(mission, tmp_path).folder)
    changes = [one for one in series.commands if one.command == "set spacing"]
    assert [one.new for one in changes] == ["12 m"]
    assert set(changes[0].acks.values()) == {"acknowledged"}


def test_a_word_of_the_timeline_that_nobody_could_be_told_fails_the_run(tmp_path: Path) -> None:
    cut = [Event(at_s=4.0, do="radio-down", boats=("b1", "b2", "b3"))]
    mission = column(*cut, Event(at_s=8.0, do="set spacing", value=12.0), checks={"collisions": 0.0})
    summary = summarise(run(mission, tmp_path).folder)
    assert [(one.name, one.ok, one.value) for one in summary.checks] == [
        ("unsaid", False, 1.0),
        ("collisions", True, 0.0),
    ]
    assert not summary.passed


def test_a_run_without_a_recording_decides_the_same(tmp_path: Path) -> None:
    mission = column(Event(at_s=5.0, do="set spacing", value=12.0))
    assert run(mission, tmp_path).digest == run(mission, tmp_path, record=False).digest


def test_the_order_in_which_python_keeps_sets_changes_no_bit() -> None:
    script = (
        "from fleet.mission.load import load\nfrom fleet.mission.plan import build\n"
        "from fleet.sim.lockstep import Lockstep, operator\nimport sys\n"
        "m = load('survey-column')\nsim = Lockstep(build(m))\n"
        "with operator(sim) as fleet:\n    fleet.wait_for([b.name for b in m.boats]); fleet.launch(m); sim.sleep(8.0)\n"
        "assert 'zenoh' not in sys.modules\nprint(sim.digest)\n"
    )
    digests = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": number},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for number in ("1", "2")
    }
    assert len(digests) == 1


def test_it_does_not_matter_who_ticks_first() -> None:
    mission = column(radio=Radio(delay_s=0.15, loss=0.2))

    def decisions(backwards: bool) -> dict[str, list[bytes]]:
        recorders = {boat.name: MemoryRecorder() for boat in mission.boats}
        sim = Sim(build(mission), seed=3, recorder_of=recorders.__getitem__)
        if backwards:
            sim.stations = dict(reversed(sim.stations.items()))
        with operator(sim) as fleet:
            fleet.wait_for([boat.name for boat in mission.boats])
            fleet.launch(mission)
            sim.sleep(8.0)
        return {
            name: [m.payload for m in one.messages if m.topic.endswith("/inputs")] for name, one in recorders.items()
        }

    assert decisions(False) == decisions(True)


def test_the_seed_decides_which_messages_are_lost(tmp_path: Path) -> None:
    mission = column(radio=Radio(loss=0.3), seconds=10.0)
    one, two = run(mission, tmp_path, seed=1), run(mission, tmp_path, seed=2)
    assert one.digest != two.digest
    assert one.digest == run(mission, tmp_path, seed=1).digest


def test_a_radio_delays_and_loses_what_is_heard() -> None:
    sim = launched(column(radio=Radio(delay_s=0.5, loss=0.25)))
    sim.sleep(20.0)
    agent = sim.stations["b1"].agent
    assert agent is not None
    b2 = agent.picture.others["b2"]
    assert b2.track is not None
    assert 0.15 < b2.lost / (b2.lost + b2.heard) < 0.35
    age_s, _ = agent.picture.age_s(b2, b2.track, sim.now_ns)
    assert age_s >= 0.5


def test_a_killed_boat_is_silent_at_once_and_goes_on_after_its_restart() -> None:
    sim = launched(column())
    sim.sleep(5.0)
    sim.do("kill", "b2")
    sim.sleep(0.5)
    assert reasons(sim, "b1") & Reason.PEER_SILENT
    sim.sleep(5.0)
    assert sim.world.ships["b2"].state.u < 0.5  # the hull drifts on
    sim.do("start", "b2")
    sim.sleep(sim.nature.startup_s + 3.0)
    assert not reasons(sim, "b1") & Reason.PEER_SILENT
    agent = sim.stations["b2"].agent
    assert agent is not None
    assert agent.decision.mode in (Mode.FOLLOW, Mode.AVOID)


def test_a_frozen_agent_loses_its_link_and_finds_it_again() -> None:
    sim = launched(column())
    sim.do("freeze", "b2")
    sim.sleep(2.0)
    assert reasons(sim, "b1") & Reason.PEER_SILENT
    assert sim.world.ships["b2"].powered == 1.0  # its watchdog, not its agent, has stopped the thrusters
    assert "b2" not in sim.shore.alive()
    sim.do("thaw", "b2")
    sim.sleep(sim.nature.reconnect_s + 1.0)
    assert not reasons(sim, "b1") & Reason.PEER_SILENT
    assert not reasons(sim, "b2") & Reason.LINK_DOWN


def test_a_boat_without_radio_sails_alone() -> None:
    sim = launched(column())
    sim.do("radio-down", "b3")
    sim.sleep(4.0)
    assert reasons(sim, "b3") & Reason.LINK_DOWN
    assert reasons(sim, "b1") & Reason.PEER_SILENT
    sim.do("radio-up", "b3")
    sim.sleep(4.0)
    assert not reasons(sim, "b3") & Reason.LINK_DOWN


def test_sensors_thrusters_and_battery_fail_as_told() -> None:
    sim = launched(column())
    sim.do("gnss-down", "b1")
    sim.do("actuator-down", "b2")
    sim.do("battery", "b3", 3.0)
    sim.sleep(2.0)
    assert reasons(sim, "b1") & Reason.NAVIGATION
    assert reasons(sim, "b2") & Reason.DRIVER
    assert reasons(sim, "b3") & Reason.BATTERY_CRITICAL


def test_hulls_are_free_when_the_mission_begins_though_the_launch_waits_for_a_boat_that_starts_late(
    tmp_path: Path,
) -> None:
    late = Event(at_s=2.0, do="start", boats=("b3",))
    sailed = run(replace(load("late-joiner"), duration_s=3.0, timeline=(late,)), tmp_path)
    series = load_series(sailed.folder)
    track = series.tracks["b1"]
    since_s = track.t + (series.start_ns - sailed.start_ns) * 1e-9
    assert track.x[since_s <= 1.0][-1] > track.x[0] + 0.1


def test_an_operator_hears_who_obeys_who_refuses_and_who_is_silent() -> None:
    sim = launched(column())
    sim.do("freeze", "b3")
    with operator(sim) as fleet:
        held = fleet.hold(["b1", "b3"])
        assert held.acknowledged == ("b1",)
        assert held.silent == ("b3",)
        assert fleet.set_speed(9.0).refused.keys() == {"b1", "b2"}
    assert sim.now_ns > BEGIN_NS


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Summary]:
    """Every ready mission in lock-step."""
    folder = tmp_path_factory.mktemp("lockstep")
    return {name: summarise(run(load(name), folder).folder) for name in ready()}


@pytest.mark.parametrize("name", list(ready()))
def test_every_ready_mission_holds_its_checks(name: str, sailed: dict[str, Summary]) -> None:
    assert sailed[name].passed, sailed[name].checks


@pytest.mark.sails
@pytest.mark.parametrize(("name", "warp"), [("overtaking", 8.0), ("comes-back", 12.0)])
def test_real_processes_and_lockstep_agree_within_the_band(name: str, warp: float, tmp_path: Path) -> None:
    real, mine = both(name, warp, tmp_path)
    assert beyond(name, real, mine) == []
