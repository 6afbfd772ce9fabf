"""Distances, domains, classes and ways of a scenario with foreign vessels, from the true tracks only."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from msgspec import structs

from fleet.avoidance.foreign import ForeignParams
from fleet.avoidance.foreign.domain import domain, gap
from fleet.avoidance.foreign.encounter import Bearing, classify
from fleet.ops import FloatArray
from fleet.sensing import Target
from fleet.sim.batch.ships import ShipCase, Voyage
from fleet.sim.batch.ships_radio import DT_S

HULL_RADIUS_M = 0.6  # of the own capsule, 2.4 m x 1.2 m
HULL_HALF_M = 0.6  # from its centre to the centres of its round ends
CLASS_BEFORE_S = 200.0 * 2.2 / 1500.0  # of the time to meet: the class counts this long before entry
SPARSE = 10  # ticks
PARAMS = ForeignParams()


def relative(voyage: Voyage, k: int, extra: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Boats' centres in the frame of vessel k, its course as the first axis; `extra` metres ahead of the centre."""
    c, s = np.cos(voyage.ship_chi[:, k, None]), np.sin(voyage.ship_chi[:, k, None])
    dx = voyage.x + extra * np.cos(voyage.psi) - voyage.ship_x[:, k, None]
    dy = voyage.y + extra * np.sin(voyage.psi) - voyage.ship_y[:, k, None]
    return dx * c + dy * s, dy * c - dx * s


def hull_distance(case: ShipCase, voyage: Voyage, k: int) -> FloatArray:
    """(tick, boat): distance of the capsules, target length L and radius 0.1 L; <= 0 they touch [m]."""
    L = case.ships[k].length
    bow, stern = relative(voyage, k, HULL_HALF_M), relative(voyage, k, -HULL_HALF_M)
    d, _ = gap(stern[0], stern[1], bow[0], bow[1], -0.4 * L, 0.4 * L)
    return d - 0.1 * L - HULL_RADIUS_M


def core(case: ShipCase, k: int, variance: float = 0.0) -> tuple[float, float, float]:
    """(astern, ahead, C) of the true vessel, C0 where it is exactly known; a stopped one is a point."""
    d = domain(structs.replace(as_target(case, k, 0.0), P11=variance), case.cruise, 0.0, PARAMS)
    return d.astern, d.ahead, d.C


def as_target(case: ShipCase, k: int, t: float) -> Target:
    """The vessel at time t, exactly known, before it turns."""
    ship = case.ships[k]
    vx, vy = ship.U * math.cos(ship.chi), ship.U * math.sin(ship.chi)
    return Target(
        float(k), ship.x + t * vx, ship.y + t * vy, vx, vy, 0.0, 0.0, 0.0, 0.0, ship.length, 0.0, 1.0
    )  # fmt: skip


def domain_share(case: ShipCase, voyage: Voyage, k: int) -> FloatArray:
    """(tick, boat): distance from the own centre to the core, as a share of C0."""
    astern, ahead, C = core(case, k)
    x, y = relative(voyage, k)
    over = x - np.clip(x, astern, ahead)
    share: FloatArray = np.sqrt(over * over + y * y) / C
    return share


def nominal(case: ShipCase, k: int, party: Sequence[int]) -> tuple[float, float]:
    """(Kind, entry): with everybody straight on, when a party enters the domain and the class before that [s]."""
    ship = case.ships[k]
    t = np.array([i * DT_S for i in range(round(case.limit_s / DT_S))])
    vx, vy = ship.U * math.cos(ship.chi), ship.U * math.sin(ship.chi)
    astern, ahead, C = core(case, k)
    inside = np.zeros(len(t), dtype=bool)
    c, s = math.cos(ship.chi), math.sin(ship.chi)
    for i in party:
        x, y = undisturbed(case, i, t)
        dx, dy = x - ship.x - vx * t, y - ship.y - vy * t
        along, across = dx * c + dy * s, dy * c - dx * s
        over = along - np.clip(along, astern, ahead)
        inside |= over * over + across * across < C * C
    if not inside.any():
        return 0.0, math.inf
    entry = float(t[inside.argmax()])
    at = max(entry - CLASS_BEFORE_S * case.meet_s, 0.0)
    first = party[0]
    point = case.path_of(first).at(case.begins_at(first) + case.cruise * at)
    ex, ey = point.tx, point.ty
    own = Bearing(point.x, point.y, ex, ey, case.cruise, case.cruise * ex, case.cruise * ey)
    kind, _ = classify(own, domain(as_target(case, k, at), case.cruise, 0.0, PARAMS), PARAMS)
    return kind, entry


def undisturbed(case: ShipCase, boat: int, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where a boat would be with nobody in the way, at every time."""
    x, y, _ = case.paths[boat]
    path, begin = case.path_of(boat), case.begins_at(boat)
    if case.bend is None:
        way = path.at(begin)
        return x + way.tx * case.cruise * t, y + way.ty * case.cruise * t
    places = [path.at(begin + case.cruise * each) for each in t[::SPARSE].tolist()]
    return (
        np.interp(t, t[::SPARSE], [place.x for place in places]),
        np.interp(t, t[::SPARSE], [place.y for place in places]),
    )


def miss(case: ShipCase, voyage: Voyage, k: int, row: int, boat: int) -> float:
    """m = cross(p, w) at that tick: > 0 the vessel is left to port."""
    chi, U = voyage.ship_chi[row, k], case.ships[k].U
    px, py = voyage.ship_x[row, k] - voyage.x[row, boat], voyage.ship_y[row, k] - voyage.y[row, boat]
    before = max(min(row, len(voyage.t) - 2), 0)
    rows = slice(before, before + 2)
    vx, vy = velocity(voyage.x[rows, boat])[0], velocity(voyage.y[rows, boat])[0]
    wx, wy = vx - U * math.cos(chi), vy - U * math.sin(chi)
    return float(px * wy - py * wx)


def way_made(case: ShipCase, voyage: Voyage) -> float:
    """Of the first boat along its path [m]."""
    if case.bend is None and not case.courses:
        return float(voyage.x[-1, 0] - case.paths[0][0])
    path = case.path_of(0) if case.courses else case.path()
    return path.project(float(voyage.x[-1, 0]), float(voyage.y[-1, 0]))


def deviation(case: ShipCase, voyage: Voyage) -> float:
    """Largest distance of a boat from its path [m]."""
    if case.bend is None and not case.courses:
        return float(abs(voyage.y - np.array([y for _, y, _ in case.paths])).max())
    most = 0.0
    for i in range(len(case.paths)):
        path = case.path_of(i)
        for x, y in zip(voyage.x[::SPARSE, i].tolist(), voyage.y[::SPARSE, i].tolist(), strict=True):
            point = path.at(path.project(x, y))
            most = max(most, math.hypot(x - point.x, y - point.y))
    return most


def velocity(x: FloatArray) -> FloatArray:
    """Over ground from positions [m/s]."""
    v: FloatArray = np.gradient(x, DT_S, axis=0) if len(x) > 1 else np.zeros_like(x)
    return v


def closest(voyage: Voyage) -> float:
    """Least distance between the centres of two boats [m]."""
    boats = voyage.x.shape[1]
    return min(
        (
            float(np.hypot(voyage.x[:, i] - voyage.x[:, j], voyage.y[:, i] - voyage.y[:, j]).min())
            for i in range(boats)
            for j in range(i)
        ),
        default=math.inf,
    )


def to_edge(voyage: Voyage, edge: tuple[float, float, float, float]) -> FloatArray:
    """(tick, boat): distance to an edge [m]."""
    ax, ay, bx, by = edge
    long = math.hypot(bx - ax, by - ay)
    ex, ey = (bx - ax) / long, (by - ay) / long
    px, py = voyage.x - ax, voyage.y - ay
    along, across = px * ex + py * ey, py * ex - px * ey
    over = along - np.clip(along, 0.0, long)
    away: FloatArray = np.sqrt(over * over + across * across)
    return away
