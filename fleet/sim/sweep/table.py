"""The figures of a sweep: of each point, and of all together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fleet.ops import FloatArray
from fleet.sim.batch import Results
from fleet.sim.sweep import ships_results
from fleet.sim.sweep.checks import evaluate
from fleet.sim.sweep.family import Family, case_name
from fleet.sim.sweep.run import Ended
from fleet.sim.sweep.ships_results import ShipResults
from fleet.sim.sweep.store import Store

Figures = dict[str, Any]

MEANINGS: dict[str, tuple[str, str]] = {
    "cases": ("scenarios sailed", ""),
    "collisions": ("cases in which hulls came to overlap", ""),
    "standstills": ("cases in which a boat made no 6 m good in 60 s without being told to, or never arrived", ""),
    "stopped": (
        "of these, cases in which a boat sailed less than 6 m in 60 s, or never arrived: not even in circles",
        "",
    ),
    "arrived": ("boats that arrived within 3 times the nominal time and 60 s", ""),
    "boats_with_goal": ("boats that have somewhere to arrive", ""),
    "inside_radius": ("cases in which two boats came nearer than R", ""),
    "min_separation_m": ("least separation of two boats in any case", "m"),
    "separation_median_m": ("least separation of a case, median", "m"),
    "delay_median_s": ("arrival later than with nobody in the way, median of boats", "s"),
    "delay_p95_s": ("the same, 95 % are below", "s"),
    "switches_per_boat": ("times that keeping clear began or ended", ""),
    "cross_track_rms_m": ("distance from the path, root mean square of all boats", "m"),
    "cross_track_most_m": ("largest distance from the path", "m"),
    "formation_rms_m": ("formation error, root mean square of all boats", "m"),
    "formation_end_m": ("formation error at the end, the worst boat", "m"),
    "settled_median_s": ("from then on a boat stays within 1 m of its place, median", "s"),
    "settled_p95_s": ("the same, 95 % of boats are sooner", "s"),
    "off_path": ("of the time 1 m or more from the path, in a formation", "share"),
    "off_place": ("of the time 2 m or more from its place, a wingman from abeam", "share"),
    "unsettled": ("boats that are not within 1 m of their places at the end", ""),
}
"""Figures: meaning and unit. None: there is nothing to measure."""


def figures(parts: Sequence[Any]) -> Figures:
    """The figures of one point, or of several together; keys as `MEANINGS`, of `ships_results` with foreign vessels."""

    if isinstance(parts[0], ShipResults):
        return ships_results.figures(parts)

    def every(name: str) -> FloatArray:
        return np.concatenate([np.ravel(getattr(one, name)) for one in parts])

    least, nominal, delay = every("least_m"), every("nominal_s"), every("delay_s")
    goals, delay = np.isfinite(nominal), delay[np.isfinite(delay)]
    formation = bool(every("formation_most_m").any())
    return {
        "cases": len(least),
        "collisions": int(every("collided").sum()),
        "standstills": int(every("standstill").sum()),
        "stopped": int(sum(np.maximum(one.stopped.max(axis=1), one.unfinished).sum() for one in parts)),
        "arrived": int((np.isfinite(every("arrived_s")) & goals).sum()),
        "boats_with_goal": int(goals.sum()),
        "inside_radius": sum(int((one.least_m < one.radius_m).sum()) for one in parts),
        "min_separation_m": _finite(least.min()),
        "separation_median_m": _finite(np.median(least)),
        "delay_median_s": _finite(np.median(delay)) if len(delay) else None,
        "delay_p95_s": _finite(np.percentile(delay, 95.0)) if len(delay) else None,
        "switches_per_boat": _finite(every("switches").mean()),
        "cross_track_rms_m": _finite(_rms(every("cross_track_rms_m"))),
        "cross_track_most_m": _finite(every("cross_track_most_m").max()),
        "formation_rms_m": _finite(_rms(every("formation_rms_m"))) if formation else None,
        "formation_end_m": _finite(every("formation_end_m").max()) if formation else None,
        "settled_median_s": _finite(_share(every("settled_s"), 0.5)) if formation else None,
        "settled_p95_s": _finite(_share(every("settled_s"), 0.95)) if formation else None,
        "off_path": _mean(every("off_path")),
        "off_place": _mean(every("off_place")),
        "unsettled": int((~np.isfinite(every("settled_s"))).sum()) if formation else None,
    }


def _share(values: FloatArray, share: float) -> Any:
    """The least of the values that so many do not exceed; inf among them counts."""
    return np.sort(values)[max(int(np.ceil(share * len(values))) - 1, 0)]


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values * values)))


def _mean(values: FloatArray) -> float | None:
    """Of the shares of those boats that have any: at least 0."""
    there = values[values >= 0.0]
    return float(there.mean()) if len(there) else None


def _finite(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


def failed_names(family: Family, seed: int, results: Sequence[Results | None]) -> list[str]:
    """Cases with a collision or a standstill, as `fleet sim --case` calls them."""
    return [
        case_name(family, seed, point.number, int(case))
        for point, one in zip(family.points, results, strict=True)
        if one is not None
        for case in one.failed
    ]


def summary(store: Store, results: Sequence[Results | None], ended: Ended | None = None) -> Figures:
    """Everything about a sweep that `summary.json` and `--json` tell.

    Args:
        store: the sweep
        results: of each point; None where there are none
        ended: what this process did; without it speed and wall time are None
    """
    family, sweep = store.family, store.sweep
    there = [one for one in results if one is not None]
    points = []
    for point, one in zip(family.points, results, strict=True):
        if one is None:
            continue
        of_point = figures([one])
        checks = evaluate(family.checks, of_point)
        points.append(
            {
                "point": point.number,
                "label": point.label,
                "values": point.values,
                "method": one.method,
                **of_point,
                "passed": all(check.ok for check in checks),
                "checks": [
                    {
                        "name": check.name,
                        "ok": check.ok,
                        "value": check.value,
                        "limit": check.bound,
                        "text": check.text(),
                    }
                    for check in checks
                ],
            }
        )
    whole = sum(len(one.case) for one in there) == sweep.total
    wall_s, ticks = (ended.wall_s, ended.boat_ticks) if ended is not None else (None, 0)
    return {
        "family": sweep.family,
        "title": family.title,
        "method": ", ".join(dict.fromkeys(one.method for one in there)) or sweep.method,
        "boats": sweep.most_boats,
        "seed": sweep.seed,
        **(figures(there) if there else {}),
        "failed_seeds": failed_names(family, sweep.seed, results),
        "boat_ticks_per_s": ticks / wall_s if wall_s and ticks else None,
        "wall_s": wall_s,
        "complete": whole,
        "lost": [f"{one.part}: {one.why}" for one in ended.lost] if ended is not None else [],
        "passed": whole and all(point["passed"] for point in points),
        "points": points,
        "folder": str(store.folder),
        "version": sweep.version,
        "laws": sweep.laws,
    }
