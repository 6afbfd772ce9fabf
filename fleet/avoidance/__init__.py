"""Keeping clear of other vehicles: methods that are exchanged behind one seam (`types`).

A further method is one module and one entry in `METHODS`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

from msgspec import Struct, structs

from fleet.avoidance import circle, pair, params, scoring
from fleet.plugins import Kinds

CLOSER = 3.5 / 6.0
"""Share of the safety radius that boats of the fleet keep from each other while a foreign vessel decides."""
CLOSER_S = params.ScoringParams().together_s
"""And so far ahead: a formation that turns together is not on its way into itself for longer."""
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
    closer: Callable[[Any], Any]  # params -> those that keep less, and only soon: while a foreign vessel decides


def _scoring_params(radius_m: float, side: Side) -> params.ScoringParams:  # noqa: ARG001 - its sides are its own
    return params.for_radius(radius_m)


def _scoring_closer(keep: params.ScoringParams) -> params.ScoringParams:
    soon = CLOSER_S
    return structs.replace(
        keep,
        wanted_m=keep.companion_m,
        horizon_max_s=soon,
        horizon_min_s=soon,
        horizon_unknown_s=soon,
    )


def _circle_closer(keep: circle.CircleParams) -> circle.CircleParams:
    return structs.replace(keep, radius_m=CLOSER * keep.radius_m)


def _circle_params(radius_m: float, side: Side) -> circle.CircleParams:
    return circle.CircleParams(radius_m=radius_m, side=side)


def _circle_align(
    memory: circle.CircleMemory[float],
    old_numbers: Sequence[float],  # noqa: ARG001 - the latch names its vehicle by number
    new_numbers: Sequence[float],  # noqa: ARG001
) -> circle.CircleMemory[float]:
    return memory


_BUILT_IN = (
    Method(
        name="scoring",
        description="velocities scored by nearness, side and cost, with a last-moment brake (default)",
        params=_scoring_params,
        start=scoring.start_memory,
        keep_clear=scoring.keep_clear,
        memory=scoring.ScoringMemory[float],
        align=scoring.align,
        closer=_scoring_closer,
    ),
    Method(
        name="circle",
        description="the safety circle of Bibuli et al. (2014), corrected; knows positions only",
        params=_circle_params,
        start=circle.start_memory,
        keep_clear=circle.keep_clear,
        memory=circle.CircleMemory[float],
        align=_circle_align,
        closer=_circle_closer,
    ),
)
METHODS: Kinds[Method] = Kinds(
    "fleet.keeping_clear", {method.name: method for method in _BUILT_IN}, needs=tuple(Method.__struct_fields__)
)
"""Every method by the name that a mission file gives it; other packages may add some."""

__all__ = ["METHODS", "Method", "Side", "circle", "pair", "params", "scoring"]
