"""kill -9 each process of a running mission in turn: the others do what the trouble table says."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from fleet.sim.sail import Progress, Sailing
from tests.sim.sailed import Sailed, sail

pytestmark = pytest.mark.sails
COLUMN = str(Path(__file__).with_name("column.toml"))
SILENT = "a boat of the formation is silent"


def kill(name: str) -> object:
    return lambda sailing, _: sailing.processes.signal(name, signal.SIGKILL)


def least_speed(run: Sailed, boat: str, since_s: float, until_s: float) -> float:
    times = [run.t(truth.stamp_ns) for truth in run.truths[boat]]
    return min(run.speed(boat, t) for t in times if since_s <= t <= until_s)


def test_a_killed_agent_leaves_the_sums_and_its_hull_is_passed(tmp_path: Path) -> None:
    run = sail(COLUMN, tmp_path, "duration_s=70", at={15.0: kill("b1")})
    assert run.summary.collisions == 0
    assert run.summary.min_separation_m is not None
    assert run.summary.min_separation_m > 4.0
    assert SILENT in run.reasons("b2", 16.0, 18.0)
    north = {boat: truths[-1].x_m for boat, truths in run.truths.items()}
    assert north["b2"] > north["b1"] + 10.0  # past the drifting hull
    assert abs((north["b2"] - north["b3"]) - 20.0) < 3.0  # and in formation with each other


def test_a_killed_agent_is_back_in_formation_within_five_seconds_of_its_restart(tmp_path: Path) -> None:
    restarted: list[float] = []

    def start(sailing: Sailing, progress: Progress) -> None:
        restarted.append(progress.t_s)
        sailing.processes.start_agent("b2")

    run = sail(COLUMN, tmp_path, "duration_s=24", at={8.0: kill("b2"), 10.0: start}, warp=2.0)
    resumed = run.happened("resumed", "b2")
    assert len(resumed) == 1
    back = min(run.t(s.stamp_ns) for s in run.states["b2"] if s.mode == "follow" and run.t(s.stamp_ns) > restarted[0])
    assert back - restarted[0] < 5.0
    assert {s.mission_id for s in run.states["b2"][-5:]} == {s.mission_id for s in run.states["b1"][-5:]}
    assert not run.reasons("b1", back + 2.0, 24.0)
    assert run.summary.collisions == 0


def test_without_the_hub_every_boat_goes_on_alone_and_joins_again_when_it_is_back(tmp_path: Path) -> None:
    def restart(sailing: Sailing, progress: Progress) -> None:
        sailing.processes.start_hub()

    run = sail(COLUMN, tmp_path, "duration_s=80", at={15.0: kill("hub"), 25.0: restart})
    for boat in ("b1", "b2", "b3"):
        assert "alone" in run.own_modes(boat, 16.0, 24.0)
        assert run.own_modes(boat, 45.0, 60.0) <= {"follow", "avoid"}  # no longer alone
        assert run.own_modes(boat, 70.0, 80.0) == {"follow"}
        assert least_speed(run, boat, 16.0, 24.0) > 0.7  # at cruise, not stopped
    assert run.summary.collisions == 0
    assert run.summary.formation_error_m is not None
    assert run.summary.formation_error_m < 0.5


def test_without_the_hub_for_long_every_boat_holds(tmp_path: Path) -> None:
    run = sail(COLUMN, tmp_path, "duration_s=45", "lost.alone_for_s=10", at={15.0: kill("hub")})
    for boat in ("b1", "b2", "b3"):
        assert run.own_modes(boat, 30.0, 45.0) == {"hold"}
    assert run.summary.collisions == 0


def test_without_the_world_every_boat_knows_that_it_knows_nothing(tmp_path: Path) -> None:
    run = sail(COLUMN, tmp_path, "duration_s=20", at={10.0: kill("world")})
    for boat in ("b1", "b2", "b3"):
        events = [e.text for e in run.own[boat] if e.kind == "mode" and run.t(e.stamp_ns) > 10.0]
        assert any("fault" in text and "navigation" in text for text in events), events


def test_a_frozen_agent_is_out_of_the_sums_within_a_second_and_still_avoided(tmp_path: Path) -> None:
    def freeze(sailing: Sailing, progress: Progress) -> None:
        sailing.processes.signal("b1", signal.SIGSTOP)

    def thaw(sailing: Sailing, progress: Progress) -> None:
        sailing.processes.signal("b1", signal.SIGCONT)

    run = sail(COLUMN, tmp_path, "duration_s=90", at={15.0: freeze, 50.0: thaw})
    silent = min(run.t(s.stamp_ns) for s in run.states["b2"] if SILENT in s.reasons and run.t(s.stamp_ns) > 14.0)
    last = max(run.t(s.stamp_ns) for s in run.states["b1"] if run.t(s.stamp_ns) < 30.0)
    assert silent - last < 1.0
    assert run.summary.collisions == 0
    assert run.summary.min_separation_m is not None
    assert run.summary.min_separation_m > 4.0
    assert "follow" in run.modes("b1", 55.0, 90.0)  # back without being told


def test_an_operator_killed_in_the_middle_of_a_change_leaves_one_formation(tmp_path: Path) -> None:
    children: list[subprocess.Popen[bytes]] = []

    def change(sailing: Sailing, progress: Progress) -> None:
        script = (
            "import sys\nfrom fleet.operator import Fleet\n"
            "with Fleet('sim', connect=sys.argv[1:], operator='sim-operator') as f:\n"
            "    f.set_spacing(15.0)\n    print('said', flush=True)\n    f.set_spacing(25.0)\n"
        )
        child = subprocess.Popen(
            [sys.executable, "-c", script, *sailing.processes.connect],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        children.append(child)

    def end(sailing: Sailing, progress: Progress) -> None:
        children[0].kill()
        children[0].wait()

    run = sail(COLUMN, tmp_path, "duration_s=60", at={8.0: change, 16.0: end})
    last = {boat: (states[-1].spacing_m, states[-1].revision) for boat, states in run.states.items()}
    assert len(set(last.values())) == 1, last
    assert run.summary.formation_error_m is not None
    assert run.summary.formation_error_m < 1.0
    assert run.summary.collisions == 0


def test_a_stop_outlives_a_restart_and_only_its_release_ends_it(tmp_path: Path) -> None:
    def stop(sailing: Sailing, progress: Progress) -> None:
        assert progress.fleet.stop_now(["b3"]).ok

    def release(sailing: Sailing, progress: Progress) -> None:
        assert progress.fleet.release(["b3"]).ok
        assert progress.fleet.resume(["b3"], at="nearest").ok

    run = sail(
        COLUMN,
        tmp_path,
        "duration_s=70",
        at={
            8.0: stop,
            12.0: kill("b3"),
            14.0: lambda sailing, _: sailing.processes.start_agent("b3"),
            40.0: release,
        },
        warp=6.0,
    )
    assert run.modes("b3", 30.0, 39.0) <= {"neutral", "standby"}
    assert "stopped by an operator, not released" in run.reasons("b3", 30.0, 39.0)
    assert least_speed(run, "b3", 20.0, 39.0) < 0.1
    assert "follow" in run.modes("b3", 45.0, 70.0)


def test_a_killed_supervisor_leaves_nobody_behind(tmp_path: Path) -> None:
    script = (
        "import sys\nfrom fleet.mission.load import load\nfrom fleet.sim.sail import Options, Sailing\n"
        "said = []\n"
        "def watch(p):\n"
        "    if not said and p.t_s > 1.0:\n"
        "        said.append(1); print(*sailing.processes.pids, flush=True)\n"
        "sailing = Sailing(load('overtaking'), 'test', Options(warp=5.0, root=sys.argv[1]), watch)\nsailing.sail()\n"
    )
    child = subprocess.Popen([sys.executable, "-c", script, str(tmp_path)], stdout=subprocess.PIPE)
    assert child.stdout is not None
    pids = [int(word) for word in child.stdout.readline().split()]
    assert len(pids) == 4
    child.kill()
    child.wait()
    child.stdout.close()
    deadline = time.monotonic() + 10.0
    while any(Path(f"/proc/{pid}").exists() for pid in pids):
        assert time.monotonic() < deadline, "somebody is still there"
        time.sleep(0.05)
