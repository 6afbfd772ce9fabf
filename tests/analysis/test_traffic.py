"""How near boats came to other vessels: hulls and domains, worked by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.analysis.chart import chart_of
from fleet.analysis.figures import picture
from fleet.analysis.metrics import FIGURES, summary_of
from fleet.analysis.report import page
from fleet.analysis.series import Series, Track
from fleet.analysis.traffic import domain_ratio, hull_distance, passings

T = np.arange(0.0, 100.05, 0.1)


def track(x: float, y: float, psi_deg: float, speed: float, length_m: float, t: np.ndarray = T) -> Track:
    psi = math.radians(psi_deg)
    return Track(
        t=t, x=x + speed * math.cos(psi) * t, y=y + speed * math.sin(psi) * t,
        psi=np.full_like(t, psi), speed=np.full_like(t, speed), length_m=length_m,
    )  # fmt: skip


BOAT = track(0.0, 0.0, 0.0, 1.0, 2.4)  # north


def test_hulls_alongside_are_apart_by_the_gap_between_their_sides() -> None:
    ship = track(0.0, 20.0, 0.0, 1.0, 40.0)  # beam 8 m, the boat's 1.2 m
    assert hull_distance(BOAT, ship, T[:1]) == pytest.approx(20.0 - 4.0 - 0.6)


def test_hulls_bow_to_bow_are_apart_by_the_gap_between_their_ends() -> None:
    ship = track(100.0, 0.0, 180.0, 0.0, 40.0)
    assert hull_distance(BOAT, ship, T[:1]) == pytest.approx(100.0 - 20.0 - 1.2)


def test_hulls_that_cross_touch() -> None:
    ship = track(50.0, 30.0, 270.0, 0.6, 40.0)  # its middle is on the path when the boat is there
    assert hull_distance(BOAT, ship, np.array([50.0])) == pytest.approx(0.0)
    (passing,) = passings({"b1": BOAT}, {"mv": ship})
    assert passing.contacts == 1
    assert passing.hull_m == 0.0


def test_the_domain_reaches_ten_seconds_ahead_at_most_three_lengths() -> None:
    ship = track(0.0, 0.0, 0.0, 2.0, 20.0)  # C0 = 1.2 + 2 + 8 = 11.2; core from -8 to 8 + 20
    at = T[:1]
    ahead, abeam, astern = (
        track(40.0, 0.0, 0.0, 0.0, 2.4),
        track(0.0, 22.4, 0.0, 0.0, 2.4),
        track(-30.4, 0.0, 0.0, 0.0, 2.4),
    )
    assert domain_ratio(ahead, ship, at) == pytest.approx(12.0 / 11.2)
    assert domain_ratio(abeam, ship, at) == pytest.approx(2.0)
    assert domain_ratio(astern, ship, at) == pytest.approx(2.0)
    fast = track(0.0, 0.0, 0.0, 8.0, 20.0)  # 80 m would be 4 lengths
    assert domain_ratio(ahead, fast, at) == pytest.approx(0.0)
    assert domain_ratio(track(8.0 + 60.0 + 11.2, 0.0, 0.0, 0.0, 2.4), fast, at) == pytest.approx(1.0)


def test_a_vessel_that_lies_still_is_a_point_with_a_wider_circle() -> None:
    barge = track(0.0, 0.0, 0.0, 0.0, 20.0)
    boat = track(0.0, 19.2, 0.0, 0.0, 2.4)
    assert domain_ratio(boat, barge, T[:1]) == pytest.approx(1.0)  # C0 + 0.4 L


@given(st.floats(-180.0, 180.0), st.floats(-90.0, 90.0), st.floats(5.0, 90.0), st.floats(-3.0, 3.0))
def test_turning_the_scene_changes_no_distance(angle: float, x: float, y: float, turn: float) -> None:
    def turned(one: Track) -> Track:
        c, s = math.cos(turn), math.sin(turn)
        return Track(one.t, c * one.x - s * one.y, s * one.x + c * one.y, one.psi + turn, one.speed, one.length_m)

    ship = track(x, y, angle, 3.0, 30.0)
    a, b = passings({"b": BOAT}, {"v": ship})[0], passings({"b": turned(BOAT)}, {"v": turned(ship)})[0]
    assert a.hull_m == pytest.approx(b.hull_m, abs=1e-6)
    assert a.domain == pytest.approx(b.domain, abs=1e-6)


def test_vessels_that_were_never_there_together_do_not_pass() -> None:
    late = track(0.0, 0.0, 0.0, 1.0, 20.0, T + 500.0)
    assert passings({"b1": BOAT}, {"mv": late}) == []


def series(**vessels: Track) -> Series:
    return Series(folder=Path("run"), start_ns=0, tracks={"b1": BOAT}, traffic=dict(vessels))


def test_the_summary_has_the_figures_and_the_checks_hold_or_not() -> None:
    ship = track(50.0, 30.0, 270.0, 0.6, 40.0)
    summary = summary_of(series(mv=ship), "m", {"contacts": 0, "min_domain": 1.0, "min_traffic_m": 5.0})
    assert (summary.contacts, summary.min_traffic_m) == (1, 0.0)
    assert [check.ok for check in summary.checks] == [False, False, False]
    far = summary_of(series(mv=track(50.0, 500.0, 0.0, 0.6, 40.0)), "m", {"contacts": 0, "min_domain": 1.0})
    assert far.passed
    assert {"contacts", "min_domain", "min_traffic_m"} <= set(FIGURES)


def test_without_traffic_there_are_no_such_figures_and_a_check_of_them_fails() -> None:
    summary = summary_of(series(), "m", {"contacts": 0})
    assert (summary.contacts, summary.min_traffic_m, summary.min_domain) == (None, None, None)
    assert not summary.passed


def test_the_page_lists_who_passed_whom_and_marks_what_is_bad() -> None:
    found = series(mv=track(50.0, 30.0, 270.0, 0.6, 40.0), far=track(50.0, 500.0, 0.0, 0.6, 40.0))
    text = page(found, summary_of(found, "m", {}), "")
    assert "<h2>Other vessels</h2>" in text
    assert "b1 - mv" in text
    assert "touched 1 times" in text
    assert "Other vessels" not in page(series(), summary_of(series(), "m", {}), "")


def test_vessels_are_drawn_near_the_boats_only() -> None:
    pytest.importorskip("matplotlib")
    found = series(mv=track(50.0, 30.0, 270.0, 0.6, 40.0), far=track(5000.0, 9000.0, 0.0, 0.6, 40.0))
    axis = picture(found, chart_of({}), "m").axes[0]
    labels = {str(line.get_label()).partition(",")[0] for line in axis.get_lines()}
    assert {"mv", "far"} <= labels
    low, high = axis.get_ylim()
    assert high - low < 1000.0
