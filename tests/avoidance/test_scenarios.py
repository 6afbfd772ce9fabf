"""Whole encounters in a small sea; the bands are those of the corrected paper and of velocity scoring's own figures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fleet.avoidance.circle import CircleParams
from fleet.avoidance.params import for_radius
from tests.avoidance.sea import Fleet, Outcome, antipodal, meeting, sail

HULL_M = 2.4


def overtake(name: str, params: Any) -> tuple[Outcome, np.ndarray, np.ndarray]:
    """Spacing 20 m becomes -20 m on one straight path, 0.7-1.3 m/s; errors and speeds per tick."""
    ahead = np.array([[20.0], [0.0]])
    fleet = Fleet(ahead, np.zeros((2, 1)), np.zeros((2, 1)), np.ones((2, 1)), np.full((2, 1), 1e4))
    errors, speeds = [], []

    def wanted(s: np.ndarray, _time: float) -> np.ndarray:
        z = s + ahead - np.array([[-20.0], [0.0]])
        error = 2.0 * (z.mean(axis=0) - z)
        errors.append(abs(error[0, 0]))
        return 1.0 + 0.3 * np.tanh(0.3 * error)

    def watch(_tick: int, own: Any, *_: Any) -> None:
        speeds.append(np.hypot(own.vx, own.vy))

    outcome = sail(fleet, name, params, wanted, time_s=120.0, watch=watch)
    return outcome, np.array(errors), np.array(speeds)


@pytest.mark.parametrize(
    ("name", "params", "least", "below_1_m", "below_0_1_m"),
    [
        ("circle", CircleParams(side="closest"), 4.8, 75, 81),
        ("circle", CircleParams(side="starboard"), 4.0, 75, 81),
        ("scoring", for_radius(6.0), 6.0, 80, 90),
    ],
)
def test_overtaking_swaps_the_boats(name: str, params: Any, least: float, below_1_m: int, below_0_1_m: int) -> None:
    outcome, errors, speeds = overtake(name, params)
    assert outcome.least[0] >= least
    assert errors[below_1_m * 10 :].max() < 1.0
    assert errors[below_0_1_m * 10 :].max() < 0.1
    assert speeds.min() >= 0.70 - 1e-9
    assert speeds.max() <= 1.30 + 1e-9
    assert abs(speeds[850:] - 1.0).max() < 0.02
    assert outcome.switches.tolist() == [[2.0], [2.0]]


def test_the_circle_as_printed_never_gets_past() -> None:
    _, errors, _ = overtake("circle", CircleParams(printed=True))
    assert errors[-1] > 10.0


@pytest.mark.parametrize(
    ("fleet", "least", "median"),
    [
        (meeting(2, 100, 5), 6.0, 7.4),
        (meeting(4, 25, 5), 6.0, 6.9),
        (antipodal(4, 10, 5, 40.0), 6.3, 6.8),
        (antipodal(8, 3, 5, 50.0), 6.3, 6.8),
        (antipodal(16, 1, 5, 70.0), 6.0, 6.0),
    ],
    ids=["two", "four", "antipodal-4", "antipodal-8", "antipodal-16"],
)
def test_velocity_scoring_keeps_crowds_apart_and_everybody_arrives(fleet: Fleet, least: float, median: float) -> None:
    outcome = sail(fleet)
    assert outcome.least.min() >= least
    assert np.median(outcome.least) >= median
    assert np.isfinite(outcome.arrived).all()


@pytest.mark.parametrize("silent", [(), (1,)], ids=["known", "silent"])
def test_a_boat_that_does_not_keep_clear_is_avoided_by_the_other(silent: tuple[int, ...]) -> None:
    fleet = meeting(2, 30, 6)
    fleet.deaf, fleet.silent = (1,), silent
    outcome = sail(fleet)
    assert outcome.least.min() >= 5.0
    assert np.isfinite(outcome.arrived[0]).all()


def test_without_keeping_clear_they_would_have_collided() -> None:
    fleet = meeting(4, 40, 5)
    fleet.deaf = (0, 1, 2, 3)
    assert (sail(fleet).least < HULL_M).mean() > 0.8


def test_three_boats_meeting_at_120_degrees_pass_and_are_back() -> None:
    chi = np.array([[0.0], [2.0 * np.pi / 3.0], [-2.0 * np.pi / 3.0]])
    fleet = Fleet(-40.0 * np.cos(chi), -40.0 * np.sin(chi), chi, np.ones((3, 1)), np.full((3, 1), 105.0))
    assert sail(fleet, "scoring").least[0] >= 6.0
    starboard = sail(fleet, "circle", CircleParams(side="starboard"))
    assert starboard.least[0] >= 5.0
    assert np.isfinite(starboard.arrived).all()


def test_one_case_alone_sails_as_in_the_batch() -> None:
    fleet = meeting(2, 4, 7)
    together = sail(fleet, time_s=110.0)
    one = Fleet(*(a[:, 2:3] for a in (fleet.x, fleet.y, fleet.chi_p, fleet.speed, fleet.length)))
    alone = sail(one, time_s=110.0)
    assert alone.least[0] == together.least[2]
    assert alone.arrived[:, 0].tolist() == together.arrived[:, 2].tolist()
