"""Every manoeuvre against a vessel that turns: what is possible is found, and what is not is not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fleet.sim.batch.ships import Ship, ShipCase, Voyage, ship_track
from tests.proofs.sudden import best


def met(beside_m: float, length: float) -> tuple[ShipCase, Voyage]:
    """A vessel of 8 m/s sails so far beside a boat of 0.5 m/s and turns towards it by 90 deg at 10 s."""
    ship = Ship(x=6.0, y=beside_m, chi=0.0, U=8.0, length=length, turns_s=10.0, turn=-math.pi / 2.0, rate=0.4)
    case = ShipCase(
        suite="by hand",
        seed=1,
        case=0,
        cruise=0.5,
        paths=((100.0, 0.0, 0.0),),
        ships=(ship,),
        meet_s=20.0,
        limit_s=60.0,
    )
    t = np.arange(600) * 0.1
    x, zero = (100.0 + 0.5 * t)[:, None], np.zeros((600, 1))
    track = [each[:, None] for each in ship_track(ship, 600)]
    return case, Voyage(t, x, zero, zero, zero + 0.5, *track, (), True)


@pytest.mark.parametrize(("beside_m", "avoidable"), [(45.0, False), (160.0, True)])
def test_a_long_vessel_that_turns_right_beside_a_slow_boat_hits_it_whatever_it_does(
    beside_m: float, avoidable: bool
) -> None:
    """45 m: its bow is there in 4 s, with a beam of 12 m. 160 m: 17 s, and 14 m away at 1.5 m/s."""
    case, voyage = met(beside_m, 60.0)
    found = best(case, voyage, 0.0)
    assert found is not None
    assert (found.hull_m > 0.0) == avoidable


def test_the_later_the_less_is_possible_and_nothing_when_all_is_over() -> None:
    case, voyage = met(160.0, 60.0)
    now, later = best(case, voyage, 0.0), best(case, voyage, 15.0)
    assert now is not None
    assert later is not None
    assert now.hull_m > later.hull_m
    assert now.domain >= later.domain
    assert best(case, voyage, 60.0) is None


def test_what_has_happened_by_then_is_not_undone_by_a_manoeuvre_after_it() -> None:
    case, voyage = met(45.0, 60.0)
    late = best(case, voyage, 35.0)
    assert late is not None
    assert late.hull_m <= 0.0
    assert late.domain < 1.0
