"""Speeds that make and keep a formation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.coordination import Member, along_path_error, formation_speed

metres = st.floats(-500.0, 500.0)
weights = st.sampled_from([0.0, 0.05, 0.5, 1.0])
members = st.lists(st.tuples(weights, metres), max_size=6)


def error(z: float, *others: float) -> float:
    return along_path_error(z, [Member(1.0, other) for other in others])


# -- by hand -----------------------------------------------------------------------------------------------------------
def test_nobody_else_is_no_error() -> None:
    assert error(7.0) == 0.0


def test_three_metres_behind_its_place_the_error_is_plus_three() -> None:
    assert error(0.0, 3.0) == 3.0


def test_the_error_is_the_mean_over_the_others() -> None:
    assert error(0.0, 3.0, -1.0, 4.0) == 2.0


def test_two_boats_see_opposite_errors() -> None:
    assert error(0.0, 3.0) == -error(3.0, 0.0)


def test_one_straggler_counts_for_ten_metres_and_no_more() -> None:
    assert error(0.0, -200.0) == -10.0
    assert error(0.0, -200.0, 0.0, 0.0, 0.0) == -2.5
    assert error(0.0, 1e18, 1e18) == 10.0


def test_a_boat_that_comes_back_counts_by_its_weight() -> None:
    assert along_path_error(0.0, [Member(0.25, 4.0)]) == 1.0, "not divided by its small weight: no bump"
    assert along_path_error(0.0, [Member(1.0, 0.0), Member(0.5, 6.0)]) == pytest.approx(2.0)


def test_in_its_place_a_boat_goes_at_cruise_speed() -> None:
    assert formation_speed(0.0, 1.0, 0.7, 1.4, 0.3) == 1.0


def test_far_behind_it_goes_at_its_fastest_and_far_ahead_at_its_slowest() -> None:
    assert formation_speed(1e6, 1.0, 0.7, 1.4, 0.3) == pytest.approx(1.4)
    assert formation_speed(-1e6, 1.0, 0.7, 1.4, 0.3) == pytest.approx(0.7)


def test_one_metre_behind() -> None:
    assert formation_speed(1.0, 1.0, 0.7, 1.4, 0.3) == pytest.approx(1.0 + 0.4 * math.tanh(0.3))
    assert formation_speed(-1.0, 1.0, 0.7, 1.4, 0.3) == pytest.approx(1.0 - 0.3 * math.tanh(0.3))


# -- the paper ---------------------------------------------------------------------------------------------------------
@given(s1=metres, s2=metres, wanted=st.floats(-50.0, 50.0))
def test_two_boats_are_the_papers_law_with_slots_d_and_0(s1: float, s2: float, wanted: float) -> None:
    """Eq. 4 with its signs put right: e = s_2 + D* - s_1 for the boat in slot 1, u = mean + half range x tanh(k e)."""
    u_min, u_max, gain = 0.7, 1.3, 0.3
    z1, z2 = s1 - wanted, s2
    e1, e2 = error(z1, z2), error(z2, z1)
    paper = min(max((s2 + wanted) - s1, -10.0), 10.0)
    assert e1 == pytest.approx(paper, abs=1e-9)
    assert e2 == pytest.approx(-paper, abs=1e-9)
    u = 0.5 * (u_max + u_min) + 0.5 * (u_max - u_min) * math.tanh(gain * paper)
    assert formation_speed(e1, 1.0, u_min, u_max, gain) == pytest.approx(u, abs=1e-9)


@given(s1=metres, s2=metres, wanted=st.floats(-50.0, 50.0))
def test_the_opposite_spacing_swaps_the_boats(s1: float, s2: float, wanted: float) -> None:
    in_slot_one_of_minus_d, in_slot_zero_of_d = error(s1 + wanted, s2), error(s1, s2 - wanted)
    assert in_slot_one_of_minus_d == pytest.approx(in_slot_zero_of_d, abs=1e-9)


# -- always ------------------------------------------------------------------------------------------------------------
@given(z=metres, others=members, masked=st.integers(0, 6))
def test_a_masked_member_is_neutral_to_the_bit(z: float, others: list[tuple[float, float]], masked: int) -> None:
    plain = [Member(w, other) for w, other in others]
    more = [*plain[:masked], Member(0.0, 123.0), *plain[masked:]]
    assert along_path_error(z, more) == along_path_error(z, plain)
    assert math.copysign(1.0, along_path_error(z, more)) == math.copysign(1.0, along_path_error(z, plain))


@given(z=metres, others=members)
def test_the_error_is_never_more_than_ten_metres(z: float, others: list[tuple[float, float]]) -> None:
    assert abs(along_path_error(z, [Member(*pair) for pair in others])) <= 10.0 + 1e-9


@given(e=st.floats(-1e9, 1e9), cruise=st.floats(0.3, 1.4))
def test_the_speed_is_always_within_the_limits(e: float, cruise: float) -> None:
    assert 0.2 - 1e-12 <= formation_speed(e, cruise, 0.2, 1.5, 0.3) <= 1.5 + 1e-12


@given(cases=st.lists(st.tuples(metres, weights, metres, weights, metres), min_size=1, max_size=9))
def test_a_batch_gets_what_each_boat_would_get_alone(cases: list[tuple[float, ...]]) -> None:
    z, w1, z1, w2, z2 = np.array(cases).T
    e: Any = along_path_error(z, [Member(w1, z1), Member(w2, z2)])
    u: Any = formation_speed(e, np.full_like(z, 1.0), np.full_like(z, 0.2), np.full_like(z, 1.5), np.full_like(z, 0.3))
    alone = [along_path_error(c[0], [Member(c[1], c[2]), Member(c[3], c[4])]) for c in cases]
    assert e.tolist() == alone
    assert u.tolist() == [formation_speed(a, 1.0, 0.2, 1.5, 0.3) for a in alone]


# -- it converges ------------------------------------------------------------------------------------------------------
def settle(s: list[float], offsets: list[float], seconds: float, masks: dict[int, float] | None = None) -> list[float]:
    """Points that sail at the speed of the law; how far each is off at the end."""
    masks = masks or {}
    for _ in range(round(seconds * 10.0)):
        z = [a - o for a, o in zip(s, offsets, strict=True)]
        speeds = [
            formation_speed(
                along_path_error(z[i], [Member(masks.get(j, 1.0), z[j]) for j in range(len(s)) if j != i]),
                1.0,
                0.2,
                1.5,
                0.3,
            )
            for i in range(len(s))
        ]
        s = [a + 0.1 * u for a, u in zip(s, speeds, strict=True)]
    z = [a - o for a, o in zip(s, offsets, strict=True)]
    return [a - sum(z) / len(z) for a in z]


@pytest.mark.parametrize("boats", [2, 3, 5, 10])
def test_any_start_becomes_the_formation(boats: int) -> None:
    start = [40.0 * math.sin(7.0 * k) for k in range(boats)]
    assert max(map(abs, settle(start, [-12.0 * k for k in range(boats)], 150.0))) < 0.05


def test_one_straggler_does_not_halt_the_fleet() -> None:
    offsets = [-12.0 * k for k in range(5)]
    start = [*offsets[:4], offsets[4] - 200.0]
    s = list(start)
    for _ in range(600):
        z = [a - o for a, o in zip(s, offsets, strict=True)]
        u = [
            formation_speed(along_path_error(z[i], [Member(1.0, z[j]) for j in range(5) if j != i]), 1.0, 0.2, 1.5, 0.3)
            for i in range(5)
        ]
        assert min(u[:4]) > 0.2
        s = [a + 0.1 * v for a, v in zip(s, u, strict=True)]
    front = [a - o for a, o in zip(s[:4], offsets[:4], strict=True)]
    assert max(front) - min(front) < 0.1, "the others stay in their places among themselves"


def test_boats_that_do_not_hear_one_settle_among_themselves() -> None:
    off = settle([0.0, -30.0, 5.0], [0.0, -12.0, -24.0], 120.0, masks={2: 0.0})
    assert abs(off[0] - off[1]) < 0.05
