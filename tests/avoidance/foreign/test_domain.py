"""The water around a vessel."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.avoidance.foreign.domain import clearance, domain, gap

from .scenes import P, target

coordinates = st.floats(-100.0, 100.0)


@pytest.mark.parametrize(
    ("length", "c0", "give_way", "stand_on"),
    [(5.0, 7.7, 33.4, 16.04), (20.0, 11.2, 40.4, 20.24), (60.0, 31.2, 80.4, 44.24), (100.0, 41.2, 100.4, 56.24)],
)
def test_larger_vessels_have_larger_domains_and_longer_times(
    length: float, c0: float, give_way: float, stand_on: float
) -> None:
    d = domain(target(0.0, 0.0, 0.0, 5.0, length), 1.0, 0.0, P)
    assert pytest.approx(c0) == d.C
    assert pytest.approx(give_way) == d.T_gw
    assert pytest.approx(stand_on) == d.T_so
    assert pytest.approx(1.5 * give_way) == d.H


def test_the_core_reaches_ten_seconds_ahead_but_no_more_than_three_lengths() -> None:
    slow, fast = domain(target(0.0, 0.0, 0.0, 2.0), 1.0, 0.0, P), domain(target(0.0, 0.0, 0.0, 9.0), 1.0, 0.0, P)
    assert (slow.astern, slow.ahead) == (-8.0, 28.0)
    assert fast.ahead == 68.0


def test_a_vessel_without_a_course_is_a_point_with_its_length_around() -> None:
    d = domain(target(0.0, 0.0, 90.0, 0.2), 1.0, 0.0, P)
    assert (d.slow, d.astern, d.ahead) == (1.0, 0.0, 0.0)
    assert pytest.approx(11.2 + 8.0) == d.C
    assert domain(target(0.0, 0.0, 90.0, 0.5), 1.0, 0.0, P).slow == 0.0
    assert domain(target(0.0, 0.0, 90.0, 0.5, P22=0.09), 1.0, 0.0, P).slow == 1.0


def test_a_vessel_that_is_only_just_fast_enough_has_a_domain_between_the_two() -> None:
    # sigma_v 0.1: round below 0.3 m/s, on its course from 0.6 m/s on; 0.45 m/s is half way
    slow, between, fast = (domain(target(0.0, 0.0, 90.0, U, P22=0.01), 1.0, 0.0, P) for U in (0.29, 0.45, 0.61))
    assert (slow.vague, fast.vague) == (1.0, 0.0)
    assert between.vague == pytest.approx(0.5)
    assert between.astern == pytest.approx(-4.0)
    assert between.ahead == pytest.approx(4.0 + 0.5 * 4.5)
    assert pytest.approx(11.2 + 4.0) == between.C
    assert pytest.approx(11.2) == fast.C


def test_a_velocity_that_may_be_noise_is_believed_in_part() -> None:
    # half of the square of 0.14 m/s is noise where sigma_v is 0.1; a vessel that certainly moves is believed whole
    (lies,) = domain(target(0.0, 0.0, 0.0, math.sqrt(0.02), P22=0.01), 1.0, 0.0, P).guesses
    (goes,) = domain(target(0.0, 0.0, 0.0, 2.0, P22=0.01), 1.0, 0.0, P).guesses
    assert lies.vx == pytest.approx(0.5 * math.sqrt(0.02))
    assert (lies.ex, goes.vx, goes.ex) == (1.0, 2.0, 1.0)


@given(st.floats(0.0, 1.5), st.floats(0.05, 0.3))
def test_a_little_more_speed_changes_a_domain_only_a_little(U: float, sigma: float) -> None:
    one, two = (domain(target(0.0, 0.0, 90.0, U + more, P22=sigma * sigma), 1.0, 0.0, P) for more in (0.0, 0.001))
    # 8 m in three standard deviations at most, and the bow zone by its own 10 s
    assert abs(one.C - two.C) <= 0.001 * 8.0 / (3.0 * sigma) + 1e-9
    assert abs(one.ahead - two.ahead) <= 0.001 * (8.0 + 10.0 * 1.5) / (3.0 * sigma) + 0.01 + 1e-9


def test_uncertainty_widens_the_domain_by_half_its_margin_at_most() -> None:
    d = domain(target(0.0, 0.0, 0.0, 5.0, P11=4.0, P22=0.01), 1.0, 0.0, P)
    assert pytest.approx(13.2) == d.C
    assert clearance(d, 10.0) == pytest.approx(14.2)
    assert clearance(d, 1000.0) == pytest.approx(15.2)
    assert pytest.approx(15.2) == domain(target(0.0, 0.0, 0.0, 5.0, P11=400.0), 1.0, 0.0, P).C


def test_a_turning_vessel_has_a_second_velocity() -> None:
    first, second = domain(target(0.0, 0.0, 0.0, 2.0, om=0.1), 1.0, 0.0, P).guesses
    assert (first.vx, first.vy) == (2.0, 0.0)
    assert second.vx == pytest.approx(2.0 * math.cos(0.6))
    assert second.vy == pytest.approx(2.0 * math.sin(0.6))


@pytest.mark.parametrize(
    ("leg", "distance", "where"),
    [
        ((0.0, 5.0, 10.0, 5.0), 5.0, 0.0),  # along it
        ((0.0, 5.0, 0.0, -5.0), 0.0, 0.5),  # across it
        ((-10.0, 3.0, -6.0, 3.0), math.hypot(4.0, 3.0), 1.0),  # short of it
        ((20.0, -10.0, 20.0, 10.0), 12.0, 0.5),  # ahead of it
        ((3.0, 4.0, 3.0, 4.0), 4.0, 0.0),  # standing
    ],
)
def test_the_gap_between_a_leg_and_a_core(
    leg: tuple[float, float, float, float], distance: float, where: float
) -> None:
    assert gap(*leg, -2.0, 8.0) == (pytest.approx(distance), pytest.approx(where))


@given(coordinates, coordinates, coordinates, coordinates, st.floats(0.0, 60.0))
def test_the_gap_is_the_least_of_a_thousand_points_of_the_leg(
    x0: float, y0: float, x1: float, y1: float, high: float
) -> None:
    share = np.linspace(0.0, 1.0, 1001)
    x, y = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
    sampled = float(np.hypot(x - np.clip(x, -2.0, high), y).min())
    least, _ = gap(x0, y0, x1, y1, -2.0, high)
    assert sampled - 0.15 <= least <= sampled + 1e-9


@given(st.lists(st.tuples(coordinates, coordinates, coordinates, coordinates), min_size=1, max_size=9))
def test_legs_in_an_array_have_the_gaps_of_each_alone(legs: list[tuple[float, float, float, float]]) -> None:
    together = gap(*np.array(legs).T, -2.0, 8.0)
    assert [values.tolist() for values in together] == [
        list(v) for v in zip(*(gap(*leg, -2.0, 8.0) for leg in legs), strict=True)
    ]
