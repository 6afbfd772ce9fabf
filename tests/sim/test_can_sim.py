"""Real agents with the `can` driver: each boat a bus and a thruster controller of its own, on the catamaran's hull."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sim.sailed import sail

pytestmark = pytest.mark.sails
COLUMN = str(Path(__file__).with_name("column.toml"))
DRIVER, SOMEBODY = "the driver cannot command the boat", "somebody else commands the boat"


def test_the_overtaking_holds_its_checks_over_can(tmp_path: Path) -> None:
    run = sail("overtaking", tmp_path, driver="can")
    assert run.summary.passed, run.summary.checks
    fastest = max(truth.u_mps for truths in run.truths.values() for truth in truths if truth.u_mps is not None)
    assert fastest < 1.30 * 1.02  # set-points stay within 1.3 m/s; the hull may make 2 % more of them


def test_a_bus_that_fails_and_a_pilot_are_each_said_and_sailed_out_of(tmp_path: Path) -> None:
    events = ", ".join(
        f'{{ at_s = {at_s}, do = "{do}", boats = ["{boat}"] }}'
        for at_s, do, boat in (
            (6.0, "bus-off", "b1"),
            (14.0, "bus-on", "b1"),
            (18.0, "pilot-takes", "b3"),
            (26.0, "pilot-gives", "b3"),
        )
    )
    run = sail(COLUMN, tmp_path, "duration_s=60", f"timeline=[{events}]", driver="can", warp=4.0)
    assert run.modes("b1", 8.5, 13.0) == {"neutral"} or run.modes("b1", 8.5, 13.0) == {"fault"}
    assert DRIVER in run.reasons("b1", 8.5, 13.0)
    assert run.speed("b1", 14.0) < 0.6
    assert SOMEBODY in run.reasons("b3", 20.0, 25.0)
    assert run.modes("b3", 20.0, 25.0) == {"neutral"}
    assert run.speed("b3", 26.0) < 0.6
    assert run.modes("b1", 50.0, 60.0) == run.modes("b3", 50.0, 60.0) == {"follow"}
    assert run.summary.collisions == 0
