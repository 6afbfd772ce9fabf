"""A boat meets a ship in lock-step: recorded, replayed bit for bit, the same from run to run, and put into figures."""

from __future__ import annotations

from pathlib import Path

import pytest

from fleet.analysis.metrics import summarise
from fleet.analysis.replay import replay
from fleet.analysis.series import load as series
from fleet.mission.load import load
from fleet.sim.lockstep import LockstepRun, Options, sail_lockstep

CLOSE = (
    "duration_s=45",
    "timeline=[]",
    "traffic.ferry.track={kind='course', start=[110.0, 190.0], course_deg=270.0}",
    "traffic.ferry.sensed={kind='ais', interval_s=2.0}",
    "checks={contacts=0, min_domain=1.0}",
)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> LockstepRun:
    return sail_lockstep(load("ship", CLOSE, 2), "ship", Options(root=str(tmp_path_factory.mktemp("runs"))))


def test_what_boats_decided_about_a_ship_replays_bit_for_bit(run: LockstepRun) -> None:
    again = replay(run.folder)
    assert again.same, again.lines()
    assert again.ticks > 800
    assert not any(boat.skipped for boat in again.boats)


def test_the_same_run_without_recording_has_the_same_digest(run: LockstepRun, tmp_path: Path) -> None:
    again = sail_lockstep(load("ship", CLOSE, 2), "ship", Options(root=str(tmp_path), record=False))
    assert again.digest == run.digest


def test_the_ship_is_in_the_recording_and_in_the_figures(run: LockstepRun) -> None:
    found = series(run.folder)
    assert set(found.traffic) == {"ferry"}
    assert found.traffic["ferry"].length_m == 40.0
    assert found.boats == ["b1", "b2"]
    summary = summarise(run.folder)
    assert summary.passed, summary.checks
    assert summary.min_traffic_m is not None
    assert summary.min_traffic_m > 10.0
    assert any(event.kind == "avoid" and "gives way to ferry" in event.text for event in found.events)
