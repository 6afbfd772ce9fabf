"""Could a boat have kept clear of a foreign vessel that turned? Every manoeuvre is tried against its true track.

python -m tests.proofs.sudden [FAMILY] [--seed S] [--cases N] [--first K]

A manoeuvre is a course (36 of them), a sense of turning, a share of the cruise speed (1, 0.5, 0, as fast as the boat
goes) and a moment to begin: when the vessel begins to turn, and every 10 s of the minute after it. Until then the boat
sails as it did. What is found is possible for who knows what the vessel will do; what is not found no law can do.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
from msgspec import Struct

from fleet import ops
from fleet.hulls import HULLS, HullState, Water
from fleet.sim.batch.ships import ShipCase, Voyage, ship_track
from fleet.sim.batch.ships_judge import judge
from fleet.sim.batch.ships_measures import domain_share, hull_distance
from fleet.sim.batch.ships_radio import DT_S
from fleet.sim.batch.ships_sail import HULL_STEPS, STEP_S, sail
from fleet.sim.sweep.family import load
from fleet.sim.sweep.ships_results import LOST_DOMAIN

COURSES, SHARES = 36, (1.0, 0.5, 0.0)
DELAYS_S = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0)
HELD_S = 90.0
NEAR_RAD = 0.5  # of its course a boat no longer turns the long way round


class Best(Struct, frozen=True):
    """The best manoeuvre that begins at one moment."""

    begin_s: float  # after the vessel has begun to turn
    hull_m: float  # least distance of the hulls, <= 0 they touch
    domain: float  # least share of the clearance; another manoeuvre, perhaps


def best(case: ShipCase, voyage: Voyage, after_s: float) -> Best | None:
    """What the first boat could still do so long after the first vessel began to turn; None once all was over."""
    row = round((case.ships[0].turns_s + after_s) / DT_S)
    if row >= len(voyage.t):
        return None
    limits, cruise = case.limits, case.cruise
    speeds = np.array([*(share * cruise for share in SHARES), limits.speed_max_mps])
    courses = np.linspace(-np.pi, np.pi, COURSES, endpoint=False)
    chi, sense, u_d = (each.ravel() for each in np.meshgrid(courses, [-1.0, 1.0], speeds))
    one, before = np.ones_like(chi), max(row - 1, 0)
    r = float(ops.wrap(float(voyage.psi[row, 0] - voyage.psi[before, 0]))) / DT_S
    x, y, psi, u = (one * getattr(voyage, name)[row, 0] for name in ("x", "y", "psi", "u"))
    hull = HullState(x, y, psi, u, 0.0 * one, r * one, 0.0 * one, 0.0 * one)
    water, model = Water(*(one * v for v in (*case.current, 0.0, 0.0))), HULLS[case.hull]
    short = np.zeros_like(chi, dtype=bool)
    rows = []
    for _ in range(round(HELD_S / DT_S)):
        rows.append((hull.x, hull.y, hull.psi))
        off = np.asarray(ops.wrap(chi - hull.psi))
        short |= np.abs(off) < NEAR_RAD
        r_d = np.where(short, off, sense * limits.yaw_rate_max_radps)
        hull = model.advance_by(HULL_STEPS, hull, u_d, r_d, water, limits, STEP_S, 1.0)
    tracks = [ship_track(ship, row + len(rows)) for ship in case.ships]
    ships = [np.stack([track[n][row:] for track in tracks], axis=1) for n in range(3)]
    xs, ys, psis = (np.stack([each[n] for each in rows]) for n in range(3))
    tried = Voyage(np.arange(len(rows)) * DT_S, xs, ys, psis, xs, *ships, (), True)
    every = range(len(case.ships))
    hulls = min(float("inf"), *(hull_distance(case, tried, k).min(axis=0).max() for k in every))
    share = min(float("inf"), *(domain_share(case, tried, k).min(axis=0).max() for k in every))
    hulls = min(hulls, *(hull_distance(case, voyage, k)[: row + 1].min() for k in every))  # what it has done by then
    share = min(share, *(domain_share(case, voyage, k)[: row + 1].min() for k in every))
    return Best(after_s, float(hulls), float(share))


def main(arguments: Sequence[str] | None = None) -> None:
    """Sail cases of a family of one vessel, and try every manoeuvre where the boat touched it or came near."""
    parser = argparse.ArgumentParser(prog="python -m tests.proofs.sudden")
    parser.add_argument("family", nargs="?", default="sudden")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args(arguments)
    family = load(given.family, [])
    touched = unavoidable = late = lost = unreachable = 0
    for case in family.ships(given.seed, 0, range(given.first, given.first + given.cases)):
        voyage = sail(case)
        outcome = judge(case, voyage)
        if outcome.inside or outcome.dom >= LOST_DOMAIN:
            continue
        tried = [one for one in (best(case, voyage, after) for after in DELAYS_S) if one is not None]
        reach = [one.begin_s for one in tried if one.hull_m > 0.0]
        whole = [one.begin_s for one in tried if one.domain >= 1.0]
        lost, unreachable = lost + 1, unreachable + (not whole)
        if outcome.contact:
            touched, unavoidable = touched + 1, unavoidable + (not reach)
            late += bool(reach) and max(reach) < DELAYS_S[1]
        said = f"contact avoidable until {max(reach):.0f} s" if reach else "contact not avoidable"
        kept = f"domain until {max(whole):.0f} s" if whole else "domain not"
        print(
            f"case {case.case}: {'CONTACT, ' if outcome.contact else ''}{outcome.dom:.2f} of the domain kept;"
            f" after the turn began {said}, {kept}",
            flush=True,
        )
    print(
        f"{given.cases} cases: {touched} contacts, of them {unavoidable} not avoidable from the turn on and {late} not"
        f" 10 s after it began; {lost} lost a fifth of the domain, for {unreachable} the whole was out of reach"
    )


if __name__ == "__main__":
    main()
