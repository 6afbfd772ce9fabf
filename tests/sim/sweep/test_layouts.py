"""Where boats begin and what they are told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fleet.agent.modes import Goal
from fleet.guidance.limits import Limits
from fleet.sim.batch import Scenarios, run
from fleet.sim.sweep.anywhere import escapable
from fleet.sim.sweep.family import load, loads
from fleet.sim.sweep.layouts import circle_radius, nearest
from fleet.sim.sweep.merging import BEND_M
from fleet.sim.world import LEEWAY

CASES = range(40)


def drawn(name: str, *overrides: str, boats: int | None = None, point: int = 0) -> Scenarios:
    return load(name, overrides, boats=boats).scenarios(9, point, CASES)


def at(scenarios: Scenarios, row: int, boat: int, s: float) -> Any:
    return scenarios.paths[int(scenarios.path[row, boat])].at(s)


def test_boats_of_a_meeting_would_be_at_one_point_at_one_time() -> None:
    scenarios = drawn("four", "layout.late_s=0", "layout.aside_m=0")
    x = scenarios.x + 70.0 * scenarios.cruise * np.cos(scenarios.psi)
    y = scenarios.y + 70.0 * scenarios.cruise * np.sin(scenarios.psi)
    assert np.abs(x).max() < 1e-9
    assert np.abs(y).max() < 1e-9
    assert nearest(scenarios.x, scenarios.y).min() > 20.0
    assert np.allclose(scenarios.goal_m, 140.0 * scenarios.cruise)


def test_late_and_aside_are_seconds_and_metres_off_the_point() -> None:
    scenarios = drawn("two-boat", "layout.late_s=2", "layout.aside_m=3", "layout.cruise_mps=1.2")
    c, s = np.cos(scenarios.psi), np.sin(scenarios.psi)
    assert np.allclose(scenarios.x * c + scenarios.y * s, -72.0 * 1.2)
    assert np.allclose(scenarios.y * c - scenarios.x * s, 3.0)  # to starboard


@pytest.mark.parametrize(
    ("name", "low", "high"), [("head-on", 170, 190), ("crossing-pair", 30, 150), ("overtaking-pair", -15, 15)]
)
def test_courses_of_a_pair_differ_as_the_family_says(name: str, low: float, high: float) -> None:
    scenarios = drawn(name)
    middle = 0.5 * (low + high)
    difference = np.degrees(scenarios.psi[:, 1] - scenarios.psi[:, 0])
    off = (difference - middle + 180.0) % 360.0 - 180.0
    assert np.abs(off).max() <= 0.5 * (high - low)
    assert np.abs(off).max() > 0.4 * (high - low)
    assert np.std(scenarios.psi[:, 0]) > 1.0  # the scene as a whole points anywhere


def test_an_overtaking_boat_is_clearly_faster() -> None:
    scenarios = drawn("overtaking-pair")
    assert np.abs(scenarios.cruise[:, 0] - scenarios.cruise[:, 1]).min() > 0.05
    ahead = (scenarios.x[:, 1] - scenarios.x[:, 0]) * np.cos(scenarios.psi[:, 0]) + (
        scenarios.y[:, 1] - scenarios.y[:, 0]
    ) * np.sin(scenarios.psi[:, 0])
    assert (np.sign(ahead) == np.sign(scenarios.cruise[:, 0] - scenarios.cruise[:, 1])).mean() > 0.9


def test_the_radius_of_a_circle_goes_by_the_number_of_boats() -> None:
    assert [circle_radius(boats) for boats in (2, 4, 5, 8, 12, 16, 24, 32)] == [40, 40, 50, 50, 54, 70, 108, 144]


def test_an_exact_circle_is_the_same_from_every_boat() -> None:
    family = load("antipodal-exact")
    for point in family.points:
        scenarios = family.scenarios(1, point, [0])
        boats = scenarios.boats
        assert np.allclose(np.hypot(scenarios.x, scenarios.y), circle_radius(boats))
        turn = 2.0 * np.pi / boats
        c, s = np.cos(turn), np.sin(turn)
        x, y = scenarios.x * c - scenarios.y * s, scenarios.x * s + scenarios.y * c
        assert np.allclose(x[0], np.roll(scenarios.x[0], -1))
        assert np.allclose(y[0], np.roll(scenarios.y[0], -1))
        ends = [at(scenarios, 0, boat, scenarios.goal_m[0, boat]) for boat in range(boats)]
        assert np.allclose([p.x for p in ends], -scenarios.x[0])
        assert np.allclose([p.y for p in ends], -scenarios.y[0])


def test_a_column_leads_with_its_first_boat_and_is_told_its_timeline() -> None:
    scenarios = drawn("swap", boats=3)
    spacing = scenarios.offset[:, 1]
    assert np.allclose(scenarios.offset, spacing[:, None] * [2.0, 1.0, 0.0])
    assert np.abs(scenarios.s - scenarios.offset).max() <= 4.0
    (change,) = scenarios.changes
    assert np.array_equal(change.offset, -scenarios.offset)
    assert change.at_s.tolist() == [30.0] * 40
    assert (scenarios.member == 1.0).all()
    assert scenarios.u_min[0, 0] == 0.7


def test_orders_of_a_timeline_add_up_and_come_in_time() -> None:
    text, perfect = load("lossy").text, ["radio.loss=0", "radio.delay_s=0"]
    later = '\n[[timeline]]\nat_s = 150.0\ndo = "hold"\n\n[[timeline]]\nat_s = 160.0\ndo = "resume"\n'
    slower = '\n[[timeline]]\nat_s = 50.0\ndo = "set speed"\ntimes = 0.9\n'
    changes = loads(text + later + slower, "f", perfect).scenarios(1, 0, [0]).changes
    assert [float(change.at_s[0]) for change in changes] == [50.0, 100.0, 150.0, 160.0, 200.0]
    assert [float(change.offset[0, 0]) for change in changes] == [60.0, 80.0, 80.0, 80.0, 60.0]
    assert {float(change.cruise[0, 0]) for change in changes} == {0.9}
    assert [Goal(int(change.goal[0, 0])).name for change in changes] == ["FOLLOW", "FOLLOW", "HOLD", "FOLLOW", "FOLLOW"]


@pytest.mark.parametrize("angle", [0.0, 5.0, 30.0, 80.0])
def test_merging_paths_are_lanes_and_have_one_abscissa_at_the_bend(angle: float) -> None:
    scenarios = drawn("merging", f"layout.angle_deg={angle}", "layout.across_m=0", boats=3)
    for boat, lane in enumerate((-8.0, 0.0, 8.0)):
        path = scenarios.paths[int(scenarios.path[0, boat])]
        beyond = path.at(BEND_M + 60.0)
        assert (beyond.x, beyond.y) == (pytest.approx(60.0, abs=1e-3), pytest.approx(lane))
        begin = path.at(float(scenarios.s[0, boat]))
        assert begin.x == pytest.approx(scenarios.x[0, boat], abs=1e-6)
        assert begin.y == pytest.approx(scenarios.y[0, boat], abs=1e-6)
        assert np.arctan2(begin.ty, begin.tx) == pytest.approx(scenarios.psi[0, boat])
        assert np.degrees(scenarios.psi[0, boat]) == pytest.approx(-np.sign(lane) * angle)


def test_boats_of_a_merging_without_a_formation_reach_the_bend_together_rank_by_rank() -> None:
    scenarios = drawn("merging", "layout.late_s=0", "layout.cruise_mps=1.1", "layout.paths=2", boats=4)
    time_s = (BEND_M - scenarios.s) / scenarios.cruise
    assert np.allclose(time_s[:, :2], 70.0)
    assert np.allclose((time_s[:, 2:] - 70.0) * scenarios.cruise[:, 2:], 15.0)
    assert np.array_equal(scenarios.path[:, 0], scenarios.path[:, 2])
    assert np.allclose(scenarios.goal_m, BEND_M + 100.0)


def test_boats_that_merge_into_one_column_begin_at_their_places() -> None:
    scenarios = drawn("merging-one", "layout.late_s=0", boats=3)
    places = scenarios.s - scenarios.offset
    assert np.allclose(places, places[:, :1])
    assert np.allclose(scenarios.offset, [30.0, 15.0, 0.0])
    ends = [at(scenarios, 0, boat, BEND_M + 200.0) for boat in range(3)]
    assert np.allclose([p.y for p in ends], 0.0)


def track(scenarios: Scenarios, row: int, boat: int, t: np.ndarray) -> np.ndarray:
    """(2, time) where a boat would be with nobody in the way."""
    points = [at(scenarios, row, boat, s) for s in (scenarios.s[row, boat] + scenarios.cruise[row, boat] * t).tolist()]
    return np.array([[p.x for p in points], [p.y for p in points]])


def test_boats_anywhere_would_each_meet_one_of_those_before_it() -> None:
    scenarios = drawn("fleet", "layout.late_s=0", "layout.aside_m=0", point=6)
    t = np.arange(0.0, 85.0, 0.5)
    for row in range(8):
        tracks = [track(scenarios, row, boat, t) for boat in range(8)]
        for boat in range(1, 8):
            near = [np.hypot(*(tracks[boat] - other)) for other in tracks[:boat]]
            assert min(d[t >= 20.0].min() for d in near) < 0.25 * 3.0 + 0.05  # half a time step of both


def test_boats_anywhere_begin_apart_on_their_paths_and_some_paths_bend() -> None:
    scenarios = drawn("fleet", point=6)
    assert nearest(scenarios.x, scenarios.y).min() > 12.0
    assert escapable(scenarios.x, scenarios.y, scenarios.psi, scenarios.u, scenarios.limits).all()
    bent = 0
    for boat in range(8):
        begin, end = at(scenarios, 3, boat, 0.0), at(scenarios, 3, boat, scenarios.goal_m[3, boat])
        assert (begin.x, begin.y) == (pytest.approx(scenarios.x[3, boat]), pytest.approx(scenarios.y[3, boat]))
        assert np.arctan2(begin.ty, begin.tx) == pytest.approx(scenarios.psi[3, boat])
        turn = np.degrees(np.arctan2(begin.tx * end.ty - begin.ty * end.tx, begin.tx * end.tx + begin.ty * end.ty))
        assert min(abs(turn - angle) for angle in (-90, -45, 0, 45, 90)) < 0.1
        bent += abs(turn) > 1.0
    assert 0 < bent < 8


def test_two_boats_bow_to_bow_escape_only_where_both_can_stop() -> None:
    """1.5 m/s stops within 1.5 (2.5 + 1) = 5.25 m: two of them need 12.9 m, and 2.4 m of hull is in it."""
    psi, u = np.array([[0.0, np.pi]]), np.array([[1.5, 1.5]])
    for gap, clear in ((12.8, False), (13.0, True)):
        assert escapable(np.array([[0.0, gap]]), np.zeros((1, 2)), psi, u, Limits()).tolist() == [clear]


def test_two_formations_would_meet_with_their_middles() -> None:
    scenarios = drawn(
        "meeting", "layout.late_s=0", "layout.aside_m=0", "layout.along_m=0", "layout.across_m=0", point=1
    )
    assert scenarios.member.tolist() == [[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]] * 40
    shapes = set()
    for row in range(40):
        for group in (slice(0, 3), slice(3, 6)):
            assert np.ptp(scenarios.cruise[row, group]) == 0.0
            assert np.ptp(scenarios.psi[row, group]) == 0.0
            ends = np.array([track(scenarios, row, boat, np.array([100.0]))[:, 0] for boat in range(6)[group]])
            assert np.allclose(ends.mean(axis=0), 0.0, atol=1e-9)
            assert np.allclose(scenarios.s[row, group] - scenarios.offset[row, group], 500.0)
            shapes.add(bool(np.ptp(scenarios.offset[row, group]) == 0.0))
            apart = np.hypot(*(ends[0] - ends[1]))
            assert apart == pytest.approx(16.0 if shapes and np.ptp(scenarios.offset[row, group]) == 0.0 else apart)
    assert shapes == {True, False}


def test_boats_of_a_circuit_begin_apart_and_on_the_lap_nearest_to_their_slots() -> None:
    scenarios = drawn("circuit", point=2)
    lap = scenarios.paths[0].length
    along = np.sort(scenarios.s % lap, axis=1)
    assert np.diff(along, axis=1).min() >= 10.0 - 1e-9
    assert (along[:, 0] + lap - along[:, -1]).min() >= 10.0 - 1e-9
    off = (scenarios.s - scenarios.offset) - (scenarios.s - scenarios.offset)[:, -1:]
    assert np.abs(off).max() <= 0.5 * lap
    assert (scenarios.u == 0.0).all()
    assert len({tuple(np.argsort(row)) for row in (scenarios.s % lap).tolist()}) > 30  # in any order


# around them and among them


def test_water_comes_from_where_it_is_said() -> None:
    scenarios = drawn(
        "two-boat",
        "environment.current_mps=0.2",
        "environment.current_toward_deg=90",
        "environment.wind_mps=10",
        "environment.wind_from_deg=0",
    )
    assert np.allclose(scenarios.current_n, 0.0)
    assert np.allclose(scenarios.current_e, 0.2)
    assert np.allclose(scenarios.wind_n, -10.0 * LEEWAY)  # a north wind sets to the south
    assert np.allclose(scenarios.wind_e, 0.0)


def test_radio_hull_and_sensors_reach_the_scenarios() -> None:
    scenarios = drawn("noisy", "hull=otter", "radio.loss={even=[0, 1]}", "limits.speed_max_mps=1.6")
    assert (scenarios.hulls, scenarios.gnss_sigma_m, scenarios.gnss_white_m) == (("otter",), 1.5, 0.1)
    assert scenarios.limits.speed_max_mps == 1.6
    assert len(set(scenarios.loss.tolist())) == 40


def test_each_boat_has_one_of_the_hulls_and_nothing_else_changes() -> None:
    mixed, plain = drawn("fleet", point=6), drawn("fleet", "hulls=[]", point=6)
    assert (mixed.hulls, plain.hulls) == (("unicycle", "otter"), ("unicycle",))
    assert 0.4 < mixed.hull.mean() < 0.6
    assert set(mixed.hull.ravel()) == {0.0, 1.0}
    assert np.array_equal(mixed.x, plain.x)
    assert np.array_equal(mixed.current_n, plain.current_n)
    assert mixed.gnss_velocity_mps == 0.05


def test_boats_in_trouble_are_those_named_and_the_others_draw_the_same() -> None:
    plain = drawn("four")
    deaf = drawn("not-avoiding-4")
    assert deaf.avoids.tolist() == [[0.0, 1.0, 1.0, 1.0]] * 40
    assert np.array_equal(deaf.x, plain.x)
    mute = drawn("four", "trouble.mute=[2, 4]", "trouble.mute_at_s={even=[10, 60]}")
    assert np.isinf(mute.mute_s[:, [0, 2]]).all()
    assert (mute.mute_s[:, [1, 3]] >= 10.0).all()
    assert (mute.mute_s[:, [1, 3]] < 60.0).all()


def test_a_stopped_boat_lies_near_the_point_and_has_nowhere_to_go() -> None:
    scenarios = drawn("stopped")
    assert np.hypot(scenarios.x[:, 2], scenarios.y[:, 2]).max() <= np.hypot(5.0, 5.0)
    assert (scenarios.u[:, 2] == 0.0).all()
    assert (scenarios.goal[:, 2] == float(Goal.NEUTRAL)).all()
    assert np.isinf(scenarios.nominal_s[:, 2]).all()
    assert np.isfinite(scenarios.nominal_s[:, :2]).all()
    assert (scenarios.u[:, :2] > 0.0).all()


def test_a_wingman_begins_in_its_place_beside_its_leader() -> None:
    scenarios = drawn("wingman", "layout.along_m=0", "layout.across_m=0", point=1)
    for row in range(0, len(CASES), 8):
        room = scenarios.rooms[int(scenarios.room[row, 1])]
        wanted, _ = room.at(float(scenarios.s[row, 1]))
        assert scenarios.x[row, 1] - scenarios.x[row, 0] == pytest.approx(wanted, abs=0.6)
    assert set(scenarios.leader[:, 1]) == {0.0}
    assert nearest(scenarios.x, scenarios.y).min() > 7.4


def test_a_wingman_of_a_sweep_stays_beside_its_leader_and_is_counted_against_abeam() -> None:
    family = load("wingman", ["duration_s=75", "measure_from_s=15", "layout.phase_m=40"])
    results = run(family.scenarios(3, 1, [0]), record=(0,), **family.run_options(1))
    trace = results.traces[0]
    ahead = trace.x[:, 1] - trace.x[:, 0]
    far = float(np.mean(np.abs(ahead[150:]) >= 2.0))
    assert results.off_place[0, 1] == pytest.approx(far, abs=0.02)
    assert 0.2 < far < 0.7  # it falls back for a crossing in that time
    assert results.off_place[0, 0] == -1.0  # its leader keeps no place
    assert results.off_path[0, 1] == 0.0
    assert results.least_m[0] > 7.2
    assert results.switches.max() == 0.0
