"""Two sweeps side by side: what got worse, and when that cannot be said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from msgspec import structs

from fleet.sim.batch import Results
from fleet.sim.sweep.compare import compare, differences, paired
from fleet.sim.sweep.parts import Part, pack, sail
from fleet.sim.sweep.store import Store, create
from tests.sim.sweep.brief import BRIEF, GRID, SEED, sweep


def results(store: Store) -> Results:
    return sail(store.family, SEED, Part(0, 0, 5))


@pytest.fixture
def one(tmp_path: Path) -> Store:
    """A sweep that is not sailed yet."""
    return create(tmp_path, sweep())


def altered(of: Results, least: list[float], late: float = 0.0) -> Results:
    """The same cases with other least separations, and later arrivals of all boats."""
    arrived = np.full(of.arrived_s.shape, 20.0)
    return structs.replace(of, least_m=np.array(least), arrived_s=arrived + late)


def test_each_case_is_compared_with_itself(one: Store) -> None:
    found = results(one)
    before = altered(found, [5.0, 1.0, 5.0, 1.0, 5.0])
    after = altered(found, [1.0, 5.0, 1.0, 1.0, 5.001], late=2.5)
    pair = paired([before], [after])
    assert pair["cases"] == 5
    assert pair["collisions"] == {"both": 1, "only_a": 1, "only_b": 2}
    separation = pair["separation"]
    assert (separation["less"], separation["equal"], separation["more"]) == (2, 2, 1)
    assert (separation["least"], separation["most"]) == (-4.0, 4.0)
    assert separation["median"] == 0.0
    assert pair["delay"] == {"number": 10, "median": 2.5, "least": 2.5, "most": 2.5, "less": 0, "equal": 0, "more": 10}


def test_only_cases_that_both_have_are_compared(one: Store) -> None:
    found = results(one)
    some = sail(one.family, SEED, Part(0, 3, 2))
    pair = paired([found], [some])
    assert (pair["cases"], pair["separation"]["equal"], pair["delay"]["equal"]) == (2, 2, pair["delay"]["number"])


def test_cases_that_turned_are_named(tmp_path: Path) -> None:
    a = create(tmp_path, sweep())
    b = create(tmp_path, sweep(BRIEF + '[keeping_clear]\nmethod = "circle"\n'))
    (part,) = a.sweep.parts
    found = results(a)
    a.keep(part, pack(altered(found, [5.0, 1.0, 5.0, 1.0, 5.0])))
    b.keep(part, pack(structs.replace(altered(found, [1.0, 5.0, 5.0, 1.0, 5.0]), method="circle")))
    said = compare(a, b)
    assert (said["comparable"], said["a"]["method"], said["b"]["method"]) == (True, "scoring", "circle")
    assert (said["worse"], said["better"]) == (["7/0"], ["7/1"])
    assert said["points"][0]["a"]["collisions"] == 2


def test_points_are_matched_by_their_labels(tmp_path: Path) -> None:
    a = create(tmp_path, sweep(GRID))
    b = create(tmp_path, sweep(GRID.replace("[3.0, 4.0]", "[4.0, 5.0]")))
    for store in (a, b):
        for part in store.sweep.parts:
            store.keep(part, pack(sail(store.family, SEED, part)))
    said = compare(a, b)
    assert [point["label"] for point in said["points"] if point["paired"]] == [
        "radius_m 4, loss 0",
        "radius_m 4, loss 0.4",
    ]
    assert (len(said["points"]), said["together"]["paired"]["cases"]) == (6, 10)
    assert said["together"]["paired"]["separation"]["equal"] == 10


@pytest.mark.parametrize(
    ("other", "why"),
    [
        (sweep(seed=8), ["seeds 7 and 8"]),
        (sweep(BRIEF.replace("boats = 2", "boats = 3")), ["2 and 3 boats"]),
        (sweep(BRIEF.replace('"brief"', '"short"')), ["families brief and short"]),
        (sweep(BRIEF.replace("meet_s = 9.0", "meet_s = 8.5")), ["family brief with other scenarios: layout"]),
        (sweep(GRID), ["no point of the grid in common"]),
        (sweep(BRIEF.replace("cases = 5", "cases = 6")), []),
        (sweep(BRIEF + "[keeping_clear]\nradius_m = 5.0\n"), []),
    ],
)
def test_what_is_not_comparable_is_said_and_why(other: object, why: list[str]) -> None:
    assert differences(sweep(), other) == why  # type: ignore[arg-type]
    assert len(differences(other, sweep())) == len(why)  # type: ignore[arg-type]


def test_sweeps_of_two_seeds_are_shown_but_not_paired(tmp_path: Path) -> None:
    a, b = create(tmp_path, sweep()), create(tmp_path, sweep(seed=8))
    for store in (a, b):
        (part,) = store.sweep.parts
        store.keep(part, pack(sail(store.family, store.sweep.seed, part)))
    said = compare(a, b)
    assert (said["comparable"], said["why"], said["together"]["paired"]) == (False, ["seeds 7 and 8"], None)
    assert said["points"][0]["a"]["cases"] == said["points"][0]["b"]["cases"] == 5
    assert (said["worse"], said["better"]) == ([], [])
