"""Thrust allocation: what is asked for is given where it can be; where not, yaw comes first."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet.guidance.thrust import Thrusters, Thrusts, allocate, limited, resultant, slew

BOAT = Thrusters()
forces, moments = st.floats(-400.0, 400.0), st.floats(-120.0, 120.0)
quick = settings(deadline=None, derandomize=True, max_examples=200)


def in_limits(t: Thrusts[float]) -> bool:
    rear = all(-BOAT.rear_astern_n <= one <= BOAT.rear_ahead_n for one in (t.rear_port, t.rear_starboard))
    return rear and all(-BOAT.side_astern_n <= one <= BOAT.side_ahead_n for one in (t.side_port, t.side_starboard))


def test_straight_ahead_is_shared_by_the_rear_pair() -> None:
    assert allocate(100.0, 0.0, BOAT) == Thrusts(50.0, 50.0, 0.0, 0.0)


def test_a_small_turn_to_starboard_is_made_by_the_side_pair_alone_port_ahead() -> None:
    assert allocate(100.0, 14.0, BOAT) == Thrusts(50.0, 50.0, 14.0, -14.0)  # 2 x 14 N x 0.5 m


def test_what_the_side_pair_cannot_turn_the_rear_pair_does() -> None:
    assert allocate(0.0, 44.0, BOAT) == Thrusts(20.0, -20.0, 28.0, -28.0)  # 28 Nm and 2 x 20 N x 0.4 m


def test_full_speed_gives_way_to_yaw() -> None:
    t = allocate(266.0, 28.0 + 32.0, BOAT)  # 40 N of each rear thruster are for the turn
    assert t == Thrusts(133.0, 53.0, 28.0, -28.0)
    assert resultant(t, BOAT) == (186.0, 60.0)


@given(forces, moments)
@quick
def test_the_thrusts_are_within_their_limits(surge: float, yaw: float) -> None:
    t = allocate(surge, yaw, BOAT)
    for field in Thrusts.__struct_fields__:
        assert getattr(limited(t, BOAT), field) == pytest.approx(getattr(t, field))
    assert in_limits(limited(t, BOAT))


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
@quick
def test_a_feasible_force_and_moment_are_given_exactly(share: float, part: float) -> None:
    yaw = part * BOAT.moment_max
    half = max(abs(yaw) - BOAT.side_moment_max, 0.0) * 0.5 / BOAT.rear_arm_m
    surge = 2.0 * share * (BOAT.rear_ahead_n - half if share > 0.0 else BOAT.rear_astern_n - half)
    assert resultant(allocate(surge, yaw, BOAT), BOAT) == pytest.approx((surge, yaw), abs=1e-9)


@given(forces, moments)
@quick
def test_the_moment_is_kept_whatever_force_is_asked_for(surge: float, yaw: float) -> None:
    given_yaw = resultant(allocate(surge, yaw, BOAT), BOAT)[1]
    assert given_yaw == pytest.approx(max(-BOAT.moment_max, min(yaw, BOAT.moment_max)), abs=1e-9)


@given(forces, moments)
@quick
def test_a_force_is_cut_and_never_turned_round_or_made_larger(surge: float, yaw: float) -> None:
    force = resultant(allocate(surge, yaw, BOAT), BOAT)[0]
    assert abs(force) <= abs(surge) + 1e-9
    assert force * surge >= 0.0


@given(forces, moments)
@quick
def test_port_mirrors_starboard(surge: float, yaw: float) -> None:
    a, b = allocate(surge, yaw, BOAT), allocate(surge, -yaw, BOAT)
    assert (a.rear_port, a.rear_starboard, a.side_port, a.side_starboard) == (
        b.rear_starboard,
        b.rear_port,
        b.side_starboard,
        b.side_port,
    )


def test_a_lane_gets_the_bits_of_a_boat() -> None:
    rng = np.random.default_rng(7)
    surge, yaw = rng.uniform(-400.0, 400.0, 500), rng.uniform(-120.0, 120.0, 500)
    now = Thrusts(*rng.uniform(-60.0, 60.0, (4, 500)))
    batch = slew(now, limited(allocate(surge, yaw, BOAT), BOAT), BOAT, 0.02)
    columns = [Thrusts(*column) for column in np.array([getattr(now, f) for f in Thrusts.__struct_fields__]).T.tolist()]
    singly = [
        slew(before, limited(allocate(x, n, BOAT), BOAT), BOAT, 0.02)
        for before, x, n in zip(columns, surge.tolist(), yaw.tolist(), strict=True)
    ]
    for field in Thrusts.__struct_fields__:
        assert getattr(batch, field).tolist() == [getattr(one, field) for one in singly]


def test_thrust_comes_and_goes_at_its_rate() -> None:
    t = slew(Thrusts(0.0, 0.0, 0.0, 0.0), Thrusts(133.0, -66.0, 1.0, -28.0), BOAT, 0.1)
    assert (t.rear_port, t.rear_starboard, t.side_port, t.side_starboard) == pytest.approx((13.0, -13.0, 1.0, -11.0))


def test_without_side_thrusters_the_rear_pair_does_it_all() -> None:
    bare = Thrusters(side_ahead_n=0.0, side_astern_n=0.0)
    assert allocate(60.0, 16.0, bare) == Thrusts(50.0, 10.0, 0.0, 0.0)
