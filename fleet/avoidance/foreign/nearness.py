"""What it costs to come near to vessels and mates on many ways at once: arrays (vessel, vertex, boat, candidate)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from msgspec import Struct

from fleet import ops
from fleet.avoidance.foreign.domain import Domain, Guess, gap
from fleet.avoidance.foreign.encounter import Bearing
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.rollout import Way
from fleet.avoidance.foreign.types import Afloat, Mate
from fleet.ops import BoolArray, FloatArray

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

IntArray: TypeAlias = "NDArray[np.intp]"
FAR = 1.0e6
SIDE_NEAR = 2.0  # C: passing farther off, the side is worth no part of a domain,
SIDE_REACH = 4.0  # and farther off than this it does not matter


class Ways(Struct, frozen=True, gc=False):
    """Ways, stacked."""

    t: FloatArray  # (vertex, 1, 1)
    x: FloatArray  # (vertex, boat, candidate)
    y: FloatArray


class Vessels(Struct, frozen=True, gc=False):
    """Vessels, each as often as there are guesses of its velocity; arrays (guess, 1, 1, 1)."""

    domains: list[Domain]  # of each guess
    guesses: list[Guess]

    def column(self, name: str) -> FloatArray:
        """A figure of every domain."""
        import numpy as np

        return np.array([getattr(d, name) for d in self.domains])[:, None, None, None]

    def motion(self, name: str) -> FloatArray:
        """A figure of every guess."""
        import numpy as np

        return np.array([getattr(g, name) for g in self.guesses])[:, None, None, None]


class Legs(Struct, frozen=True, gc=False):
    """What every leg of the ways does, arrays (guess, leg, boat, candidate)."""

    first: FloatArray  # distance to the core at the start of the way [m]
    least: FloatArray  # least distance to the core [m]
    when: FloatArray  # time of that [s]
    C: FloatArray  # clearance then [m]


def stacked(way: Way[FloatArray]) -> Ways:
    """The vertices of the ways as arrays."""
    import numpy as np

    return Ways(np.array(way.t)[:, None, None], np.stack(way.x), np.stack(way.y))


def part(ways: Ways, boats: Sequence[int], candidates: Sequence[int]) -> Ways:
    """Those of some boats on some candidates."""
    import numpy as np

    rows = np.array(boats)[:, None], np.array(candidates)
    return Ways(ways.t, ways.x[:, rows[0], rows[1]], ways.y[:, rows[0], rows[1]])


def nearness(
    ways: Ways,
    boat: Afloat,
    domains: Sequence[Domain],
    sides: dict[float, tuple[float, float]],
    mates: Sequence[Mate],
    params: ForeignParams,
) -> FloatArray:
    """Price of the vessels and mates on every candidate; v is the worst over the boats and over the guesses.

    100 max v + 30 sum v + 300 max v_half + 1000 max v_hull + the wrong sides

    Args:
        sides: wanted of each vessel, by number, and what the other one costs
    """
    import numpy as np

    worst = each = half = hull = wrong = np.zeros(ways.x.shape[2])
    near = vessels(d for d in domains if _reachable(d, boat, float(ways.t[-1, 0, 0])))
    if near.domains:
        v_domain, v_half, v_hull, turn, close = _violations(ways, near, params)
        for number in dict.fromkeys(d.number for d in near.domains):
            rows = [i for i, d in enumerate(near.domains) if d.number == number]
            v = v_domain[rows].max(axis=0)
            worst, each = np.maximum(worst, v), each + v
            side, dear = sides.get(number, (0.0, 0.0))
            off = side * turn[rows[0]] < 0.0
            far = min(dear, params.other_side)
            wrong = wrong + np.where((off & close[rows[0]]).any(axis=0), dear, np.where(off.any(axis=0), far, 0.0))
        half, hull = v_half.max(axis=0), v_hull.max(axis=0)
    if mates:
        v_mates, v_touch = _mates(ways, mates, params)
        for v in v_mates:
            worst, each = np.maximum(worst, v), each + v
        hull = np.maximum(hull, v_touch.max(axis=0))
    price: FloatArray = params.worst * worst + params.each * each + params.half * half + params.hull * hull + wrong
    return price


def free_after(ways: Ways, own: Bearing, domains: Sequence[Domain], params: ForeignParams) -> FloatArray:
    """First time on each candidate from which the plain path velocity clears those vessels by 1.1 C over H [s].

    Where there is none, 1.5 times the end of the candidate.
    """
    import numpy as np

    if not domains:
        return np.zeros(ways.x.shape[2])
    near = vessels(domains)
    x, y = _frames(ways, near)
    ex, ey, H = near.motion("ex"), near.motion("ey"), near.column("H")
    wx, wy = own.cruise * own.ex - near.motion("vx"), own.cruise * own.ey - near.motion("vy")
    dx, dy = (wx * ex + wy * ey) * H, (wy * ex - wx * ey) * H
    C = params.acting_factor * near.column("C")
    least, _ = _gaps(x, y, x + dx, y + dy, near.column("astern"), near.column("ahead"), C)
    free = (least >= C).all(axis=(0, 2))  # (vertex, candidate)
    t = ways.t[:, 0, 0]
    first: FloatArray = np.where(free.any(axis=0), t[free.argmax(axis=0)], 1.5 * t[-1])
    return first


def vessels(domains: Any) -> Vessels:
    """One row for each guess of each domain."""
    rows = [(d, g) for d in domains for g in d.guesses]
    return Vessels([d for d, _ in rows], [g for _, g in rows])


def _frames(ways: Ways, near: Vessels) -> tuple[FloatArray, FloatArray]:
    """(x, y) of the ways in the frames of the vessels as they move on, their courses as the first axis."""
    px = ways.x - (near.column("x") + ways.t * near.motion("vx"))
    py = ways.y - (near.column("y") + ways.t * near.motion("vy"))
    ex, ey = near.motion("ex"), near.motion("ey")
    return px * ex + py * ey, py * ex - px * ey


def _reachable(d: Domain, boat: Afloat, horizon: float) -> bool:
    """It can come near enough within the horizon to have a price."""
    u = max(boat.limits.speed_max_mps, boat.U)
    reach = SIDE_REACH * 1.1 * (d.C + d.most) + d.ahead - d.astern + 200.0
    return ops.hypot(d.x - boat.x, d.y - boat.y) < reach + (u + d.U) * horizon


def _violations(
    ways: Ways, near: Vessels, params: ForeignParams
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, BoolArray]:
    """(v, v_half, v_hull), (guess, candidate); m of the nearest leg, 0 if far off, near: (guess, boat, candidate)."""
    import numpy as np

    x, y = _frames(ways, near)
    most = near.column("C") + near.column("most")
    legs = _legs(ways, near, x, y, near.column("astern"), near.column("ahead"), SIDE_REACH * most)
    v, k = _violated(ways, near, legs, legs.C, params)
    turn = y[:, :-1] * (x[:, 1:] - x[:, :-1]) - x[:, :-1] * (y[:, 1:] - y[:, :-1])  # cross(p, w) dt
    least, C = _at(legs.least, k), _at(legs.C, k)
    half, hull = np.zeros_like(v), np.zeros_like(v)
    bad = np.flatnonzero(v.max(axis=0) > 0.0)  # elsewhere the smaller cores are clear, too
    if bad.size:
        part = Ways(ways.t, ways.x[:, :, bad], ways.y[:, :, bad])
        size = near.column("half")
        radius = np.maximum(params.half_radius * most, near.column("hull"))
        inner = _legs(part, near, x[..., bad], y[..., bad], -size, size, params.acting_factor * radius)
        half[:, bad], _ = _violated(part, near, inner, params.half_radius * inner.C, params)
        hull[:, bad], _ = _violated(part, near, inner, near.column("hull") * np.ones_like(inner.C), params)
    return v, half, hull, np.where(least < SIDE_REACH * C, _at(turn, k), 0.0), least < SIDE_NEAR * C


def _legs(
    ways: Ways, near: Vessels, x: FloatArray, y: FloatArray, low: FloatArray, high: FloatArray, far: FloatArray
) -> Legs:
    """All legs, to the cores from `low` to `high` on the vessels' courses; farther off than `far` does not matter."""
    least, share = _gaps(x[:, :-1], y[:, :-1], x[:, 1:], y[:, 1:], low, high, far)
    first, _ = gap(x[:, :1], y[:, :1], x[:, :1], y[:, :1], low, high)
    when = ways.t[:-1] + share * (ways.t[1:] - ways.t[:-1])
    return Legs(first, least, when, near.column("C") + ops.minimum(near.column("grow") * when, near.column("most")))


def _gaps(
    x0: FloatArray, y0: FloatArray, x1: FloatArray, y1: FloatArray, low: FloatArray, high: FloatArray, far: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """As `gap`, but (FAR, 0) where a whole leg is farther than `far` beyond one end or one side of the segment.

    Most legs are, and the others cost most of a decision.
    """
    import numpy as np

    out = (np.minimum(y0, y1) > far) | (np.maximum(y0, y1) < -far)
    out |= (np.minimum(x0, x1) > high + far) | (np.maximum(x0, x1) < low - far)
    rows = np.nonzero(~out)
    least, share = np.full(out.shape, FAR), np.zeros(out.shape)
    ends = low[rows[0], 0, 0, 0], high[rows[0], 0, 0, 0]
    least[rows], share[rows] = gap(x0[rows], y0[rows], x1[rows], y1[rows], *ends)
    return least, share


def _violated(
    ways: Ways, near: Vessels, legs: Legs, radius: FloatArray, params: ForeignParams
) -> tuple[FloatArray, IntArray]:
    """(v, leg): how much 1.1 `radius` is violated, sooner counting more, worst over the boats; and on which leg.

        v = max(0, 1 - d / (1.1 radius)) (1 - 0.5 min(1, t / H))

    Where a boat is inside already, only what comes after 4 s counts: that rewards opening.
    """
    import numpy as np

    share = legs.least / (params.acting_factor * radius)
    inside = legs.first < params.acting_factor * radius[:, :1]
    share = np.where((ways.t[1:] <= params.opening_s) & inside, FAR, share)
    k: IntArray = share.argmin(axis=1)
    fade = 1.0 - 0.5 * np.minimum(_at(legs.when, k) / near.column("H")[:, 0], 1.0)
    v = np.maximum(1.0 - _at(share, k), 0.0) * fade
    return v.max(axis=1), k


def _at(values: FloatArray, k: IntArray) -> FloatArray:
    """The values of legs k."""
    import numpy as np

    chosen: FloatArray = np.take_along_axis(values, k[:, None], axis=1)[:, 0]
    return chosen


def _mates(ways: Ways, mates: Sequence[Mate], params: ForeignParams) -> tuple[FloatArray, FloatArray]:
    """(v, v_hull), (mate, candidate), of boats that decide for themselves: discs with their present velocity."""
    import numpy as np

    x, y, vx, vy = (np.array([getattr(m, n) for m in mates])[:, None, None, None] for n in ("x", "y", "vx", "vy"))
    px, py = ways.x - (x + ways.t * vx), ways.y - (y + ways.t * vy)
    least, _ = gap(px[:, :-1], py[:, :-1], px[:, 1:], py[:, 1:], 0.0, 0.0)
    inside = px[:, :1] * px[:, :1] + py[:, :1] * py[:, :1] < params.mate_m * params.mate_m
    early, late = ways.t[1:] <= params.opening_s, ways.t[:-1] >= params.mate_s
    d = np.where((early & inside) | late, FAR, least).min(axis=(1, 2))
    return np.maximum(1.0 - d / params.mate_m, 0.0), np.maximum(1.0 - d / (params.mate_hull * params.mate_m), 0.0)
