"""Other vessels of a simulation: how they move, what they do by their script, and what boats receive of them."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.mission.load import load
from fleet.mission.model import Ais, Change, Gap, Legs, Mission, Positions, Steady, Vessel
from fleet.mission.plan import build
from fleet.sim import traffic
from fleet.sim.traffic import Body, Listener, Motion, Script
from fleet.sim.world import World

DT = 0.1
NOBODY: tuple[Body, ...] = ()
PLAN = build(load("overtaking"))


def script(vessel: Vessel) -> Script:
    return traffic._script(vessel, PLAN.plane)


def ship(**changes: object) -> Vessel:
    what: dict[str, object] = {
        "name": "mv-x",
        "length_m": 20.0,
        "speed_mps": 4.0,
        "track": Steady(start=(0.0, 0.0), course_deg=90.0),
    }
    return Vessel(**{**what, **changes})  # type: ignore[arg-type]


def sailed(one: Script, seconds: float, boats: tuple[Body, ...] = NOBODY) -> list[Motion]:
    motion, found = traffic.begin(one), []
    for k in range(round(seconds / DT)):
        motion = traffic.advance(one, motion, (k + 1) * DT, boats, DT)
        found.append(motion)
    return found


def test_a_vessel_on_a_course_goes_straight_at_its_speed() -> None:
    last = sailed(script(ship()), 100.0)[-1]
    assert (last.x, last.y) == pytest.approx((0.0, 400.0), abs=1e-6)


def test_it_turns_as_far_as_its_script_says_no_tighter_than_two_and_a_half_lengths() -> None:
    one = script(ship(changes=(Change(at_s=10.0, do="turn", value=60.0),)))
    way = sailed(one, 60.0)
    assert math.degrees(way[-1].chi) == pytest.approx(150.0)
    rates = [(b.chi - a.chi) / DT for a, b in pairwise(way)]
    assert max(rates) == pytest.approx(4.0 / 50.0)  # v / (2.5 L)
    assert all(motion.chi == pytest.approx(math.pi / 2) for motion in way[:99])


def test_it_stops_and_sets_off_again_when_told() -> None:
    one = script(ship(changes=(Change(at_s=5.0, do="stop"), Change(at_s=60.0, do="speed", value=2.0))))
    way = sailed(one, 120.0)
    assert way[500].speed == 0.0
    assert way[-1].speed == pytest.approx(2.0)
    losses = [(a.speed - b.speed) / DT for a, b in pairwise(way)]
    assert max(losses) == pytest.approx(3.0 / 20.0)  # 3 m/s a second over its length


def test_it_goes_from_point_to_point_and_beyond_the_last_keeps_its_course() -> None:
    one = script(ship(length_m=10.0, track=Legs(points=((0.0, 0.0), (200.0, 0.0), (200.0, 300.0)))))
    way = sailed(one, 200.0)
    assert min(math.hypot(m.x - 200.0, m.y) for m in way) < 25.0
    assert min(math.hypot(m.x - 200.0, m.y - 300.0) for m in way) < 25.0
    assert way[-1].y > 400.0
    assert way[-1].chi == pytest.approx(way[-100].chi)


def test_one_that_gives_way_turns_to_starboard_for_a_boat_from_starboard_and_goes_back() -> None:
    boat: Body = (180.0, 200.0, -3.6, 0.0)  # from port, collision course
    crossing: Body = (-150.0, 200.0, 3.0, 0.0)  # from starboard
    stubborn, polite = script(ship()), script(ship(gives_way=True))

    def courses(one: Script, other: Body) -> list[float]:
        motion, found = traffic.begin(one), []
        for k in range(900):
            t = (k + 1) * DT
            body = (other[0] + other[2] * t, other[1] + other[3] * t, other[2], other[3])
            motion = traffic.advance(one, motion, t, (body,), DT)
            found.append(math.degrees(motion.chi))
        return found

    assert max(courses(stubborn, crossing)) == pytest.approx(90.0)
    assert max(courses(polite, crossing)) == pytest.approx(135.0)
    assert courses(polite, crossing)[-1] == pytest.approx(90.0)
    assert max(courses(polite, boat)[:400]) == pytest.approx(90.0)  # who comes from port has to give way itself


def test_a_vessel_that_stands_still_neither_moves_nor_turns() -> None:
    one = script(ship(speed_mps=0.0, changes=(Change(at_s=1.0, do="turn", value=90.0),)))
    last = sailed(one, 30.0)[-1]
    assert (last.x, last.y, last.chi) == (0.0, 0.0, math.pi / 2)


@given(st.integers(0, 2**32), st.floats(-180.0, 180.0), st.floats(0.0, 8.0), st.floats(5.0, 100.0))
def test_the_same_script_gives_the_same_bits(seed: int, course: float, speed: float, length: float) -> None:
    one = script(
        ship(speed_mps=speed, length_m=length, track=Steady(start=(0.0, 0.0), course_deg=course), gives_way=True)
    )
    assert sailed(one, 3.0, ((50.0, 50.0, 1.0, 0.0),)) == sailed(one, 3.0, ((50.0, 50.0, 1.0, 0.0),))
    assert traffic.reports(one, 100.0, seed) == traffic.reports(one, 100.0, seed)


# -- what boats receive ------------------------------------------------------------------------------------------------
def listener(number: int = 7, x: float = 0.0, y: float = 0.0, **more: object) -> Listener:
    values: dict[str, object] = {"error_n": 0.0, "error_e": 0.0, "knows_itself": True, "plane": PLAN.plane, **more}
    return Listener(number, x, y, **values)  # type: ignore[arg-type]


def heard(one: Script, boat: Listener, count: int = 400, t_s: float = 50.0, seed: int = 3):  # type: ignore[no-untyped-def]
    motion = traffic.begin(one)
    return [traffic.report(one, motion, boat, number, 1, t_s, seed) for number in range(count)]


def test_ais_tells_name_position_velocity_and_size_with_the_noise_that_was_asked_for() -> None:
    one = script(ship(sensed=Ais(noise_m=2.0, velocity_noise_mps=0.1, loss=0.0)))
    found = [report for report in heard(one, listener()) if report is not None]
    assert len(found) == 400
    assert {(report.name, report.length_m, report.position_error_m) for report in found} == {("mv-x", 20.0, 2.0)}
    off = [PLAN.plane.to_local(report.lat_deg, report.lon_deg) for report in found]
    spread = math.sqrt(sum(x * x + y * y for x, y in off) / 800)
    assert spread == pytest.approx(2.0, rel=0.1)
    assert sum(report.v_east_mps for report in found) / 400 == pytest.approx(4.0, abs=0.02)


def test_ais_that_does_not_tell_its_size_leaves_it_open() -> None:
    one = script(ship(sensed=Ais(tells_size=False, loss=0.0)))
    assert all(math.isnan(report.length_m) for report in heard(one, listener(), 5))


def test_all_boats_hear_the_same_words_and_each_loses_its_own() -> None:
    one = script(ship(sensed=Ais(loss=0.3)))
    a, b = heard(one, listener(1)), heard(one, listener(2))
    both = [(x, y) for x, y in zip(a, b, strict=True) if x is not None and y is not None]
    assert all(x == y for x, y in both)
    assert sum(x is None for x in a) / 400 == pytest.approx(0.3, abs=0.07)
    assert [x is None for x in a] != [y is None for y in b]


def test_bare_positions_have_neither_name_nor_velocity_and_each_boat_its_own_noise() -> None:
    one = script(ship(sensed=Positions(noise_m=1.0, loss=0.0, size_error=0.25)))
    a, b = heard(one, listener(1), 3), heard(one, listener(2), 3)
    assert all(report.name == "" and math.isnan(report.v_north_mps) for report in a)
    assert [(r.lat_deg, r.lon_deg) for r in a] != [(r.lat_deg, r.lon_deg) for r in b]
    assert all(15.0 <= report.length_m <= 25.0 for report in (*a, *b))
    assert len({report.length_m for report in a}) == 1  # a sensor misjudges a vessel alike each time


def test_a_boat_that_is_wrong_about_itself_is_as_wrong_about_what_it_sees() -> None:
    one = script(ship(sensed=Positions(noise_m=0.0, loss=0.0)))
    (report,) = heard(one, listener(error_n=3.0, error_e=-2.0), 1)
    assert PLAN.plane.to_local(report.lat_deg, report.lon_deg) == pytest.approx((3.0, -2.0), abs=1e-6)
    assert heard(one, listener(knows_itself=False), 1) == [None]


def test_nothing_is_received_beyond_the_range_nor_in_a_gap() -> None:
    one = script(ship(sensed=Positions(range_m=100.0, loss=0.0, gaps=(Gap(from_s=40.0, to_s=60.0),))))
    assert heard(one, listener(x=99.0), 1, t_s=60.0) != [None]
    assert heard(one, listener(x=101.0), 1, t_s=60.0) == [None]
    assert heard(one, listener(x=99.0), 1, t_s=40.0) == [None]


@pytest.mark.parametrize(("sensed", "period_s"), [(Ais(interval_s=10.0), 10.0), (Positions(rate_hz=2.0), 0.5)])
def test_reports_come_as_often_as_the_mission_says(sensed: Ais | Positions, period_s: float) -> None:
    one = script(ship(sensed=sensed))
    assert traffic.reports(one, 1000.0, 5) - traffic.reports(one, 0.0, 5) == round(1000.0 / period_s)


def test_the_world_hands_each_report_to_a_boat_once_and_moves_vessels_only_after_the_beginning() -> None:
    mission: Mission = load("ship")
    world = World(build(mission), 0, seed=1)
    world.begins_ns = 2_000_000_000
    for _ in range(100):
        world.step()
    assert world.vessel("ferry").y_m == 620.0
    for _ in range(500):
        world.step()
    reports = world.sense("b1").sightings
    assert len(reports) in (1, 2)  # every 8 s, in 10 s
    assert world.sense("b1").sightings == ()
    assert world.vessel("ferry").y_m == pytest.approx(570.0)
    assert world.vessel("ferry").length_m == 40.0


def test_what_waits_for_a_dead_boat_is_bounded() -> None:
    mission: Mission = load("ship", ["traffic.ferry.sensed={kind='positions', rate_hz=5.0, range_m=5000.0, loss=0.0}"])
    world = World(build(mission), 0)
    for _ in range(4000):
        world.step()
    assert len(world.sense("b2").sightings) == 256


def test_a_mission_without_traffic_has_none() -> None:
    assert World(PLAN, 0).crafts == {}
