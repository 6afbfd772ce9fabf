"""Two boats meet: what is drawn is what its name says, and a part of the random starts is sailed."""

from __future__ import annotations

import numpy as np
import pytest

from fleet import ops
from fleet.sim.batch import run
from tests.proofs.meetings import CROSSING_DEG, HEAD_ON_DEG, delay_s, kinds, meeting


@pytest.mark.parametrize("between_deg", [HEAD_ON_DEG, CROSSING_DEG])
def test_meetings_are_of_the_kind_that_was_asked_for(between_deg: tuple[float, float]) -> None:
    drawn = meeting(between_deg, 60)
    apart = np.degrees(abs(ops.wrap(drawn.psi[:, 1] - drawn.psi[:, 0])))
    assert drawn.count == 60
    assert apart.min() >= between_deg[0]
    assert apart.max() <= between_deg[1]


@pytest.mark.parametrize("name", ["swap", "head-on", "crossing"])
def test_nobody_touches_and_nobody_stands_still(name: str) -> None:
    scenarios = kinds(40)[name]
    found = run(scenarios)
    assert not found.failed.size
    assert found.least_m.min() > 6.0
    assert np.median(delay_s(scenarios, found)) < (90.0 if name == "swap" else 5.0)
