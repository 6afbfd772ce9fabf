"""Position fusion: what is known from GNSS, heading and yaw rate, how well, and what is lost with each of them."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from fleet import ops
from fleet.sensing.fusion import NOTHING, Fused, Sensors, fuse, known
from fleet.wire.radio import uniform

DT, NAN = 0.1, math.nan
NO_FIX = {"x": NAN, "y": NAN, "vx": NAN, "vy": NAN}


def truth(t: float, u: float = 1.0, r: float = 0.0) -> Sensors:
    """A boat that goes north, or round a circle to starboard, as perfect sensors see it."""
    psi = r * t
    x, y = (u * t, 0.0) if r == 0.0 else (u / r * math.sin(psi), u / r * (1.0 - math.cos(psi)))
    return Sensors(x, y, 0.5, u * math.cos(psi), u * math.sin(psi), 0.05, 0.0, ops.wrap(psi), 0.02, 0.0, r, 0.0)


def after(seconds: float, spoil: Callable[[float, Sensors], Sensors] = lambda t, s: s, **way: float) -> Fused:
    fused = NOTHING
    for k in range(round(seconds / DT)):
        t = k * DT
        fused = fuse(fused, spoil(t, truth(t, **way)), DT)
    return fused


def normal(*parts: int) -> float:
    return math.sqrt(-2.0 * math.log(1.0 - uniform(*parts, 0))) * math.cos(2.0 * math.pi * uniform(*parts, 1))


def noisy(t: float, s: Sensors) -> Sensors:
    k = round(t / DT)
    return replace(
        s,
        x=s.x + 0.5 * normal(k, 1),
        y=s.y + 0.5 * normal(k, 2),
        vx=s.vx + 0.05 * normal(k, 3),
        vy=s.vy + 0.05 * normal(k, 4),
        psi=s.psi + 0.02 * normal(k, 5),
        r=s.r + 0.005 * normal(k, 6),
    )


def test_before_the_first_fix_nothing_is_known_and_after_it_everything() -> None:
    assert not known(NOTHING)
    first = fuse(NOTHING, truth(0.0), DT)
    assert known(first)
    assert (first.x, first.vx, first.psi) == (0.0, 1.0, 0.0)
    assert not known(fuse(NOTHING, replace(truth(0.0), **NO_FIX), DT))


def test_perfect_sensors_give_the_truth_on_a_circle() -> None:
    fused, there = after(60.0, r=0.1), truth(59.9, r=0.1)
    assert (fused.x, fused.y) == pytest.approx((there.x, there.y), abs=0.02)
    assert fused.psi == pytest.approx(there.psi, abs=0.002)


def test_the_slow_error_of_fixes_is_learnt_from_the_way_sailed_and_the_filter_knows_how_well() -> None:
    def drifting(run: int) -> Callable[[float, Sensors], Sensors]:
        error = {"x": 0.5 * normal(run, 7), "y": 0.5 * normal(run, 8)}

        def spoil(t: float, s: Sensors) -> Sensors:
            k, keep = round(t / DT), 1.0 - DT / 60.0
            kick = 0.5 * math.sqrt(1.0 - keep * keep)
            error["x"] = keep * error["x"] + kick * normal(run, k, 10)
            error["y"] = keep * error["y"] + kick * normal(run, k, 11)
            shaken = noisy(t, s)
            return replace(
                shaken,
                x=s.x + error["x"] + 0.05 * normal(run, k, 12),
                y=s.y + error["y"] + 0.05 * normal(run, k, 13),
                vx=s.vx + 0.05 * normal(run, k, 14),
                vy=s.vy + 0.05 * normal(run, k, 15),
            )

        return spoil

    there = truth(59.9, r=0.05)
    ends = [after(60.0, drifting(run), r=0.05) for run in range(40)]
    off = math.sqrt(sum((f.x - there.x) ** 2 + (f.y - there.y) ** 2 for f in ends) / 80.0)
    assert ends[0].sigma == pytest.approx(0.5 / math.sqrt(1.0 + 60.0 / 120.0), rel=0.05)
    assert 0.75 < off / ends[0].sigma < 1.25


def test_an_old_fix_is_where_the_boat_was_and_is_carried_on() -> None:
    fused = after(30.0, lambda t, s: replace(s, x=s.x - 0.2 * s.vx, y=s.y - 0.2 * s.vy, fix_age=0.2))
    assert fused.x == pytest.approx(29.9, abs=0.02)


def test_a_fix_older_than_half_a_second_is_none() -> None:
    assert not known(after(5.0, lambda t, s: replace(s, fix_age=0.6)))


# -- outliers ----------------------------------------------------------------------------------------------------------
def test_one_wild_fix_moves_nothing_and_is_counted() -> None:
    fused = after(20.0, lambda t, s: replace(s, x=s.x + 80.0) if abs(t - 15.0) < 0.01 else s)
    clean = after(20.0)
    assert fused.outliers == 1.0
    assert fused.x == pytest.approx(clean.x, abs=0.05)


def test_fixes_that_stay_elsewhere_are_believed_after_three_seconds() -> None:
    def moved(t: float, s: Sensors) -> Sensors:
        return replace(s, x=s.x + 80.0) if t >= 10.0 else s

    assert after(12.5, moved).x == pytest.approx(12.4, abs=1.0)
    assert after(14.0, moved).x == pytest.approx(13.9 + 80.0, abs=1.0)


def test_a_compass_that_jumps_for_a_moment_is_not_followed() -> None:
    fused = after(20.0, lambda t, s: replace(s, psi=2.0) if 15.0 <= t < 15.5 else s)
    assert fused.psi == pytest.approx(0.0, abs=0.01)
    assert fused.outliers == 5.0


# -- what is lost ------------------------------------------------------------------------------------------------------
def test_without_gnss_the_boat_reckons_round_the_bend_surer_at_first_and_then_knows_nothing() -> None:
    def lost(t: float, s: Sensors) -> Sensors:
        return replace(s, **NO_FIX) if t >= 30.0 else s

    soon, late = after(35.0, lost, r=0.1), after(39.0, lost, r=0.1)
    there = truth(34.9, r=0.1)
    assert math.hypot(soon.x - there.x, soon.y - there.y) < 0.1
    assert known(soon)
    assert 0.4 < soon.sigma < late.sigma
    assert not known(after(41.0, lost, r=0.1))
    assert known(after(50.0, lambda t, s: lost(t, s) if t < 45.0 else s, r=0.1))


def test_without_compass_the_yaw_rate_carries_the_heading_and_the_course_corrects_it() -> None:
    def lost(t: float, s: Sensors) -> Sensors:
        return (
            replace(s, psi=NAN, r=s.r + 0.01) if t >= 20.0 else s
        )  # and the gyro has a bias of half a degree a second

    fused = after(120.0, lost)
    assert known(fused)
    assert fused.psi == pytest.approx(0.0, abs=0.15)  # on the gyro alone it would be off by 1 rad


def test_without_compass_a_boat_that_never_moved_has_no_heading() -> None:
    fused = after(30.0, lambda t, s: replace(s, psi=NAN), u=0.0)
    assert not known(fused)
    moving = after(30.0, lambda t, s: replace(s, psi=NAN), u=0.5)
    assert known(moving)
    assert moving.psi == pytest.approx(0.0, abs=0.05)


def test_below_three_tenths_of_a_metre_a_second_the_course_is_no_heading() -> None:
    fused = after(300.0, lambda t, s: replace(s, psi=NAN, r=NAN) if t >= 10.0 else s, u=0.2)
    assert not known(fused)


def test_without_gyro_the_yaw_rate_comes_from_headings_with_a_lag() -> None:
    def lost(t: float, s: Sensors) -> Sensors:
        return replace(s, r=NAN) if t >= 10.0 else s

    assert after(20.0, lost, r=0.1).r == pytest.approx(0.1, abs=0.005)
    assert after(10.3, lost, r=0.1).r == pytest.approx(0.1, abs=0.02)  # half a second on the last value


def test_with_nothing_but_a_fix_a_boat_under_way_still_knows_itself() -> None:
    fused = after(60.0, lambda t, s: replace(s, psi=NAN, r=NAN), r=0.05)
    there = truth(59.9, r=0.05)
    assert known(fused)
    assert math.hypot(fused.x - there.x, fused.y - there.y) < 0.5
    assert abs(ops.wrap(fused.psi - there.psi)) < 0.4


finite = st.floats(-1e3, 1e3)
anything = finite | st.just(NAN)


@given(st.lists(st.tuples(anything, anything, anything, anything, anything, st.floats(0.0, 2.0)), max_size=30))
def test_whatever_the_sensors_say_the_filter_stays_finite_or_unknown(
    told: list[tuple[float, float, float, float, float, float]],
) -> None:
    fused = NOTHING
    for x, y, vx, psi, r, age in told:
        fused = fuse(fused, Sensors(x, y, 1.0, vx, 0.0, 0.1, age, psi, 0.02, age, r, age), DT)
        if known(fused):
            assert math.isfinite(fused.x + fused.y + fused.vx + fused.vy + fused.psi + fused.r + fused.sigma)
            assert fused.cov.xx >= 0.0
            assert fused.cov.vv >= 0.0


@given(st.floats(-math.pi, math.pi))
def test_turning_the_whole_scene_turns_the_answer(angle: float) -> None:
    def turned(t: float, s: Sensors) -> Sensors:
        c, k = math.cos(angle), math.sin(angle)
        s = noisy(t, s)
        return replace(
            s, x=c * s.x - k * s.y, y=k * s.x + c * s.y, vx=c * s.vx - k * s.vy, vy=k * s.vx + c * s.vy,
            psi=ops.wrap(s.psi + angle),
        )  # fmt: skip

    plain, other = after(5.0, noisy), after(5.0, turned)
    c, k = math.cos(angle), math.sin(angle)
    assert (other.x, other.y) == pytest.approx((c * plain.x - k * plain.y, k * plain.x + c * plain.y), abs=1e-9)
    assert abs(ops.wrap(other.psi - plain.psi - angle)) < 1e-9


def once_a_second(t: float, s: Sensors) -> Sensors:
    """A compass and a receiver that tell once a second, a boat's cheapest; no gyro."""
    told = round(t / DT) % 10 == 0
    return replace(s, r=NAN) if told else replace(s, **NO_FIX, psi=NAN, r=NAN)


def test_a_compass_that_tells_once_a_second_gives_the_yaw_rate_of_a_steady_turn() -> None:
    fused = after(20.0, once_a_second, r=0.2)
    assert fused.r == pytest.approx(0.2, abs=0.01)
    assert ops.wrap(fused.psi - 0.2 * 19.9) == pytest.approx(0.0, abs=0.03)


def test_the_same_heading_said_again_is_not_a_boat_that_stopped_turning() -> None:
    def again(t: float, s: Sensors) -> Sensors:
        age = t % 0.3
        return replace(s, psi=0.2 * (t - age), psi_age=age, r=NAN)

    assert after(10.0, again, r=0.2).r == pytest.approx(0.2, abs=0.01)


def test_without_headings_the_boat_is_soon_taken_to_turn_no_more() -> None:
    fused = after(10.0, lambda t, s: replace(s, r=NAN, psi=NAN if t > 5.0 else s.psi), r=0.2)
    assert abs(fused.r) < 0.01
