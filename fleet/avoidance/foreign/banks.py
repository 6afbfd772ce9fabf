"""Banks and no-go polygons: a course that leads to an edge turns parallel to it in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.avoidance.foreign.domain import gap
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.types import Edge
from fleet.ops import R

FAR_M = 1.0e6
BLUNT_M = 1.0e-6
NEAR_M = 2.0  # an edge this much farther off than the end of a leg is not met by it
SQUARE = 0.01  # the same of a course that prefers neither way along the edge
STRAIGHT_AT = 0.17  # cosine of the angle between course and edge: within 10 deg of square to it


class Bent(Struct, Generic[R], frozen=True, gc=False):
    """A course after the banks."""

    cx: R  # unit vector
    cy: R
    bent: R  # 1 a bank bends it
    free: R  # 0 parallel leads to another edge: stop


def within(edges: Sequence[Edge], x: float, y: float, reach: float) -> tuple[Edge, ...]:
    """The edges nearer than `reach` [m] to (x, y), those without length left out."""
    return tuple(e for e in edges if ops.hypot(e[2] - e[0], e[3] - e[1]) > BLUNT_M and _nearest(x, y, e)[2] < reach)


def bend(
    x: R, y: R, cx: R, cy: R, hx: R, hy: R, u: R, r_max: R, edges: Sequence[Edge], params: ForeignParams
) -> Bent[R]:
    """The course (cx, cy) at (x, y), turned parallel to the nearest edge where it leads too near to it.

        parallel within 2 m + 0.6 s u + (1 - cos g) u / r_max of the edge, g the angle between course and edge

    Parallel is the way in which the boat goes already (the other one would be a turn through the edge); where it goes
    straight at the edge, that which is nearer to the course. Within 2 m it is up to 45 deg off the edge.

    Args:
        hx, hy: unit vector of the course on which the boat is
        u: speed [m/s]
        r_max: largest yaw rate [rad/s]
        edges: those that matter, each with a length
    """
    least, nx, ny, away = ops.full(x, FAR_M), ops.zero(x), ops.zero(x), []
    for edge in edges:
        dx, dy, d = _nearest(x, y, edge)
        away.append(d)
        nearer = d < least
        least, nx, ny = ops.where(nearer, d, least), ops.where(nearer, dx, nx), ops.where(nearer, dy, ny)
    if not ops.some(least < params.bank_m + params.bank_s * u + u / r_max):
        return Bent(cx, cy, ops.zero(x), ops.full(x, 1.0))
    per = 1.0 / ops.maximum(least, BLUNT_M)
    nx, ny = nx * per, ny * per
    along = cy * nx - cx * ny  # of the tangent (-ny, nx)
    room = params.bank_m + params.bank_s * u + (1.0 - abs(along)) * u / r_max
    bent = (cx * nx + cy * ny > 0.0) & (least < room)
    gone = hy * nx - hx * ny
    leading = ops.where((abs(gone) > STRAIGHT_AT) | (abs(along) < SQUARE), gone, along)
    way = ops.where(leading < 0.0, -1.0, ops.full(x, 1.0))
    off = ops.clip(1.0 - least / max(params.bank_m, BLUNT_M), 0.0, 1.0)  # nearer than it should be: off it, too
    long = 1.0 / ops.sqrt(1.0 + off * off)
    cx = ops.where(bent, (-ny * way - off * nx) * long, cx)
    cy = ops.where(bent, (nx * way - off * ny) * long, cy)
    free = ops.full(x, 1.0)
    if len(edges) > 1 and ops.some(bent):
        ahead = params.bank_m + params.bank_s * u + u / r_max
        near = [e for e, d in zip(edges, away, strict=True) if ops.some(bent & (d < ahead + NEAR_M))]
        clear = ashore(x, y, x + ahead * cx, y + ahead * cy, near, params.ashore_m) < 0.5
        free = ops.flag(ops.no(bent) | clear, x)
    return Bent(cx, cy, ops.flag(bent, x), free)


def off_shore(x: float, y: float, chi: float, edges: Sequence[Edge], reach: float) -> float:
    """Which way round leads off the nearest edge within `reach` [m]: +1 by starboard, -1 by port, 0 none is so near."""
    near = [_nearest(x, y, edge) for edge in within(edges, x, y, reach)]
    if not near:
        return 0.0
    dx, dy, _ = min(near, key=lambda each: each[2])
    s, c = ops.sincos(chi)
    return -1.0 if c * dy - s * dx > 0.0 else 1.0


def ashore(x0: R, y0: R, x1: R, y1: R, edges: Sequence[Edge], near: float) -> R:
    """1 where the leg from (x0, y0) to (x1, y1) comes nearer than `near` [m] to an edge, or crosses it."""
    return ops.flag(offing(x0, y0, x1, y1, edges, near) < near, x0)


def offing(x0: R, y0: R, x1: R, y1: R, edges: Sequence[Edge], near: float) -> R:
    """How near the leg from (x0, y0) to (x1, y1) comes to an edge, 0 where it crosses one; only if it is `near` [m]."""
    least = ops.full(x0, FAR_M)
    for ax, ay, bx, by in edges:
        long = ops.hypot(bx - ax, by - ay)
        ex, ey = (bx - ax) / long, (by - ay) / long
        px, py, qx, qy = x0 - ax, y0 - ay, x1 - ax, y1 - ay
        leg = px * ex + py * ey, py * ex - px * ey, qx * ex + qy * ey, qy * ex - qx * ey
        least = ops.minimum(least, _least(*leg, long, near))
    return least


def _least(x0: R, y0: R, x1: R, y1: R, long: float, near: float) -> R:
    """Distance of the leg to [0, long] of the x axis; FAR_M where all of it is beyond one end or side, as most are."""
    far = near + BLUNT_M
    out = ((y0 > far) & (y1 > far)) | ((y0 < -far) & (y1 < -far))
    out = out | ((x0 > long + far) & (x1 > long + far)) | ((x0 < -far) & (x1 < -far))
    if isinstance(out, bool):
        return FAR_M if out else gap(x0, y0, x1, y1, 0.0, long)[0]
    least = ops.full(x0, FAR_M)
    if not ops.every(out):
        rows = ~out
        least = least.copy()
        least[rows] = gap(x0[rows], y0[rows], x1[rows], y1[rows], 0.0, long)[0]
    return least


def _nearest(x: R, y: R, edge: Edge) -> tuple[R, R, R]:
    """(dx, dy, distance) to the nearest point of an edge [m]."""
    ax, ay, bx, by = edge
    ex, ey = bx - ax, by - ay
    share = ops.clip(((x - ax) * ex + (y - ay) * ey) / (ex * ex + ey * ey), 0.0, 1.0)
    dx, dy = ax + share * ex - x, ay + share * ey - y
    return dx, dy, ops.hypot(dx, dy)
