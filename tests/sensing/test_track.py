"""Tracks of foreign vessels: worked by hand where that is possible, else against vessels that are known."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.sensing import Track, TrackParams, begin, lost, predict, seen, update_ais, update_position
from fleet.wire.radio import uniform

P = TrackParams()


def north(speed: float = 2.0) -> Track:
    """An AIS track of a vessel that sails north from the origin at t = 100 s."""
    return begin(7.0, 0.0, 0.0, 2.0, 100.0, 20.0, (speed, 0.0))


def sailed(
    seconds: float, every: float, sigma: float, turn_at: float = math.inf, rate: float = 0.0, params: TrackParams = P
) -> Track:
    """A track of a vessel at 4 m/s from bare positions with noise."""
    x = y = chi = t = 0.0
    track = begin(1.0, 0.0, 0.0, sigma, 0.0, 20.0)
    k = 0
    while t < seconds:
        k += 1
        x, y, t = x + every * 4.0 * math.cos(chi), y + every * 4.0 * math.sin(chi), t + every
        chi += rate * every if t > turn_at else 0.0
        noise = [sigma * (sum(uniform(k, axis, n) for n in range(12)) - 6.0) for axis in (1, 2)]
        track = update_position(track, x + noise[0], y + noise[1], sigma, t, params)
    return track


def test_dead_reckoning_goes_straight_on_and_knows_less() -> None:
    there = predict(north(), 110.0)
    assert (there.x, there.y, there.vx, there.vy) == (20.0, 0.0, 2.0, 0.0)
    # P11 = 4 + h^2 0.15^2 + q h^3 / 3, P12 = h 0.15^2 + q h^2 / 2, P22 = 0.15^2 + q h with h = 10
    assert pytest.approx(4.0 + 2.25 + 1.0 / 3.0) == there.P11
    assert pytest.approx(0.225 + 0.05) == there.P12
    assert pytest.approx(0.0225 + 0.01) == there.P22


def test_two_positions_give_the_velocity_between_them() -> None:
    track = begin(1.0, 0.0, 0.0, 1.0, 0.0, 10.0)
    track = update_position(track, 30.0, 40.0, 1.0, 10.0)
    gain = track.vx / 30.0
    # by hand: P11 = 1 + 900 + 1/3, P12 = 90 + 0.05, gain of the velocity P12 / (P11 + 1)
    assert gain == pytest.approx(90.05 / (902.0 + 1.0 / 3.0), rel=1e-9)
    assert track.vy == pytest.approx(40.0 * gain)


@given(st.floats(0.1, 20.0), st.floats(0.1, 20.0))
def test_predicting_in_two_steps_is_predicting_in_one(a: float, b: float) -> None:
    one, two = predict(north(), 100.0 + a + b), predict(predict(north(), 100.0 + a), 100.0 + a + b)
    for name in ("x", "y", "P11", "P12", "P22"):
        assert getattr(two, name) == pytest.approx(getattr(one, name), rel=1e-9)


def test_late_data_do_not_turn_time_back() -> None:
    track = update_position(north(), 0.0, 0.0, 2.0, 90.0)
    assert track.t == 100.0


def test_a_steady_vessel_is_known_to_a_tenth_of_a_metre_per_second_within_half_a_minute() -> None:
    track = sailed(30.0, 0.5, 2.0)
    assert abs(track.vx - 4.0) < 0.3
    assert abs(track.vy) < 0.3
    assert track.P22 < 0.2 * 0.2
    assert seen(track, 30.0).om == 0.0


def test_ais_that_tells_another_velocity_is_believed_at_once() -> None:
    track = north()
    for k in range(1, 6):
        track = update_ais(track, 2.0 * k, 0.0, 2.0, 2.0, 0.0, 100.0 + k)
    turned = update_ais(track, 10.0, 2.0, 2.0, 0.0, 2.0, 106.0)
    assert math.hypot(turned.vx, turned.vy - 2.0) < 0.15
    assert turned.alert == 106.0 + P.alert_s
    steady = update_ais(track, 12.0, 0.0, 2.0, 2.0, 0.0, 106.0)
    assert steady.alert == track.alert


def test_a_turn_is_noticed_by_positions_alone() -> None:
    turning, steady = sailed(50.0, 0.5, 1.0, 40.0, 0.08), sailed(50.0, 0.5, 1.0)
    assert turning.alert > 40.0
    assert steady.alert == 0.0
    assert seen(turning, 50.0).om > 0.03
    course = math.atan2(turning.vy, turning.vx)
    assert abs(course - 0.8) < 0.35


def test_a_turn_is_noticed_in_poor_positions_before_the_track_is_ten_metres_off() -> None:
    # 3 m of noise once a second hide one innovation, but not the mean of some: 0.06 rad/s for 10 s at 4 m/s are 11 m
    turning, steady = sailed(70.0, 1.0, 3.0, 60.0, 0.06), sailed(400.0, 1.0, 3.0)
    assert 60.0 < turning.alert - P.alert_s <= 70.0
    assert steady.alert == 0.0
    deaf = TrackParams(drift_most=1.0e9)
    assert sailed(70.0, 1.0, 3.0, 60.0, 0.06, deaf).alert == 0.0  # by single innovations it is not noticed so soon


def test_a_turn_rate_is_not_trusted_when_the_track_is_young_or_the_data_are_old() -> None:
    young, old = sailed(11.0, 0.5, 1.0, 3.0, 0.08), sailed(50.0, 0.5, 1.0, 40.0, 0.08)
    assert abs(young.om) > P.om_least
    assert seen(young, 11.0).om == 0.0
    assert seen(old, 50.0).om != 0.0
    assert seen(old, 57.0).om == 0.0


def test_a_bare_position_is_usable_after_six_seconds_an_ais_report_at_once() -> None:
    bare = begin(1.0, 0.0, 0.0, 2.0, 0.0, 10.0)
    assert seen(bare, 5.9).usable == 0.0
    assert seen(bare, 6.0).usable == 1.0
    assert seen(north(), 100.0).usable == 1.0


def test_a_vessel_is_kept_for_two_minutes_without_data() -> None:
    assert not lost(north(), 220.0)
    assert lost(north(), 220.1)
    assert seen(north(), 200.0).x == 200.0
    assert seen(north(), 200.0).age == 100.0


@given(st.floats(-math.pi, math.pi))
def test_turning_the_scene_turns_the_track(angle: float) -> None:
    c, s = math.cos(angle), math.sin(angle)

    def last(c: float, s: float) -> Track:
        track = begin(1.0, 0.0, 0.0, 1.0, 0.0, 10.0)
        for k in range(1, 8):
            x, y = 3.0 * k, 0.3 * k * k
            track = update_position(track, c * x - s * y, s * x + c * y, 1.0, float(k))
        return track

    straight, turned = last(1.0, 0.0), last(c, s)
    assert turned.x == pytest.approx(c * straight.x - s * straight.y, abs=1e-8)
    assert turned.vy == pytest.approx(s * straight.vx + c * straight.vy, abs=1e-8)
    assert turned.om == pytest.approx(straight.om, abs=1e-8)
