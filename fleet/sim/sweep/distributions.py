"""Numbers of a scenario: fixed, or drawn from a distribution. A draw is a hash of seed, case, boat and its number."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from msgspec import Struct, structs

from fleet.ops import FloatArray
from fleet.sim.batch.draws import Purpose, Words, begin, more, normal, uniform
from fleet.sim.batch.scenarios import IntArray

DRAWS_AGAIN = 200  # times, for a normal number beyond its limits; then it is put on the limit
FARTHEST = 6.0  # standard deviations that a normal number is ever off its mean


class Spread(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A distribution: exactly one of the first four."""

    even: tuple[float, ...] | None = None  # [low, high)
    log_even: tuple[float, ...] | None = None  # [low, high), each octave as often as the next
    normal: tuple[float, ...] | None = None  # [mean, standard deviation]
    one_of: tuple[float, ...] | None = None  # each as often as the others
    within: tuple[float, ...] | None = None  # [low, high] that no normal number leaves: what does is drawn again

    @property
    def support(self) -> tuple[float, float]:
        """Lowest and highest number that can come."""
        if self.one_of is not None:
            return min(self.one_of), max(self.one_of)
        if self.normal is not None:
            mean, sigma = self.normal
            low, high = self.within or (-math.inf, math.inf)
            return max(low, mean - FARTHEST * sigma), min(high, mean + FARTHEST * sigma)
        low, high = self.even or self.log_even or (0.0, 0.0)
        return low, high

    def at(self, h: Words) -> FloatArray:
        """The numbers that belong to some hashes."""
        if self.one_of is not None:
            choices = np.array(self.one_of)
            return choices[(uniform(h) * len(choices)).astype(np.intp)]
        if self.normal is not None:
            return self._normal(h)
        low, high = self.even or self.log_even or (0.0, 0.0)
        if self.even is not None:
            return low + (high - low) * uniform(h)
        octaves = math.log(high / low)
        values = [
            low * math.exp(octaves * share) for share in uniform(h).ravel().tolist()
        ]  # alike alone and among many
        return np.array(values).reshape(h.shape)

    def _normal(self, h: Words) -> FloatArray:
        """Normal numbers, those beyond the limits drawn again."""
        assert self.normal is not None
        mean, sigma = self.normal
        value = mean + sigma * normal(h, 0)
        if self.within is None:
            return value
        low, high = self.within
        for again in range(1, DRAWS_AGAIN):
            out = (value < low) | (value > high)
            if not out.any():
                break
            value[out] = mean + sigma * normal(more(h[out], again), 0)
        return np.clip(value, low, high)


Drawn: TypeAlias = float | Spread
"""A number, or where it comes from."""


def support(value: Drawn) -> tuple[float, float]:
    """Lowest and highest number that can come."""
    return value.support if isinstance(value, Spread) else (value, value)


def radians(value: Drawn) -> Drawn:
    """Of degrees."""
    if not isinstance(value, Spread):
        return math.radians(value)
    fields = {name: getattr(value, name) for name in value.__struct_fields__}
    return Spread(**{name: tuple(map(math.radians, given)) if given else None for name, given in fields.items()})


def never_negative(value: Drawn) -> bool:
    """Whether no number below zero can come."""
    return support(value)[0] >= 0.0


class Draw:
    """Numbers for some cases. Draws are numbered one after the other; what is fixed has no number."""

    def __init__(self, seed: int, case: IntArray, boats: int, attempt: int = 0, used: int = 0) -> None:
        self._seed, self._case, self._boats, self._attempt = seed, case, boats, attempt
        self.used = used

    def per_boat(self, value: Drawn) -> FloatArray:
        """(B, K) one for each boat."""
        return self._numbers(value, np.arange(self._boats)[None, :])

    def per_scenario(self, value: Drawn) -> FloatArray:
        """(B,) one for each scenario."""
        return self._numbers(value, np.array([[-1]]))[:, 0]

    def _numbers(self, value: Drawn, boat: IntArray) -> FloatArray:
        if not isinstance(value, Spread):
            return np.full((len(self._case), boat.shape[1]), float(value))
        self.used += 1
        purpose = int(Purpose.START) + self.used
        return value.at(begin(self._seed, self._case[:, None], boat, boat, self._attempt, purpose))


def unfit(value: Spread) -> str | None:
    """What is wrong with a distribution, or None."""
    kinds = [name for name in ("even", "log_even", "normal", "one_of") if getattr(value, name) is not None]
    if len(kinds) != 1:
        found = f"; got {' and '.join(kinds)}" if kinds else ""
        return f"expected exactly one of even, log_even, normal, one_of{found}"
    kind = kinds[0]
    numbers: tuple[float, ...] = getattr(value, kind)
    if kind == "one_of":
        wrong = None if numbers else "expected at least one number to choose from"
    elif len(numbers) != 2:
        wrong = f"{kind}: expected {'[mean, standard deviation]' if kind == 'normal' else '[low, high]'}"
    elif kind == "normal":
        wrong = (
            None if numbers[1] >= 0.0 else f"normal: expected a standard deviation of at least 0, got {numbers[1]:g}"
        )
    elif numbers[0] > numbers[1]:
        wrong = f"{kind}: low {numbers[0]:g} above high {numbers[1]:g}"
    elif kind == "log_even" and numbers[0] <= 0.0:
        wrong = f"log_even: expected low above 0, got {numbers[0]:g}"
    else:
        wrong = None
    return wrong or _unfit_within(value)


def _unfit_within(value: Spread) -> str | None:
    """What is wrong with the limits of a distribution."""
    if value.within is None:
        return None
    if value.normal is None:
        return "within: only with normal"
    if len(value.within) != 2 or value.within[0] > value.within[1]:
        return "within: expected [low, high], low not above high"
    low, high = structs.replace(value, within=None).support
    return (
        None
        if value.within[0] <= high and value.within[1] >= low
        else "within: no number of normal can come to lie there"
    )
