"""From a scan to things on the water: cases worked by hand, then laws, then hulls as beams meet them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from fleet.sensing.clusters import Cluster, ClusterParams, Found, Motion, clusters, seen_before
from fleet.sensing.scan import Scan, cleaned, packed, problem, unpacked
from fleet.sim.scanner.rays import Body, Turn, boat, ranges, vessel

STEP = math.radians(0.25)
FIRST = math.radians(135.0)
BEAMS = 1081
NONE = math.nan
P = ClusterParams()


def scan(seen: dict[int, float], **more: float) -> Scan:
    """Ranges by beam; beam 540 looks ahead, beam 180 to starboard."""
    made = Scan(1, FIRST, -STEP, packed(seen.get(k, NONE) for k in range(BEAMS)), 60.0)
    return replace(made, **more)


def of(*bodies: Body, psi: float = 0.0, r: float = 0.0, u: float = 0.0, beam_s: float = 0.0) -> Scan:
    """What a scanner at the origin sees of hulls; they and it lie still but for its own motion."""
    turn = Turn(0.0, 0.0, psi, u * math.cos(psi), u * math.sin(psi), r, beam_s)
    found = ranges(turn, FIRST - STEP * np.arange(BEAMS), bodies, 60.0)
    return Scan(1, FIRST, -STEP, packed(one if one < 60.0 else NONE for one in found.tolist()), 60.0, beam_s)


def only(found: Found) -> Cluster:
    assert len(found.clusters) == 1, found
    return found.clusters[0]


def test_three_returns_ahead_are_a_thing_ahead() -> None:
    one = only(clusters(scan({539: 20.0, 540: 20.0, 541: 20.0})))
    assert one.ahead == pytest.approx(20.0 * math.cos(STEP))
    assert one.starboard == pytest.approx(0.0, abs=1e-6)
    assert one.length == pytest.approx(40.0 * math.sin(STEP))
    assert (one.range, one.returns) == (20.0, 3)


def test_what_is_to_starboard_is_positive_though_the_scanner_turns_to_port() -> None:
    one = only(clusters(scan({179: 10.0, 180: 10.0, 181: 10.0})))
    assert (one.ahead, one.starboard) == (pytest.approx(0.0, abs=0.01), pytest.approx(10.0, abs=0.01))


def test_two_returns_are_spray_and_counted() -> None:
    found = clusters(scan({540: 20.0, 541: 20.0, 600: 30.0}))
    assert found == Found(returns=3, few=3)


def test_nothing_seen_is_nothing_found() -> None:
    assert clusters(scan({})) == Found()
    assert clusters(scan({540: 0.0, 541: -1.0, 542: 61.0, 543: math.inf})) == Found()


def test_things_two_metres_behind_each_other_are_two() -> None:
    near = dict.fromkeys(range(530, 540), 20.0)
    far = dict.fromkeys(range(540, 550), 22.0)
    assert len(clusters(scan(near | far)).clusters) == 2
    close = dict.fromkeys(range(540, 550), 20.9)
    assert len(clusters(scan(near | close)).clusters) == 1


def test_a_hull_with_returns_missing_is_still_one() -> None:
    seen = {k: 30.0 for k in range(520, 561) if k % 5}
    one = only(clusters(scan(seen)))
    assert one.returns == len(seen)
    assert one.length == pytest.approx(60.0 * math.sin(0.5 * 38 * STEP), abs=0.1)


def test_a_bank_is_no_vessel_and_counted() -> None:
    wall = {k: 15.0 / max(math.sin(FIRST - k * STEP), 1e-9) for k in range(60, 500)}
    found = clusters(scan({k: rho for k, rho in wall.items() if 0.0 < rho < 60.0}))
    assert found.clusters == ()
    assert found.banks == 1
    assert found.long == found.returns


def test_the_own_hull_is_masked() -> None:
    found = clusters(scan(dict.fromkeys(range(100, 130), 0.5) | dict.fromkeys(range(539, 542), 20.0)))
    assert found.own == 30
    assert only(found).range == 20.0


def test_where_the_scanner_is_on_the_boat_counts() -> None:
    ahead = {539: 20.0, 540: 20.0, 541: 20.0}
    one = only(clusters(scan(ahead, ahead_m=1.0, starboard_m=-0.5)))
    assert (one.ahead, one.starboard) == (pytest.approx(21.0, abs=0.01), pytest.approx(-0.5, abs=0.01))
    turned = only(clusters(scan(ahead, yaw_rad=math.radians(90.0))))
    assert (turned.ahead, turned.starboard) == (pytest.approx(0.0, abs=0.01), pytest.approx(20.0, abs=0.01))


def test_of_many_things_the_nearest_are_kept_and_the_rest_counted() -> None:
    seen = {k + j: 10.0 + 0.04 * k for k in range(0, 1070, 10) for j in range(3)}
    found = clusters(scan(seen), params=ClusterParams(join_m=0.2, gap_max_m=0.2, most=8))
    assert len(found.clusters) == 8
    assert max(one.range for one in found.clusters) == pytest.approx(10.0 + 0.04 * 70)
    assert sum(one.returns for one in found.clusters) + found.dropped == found.returns == 3 * 107


def test_a_thing_right_astern_of_a_scanner_that_looks_all_round_is_one() -> None:
    n = 360
    seen = [20.0 if k < 5 or k >= n - 5 else NONE for k in range(n)]
    around = Scan(1, math.pi, -2.0 * math.pi / n, packed(seen), 60.0)
    one = only(clusters(around))
    assert (one.ahead, one.starboard) == (pytest.approx(-20.0, abs=0.1), pytest.approx(0.0, abs=0.2))
    assert one.returns == 10


# -- laws --------------------------------------------------------------------------------------------------------------
returns = st.dictionaries(st.integers(0, BEAMS - 1), st.floats(2.0, 60.0, width=32), max_size=80)


@given(returns)
def test_every_return_is_counted_once(seen: dict[int, float]) -> None:
    found = clusters(scan(seen))
    kept = sum(one.returns for one in found.clusters)
    assert found.returns == len(seen) == kept + found.own + found.few + found.long + found.dropped


@given(returns)
def test_port_is_the_mirror_of_starboard(seen: dict[int, float]) -> None:
    here = clusters(scan(seen)).clusters
    there = clusters(scan({BEAMS - 1 - k: rho for k, rho in seen.items()})).clusters
    key = lambda one: (round(one.range, 6), round(one.ahead, 3))  # noqa: E731
    for a, b in zip(sorted(here, key=key), sorted(there, key=key), strict=True):
        assert (a.ahead, a.length) == (pytest.approx(b.ahead, abs=1e-6), pytest.approx(b.length, abs=1e-6))
    mirrored = sorted(-one.starboard for one in there)
    assert sorted(one.starboard for one in here) == pytest.approx(mirrored, abs=1e-6)


# -- hulls -------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("course_deg", [45.0, 70.0, 90.0, 120.0])
def test_the_middle_of_a_hull_is_found_within_a_tenth_of_its_length_unless_it_is_seen_end_on(course_deg: float) -> None:
    one = only(clusters(of(vessel(30.0, 8.0, math.radians(course_deg), 0.0, 0.0, 10.0))))
    assert math.hypot(one.ahead - 30.0, one.starboard - 8.0) < 1.1
    assert one.length <= 10.5


def test_a_hull_seen_end_on_shows_its_nearer_end() -> None:
    one = only(clusters(of(vessel(30.0, 0.0, 0.0, 0.0, 0.0, 10.0))))
    assert one.ahead == pytest.approx(26.0, abs=0.6)
    assert one.length == pytest.approx(2.0, abs=0.3)  # its beam


def test_a_thing_at_the_edge_of_the_scan_is_less_certain() -> None:
    whole = only(clusters(scan(dict.fromkeys(range(400, 440), 10.0))))
    cut = only(clusters(scan(dict.fromkeys(range(40), 10.0))))
    assert cut.sigma > 4.0 * whole.sigma


@pytest.mark.parametrize("r", [-0.35, 0.0, 0.2])
@pytest.mark.parametrize("u", [0.0, 1.5])
@pytest.mark.parametrize("bearing_deg", [-100.0, -20.0, 0.0, 60.0])
def test_the_motion_of_the_boat_during_a_slow_turn_is_taken_out(r: float, u: float, bearing_deg: float) -> None:
    bearing, beam_s = math.radians(bearing_deg), 0.1 / 1440
    x, y = 25.0 * math.cos(bearing), 25.0 * math.sin(bearing)
    one = only(clusters(of(boat(x, y, 0.3, 0.0, 0.0, 1.2), r=r, u=u, beam_s=beam_s), Motion(u, 0.0, r)))
    # at the last beam the boat is at the origin and heads north; the thing was seen some milliseconds before
    before = (BEAMS - 1) * beam_s - one.t
    s, c = math.sin(-r * before), math.cos(-r * before)
    dx, dy = x + u * before, y
    ahead, starboard = dx * c + dy * s, dy * c - dx * s
    away = math.hypot(ahead, starboard)
    across = (one.starboard * ahead - one.ahead * starboard) / away
    assert across == pytest.approx(0.0, abs=0.06)
    assert math.hypot(one.ahead, one.starboard) == pytest.approx(away, abs=0.4)  # its near side is seen


def test_two_hulls_seen_one_after_the_other_by_a_turning_boat_are_as_far_apart_as_they_are() -> None:
    beam_s = 0.1 / 1440
    scan_of = of(boat(20.0, -20.0, 0.3, 0.0, 0.0, 1.2), boat(20.0, 20.0, 0.3, 0.0, 0.0, 1.2), r=0.35, beam_s=beam_s)
    found = clusters(scan_of, Motion(0.0, 0.0, 0.35)).clusters
    early, late = sorted(found, key=lambda one: one.t)
    turned = 0.35 * (late.t - early.t)  # between the two the boat has turned: each is told as it was seen
    bearing = [math.atan2(one.starboard, one.ahead) for one in (early, late)]
    assert bearing[0] - bearing[1] - turned == pytest.approx(math.radians(90.0), abs=0.003)
    assert turned > 0.008


# -- scans that cannot be ----------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"ranges": b""}, "0 bytes of ranges"),
        ({"ranges": b"123"}, "3 bytes of ranges"),
        ({"ranges": bytes(4 * 8193)}, "expected 4 for each of 1 to 8192 beams"),
        ({"first_rad": math.nan}, "not finite"),
        ({"yaw_rad": math.inf}, "not finite"),
        ({"first_rad": 7.0}, "beyond a whole turn"),
        ({"increment_rad": 0.0}, "not part of one turn"),
        ({"increment_rad": 0.01}, "1081 beams of it are not part of one turn"),
        ({"range_max_m": 0.0}, "range_max_m"),
        ({"beam_s": 0.01}, "a turn of 10.8 s"),
        ({"beam_s": -1e-6}, "expected 0 to 1"),
        ({"ahead_m": 101.0}, "100 m"),
    ],
)
def test_a_scan_that_cannot_be_is_refused_with_the_reason(wrong: dict[str, float], why: str) -> None:
    assert problem(scan({})) == ""
    assert why in problem(replace(scan({}), **wrong))


def test_ranges_out_of_the_scanners_reach_are_no_return() -> None:
    ranges_of = packed([0.05, 0.1, 5.0, 30.0, 30.1, math.inf, -math.inf, NONE])
    assert [one for one in unpacked(cleaned(ranges_of, 0.1, 30.0)) if not math.isnan(one)] == pytest.approx(
        [0.1, 5.0, 30.0]
    )


# -- seen before -------------------------------------------------------------------------------------------------------
THREE = {539: 20.0, 540: 20.0, 541: 20.0}
TENTH = 100_000_000


def before(seen: dict[int, float], ago_ns: int = TENTH) -> Scan:
    """A scan that came before the one with stamp 1."""
    return scan(seen, stamp_ns=1 - ago_ns)


def test_a_thing_that_one_scan_alone_shows_was_not_seen_before() -> None:
    now = scan(THREE)
    found = clusters(now).clusters
    assert seen_before(found, now, []) == [True], "nothing to compare with"
    assert seen_before(found, now, [before({})]) == [False]
    assert seen_before(found, now, [before({800: 20.0})]) == [False]
    assert seen_before(found, now, [before({540: 21.4})]) == [True], "one return of it is enough"
    assert seen_before(found, now, [before({540: 21.7})]) == [False], "a metre, half its length, 5 m/s"
    assert seen_before(found, now, [before({540: 21.7}, 2 * TENTH)]) == [True]
    assert seen_before(found, now, [before({}), before({540: 20.0}), before({})]) == [True], "in any of them"


@given(st.integers(-50, 50).map(lambda k: 0.01 * k), st.integers(-150, 150).map(lambda k: 0.01 * k))
def test_what_lies_still_was_seen_before_however_the_boat_turns_and_goes(r: float, u: float) -> None:
    motion, ago = Motion(u, 0.0, r), 0.1
    far = [boat(50.0, 3.0, 0.0, 0.0, 0.0, 4.0)]
    half = 0.5 * r * ago  # where the boat was, along its mean heading, and how it lay
    turn = Turn(-u * ago * math.cos(half), u * ago * math.sin(half), -r * ago, 0.0, 0.0, 0.0, 0.0)
    seen = ranges(turn, FIRST - STEP * np.arange(BEAMS), far, 60.0)
    earlier = Scan(1 - TENTH, FIRST, -STEP, packed(one if one < 60.0 else NONE for one in seen.tolist()), 60.0)
    now = of(*far)
    assert seen_before(clusters(now).clusters, now, [earlier], motion) == [True]
