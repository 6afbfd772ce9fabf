"""Real agents that hear sentences of NMEA 0183 and AIS and nothing else, over a controller that has no sensors."""

from __future__ import annotations

from pathlib import Path

import pytest

from fleet.sim.suite import mmsi_of
from tests.sim.sailed import sail

pytestmark = pytest.mark.sails
UNDER_WAY = {"follow", "avoid"}
CALM_TICKS = 20  # late ones, of all boats: a machine that keeps up
STALLS = 0.2  # of the time: four stalls of a second at warp 4, with the 3 s until navigation is trusted again
MISSION = str(Path(__file__).with_name("aivdm.toml"))


def test_a_ship_known_by_aivdm_sentences_only_is_kept_clear_of(tmp_path: Path) -> None:
    run = sail(MISSION, tmp_path, driver="can", sensors="nmea", warp=4.0)
    assert run.summary.passed, run.summary.checks
    ferry = f"mmsi-{mmsi_of('ferry'):09d}"
    assert any(ferry in event.text for event in run.events), [event.text for event in run.events]
    assert {event.text for event in run.own["b1"] if event.kind == "sensor"} >= {"fix from nmea", "heading from nmea"}
    assert run.modes("b1", 90.0, 100.0) <= UNDER_WAY
    calm = (run.summary.ticks_late or 0) < CALM_TICKS
    for boat in ("b1", "b2"):  # a machine that stalls may stop it for some seconds; sentences alone never do
        late = [state for state in run.own_states[boat] if 15.0 <= run.t(state.stamp_ns) <= 100.0]
        stopped = [state for state in late if state.mode not in UNDER_WAY]
        assert len(stopped) < STALLS * len(late), [state.reasons for state in stopped]
        calm = calm and not stopped
        assert all("stale" in " ".join(state.reasons) for state in stopped if state.mode == "fault")
    for boat in ("b1", "b2"):  # whose hulls are under way all of a sudden, which takes the fusion some seconds
        last_ns = run.truths[boat][-1].stamp_ns
        told = [state for state in run.states[boat] if run.t(state.stamp_ns) > 5.0 and state.stamp_ns < last_ns]
        errors = sorted(run.position_error(boat, state) for state in told)
        assert len(errors) > 500
        assert errors[len(errors) // 2] < 1.0  # metres; fixes are wrong by 0.3 m (1 sigma per axis)
        if calm:  # what is 0.3 s late on the wall is 1.2 m away
            assert errors[int(0.95 * len(errors))] < 1.5
