"""Laps on circuits, and the end of the path (DESIGN section 5)."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import pytest

from fleet.agent.modes import Mode, Reason
from fleet.mission.model import Start, Straight
from tests.agent.harness import CIRCUIT, Sea, mission, sailing

SHORT = Straight(start=(0.0, 0.0), end=(150.0, 0.0))


def errors(sea: Sea) -> list[float]:
    return [sea.agent(boat).decision.e for boat in sea.agents()]


@pytest.mark.parametrize("starts", [(30.0, 15.0, 110.0), (5.0, 110.0, 95.0), (110.0, 95.0, 80.0), (60.0, 30.0, 2.0)])
def test_on_a_circuit_boats_take_the_laps_that_are_nearest_their_slots(
    tmp_path: Path, starts: tuple[float, ...]
) -> None:
    sea = Sea(tmp_path, mission(3, 12.0, path=CIRCUIT, starts=[Start(s_m=s) for s in starts]))
    sea.run(0.5)
    assert all(ack.ok for ack in sea.launch().values())
    sea.run(2.5)
    length = sea.plan.boats[0].path.length
    z = [sea.state(boat).s_m + 12.0 * i for i, boat in enumerate(sea.agents())]
    assert max(z) - min(z) < length / 2.0 + 12.0, z
    sea.run(120.0)
    assert max(map(abs, errors(sea))) < 1.0


def test_a_boat_that_joins_late_takes_the_lap_of_the_others(tmp_path: Path) -> None:
    sea = Sea(
        tmp_path, mission(3, 12.0, path=CIRCUIT, starts=[Start(s_m=s) for s in (45.0, 30.0, 15.0)]), ashore=("b3",)
    )
    sea.run(0.5)
    sea.launch()
    sea.run(140.0)
    assert sea.state("b1").lap >= 1
    sea.stations["b3"].switch_on()
    sea.run(4.0)
    assert abs(sea.state("b3").s_m + 24.0 - sea.state("b1").s_m) <= sea.plan.boats[0].path.length / 2.0 + 12.0
    sea.run(150.0)
    assert max(map(abs, errors(sea))) < 1.0


def test_abscissas_go_on_growing_lap_after_lap(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0, path=CIRCUIT, starts=[Start(s_m=s) for s in (45.0, 30.0)]), 3.0)
    last = [0.0]

    def grows() -> None:
        s = sea.state("b1").s_m
        assert s > last[0] - 0.5
        last[0] = s

    sea.each_tick.append(grows)
    sea.run(250.0)
    assert last[0] > 2.0 * sea.plan.boats[0].path.length


def test_at_the_end_of_the_path_every_boat_holds_in_its_slot(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3, 12.0, path=SHORT), 5.0)
    sea.run_until(lambda: sea.modes() == [Mode.HOLD] * 3, 120.0)
    sea.run(60.0)
    for i, boat in enumerate(sea.agents()):
        assert sea.where(boat)[0] == pytest.approx(150.0 - 12.0 * i, abs=6.0)
        assert Reason.MISSION_ENDED in sea.reasons(boat)
    xs = [sea.where(boat)[0] for boat in sea.agents()]
    assert min(a - b for a, b in itertools.pairwise(xs)) > 7.0, "no two share an end point"


def test_a_boat_that_sails_alone_ends_at_its_own_slot_too(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3, 12.0, path=SHORT), 5.0)
    sea.cut("b3")
    sea.run(30.0)
    sea.mend("b3")
    sea.run_until(lambda: sea.mode("b3") == Mode.HOLD, 120.0)
    assert sea.where("b3")[0] == pytest.approx(126.0, abs=6.0)


def test_after_the_end_a_restarted_boat_still_holds(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0, path=SHORT), 5.0)
    sea.run_until(lambda: sea.modes() == [Mode.HOLD] * 2, 120.0)
    sea.run(5.0)
    x, y = sea.where("b2")
    sea.restart("b2")
    sea.run(30.0)
    assert sea.mode("b2") == Mode.HOLD
    assert math.dist((x, y), sea.where("b2")) < 8.0
