"""The overtaking with `--driver mavlink`: real agents, real MAVLink to simulated autopilots, and a pilot."""

from __future__ import annotations

import msgspec
import pytest

from fleet.drivers.mavlink.words import MANUAL
from fleet.sim.sail import Progress, Sailing
from fleet.sim.world_process import Trouble
from tests.sim.sailed import Deed, sail

pytestmark = pytest.mark.sails
OVERSHOOT = "checks.speed_min_mps=0.6"  # set-points keep to 0.7, the autopilot swings below by 0.07


def breaks(boat: str, kind: str, value: float = 0.0) -> Deed:
    """Something happens to a boat's autopilot."""

    def deed(sailing: Sailing, progress: Progress) -> None:
        sailing._truth.send(msgspec.msgpack.encode(Trouble(boat, kind, value)))

    return deed


def test_the_overtaking_holds_its_bands_through_autopilots(tmp_path) -> None:  # type: ignore[no-untyped-def]
    run = sail("overtaking", tmp_path, OVERSHOOT, driver="mavlink", warp=6.0)
    assert run.summary.passed, run.summary.checks
    assert run.summary.min_separation_m is not None
    assert run.summary.min_separation_m >= 6.0
    for boat in ("b1", "b2"):
        armed = [e for e in run.happened("autopilot", boat) if e.text == "Throttle armed"]
        assert len(armed) == 1, "the launch arms, once"
        asked = [s.u_d_mps for s in run.own_states[boat] if s.mode == "follow" and s.u_d_mps is not None]
        assert 0.7 - 1e-9 <= min(asked) <= max(asked) <= 1.3 + 1e-9, "the limits hold for the set-points"


def test_a_pilot_takes_a_boat_and_an_autopilot_restarts(tmp_path) -> None:  # type: ignore[no-untyped-def]
    at = {10.0: breaks("b1", "pilot", MANUAL), 12.0: breaks("b2", "reboot")}
    run = sail("overtaking", tmp_path, "duration_s=25", "timeline=[]", "checks={}", driver="mavlink", warp=4.0, at=at)
    assert run.modes("b1", 11.0, 24.0) == {"neutral"}
    assert run.reasons("b1", 11.0, 24.0) >= {"somebody else commands the boat"}
    assert run.speed("b1", 24.0) < 0.1
    assert run.modes("b2", 14.0, 24.0) <= {"neutral", "fault"}
    assert run.speed("b2", 24.0) < 0.1
