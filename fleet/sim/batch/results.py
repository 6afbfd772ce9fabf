"""What came out of a set of scenarios."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from msgspec import Struct

from fleet.ops import FloatArray
from fleet.sim.batch.scenarios import IntArray

PER_BOAT = (
    "nominal_s",
    "arrived_s",
    "switches",
    "cross_track_rms_m",
    "cross_track_most_m",
    "formation_rms_m",
    "formation_most_m",
    "formation_end_m",
    "settled_s",
    "stood",
    "stopped",
    "off_path",
    "off_place",
)
PER_SCENARIO = ("least_m", "inside_s", "ended_s")


class Trace(Struct, frozen=True, kw_only=True):
    """The trajectories of one scenario; arrays are (tick, boat)."""

    case: int
    t: FloatArray  # (tick,)
    x: FloatArray
    y: FloatArray
    psi: FloatArray
    u: FloatArray
    s: FloatArray
    e: FloatArray  # along-path error, as the boat sees it [m]
    y_e: FloatArray
    u_d: FloatArray
    r_d: FloatArray
    mode: FloatArray
    avoiding: FloatArray


class Results(Struct, kw_only=True):
    """Of each scenario, in the order of the set; arrays are (B, K) unless they say (B,)."""

    family: str
    method: str
    seed: int
    hull_m: float
    radius_m: float
    case: IntArray  # (B,)
    least_m: FloatArray  # (B,) least separation of any two boats, between ticks too
    inside_s: FloatArray  # (B,) time within R, of the pair that was there longest
    ended_s: FloatArray  # (B,)
    nominal_s: FloatArray
    arrived_s: FloatArray  # inf never
    switches: FloatArray  # avoidances begun and ended
    cross_track_rms_m: FloatArray
    cross_track_most_m: FloatArray
    formation_rms_m: FloatArray
    formation_most_m: FloatArray
    formation_end_m: FloatArray
    settled_s: FloatArray  # from when on the formation error stays below 1 m
    stood: FloatArray  # 1 it made less than 6 m good in 60 s without being told to stop
    stopped: FloatArray  # 1 it did not even sail 6 m in 60 s
    off_path: FloatArray  # share of the time 1 m or more off its path; -1 of boats that keep no place
    off_place: FloatArray  # share of the time 2 m or more from its place, of a wingman from abeam
    traces: list[Trace]
    boat_ticks: int = 0
    wall_s: float = 0.0

    @property
    def collided(self) -> FloatArray:
        """(B,) 1 where hulls came to overlap: centres nearer than the sum of half lengths."""
        return np.where(self.least_m < self.hull_m, 1.0, 0.0)

    @property
    def unfinished(self) -> FloatArray:
        """(B,) 1 where a boat with a goal did not get there in time."""
        late = np.isfinite(self.nominal_s) & ~np.isfinite(self.arrived_s)
        return np.where(late.any(axis=1), 1.0, 0.0)

    @property
    def standstill(self) -> FloatArray:
        """(B,) 1 where a boat made less than 6 m good in 60 s without being told to, or did not get there in time."""
        stood: FloatArray = np.maximum(self.stood.max(axis=1), self.unfinished)
        return stood

    @property
    def delay_s(self) -> FloatArray:
        """Against nobody in the way; inf where the boat never arrived, NaN where it has no goal."""
        goal = np.isfinite(self.nominal_s)
        return np.where(goal, self.arrived_s - np.where(goal, self.nominal_s, 0.0), np.nan)

    @property
    def failed(self) -> IntArray:
        """Cases with a collision or a standstill."""
        failed: IntArray = self.case[(self.collided + self.standstill) > 0.0]
        return failed

    def summary(self) -> dict[str, object]:
        """The figures of a sweep."""
        delay = self.delay_s[np.isfinite(self.delay_s)]
        goals = np.isfinite(self.nominal_s)
        return {
            "family": self.family,
            "method": self.method,
            "cases": len(self.case),
            "collisions": int(self.collided.sum()),
            "standstills": int(self.standstill.sum()),
            "arrived": int((np.isfinite(self.arrived_s) & goals).sum()),
            "boats_with_goal": int(goals.sum()),
            "inside_radius": int((self.least_m < self.radius_m).sum()),
            "min_separation_m": float(self.least_m.min()),
            "separation_median_m": float(np.median(self.least_m)),
            "delay_median_s": float(np.median(delay)) if len(delay) else None,
            "delay_p95_s": float(np.percentile(delay, 95.0)) if len(delay) else None,
            "switches_per_boat": float(self.switches.mean()),
            "failed_seeds": [int(case) for case in self.failed],
            "boat_ticks_per_s": self.boat_ticks / self.wall_s if self.wall_s > 0.0 else None,
            "wall_s": self.wall_s,
        }

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Of several sets with the same boats, one after the other; wall times added."""
        first = parts[0]
        arrays: dict[str, Any] = {
            name: np.concatenate([getattr(part, name) for part in parts]) for name in ("case", *PER_SCENARIO, *PER_BOAT)
        }
        return cls(
            family=first.family,
            method=first.method,
            seed=first.seed,
            hull_m=first.hull_m,
            radius_m=first.radius_m,
            traces=[trace for part in parts for trace in part.traces],
            boat_ticks=sum(part.boat_ticks for part in parts),
            wall_s=sum(part.wall_s for part in parts),
            **arrays,
        )
