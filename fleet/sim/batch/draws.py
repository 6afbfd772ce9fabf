"""Random numbers as hashes of (seed, case, sender, receiver, tick, purpose): alike in a lane and alone.

The hash is that of `fleet.wire.radio`, a part at a time, so that what is the same in every tick is mixed once.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray

from fleet.ops import FloatArray

Words: TypeAlias = NDArray[np.uint64]
_MASK = (1 << 64) - 1
_GOLDEN, _M1, _M2 = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB


class Purpose(IntEnum):
    """What a number is drawn for."""

    LOSS = 1
    DRIFT_N = 10
    DRIFT_E = 13
    WHITE_N = 20
    WHITE_E = 23
    VELOCITY_N = 30
    VELOCITY_E = 33
    START = 100  # of a scenario; families add their own count


def _words(part: Any) -> Any:
    """Whole numbers as unsigned words, negative ones modulo 2**64."""
    if isinstance(part, np.ndarray):
        return part.astype(np.uint64)
    return np.uint64(int(part) & _MASK)


@overload
def more(h: int, part: int) -> int: ...
@overload
def more(h: Words, part: int | NDArray[np.intp]) -> Words: ...
def more(h: Any, part: Any) -> Any:
    """A hash with one more part (splitmix64); `more(more(0, a), b)` is `fleet.wire.radio.mix(a, b)`."""
    if type(h) is int:
        h = (h + (part & _MASK) + _GOLDEN) & _MASK
        h = ((h ^ (h >> 30)) * _M1) & _MASK
        h = ((h ^ (h >> 27)) * _M2) & _MASK
        return h ^ (h >> 31)
    h = h + _words(part) + np.uint64(_GOLDEN)
    h = (h ^ (h >> np.uint64(30))) * np.uint64(_M1)
    h = (h ^ (h >> np.uint64(27))) * np.uint64(_M2)
    return h ^ (h >> np.uint64(31))


def begin(*parts: int | NDArray[np.intp]) -> Words:
    """The hash of some parts, broadcast against each other."""
    shape = np.broadcast_shapes(*(np.shape(part) for part in parts))
    h: Words = np.zeros(shape if shape else (1,), dtype=np.uint64)
    for part in parts:
        h = more(h, part)
    return h


@overload
def uniform(h: int) -> float: ...
@overload
def uniform(h: Words) -> FloatArray: ...
def uniform(h: Any) -> Any:
    """A number in [0, 1)."""
    if type(h) is int:
        return (h >> 11) * (1.0 / (1 << 53))
    return (h >> np.uint64(11)).astype(np.float64) * (1.0 / (1 << 53))


@overload
def normal(h: int, purpose: int) -> float: ...
@overload
def normal(h: Words, purpose: int) -> FloatArray: ...
def normal(h: Any, purpose: int) -> Any:
    """A standard normal number, but never beyond 6: the sum of twelve uniform ones, exact in whole numbers."""
    total: Any = 0 if type(h) is int else np.zeros(h.shape, dtype=np.uint64)
    for k in range(3):
        word = more(h, purpose + k)
        for shift in (0, 16, 32, 48):
            if type(h) is int:
                total += (word >> shift) & 0xFFFF
            else:
                total = total + ((word >> np.uint64(shift)) & np.uint64(0xFFFF))
    value = float(total) if type(h) is int else total.astype(np.float64)
    return value * (1.0 / 65536.0) - (6.0 - 6.0 / 65536.0)
