"""`search` for arrays: the same prices of the same candidates, several candidates at once where lanes are few.

Lanes leave as soon as no candidate can be better for them; what is left is worked off in blocks of about equal size.
The least price and, of equals, the first candidate do not depend on how they are grouped.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from fleet import ops
from fleet.avoidance.cost import Threat, legs, price_on_legs, price_straight
from fleet.avoidance.params import ScoringParams
from fleet.avoidance.search import Choice, Stance, back_of, candidates, change_of, speed_of
from fleet.avoidance.types import Own
from fleet.ops import FloatArray

_VALUES = 4096  # of one block: candidates times lanes
_MOST = 64  # candidates of one block
_SHARE = 0.75  # when fewer of the lanes are still open, the others are left behind
_NONE_YET, _NEVER = 1e300, 1e301


class _Table(Struct, frozen=True):
    """The candidates as columns (candidate, 1)."""

    price: FloatArray
    cos_a: FloatArray
    sin_a: FloatArray
    a: FloatArray
    factor: FloatArray
    prices: list[float]
    straight: NDArray[np.bool_]  # off the plan


@lru_cache(maxsize=64)
def _table(params: ScoringParams) -> _Table:
    table = candidates(params)

    def column(name: str) -> FloatArray:
        return np.array([[getattr(each, name)] for each in table])

    a = column("a")
    return _Table(
        column("price"), column("cos_a"), column("sin_a"), a, column("factor"),
        [each.price for each in table], a[:, 0] != 0.0,
    )  # fmt: skip


class _Lanes(Struct, frozen=True):
    """The lanes that are still open."""

    own: Own[FloatArray]
    threats: tuple[Threat[FloatArray], ...]
    stance: Stance[FloatArray]
    least: FloatArray
    best: NDArray[np.intp]
    number: NDArray[np.intp]


def search(
    own: Own[Any], threats: tuple[Threat[Any], ...], stance: Stance[Any], u_min: float, params: ScoringParams
) -> Choice[Any]:
    """As `fleet.avoidance.search.search`."""
    table = _table(params)
    count = len(own.x)
    least, best = np.full(count, _NONE_YET), np.full(count, -1)
    numbers = np.arange(count)
    lanes = _Lanes(own, threats, stance, least, best, numbers)
    first = 0
    while first < len(table.prices):
        unsettled = lanes.least > table.prices[first]
        left = int(np.count_nonzero(unsettled))
        if left == 0:
            break
        if left < _SHARE * len(lanes.least):
            least[lanes.number], best[lanes.number] = lanes.least, lanes.best
            lanes = ops._gather(lanes, np.flatnonzero(unsettled))
        last = min(first + max(1, min(_MOST, _VALUES // left)), len(table.prices))
        price = _prices(lanes, table, first, last, u_min, params)
        found = price.argmin(axis=0)
        lowest = price[found, np.arange(len(found))]
        better = lowest < lanes.least
        np.copyto(lanes.least, lowest, where=better)
        np.copyto(lanes.best, found + first, where=better)
        first = last
    least[lanes.number], best[lanes.number] = lanes.least, lanes.best
    return _choice(own, best, table)


def _prices(lanes: _Lanes, table: _Table, first: int, last: int, u_min: float, params: ScoringParams) -> FloatArray:
    """(candidate, lane); one that may not be chosen costs more than any other."""
    own, threats, least = lanes.own, lanes.threats, lanes.least
    price = np.empty((last - first, len(least)))
    rows = np.flatnonzero(table.straight[first:last]) + first
    if len(rows):
        cos_a, sin_a, factor = table.cos_a[rows], table.sin_a[rows], table.factor[rows]
        u = speed_of(own.u_d, factor, u_min, params)
        cx, cy = own.gx * cos_a - own.gy * sin_a, own.gx * sin_a + own.gy * cos_a
        own_price = (
            table.price[rows]
            + change_of(lanes.stance, table.a[rows], cx, cy, params)
            + factor * back_of(own, cx, cy, params)
        )
        own_price = _hurry(lanes, own_price, factor, params)
        price[rows - first] = price_straight(own_price, u * cx, u * cy, threats, least, params)
    for row in np.flatnonzero(~table.straight[first:last]) + first:
        u = speed_of(own.u_d, float(table.factor[row, 0]), u_min, params)
        own_price = table.prices[row] + change_of(lanes.stance, float(table.a[row, 0]), own.gx, own.gy, params)
        own_price = own_price + float(table.factor[row, 0]) * back_of(own, own.gx, own.gy, params)
        own_price = _hurry(lanes, own_price, table.factor[row], params)
        price[row - first] = price_on_legs(own_price, legs(own, u), threats, least, params)
    if (lanes.stance.yielding == 1.0).any():
        held_back = (lanes.stance.yielding == 1.0) & (table.factor[first:last] > params.yield_other_factor)
        np.copyto(price, _NEVER, where=held_back)
    return price


def _hurry(lanes: _Lanes, own_price: FloatArray, factor: FloatArray, params: ScoringParams) -> FloatArray:
    """The price with that of going on while it is time to yield to a companion."""
    dearer: FloatArray = np.where(
        factor > params.yield_companion_factor, own_price + params.hurry * lanes.stance.waiting, own_price
    )
    return dearer


def _choice(own: Own[FloatArray], best: NDArray[np.intp], table: _Table) -> Choice[FloatArray]:
    """The velocities of the candidates found; the plan where there is none."""
    none = best < 0
    cos_a, sin_a = table.cos_a[best, 0], table.sin_a[best, 0]
    return Choice(
        np.where(none, own.gx, own.gx * cos_a - own.gy * sin_a),
        np.where(none, own.gy, own.gx * sin_a + own.gy * cos_a),
        np.where(none, 1.0, table.factor[best, 0]),
        np.where(none | ~table.straight[best], 0.0, 1.0),
    )
