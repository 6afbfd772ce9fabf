"""The overtaking with `--driver mavlink`: real agents, real MAVLink to simulated autopilots, and a pilot."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sim.sailed import sail

pytestmark = pytest.mark.sails
PILOT = str(Path(__file__).with_name("pilot.toml"))


def test_the_overtaking_holds_its_bands_through_autopilots(tmp_path: Path) -> None:
    run = sail("overtaking", tmp_path, driver="mavlink", warp=8.0)
    assert run.summary.passed, run.summary.checks
    judged = {one.name: one.by for one in run.summary.checks}
    assert judged["speed_min_mps"] == "setpoint_min_mps", "limits of speed hold for the set-points"
    assert run.summary.speed_min_mps is not None
    assert run.summary.speed_min_mps >= 0.6, "the autopilot swings below the least of them by 0.07 m/s"
    assert run.summary.min_separation_m is not None
    assert run.summary.min_separation_m >= 6.0
    for boat in ("b1", "b2"):
        armed = [e for e in run.happened("autopilot", boat) if e.text == "Throttle armed"]
        assert len(armed) == 1, "the launch arms, once"
        asked = [s.u_d_mps for s in run.own_states[boat] if s.mode == "follow" and s.u_d_mps is not None]
        assert 0.7 - 1e-9 <= min(asked) <= max(asked) <= 1.3 + 1e-9, "the limits hold for the set-points"


def test_a_pilot_takes_a_boat_and_gives_it_back_and_a_restarted_autopilot_waits_for_an_operator(tmp_path: Path) -> None:
    run = sail(PILOT, tmp_path, driver="mavlink", warp=4.0)
    assert run.modes("b1", 12.0, 21.0) == {"neutral"}
    assert run.reasons("b1", 12.0, 21.0) >= {"somebody else commands the boat"}
    assert run.speed("b1", 21.0) < 0.1
    assert run.modes("b1", 25.0, 31.0) <= {"follow", "avoid"}
    assert run.modes("b2", 12.0, 31.0) <= {"neutral", "fault"}
    assert run.speed("b2", 31.0) < 0.1
    assert "the autopilot was restarted" in {e.text for e in run.happened("autopilot", "b2")}
