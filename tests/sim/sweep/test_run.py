"""A sweep from its first part to the last, interrupted or not; and one of its cases alone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np
import pytest

from fleet.errors import RecordingError, UsageError
from fleet.sim.batch import run as run_batch
from fleet.sim.sweep.alone import closest, sail_case, told
from fleet.sim.sweep.family import loads
from fleet.sim.sweep.page import page
from fleet.sim.sweep.parts import Part, pack, sail
from fleet.sim.sweep.pool import Engine, Sailed
from fleet.sim.sweep.run import Ended, Progress
from fleet.sim.sweep.run import sail as sail_sweep
from fleet.sim.sweep.store import Store, create, find
from fleet.sim.sweep.table import MEANINGS, figures, summary
from tests.sim.sweep.brief import ARRAYS, BRIEF, GRID, SEED, same_bits, sweep
from tests.sim.sweep.test_store import files_of_at_most


def here(last: int | None = None, turned: bool = False, lost: Sequence[int] = ()) -> Engine:
    """An engine in this process that is interrupted after so many parts, or begins with the last one."""

    def engine(text: str, seed: int, parts: Sequence[Part]) -> Iterator[Sailed]:
        family = loads(text)
        for number, part in enumerate(reversed(parts) if turned else parts):
            if number == last:
                raise KeyboardInterrupt
            if number in lost:
                yield Sailed(part, None, "sunk")
            else:
                yield Sailed(part, pack(sail(family, seed, part)))

    return engine


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Store:
    """A sweep that nothing disturbed."""
    store = create(tmp_path_factory.mktemp("whole"), sweep(GRID))
    sail_sweep(store, here())
    return store


def bare(found: dict[str, object]) -> dict[str, object]:
    """A summary without what differs from run to run."""
    return {name: value for name, value in found.items() if name not in ("folder", "wall_s", "boat_ticks_per_s")}


def test_an_interrupted_sweep_goes_on_and_ends_with_the_bits_of_one_that_was_not(tmp_path: Path, whole: Store) -> None:
    store = create(tmp_path, sweep(GRID))
    with pytest.raises(KeyboardInterrupt):
        sail_sweep(store, here(last=1, turned=True))
    assert [part.point for part in store.missing()[0]] == [0, 1, 2]
    seen: list[tuple[int, int]] = []
    ended = sail_sweep(find("last", tmp_path), here(), lambda p: seen.append((p.before, p.cases)))
    assert seen == [(5, 5), (5, 10), (5, 15), (5, 20)]
    assert ended.lost == []
    for one, other in zip(store.results(), whole.results(), strict=True):
        assert same_bits(one, other)
    assert bare(summary(store, store.results())) == bare(summary(whole, whole.results()))


def test_a_part_that_comes_twice_counts_once(tmp_path: Path, whole: Store) -> None:
    def twice(text: str, seed: int, parts: Sequence[Part]) -> Iterator[Sailed]:
        for one in here()(text, seed, parts):
            yield one
            yield one

    store = create(tmp_path, sweep(GRID))
    sail_sweep(store, twice)
    assert bare(summary(store, store.results())) == bare(summary(whole, whole.results()))


def test_nothing_is_sailed_again_when_all_is_there(whole: Store) -> None:
    def nobody(text: str, seed: int, parts: Sequence[Part]) -> Iterator[Sailed]:
        raise AssertionError(parts)

    ended = sail_sweep(whole, nobody)
    assert ended.boat_ticks == 0
    assert summary(whole, whole.results(), ended)["boat_ticks_per_s"] is None


def test_a_damaged_part_is_sailed_again_and_named(tmp_path: Path) -> None:
    store = create(tmp_path, sweep(BRIEF))
    sail_sweep(store, here())
    before = store.results()[0]
    store.part_file(store.sweep.parts[0]).write_bytes(b"rubbish")
    ended = sail_sweep(store, here())
    assert len(ended.damaged) == 1
    assert same_bits(store.results()[0], before)


def test_a_full_disk_stops_the_sweep_and_it_goes_on_when_there_is_room(tmp_path: Path, whole: Store) -> None:
    store = create(tmp_path, sweep(GRID))
    with files_of_at_most(1000), pytest.raises(RecordingError, match="largest file size reached"):
        sail_sweep(store, here())
    assert len(store.missing()[0]) == 4
    sail_sweep(store, here())
    assert bare(summary(store, store.results())) == bare(summary(whole, whole.results()))


def test_a_part_given_up_is_named_and_the_sweep_is_not_complete(tmp_path: Path) -> None:
    store = create(tmp_path, sweep(GRID))
    ended = sail_sweep(store, here(lost=[2]))
    found = summary(store, store.results(), ended)
    assert found["lost"] == ["point 2, cases 0 to 4: sunk"]
    assert (found["complete"], found["passed"], found["cases"]) == (False, False, 15)
    assert "point 2, cases 0 to 4: sunk" in page(store, store.results(), found)


def test_parts_of_other_laws_are_not_gone_on_with(tmp_path: Path) -> None:
    store = create(tmp_path, sweep(laws="0123456789abcdef"))
    with pytest.raises(UsageError, match="sailed with other laws, 0123456789abcdef"):
        sail_sweep(store, here())


def test_the_end_is_estimated_from_what_this_process_sailed() -> None:
    progress = Progress(cases=300, total=500, failures=0, before=100, began=-1000.0, latest=-900.0)
    assert progress.left_s == 0.0
    ahead = Progress(cases=300, total=500, failures=0, before=100, began=1e12 - 100.0, latest=1e12)
    assert ahead.left_s == pytest.approx(1e12 + 100.0, rel=1e-6)  # 200 in 100 s, 200 are left
    assert Progress(cases=100, total=500, failures=0, before=100, began=0.0, latest=0.0).left_s is None


def test_figures_are_those_of_the_batch(whole: Store) -> None:
    for results in whole.results():
        assert results is not None
        theirs = results.summary()
        mine = figures([results])
        assert set(mine) == set(MEANINGS)
        shared = set(mine) & set(theirs)
        assert {name: mine[name] for name in shared} == {name: theirs[name] for name in shared}
        assert len(shared) >= 11


def test_figures_of_a_grid_are_those_of_all_its_cases(whole: Store) -> None:
    there = [one for one in whole.results() if one is not None]
    found = summary(whole, there, Ended([], [], 1000, 2.0))
    assert (found["cases"], len(found["points"]), found["boat_ticks_per_s"]) == (20, 4, 500.0)
    assert found["min_separation_m"] == min(point["min_separation_m"] for point in found["points"])
    assert found["collisions"] == sum(point["collisions"] for point in found["points"])
    assert found["points"][3]["values"] == {"keeping_clear.radius_m": 4.0, "radio.loss": 0.4}
    assert len(found["failed_seeds"]) == sum(len(one.failed) for one in there)
    assert all(name.startswith(f"{SEED}/") and name.count("/") == 2 for name in found["failed_seeds"])


@pytest.mark.parametrize("method", ["scoring", "circle"])
def test_a_case_alone_on_floats_has_the_figures_and_the_trace_of_its_lane(tmp_path: Path, method: str) -> None:
    store = create(tmp_path, sweep(GRID.replace("[checks]", f'[keeping_clear]\nmethod = "{method}"\n[checks]')))
    family = store.family
    point = family.points[3]
    lanes = run_batch(
        family.scenarios(SEED, point, np.arange(5)), record=(4,), floats=False, **family.run_options(point)
    )
    alone = sail_case(family, SEED, 3, 4)
    assert same_bits(alone, msgspec.structs.replace(lanes, **{n: getattr(lanes, n)[4:] for n in ARRAYS}))
    for name in alone.traces[0].__struct_fields__:
        assert np.array_equal(getattr(alone.traces[0], name), getattr(lanes.traces[0], name)), name


def test_the_closest_approach_of_a_trace_is_the_least_separation_of_the_case() -> None:
    family = loads(BRIEF)
    results = sail_case(family, SEED, 0, 2)
    near = closest(results.traces[0])
    assert near is not None
    assert near.distance_m == pytest.approx(float(results.least_m[0]), abs=1e-9)
    assert (near.first, near.second) == (1, 2)
    assert 0.0 < near.t_s < 20.0
    said = told(family, SEED, 0, results)
    assert said["case"] == f"brief:{SEED}/2"
    assert said["closest"]["at_s"] == near.t_s
    assert math.isclose(said["min_separation_m"], near.distance_m, abs_tol=1e-9)
