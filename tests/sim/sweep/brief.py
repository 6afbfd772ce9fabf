"""A family that is sailed in a second."""

from __future__ import annotations

import msgspec
import numpy as np

from fleet.sim.batch import Results
from fleet.sim.batch.results import PER_BOAT, PER_SCENARIO
from fleet.sim.sweep.family import loads
from fleet.sim.sweep.store import Sweep

BRIEF = """
name = "brief"
title = "Two boats meet soon"
boats = 2
cases = 5
duration_s = 20.0

[layout]
kind = "meeting"
cruise_mps = { even = [0.9, 1.1] }
meet_s = 9.0
aside_m = { even = [-1.0, 1.0] }
apart_m = 8.0

[checks]
collisions_max = 5
"""
GRID = BRIEF + '\n[grid]\n"keeping_clear.radius_m" = [3.0, 4.0]\n"radio.loss" = [0.0, 0.4]\n'
SEED = 7
ARRAYS = ("case", *PER_SCENARIO, *PER_BOAT)


def sweep(text: str = BRIEF, seed: int = SEED, **more: object) -> Sweep:
    """What to sail; `more` replaces fields."""
    return msgspec.structs.replace(Sweep.of(loads(text, overrides=[f"seed={seed}"]), "fleet sweep brief"), **more)


def same_bits(a: Results | None, b: Results | None) -> bool:
    """Every array of both, to the last bit."""
    assert a is not None
    assert b is not None
    return all(np.array_equal(getattr(a, name), getattr(b, name), equal_nan=True) for name in ARRAYS)
