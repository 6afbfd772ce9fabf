"""Could a collision have been avoided? Every manoeuvre of one boat is tried against the true tracks of the others.

python -m tests.proofs.avoidable FAMILY SEED/POINT/CASE [KEY=VALUE ...]

A manoeuvre is a course (36 of them), a sense of turning, a speed (4) and a moment to begin (every 2 s of the minute
before the boats touch); then course and speed are held. The others sail as they did, so that what is found is possible;
what is not found may still be possible for two boats together.
"""

from __future__ import annotations

import sys
from itertools import combinations

import numpy as np
from msgspec import Struct

from fleet import ops
from fleet.hulls import HULLS, STEP_S, HullState, Water
from fleet.ops import FloatArray
from fleet.sim.batch import Scenarios, Trace
from fleet.sim.batch.hearing import TICK_S
from fleet.sim.sweep.alone import sail_case
from fleet.sim.sweep.family import Family, load, read_case

COURSES, SPEEDS, BEFORE_S, EVERY_S, HELD_S = 36, (0.0, 0.33, 0.67, 1.0), 60.0, 2.0, 60.0
NEAR_RAD = 0.5  # of its course a boat no longer turns the long way round


class Found(Struct, frozen=True):
    """The best manoeuvres of one boat."""

    boat: int  # from 1
    best_m: float  # largest least separation of all manoeuvres
    latest_s: float  # before the touch, the last moment from which some manoeuvre keeps hulls apart; NaN none


def touching(trace: Trace, hull_m: float) -> tuple[int, list[int]]:
    """First tick at which hulls overlap, and whose (from 0)."""
    for tick in range(len(trace.t)):
        for i, j in combinations(range(trace.x.shape[1]), 2):
            if np.hypot(trace.x[tick, i] - trace.x[tick, j], trace.y[tick, i] - trace.y[tick, j]) < hull_m:
                return tick, [i, j]
    raise ValueError("nobody touches at a tick")


def separation(trace: Trace, scenarios: Scenarios, boat: int, begin: int) -> float:
    """Largest least distance to all others [m] that a manoeuvre of a boat begun at a tick keeps for a minute."""
    limits = scenarios.limits
    courses = np.linspace(-np.pi, np.pi, COURSES, endpoint=False)
    chi, sense, speed = (a.ravel() for a in np.meshgrid(courses, [-1.0, 1.0], np.array(SPEEDS) * limits.speed_max_mps))
    one = np.ones_like(chi)
    r = ops.wrap(float(trace.psi[begin, boat] - trace.psi[max(begin - 1, 0), boat])) / TICK_S
    x, y, psi, u = (one * field[begin, boat] for field in (trace.x, trace.y, trace.psi, trace.u))
    hull = HullState(x, y, psi, u, 0.0 * one, r * one, 0.0 * one, 0.0 * one)
    water = Water(*(one * getattr(scenarios, name)[0] for name in ("current_n", "current_e", "wind_n", "wind_e")))
    model = HULLS[scenarios.hulls[int(scenarios.hull[0, boat])]]
    least: FloatArray = np.full_like(chi, np.inf)
    short = np.zeros_like(chi, dtype=bool)
    for tick in range(begin, min(begin + round(HELD_S / TICK_S), len(trace.t))):
        for other in range(trace.x.shape[1]):
            if other != boat:
                least = np.minimum(least, np.hypot(hull.x - trace.x[tick, other], hull.y - trace.y[tick, other]))
        off = np.asarray(ops.wrap(chi - hull.psi))
        short |= np.abs(off) < NEAR_RAD
        r_d = np.where(short, off, sense * limits.yaw_rate_max_radps)
        hull = model.advance_by(round(TICK_S / STEP_S), hull, speed, r_d, water, limits, STEP_S, 1.0)
    return float(least.max())


def search(family: Family, seed: int, point: int, case: int) -> tuple[float, list[Found]]:
    """When boats first touch [s], and what each of the two that keeps clear of others could have done."""
    results = sail_case(family, seed, point, case, floats=None)
    scenarios = family.scenarios(seed, point, [case])
    trace = results.traces[0]
    touch, who = touching(trace, results.hull_m)
    found = []
    for boat in who:
        if scenarios.avoids[0, boat] < 1.0 or trace.mode[touch, boat] > 4.0:
            continue
        begins = range(
            touch - round(EVERY_S / TICK_S), max(touch - round(BEFORE_S / TICK_S), 0), -round(EVERY_S / TICK_S)
        )
        kept = [(begin, separation(trace, scenarios, boat, begin)) for begin in begins]
        clear = [begin for begin, m in kept if m >= results.hull_m]
        latest = (touch - max(clear)) * TICK_S if clear else float("nan")
        found.append(Found(boat + 1, max(m for _, m in kept), latest))
    return touch * TICK_S, found


def main(argv: list[str]) -> int:
    """One case."""
    family = load(argv[0], argv[2:])
    at_s, found = search(family, *read_case(family, argv[1]))
    for each in found:
        said = f"avoidable until {each.latest_s:.0f} s before" if each.latest_s == each.latest_s else "not avoidable"
        print(f"touch at {at_s:.1f} s; boat {each.boat}: {said}, best separation {each.best_m:.1f} m")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
