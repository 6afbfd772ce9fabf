"""Benches that are cleared away after each test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from tests.drivers.mavlink.bench import Bench


@pytest.fixture
def bench_of() -> Iterator[Callable[..., Bench]]:
    """Makes benches."""
    made: list[Bench] = []

    def make(**more: Any) -> Bench:
        made.append(Bench(**more))
        return made[-1]

    yield make
    for bench in made:
        bench.close()


@pytest.fixture
def bench(bench_of: Callable[..., Bench]) -> Bench:
    """A boat whose autopilot has been running for a while, in MANUAL."""
    return bench_of()


@pytest.fixture
def driven(bench: Bench) -> Bench:
    """A boat at 1 m/s under an operator's orders."""
    bench.launch()
    bench.run(15.0, (1.0, 0.0))
    assert bench.state.u == pytest.approx(1.0, abs=0.1)
    return bench
