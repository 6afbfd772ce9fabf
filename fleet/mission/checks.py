"""What a mission can ask of a run that sailed it, and whether the run did it."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import Struct


class Check(Struct, frozen=True):
    """One figure of a run and which way it is limited."""

    direction: str
    """`at most`, `at least` or `exactly`."""
    unit: str
    meaning: str
    highest: float | None = None
    """Limits above this make no sense."""


class CheckResult(Struct, frozen=True):
    """What a run did against one check."""

    name: str
    ok: bool
    value: float | None
    """None: the run has no such figure, which is not ok."""
    limit: float
    by: str = ""
    """The figure that was judged, where it is not the one of the check's name."""


CHECKS: dict[str, Check] = {
    "collisions": Check("at most", "", "pairs of hulls that touched"),
    "min_separation_m": Check("at least", "m", "least distance between the centres of two boats"),
    "contacts": Check("at most", "", "times that a boat touched a vessel that is not of the fleet"),
    "min_traffic_m": Check("at least", "m", "least distance between the hulls of a boat and of such a vessel"),
    "min_domain": Check(
        "at least", "", "least distance from such a vessel, as a share of what boats keep from one of its size"
    ),
    "reformed_s": Check(
        "at most",
        "s",
        "seconds from the last formation change until every boat's formation error stays below 1 m",
    ),
    "formation_error_m": Check("at most", "m", "largest formation error of a boat at the end"),
    "speed_min_mps": Check(
        "at least", "m/s", "least speed of a boat that follows its path; of what it asks of an autopilot"
    ),
    "speed_max_mps": Check("at most", "m/s", "highest speed of a boat; of what it asks of an autopilot"),
    "cross_track_rms_m": Check("at most", "m", "root mean square distance from the path, the worst boat"),
    "messages_lost": Check("at most", "", "messages that a boat sent and another never saw"),
    "ticks_late_share": Check("at most", "", "share of the control ticks that came late or were skipped", highest=1.0),
    "unsaid": Check("at most", "", "words of the timeline that could not be said; 0 where not asked"),
    "finished": Check("exactly", "", "1: at the end every boat follows or holds, as the mission wants", highest=1.0),
}
"""Every limit is a number of at least 0."""


SET_POINTS = {"speed_min_mps": "setpoint_min_mps", "speed_max_mps": "setpoint_max_mps"}
"""Limits of speed hold for what a boat asks of its driver. Where an autopilot or a controller of its own stands between
that and the hull, they are judged by it; by the hull where the set-points are the hull's."""


def evaluate(
    checks: Mapping[str, float], figures: Mapping[str, float], instead: Mapping[str, str] | None = None
) -> tuple[CheckResult, ...]:
    """Every check against the figures of a run, in the order of the mission; a figure that is missing fails.

    Args:
        checks: limits by name
        figures: values by name
        instead: figures that are judged in place of those of a check's name
    """
    results = []
    for name, limit in checks.items():
        by = (instead or {}).get(name, "")
        value = figures.get(by or name)
        ok = value is not None and name in CHECKS and _holds(CHECKS[name].direction, value, limit)
        results.append(CheckResult(name=name, ok=ok, value=value, limit=limit, by=by))
    return tuple(results)


def _holds(direction: str, value: float, limit: float) -> bool:
    """Whether value keeps to limit; NaN never does."""
    if direction == "at most":
        return value <= limit
    if direction == "at least":
        return value >= limit
    return value == limit
