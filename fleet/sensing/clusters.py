"""From a scan to things on the water: returns that belong together, where they are, and how long.

A thing seen from outside shows its near side only. Its middle is taken to lie halfway between the first and the last
return, its length to be the longer side of the box about all returns.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

from msgspec import Meta, Struct

from fleet.sensing.scan import TURN, Scan

if TYPE_CHECKING:
    import numpy as np

    Numbers = np.ndarray[Any, np.dtype[np.float64]]

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
SIGMA_M = 0.1  # of a range; and of a middle, at least
SIGMA_CUT = 0.5  # so, of a thing that the edge of the scan cuts off
SIGMA_A_LENGTH = 0.1  # of the length: one side of a hull is seen, and its middle lies behind it
NEAR_M, FASTEST_MPS = 1.0, 5.0  # of what an earlier scan shows: how near, and how fast a thing may have gone
WIDEST_GAP_RAD = math.radians(5.0)  # a gap beyond counts as so wide


class ClusterParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How returns are put together."""

    join_m: Positive = 1.0  # returns one after the other, so near to each other, are of one thing
    gap_max_m: Positive = 3.0  # and never farther apart than that
    grazing_deg: Annotated[float, Meta(ge=5.0, le=45.0)] = 10.0  # a side seen at a flatter angle falls into pieces
    returns_min: Annotated[int, Meta(ge=1, le=1000)] = 3  # fewer are spray
    length_max_m: Positive = 60.0  # what is longer is a bank or a quay, and no vessel
    range_max_m: Positive = 200.0  # farther returns count for nothing
    hull_length_m: NotNegative = 2.4  # of the own boat: returns within are its own
    hull_beam_m: NotNegative = 1.2
    hull_margin_m: NotNegative = 0.3
    most: Annotated[int, Meta(ge=1, le=256)] = 64  # things that are kept: the nearest


class Motion(Struct, frozen=True, gc=False):
    """How the boat moves while it scans."""

    u: float = 0.0  # over ground, ahead [m/s]
    v: float = 0.0  # over ground, to starboard [m/s]
    r: float = 0.0  # yaw rate, + to starboard [rad/s]


class Cluster(Struct, frozen=True, gc=False):
    """Something on the water."""

    t: float  # when it was seen, after the scan's stamp [s]
    ahead: float  # its middle, from the boat's centre at that time [m]
    starboard: float
    length: float  # of what is seen of it [m]
    sigma: float  # 1-sigma error of the middle per axis [m]
    range: float  # of its nearest return, from the scanner [m]
    returns: int


class Found(Struct, frozen=True, gc=False):
    """What became of a scan's returns; each return is counted once."""

    clusters: tuple[Cluster, ...] = ()  # nearest first
    returns: int = 0
    own: int = 0  # from the own hull
    few: int = 0  # returns of things with too few of them
    long: int = 0  # returns of things too long for a vessel
    dropped: int = 0  # returns of things beyond `most`
    banks: int = 0  # things too long for a vessel


STILL = Motion()


def clusters(scan: Scan, motion: Motion = STILL, params: ClusterParams | None = None) -> Found:
    """Things that a scan shows, in the boat's frame.

    Two returns one after the other, a distance d apart, at range rho and an angle of delta, are of one thing when

        d <= clip(rho sin(delta) / sin(lambda - delta), join_m, gap_max_m) + 3 sigma

    The fraction is their distance on a straight side that is seen under the grazing angle lambda.

    Args:
        scan: one turn, sound (see `fleet.sensing.scan.problem`)
        motion: of the boat during that turn; every beam is put where it was measured
        params: tuning
    """
    import numpy as np

    p = params or ClusterParams()
    beams, rho, bearing, x, y = _returns(scan, p)
    returns = len(beams)
    if returns == 0:
        return Found()
    own = (abs(x) <= 0.5 * p.hull_length_m + p.hull_margin_m) & (abs(y) <= 0.5 * p.hull_beam_m + p.hull_margin_m)
    if own.any():
        away = ~own
        beams, rho, bearing, x, y = beams[away], rho[away], bearing[away], x[away], y[away]
    if len(beams) == 0:
        return Found(returns=returns, own=returns)
    t: Numbers = scan.beam_s * beams.astype(np.float64)
    x, y = _at_the_stamp(x, y, t, motion)
    starts = _starts(x, y, rho, bearing, p)
    around = abs(scan.increment_rad) * (scan.beams + 1) >= TURN
    edge = ((beams <= 1) | (beams >= scan.beams - 2)) & (not around)
    points: Numbers = np.stack((x, y, t, rho, edge.astype(np.float64)))
    if around and len(starts) > 1 and _closes(scan, beams, points, p):
        first = int(starts[-1])
        points = np.roll(points, -first, axis=1)
        starts = np.concatenate(([0], starts[1:-1] + len(x) - first))
    return _told(points, starts, motion, p, returns)


def seen_before(
    found: Sequence[Cluster],
    scan: Scan,
    earlier: Sequence[Scan],
    motion: Motion = STILL,
    params: ClusterParams | None = None,
) -> list[bool]:
    """Whether a scan shortly before shows anything where each thing is: a thing that is there is in more than one scan.

    One return is enough, in any of them, as near to the thing as its own hull reaches and both may have gone
    meanwhile, give and take a metre. All are true where there is no scan before.

    Args:
        found: things of the scan
        scan: the newest
        earlier: of the same scanner
        motion: of the boat, in all that time
        params: tuning
    """
    import numpy as np

    p, told = params or ClusterParams(), [not earlier] * len(found)
    for before in earlier if found else ():
        beams, _, _, x, y = _returns(before, p)
        ago = (before.stamp_ns - scan.stamp_ns) * 1e-9
        x, y = _at_the_stamp(x, y, ago + before.beam_s * beams.astype(np.float64), motion)
        for k, one in enumerate(found):
            if not told[k]:
                there = _at_the_stamp(np.asarray(one.ahead), np.asarray(one.starboard), np.asarray(one.t), motion)
                reach = NEAR_M + 0.5 * one.length + FASTEST_MPS * (one.t - ago)
                told[k] = bool((np.hypot(x - there[0], y - there[1]) <= reach).any())
    return told


def _returns(scan: Scan, p: ClusterParams) -> tuple[Any, Numbers, Numbers, Numbers, Numbers]:
    """Beams with a return, its range [m], bearing [rad] and place from the boat's centre [m], where it was measured."""
    import numpy as np

    rho = np.frombuffer(scan.ranges, dtype="<f4").astype(np.float64)
    with np.errstate(invalid="ignore"):
        beams = np.flatnonzero((rho > 0.0) & (rho <= min(scan.range_max_m, p.range_max_m)))
    rho = rho[beams]
    bearing: Numbers = scan.yaw_rad + scan.first_rad + scan.increment_rad * beams.astype(np.float64)
    return beams, rho, bearing, scan.ahead_m + rho * np.cos(bearing), scan.starboard_m + rho * np.sin(bearing)


def _at_the_stamp(x: Numbers, y: Numbers, t: Numbers, m: Motion) -> tuple[Numbers, Numbers]:
    """Points of the boat's frame at t [s], in its frame at 0: it has turned by r t, and gone on the mean heading."""
    import numpy as np

    turned = m.r * t
    s, c = np.sin(turned), np.cos(turned)
    s_half, c_half = np.sin(0.5 * turned), np.cos(0.5 * turned)
    ahead, starboard = m.u * t, m.v * t
    return (
        x * c - y * s + ahead * c_half - starboard * s_half,
        x * s + y * c + ahead * s_half + starboard * c_half,
    )


def _from_the_stamp(x: float, y: float, t: float, m: Motion) -> tuple[float, float]:
    """The other way round: a point of the frame at 0, in the frame at t."""
    turned = m.r * t
    s, c = math.sin(turned), math.cos(turned)
    s_half, c_half = math.sin(0.5 * turned), math.cos(0.5 * turned)
    dx = x - (m.u * t * c_half - m.v * t * s_half)
    dy = y - (m.u * t * s_half + m.v * t * c_half)
    return dx * c + dy * s, dy * c - dx * s


def _apart(distance: Numbers, nearer: Numbers, delta: Numbers, p: ClusterParams) -> Any:
    """Whether neighbours are of two things."""
    import numpy as np

    delta = np.minimum(delta, min(WIDEST_GAP_RAD, 0.5 * math.radians(p.grazing_deg)))
    most = nearer * np.sin(delta) / np.sin(math.radians(p.grazing_deg) - delta)
    return distance > np.clip(most, p.join_m, max(p.join_m, p.gap_max_m)) + 3.0 * SIGMA_M


def _starts(x: Numbers, y: Numbers, rho: Numbers, bearing: Numbers, p: ClusterParams) -> Any:
    """Indices at which a thing begins."""
    import numpy as np

    distance = np.hypot(np.diff(x), np.diff(y))
    apart = _apart(distance, np.minimum(rho[1:], rho[:-1]), abs(np.diff(bearing)), p)
    return np.concatenate(([0], np.flatnonzero(apart) + 1))


def _closes(scan: Scan, beams: Any, points: Numbers, p: ClusterParams) -> bool:
    """Whether the last thing of a scan that goes all round is its first."""
    import numpy as np

    x, y, _, rho, _ = points
    delta = TURN - abs(scan.increment_rad) * float(beams[-1] - beams[0])
    distance = np.hypot(x[0] - x[-1], y[0] - y[-1])
    return not bool(_apart(distance, np.minimum(rho[0], rho[-1]), np.asarray(abs(delta)), p))


def _told(points: Numbers, starts: Any, m: Motion, p: ClusterParams, returns: int) -> Found:
    """Things with their places, nearest first.

    Args:
        points: by row x, y [m], t [s], rho [m], and 1 for returns at the edge of the scan; a column each
        starts: columns at which a thing begins
        m: motion of the boat
        p: tuning
        returns: of the whole scan
    """
    import numpy as np

    ends = np.concatenate((starts[1:], [points.shape[1]]))
    counts = ends - starts
    enough = counts >= p.returns_min
    few = int(counts[~enough].sum())
    if len(starts) > 2 * p.most and int(enough.sum()) > 2 * p.most:  # in rain: the nearest are looked at
        near = np.where(enough, np.minimum.reduceat(points[3], starts), np.inf)
        looked = np.argsort(near, kind="stable")[: 2 * p.most]
    else:
        looked = np.flatnonzero(enough)
    dropped = int(counts[enough].sum() - counts[looked].sum())
    things = [_thing(points[:, start:end], m) for start, end in zip(starts[looked], ends[looked], strict=True)]
    banks = [one for one in things if one.length > p.length_max_m]
    found = sorted((one for one in things if one.length <= p.length_max_m), key=lambda one: one.range)
    dropped += sum(one.returns for one in found[p.most :])
    long = sum(one.returns for one in banks)
    return Found(tuple(found[: p.most]), returns, returns - points.shape[1], few, long, dropped, len(banks))


def _thing(points: Numbers, m: Motion) -> Cluster:
    """One thing; cut off at the edge of the scan, its middle may be elsewhere."""
    x, y, t, rho, edge = points
    x0, y0, x1, y1 = float(x[0]), float(y[0]), float(x[-1]), float(y[-1])
    chord = math.hypot(x1 - x0, y1 - y0)
    ex, ey = ((x1 - x0) / chord, (y1 - y0) / chord) if chord > 0.0 else (1.0, 0.0)
    along, across = x * ex + y * ey, y * ex - x * ey
    length = max(float(along.max() - along.min()), float(across.max() - across.min()))
    seen = float(t.mean())
    ahead, starboard = _from_the_stamp(0.5 * (x0 + x1), 0.5 * (y0 + y1), seen, m)
    sigma = math.hypot(SIGMA_M, (SIGMA_CUT if edge.any() else SIGMA_A_LENGTH) * length)
    return Cluster(seen, ahead, starboard, length, sigma, float(rho.min()), len(x))
