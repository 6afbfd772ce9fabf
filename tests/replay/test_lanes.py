"""A tick alone, and the same tick as one lane of a batch: the same bits; and where not, it is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from fleet import coordination, ops
from fleet.agent import step as step_module
from fleet.analysis.replay import replay
from fleet.mission.load import load
from fleet.mission.model import Event
from fleet.sim.lockstep import sail_lockstep
from fleet.sim.share import Options

REFERENCE = Path(__file__).with_name("reference")


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three boats of the circuit, one without navigation for a while, one that falls silent: masks and all modes."""
    mission = replace(
        load("circuit"),
        duration_s=20.0,
        timeline=(
            Event(at_s=4.0, do="gnss-down", boats=("b1",)),
            Event(at_s=8.0, do="kill", boats=("b3",)),
            Event(at_s=12.0, do="hold", boats=("b2",)),
        ),
    )
    return sail_lockstep(mission, "lanes", Options(root=str(tmp_path_factory.mktemp("lanes")))).folder


def test_every_tick_of_a_run_decides_alike_as_one_lane_of_a_hundred(sailed: Path) -> None:
    found = replay(sailed, lanes=100)
    assert found.same, found.lines()
    assert sum(boat.lanes for boat in found.boats) == found.ticks > 500
    for boat in found.boats:
        assert f"{boat.boat}: {boat.lanes} ticks decided as lanes of a batch, all alike" in found.lines()


@pytest.mark.parametrize("case", ["overtaking-scoring", "overtaking-circle", "comes-back"])
def test_the_reference_runs_decide_alike_as_lanes(case: str) -> None:
    found = replay(REFERENCE / f"{case}.mcap", lanes=300)
    assert not any(boat.lanes_differing for boat in found.boats), found.lines()
    assert sum(boat.lanes for boat in found.boats) == found.ticks


def test_without_being_asked_no_batch_is_decided(sailed: Path) -> None:
    assert all(boat.lanes == 0 for boat in replay(sailed).boats)


def test_one_expression_re_associated_for_arrays_only_is_found(sailed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    law = coordination.formation_speed

    def re_associated(e: Any, cruise: Any, u_min: Any, u_max: Any, gain: Any) -> Any:
        """C + (u_max - C) tanh is (C - C tanh) + u_max tanh, in a batch."""
        if type(e) is float:
            return law(e, cruise, u_min, u_max, gain)
        t = ops.tanh(gain * e)
        limit = ops.where(e > 0.0, u_max, u_min)
        t = ops.where(e > 0.0, t, -t)
        return (cruise - cruise * t) + limit * t

    monkeypatch.setattr(step_module, "formation_speed", re_associated)
    found = replay(sailed, lanes=100)
    assert found.exit_code == 1
    assert not any(boat.differing for boat in found.boats)
    assert any(boat.lanes_differing for boat in found.boats)
    assert {one.field for one in found.differences} <= {"lane.u_plan", "lane.u_d", "lane.straight"}
    assert 0.0 < max(one.size for one in found.differences if one.field == "lane.u_plan") < 1e-14
