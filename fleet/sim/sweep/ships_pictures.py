"""Pictures of families with foreign vessels: what is left of domains, delays, the tracks of a case."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from fleet.analysis.canvas import ALARM, COLOURS, FAINT, INK, STYLES, canvas
from fleet.ops import FloatArray
from fleet.sim.batch.ships import ShipCase, Voyage
from fleet.sim.batch.ships_measures import domain_share, hull_distance
from fleet.sim.batch.ships_radio import DT_S
from fleet.sim.sweep.ships_results import LOST_DOMAIN, ShipResults

BINS = 40
FAR_SHARE = 4.0
MARK_EVERY_S = 20.0


def distributions(results: Sequence[ShipResults]) -> Any:
    """Least distances to cores as shares of the clearance, and delays."""
    figure_of, style = canvas()
    with style():
        figure = figure_of(figsize=(11.0, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        dom = np.concatenate([one.values["dom"] for one in results])
        left.hist(np.clip(dom[np.isfinite(dom)], 0.0, FAR_SHARE), bins=BINS, color=COLOURS[0], alpha=0.75)
        for place, colour in ((1.0, INK), (LOST_DOMAIN, ALARM)):
            left.axvline(place, color=colour, linewidth=1.2, linestyle=(0, (6, 3)))
        left.set_title("Least distance to a vessel's core")
        left.set_xlabel(f"as a share of the clearance; {FAR_SHARE:g} and more in the last bar")
        left.set_ylabel("cases")
        late = np.concatenate([one.late_s for one in results])
        right.hist(late, bins=BINS, color=COLOURS[0], alpha=0.75)
        right.set_title("Delay of the first boat")
        right.set_xlabel("way along the path that was lost, as time [s]")
        right.set_ylabel("cases")
    return figure


def tracks(case: ShipCase, voyage: Voyage, title: str) -> Any:
    """The tracks of one case: all of it, the closest approach enlarged, and what is left of the domains in time."""
    share = [domain_share(case, voyage, k).min(axis=1) for k in range(len(case.ships))]
    nearest = int(np.argmin([one.min() for one in share]))
    row = int(share[nearest].argmin())
    figure_of, style = canvas()
    with style():
        figure = figure_of(figsize=(11.0, 4.4), layout="constrained")
        figure.suptitle(title, fontsize=11, fontweight="bold", color=INK)
        whole, close, left = figure.subplots(1, 3)
        _tracks(whole, case, voyage, np.arange(len(voyage.t)))
        whole.set_title("Tracks, a dot every 20 s")
        whole.legend(fontsize=7, loc="best")
        _close(close, case, voyage, nearest, row)
        for k, one in enumerate(share):
            left.plot(voyage.t, one, color=_colour(case, k), linewidth=1.2, label=f"vessel {k + 1}")
        for t in sorted({d.t for d in voyage.decisions}):
            left.axvline(t, color=FAINT, linewidth=0.8)
        left.axhline(1.0, color=ALARM, linewidth=1.0, linestyle=(0, (6, 3)))
        left.set_ylim(0.0, FAR_SHARE)
        left.set_xlabel("time [s]; lines are decisions")
        left.set_title("Distance to the cores, shares of the clearance")
    return figure


def _colour(case: ShipCase, k: int) -> Any:
    return COLOURS[(len(case.paths) + k) % 7]


def _tracks(axis: Any, case: ShipCase, voyage: Voyage, rows: Any) -> None:
    every = round(MARK_EVERY_S / DT_S)
    dots = rows[rows % every == 0]
    for i in range(voyage.x.shape[1]):
        axis.plot(voyage.y[rows, i], voyage.x[rows, i], color=COLOURS[i % 7], linewidth=1.2, label=f"boat {i + 1}")
        axis.plot(voyage.y[dots, i], voyage.x[dots, i], ".", color=COLOURS[i % 7], markersize=4)
    near = 1.5 * float(np.ptp(voyage.x[rows])) + 50.0
    for k in range(len(case.ships)):
        x, y = voyage.ship_x[rows, k], voyage.ship_y[rows, k]
        seen = np.hypot(x - voyage.x[rows, 0].mean(), y - voyage.y[rows, 0].mean()) < near
        look = {"color": _colour(case, k), "linestyle": STYLES[1]}
        axis.plot(np.where(seen, y, np.nan), np.where(seen, x, np.nan), **look, label=f"vessel {k + 1}")
        here = dots[seen[np.searchsorted(rows, dots)]]
        axis.plot(voyage.ship_y[here, k], voyage.ship_x[here, k], ".", color=look["color"], markersize=4)
    for ax, ay, bx, by in case.edges:
        x = np.clip([ax, bx], voyage.x.min() - 50.0, voyage.x.max() + 50.0) if len(case.edges) == 1 else [ax, bx]
        axis.plot([ay, by], x, color=INK, linewidth=2.0)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel("east [m]")
    axis.set_ylabel("north [m]")


def _close(axis: Any, case: ShipCase, voyage: Voyage, k: int, row: int) -> None:
    """The boat and the vessel that came nearest, then; the vessel as a capsule."""
    before = max(0, row - round(MARK_EVERY_S / DT_S))
    _tracks(axis, case, voyage, np.arange(before, min(row + row - before + 1, len(voyage.t))))
    L, chi = case.ships[k].length, float(voyage.ship_chi[row, k])
    x, y = float(voyage.ship_x[row, k]), float(voyage.ship_y[row, k])
    ends = [(y + a * L * math.sin(chi), x + a * L * math.cos(chi)) for a in (-0.5, 0.5)]
    axis.plot([a for a, _ in ends], [b for _, b in ends], color=_colour(case, k), linewidth=4.0, solid_capstyle="round")
    boats: FloatArray = voyage.x[row]
    axis.plot(voyage.y[row], boats, "x", color=INK)
    away = float(hull_distance(case, voyage, k).min())
    axis.set_title(f"Vessel {k + 1}: hulls {away:.1f} m apart at the least")
