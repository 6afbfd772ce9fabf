"""Arithmetic: as accurate as the libraries, and the same bits for a float and for a lane."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Struct

from fleet import ops
from fleet.ops import R

NAN, INF = math.nan, math.inf
BELOW_MINUS_PI = math.nextafter(-math.pi, -INF)
EDGES = [
    *(0.0, -0.0, 1.0, -1.0, 1e-300, -1e-300, 5e-324, 1e-9, -1e-9, 0.5, 1e5, -1e5),
    *(k * math.pi / 4.0 for k in range(-9, 10)),
    *(BELOW_MINUS_PI, math.nextafter(math.pi, INF), math.nextafter(math.pi, 0.0), math.nextafter(math.pi / 4, 1.0)),
    *(0.125, 0.375, 0.625, 0.875, 22.0, -22.0, 23.0, 700.0),
]
UNARY: dict[str, Callable[..., object]] = {
    "sin": lambda x: ops.sincos(x)[0],
    "cos": lambda x: ops.sincos(x)[1],
    "tanh": ops.tanh,
    "wrap": ops.wrap,
    "floor": ops.floor,
    "finite": ops.finite,
    "zero": ops.zero,
    "sqrt of its size": lambda x: ops.sqrt(abs(x)),
    "flag": lambda x: ops.flag(x > 0.5, x),
    "full": lambda x: ops.full(x, 2.5),
}
BINARY: dict[str, Callable[..., object]] = {
    "atan2": ops.atan2,
    "minimum": ops.minimum,
    "maximum": ops.maximum,
    "hypot": ops.hypot,
    "where": lambda x, y: ops.where(x > y, x, y),
    "clip": lambda x, y: ops.clip(x, -abs(y), abs(y)),
    "select": lambda x, y: ops.select(((x > 1.0, 1.0), (y > 1.0, 2.0), (x > -INF, 3.0)), ops.full(x, 4.0)),
}


def bits(values: object) -> list[bytes]:
    """Every NaN counts as the same one: the sign of a NaN carries nothing."""
    array = np.asarray(values, dtype=np.float64)
    return [np.where(np.isnan(array), NAN, array)[i].tobytes() for i in range(array.size)]


@pytest.mark.parametrize("name", UNARY)
def test_a_float_and_a_lane_get_equal_bits_from_every_law_of_one_value(name: str) -> None:
    law = UNARY[name]
    values = [*EDGES, NAN, *np.random.default_rng(1).normal(0.0, 20.0, 2000).tolist()]
    with np.errstate(all="ignore"):
        lanes = law(np.array(values))
    assert bits(lanes) == bits([law(v) for v in values])


@pytest.mark.parametrize("name", BINARY)
def test_a_float_and_a_lane_get_equal_bits_from_every_law_of_two_values(name: str) -> None:
    law = BINARY[name]
    second = EDGES if name == "atan2" else [*EDGES, NAN]  # its NaN has a test of its own
    pairs = [(a, b) for a in [*EDGES, NAN] for b in second]
    pairs += [tuple(p) for p in np.random.default_rng(2).normal(0.0, 3.0, (2000, 2)).tolist()]
    x, y = np.array(pairs).T
    with np.errstate(all="ignore"):
        lanes = law(x, y)
    assert bits(lanes) == bits([law(*p) for p in pairs])


def test_an_array_of_one_and_of_a_thousand_give_the_same_lane() -> None:
    values = np.random.default_rng(3).normal(0.0, 5.0, 1000)
    assert ops.tanh(values)[:1].tolist() == ops.tanh(values[:1]).tolist() == [ops.tanh(float(values[0]))]


@pytest.mark.parametrize(
    "law", [ops.tanh, ops.wrap, ops.floor, lambda x: ops.sincos(x)[0], lambda x: ops.atan2(x, 1.0)]
)
def test_a_float_stays_a_float(law: Callable[[float], object]) -> None:
    assert all(type(law(v)) is float for v in [*EDGES, NAN])


def test_sine_and_cosine_are_those_of_a_book_to_3e_16() -> None:
    angles = [*EDGES, *np.random.default_rng(4).uniform(-1e5, 1e5, 2000).tolist()]
    for a in angles:
        s, c = ops.sincos(a)
        assert abs(s - mpmath.sin(mpmath.mpf(a))) < 3e-16
        assert abs(c - mpmath.cos(mpmath.mpf(a))) < 3e-16


def test_the_angle_of_a_vector_is_that_of_a_book_to_5e_16() -> None:
    for x, y in np.random.default_rng(5).normal(0.0, 10.0, (2000, 2)).tolist():
        assert abs(ops.atan2(y, x) - mpmath.atan2(y, x)) < 5e-16


@pytest.mark.parametrize("y", [0.5, 5.0])
def test_the_angle_of_a_vector_with_a_nan_is_nan(y: float) -> None:
    assert math.isnan(ops.atan2(NAN, y))
    assert math.isnan(ops.atan2(y, NAN))


@pytest.mark.parametrize(
    ("y", "x", "angle"),
    [
        (0.0, 0.0, 0.0),
        (0.0, 1.0, 0.0),
        (1.0, 0.0, math.pi / 2),
        (-1.0, 0.0, -math.pi / 2),
        (0.0, -1.0, math.pi),
        (1.0, 1.0, math.pi / 4),
        (-1.0, -1.0, -3.0 * math.pi / 4),
    ],
)
def test_the_angle_of_a_vector_on_an_axis_is_exact(y: float, x: float, angle: float) -> None:
    assert ops.atan2(y, x) == angle


def test_the_hyperbolic_tangent_is_that_of_a_book_to_4e_16() -> None:
    for x in [*EDGES, *np.random.default_rng(6).normal(0.0, 4.0, 2000).tolist()]:
        assert abs(ops.tanh(x) - mpmath.tanh(mpmath.mpf(x))) < 4e-16


def test_wrapping_keeps_minus_pi_and_its_neighbours_within_the_circle() -> None:
    assert ops.wrap(-math.pi) == -math.pi
    assert ops.wrap(math.pi) == math.pi
    assert abs(ops.wrap(3.0 * math.pi)) == pytest.approx(math.pi, abs=1e-15)
    for edge in (BELOW_MINUS_PI, math.nextafter(math.pi, INF)):
        assert abs(ops.wrap(edge)) <= math.nextafter(math.pi, INF)


@given(st.floats(-1000.0, 1000.0))
@settings(deadline=None, derandomize=True)
def test_wrapping_changes_an_angle_by_whole_turns(angle: float) -> None:
    wrapped = ops.wrap(angle)
    turns = (angle - wrapped) / (2.0 * math.pi)
    assert abs(wrapped) <= math.nextafter(math.pi, INF)
    assert turns == pytest.approx(round(turns), abs=1e-12)


@given(st.floats(-1e15, 1e15))
@settings(deadline=None, derandomize=True)
def test_floor_is_the_floor(x: float) -> None:
    assert ops.floor(x) == math.floor(x)


def test_limits_let_a_nan_through_instead_of_hiding_it() -> None:
    assert math.isnan(ops.clip(NAN, -1.0, 1.0))
    assert np.isnan(ops.clip(np.array([NAN, 5.0]), -1.0, 1.0)).tolist() == [True, False]


def test_the_first_rule_that_holds_decides() -> None:
    assert ops.select(((False, 1.0), (True, 2.0), (True, 3.0)), 4.0) == 2.0
    assert ops.select(((False, 1.0),), 4.0) == 4.0
    lanes = np.array([0.0, 1.0, 2.0])
    assert ops.select(((lanes > 1.0, 10.0), (lanes > 0.0, 20.0)), np.zeros(3)).tolist() == [0.0, 20.0, 10.0]


def test_not_every_and_some_speak_for_a_boat_and_for_a_batch() -> None:
    assert ops.no(True) is False
    assert ops.no(np.array([True, False])).tolist() == [False, True]
    assert ops.every(True)
    assert ops.some(np.array([True, False]))
    assert not ops.every(np.array([True, False]))


class Pair(Struct, Generic[R], frozen=True, gc=False):
    a: R
    b: R


def swap_and_double(pair: Pair[R], factor: float) -> Pair[R]:
    return Pair(a=pair.b * factor, b=pair.a * factor)


def test_a_dear_law_runs_only_in_the_lanes_that_need_it() -> None:
    seen: list[int] = []

    def law(pair: Pair[R], factor: float) -> Pair[R]:
        seen.append(np.size(pair.a))
        return swap_and_double(pair, factor)

    a, b = np.arange(5.0), np.arange(5.0) + 10.0
    batch = ops.when(a > 2.0, law, Pair(a, b), Pair(a, b), 2.0)
    singles = [ops.when(x > 2.0, law, Pair(x, y), Pair(x, y), 2.0) for x, y in zip(a.tolist(), b.tolist(), strict=True)]
    assert seen == [2, 1, 1]
    assert batch.a.tolist() == [p.a for p in singles]
    assert batch.b.tolist() == [p.b for p in singles]


def test_a_law_that_no_lane_needs_is_not_run_and_one_that_all_need_is_run_once() -> None:
    def never(x: R) -> R:
        raise AssertionError

    x = np.arange(3.0)
    assert ops.when(x > 9.0, never, x, x) is x
    assert ops.when(x > -1.0, lambda v: v + 1.0, x, x).tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(("cond", "side"), [([True, True, True], 1.0), ([False, False, False], -1.0)])
def test_where_all_lanes_agree_they_get_that_side_whatever_its_shape(cond: list[bool], side: float) -> None:
    lanes, a, b = np.array(cond), np.full(3, 1.0), np.full(3, -1.0)
    for one, other in ((a, b), (1.0, -1.0), (a, -1.0), (1.0, b)):
        assert ops.where(lanes, one, other).tolist() == [side] * 3
    rows = ops.where(lanes, np.full((2, 3), 1.0), np.full((2, 3), -1.0))
    assert rows.tolist() == [[side] * 3] * 2


def test_what_many_ask_for_is_one_array_that_nobody_can_spoil() -> None:
    zeros = ops.zero(np.ones(4))
    with pytest.raises(ValueError, match="read-only"):
        zeros[0] = 1.0
    assert ops.full(np.ones(2), 7.0).tolist() == [7.0, 7.0]


def test_a_condition_on_which_all_lanes_agree_as_expected_is_one_bool() -> None:
    assert ops.settled(np.array([True, True]), True) is True
    assert ops.settled(np.array([False, False]), False) is False
    assert ops.settled(np.array([True, False]), True).tolist() == [True, False]
    assert ops.settled(np.array([False, False]), True).tolist() == [False, False]
    assert ops.settled(False, True) is False
    assert ops.flag(ops.settled(np.array([False, False]), False), np.ones(2)).tolist() == [0.0, 0.0]


@given(st.lists(st.tuples(st.floats(0.0, 1e9), st.floats(0.0, 1e9)), min_size=1, max_size=5))
def test_the_lesser_and_the_greater_square_are_minimum_and_maximum(pairs: list[tuple[float, float]]) -> None:
    a, b = np.array(pairs).T
    assert ops.lesser(a, b).tolist() == ops.minimum(a, b).tolist() == [ops.lesser(*p) for p in pairs]
    assert ops.greater(a, b).tolist() == ops.maximum(a, b).tolist() == [ops.greater(*p) for p in pairs]
