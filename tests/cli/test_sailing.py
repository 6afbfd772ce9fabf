"""`fleet sim` with real processes: one object on stdout, a run folder, and nothing left behind, whatever happens."""

from __future__ import annotations

import json
import signal
from pathlib import Path

import psutil
import pytest

from fleet.recording.reader import RecordingFile
from tests.cli.terminal import fleet, running, until

pytestmark = pytest.mark.sails
SHORT = ("--warp", "20", "--set", "duration_s=40", "--set", "timeline=[]")


def test_a_short_sail_gives_one_object_and_a_run_folder(tmp_path: Path) -> None:
    ended = fleet("sim", "overtaking", *SHORT, "--json", "--runs", str(tmp_path))
    summary = json.loads(ended.stdout)
    assert ended.returncode == 0, ended.stderr
    assert summary["passed"] is True
    assert summary["boats"] == ["b1", "b2"]
    assert summary["collisions"] == 0
    assert {"ticks_late", "messages_lost", "wall_s", "simulated_s", "formation_error_m"} <= set(summary)
    run = Path(summary["run"])
    assert {"run.mcap", "mission.toml", "summary.json", "picture.png", "report.html"} <= {p.name for p in run.iterdir()}
    assert "launch" in ended.stderr
    assert "acknowledged" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_a_check_that_does_not_hold_is_exit_code_1_and_said(tmp_path: Path) -> None:
    too_short = ("--warp", "20", "--set", "duration_s=30", "--set", "checks={formation_error_m=0.1,finished=1}")
    ended = fleet("sim", "overtaking", *too_short, "--no-picture", "--runs", str(tmp_path))
    lines = ended.stdout.splitlines()
    assert ended.returncode == 1
    assert any(line.startswith("  min_separation_m") and line.endswith(" m") for line in lines)
    assert any(line.split()[0] == "finished" and line.endswith("ok") for line in lines if line.strip())
    (failed,) = [line for line in lines if line.endswith("NOT OK")]
    assert failed.split()[0] == "formation_error_m"
    assert "FAILED: formation_error_m" in lines


def test_without_a_recording_nothing_is_judged(tmp_path: Path) -> None:
    short = ("--warp", "50", "--set", "duration_s=10", "--set", "timeline=[]")
    ended = fleet("sim", "overtaking", *short, "--record", "none", "--json", "--runs", str(tmp_path))
    summary = json.loads(ended.stdout)
    assert ended.returncode == 1
    assert summary["passed"] is False
    assert summary["min_separation_m"] is None
    assert "not recorded" in ended.stderr


def left(children: list[psutil.Process]) -> list[psutil.Process]:
    """Those that still run."""
    return [child for child in children if child.is_running() and child.status() != psutil.STATUS_ZOMBIE]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_on_the_way_it_ends_everything_and_leaves_a_readable_run(tmp_path: Path, number: int) -> None:
    errors = tmp_path / "stderr"
    with running("sim", "overtaking", "--warp", "10", "--json", "--runs", str(tmp_path), errors=errors) as sim:
        until(lambda: "b1 follow" in errors.read_text(), "the boats follow")
        children = psutil.Process(sim.pid).children(recursive=True)
        assert len(children) == 4  # hub, world, two agents
        sim.send_signal(number)
        sim.send_signal(number)  # an impatient operator changes nothing
        out, _ = sim.communicate(timeout=20)
    assert (sim.returncode, out) == (130, "")
    assert not left(children)
    said = errors.read_text()
    assert "interrupted; what was sailed: " in said
    assert "Traceback" not in said
    (run,) = [path for path in tmp_path.iterdir() if path.is_dir()]
    for name in ("run.mcap", "boats/b1.mcap", "boats/b2.mcap"):
        with RecordingFile(run / name) as recording:
            assert recording.whole
            assert recording.message_count > 0
    shown = fleet("run", "show", str(run), "--json")
    assert json.loads(shown.stdout)["boats"] == ["b1", "b2"], shown.stderr


def test_killed_outright_it_leaves_no_process(tmp_path: Path) -> None:
    errors = tmp_path / "stderr"
    with running("sim", "overtaking", "--warp", "5", "--runs", str(tmp_path), errors=errors) as sim:
        until(lambda: "acknowledged" in errors.read_text(), "the boats have their mission")
        children = psutil.Process(sim.pid).children(recursive=True)
        sim.kill()
        sim.wait(10)
    until(lambda: not left(children), "every process of the simulation has ended", 10.0)


def test_kept_it_can_be_commanded_from_another_terminal(tmp_path: Path) -> None:
    errors = tmp_path / "stderr"
    short = ("--warp", "10", "--set", "duration_s=5", "--set", "timeline=[]", "--no-picture", "--keep", "--json")
    with running("sim", "overtaking", *short, "--runs", str(tmp_path), errors=errors) as sim:
        until(lambda: "sailing on; Ctrl-C ends it" in errors.read_text(), "the simulation sails on")
        (line,) = [one for one in errors.read_text().splitlines() if "export " in one]
        variables = dict(word.split("=", 1) for word in line.split("export ")[1].split())
        assert fleet("take", FLEET_OPERATOR="anna", **variables).returncode == 0
        ended = fleet("set", "spacing", "15", "--yes", FLEET_OPERATOR="anna", **variables)
        assert (ended.returncode, ended.stdout.splitlines()[0]) == (0, "set spacing: 20 m -> 15 m")
        sim.send_signal(signal.SIGINT)
        out, _ = sim.communicate(timeout=20)
    assert sim.returncode == 130
    assert json.loads(out)["boats"] == ["b1", "b2"]
