"""Paths of smooth curves: sines, and cubic splines through points, cut into cells by arc length."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

from fleet.paths.build import line_piece, smooth_piece
from fleet.paths.errors import PathError, Point, need_finite, need_points, need_positive
from fleet.paths.path import Path, Piece

CELL_M = 1.0
"""Longest cell of a smooth curve [m]."""
_LEAST_COS = math.cos(0.125)  # a cell turns at most this much, as arcs do
_MOST_DOUBLINGS = 7

Curve = Callable[[float], tuple[float, float, float, float]]
"""x, y, dx/du, dy/du of a parameter u."""


def sine(start: Point, end: Point, amplitude: float, wavelength: float) -> Path:
    """A sine about the line from start to end, first to starboard for a positive amplitude."""
    need_positive(wavelength, "wavelength of the sine")
    height = need_finite(amplitude, "amplitude of the sine")
    (x0, y0), (x1, y1) = a, b = need_points((start, end), 2, closed=False)
    if height == 0.0:
        return Path([line_piece(a, b)], closed=False)
    long = math.hypot(x1 - x0, y1 - y0)
    ux, uy = (x1 - x0) / long, (y1 - y0) / long
    k = 2.0 * math.pi / wavelength

    def curve(u: float) -> tuple[float, float, float, float]:
        off, slope = height * math.sin(k * u), height * k * math.cos(k * u)
        return x0 + u * ux - off * uy, y0 + u * uy + off * ux, ux - slope * uy, uy + slope * ux

    parts = max(1, math.ceil(4.0 * long / wavelength))
    pieces: list[Piece] = []
    for i in range(parts):
        pieces.extend(_cells(curve, long * i / parts, long * (i + 1) / parts, "sine"))
    return Path(pieces, closed=False)


def through(points: Sequence[Point], closed: bool = False) -> Path:
    """A cubic spline through points: centripetal parameter, natural ends, or periodic where closed."""
    nodes = need_points(tuple(points), 3 if closed else 2, closed)
    if closed:
        nodes = (*nodes, nodes[0])
    if len(nodes) == 2:
        return Path([line_piece(*nodes)], closed=False)
    spans = [math.sqrt(math.hypot(q[0] - p[0], q[1] - p[1])) for p, q in pairwise(nodes)]
    bends = [_second_derivatives([p[axis] for p in nodes], spans, closed) for axis in (0, 1)]
    pieces: list[Piece] = []
    for i, h in enumerate(spans):
        x = _coefficients(nodes[i][0], nodes[i + 1][0], bends[0][i], bends[0][i + 1], h)
        y = _coefficients(nodes[i][1], nodes[i + 1][1], bends[1][i], bends[1][i + 1], h)
        pieces.extend(_cells(_cubic(x, y), 0.0, h, f"curve after point {i + 1}"))
    return Path(pieces, closed)


def _cubic(x: tuple[float, float, float, float], y: tuple[float, float, float, float]) -> Curve:
    """A span of the spline as a curve."""
    x0, x1, x2, x3 = x
    y0, y1, y2, y3 = y

    def curve(u: float) -> tuple[float, float, float, float]:
        bx, by = x3 * u, y3 * u
        ax, ay = x2 + bx, y2 + by
        return (
            x0 + u * (x1 + u * ax),
            y0 + u * (y1 + u * ay),
            x1 + u * (2.0 * ax + bx),
            y1 + u * (2.0 * ay + by),
        )

    return curve


def _coefficients(p: float, q: float, m: float, n: float, h: float) -> tuple[float, float, float, float]:
    """Cubic over [0, h] from values p, q and second derivatives m, n at its ends."""
    return p, (q - p) / h - h * (2.0 * m + n) / 6.0, 0.5 * m, (n - m) / (6.0 * h)


def _second_derivatives(values: list[float], spans: list[float], closed: bool) -> list[float]:
    """Second derivatives of the interpolating spline at its nodes; closed: the last node is the first again."""
    n = len(spans)
    slopes = [(b - a) / h for a, b, h in zip(values, values[1:], spans, strict=False)]
    if not closed:
        rows = range(1, n)
        inner = _tridiagonal(
            [spans[i - 1] for i in rows],
            [2.0 * (spans[i - 1] + spans[i]) for i in rows],
            [spans[i] for i in rows],
            [6.0 * (slopes[i] - slopes[i - 1]) for i in rows],
        )
        return [0.0, *inner, 0.0]
    below = [spans[i - 1] for i in range(n)]
    diagonal = [2.0 * (spans[i - 1] + spans[i]) for i in range(n)]
    right = [6.0 * (slopes[i] - slopes[i - 1]) for i in range(n)]
    # the corners of the cyclic system are a matrix of rank one: Sherman and Morrison
    corner = spans[-1]
    gamma = -diagonal[0]
    diagonal[0] -= gamma
    diagonal[-1] -= corner * corner / gamma
    y = _tridiagonal(below, diagonal, spans, right)
    z = _tridiagonal(below, diagonal, spans, [gamma, *[0.0] * (n - 2), corner])
    share = (y[0] + corner * y[-1] / gamma) / (1.0 + z[0] + corner * z[-1] / gamma)
    solved = [a - share * b for a, b in zip(y, z, strict=True)]
    return [*solved, solved[0]]


def _tridiagonal(below: list[float], diagonal: list[float], above: list[float], right: list[float]) -> list[float]:
    """Solve a system that is dominant on its diagonal, by elimination; below[0] and above[-1] are not used."""
    n = len(diagonal)
    factor, value = [0.0] * n, [0.0] * n
    for i in range(n):
        pivot = diagonal[i] - (below[i] * factor[i - 1] if i else 0.0)
        factor[i] = above[i] / pivot
        value[i] = (right[i] - (below[i] * value[i - 1] if i else 0.0)) / pivot
    for i in range(n - 2, -1, -1):
        value[i] -= factor[i] * value[i + 1]
    return value


def _cells(curve: Curve, low: float, high: float, name: str) -> list[Piece]:
    """A span of a curve cut evenly in its parameter into cells of at most 1 m that turn little, lengths by Simpson."""
    fastest = max(math.hypot(*curve(low + (high - low) * k / 4.0)[2:]) for k in range(5))
    count = max(4, math.ceil(1.02 * fastest * (high - low) / CELL_M))
    for _ in range(_MOST_DOUBLINGS):
        pieces = _try_cells(curve, low, high, count)
        if pieces:
            return pieces
        count *= 2
    x, y, _, _ = curve(0.5 * (low + high))
    raise PathError(f"{name} has a kink near [{x:.2f}, {y:.2f}] m; expected a curve that turns gradually")


def _try_cells(curve: Curve, low: float, high: float, count: int) -> list[Piece]:
    """Cells of equal parameter; none when one of them is too long or turns too much."""
    pieces: list[Piece] = []
    step = (high - low) / count
    x, y, vx, vy = curve(low)
    v0 = math.sqrt(vx * vx + vy * vy)
    if v0 < 1e-9:
        return []
    a = (x, y, vx / v0, vy / v0)
    for k in range(count):
        _, _, vx, vy = curve(low + (k + 0.5) * step)
        middle = math.sqrt(vx * vx + vy * vy)
        x, y, vx, vy = curve(low + (k + 1) * step)
        v1 = math.sqrt(vx * vx + vy * vy)
        length = (v0 + 4.0 * middle + v1) * step / 6.0
        if length > CELL_M or v1 < 1e-9:
            return []
        b = (x, y, vx / v1, vy / v1)
        if a[2] * b[2] + a[3] * b[3] < _LEAST_COS:
            return []
        pieces.append(smooth_piece(a, b, length))
        a, v0 = b, v1
    return pieces
