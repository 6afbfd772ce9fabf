"""Boats meet foreign vessels: the engine, the judge, and a few scenarios of every suite."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec import structs

from fleet.avoidance.foreign import Kind
from fleet.sim.batch.ships import Decided, Ship, ShipCase, Voyage, ship_track
from fleet.sim.batch.ships_cases import IMAZU, c0, channel, formation, imazu, several, stopped, sudden, two
from fleet.sim.batch.ships_judge import judge, run_suite
from fleet.sim.batch.ships_sail import sail
from fleet.sim.batch.ships_sensors import believed_length, reports

HEAD_ON = ShipCase(
    suite="by hand",
    seed=1,
    case=0,
    cruise=1.0,
    paths=((0.0, 0.0, 0.0),),
    ships=(Ship(x=300.0, y=0.0, chi=math.pi, U=2.0, length=20.0),),
    meet_s=100.0,
    limit_s=300.0,
)


def straight_on(case: ShipCase, seconds: float, y: float = 0.0, decisions: tuple[Decided, ...] = ()) -> Voyage:
    """What would happen if the boat went on, y metres beside its path."""
    ticks = round(seconds * 10)
    t = np.arange(ticks) * 0.1
    track = [ship_track(ship, ticks) for ship in case.ships]
    ships = [np.stack([each[k] for each in track], axis=1) for k in range(3)]
    x = (case.cruise * t)[:, None]
    here, zero = np.full_like(x, y), np.zeros_like(x)
    return Voyage(t, x, here, zero, zero + case.cruise, *ships, decisions, True)


def test_a_vessel_follows_its_script() -> None:
    ship = Ship(x=0.0, y=0.0, chi=0.0, U=2.0, length=10.0, turns_s=10.0, turn=math.pi / 2.0, rate=0.05)
    x, y, chi = ship_track(ship, 1000)
    assert (x[100], y[100], chi[100]) == (pytest.approx(20.0), 0.0, 0.0)
    assert chi[-1] == pytest.approx(math.pi / 2.0)
    assert y[-1] - y[-101] == pytest.approx(20.0)
    assert x[-1] - 20.0 == pytest.approx(2.0 / 0.05, abs=0.2)  # the radius of its turn is U / rate


def test_touching_hulls_are_a_contact() -> None:
    """Head-on, 2 m and 3.2 m beside: half a beam of 4 m and the own 0.6 m make 2.6 m."""
    assert judge(HEAD_ON, straight_on(HEAD_ON, 120.0, 2.5)).contact
    near = judge(HEAD_ON, straight_on(HEAD_ON, 120.0, 3.2))
    assert not near.contact
    assert near.hull_m == pytest.approx(0.6)
    assert near.dom == pytest.approx(3.2 / 11.2)


def test_the_side_is_that_of_the_nearest_moment() -> None:
    assert judge(HEAD_ON, straight_on(HEAD_ON, 120.0, 15.0)).side == 1.0  # the boat passes to starboard of its path
    assert judge(HEAD_ON, straight_on(HEAD_ON, 120.0, -15.0)).side == 0.0
    assert judge(HEAD_ON, straight_on(HEAD_ON, 120.0, 15.0)).kind == Kind.HEAD_ON


def test_actions_are_counted_with_their_changes_of_side_and_their_repetitions() -> None:
    def said(t: float, acting: float, a: float) -> Decided:
        return Decided(t, 0, acting, a, 1.0, 0.0 if acting else -1.0, 100.0 if acting else math.nan, 1.0)

    log = (said(50.0, 1.0, 0.6), said(60.0, 1.0, -0.6), said(70.0, 0.0, 0.0), said(90.0, 1.0, 0.6))
    outcome = judge(HEAD_ON, straight_on(HEAD_ON, 120.0, 15.0, log))
    assert (outcome.decisions, outcome.reversals, outcome.retriggers, outcome.first) == (3, 1, 1, 1)
    assert outcome.lead_s == pytest.approx(100.0 - (11.2 + 28.0) / 3.0 - 50.0, abs=0.1)
    late = (*log[:3], said(140.0, 1.0, 0.6))
    assert judge(HEAD_ON, straight_on(HEAD_ON, 150.0, 15.0, late)).retriggers == 0


def test_a_slow_boat_is_late_by_the_way_that_it_lost() -> None:
    voyage = straight_on(HEAD_ON, 100.1, 15.0)
    slow = structs.replace(voyage, x=voyage.x * 0.8)
    assert judge(HEAD_ON, slow).delay_s == pytest.approx(20.0)


def test_sensors_say_what_they_are_said_to_say() -> None:
    for sensor, interval, least in (("ais", (2.0, 10.0), 1.0), ("positions", (0.5, 1.0), 1.0)):
        ship = structs.replace(HEAD_ON.ships[0], sensor=sensor)
        seen = []
        for case in range(40):
            scene = structs.replace(HEAD_ON, ships=(ship,), case=case)
            truth = ship_track(ship, 3000)
            heard = list(reports(scene, 0, truth))
            gaps = np.diff([each.tick for each in heard]) * 0.1
            assert interval[0] - 0.1 <= np.median(gaps) <= 2.0 * interval[1]
            assert all(each.sigma >= least for each in heard)
            assert (heard[0].velocity is None) == (sensor == "positions")
            off = np.array([each.x - truth[0][each.tick] for each in heard]) / heard[0].sigma
            seen.append((off.std(), gaps.max()))
        assert abs(np.mean([s for s, _ in seen]) - 1.0) < 0.1
    sizes = [believed_length(structs.replace(HEAD_ON, ships=(ship,), case=case), 0) for case in range(200)]
    assert 15.0 <= min(sizes) < 16.0
    assert 24.0 < max(sizes) <= 25.0


def test_left_alone_the_vessels_pass_where_they_were_to_pass() -> None:
    """Every vessel of `two` comes within 1.2 C0 of a boat that goes straight on."""
    for case in two(3, 30):
        x, y, _ = ship_track(case.ships[0], round(case.limit_s * 10))
        t = np.arange(len(x)) * 0.1
        nearest = np.hypot(x - case.cruise * t, y).min()
        assert nearest <= 1.2 * c0(case.ships[0].length) + 0.3


def test_the_vessels_of_imazu_meet_in_one_point() -> None:
    for case in imazu(1, 2.0):
        for ship, degrees in zip(case.ships, IMAZU[case.case], strict=True):
            x, y, _ = ship_track(ship, 1801)
            if degrees != 0:
                assert math.hypot(x[-1] - 180.0, y[-1]) < 0.5
            assert (0.5 if degrees == 0 else 2.0) == ship.U


@pytest.mark.parametrize(
    "cases",
    [two(21, 6), several(21, 3), list(imazu(1, 2.0))[4:7], sudden(21, 3), stopped(21, 2), channel(21, 3)],
    ids=["two", "several", "imazu", "sudden", "stopped", "channel"],
)
def test_a_few_of_every_suite_touch_nobody(cases: list[ShipCase]) -> None:
    summary = run_suite(cases)
    figures = summary.figures()
    assert figures["contact"] == 0
    assert all(each.dom > 0.5 for each in summary.outcomes)
    assert all(each.bank_m > 0.5 for each in summary.outcomes)
    assert figures["n"] == len(summary.outcomes)


@pytest.mark.parametrize("abreast", [False, True])
def test_a_formation_keeps_clear_by_one_decision_and_keeps_its_order(abreast: bool) -> None:
    summary = run_suite(formation(21, 2, boats=3, abreast=abreast))
    for outcome in summary.outcomes:
        assert not outcome.contact
        assert outcome.dom >= 1.0
        assert outcome.closest_m > 6.0
        assert outcome.reversals == 0


def test_the_same_scenario_sails_alike_every_time() -> None:
    case = next(two(21, 1, first=4))
    first, second = sail(case), sail(case)
    assert first.decisions == second.decisions
    assert np.array_equal(first.x, second.x)
