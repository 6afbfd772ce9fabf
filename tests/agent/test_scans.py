"""From scans to foreign vessels: where things are put, which are boats of the fleet, how long vessels are."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest
from msgspec.structs import replace

from fleet.agent.scanned import BESIDE, Mate
from fleet.agent.scans import Outlook, ScanParams
from fleet.agent.step import Nav
from fleet.agent.traffic import SCAN, Traffic
from fleet.drivers.seam import Sighting
from fleet.sensing import Target
from fleet.sensing.scan import Scan, packed
from fleet.sim.scanner.rays import Body, Turn, boat, ranges, vessel

S = 1_000_000_000
STEP, FIRST, BEAMS = math.radians(0.25), math.radians(135.0), 1081
BEAM_S = 0.1 / 1440


def geographic(x: float, y: float) -> tuple[float, float]:
    return x * 1e-5, y * 1e-5


def local(lat_deg: float, lon_deg: float) -> tuple[float, float]:
    return lat_deg * 1e5, lon_deg * 1e5


class Sea:
    """A boat with a scanner, and hulls around it; no noise but what is asked for."""

    def __init__(self, loss: float = 0.0) -> None:
        self.outlook = Outlook()
        self.traffic = Traffic(lambda: ("b2",), 0)
        self.loss = loss
        self._random = np.random.default_rng(1)

    def look(self, t_s: float, nav: Nav[float], bodies: Iterable[Body], mates: Iterable[Mate] = ()) -> list[Sighting]:
        """A turn that ends at that time, and what the agent makes of it 50 ms later."""
        turn = Turn(nav.x, nav.y, nav.psi, nav.vx, nav.vy, nav.r, BEAM_S)
        found = ranges(turn, FIRST - STEP * np.arange(BEAMS), bodies, 60.0)
        found[self._random.random(BEAMS) < self.loss] = math.inf
        seen = packed(one if one < 60.0 else math.nan for one in found.tolist())
        stamp_ns = round((t_s - (BEAMS - 1) * BEAM_S) * S)
        scan = Scan(stamp_ns, FIRST, -STEP, seen, 60.0, BEAM_S, scanner="bow")
        later = 0.05
        now_ns = round((t_s + later) * S)
        now = replace(nav, x=nav.x + nav.vx * later, y=nav.y + nav.vy * later, psi=nav.psi + nav.r * later)
        told = [*self.outlook.sightings([scan], now, geographic, now_ns)]
        for sightings in told:
            self.traffic.hear(sightings, local, mates, now_ns)
        return [one for sightings in told for one in sightings]

    def targets(self, t_s: float) -> tuple[Target, ...]:
        return self.traffic.targets(round(t_s * S))


def nav(x: float = 0.0, y: float = 0.0, psi: float = 0.0, u: float = 0.0, r: float = 0.0) -> Nav[float]:
    return Nav(1.0, x, y, psi, u * math.cos(psi), u * math.sin(psi), r, 0.5)


@pytest.mark.parametrize("psi_deg", [0.0, 90.0, -150.0])
@pytest.mark.parametrize("r", [0.0, 0.3, -0.3])
def test_a_thing_is_where_it_is_whatever_the_boat_does_while_it_scans(psi_deg: float, r: float) -> None:
    psi = math.radians(psi_deg)
    x, y = 100.0 + 20.0 * math.cos(psi + 0.5), -50.0 + 20.0 * math.sin(psi + 0.5)
    (one,) = Sea().look(10.0, nav(100.0, -50.0, psi, 1.5, r), [boat(x, y, 0.0, 0.0, 0.0, 1.0)])
    there = local(one.lat_deg, one.lon_deg)
    assert math.dist(there, (x, y)) < 0.35  # its near side is seen
    assert (one.source, one.name, one.length_m) == (SCAN, "", 2.0)
    assert one.position_error_m == pytest.approx(math.hypot(0.1, 0.02 * 20.0), rel=0.1)


def test_what_one_of_several_scans_shows_is_not_told_and_counted() -> None:
    sea, thing = Sea(), [boat(20.0, 0.0, 0.0, 0.0, 0.0, 4.0)]
    sea.look(0.0, nav(), [])
    for k in range(1, 5):
        assert sea.look(0.1 * k, nav(), []) == [], "too soon"
    assert sea.look(0.5, nav(), thing) == []
    assert (sea.outlook.tally.once, sea.outlook.tally.things) == (1, 0)
    for k in range(6, 10):
        sea.look(0.1 * k, nav(), thing)
    assert len(sea.look(1.0, nav(), thing)) == 1
    assert (sea.outlook.tally.once, sea.outlook.tally.things) == (1, 1)


def test_three_looks_make_a_vessel_and_one_that_lies_still_has_no_speed() -> None:
    sea = Sea(loss=0.05)
    buoy = [vessel(30.0, 5.0, 1.0, 0.0, 0.0, 6.0)]
    for k in range(40):
        sea.look(0.5 * k, nav(0.5 * k * 0.8, u=0.8), buoy)
        assert len(sea.targets(0.5 * k)) == (k >= 2)
    (target,) = sea.targets(20.0)
    assert math.hypot(target.vx, target.vy) < 0.1
    assert math.hypot(target.x - 30.0, target.y - 5.0) < 1.0
    assert 4.0 < target.length < 6.5


def test_a_vessel_that_crosses_is_one_track_with_its_velocity() -> None:
    sea = Sea(loss=0.05)
    for k in range(30):
        t = 0.5 * k
        sea.look(t, nav(u=0.0), [vessel(35.0, 40.0 - 2.0 * t, -0.5 * math.pi, 0.0, -2.0, 8.0)])
    (target,) = sea.targets(14.5)
    assert target.vy == pytest.approx(-2.0, abs=0.3)
    assert target.vx == pytest.approx(0.0, abs=0.3)


def test_two_boats_at_anchor_six_metres_apart_are_two_vessels() -> None:
    sea = Sea()
    for k in range(10):
        sea.look(0.5 * k, nav(), [vessel(25.0, -3.0, 0.5, 0.0, 0.0, 5.0), vessel(25.0, 5.0, 0.5, 0.0, 0.0, 5.0)])
    assert sorted(round(target.y) for target in sea.targets(5.0)) == pytest.approx([-3, 5], abs=1)


def test_a_hull_that_falls_into_two_pieces_stays_one_vessel() -> None:
    sea = Sea()
    whole = vessel(20.0, 0.0, 0.5 * math.pi, 0.0, 0.0, 20.0)
    for k in range(4):
        sea.look(0.5 * k, nav(), [whole])
    pile = boat(10.0, 0.0, 0.0, 0.0, 0.0, 4.0)  # it hides the middle
    for k in range(4, 12):
        assert len(sea.look(0.5 * k, nav(), [whole, pile])) == 3
    ship, *others = sea.targets(6.0)
    assert ship.x == pytest.approx(18.0, abs=1.0)
    assert abs(ship.y) < 8.0
    assert ship.length > 15.0
    assert all(other.x < 12.0 for other in others)  # the pile may be a vessel, the other piece is none
    assert sea.traffic.parts >= 8


def test_a_boat_of_the_fleet_is_no_vessel_within_the_errors_of_both_positions() -> None:
    sea = Sea()
    for k in range(20):
        mate = Mate(20.0 + 3.0, 2.0, 3.0 * math.hypot(1.0, 0.5))  # it believes itself 3 m farther ahead
        sea.look(0.5 * k, nav(), [boat(20.0, 2.0, 0.0, 0.0, 0.0, 2.4)], [mate])
    assert sea.targets(10.0) == ()
    assert sea.traffic.mates == 20


def test_a_boat_that_is_heard_only_after_it_was_seen_is_no_vessel_any_more() -> None:
    sea = Sea()
    hull, mate = [boat(20.0, 2.0, 0.0, 0.0, 0.0, 2.4)], Mate(21.0, 2.0, 1.0)
    for k in range(4):
        sea.look(0.5 * k, nav(), hull)
    assert len(sea.targets(1.5)) == 1
    sea.traffic.greet(mate)
    assert sea.targets(1.5) == ()


def test_a_vessel_that_goes_where_a_boat_goes_is_that_boat() -> None:
    sea = Sea()
    for k in range(4 + BESIDE):
        t = 0.5 * k
        there = boat(20.0, 2.0 + t, 0.5 * math.pi, 0.0, 1.0, 2.4)
        heard_as = [Mate(there.x + 1.5, there.y, 1.5, 0.0, 1.0)] if k >= 4 else []
        sea.look(t, nav(), [there], heard_as)
        assert bool(sea.targets(t)) == (2 <= k < 3 + BESIDE)


def test_returns_of_a_mate_do_not_move_the_vessel_that_it_passes() -> None:
    sea = Sea()
    barge = vessel(30.0, 0.0, 0.0, 0.0, 0.0, 6.0)
    for k in range(60):
        t = 0.5 * k
        mate = boat(20.0 + t, -9.0, 0.0, 1.0, 0.0, 2.4)
        sea.look(t, nav(), [barge, mate], [Mate(mate.x, mate.y, 1.5, 1.0, 0.0)])
    (target,) = sea.targets(29.5)
    assert math.hypot(target.x - 30.0, target.y) < 3.0
    assert math.hypot(target.vx, target.vy) < 0.1


def test_the_length_of_a_vessel_is_the_longest_that_was_seen_of_late() -> None:
    sea = Sea()
    for k in range(10):
        sea.look(0.5 * k, nav(), [vessel(25.0, 0.0, 0.5 * math.pi, 0.0, 0.0, 12.0)])  # broadside
    assert sea.targets(4.5)[0].length == pytest.approx(12.0, abs=0.6)
    for k in range(10, 20):
        sea.look(0.5 * k, nav(), [vessel(25.0, 0.0, 0.0, 0.0, 0.0, 12.0)])  # it has swung to its anchor
    assert sea.targets(9.5)[0].length > 9.0


def test_what_an_ais_vessel_tells_of_its_length_is_not_replaced_by_what_is_seen_of_it() -> None:
    sea = Sea()
    told = Sighting(0, "ais", "coaster", *geographic(30.0, 0.0), 2.0, 0.0, 0.0, 60.0)
    sea.traffic.hear([told], local, (), 0)
    for k in range(6):
        sea.look(0.5 * k, nav(), [vessel(30.0, 0.0, 0.0, 0.0, 0.0, 12.0)])
    (target,) = sea.targets(3.0)
    assert (target.length, sea.traffic.name_of(target.number)) == (60.0, "coaster")


def test_scans_are_looked_at_twice_a_second_and_none_without_a_position_or_too_late() -> None:
    sea = Sea()
    thing = [boat(20.0, 0.0, 0.0, 0.0, 0.0, 2.4)]
    for k in range(20):
        sea.look(0.1 * k, nav(), thing)
    assert (sea.outlook.tally.scans, sea.outlook.tally.looked) == (20, 4)
    assert not sea.look(3.0, replace(nav(), sound=0.0), thing)
    assert sea.outlook.tally.unplaced == 1
    late = Scan(round(4.0 * S), FIRST, -STEP, packed([5.0] * 3), 60.0)
    assert [*sea.outlook.sightings([late], nav(), geographic, round(4.6 * S))] == []
    assert sea.outlook.tally.unplaced == 2


def test_banks_are_no_vessels_but_are_told() -> None:
    sea = Sea()
    quay = Body(0.0, 30.0, 0.0, 0.0, 0.0, 50.0, 1.0)
    assert sea.look(1.0, nav(), [quay, boat(15.0, 0.0, 0.0, 0.0, 0.0, 2.4)]) != []
    assert sea.outlook.words() == ("bow: 1 on the water, 1 too long for a vessel",)
    assert sea.outlook.tally.banks == 1


def test_a_boat_may_scan_without_keeping_clear_of_what_it_sees() -> None:
    sea = Sea()
    sea.outlook = Outlook(ScanParams(avoid=False))
    assert sea.look(1.0, nav(), [boat(20.0, 0.0, 0.0, 0.0, 0.0, 2.4)]) == []
    assert sea.outlook.tally.things == 1
