"""What came of a family with foreign vessels: an array per figure, kept, joined and compared like other results."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from msgspec import Struct

from fleet.ops import FloatArray
from fleet.sim.batch.scenarios import IntArray
from fleet.sim.batch.ships_results import Outcome
from fleet.sim.sweep.model import Spec

METHOD = "commit and hold"
PER_CASE = (
    "contact", "inside", "risk", "dom", "side", "early", "substantial", "stand_on_port", "first_range_m", "lead_s",
    "decisions", "reversals", "retriggers", "deviation_m", "alone", "bank_m", "ended_s", "rule_right",
)  # fmt: skip
"""Fields of `Outcome` that are kept as they are, flags as 0 and 1."""
LOST_DOMAIN = 0.8


class ShipResults(Struct, kw_only=True):
    """Results of some cases; arrays are (B,)."""

    family: str
    method: str
    seed: int
    hull_m: float
    radius_m: float
    case: IntArray
    values: dict[str, FloatArray]
    """By the names of `PER_CASE`."""
    least_m: FloatArray
    """Least distance of two boats; inf for one [m]."""
    ship_m: FloatArray
    """Least distance of hulls of a boat and a vessel [m]."""
    late_s: FloatArray
    """Way along the path that was lost, as time [s]."""
    unfinished: FloatArray
    boat_ticks: int
    wall_s: float

    @property
    def collided(self) -> FloatArray:
        """1 where hulls touched, those of a vessel or of two boats."""
        touched: FloatArray = np.maximum(self.values["contact"], (self.least_m < self.hull_m) * 1.0)
        return touched

    @property
    def standstill(self) -> FloatArray:
        """1 where the boats were not past and back on their path in time."""
        return self.unfinished

    @property
    def delay_s(self) -> FloatArray:
        """(B, 1), of the first boat."""
        return self.late_s[:, None]

    @property
    def failed(self) -> IntArray:
        """Cases with a contact, or with less than 0.8 of the domain left that did not begin so."""
        v = self.values
        lost = (v["dom"] < LOST_DOMAIN) & (v["inside"] < 0.5)
        failed: IntArray = self.case[(self.collided > 0.0) | lost]
        return failed

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """One after the other; wall times added."""
        first = parts[0]
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in ("case", "least_m", "ship_m", "late_s", "unfinished")
        }
        return cls(
            family=first.family,
            method=first.method,
            seed=first.seed,
            hull_m=first.hull_m,
            radius_m=first.radius_m,
            values={name: np.concatenate([part.values[name] for part in parts]) for name in PER_CASE},
            boat_ticks=sum(part.boat_ticks for part in parts),
            wall_s=sum(part.wall_s for part in parts),
            **arrays,
        )


def gathered(name: str, seed: int, spec: Spec, outcomes: Sequence[Outcome], ticks: int, wall_s: float) -> ShipResults:
    """Of judged cases."""

    def every(field: str) -> FloatArray:
        return np.array([float(getattr(one, field)) for one in outcomes])

    return ShipResults(
        family=name,
        method=METHOD,
        seed=seed,
        hull_m=spec.limits.length_m,
        radius_m=spec.keeping_clear.radius_m,
        case=np.array([one.case for one in outcomes], dtype=np.intp),
        values={field: every(field) for field in PER_CASE},
        least_m=every("closest_m"),
        ship_m=every("hull_m"),
        late_s=every("delay_s"),
        unfinished=1.0 - every("complete"),
        boat_ticks=ticks,
        wall_s=wall_s,
    )


MEANINGS: dict[str, tuple[str, str]] = {
    "cases": ("scenarios sailed", ""),
    "at_risk": ("cases in which a domain would be entered if everybody went on", ""),
    "contacts": ("cases in which a boat touched a vessel", ""),
    "collisions": ("cases in which a boat touched a vessel or another boat", ""),
    "domain_kept": ("of the cases that began outside: the whole domain stayed free", "share"),
    "domain_kept_08": ("the same for 0.8 of the domain", "share"),
    "dom_p5": ("least distance to a vessel's core as a share of the clearance, cases at risk: 5 % are below", ""),
    "dom_median": ("the same, median", ""),
    "side_right": ("every vessel head-on or from starboard was left to port; of the cases that have one", "share"),
    "in_time": ("the first action was in time for its role, one vessel", "share"),
    "substantial": ("the track altered by 25 deg or the speed by 30 % within 15 s of the first action", "share"),
    "port_closed": ("a boat that stands on turned to port for a vessel on its port side", "share"),
    "rule_right": ("side, time and size of the action as the rules want, no closed turn to port", "share"),
    "range_median_m": ("range at the first action, median", "m"),
    "lead_median_s": ("from the first action to the entry that it prevents, median", "s"),
    "decisions": ("alterations begun or changed, mean of the cases with an action", ""),
    "reversals": ("cases in which an alteration changed its side", "share"),
    "retriggers": ("cases that acted again for a vessel within 60 s of resuming", "share"),
    "decided_alone": ("cases in which a follower decided for itself", "share"),
    "delay_median_s": ("way along the path that was lost, as time, median", "s"),
    "delay_p95_s": ("the same, 95 % are below", "s"),
    "deviation_p95_m": ("largest distance from the path, 95 % are below", "m"),
    "min_separation_m": ("least distance of two boats in any case", "m"),
    "inside_radius": ("cases in which two boats came nearer than R", ""),
    "bank_least_m": ("least distance to a shore", "m"),
    "unfinished": ("cases not over when their time was up", ""),
}
"""Figures of families with foreign vessels: meaning and unit. None: there is nothing to measure."""
COLUMNS: dict[str, str] = {
    "cases": "cases",
    "contacts": "contacts",
    "domain_kept": "domain kept",
    "domain_kept_08": "0.8 of it",
    "side_right": "side right",
    "in_time": "in time",
    "rule_right": "rules right",
    "decisions": "decisions",
    "reversals": "reversals",
    "retriggers": "again",
    "delay_median_s": "delay [s]",
    "delay_p95_s": "95 % [s]",
    "min_separation_m": "boats [m]",
}
"""Columns of the table of points."""
MAPS: dict[str, str] = {
    "contacts": "cases with a contact",
    "domain_kept": "domain kept, share of cases",
    "side_right": "right side, share of cases",
    "delay_p95_s": "delay, 95 % are below [s]",
    "decisions": "decisions of a case",
    "retriggers": "acted again within 60 s, share",
}
"""Figures that are drawn over a grid."""


def figures(parts: Sequence[ShipResults]) -> dict[str, Any]:
    """The figures of one point, or of several together; keys as `MEANINGS`."""

    def every(name: str) -> FloatArray:
        return np.concatenate([part.values[name] for part in parts])

    least, late = (np.concatenate([getattr(part, name) for part in parts]) for name in ("least_m", "late_s"))
    dom, outside, decisions = every("dom"), every("inside") < 0.5, every("decisions")
    met = dom[outside & (every("risk") > 0.5)]
    return {
        "cases": len(dom),
        "at_risk": int((outside & (every("risk") > 0.5)).sum()),
        "contacts": int(every("contact").sum()),
        "collisions": int(sum(part.collided.sum() for part in parts)),
        "domain_kept": _mean(dom[outside] >= 1.0),
        "domain_kept_08": _mean(dom[outside] >= LOST_DOMAIN),
        "dom_p5": _percentile(met, 5.0),
        "dom_median": _percentile(met, 50.0),
        "side_right": _mean(every("side")),
        "in_time": _mean(every("early")),
        "substantial": _mean(every("substantial")),
        "port_closed": _mean(every("stand_on_port")),
        "rule_right": _mean(every("rule_right")),
        "range_median_m": _percentile(every("first_range_m"), 50.0),
        "lead_median_s": _percentile(every("lead_s"), 50.0),
        "decisions": _mean(decisions[decisions > 0.0]),
        "reversals": _mean(every("reversals") > 0.0),
        "retriggers": _mean(every("retriggers") > 0.0),
        "decided_alone": _mean(every("alone") > 0.0),
        "delay_median_s": _percentile(late, 50.0),
        "delay_p95_s": _percentile(late, 95.0),
        "deviation_p95_m": _percentile(every("deviation_m"), 95.0),
        "min_separation_m": _finite(least.min()),
        "inside_radius": sum(int((part.least_m < part.radius_m).sum()) for part in parts),
        "bank_least_m": _finite(every("bank_m").min()),
        "unfinished": int(sum(part.unfinished.sum() for part in parts)),
    }


def reasons(results: ShipResults) -> list[str]:
    """Why the one case failed, or what else the rules miss in it; none if all is well."""
    v = {name: float(values[0]) for name, values in results.values.items()}
    found = []
    if v["contact"] > 0.0:
        found.append(f"contact: hulls overlap by {-results.ship_m[0]:.2f} m")
    if results.least_m[0] < results.hull_m:
        found.append(f"collision: two boats {results.least_m[0]:.2f} m apart, hulls are {results.hull_m:g} m long")
    if v["dom"] < LOST_DOMAIN and v["inside"] < 0.5:
        found.append(f"{v['dom']:.2f} of the domain kept")
    return found


def _mean(values: Any) -> float | None:
    known = np.asarray(values, dtype=float)
    known = known[~np.isnan(known)]
    return float(known.mean()) if len(known) else None


def _percentile(values: FloatArray, share: float) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.percentile(known, share)) if len(known) else None


def _finite(value: Any) -> float | None:
    return float(value) if math.isfinite(value) else None
