"""A receiver's slow error: learnt from the way sailed, alike for one boat and for many."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fleet.sensing import drift
from fleet.sensing.drift import Cov, Drifting


def test_the_first_fix_is_the_position_and_all_its_error_is_the_slow_one() -> None:
    cov = drift.first(1.5, 0.05)
    assert cov.xx == pytest.approx(2.25 + 0.75**2)
    assert cov.xb == -cov.bb == -2.25


def test_without_time_a_second_fix_tells_nothing_but_the_noise() -> None:
    cov, gain = drift.by_fix(drift.first(1.5, 0.05), drift.white_of(1.5))
    assert cov.bb == pytest.approx(2.25)
    assert gain == pytest.approx((0.5, 0.0, 0.0))


@pytest.mark.parametrize("seconds", [30.0, 60.0, 120.0, 240.0])
def test_a_good_velocity_lets_the_error_shrink_as_the_mean_of_a_drifting_error_does(seconds: float) -> None:
    """The best mean of a Gauss-Markov error over t has the variance sigma^2 / (1 + t / 2T); T = 60 s."""
    cov = drift.first(1.5, 0.05)
    for _ in range(round(seconds / 0.1)):
        cov, gains = drift.look(cov, 0.1, 1.5, 0.05)
    assert gains.sigma == pytest.approx(1.5 / math.sqrt(1.0 + seconds / 120.0), rel=0.05)


def test_what_is_said_is_never_less_than_half_of_the_receivers_own_error() -> None:
    assert drift.said(Cov(0.01, 0.0, 0.0, 0.0, 0.0, 0.0), 1.5) == 0.75
    assert drift.said(Cov(4.0, 0.0, 0.0, 0.0, 0.0, 0.0), 1.5) == 2.0


def test_an_innovation_of_the_fix_goes_to_position_and_slow_error() -> None:
    known = drift.corrected(Drifting(0.0, 0.0, 1.0, 0.0, 0.0, 0.0), (0.25, 0.0, 0.75), 4.0, -4.0)
    assert known == Drifting(1.0, -1.0, 1.0, 0.0, 3.0, -3.0)


def test_many_boats_get_what_each_gets_alone_to_the_last_bit() -> None:
    rng = np.random.default_rng(3)
    start, fixes = rng.normal(size=(6, 5)), rng.normal(size=(20, 5, 5))
    lanes = Drifting(*start)
    alone = [Drifting(*start[:, k].tolist()) for k in range(5)]
    cov = drift.first(1.5, 0.05)
    for x, y, vx, vy, r in fixes:
        cov, gains = drift.look(cov, 0.1, 1.5, 0.05)
        lanes = drift.seen(lanes, x, y, vx, vy, r, 0.1, gains)
        alone = [
            drift.seen(one, float(x[k]), float(y[k]), float(vx[k]), float(vy[k]), float(r[k]), 0.1, gains)
            for k, one in enumerate(alone)
        ]
    assert [lanes.x.tolist(), lanes.by.tolist()] == [[one.x for one in alone], [one.by for one in alone]]
