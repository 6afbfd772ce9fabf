"""Paths of lines and arcs, and the two kinds of pieces that all paths are made of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from fleet.paths.errors import PathError, Point, need_finite, need_points, need_positive, show
from fleet.paths.path import Path, Piece

TURN_PER_CELL = 0.125
"""An arc turns at most this much per cell [rad]: below the 10 deg of `straight`, and below 1e-6 of the radius off."""
_LEAST_LINE_M = 1e-4  # shorter leftovers between two corners are left out
_LEAST_ARC_M = 0.5  # gentle corners are rounded more gently than asked, so that no cell gets tiny
_LEAST_TURN = 1e-9  # below it two legs are one line [rad]
_MOST_TURN = math.pi - 1e-3  # above it the path doubles back [rad]

Node = tuple[float, float, float, float]
"""x, y and the unit tangent there."""


def line_piece(a: Point, b: Point) -> Piece:
    """A straight line from a to b."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    return (a[0], dx, 0.0, 0.0, a[1], dy, 0.0, 0.0, math.sqrt(dx * dx + dy * dy))


def smooth_piece(a: Node, b: Node, length: float) -> Piece:
    """The cubic between two points with unit tangents: of unit speed at both ends, so that t grows evenly with s."""
    (x0, y0, tx0, ty0), (x1, y1, tx1, ty1) = a, b
    ax, ay, bx, by = tx0 * length, ty0 * length, tx1 * length, ty1 * length
    dx, dy = x1 - x0, y1 - y0
    x3, y3 = ax + bx - 2.0 * dx, ay + by - 2.0 * dy
    return (x0, ax, dx - ax - x3, x3, y0, ay, dy - ay - y3, y3, length)


def arc_pieces(centre: Point, radius: float, bearing: float, turn: float) -> list[Piece]:
    """An arc that starts at a bearing from its centre and turns, + clockwise [rad]."""
    count = math.ceil(abs(turn) / TURN_PER_CELL - 1e-9)
    side = math.copysign(1.0, turn)
    length = radius * abs(turn) / count
    nodes: list[Node] = []
    for k in range(count + 1):
        angle = bearing + turn * k / count
        c, s = math.cos(angle), math.sin(angle)
        nodes.append((centre[0] + radius * c, centre[1] + radius * s, -side * s, side * c))
    return [smooth_piece(a, b, length) for a, b in pairwise(nodes)]


def straight(start: Point, end: Point) -> Path:
    """A straight line."""
    a, b = need_points((start, end), 2, closed=False)
    return Path([line_piece(a, b)], closed=False)


def arc(centre: Point, radius: float, from_bearing_rad: float, turn_rad: float) -> Path:
    """Part of a circle from a bearing seen from its centre; turn + clockwise; a whole turn is a closed path."""
    need_positive(radius, "radius of the arc")
    need_finite(from_bearing_rad, "bearing of the arc's start")
    need_finite(turn_rad, "turn of the arc")
    middle = (need_finite(centre[0], "north of the arc's centre"), need_finite(centre[1], "east of the arc's centre"))
    whole = abs(abs(turn_rad) - 2.0 * math.pi) < 1e-6
    if whole:
        turn_rad = math.copysign(2.0 * math.pi, turn_rad)
    if not 1e-6 <= abs(turn_rad) <= 2.0 * math.pi:
        raise PathError(
            f"arc about {show(middle)} turns by {math.degrees(turn_rad):.6g} deg; "
            "expected up to 360 deg either way, and not 0"
        )
    return Path(arc_pieces(middle, float(radius), from_bearing_rad, turn_rad), closed=whole)


def polyline(points: Sequence[Point], corner_radius: float, closed: bool = False) -> Path:
    """Straight legs with corners rounded by arcs of at least the corner radius."""
    radius = need_positive(corner_radius, "corner radius")
    nodes = need_points(tuple(points), 3 if closed else 2, closed)
    n = len(nodes)
    count = n if closed else n - 1
    legs = [_leg(nodes[i], nodes[(i + 1) % n]) for i in range(count)]  # unit vectors and lengths
    turns = [0.0] * (n + 1)  # at each node; the last one again the first
    for i in range(0 if closed else 1, count):
        (ax, ay, _), (bx, by, _) = legs[i - 1], legs[i]
        turns[i] = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        if abs(turns[i]) > _MOST_TURN:
            raise PathError(
                f"path doubles back at point {i + 1} {show(nodes[i])}, turning by {math.degrees(turns[i]):.1f} deg; "
                "expected less than 180 deg"
            )
    if closed:
        turns[n] = turns[0]
    cuts = _cuts(nodes, legs, turns, radius)
    pieces: list[Piece] = []
    for i, (ux, uy, long) in enumerate(legs):
        (x0, y0), (x1, y1) = nodes[i], nodes[(i + 1) % n]
        a = (x0 + ux * cuts[i], y0 + uy * cuts[i])
        b = (x1 - ux * cuts[i + 1], y1 - uy * cuts[i + 1])
        if long - cuts[i] - cuts[i + 1] > _LEAST_LINE_M:
            pieces.append(line_piece(a, b))
        turn = turns[i + 1]
        if abs(turn) > _LEAST_TURN:
            side = math.copysign(1.0, turn)
            r = cuts[i + 1] / math.tan(0.5 * abs(turn))
            centre = (b[0] - side * uy * r, b[1] + side * ux * r)
            pieces.extend(arc_pieces(centre, r, math.atan2(-side * ux, side * uy), turn))
    return Path(pieces, closed)


def _leg(a: Point, b: Point) -> tuple[float, float, float]:
    """Unit vector and length of the leg from a to b."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    long = math.hypot(dx, dy)
    return dx / long, dy / long, long


def _cuts(
    nodes: tuple[Point, ...], legs: list[tuple[float, float, float]], turns: list[float], radius: float
) -> list[float]:
    """Metres that the arc at each node takes from both its legs; refuses legs that are too short for that."""
    n = len(nodes)
    cuts = [radius * math.tan(0.5 * abs(turn)) for turn in turns]
    spare = []
    for i, (_, _, long) in enumerate(legs):
        need = cuts[i] + cuts[i + 1]
        if need > long + 1e-9:
            j = (i + 1) % n
            raise PathError(
                f"leg from point {i + 1} {show(nodes[i])} to point {j + 1} {show(nodes[j])} is {long:.2f} m long, its "
                f"corners of radius {radius:.2f} m need {need:.2f} m; expected a corner radius of at most "
                f"{radius * long / need:.2f} m, or a longer leg"
            )
        spare.append(long - need)
    for i, turn in enumerate(turns[: len(legs)]):
        if abs(turn) > _LEAST_TURN:
            gentle = _LEAST_ARC_M / abs(turn) * math.tan(0.5 * abs(turn))
            room = 0.5 * min(spare[i - 1], spare[i])
            cuts[i] = max(cuts[i], min(gentle, cuts[i] + room))
    if turns[-1] != 0.0:
        cuts[-1] = cuts[0]
    return cuts
