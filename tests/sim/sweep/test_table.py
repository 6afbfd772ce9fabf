"""The figures of a sweep."""

from __future__ import annotations

import numpy as np

from fleet.sim.batch import run
from fleet.sim.batch.families import swap, two_boat
from fleet.sim.sweep.checks import evaluate
from fleet.sim.sweep.table import figures


def test_settling_is_the_time_from_which_on_boats_stay_in_their_places() -> None:
    results = run(swap(4, 3, limit_s=200.0))
    told = figures([results])
    assert told["settled_p95_s"] == results.settled_s.max()  # of eight boats
    assert told["settled_median_s"] == np.sort(results.settled_s.ravel())[3]
    assert told["unsettled"] == 0
    assert all(check.ok for check in evaluate({"settled_p95_s": 150.0, "unsettled_max": 0.0}, told))
    results.settled_s[1, 0] = np.inf
    told = figures([results])
    assert (told["settled_p95_s"], told["unsettled"]) == (None, 1)
    assert np.isfinite(told["settled_median_s"])
    assert [check.ok for check in evaluate({"settled_p95_s": 1e6, "unsettled_max": 0.0}, told)] == [False, False]


def test_boats_without_a_formation_have_nothing_to_settle() -> None:
    told = figures([run(two_boat(2, 1, limit_s=10.0))])
    assert told["settled_p95_s"] is None
    assert told["unsettled"] is None


def test_a_case_that_does_not_end_counts_as_stopped_even_while_its_boats_move() -> None:
    told = figures([run(two_boat(2, 1, limit_s=60.0))])
    assert (told["standstills"], told["stopped"], told["arrived"]) == (2, 2, 0)
