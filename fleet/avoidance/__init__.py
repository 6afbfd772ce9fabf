"""Keeping clear of other vehicles: methods that are exchanged behind one seam (`types`).

A further method is one module and one entry in `METHODS`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

from msgspec import Struct

from fleet.avoidance import circle, pair, params, scoring

Side = Literal["closest", "starboard"]


class Method(Struct, frozen=True, kw_only=True):
    """One way of keeping clear. Memory and params are the method's own; whoever calls only hands them on."""

    name: str
    description: str  # one line for the operator
    params: Callable[[float, Side], Any]  # (safety radius R [m], rule of the side) -> params
    start: Callable[[Any, int], Any]  # (like, number of peers) -> memory
    keep_clear: Callable[..., Any]  # (own, peers, memory, limits, params, dt [s]) -> (memory, Advice)
    memory: Any  # type of the memory of one boat, for msgspec to decode
    align: Callable[[Any, Sequence[float], Sequence[float]], Any]  # (memory, old numbers, new numbers) -> memory


def _scoring_params(radius_m: float, side: Side) -> params.ScoringParams:  # noqa: ARG001 - its sides are its own
    return params.for_radius(radius_m)


def _circle_params(radius_m: float, side: Side) -> circle.CircleParams:
    return circle.CircleParams(radius_m=radius_m, side=side)


def _circle_align(
    memory: circle.CircleMemory[float],
    old_numbers: Sequence[float],  # noqa: ARG001 - the latch names its vehicle by number
    new_numbers: Sequence[float],  # noqa: ARG001
) -> circle.CircleMemory[float]:
    return memory


METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        Method(
            name="scoring",
            description="velocities scored by nearness, side and cost, with a last-moment brake (default)",
            params=_scoring_params,
            start=scoring.start_memory,
            keep_clear=scoring.keep_clear,
            memory=scoring.ScoringMemory[float],
            align=scoring.align,
        ),
        Method(
            name="circle",
            description="the safety circle of Bibuli et al. (2014), corrected; knows positions only",
            params=_circle_params,
            start=circle.start_memory,
            keep_clear=circle.keep_clear,
            memory=circle.CircleMemory[float],
            align=_circle_align,
        ),
    )
}
"""Every method by the name that a mission file gives it."""

__all__ = ["METHODS", "Method", "Side", "circle", "pair", "params", "scoring"]
