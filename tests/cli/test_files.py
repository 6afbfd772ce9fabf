"""Missions, runs and configurations: the commands that read files."""

from __future__ import annotations

import json
import os
import shutil
import socket
from pathlib import Path

import pytest

from fleet.cli.main import main
from fleet.mission.load import ready
from tests.analysis.sailed import sail

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("runs")
    sail(root / "20261122T120000Z-overtaking")
    return root


def json_of(capfd: Capture) -> object:
    return json.loads(capfd.readouterr().out)


def test_the_ready_missions_are_listed_and_all_of_them_are_right(capfd: Capture) -> None:
    assert main(["mission", "list", "--json"]) == 0
    listed = json_of(capfd)
    assert {one["name"]: one["title"] for one in listed} == ready()
    for name in ready():
        assert main(["mission", "check", name]) == 0
        assert capfd.readouterr().out.startswith(f"{name}: ok: ")


def test_check_says_every_problem(capfd: Capture) -> None:
    wrong = ["--set", "formation.spacing_m=3", "--set", "formation.cruise_mps=9"]
    assert main(["mission", "check", "overtaking", *wrong]) == 2
    said = capfd.readouterr()
    assert "formation.spacing_m = 3 (--set)" in said.err
    assert "formation.cruise_mps = 9 (--set)" in said.err
    assert all(line.startswith("error: overtaking: ") for line in said.err.splitlines())
    assert main(["mission", "check", "overtaking", *wrong, "--json"]) == 2
    answer = json_of(capfd)
    assert answer["ok"] is False
    assert len(answer["problems"]) >= 2


def test_show_prints_the_file_describes_it_and_draws_it(tmp_path: Path, capfd: Capture) -> None:
    assert main(["mission", "show", "overtaking", "--text"]) == 0
    copy = tmp_path / "copy.toml"
    copy.write_text(capfd.readouterr().out)
    assert main(["mission", "show", str(copy), "--out", str(tmp_path / "copy.png")]) == 0
    assert "set spacing" in capfd.readouterr().out
    assert (tmp_path / "copy.png").read_bytes().startswith(b"\x89PNG")


def test_runs_are_listed_shown_and_reported(runs: Path, capfd: Capture) -> None:
    where = ["--runs", str(runs)]
    assert main(["run", "show", *where, "--json"]) == 0
    summary = json_of(capfd)
    assert summary["boats"] == ["blue", "red"] or summary["boats"] == ["red", "blue"]
    assert main(["run", "show", "overtaking", *where]) == 0
    text = capfd.readouterr().out
    for name in ("min_separation_m", "reformed_s", "collisions", "wall_s"):
        assert name in text
    assert main(["run", "report", "--paper", *where]) == 0
    capfd.readouterr()
    folder = runs / "20261122T120000Z-overtaking"
    assert {"summary.json", "picture.png", "paper.png", "report.html"} <= {path.name for path in folder.iterdir()}
    assert main(["run", "list", *where, "--json"]) == 0
    rows = json_of(capfd)
    assert [(row["run"], row["passed"]) for row in rows] == [(folder.name, summary["passed"])]


def test_a_torn_recording_is_repaired_beside_itself(runs: Path, tmp_path: Path, capfd: Capture) -> None:
    folder = tmp_path / "20261122T120000Z-overtaking"
    shutil.copytree(runs / folder.name, folder)
    torn = folder / "run.mcap"
    os.truncate(torn, torn.stat().st_size // 2)
    before = torn.read_bytes()
    assert main(["run", "repair", str(folder), "--json"]) == 0
    (row,) = json_of(capfd)["recordings"]
    assert row["state"] == "repaired"
    assert row["messages"] > 0
    assert torn.read_bytes() == before
    assert Path(row["repaired"]) == folder / "repaired" / "run.mcap"
    assert main(["run", "repair", str(folder)]) == 0
    assert "repaired before" in capfd.readouterr().out
    assert main(["run", "repair", str(folder / "repaired" / "run.mcap"), "--json"]) == 0
    assert json_of(capfd)["recordings"][0]["state"] == "whole"


def test_an_agents_configuration_says_where_each_value_came_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Capture
) -> None:
    file = tmp_path / "b1.toml"
    file.write_text('boat = "b1"\nfleet = "harbour"\ncontrol_hz = 20.0\n')
    monkeypatch.setenv("FLEET_FLEET", "genoa")
    monkeypatch.setenv("FLEET_CONNECT", "tcp/127.0.0.1:7447,tcp/127.0.0.1:7448")
    line = ["agent", "--config", str(file), "--control-hz", "5", "--check"]
    assert main([*line, "--json"]) == 0
    values = json_of(capfd)
    assert values["boat"] == {"value": "b1", "from": str(file)}
    assert values["fleet"] == {"value": "genoa", "from": "FLEET_FLEET"}
    assert values["control_hz"] == {"value": 5.0, "from": "flag"}
    assert values["link.connect"]["value"] == ["tcp/127.0.0.1:7447", "tcp/127.0.0.1:7448"]
    assert values["seed"] == {"value": 0, "from": "default"}
    assert main(line) == 0
    assert "genoa" in capfd.readouterr().out


def test_a_busy_port_is_one_line(capfd: Capture) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["hub", "--listen", f"tcp/127.0.0.1:{port}"]) == 1
    said = capfd.readouterr()
    assert said.err == f"error: cannot listen at tcp/127.0.0.1:{port}: Address already in use\n"
