"""Voyages of wingmen are worked out before they are needed, not in the tick that takes a mission or a change."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec import structs

from fleet.agent import flights
from fleet.agent.flights import Flights
from fleet.mission.load import load
from fleet.mission.model import Event
from fleet.mission.plan import build
from tests.agent.test_patterns import under_way, wingman

PLAN = build(load("wingman"))


def test_what_was_worked_out_is_not_worked_out_again(monkeypatch: pytest.MonkeyPatch) -> None:
    known = Flights()
    first = known.prepare(PLAN, PLAN.shape)
    assert first.mates(0) == {1}
    monkeypatch.setattr(flights, "wingmen", None)
    assert known.prepare(PLAN, PLAN.shape) is first


def test_another_cruise_speed_is_another_flight() -> None:
    known = Flights()
    slower = structs.replace(PLAN.shape, cruise_mps=0.8)
    assert known.prepare(PLAN, slower) is not known.prepare(PLAN, PLAN.shape)


def test_the_tick_that_takes_a_mission_or_a_change_finds_it_there(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []
    real: Any = flights.wingmen

    def counted(plan: Any, shape: Any, need: float) -> Any:
        asked.append(shape.cruise_mps)
        return real(plan, shape, need)

    monkeypatch.setattr(flights, "wingmen", counted)
    with under_way(wingman(timeline=(Event(at_s=900.0, do="hold"),), duration_s=901.0)) as voyage:
        assert asked == [1.0, 1.0]  # once on each boat, when it read the mission
        assert voyage.fleet.set_speed(0.9).ok
        assert asked == [1.0, 1.0, 0.9, 0.9]  # when the change was judged
        voyage.sail(4.0)
        assert voyage.agent("b2").orders.sailing.shape.cruise_mps == 0.9  # type: ignore[union-attr]
        assert len(asked) == 4
