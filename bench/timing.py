"""CPU time of small pieces of work, each measured between two runs of the same calibration loop."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable

from msgspec import Struct

REFERENCE_US = 9.0  # the calibration loop on the machine for which the budgets are stated
CALIBRATION = "calibration"


def calibration() -> float:
    """A hundred steps of plain float arithmetic, as laws are made of: the unit of speed of this machine, now."""
    x, y = 1.0, 0.5
    for k in range(100):
        x = 0.5 * (x + y) + 1e-9 * k
        y = x * y - 0.25 * y if x > y else y + 0.125
    return x


class Timed(Struct, frozen=True):
    """Medians over repetitions."""

    us: float  # CPU of one call
    unit_us: float  # CPU of the calibration loop, measured in between
    ratio: float  # median of the quotients

    @property
    def scale(self) -> float:
        """How much slower this machine is now than the reference."""
        return self.unit_us / REFERENCE_US


def _spent_us(work: Callable[[], object], times: int) -> float:
    began = time.thread_time_ns()
    for _ in range(times):
        work()
    return (time.thread_time_ns() - began) * 1e-3 / times


def timed(work: Callable[[], object], repetitions: int = 25, batch_us: float = 3000.0) -> Timed:
    """CPU of one call of `work`, with the collector off: medians over repetitions of about 3 ms."""
    gc.collect()
    gc.disable()
    try:
        once = max(_spent_us(work, 5), 0.05)
        times = max(3, int(batch_us / once))
        spent: list[float] = []
        units: list[float] = []
        for _ in range(repetitions):
            before = _spent_us(calibration, 50)
            spent.append(_spent_us(work, times))
            units.append(0.5 * (before + _spent_us(calibration, 50)))
    finally:
        gc.enable()
    quotients = [us / unit for us, unit in zip(spent, units, strict=True)]
    return Timed(statistics.median(spent), statistics.median(units), statistics.median(quotients))


def percentile(values: list[float], share: float) -> float:
    """The value below which so much of the sorted values lies; 0 of none."""
    if not values:
        return 0.0
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]
