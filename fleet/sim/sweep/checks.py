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
    foreign: tuple[bool, ...] = (False,)
    """Whether families with foreign vessels have the figure, and whether the others have it."""


BOTH, ONLY = (False, True), (True,)
CHECKS: dict[str, Check] = {
    "collisions_max": Check("collisions", None, True, "", "scenarios in which hulls overlapped", foreign=BOTH),
    "standstills_max": Check(
        "standstills", None, True, "", "scenarios in which a boat made no 6 m good in 60 s, or did not arrive in time"
    ),
    "stopped_max": Check(
        "stopped", None, True, "", "scenarios in which a boat sailed less than 6 m in 60 s, or did not arrive in time"
    ),
    "arrived_min": Check("arrived", "boats_with_goal", False, "share", "boats that reached their goal in time", 1.0),
    "inside_radius_max": Check(
        "inside_radius", "cases", True, "share", "scenarios with two boats within R", 1.0, foreign=BOTH
    ),
    "min_separation_m": Check(
        "min_separation_m", None, False, "m", "least separation of two boats, of all scenarios", foreign=BOTH
    ),
    "separation_median_m": Check(
        "separation_median_m", None, False, "m", "least separation of two boats, the median scenario"
    ),
    "delay_median_s": Check(
        "delay_median_s", None, True, "s", "delay against nobody in the way, the median boat", foreign=BOTH
    ),
    "delay_p95_s": Check(
        "delay_p95_s", None, True, "s", "delay against nobody in the way, 95 % of boats stay below", foreign=BOTH
    ),
    "formation_end_m": Check("formation_end_m", None, True, "m", "formation error at the end, the worst boat"),
    "settled_p95_s": Check(
        "settled_p95_s", None, True, "s", "from then on within 1 m of its place to the end, 95 % of boats are sooner"
    ),
    "unsettled_max": Check("unsettled", None, True, "", "boats not within 1 m of their places at the end"),
    "off_path_max": Check("off_path", None, True, "share", "of the time 1 m or more from the path", 1.0),
    "off_place_max": Check(
        "off_place", None, True, "share", "of the time 2 m or more from its place, a wingman from abeam", 1.0
    ),
    "cross_track_most_m": Check("cross_track_most_m", None, True, "m", "distance from the path, the worst boat"),
    "switches_max": Check("switches_per_boat", None, True, "", "avoidances begun and ended, the mean boat"),
    "contacts_max": Check("contacts", None, True, "", "scenarios in which a boat touched a vessel", foreign=ONLY),
    "domain_kept_min": Check(
        "domain_kept", None, False, "share", "scenarios in which the domains of all vessels stayed free", 1.0, ONLY
    ),
    "domain_kept_08_min": Check(
        "domain_kept_08", None, False, "share", "scenarios in which 0.8 of the domains stayed free", 1.0, ONLY
    ),
    "side_right_min": Check(
        "side_right", None, False, "share", "scenarios in which vessels head-on and from starboard were left to port",
        1.0, ONLY,
    ),
    "bank_least_m": Check("bank_least_m", None, False, "m", "least distance to a shore, any scenario", foreign=ONLY),
    "in_time_min": Check("in_time", None, False, "share", "first actions in time for their role", 1.0, ONLY),
    "substantial_min": Check("substantial", None, False, "share", "first actions that can be seen", 1.0, ONLY),
    "rule_right_min": Check("rule_right", None, False, "share", "scenarios in which the rules were obeyed", 1.0, ONLY),
    "decisions_max": Check(
        "decisions", None, True, "", "alterations begun or changed, mean of scenarios with one", foreign=ONLY
    ),
    "reversals_max": Check(
        "reversals", None, True, "share", "scenarios in which an alteration changed its side", 1.0, ONLY
    ),
    "retriggers_max": Check(
        "retriggers", None, True, "share", "scenarios that acted again for a vessel within 60 s", 1.0, ONLY
    ),
}  # fmt: skip
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


def check_problems(checks: Mapping[str, float], foreign: bool) -> Iterator[Problem]:
    """Checks that do not exist, or not for such families, and bounds that make no sense.

    Args:
        foreign: the family is one of foreign vessels
    """
    for name, bound in checks.items():
        known = CHECKS.get(name)
        if known is None:
            yield Problem(("checks", name), f"no such check{hint(name, CHECKS)}", bound)
        elif foreign not in known.foreign:
            which = "with" if foreign else "without"
            yield Problem(("checks", name), f"there is no such figure {which} foreign vessels", bound)
        elif bound < 0.0 or bound > known.highest:
            wrong = "expected at least 0" if bound < 0.0 else f"expected at most {known.highest:g}"
            yield Problem(("checks", name), wrong, bound)
