"""What a family can ask of the figures of a sweep, and whether they do it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from msgspec import Struct

from fleet.mission.problem import Problem, hint


class Check(Struct, frozen=True):
    """One bound: on which figure of a summary, and which way."""

    figure: str
    """Key of the summary."""
    of: str | None
    """Key by which it is divided: the figure is a share."""
    at_most: bool
    unit: str
    meaning: str
    highest: float = math.inf
    """Bounds above this make no sense."""


CHECKS: dict[str, Check] = {
    "collisions_max": Check("collisions", None, True, "", "scenarios in which hulls overlapped"),
    "standstills_max": Check(
        "standstills", None, True, "", "scenarios in which a boat stood still for 60 s, or did not arrive in time"
    ),
    "arrived_min": Check("arrived", "boats_with_goal", False, "share", "boats that reached their goal in time", 1.0),
    "inside_radius_max": Check("inside_radius", "cases", True, "share", "scenarios with two boats within R", 1.0),
    "min_separation_m": Check("min_separation_m", None, False, "m", "least separation of two boats, of all scenarios"),
    "separation_median_m": Check(
        "separation_median_m", None, False, "m", "least separation of two boats, the median scenario"
    ),
    "delay_median_s": Check("delay_median_s", None, True, "s", "delay against nobody in the way, the median boat"),
    "delay_p95_s": Check("delay_p95_s", None, True, "s", "delay against nobody in the way, 95 % of boats stay below"),
    "formation_end_m": Check("formation_end_m", None, True, "m", "formation error at the end, the worst boat"),
    "settled_p95_s": Check(
        "settled_p95_s", None, True, "s", "from then on within 1 m of its place to the end, 95 % of boats are sooner"
    ),
    "unsettled_max": Check("unsettled", None, True, "", "boats not within 1 m of their places at the end"),
    "cross_track_most_m": Check("cross_track_most_m", None, True, "m", "distance from the path, the worst boat"),
    "switches_max": Check("switches_per_boat", None, True, "", "avoidances begun and ended, the mean boat"),
}
"""Every bound is a number of at least 0."""


class Judged(Struct, frozen=True):
    """What a sweep did against one check."""

    name: str
    value: float | None
    """None: the summary has no such figure, which is not ok."""
    bound: float
    ok: bool

    def text(self) -> str:
        """`collisions_max: 2, at most 0: FAILED`."""
        value = "none" if self.value is None else f"{self.value:.6g}"
        side = "at most" if CHECKS[self.name].at_most else "at least"
        return f"{self.name}: {value}, {side} {self.bound:g}: {'ok' if self.ok else 'FAILED'}"


def evaluate(checks: Mapping[str, float], summary: Mapping[str, object]) -> tuple[Judged, ...]:
    """Every check against the figures of `Results.summary`, in the order of the family."""
    return tuple(_judge(name, bound, summary) for name, bound in checks.items())


def _judge(name: str, bound: float, summary: Mapping[str, object]) -> Judged:
    check = CHECKS[name]
    value = _number(summary.get(check.figure))
    if check.of is not None and value is not None:
        whole = _number(summary.get(check.of))
        value = value / whole if whole else None
    ok = value is not None and (value <= bound if check.at_most else value >= bound)
    return Judged(name=name, value=value, bound=bound, ok=ok)


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def check_problems(checks: Mapping[str, float]) -> Iterator[Problem]:
    """Checks that do not exist, and bounds that make no sense."""
    for name, bound in checks.items():
        known = CHECKS.get(name)
        if known is None:
            yield Problem(("checks", name), f"no such check{hint(name, CHECKS)}", bound)
        elif bound < 0.0 or bound > known.highest:
            wrong = "expected at least 0" if bound < 0.0 else f"expected at most {known.highest:g}"
            yield Problem(("checks", name), wrong, bound)
