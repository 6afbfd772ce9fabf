"""`fleet sweep` and `fleet sim --case` as people use them: sail, interrupt, resume, compare, look at one case."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psutil
import pytest

from fleet.cli.main import main
from tests.cli.terminal import FLEET, environment, fleet, running, until
from tests.sim.sweep.brief import BRIEF, GRID

ISSUE = (
    "family", "method", "cases", "collisions", "standstills", "arrived", "inside_radius", "min_separation_m",
    "separation_median_m", "delay_median_s", "delay_p95_s", "failed_seeds", "boat_ticks_per_s", "wall_s",
)  # fmt: skip
SLOW = GRID.replace("duration_s = 20.0", "duration_s = 150.0").replace("meet_s = 9.0", "meet_s = 40.0")
LATER = ("folder", "wall_s", "boat_ticks_per_s")


@pytest.fixture
def family(tmp_path: Path) -> Callable[[str], str]:
    """Writes a family file."""

    def write(text: str) -> str:
        path = tmp_path / "family.toml"
        path.write_text(text)
        return str(path)

    return write


def sailed(*argv: str, cwd: Path) -> tuple[int, dict[str, Any]]:
    """Exit code and JSON."""
    ended = fleet("sweep", *argv, "--json", "--no-picture", "--runs", str(cwd / "runs"))
    return ended.returncode, json.loads(ended.stdout)


def bare(found: dict[str, Any]) -> dict[str, Any]:
    """Without what differs from run to run."""
    return {key: value for key, value in found.items() if key not in LATER}


def test_a_sweep_gives_one_object_and_each_failing_case_alone_gives_the_same_figures(
    tmp_path: Path, family: Callable[[str], str], capsys: pytest.CaptureFixture[str]
) -> None:
    where = family(BRIEF + '[keeping_clear]\nmethod = "circle"\n')
    code, found = sailed(where, "--cases", "12", "--seed", "3", "--jobs", "1", cwd=tmp_path)
    assert set(ISSUE) <= set(found)
    assert (code, found["family"], found["cases"], found["method"]) == (0, "brief", 12, "circle")
    assert found["failed_seeds"]
    least = []
    for name in found["failed_seeds"]:
        assert main(["sim", "--case", f"{found['folder']}:{name}", "--json", "--no-picture", "--record", "none"]) == 1
        alone = json.loads(capsys.readouterr().out)
        assert alone["failed"]
        least.append(alone["min_separation_m"])
    assert min(least) == found["min_separation_m"]


def test_a_sweep_writes_its_page_and_says_which_case_to_look_at(
    tmp_path: Path, family: Callable[[str], str], capsys: pytest.CaptureFixture[str]
) -> None:
    strict = GRID.replace("collisions_max = 5", "min_separation_m = 2.9")
    code = main(["sweep", family(strict), "--method", "circle", "--jobs", "2", "--runs", str(tmp_path / "runs")])
    out, err = capsys.readouterr()
    (folder,) = (tmp_path / "runs").iterdir()
    page = (folder / "report.html").read_text()
    assert code == 1
    assert "FAILED: min_separation_m" in out
    assert out.count("together") == 1
    assert f"fleet sim --case {folder}:7/" not in out
    assert f"fleet sim --case {folder}:1/" in out
    assert "20 of 20 cases" in err
    assert page.count("<svg") >= 3
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")
    assert json.loads((folder / "summary.json").read_text())["points"][3]["label"] == "radius_m 4, loss 0.4"


@pytest.mark.sails
def test_interrupted_it_keeps_what_is_sailed_and_resumes_to_the_same_figures(
    tmp_path: Path, family: Callable[[str], str]
) -> None:
    where = family(SLOW)
    errors = tmp_path / "stderr"
    common = ("--runs", str(tmp_path / "cut"), "--no-picture")
    with running("sweep", where, "--jobs", "1", *common, errors=errors) as sweep:
        until(lambda: list(tmp_path.glob("cut/*/parts/*.npz")) != [], "a part is sailed")
        workers = psutil.Process(sweep.pid).children()
        sweep.send_signal(signal.SIGINT)
        sweep.communicate(timeout=20)
    assert sweep.returncode == 130
    assert not any(worker.is_running() for worker in workers)
    (folder,) = (tmp_path / "cut").iterdir()
    said = errors.read_text()
    assert f"of 4 parts, in {folder}" in said
    assert f"fleet sweep --resume {folder}" in said
    assert "Traceback" not in said
    code, resumed = sailed("--resume", str(folder), cwd=tmp_path)
    _, whole = sailed(where, cwd=tmp_path)
    assert (code, bare(resumed)) == (0, bare(whole))


@pytest.mark.sails
def test_a_worker_killed_on_the_way_changes_nothing(tmp_path: Path, family: Callable[[str], str]) -> None:
    where = family(SLOW)
    common = ("--runs", str(tmp_path / "killed"), "--no-picture", "--json")
    with running("sweep", where, "--jobs", "2", *common) as sweep:
        until(lambda: list(tmp_path.glob("killed/*/parts/*.npz")) != [], "a part is sailed")
        psutil.Process(sweep.pid).children()[0].kill()
        out, _ = sweep.communicate(timeout=60)
    assert sweep.returncode == 0
    _, whole = sailed(where, cwd=tmp_path)
    assert bare(json.loads(out)) == bare(whole)


@pytest.mark.sails
def test_the_sweep_itself_killed_leaves_no_process(tmp_path: Path, family: Callable[[str], str]) -> None:
    long = SLOW.replace("duration_s = 150.0", "duration_s = 9000.0").replace("meet_s = 40.0", "meet_s = 3000.0")
    with running("sweep", family(long), "--jobs", "2", "--runs", str(tmp_path / "runs")) as sweep:
        until(lambda: len(psutil.Process(sweep.pid).children()) == 2, "two workers")
        workers = psutil.Process(sweep.pid).children()
        sweep.kill()
        sweep.wait(10)
    until(lambda: not any(w.is_running() and w.status() != psutil.STATUS_ZOMBIE for w in workers), "they ended", 10.0)


@pytest.mark.sails
def test_a_full_disk_is_said_with_how_to_go_on(tmp_path: Path, family: Callable[[str], str]) -> None:
    ended = subprocess.run(
        [*FLEET, "sweep", family(GRID), "--no-picture", "--runs", str(tmp_path / "runs")],
        capture_output=True,
        text=True,
        timeout=60,
        env=environment(),
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2500, 2500)),  # a part has 4.9 kB
        check=False,
    )
    assert ended.returncode == 1
    assert "error: largest file size reached: " in ended.stderr
    assert "kept: 0 of 4 parts" in ended.stderr
    assert "hint: fleet sweep --resume " in ended.stderr
    assert "Traceback" not in ended.stderr


def test_two_sweeps_are_compared_in_words_and_as_json(
    tmp_path: Path, family: Callable[[str], str], capsys: pytest.CaptureFixture[str]
) -> None:
    where = family(BRIEF)
    _, a = sailed(where, "--jobs", "1", cwd=tmp_path)
    _, b = sailed(where, "--jobs", "1", "--method", "circle", cwd=tmp_path)
    assert main(["sweep", "compare", a["folder"], b["folder"], "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["comparable"], found["together"]["paired"]["cases"]) == (True, 5)
    assert found["points"][0]["b"]["min_separation_m"] == b["min_separation_m"]
    assert main(["sweep", "compare", a["folder"], b["folder"]]) == 0
    out = capsys.readouterr().out
    assert "method circle" in out
    assert "5 cases in both" in out
    assert main(["sweep", "compare", "brief", b["folder"], "--runs", str(tmp_path / "runs")]) == 0


def test_the_ready_families_are_listed_and_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "list", "--runs", str(tmp_path)]) == 0
    listed = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert "two-boat" in listed
    assert main(["sweep", "show", "two-boat"]) == 0
    assert 'title = "Two boats meet from anywhere"' in capsys.readouterr().out


def test_a_case_is_sailed_with_its_trace_and_picture(
    tmp_path: Path, family: Callable[[str], str], capsys: pytest.CaptureFixture[str]
) -> None:
    code = main(["sim", "--case", f"{family(BRIEF)}:7/2", "--runs", str(tmp_path / "runs")])
    out = capsys.readouterr().out
    (folder,) = (tmp_path / "runs").iterdir()
    assert out.splitlines()[0] == "brief:7/2"
    assert "least separation" in out
    assert ("FAILED" in out) == (code == 1)
    assert {one.name for one in folder.iterdir()} >= {"case.json", "trace.npz", "picture.png"}


@pytest.mark.parametrize(
    ("argv", "said"),
    [
        (("sweep", "run"), "expected a FAMILY"),
        (("sweep", "two-boat", "--jobs", "0"), "--jobs 0: expected 1 to 256"),
        (("sweep", "two-boat", "--jobs", "2", "--dask", "local:2"), "expected one of them"),
        (("sweep", "two-boat", "--dask", "here"), "--dask here: expected local:N"),
        (("sweep", "--resume", "last", "--cases", "3"), "expected no --cases with it"),
        (("sweep", "--resume", "nothing"), "nothing: no sweep"),
        (("sweep", "no-such-family"), "no-such-family"),
        (("sweep", "swap", "--cases", "0"), "swap: cases = 0 (--cases): expected a whole number from 1 to 1000000"),
        (("sweep", "swap", "--cases", "-3"), "swap: cases = -3 (--cases): expected a whole number from 1 to 1000000"),
        (("sweep", "swap", "--cases", "many"), "Invalid value for '--cases': 'many': expected a whole number"),
        (("sweep", "swap", "--set", "cases=0"), "swap: cases = 0 (--set): expected a whole number from 1 to 1000000"),
        (("sweep", "swap", "--boats", "0"), "swap: boats = 0 (--boats): expected a whole number from 1 to 100"),
        (("sweep", "swap", "--boats", "1.5"), "Invalid value for '--boats': '1.5': expected a whole number"),
        (("sweep", "swap", "--seed", "-1"), "swap: seed = -1 (--seed): expected a whole number from 0 to 1000000000"),
        (("sweep", "swap", "--seed", "9" * 20), "(--seed): expected a whole number from 0 to 1000000000"),
        (("sweep", "swap", "--method", "magic"), 'keeping_clear.method = "magic" (--method): no such method'),
        (("sweep", "methods", "swap", "--cases", "0"), "--cases 0: expected 1 to 1000000"),
        (("sweep", "methods", "swap", "--cases", "-3"), "--cases -3: expected 1 to 1000000"),
        (("sweep", "methods", "swap", "--cases", "many"), "'--cases': 'many': expected a whole number"),
        (("sweep", "methods", "swap", "--seed", "-1"), "--seed -1: expected 0 to 1000000000"),
        (("sweep", "methods", "swap", "--set", "boats=0"), "swap: boats = 0 (--set): expected a whole number from 1"),
        (("sim", "--case", "swap:1/0", "--boats", "0"), "swap: boats = 0 (--boats): expected a whole number from 1"),
        (("sim", "--case", "swap:1/0", "--method", "magic"), '"magic" (--method): no such method'),
        (("sim", "--case", "swap:-1/0"), 'case "-1/0": expected SEED/CASE, whole numbers'),
        (("sim", "--case", "swap:1/-3"), 'case "1/-3": expected SEED/CASE, whole numbers'),
        (("sweep", "compare", "one", "other"), "one: no sweep"),
        (("sim",), "expected a MISSION"),
        (("sim", "overtaking", "--case", "two-boat:1/2"), "expected no MISSION with it"),
        (("sim", "--case", "two-boat"), "expected FAMILY:SEED/CASE"),
        (("sim", "--case", "two-boat:1/2/3"), "expected SEED/CASE"),
        (("sim", "--case", "two-boat:1/x"), "expected SEED/CASE"),
    ],
)
def test_wrong_use_is_exit_code_2_in_a_line_and_leaves_no_folder(
    tmp_path: Path,
    argv: tuple[str, ...],
    said: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("FLEET_RUNS", str(tmp_path / "runs"))
    code = main(argv)
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert said in err
    assert "bug" not in err
    assert not os.path.exists(tmp_path / "runs")
