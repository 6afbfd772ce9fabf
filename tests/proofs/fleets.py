"""Missions in lock-step for the proofs: made in code, launched as an operator does, and looked at every tick."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from fleet.agent.modes import Mode
from fleet.mission.model import Boat, Environment, Formation, Geographic, Limits, Mission, PathSpec, Radio, Start
from fleet.mission.plan import build
from fleet.sim.lockstep import Lockstep, operator

Floats = NDArray[np.float64]
DATUM = Geographic(lat_deg=44.38, lon_deg=8.93)
SAILS = (Mode.FOLLOW, Mode.AVOID)


def mission_of(
    path: PathSpec,
    starts: Sequence[Start],
    duration_s: float,
    *,
    spacing_m: float = 15.0,
    cruise_mps: float = 1.2,
    environment: Environment | None = None,
    radio: Radio | None = None,
) -> Mission:
    """Boats b1, b2, ... in column on one path, b1 ahead, each one spacing behind the one before."""
    boats = tuple(
        Boat(name=f"b{i + 1}", path="path", slot=-float(i), start=start, limits=Limits())
        for i, start in enumerate(starts)
    )
    return Mission(
        title="A proof",
        datum=DATUM,
        paths={"path": path},
        boats=boats,
        formation=Formation(spacing_m=spacing_m, cruise_mps=cruise_mps),
        duration_s=duration_s,
        environment=environment or Environment(),
        radio=radio or Radio(),
    )


class Seen:
    """What happened: arrays are (tick, boat), from the moment at which the mission begins."""

    def __init__(self, sim: Lockstep, rows: list[list[tuple[float, ...]]]) -> None:
        self.length_m = sim.plan.boats[0].limits.length_m
        self.period_s = sim.period_ns * 1e-9
        seen = np.array(rows)
        self.x, self.y, self.e, self.s, self.mode, self.speed = np.moveaxis(seen, 2, 0)

    @property
    def t(self) -> Floats:
        """Seconds since the mission began."""
        return np.arange(len(self.x)) * self.period_s

    def least_m(self) -> float:
        """Least distance of two hulls at any tick."""
        d = np.hypot(self.x[:, :, None] - self.x[:, None, :], self.y[:, :, None] - self.y[:, None, :])
        a, b = np.triu_indices(d.shape[1], 1)
        return float(d[:, a, b].min())

    def formed_s(self, within_m: float = 1.0) -> float:
        """From when on all boats sail and believe to be within 1 m of their places to the end; inf never."""
        sails = np.isin(self.mode, [float(mode) for mode in SAILS])
        off = np.flatnonzero(~(sails & (np.abs(self.e) < within_m)).all(axis=1))
        if not len(off):
            return 0.0
        return float(self.t[off[-1] + 1]) if off[-1] + 1 < len(self.t) else float("inf")


def sail(mission: Mission, *, seed: int = 0, until: Callable[[Lockstep], bool] = lambda sim: False) -> Seen:
    """Launch, and sail to the end of the time, or until told."""
    sim = Lockstep(build(mission), seed=seed)
    rows: list[list[tuple[float, ...]]] = []

    def look() -> None:
        row = []
        for name, station in sim.stations.items():
            assert station.agent is not None
            hull, d = sim.world.ships[name].state, station.agent.decision
            row.append((hull.x, hull.y, d.e, d.s, d.mode, d.U))
        rows.append(row)

    with operator(sim) as fleet:
        silent = fleet.wait_for([boat.name for boat in mission.boats])
        assert not silent, silent
        outcome = fleet.launch(mission)
        assert not outcome.refused, outcome.refused
        sim.sleep(sim.nature.lead_s)
        sim.each_tick.append(look)
        end_s = sim.monotonic() + mission.duration_s
        while sim.monotonic() < end_s and not until(sim):
            sim.tick()
    sim.close()
    return Seen(sim, rows)
