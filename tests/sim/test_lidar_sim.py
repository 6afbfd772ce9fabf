"""Real agents with laser scanners: SCIP over TCP from the simulated world, a vessel that nothing else tells of."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sim.sailed import sail

pytestmark = pytest.mark.sails


def test_two_boats_keep_clear_of_a_barge_that_only_their_scanners_see(tmp_path: Path) -> None:
    checks = "checks={contacts = 0, min_domain = 1.0, collisions = 0, min_separation_m = 8.0}"
    run = sail("barge", tmp_path, "duration_s=110", checks, warp=8.0)
    assert run.summary.passed, run.summary.checks
    met = [event.text for event in run.happened("avoid", "b1") if "vessel-1" in event.text]
    assert "gives way to vessel-1, not under way" in met[0]
    first = next(event for event in run.happened("traffic", "b1") if "gives way" in event.text)
    assert 25.0 < float(first.text.split(" m off")[0].split(", ")[-1]) < 60.0
    assert not [
        event for event in run.happened("sensor") if "lidar: no scans" in event.text and run.t(event.stamp_ns) > 0.0
    ]


def test_a_scanner_that_dies_is_named_the_boat_sails_on_and_it_is_used_again_when_it_is_back(tmp_path: Path) -> None:
    events = ", ".join(
        f'{{ at_s = {at_s}, do = "{do}", boats = ["b1"] }}' for at_s, do in ((6.0, "lidar-down"), (18.0, "lidar-up"))
    )
    exact = "environment.gnss_sigma_m=0"  # else the boats may make way for each other, 15 m apart as they are
    run = sail("barge", tmp_path, "duration_s=40", exact, f"timeline=[{events}]", "checks={collisions = 0}", warp=4.0)
    told = [(run.t(event.stamp_ns), event.text) for event in run.happened("sensor", "b1", after_s=5.0)]
    (lost_s, lost), (back_s, back) = told[0], told[-1]
    assert "lidar: " in lost
    assert 8.5 < lost_s < 14.0  # silent for 3 s
    assert back == "lidar: well again"
    assert 18.0 < back_s < 32.0
    assert run.modes("b1", 10.0, 18.0) == {"follow"}
