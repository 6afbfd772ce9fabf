"""Run folders are found by the names people use for them."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

from fleet.errors import RecordingError
from fleet.recording.runs import default_root, find, list_runs, new_run

NOON = datetime(2026, 11, 22, 12, 0, 0, tzinfo=UTC)


def test_a_run_is_named_by_time_and_mission_and_twice_in_a_second_stays_unique(tmp_path: Path) -> None:
    names = [new_run(tmp_path, "missions/Over taking.toml", NOON).name for _ in range(11)]
    assert names[:2] == ["20261122T120000Z-over-taking", "20261122T120000Z-over-taking-2"]
    assert [run.name for run in list_runs(tmp_path)] == names


def test_runs_are_found_by_path_name_beginning_mission_and_last(tmp_path: Path) -> None:
    first = new_run(tmp_path, "overtaking", NOON)
    second = new_run(tmp_path, "crossing", NOON.replace(hour=13))
    third = new_run(tmp_path, "overtaking", NOON.replace(hour=14))
    assert find(tmp_path, "last") == third
    assert find(tmp_path, first.name) == first
    assert find(None, first.folder) == first
    assert find(tmp_path, "20261122T13") == second
    assert find(tmp_path, "crossing") == second
    assert find(tmp_path, "overtaking") == third
    first.recording.write_bytes(b"")
    assert find(None, first.recording) == first
    assert find(None, first.boat_recording("otter-1").parent.parent) == first


def test_what_cannot_be_found_is_said_with_what_there_is(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no run in "):
        find(tmp_path, "last")
    new_run(tmp_path, "overtaking", NOON)
    new_run(tmp_path, "crossing", NOON)
    with pytest.raises(RecordingError, match=r"no run called sine .* there are 20261122T120000Z-crossing"):
        find(tmp_path, "sine")
    with pytest.raises(RecordingError, match="several runs begin with 2026"):
        find(tmp_path, "2026")


def test_the_root_comes_from_the_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("FLEET_RUNS", raising=False)
    assert default_root() == Path("runs")
    monkeypatch.setenv("FLEET_RUNS", str(tmp_path))
    assert new_run(None, "a", NOON).folder.parent == tmp_path


def test_a_root_that_cannot_be_written_is_refused_in_words(tmp_path: Path) -> None:
    (tmp_path / "runs").write_text("a file")
    with pytest.raises(RecordingError, match="cannot make the run folder"):
        new_run(tmp_path / "runs", "a", NOON)
