"""Boats at random places round a circuit form up, whichever lap each takes: 60 starts of 3, 5 and 8 boats.

python -m tests.proofs.circuit          all of it, some ten minutes
python -m tests.proofs.circuit 3 20     20 starts of 3 boats
"""

from __future__ import annotations

import random
import sys

import numpy as np

from fleet.mission.model import Mission, Polyline, Start
from tests.proofs.fleets import Seen, mission_of, sail

CORNERS = ((0.0, 0.0), (40.0, 0.0), (40.0, 30.0), (0.0, 30.0))
LAP_M = 119.4
SPACING_M = 10.0
APART_M = 10.0  # at the start, along the circuit
LIMIT_S = 300.0
FORMED_M = 1.0
RADIUS_M = 6.0
STARTS = 60


def mission(boats: int, seed: int) -> Mission:
    """The circuit of the ready mission; boats at rest anywhere on it, in any order, up to 2 m off it."""
    draw = random.Random(f"{boats} {seed}")
    places: list[float] = []
    while len(places) < boats:
        s = draw.uniform(0.0, LAP_M)
        if all(min(abs(s - o), LAP_M - abs(s - o)) >= APART_M for o in places):
            places.append(s)
        elif draw.random() < 0.01:
            places.clear()
    return mission_of(
        Polyline(points=CORNERS, corner_radius_m=12.0, closed=True),
        [Start(s_m=s, offset_m=draw.uniform(-2.0, 2.0)) for s in places],
        LIMIT_S,
        spacing_m=SPACING_M,
    )


def start(boats: int, seed: int) -> Seen:
    """One random start, sailed."""
    return sail(mission(boats, seed), seed=seed)


def report(boats: int, starts: int) -> str:
    """Figures of many starts; times until all stay within 1 m of their places to the end."""
    seen = [start(boats, seed) for seed in range(starts)]
    took = np.array([one.formed_s(FORMED_M) for one in seen])
    least = np.array([one.least_m() for one in seen])
    return (
        f"{boats} boats: {np.isfinite(took).sum()} of {starts} form up, in {np.median(took):.0f} s (median), "
        f"{np.percentile(took, 95.0):.0f} s (95 %), {took.max():.0f} s (longest); "
        f"{(least < seen[0].length_m).sum()} collisions, least separation {least.min():.2f} m (median "
        f"{np.median(least):.2f}), {(least < RADIUS_M).sum()} below {RADIUS_M:.0f} m; "
        f"not formed {np.flatnonzero(~np.isfinite(took)).tolist()}, nearest in seed {np.argmin(least)}"
    )


def main(argv: list[str]) -> int:
    """Number of boats and of starts, or everything."""
    boats = [int(argv[0])] if argv else [3, 5, 8]
    for each in boats:
        print(report(each, int(argv[1]) if len(argv) > 1 else STARTS), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
