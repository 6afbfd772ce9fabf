"""The layout of paths all over the place, each of which crosses that of another boat at about the same time."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from fleet import ops
from fleet.guidance.limits import Limits
from fleet.ops import FloatArray
from fleet.paths import Path, arc, straight
from fleet.sim.batch.scenarios import IntArray
from fleet.sim.sweep.distributions import Draw, Spread, radians
from fleet.sim.sweep.layouts import ATTEMPTS, LONG_M, Crowded, Laid, nearest
from fleet.sim.sweep.model import Anywhere

REACT_S = 1.0  # until a boat begins to stop: a message, a decision, a tick
SAMPLES = 9  # of a way to a stop
STRAIGHT_RAD = 1e-3  # less of a turn is none


class Ways(Struct, frozen=True):
    """Arcs that begin at (x, y) on course chi; arrays are (B, K)."""

    x: FloatArray
    y: FloatArray
    chi: FloatArray
    kappa: FloatArray  # curvature, + to starboard [1/m]
    length: FloatArray

    def along(self, s: FloatArray, boat: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(north, east, course) of one boat s along its way, from its start; straight on beyond the end."""
        chi, kappa = self.chi[:, boat], self.kappa[:, boat]
        on = np.minimum(s, self.length[:, boat])
        turned = kappa * on
        bent = np.abs(turned) > 1e-9
        safe = np.where(bent, kappa, 1.0)
        ahead = np.where(bent, np.sin(turned) / safe, on)
        aside = np.where(bent, (1.0 - np.cos(turned)) / safe, 0.0)
        course = chi + turned
        beyond = s - on
        c, sn = np.cos(chi), np.sin(chi)
        north = ahead * c - aside * sn + beyond * np.cos(course)
        east = ahead * sn + aside * c + beyond * np.sin(course)
        return north, east, course


def anywhere(layout: Anywhere, limits: Limits, boats: int, seed: int, case: IntArray, attempts: int = ATTEMPTS) -> Laid:
    """Boats on their ways to meetings; see `model.Anywhere`. Crowded where they do not come apart."""
    shape = (len(case), boats)
    laid = Ways(*(np.zeros(shape) for _ in range(5)))
    cruise = np.ones(shape)
    left = np.arange(len(case))
    used = 0
    for attempt in range(attempts):
        draw = Draw(seed, case[left], boats, attempt)
        new, speed = _drawn(layout, draw)
        for field in Ways.__struct_fields__:
            getattr(laid, field)[left] = getattr(new, field)
        cruise[left] = speed
        used = draw.used
        apart = nearest(new.x, new.y) > layout.apart_m
        left = left[~(apart & escapable(new.x, new.y, new.chi, speed, limits))]
        if not len(left):
            break
    else:
        raise Crowded(case[left], layout.apart_m)
    rows = zip(*(getattr(laid, name).ravel().tolist() for name in Ways.__struct_fields__), strict=True)
    return Laid(
        paths=tuple(_path(*row) for row in rows),
        path=np.arange(cruise.size).reshape(shape),
        x=laid.x,
        y=laid.y,
        psi=ops.wrap(laid.chi),
        cruise=cruise,
        more={"goal_m": laid.length},
        used=used,
    )


def _drawn(layout: Anywhere, draw: Draw) -> tuple[Ways, FloatArray]:
    """One attempt: the first boat begins at the origin, each other one so that it meets one of those before it."""
    chi, turn = draw.per_boat(radians(layout.heading_deg)), draw.per_boat(radians(layout.turn_deg))
    cruise, meet = draw.per_boat(layout.cruise_mps), draw.per_boat(layout.meet_s)
    late, aside = draw.per_boat(layout.late_s), draw.per_boat(layout.aside_m)
    whom = draw.per_boat(Spread(even=(0.0, 1.0)))
    turn = np.where(np.abs(turn) < STRAIGHT_RAD, 0.0, turn)
    length = cruise * (meet + layout.after_s)
    ways = Ways(np.zeros_like(chi), np.zeros_like(chi), chi, turn / length, length)
    for boat in range(1, chi.shape[1]):
        other = (whom[:, boat] * boat).astype(np.intp)
        north, east = np.zeros(len(chi)), np.zeros(len(chi))
        for each in range(boat):
            dn, de, _ = ways.along(cruise[:, each] * meet[:, boat], each)
            chosen = other == each
            north = np.where(chosen, ways.x[:, each] + dn, north)
            east = np.where(chosen, ways.y[:, each] + de, east)
        dn, de, course = ways.along(np.maximum(cruise[:, boat] * (meet[:, boat] + late[:, boat]), 0.0), boat)
        ways.x[:, boat] = north - dn - aside[:, boat] * np.sin(course)
        ways.y[:, boat] = east - de + aside[:, boat] * np.cos(course)
    return ways, cruise


def escapable(x: FloatArray, y: FloatArray, psi: FloatArray, u: FloatArray, limits: Limits) -> NDArray[np.bool_]:
    """(B,) whether boats that all stop at once cannot touch: their ways to a stop lie a hull's length apart.

    A way to a stop is u (max(T_u, u / 2a) + 1 s) long, straight ahead.
    """
    way = u * (np.maximum(u / (2.0 * limits.acceleration_max_mps2), limits.surge_lag_s) + REACT_S)
    share = np.linspace(0.0, 1.0, SAMPLES)
    s, c = ops.sincos(psi)
    north = x[..., None] + (way * c)[..., None] * share
    east = y[..., None] + (way * s)[..., None] * share
    clear: NDArray[np.bool_] = np.ones(len(x), dtype=bool)
    for i, j in combinations(range(x.shape[1]), 2):
        dx = north[:, i, :, None] - north[:, j, None, :]
        dy = east[:, i, :, None] - east[:, j, None, :]
        clear &= (dx * dx + dy * dy).min(axis=(1, 2)) > limits.length_m * limits.length_m
    return clear


def _path(x: float, y: float, chi: float, kappa: float, length: float) -> Path:
    """An arc, or a line, that begins at (x, y) on course chi."""
    c, s = math.cos(chi), math.sin(chi)
    if kappa == 0.0:
        return straight((x, y), (x + LONG_M * c, y + LONG_M * s))
    side, radius = math.copysign(1.0, kappa), 1.0 / abs(kappa)
    centre = (x - side * radius * s, y + side * radius * c)
    return arc(centre, radius, math.atan2(-side * c, side * s), kappa * length)
