"""Real agents and lock-step sail every ready mission: how far their figures lie apart, and within which band.

python -m tests.proofs.agreement               every ready mission, some six minutes
python -m tests.proofs.agreement overtaking    some of them
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from fleet.analysis.metrics import Summary, summarise
from fleet.mission.load import load, ready
from fleet.sim.lockstep import at_warp, sail_lockstep
from fleet.sim.share import Options
from tests.sim.sailed import Sailed, sail

WARP = 6.0

BAND: dict[str, float] = {
    "min_separation_m": 0.5,
    "reformed_s": 3.0,
    "speed_min_mps": 0.05,
    "speed_max_mps": 0.05,
    "cross_track_rms_m": 0.15,
    "formation_error_m": 0.1,
}
"""How far the figures of both ways may lie apart; docs/lockstep.md states them."""
WIDE = {**BAND, "min_separation_m": 1.0, "reformed_s": 10.0, "speed_min_mps": 0.15, "cross_track_rms_m": 0.5}
"""The same where a boat goes round another before it is in formation: there real runs differ as much themselves."""
WIDE_ONES = ("circuit", "comes-back")


def band_of(name: str) -> dict[str, float]:
    """The band of a mission."""
    return WIDE if name in WIDE_ONES else BAND


def both(name: str, warp: float, root: Path) -> tuple[Summary, Summary]:
    """The figures with real agents, and in lock-step with what real processes have at that warp."""
    real = sail(name, root, warp=warp)
    nature = at_warp(warp, startup_s(real) / warp or 0.6)
    mine = sail_lockstep(load(name), name, Options(root=str(root)), nature=nature)
    return real.summary, summarise(mine.folder)


def startup_s(processes: Sailed) -> float:
    """How long it took from the start of an agent under way to its first word; 0 if none was started."""
    for event in processes.happened("start"):
        first_ns = min(s.stamp_ns for s in processes.states[event.boat] if s.stamp_ns > event.stamp_ns)
        return (first_ns - event.stamp_ns) * 1e-9
    return 0.0


def beyond(name: str, real: Summary, mine: Summary) -> list[str]:
    """What does not agree; nothing if all does."""
    found = [
        f"{what}: {getattr(real, what)} with real agents, {getattr(mine, what)} in lock-step"
        for what in ("passed", "collisions")
        if getattr(real, what) != getattr(mine, what)
    ]
    for figure, band in band_of(name).items():
        a, b = getattr(real, figure), getattr(mine, figure)
        if (a is None) != (b is None) or (a is not None and not abs(a - b) <= band):
            found.append(f"{figure}: {a} with real agents, {b} in lock-step, band {band}")
    return found


def main(argv: list[str]) -> int:
    """A line of figures for each mission, real / lock-step; 1 if one lies beyond its band."""
    worst = 0
    for name in argv or ready():
        with TemporaryDirectory() as root:
            real, mine = both(name, WARP, Path(root))
        pairs = (f"{figure} {getattr(real, figure):.3f} / {getattr(mine, figure):.3f}" for figure in BAND)
        print(f"{name}: {', '.join(pairs)}; ticks late {real.ticks_late} of {real.ticks}", flush=True)
        for line in beyond(name, real, mine):
            worst = 1
            print(f"  BEYOND THE BAND: {line}", flush=True)
    return worst


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
