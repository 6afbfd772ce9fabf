"""The reference runs: a law that decides otherwise, if only in the last bit, shows here.

Changed on purpose? `python -m fleet.sim.lockstep_reference --accept` shows the differences and keeps the new runs.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from fleet import coordination, ops
from fleet.agent import step as step_module
from fleet.avoidance import scoring
from fleet.avoidance.params import ScoringParams
from fleet.sim.lockstep_reference import CASES, accept, compare, lines, sail, unlike_numbers

FOLDER = Path(__file__).with_name("reference")


def test_the_laws_decide_as_they_did_when_they_were_accepted() -> None:
    found = compare(FOLDER)
    assert all(one.same for one in found.values()), "\n".join(lines(found))


def test_the_numbers_inside_of_the_laws_are_those_that_were_accepted() -> None:
    assert unlike_numbers(FOLDER) == []


def test_a_price_re_associated_is_found_although_every_boat_decides_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    def total(own: float, worst: float, crowd: float, hardest: float, wrong: float, p: ScoringParams) -> float:
        """30 (a + b) is now 30 a + 30 b."""
        rest = p.crowd * crowd + p.hard * hardest
        return own + ((p.collision * worst + p.collision * rest) + p.wrong_side * wrong)

    monkeypatch.setattr(scoring, "total", total)
    assert all(one.same for one in compare(FOLDER).values())
    assert "fleet.avoidance.scoring._plan" in unlike_numbers(FOLDER)


def test_reference_runs_are_small() -> None:
    for case in CASES:
        assert (FOLDER / f"{case}.mcap").stat().st_size < 300_000


def test_sailing_a_reference_run_twice_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.mcap", "b.mcap"):
        sail("comes-back", tmp_path / name)
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_one_expression_re_associated_is_found_and_accepted_with_its_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    accept(tmp_path)

    def re_associated(e: float, cruise: float, u_min: float, u_max: float, gain: float) -> float:
        """C + (u_max - C) tanh is now (C - C tanh) + u_max tanh."""
        limit, t = (u_max, ops.tanh(gain * e)) if e > 0.0 else (u_min, -ops.tanh(gain * e))
        return (cruise - cruise * t) + limit * t

    assert step_module.formation_speed is coordination.formation_speed
    monkeypatch.setattr(step_module, "formation_speed", re_associated)
    found = compare(tmp_path)
    assert not found["circuit"].same
    assert any("u_plan: first at tick" in line for line in lines(found))
    assert 0.0 < max(d.size for d in found["circuit"].differences if d.field == "u_plan") < 1e-14
    assert not accept(tmp_path)["circuit"].same  # shown once more while accepting
    assert all(one.same for one in compare(tmp_path).values())
