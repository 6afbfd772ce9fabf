"""Layouts of formations: two that meet, and one on a circuit."""

from __future__ import annotations

from typing import Any

import numpy as np

from fleet import ops
from fleet.ops import FloatArray
from fleet.paths import Path, polyline
from fleet.sim.batch.scenarios import IntArray
from fleet.sim.sweep.distributions import Draw, Spread, radians
from fleet.sim.sweep.layouts import Laid, lines, slots
from fleet.sim.sweep.model import Circuit, Formation, Formations

BEFORE_M = 500.0  # of path before a formation's start


def formations(
    layout: Formations, formation: Formation, boats: int, seed: int, case: IntArray
) -> tuple[Laid, FloatArray]:
    """Two formations on their ways to one point, and the spacing of each case (B,) [m]; see `model.Formations`."""
    draw = Draw(seed, case, boats)
    spacing = draw.per_scenario(formation.spacing_m)
    course = draw.per_scenario(radians(layout.course_deg))
    first = boats // 2
    of = np.where(np.arange(boats) < first, 0, first)  # whose numbers hold for all of its formation

    abreast = draw.per_boat(layout.abreast)[:, of] >= 0.5
    late, aside = draw.per_boat(layout.late_s)[:, of], draw.per_boat(layout.aside_m)[:, of]
    cruise = draw.per_boat(formation.cruise_mps)[:, of]
    along, across = draw.per_boat(layout.along_m), draw.per_boat(layout.across_m)

    place = np.concatenate([_centred(first), _centred(boats - first)])
    offset = np.where(abreast, 0.0, place * spacing[:, None])
    beside = np.where(abreast, -place * layout.lateral_m, 0.0) + aside  # the first boat to port
    chi = np.where(of == 0, 0.0, course[:, None])
    s, c = ops.sincos(chi)
    begin = -cruise * (layout.meet_s + late)  # of the middle, before the point
    ahead, right = begin + offset + along, beside + across
    x, y = ahead * c - right * s, ahead * s + right * c
    from_x, from_y = (begin - BEFORE_M) * c - beside * s, (begin - BEFORE_M) * s + beside * c
    paths, path = lines(from_x, from_y, c, s)
    more: dict[str, Any] = {"s": BEFORE_M + offset + along, "offset": offset}
    more["member"] = np.broadcast_to(np.where(of == 0, 1.0, 2.0), x.shape)
    laid = Laid(paths=paths, path=path, x=x, y=y, psi=chi, cruise=cruise, more=more, used=draw.used)
    return laid, spacing


def _centred(boats: int) -> FloatArray:
    """Places of a column about its middle, in spacings, the first boat ahead."""
    return slots(boats) - 0.5 * (boats - 1)


def circuit_path(layout: Circuit) -> Path:
    """The rectangle, clockwise from its south-western corner."""
    n, e = layout.north_m, layout.east_m
    return polyline([(0.0, 0.0), (n, 0.0), (n, e), (0.0, e)], layout.corner_radius_m, closed=True)


def circuit(
    layout: Circuit, formation: Formation, boats: int, seed: int, case: IntArray
) -> tuple[Laid, FloatArray]:  # fmt: skip
    """Boats anywhere on a closed path, and the spacing of each case (B,) [m]; see `model.Circuit`.

    Each takes the lap nearest to its slot as seen from the lowest one, as at a launch.
    """
    draw = Draw(seed, case, boats)
    spacing = draw.per_scenario(formation.spacing_m)
    anywhere = Spread(even=(0.0, 1.0))
    path = circuit_path(layout)
    lap = path.length
    room = max(lap - boats * layout.apart_m, 0.0)
    gaps = np.sort(draw.per_boat(anywhere), axis=1) * room + np.arange(boats) * layout.apart_m
    order = np.argsort(draw.per_boat(anywhere), axis=1)
    raw = (np.take_along_axis(gaps, order, axis=1) + draw.per_scenario(anywhere)[:, None] * lap) % lap
    offset = slots(boats) * spacing[:, None]
    lowest = raw[:, -1:] + offset - offset[:, -1:]
    s = raw + lap * np.floor((lowest - raw) / lap + 0.5)
    across = draw.per_boat(layout.across_m)
    cruise = np.repeat(draw.per_scenario(formation.cruise_mps)[:, None], boats, axis=1)
    u = cruise * draw.per_boat(layout.speed_share)
    points = [path.at(each) for each in raw.ravel().tolist()]
    px, py, tx, ty = (np.array([getattr(p, n) for p in points]).reshape(raw.shape) for n in ("x", "y", "tx", "ty"))
    laid = Laid(
        paths=(path,),
        path=np.zeros(raw.shape, dtype=np.intp),
        x=px - across * ty,
        y=py + across * tx,
        psi=np.array(ops.atan2(ty, tx)),
        cruise=cruise,
        more={"s": s, "u": u, "offset": offset, "member": 1.0},
        used=draw.used,
    )
    return laid, spacing
