"""Real agents that hear sentences of NMEA 0183 and AIS and nothing else, over a controller that has no sensors."""

from __future__ import annotations

from pathlib import Path

import pytest

from fleet.sim.suite import mmsi_of
from tests.sim.sailed import sail

pytestmark = pytest.mark.sails
MISSION = str(Path(__file__).with_name("aivdm.toml"))


def test_a_ship_known_by_aivdm_sentences_only_is_kept_clear_of(tmp_path: Path) -> None:
    run = sail(MISSION, tmp_path, driver="can", sensors="nmea", warp=4.0)
    assert run.summary.passed, run.summary.checks
    ferry = f"mmsi-{mmsi_of('ferry'):09d}"
    assert any(ferry in event.text for event in run.events), [event.text for event in run.events]
    assert {event.text for event in run.own["b1"] if event.kind == "sensor"} >= {"fix from nmea", "heading from nmea"}
    assert run.modes("b1", 90.0, 100.0) <= {"follow", "avoid"}  # a machine that stalls may stop it for a while before
    for boat in ("b1", "b2"):  # whose hulls are under way all of a sudden, which takes the fusion some seconds
        last_ns = run.truths[boat][-1].stamp_ns
        told = [state for state in run.states[boat] if run.t(state.stamp_ns) > 5.0 and state.stamp_ns < last_ns]
        errors = sorted(run.position_error(boat, state) for state in told)
        assert len(errors) > 500
        assert errors[int(0.95 * len(errors))] < 1.5  # metres; fixes are wrong by 0.3 m (1 sigma per axis)
