"""The figures of a run, each defined once: see `FIGURES`."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from msgspec import Struct

from fleet.analysis.separation import Approach, approaches
from fleet.analysis.series import KEEPS_FORMATION, Said, Series, Track, load
from fleet.analysis.traffic import passings
from fleet.mission.checks import SET_POINTS, CheckResult, evaluate
from fleet.recording.topics import UNSAID, Status

FORMED_M = 1.0  # along-path error of a boat that is in formation
RUN_UP_S = 20.0  # at most so long a start from rest is left out of speeds and cross-track errors
UNDER_WAY = 0.9  # share of the speed asked for, at which a boat's run-up is over
SILENT_S = 2.0  # a boat that said nothing for so long before the end is not there at the end

FIGURES: dict[str, tuple[str, str]] = {
    "min_separation_m": (
        "Least distance between the centres of any two hulls, both moving in straight lines between samples.",
        "m",
    ),
    "collisions": ("Times that two hulls came nearer than the sum of their half lengths.", ""),
    "min_traffic_m": (
        "Least distance between the hulls of a boat and of a vessel that is not of the fleet, from true tracks.",
        "m",
    ),
    "contacts": ("Times that a boat's hull touched that of such a vessel.", ""),
    "min_domain": (
        "Least distance of a boat's centre from the core of such a vessel (its middle line and what it covers in 10 s, "
        "at most 3 lengths), as a share of C0, the distance that boats keep from a vessel of its size.",
        "",
    ),
    "reformed_s": (
        "From the last formation change put in force (from launch if there was none) until the along-path error of "
        "every boat that follows or avoids stays below 1 m to the end; empty if it never does.",
        "s",
    ),
    "speed_min_mps": (
        "Least speed over ground of a boat that follows or avoids, after the run-up: until all are within 1 m of "
        "formation and at 90 % of the speed asked for, at most 20 s from launch.",
        "m/s",
    ),
    "speed_max_mps": ("Highest speed over ground, of the same boats and times as the least.", "m/s"),
    "setpoint_min_mps": ("Least speed that such a boat asked of its driver, at the same times.", "m/s"),
    "setpoint_max_mps": ("Highest speed that such a boat asked of its driver, at the same times.", "m/s"),
    "cross_track_rms_m": (
        "Root mean square cross-track error of a boat that follows and avoids nobody, after the run-up; of the boat "
        "where it is largest.",
        "m",
    ),
    "formation_error_m": ("Largest along-path error at the end of the boats that follow, avoid or hold.", "m"),
    "messages_lost": ("Messages that a boat sent and another never heard, all boats together.", ""),
    "ticks": ("Ticks of the control loops, all boats together.", ""),
    "ticks_late": ("Ticks that were skipped because a loop was late, all boats together.", ""),
    "simulated_s": ("Duration of the run by its own clock.", "s"),
    "wall_s": ("Duration by the clock on the wall; less if time was warped.", "s"),
}
"""What each figure means, and its unit."""


class Summary(Struct, frozen=True, kw_only=True):
    """The figures of a run, as in `summary.json`; null where a figure does not exist."""

    mission: str
    passed: bool
    checks: list[CheckResult]
    boats: list[str]
    min_separation_m: float | None
    collisions: int | None
    reformed_s: float | None
    speed_min_mps: float | None
    speed_max_mps: float | None
    cross_track_rms_m: float | None
    formation_error_m: float | None
    messages_lost: int | None
    ticks: int | None
    ticks_late: int | None
    simulated_s: float
    wall_s: float | None
    run: str
    min_traffic_m: float | None = None
    contacts: int | None = None
    min_domain: float | None = None
    setpoint_min_mps: float | None = None
    setpoint_max_mps: float | None = None


def summarise(
    folder: Path | str,
    wall_s: float | None = None,
    checks: Mapping[str, float] | None = None,
    series: Series | None = None,
) -> Summary:
    """The figures of the run in a folder, checked against its mission.

    Args:
        folder: a run folder
        wall_s: duration on the wall; otherwise what an earlier summary says
        checks: limits; otherwise those of the folder's mission.toml
        series: the run, if it was loaded already

    Raises:
        RecordingError: there is no run to read
    """
    series = load(folder) if series is None else series
    mission = mission_tree(Path(folder))
    if wall_s is None:
        wall_s = _earlier_wall_s(Path(folder))
    wanted = checks if checks is not None else mission.get("checks", {})
    title = str(mission.get("title") or series.header.get("mission") or Path(folder).name)
    return summary_of(series, title, wanted, wall_s)


def summary_of(series: Series, mission: str, checks: Mapping[str, float], wall_s: float | None = None) -> Summary:
    """The figures of a series."""
    launched = launch_s(series.said)
    moving = run_up_end_s(series.said, series.tracks, launched)
    speeds, asked = speed_range(series.said, series.tracks, moving), setpoint_range(series.said, moving)
    pairs = approaches(series.tracks)
    passed_by = passings(series.tracks, series.traffic)
    figures: dict[str, Any] = {
        "min_separation_m": pairs[0].distance_m if pairs else None,
        "collisions": collisions(series.tracks, pairs),
        "min_traffic_m": passed_by[0].hull_m if passed_by else None,
        "contacts": sum(one.contacts for one in passed_by) if series.traffic else None,
        "min_domain": min((one.domain for one in passed_by), default=None),
        "reformed_s": reformed_s(series.said, changed_s(series, launched)),
        "speed_min_mps": speeds[0] if speeds else None,
        "speed_max_mps": speeds[1] if speeds else None,
        "setpoint_min_mps": asked[0] if asked else None,
        "setpoint_max_mps": asked[1] if asked else None,
        "cross_track_rms_m": cross_track_rms_m(series.said, moving),
        "formation_error_m": formation_error_m(series.said, series.end_s),
        **{name: counted(series.statuses, name) for name in ("messages_lost", "ticks", "ticks_late")},
        "simulated_s": series.end_s,
        "wall_s": wall_s,
    }
    more = {
        "ticks_late_share": figures["ticks_late"] / figures["ticks"] if figures["ticks"] else None,
        "finished": float(finished(series.said, series.end_s)),
        "unsaid": float(sum(one.kind == UNSAID for one in series.events)),
    }
    if more["unsaid"]:
        checks = {"unsaid": 0.0, **checks}
    known = {name: float(value) for name, value in {**figures, **more}.items() if value is not None}
    between = series.header.get("driver", "simulated") != "simulated"  # something that has loops of its own
    results = list(evaluate(checks, known, SET_POINTS if between else None))
    passed = all(one.ok for one in results)
    return Summary(
        mission=mission, passed=passed, checks=results, boats=series.boats, run=str(series.folder), **figures
    )


def write_summary(summary: Summary, path: Path | str) -> None:
    """`summary.json`, indented, replaced in one go."""
    target = Path(path)
    draft = target.with_name(target.name + ".part")
    draft.write_bytes(msgspec.json.format(msgspec.json.encode(summary), indent=2) + b"\n")
    draft.replace(target)


def mission_tree(folder: Path) -> dict[str, Any]:
    """The mission file of a run as TOML; empty if there is none that can be read."""
    try:
        return tomllib.loads((folder / "mission.toml").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def _earlier_wall_s(folder: Path) -> float | None:
    try:
        value = msgspec.json.decode((folder / "summary.json").read_bytes()).get("wall_s")
    except (OSError, msgspec.DecodeError, AttributeError):
        return None
    return float(value) if isinstance(value, int | float) else None


def launch_s(said: Mapping[str, Said]) -> float:
    """When the first boat began to follow; 0 if none ever did."""
    times = [float(one.t[sails][0]) for one in said.values() if (sails := one.within(*KEEPS_FORMATION)).any()]
    return min(times, default=0.0)


def changed_s(series: Series, launched_s: float) -> float:
    """When the last formation change came into force; launch if there was none."""
    return max((series.seconds(one.stamp_ns) for one in series.events if one.kind == "formation"), default=launched_s)


def run_up_end_s(said: Mapping[str, Said], tracks: Mapping[str, Track], launched_s: float) -> float:
    """When every boat was first in formation and under way together, at most 20 s after launch."""
    latest = launched_s + RUN_UP_S
    sailing = {name: one for name, one in said.items() if one.within(*KEEPS_FORMATION).any()}
    times = np.unique(np.concatenate([one.t for one in sailing.values()])) if sailing else np.array([])
    for t in times[(times >= launched_s) & (times < latest)]:
        if all(_ready(one, tracks.get(name), t) for name, one in sailing.items()):
            return float(t)
    return latest


def _ready(one: Said, track: Track | None, t: float) -> bool:
    k = int(np.searchsorted(one.t, t, side="right")) - 1
    if k < 0 or one.mode[k] not in KEEPS_FORMATION or abs(one.e_s[k]) >= FORMED_M:
        return False
    speed = np.interp(t, track.t, track.speed) if track is not None and len(track.t) else one.speed[k]
    return not speed < UNDER_WAY * one.u_d[k]


def speed_range(said: Mapping[str, Said], tracks: Mapping[str, Track], since_s: float) -> tuple[float, float] | None:
    """Least and highest speed over ground of boats in follow or avoid [m/s]."""
    found = []
    for name, one in said.items():
        chosen = one.within(*KEEPS_FORMATION) & (one.t >= since_s)
        track = tracks.get(name)
        if track is not None and len(track.t):
            found.append(np.interp(one.t[chosen], track.t, track.speed))
        else:
            found.append(one.speed[chosen])
    speeds = np.concatenate(found) if found else np.array([])
    speeds = speeds[np.isfinite(speeds)]
    return (float(speeds.min()), float(speeds.max())) if len(speeds) else None


def setpoint_range(said: Mapping[str, Said], since_s: float) -> tuple[float, float] | None:
    """Least and highest surge that boats in follow or avoid asked of their drivers [m/s]."""
    found = [one.u_d[one.within(*KEEPS_FORMATION) & (one.t >= since_s)] for one in said.values()]
    asked = np.concatenate(found) if found else np.array([])
    asked = asked[np.isfinite(asked)]
    return (float(asked.min()), float(asked.max())) if len(asked) else None


def cross_track_rms_m(said: Mapping[str, Said], since_s: float) -> float | None:
    """Root mean square of y_e of the boat where it is largest, in follow, avoiding nobody [m]."""
    found = []
    for one in said.values():
        y_e = one.y_e[one.within("follow") & ~one.avoiding & (one.t >= since_s)]
        y_e = y_e[np.isfinite(y_e)]
        if len(y_e):
            found.append(float(np.sqrt(np.mean(y_e * y_e))))
    return max(found, default=None)


def reformed_s(said: Mapping[str, Said], since_s: float) -> float | None:
    """Seconds from `since_s` until |e_s| of every boat present stays below 1 m to the end; None if it never does."""
    chosen = {}
    for name, one in said.items():
        present = one.within(*KEEPS_FORMATION) & (one.t >= since_s) & np.isfinite(one.e_s)
        if present.any():
            chosen[name] = (one.t[present], np.abs(one.e_s[present]) >= FORMED_M)
    if not chosen:
        return None
    end = max(float(t[-1]) for t, _ in chosen.values())
    formed = since_s
    for t, off in chosen.values():
        if not off.any():
            continue
        last = int(np.flatnonzero(off)[-1])
        if last + 1 < len(t):
            formed = max(formed, float(t[last + 1]))
        elif t[last] >= end - SILENT_S:
            return None
        else:  # it left the formation while it was off: the others need not wait for it
            formed = max(formed, float(t[last]))
    return formed - since_s


def formation_error_m(said: Mapping[str, Said], end_s: float) -> float | None:
    """Largest |e_s| in the last message of each boat that follows, avoids or holds at the end [m]."""
    found = [
        float(abs(one.e_s[-1]))
        for one in said.values()
        if _there_at_the_end(one, end_s) and one.mode[-1] in (*KEEPS_FORMATION, "hold") and np.isfinite(one.e_s[-1])
    ]
    return max(found, default=None)


def finished(said: Mapping[str, Said], end_s: float) -> bool:
    """Whether at the end every boat is there and follows, avoids or holds."""
    return bool(said) and all(
        _there_at_the_end(one, end_s) and one.mode[-1] in (*KEEPS_FORMATION, "hold") for one in said.values()
    )


def _there_at_the_end(one: Said, end_s: float) -> bool:
    return len(one.t) > 0 and bool(one.t[-1] >= end_s - SILENT_S)


def collisions(tracks: Mapping[str, Track], pairs: list[Approach]) -> int | None:
    """Times that two hulls touched; None where the length of a hull is not known, which is not the same as none."""
    if any(np.isnan(track.length_m) for track in tracks.values()):
        return None
    return sum(pair.touches for pair in pairs)


def counted(statuses: Mapping[str, list[Status]], name: str) -> int | None:
    """Sum of a counter over boats; one that fell began again with a restarted agent. None if nobody counted."""
    if not any(statuses.values()):
        return None
    total = 0
    for many in statuses.values():
        values = [int(getattr(one, name)) for one in many]
        total += sum(before for before, after in pairwise([*values, -1]) if after < before)
    return total
