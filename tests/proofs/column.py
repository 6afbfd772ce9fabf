"""A long column: ten boats for half an hour in four waters, and a straggler 200 m behind a column of five.

python -m tests.proofs.column            all of it, some five minutes
python -m tests.proofs.column straggler  one of: calm, current, radio, rough, straggler
"""

from __future__ import annotations

import sys

import numpy as np
from msgspec import Struct

from fleet.mission.model import Environment, Mission, Radio, Start, Straight
from tests.proofs.fleets import Floats, Seen, mission_of, sail

CRUISE_MPS, SPACING_M = 1.2, 15.0
PARTS = 3  # of the time, for the trend
SETTLING_S = 120.0  # left out of the first part
BEHIND_M = 200.0
CURRENT = {"current_mps": 0.2, "current_toward_deg": 60.0}
BAD_RADIO = Radio(loss=0.1, delay_s=0.2)
WATERS: dict[str, tuple[Environment, Radio]] = {
    "calm": (Environment(), Radio()),
    "current": (Environment(**CURRENT), Radio()),
    "radio": (Environment(**CURRENT), BAD_RADIO),
    "rough": (Environment(**CURRENT, gnss_sigma_m=0.5, gnss_white_m=0.1), BAD_RADIO),
}


def column(water: str = "calm", boats: int = 10, duration_s: float = 1800.0, behind_m: float = 0.0) -> Mission:
    """Boats at rest in their places; the last one `behind_m` farther back."""
    environment, radio = WATERS[water]
    places = [SPACING_M * (boats - 1 - i) + behind_m * (i < boats - 1) for i in range(boats)]
    long_m = CRUISE_MPS * duration_s + SPACING_M * boats + behind_m + 100.0
    return mission_of(
        Straight(start=(0.0, 0.0), end=(long_m, 0.0)),
        [Start(s_m=s) for s in places],
        duration_s,
        spacing_m=SPACING_M,
        cruise_mps=CRUISE_MPS,
        environment=environment,
        radio=radio,
    )


def along_errors(seen: Seen, boats: slice = slice(None)) -> Floats:
    """True formation error of some of the boats: mean of the others' places less the own one, (tick, boat) [m]."""
    x = seen.x[:, boats]
    n = x.shape[1]
    z = x + SPACING_M * np.arange(n)
    return (z.sum(axis=1, keepdims=True) - z) / (n - 1) - z


def rms(values: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values * values)))


class Kept(Struct, frozen=True):
    """How well a column is kept in a part of the time; true errors, all boats together."""

    begin_s: float
    end_s: float
    along_rms_m: float
    along_most_m: float
    cross_rms_m: float
    cross_mean_m: float


def kept(seen: Seen, duration_s: float) -> list[Kept]:
    """Errors in each third of the time, without the first two minutes."""
    e, t = along_errors(seen), seen.t
    found = []
    for part in range(PARTS):
        begin, end = duration_s * part / PARTS, duration_s * (part + 1) / PARTS
        begin = max(begin, SETTLING_S) if not part else begin
        now = (t >= begin) & (t < end)
        along, across = e[now], seen.y[now]
        found.append(Kept(begin, end, rms(along), float(np.abs(along).max()), rms(across), float(across.mean())))
    return found


class Straggled(Struct, frozen=True):
    """What a straggler does to the others."""

    apart_m: float  # how far at most one of the others is from its place among them, from 30 s on
    waiting_mps: float  # their speed while it is more than 20 m from its place
    coming_mps: float  # its own then
    joined_s: float  # until it stays within 1 m of its place behind them
    least_m: float


def straggled(seen: Seen) -> Straggled:
    """Figures of a column whose last boat began far behind."""
    others = np.abs(along_errors(seen, slice(0, -1)))[seen.t >= 30.0]
    gap = seen.x[:, -2] - seen.x[:, -1] - SPACING_M
    waiting = (seen.t >= 30.0) & (gap > 20.0)
    speed = seen.speed[waiting].mean(axis=0)
    joined = float(seen.t[np.flatnonzero(np.abs(gap) >= 1.0)[-1]]) + seen.period_s
    return Straggled(float(others.max()), float(speed[:-1].mean()), float(speed[-1]), joined, seen.least_m())


def main(argv: list[str]) -> int:
    """What is asked for, or everything."""
    for name in argv or [*WATERS, "straggler"]:
        if name == "straggler":
            print(name, straggled(sail(column(boats=5, duration_s=600.0, behind_m=BEHIND_M))), flush=True)
            continue
        mission = column(name)
        seen = sail(mission)
        print(f"{name}: {len(mission.boats)} boats, {mission.duration_s:.0f} s, nearest {seen.least_m():.2f} m")
        for part in kept(seen, mission.duration_s):
            print(
                f"  {part.begin_s:4.0f}-{part.end_s:4.0f} s: along-path RMS {part.along_rms_m:.2g} m (most "
                f"{part.along_most_m:.2g}), cross-track RMS {part.cross_rms_m:.2g} m (mean {part.cross_mean_m:+.2g})",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
