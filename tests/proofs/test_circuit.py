"""A few of the random starts round the circuit."""

from __future__ import annotations

import numpy as np
import pytest

from tests.proofs.circuit import APART_M, LAP_M, mission, start


def test_starts_are_anywhere_on_the_circuit_and_apart() -> None:
    firsts = []
    for seed in range(40):
        places = sorted(boat.start.s_m or 0.0 for boat in mission(8, seed).boats)
        assert min(np.diff([*places, places[0] + LAP_M])) >= APART_M
        firsts.append(mission(8, seed).boats[0].start.s_m)
    assert np.ptp(firsts) > 0.8 * LAP_M


@pytest.mark.parametrize(("boats", "seed"), [(3, 0), (5, 1)])
def test_a_random_start_forms_up_without_touching(boats: int, seed: int) -> None:
    seen = start(boats, seed)
    assert seen.formed_s() < 150.0
    assert seen.least_m() > seen.length_m
