"""Where the boats of a family begin, on which paths, and what they are told: layouts over arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec import Struct

from fleet import ops
from fleet.ops import FloatArray
from fleet.paths import Path, straight
from fleet.sim.batch.scenarios import IntArray
from fleet.sim.sweep.distributions import Draw, radians
from fleet.sim.sweep.model import Circle, Column, Formation, Meeting

LONG_M = 3000.0  # of every path
ATTEMPTS = 2000  # to begin far enough apart


class Crowded(Exception):
    """Some cases have boats too near each other at the start, however often they are drawn."""

    def __init__(self, cases: IntArray, apart_m: float) -> None:
        self.cases, self.apart_m = cases, apart_m
        super().__init__(f"{len(cases)} cases, the first is {int(cases[0])}, do not begin {apart_m:g} m apart")


class Laid(Struct, frozen=True, kw_only=True):
    """What a layout says of some cases; arrays are (B, K)."""

    paths: tuple[Path, ...]
    path: IntArray
    x: FloatArray
    y: FloatArray
    psi: FloatArray
    cruise: FloatArray
    more: dict[str, Any]
    """Further arguments of `fleet.sim.batch.assemble`."""
    used: int
    """Draws that were used up."""


def meeting(layout: Meeting, boats: int, seed: int, case: IntArray, attempts: int = ATTEMPTS) -> Laid:
    """Straight paths through about one point; see `model.Meeting`. Crowded where they do not come apart."""
    shape = (len(case), boats)
    chi, cruise, x, y = np.zeros(shape), np.ones(shape), np.zeros(shape), np.zeros(shape)
    left = np.arange(len(case))
    used = 0
    for attempt in range(attempts):
        draw = Draw(seed, case[left], boats, attempt)
        new_chi = _headings(layout, draw)
        new_cruise = draw.per_boat(layout.cruise_mps)
        before = new_cruise * (layout.meet_s + draw.per_boat(layout.late_s))
        aside = draw.per_boat(layout.aside_m)
        s, c = ops.sincos(new_chi)
        chi[left], cruise[left] = new_chi, new_cruise
        x[left], y[left] = -before * c - aside * s, aside * c - before * s
        used = draw.used
        left = left[nearest(x[left], y[left]) <= layout.apart_m]
        if not len(left):
            break
    else:
        raise Crowded(case[left], layout.apart_m)
    s, c = ops.sincos(chi)
    paths, path = lines(x, y, c, s)
    more = {"goal_m": 2.0 * layout.meet_s * cruise}
    return Laid(paths=paths, path=path, x=x, y=y, psi=chi, cruise=cruise, more=more, used=used)


def _headings(layout: Meeting, draw: Draw) -> FloatArray:
    """(B, K), each for itself or about that of the first boat [rad]."""
    chi = draw.per_boat(radians(layout.heading_deg))
    if layout.relative_deg is None:
        return chi
    relative = draw.per_boat(radians(layout.relative_deg))
    relative[:, 0] = 0.0
    around: FloatArray = ops.wrap(chi[:, :1] + relative)
    return around


def circle_radius(boats: int) -> float:
    """40 m up to four boats, 50 m to eight, then 4.5 m per boat; 70 m for 16, as in the yardstick [m]."""
    if boats == 16:
        return 70.0
    return 40.0 if boats <= 4 else 50.0 if boats <= 8 else 4.5 * boats


def circle(layout: Circle, boats: int, seed: int, case: IntArray) -> Laid:
    """Each boat to the opposite point; see `model.Circle`."""
    r = circle_radius(boats) if layout.radius_m is None else layout.radius_m
    draw = Draw(seed, case, boats)
    place = np.arange(boats) * (2.0 * np.pi / boats) + draw.per_boat(layout.place_rad)
    chi = ops.wrap(place + np.pi)
    s, c = ops.sincos(place)
    x = r * c + draw.per_boat(layout.offset_m)
    y = r * s + draw.per_boat(layout.offset_m)
    cruise = draw.per_boat(layout.cruise_mps)
    s, c = ops.sincos(chi)
    paths, path = lines(x, y, c, s)
    return Laid(
        paths=paths, path=path, x=x, y=y, psi=chi, cruise=cruise, more={"goal_m": 2.0 * r}, used=draw.used
    )  # fmt: skip


def column(layout: Column, formation: Formation, boats: int, seed: int, case: IntArray) -> tuple[Laid, FloatArray]:
    """Boats in column to the north, and the spacing of each case (B,) [m]; see `model.Column`."""
    draw = Draw(seed, case, boats)
    spacing = draw.per_scenario(formation.spacing_m)
    place = slots(boats) * spacing[:, None]
    s = place + draw.per_boat(layout.along_m)
    y = draw.per_boat(layout.across_m)
    psi = draw.per_boat(layout.heading_rad)
    cruise = np.repeat(draw.per_scenario(formation.cruise_mps)[:, None], boats, axis=1)
    u = cruise * draw.per_boat(layout.speed_share)
    path = np.zeros((len(case), boats), dtype=np.intp)
    line = straight((0.0, 0.0), (LONG_M, 0.0))
    more = {"s": s, "u": u, "offset": place, "member": 1.0}
    return Laid(paths=(line,), path=path, x=s, y=y, psi=psi, cruise=cruise, more=more, used=draw.used), spacing


def slots(boats: int) -> FloatArray:
    """Places of a column in spacings, the first boat ahead: K - 1 .. 0."""
    return np.arange(boats - 1, -1, -1.0)


def lines(x: FloatArray, y: FloatArray, c: FloatArray, s: FloatArray) -> tuple[tuple[Path, ...], IntArray]:
    """A straight path per boat from (x, y) along the unit vector (c, s); and their numbers (B, K)."""
    begin = zip(x.ravel().tolist(), y.ravel().tolist(), c.ravel().tolist(), s.ravel().tolist(), strict=True)
    paths = tuple(straight((x0, y0), (x0 + LONG_M * tx, y0 + LONG_M * ty)) for x0, y0, tx, ty in begin)
    return paths, np.arange(x.size).reshape(x.shape)


def nearest(x: FloatArray, y: FloatArray) -> FloatArray:
    """(B,) least distance of two boats; infinite for one [m]."""
    least = np.full(len(x), np.inf)
    for i in range(x.shape[1]):
        for j in range(i):
            least = np.minimum(least, ops.hypot(x[:, i] - x[:, j], y[:, i] - y[:, j]))
    return least
