"""A sweep's folder: parts are there whole or not at all, and what is there says what it is."""

from __future__ import annotations

import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.errors import RecordingError, UsageError
from fleet.recording.runs import list_runs, new_run
from fleet.sim.sweep import store as stores
from fleet.sim.sweep.parts import Part, pack, parts_of, sail, unpack
from fleet.sim.sweep.store import create, find
from tests.sim.sweep.brief import GRID, SEED, same_bits, sweep


@contextmanager
def files_of_at_most(number: int) -> Iterator[None]:
    """No file grows beyond so many bytes, as on a disk that is full."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (number, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_1000_cases_of_8_boats_are_four_parts_of_250() -> None:
    assert parts_of([8], 1000) == tuple(Part(0, first, 250) for first in (0, 250, 500, 750))


def test_few_cases_are_one_part_a_point() -> None:
    assert parts_of([2, 4], 30) == (Part(0, 0, 30), Part(1, 0, 30))


@given(st.lists(st.integers(1, 100), min_size=1, max_size=4), st.integers(1, 20_000))
def test_parts_hold_every_case_of_every_point_exactly_once_and_stay_in_the_cache(boats: list[int], cases: int) -> None:
    parts = parts_of(boats, cases)
    for point, of_case in enumerate(boats):
        mine = [part for part in parts if part.point == point]
        assert [c for part in mine for c in (part.first, part.first + part.count)][1:-1:2] == [
            p.first for p in mine[1:]
        ]
        assert (mine[0].first, sum(part.count for part in mine)) == (0, cases)
        assert all(part.count * of_case <= 4096 for part in mine)


def test_a_part_comes_back_from_its_file_to_the_last_bit(tmp_path: Path) -> None:
    store = create(tmp_path, sweep())
    (part,) = store.sweep.parts
    results = sail(store.family, SEED, part)
    store.keep(part, pack(results))
    assert [one.name for one in (store.folder / "parts").iterdir()] == ["0000-000000.npz"]
    back = store.read(part)
    assert same_bits(results, back)
    assert (back.family, back.method, back.seed, back.boat_ticks) == ("brief", "scoring", SEED, results.boat_ticks)
    assert store.missing() == ([], [])


def test_a_damaged_part_and_one_of_other_cases_are_missing_and_named(tmp_path: Path) -> None:
    store = create(tmp_path, sweep(GRID))
    first, second, *others = store.sweep.parts
    content = pack(sail(store.family, SEED, first))
    store.keep(first, content)
    middle = content.index(b'"family"')  # within what has a checksum
    store.part_file(first).write_bytes(content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :])
    shifted = sail(store.family, SEED, Part(1, 5, 5))
    store.keep(second, pack(shifted))
    missing, damaged = store.missing()
    assert missing == [first, second, *others]
    assert "0000-000000.npz: not a part of a sweep, or damaged" in damaged[0]
    assert "0001-000000.npz: not point 1, cases 0 to 4" in damaged[1]


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"nonsense"])
def test_what_is_no_part_is_refused(content: bytes) -> None:
    with pytest.raises(RecordingError, match="not a part of a sweep"):
        unpack(content)


def test_a_full_disk_is_said_and_leaves_nothing_of_the_part(tmp_path: Path) -> None:
    store = create(tmp_path, sweep())
    (part,) = store.sweep.parts
    content = pack(sail(store.family, SEED, part))
    with files_of_at_most(len(content) - 1), pytest.raises(RecordingError, match=r"largest file size reached: .*0000"):
        store.keep(part, content)
    assert list((store.folder / "parts").iterdir()) == []
    store.keep(part, content)
    assert store.missing() == ([], [])


def test_what_was_written_before_stays_when_it_cannot_be_written_again(tmp_path: Path) -> None:
    store = create(tmp_path, sweep())
    stores.write_text(store.summary_file, "old")
    with files_of_at_most(2), pytest.raises(RecordingError):
        stores.write_text(store.summary_file, "newer")
    assert store.summary_file.read_text() == "old"


def test_a_sweep_is_found_by_path_name_beginning_family_and_as_the_last_but_is_no_run(tmp_path: Path) -> None:
    new_run(tmp_path, "overtaking")
    store = create(tmp_path, sweep())
    name = store.folder.name
    assert name.endswith("-sweep-brief")
    for which in (str(store.folder), name, name[:15], "brief", "last"):
        assert find(which, tmp_path).folder == store.folder
    assert find("last", tmp_path).sweep == store.sweep
    assert [run.name[17:] for run in list_runs(tmp_path)] == ["overtaking"]


def test_an_unknown_sweep_is_refused_with_those_that_there_are(tmp_path: Path) -> None:
    name = create(tmp_path, sweep()).folder.name
    with pytest.raises(UsageError, match=f"nowhere: no sweep; .* there are: {name}"):
        find("nowhere", tmp_path)


def test_two_processes_never_sail_one_sweep(tmp_path: Path) -> None:
    store = create(tmp_path, sweep())
    with store.alone(), pytest.raises(UsageError, match="another process sails this sweep"), store.alone():
        pass
    with store.alone():
        pass


def test_a_draft_of_a_killed_process_is_not_taken_for_a_part(tmp_path: Path) -> None:
    store = create(tmp_path, sweep())
    (part,) = store.sweep.parts
    (store.folder / "parts" / f".{part.name}.npz.{os.getpid()}").write_bytes(b"half")
    assert store.missing() == ([part], [])
    assert store.results() == [None]


def test_results_of_a_point_are_in_the_order_of_their_cases_whoever_came_first(tmp_path: Path) -> None:
    parts = (Part(0, 0, 2), Part(0, 2, 3))
    store = create(tmp_path, sweep(parts=parts))
    for part in reversed(parts):
        store.keep(part, pack(sail(store.family, SEED, part)))
    (joined,) = store.results()
    assert joined is not None
    assert np.array_equal(joined.case, np.arange(5))
    assert same_bits(joined, sail(store.family, SEED, Part(0, 0, 5)))
