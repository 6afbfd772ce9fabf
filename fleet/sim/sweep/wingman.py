"""A wingman on a curve beside its leader on a straight path: the layout."""

from __future__ import annotations

import math

import numpy as np
from msgspec import Struct

from fleet.guidance.limits import Limits
from fleet.mission.beside import ABEAM, Room, room_beside, sail
from fleet.paths import Path, sine, straight
from fleet.sim.batch.scenarios import IntArray
from fleet.sim.sweep.distributions import Draw, support
from fleet.sim.sweep.layouts import Laid
from fleet.sim.sweep.model import Wingman

BEFORE_M = 60.0  # of path before the first crossing from which phases count
SPARE_M = 100.0  # of path beyond what is sailed


class _On(Struct, frozen=True):
    """A path, and where on it a boat begins."""

    path: Path
    s: float


def wingman(layout: Wingman, limits: Limits, need: float, duration_s: float, seed: int, case: IntArray) -> Laid:
    """Leader first; each begins near its place, at the speed that it asks for. See `model.Wingman`.

    Args:
        layout: what is drawn
        limits: of both boats
        need: least distance of two places [m]
        duration_s: how long they sail
        seed: of the sweep
        case: numbers of the cases
    """
    draw = Draw(seed, case, 2)
    amplitude, cruise = draw.per_scenario(layout.amplitude_m), draw.per_scenario(layout.cruise_mps)
    phase = draw.per_scenario(layout.phase_m)
    along, across = draw.per_boat(layout.along_m), draw.per_boat(layout.across_m)

    longest = max(map(abs, support(layout.phase_m))) + duration_s * support(layout.cruise_mps)[1]
    length = (math.ceil((BEFORE_M + longest + SPARE_M) / layout.wavelength_m) + 1.0) * layout.wavelength_m
    line = straight((0.0, 0.0), (length, 0.0))
    paths: list[Path] = [line]
    rooms: list[Room] = []
    first = BEFORE_M - math.fmod(BEFORE_M, layout.wavelength_m / 2.0) + layout.wavelength_m / 2.0
    starts, speeds = [], []
    for a, c, behind in zip(amplitude.tolist(), cruise.tolist(), phase.tolist(), strict=True):
        path = sine((0.0, 0.0), (length, 0.0), a, layout.wavelength_m)
        voyage = tuple(sail(_On(path, 0.0), _On(line, 0.0)))
        room = room_beside(voyage, limits, c, need, -1.0)
        begin = next(here for here in sail(_On(path, 0.0), _On(line, 0.0), room) if here.s1 >= first + behind)
        paths.append(path)
        rooms.append(ABEAM if layout.crossing == "keep-on" else room)
        starts.append((begin.s1, begin.s2))
        speeds.append((c, min(c * begin.rate, limits.speed_max_mps)))
    s = np.array(starts) + along
    numbers = np.stack([np.zeros(len(case), dtype=np.intp), np.arange(1, len(case) + 1)], axis=1)
    points = [[paths[k].at(at) for k, at in zip(*row, strict=True)] for row in zip(numbers, s.tolist(), strict=True)]
    x, y, tx, ty = (np.array([[getattr(p, name) for p in row] for row in points]) for name in ("x", "y", "tx", "ty"))
    both = np.repeat(cruise[:, None], 2, axis=1)
    rows = np.arange(len(case), dtype=float)
    more = {
        "s": s,
        "u": np.array(speeds),
        "leader": np.array([-1.0, 0.0]),
        "room": np.stack([np.full(len(case), -1.0), rows], axis=1),
        "rooms": tuple(rooms),
        "u_min": limits.speed_min_mps,
        "u_max": limits.speed_max_mps,
    }
    return Laid(
        paths=tuple(paths),
        path=numbers,
        x=x - across * ty,
        y=y + across * tx,
        psi=np.arctan2(ty, tx),
        cruise=both,
        more=more,
        used=draw.used,
    )
