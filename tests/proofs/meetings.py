"""Two boats change places, meet head-on and cross: 500 random starts each, by both methods, in the batch simulator.

python -m tests.proofs.meetings        all of it, about a minute
python -m tests.proofs.meetings 50     50 starts of each
"""

from __future__ import annotations

import sys

import numpy as np

from fleet import ops
from fleet.avoidance import METHODS
from fleet.ops import FloatArray
from fleet.sim.batch import Results, Scenarios, run
from fleet.sim.batch.families import swap, two_boat

SEED = 1
STARTS = 500
DRAWN = 20  # of random meetings for every one that is wanted: one in twelve is head-on, one in two crosses
HEAD_ON_DEG = (165.0, 180.0)  # between the two courses
CROSSING_DEG = (45.0, 135.0)


def meeting(between_deg: tuple[float, float], starts: int, seed: int = SEED) -> Scenarios:
    """The first so many random meetings of two boats whose courses differ by so much."""
    drawn = two_boat(DRAWN * starts, seed)
    apart = abs(ops.wrap(drawn.psi[:, 1] - drawn.psi[:, 0]))
    low, high = np.radians(between_deg)
    rows = np.flatnonzero((apart >= low) & (apart <= high))[:starts]
    assert len(rows) == starts
    return drawn.part(rows)


def kinds(starts: int) -> dict[str, Scenarios]:
    """All three, of so many starts."""
    return {
        "swap": swap(starts, SEED),
        "head-on": meeting(HEAD_ON_DEG, starts),
        "crossing": meeting(CROSSING_DEG, starts),
    }


def delay_s(scenarios: Scenarios, results: Results) -> FloatArray:
    """What it cost: time lost until the goal; of a swap, from the order until both are in their places."""
    if scenarios.family == "swap":
        settled: FloatArray = results.settled_s.max(axis=1) - 30.0
        return settled
    return results.delay_s.reshape(-1)


def report(name: str, scenarios: Scenarios, method: str) -> str:
    """Figures of one kind by one method."""
    r = run(scenarios, method)
    delay = delay_s(scenarios, r)
    what = "in place after" if name == "swap" else "delay"
    return (
        f"{name:8s} {method:8s} {len(r.case)} starts: {r.collided.sum():.0f} collisions, {r.standstill.sum():.0f} "
        f"standstills; least separation {r.least_m.min():.2f} m (median {np.median(r.least_m):.2f}), "
        f"{(r.least_m < r.radius_m).sum()} below {r.radius_m:.0f} m; {what} {np.median(delay):.1f} s (median), "
        f"{np.percentile(delay, 95.0):.1f} s (95 %); failed cases {r.failed[:8].tolist()}"
    )


def main(argv: list[str]) -> int:
    """Every kind by every method."""
    for name, scenarios in kinds(int(argv[0]) if argv else STARTS).items():
        for method in METHODS:
            print(report(name, scenarios, method), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
