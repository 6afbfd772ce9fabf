"""How far from abeam a wingman wants to be where the paths come near each other."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Struct

from fleet.guidance.limits import Limits
from fleet.mission.beside import ABEAM, Beside, Room, room_beside, sail
from fleet.paths import Path, sine, straight

FAST = Limits(speed_min_mps=0.5, speed_max_mps=2.5)
NEED = 8.0


class On(Struct):
    path: Path
    s: float


LINE = On(straight((0.0, 0.0), (660.0, 0.0)), 0.0)


def curve(wavelength: float, amplitude: float = 15.0) -> On:
    return On(sine((0.0, 0.0), (660.0, 0.0), amplitude, wavelength), 0.0)


def voyage(wing: On, room: Room = ABEAM) -> list[Beside]:
    return list(sail(wing, LINE, room))


def room_of(wing: On, limits: Limits = FAST, side: float = -1.0) -> Room:
    return room_beside(voyage(wing), limits, 1.0, NEED, side)


def share_abeam(room: Room, within_m: float = 2.0) -> float:
    """Of the leader's time, from the second crossing to the last but one."""
    lasts = [(1.0 / rate, abs(value) <= within_m) for value, rate in zip(room.values, room.rates, strict=True)]
    middle = lasts[len(lasts) // 6 : -len(lasts) // 6]
    return sum(t for t, there in middle if there) / sum(t for t, _ in middle)


def test_on_a_parallel_path_far_enough_off_it_is_strictly_abeam() -> None:
    room = room_of(On(straight((0.0, 8.0), (660.0, 8.0)), 0.0))
    assert set(room.values) == {0.0}
    assert set(room.rates) == {1.0}


def test_on_a_parallel_path_of_5_m_it_is_behind_all_the_way_by_what_pythagoras_says() -> None:
    room = room_of(On(straight((0.0, 5.0), (660.0, 5.0)), 0.0))
    assert set(room.values) == {-math.sqrt(64.0 - 25.0)}


def test_where_paths_cross_every_55_m_it_is_within_2_m_of_abeam_most_of_the_time() -> None:
    assert share_abeam(room_of(curve(110.0))) > 0.5  # 0.55 if it could change its speed at once
    assert share_abeam(room_of(curve(220.0))) > 0.6  # 0.65


def test_a_slower_boat_takes_longer_to_come_up() -> None:
    slow = Limits(speed_min_mps=0.0, speed_max_mps=1.5)
    assert 0.2 < share_abeam(room_of(curve(110.0), slow)) < share_abeam(room_of(curve(110.0)))


def test_going_ahead_is_falling_back_sailed_backwards() -> None:
    behind, ahead = room_of(curve(220.0)), room_of(curve(220.0), side=1.0)
    assert min(behind.values) == pytest.approx(-NEED, abs=0.05)
    assert max(ahead.values) == pytest.approx(NEED, abs=0.05)
    assert min(ahead.values) == 0.0


@settings(max_examples=15, deadline=None)
@given(wavelength=st.floats(90.0, 300.0), amplitude=st.floats(9.0, 16.0), side=st.sampled_from([-1.0, 1.0]))
def test_in_its_place_it_is_never_too_near_and_asks_for_no_speed_that_it_has_not(
    wavelength: float, amplitude: float, side: float
) -> None:
    wing = curve(wavelength, amplitude)
    room = room_of(wing, side=side)
    for here in voyage(wing, room)[30:]:  # by then it has come from abeam, where it begins, to its place
        away = math.dist((here.own.x, here.own.y), (here.leader.x, here.leader.y))
        assert away > NEED - 0.5
    assert min(room.rates[5:-5]) >= 0.5
    assert max(room.rates[5:-5]) <= 2.5


@given(wavelength=st.floats(90.0, 300.0))
@settings(max_examples=10, deadline=None)
def test_it_changes_its_speed_no_faster_than_the_boat_can(wavelength: float) -> None:
    room = room_of(curve(wavelength))
    changes = [(b - a) / room.step * 0.5 * (a + b) for a, b in pairwise(room.rates)]  # u du/ds, leader at 1 m/s
    within = sum(abs(change) <= 0.3 for change in changes) / len(changes)
    assert within > 0.94  # but for the moments at which it begins to fall back, and short ways between crossings
    assert max(changes) <= 0.3


def test_port_and_starboard_are_mirror_images() -> None:
    assert room_of(curve(150.0)).values == pytest.approx(room_of(curve(150.0, -15.0)).values)


def test_what_it_gains_is_the_speed_of_a_lag_later() -> None:
    room = Room(0.0, 1.0, (0.0,) * 5, (1.0, 1.0, 2.0, 2.0, 2.0))
    assert room.gains(0.0, 1.0, 1.0) == 0.0
    assert room.gains(0.5, 1.0, 1.0) == pytest.approx(0.5)
    assert room.gains(0.0, 0.5, 4.0) == pytest.approx(0.5)  # of a leader at half a metre a second
    assert room.gains(3.0, 1.0, 9.0) == 0.0
    assert ABEAM.gains(1.0, 1.0, 1.0) == 0.0
