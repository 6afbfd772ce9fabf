"""The ready families of `fleet sweep` by function: for tests and benchmarks, which change more than a file can say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from msgspec import structs

from fleet.sim.batch.scenarios import PER_BOAT, PER_BOAT_LATER, PER_SCENARIO, IntArray, Scenarios
from fleet.sim.sweep.family import load


def _drawn(
    family: str, cases: int | IntArray, seed: int, boats: int, overrides: Sequence[str], given: dict[str, Any]
) -> Scenarios:
    """The first so many cases, or those given, of a family's first point; `given` replaces fields of Scenarios."""
    case = np.arange(cases) if isinstance(cases, int) else np.asarray(cases, dtype=np.intp)
    drawn = load(family, overrides, boats=boats).scenarios(seed, 0, case)
    for name, value in given.items():
        if name in PER_SCENARIO:
            given[name] = np.array(np.broadcast_to(np.asarray(value, dtype=float), drawn.case.shape))
        elif name in PER_BOAT or name in PER_BOAT_LATER:
            given[name] = np.array(np.broadcast_to(np.asarray(value, dtype=float), drawn.x.shape))
    return structs.replace(drawn, **given)


def crossing(cases: int | IntArray, seed: int, boats: int = 8, **given: Any) -> Scenarios:
    """So many boats that meet near one point."""
    return _drawn("crossing", cases, seed, boats, (), given)


def two_boat(cases: int | IntArray, seed: int, **given: Any) -> Scenarios:
    """Two boats from all round: head-on, crossing, overtaking."""
    return _drawn("two-boat", cases, seed, 2, (), given)


def four(cases: int | IntArray, seed: int, **given: Any) -> Scenarios:
    """Four boats that meet near one point."""
    return _drawn("four", cases, seed, 4, (), given)


def antipodal(cases: int | IntArray, seed: int, boats: int = 8, radius: float | None = None, **given: Any) -> Scenarios:
    """Boats on a circle, each bound for the opposite point; radius by the number of boats if None [m]."""
    return _drawn("antipodal", cases, seed, boats, [] if radius is None else [f"layout.radius_m={radius}"], given)


def swap(
    cases: int | IntArray, seed: int, boats: int = 2, limit_s: float | None = None, current: float = 0.3, **given: Any
) -> Scenarios:
    """A column whose spacing goes from +D to -D after 30 s; D is 15 to 25 m for two boats, 13 to 17 m for more."""
    spacing = [] if boats == 2 else ["formation.spacing_m={even=[13, 17]}"]
    time_s = limit_s if limit_s is not None else 30.0 + (270.0 if boats == 2 else 800.0)
    overrides = [*spacing, f"duration_s={time_s}", f"environment.current_mps={{even=[0, {current}]}}"]
    return _drawn("swap", cases, seed, boats, overrides, given)


def lossy(
    cases: int | IntArray,
    seed: int,
    boats: int = 5,
    loss: Any = 0.3,
    delay_s: Any = 0.5,
    limit_s: float = 300.0,
    **given: Any,
) -> Scenarios:
    """A column of 15 m that opens to 20 m after 100 s and closes again after 200 s, through loss and delay."""
    given |= {"loss": loss, "delay_s": delay_s, "limit_s": limit_s}
    return _drawn("lossy", cases, seed, boats, ["radio.loss=0", "radio.delay_s=0"], given)


FAMILIES: dict[str, Callable[..., Scenarios]] = {
    "two-boat": two_boat,
    "four": four,
    "crossing": crossing,
    "antipodal": antipodal,
    "swap": swap,
    "lossy": lossy,
}
"""Functions by name: (cases, seed, ...) -> Scenarios."""
