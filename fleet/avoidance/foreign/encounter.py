"""One vessel that meets us: its class, who keeps clear, on which side, when to act, and when it is over."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.foreign.domain import Domain
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.types import NEVER_S, Boat, Encounter, Kind, Reason, Role

ABAFT = 0.3826834323650898  # sin 22.5 deg: two points abaft the beam
AHEAD = 0.9238795325112867  # cos 22.5 deg
OPPOSITE = 0.9659258262890683  # cos 15 deg
OPPOSITE_RAD = 0.2617993877991494
NEARLY_RAD = 0.7853981633974483  # 45 deg from opposite: it comes towards us
CONFIRM_DOWN_S = 1.0  # a look that sees no need takes this from the count
ALIKE_MPS = 1.0e-9

_GIVE_WAY = (float(Kind.STATIC), float(Kind.OVERTAKING), float(Kind.HEAD_ON), float(Kind.CROSSING_GIVE_WAY))
_EITHER_SIDE = (float(Kind.STATIC), float(Kind.OVERTAKING))  # no rule asks for one
BY_STARBOARD = (float(Kind.HEAD_ON), float(Kind.CROSSING_GIVE_WAY))
"""Rules 14 and 15: the way that turns to port is closed."""


class Bearing(Struct, frozen=True, gc=False):
    """The plan of the boat that decides: where it is and the velocity it intends."""

    x: float
    y: float
    ex: float  # unit vector of the path's course
    ey: float
    cruise: float  # [m/s]
    vx: float  # true velocity over ground [m/s]
    vy: float


def bearing(boat: Boat) -> Bearing:
    """Of one boat."""
    point = boat.path.at(boat.s)
    s, c = ops.sincos(boat.chi)
    return Bearing(boat.x, boat.y, point.tx, point.ty, boat.cruise, boat.U * c, boat.U * s)


def role(kind: float) -> Role:
    """Who keeps clear."""
    if kind == Kind.NONE:
        return Role.NONE
    return Role.GIVE_WAY if kind in _GIVE_WAY else Role.STAND_ON


def classify(own: Bearing, d: Domain, params: ForeignParams) -> tuple[float, float]:
    """(Kind, wanted side) of a vessel for a boat that sails its path at cruise speed.

    Angles from the bow of each to the other, and between the courses; the first rule that fits.

    Source: COLREGS rules 13 (two points abaft the beam), 14, 15.
    """
    px, py = d.x - own.x, d.y - own.y
    per = 1.0 / ops.maximum(ops.hypot(px, py), ALIKE_MPS)
    g = d.guesses[0]
    fo = (px * own.ex + py * own.ey) * per
    ft = -(px * g.ex + py * g.ey) * per
    ee = own.ex * g.ex + own.ey * g.ey
    miss = _miss(own, d)
    passing = 1.0 if miss > -params.overtaking_miss_m else -1.0
    if d.slow > 0.5:
        likely = _crosses_from_starboard(fo, ft, ee, own, d, px, py) and params.slow_mps < d.U
        return float(Kind.STATIC), 1.0 if likely else passing
    if ft < -ABAFT and own.cruise > d.U * max(ee, 0.0):
        return float(Kind.OVERTAKING), passing
    if fo < -ABAFT and own.cruise < d.U:
        return float(Kind.OVERTAKEN), -1.0 if miss < 0.0 else 1.0
    if ee < -OPPOSITE and fo > AHEAD and ft > AHEAD:
        return float(Kind.HEAD_ON), 1.0
    if own.ex * py - own.ey * px >= 0.0:
        return float(Kind.CROSSING_GIVE_WAY), 1.0
    return float(Kind.CROSSING_STAND_ON), 0.0


def _miss(own: Bearing, d: Domain) -> float:
    """How far off it is passed on the path's course from here, > 0 where it is left to port [m]."""
    g = d.guesses[0]
    px, py = d.x - own.x, d.y - own.y
    wx, wy = own.cruise * own.ex - g.vx, own.cruise * own.ey - g.vy
    return (px * wy - py * wx) / ops.maximum(ops.hypot(wx, wy), ALIKE_MPS)


def believed(own: Bearing, d: Domain, params: ForeignParams) -> tuple[float, float]:
    """(Kind, wanted side) of a vessel as it is known: one that may be head-on, or to starboard, is not stood on for.

    Ahead, coming towards us, and within two standard deviations an opposite course or on the starboard bow: rule 14 c,
    in any doubt it is head-on.
    """
    kind, side = classify(own, d, params)
    if kind != Kind.CROSSING_STAND_ON:
        return kind, side
    g = d.guesses[0]
    px, py = d.x - own.x, d.y - own.y
    ahead, abeam = px * own.ex + py * own.ey, own.ex * py - own.ey * px
    off = ops.PI - abs(ops.atan2(own.ex * g.ey - own.ey * g.ex, own.ex * g.ex + own.ey * g.ey))
    opposite = off < OPPOSITE_RAD + min(2.0 * d.sigma_v / ops.maximum(d.U, ALIKE_MPS), params.doubt_rad)
    nearly = off < NEARLY_RAD and abeam > -2.0 * d.sigma_p
    if ahead > AHEAD * ops.hypot(px, py) and (opposite or nearly):
        return float(Kind.HEAD_ON), 1.0
    return kind, side


def _crosses_from_starboard(fo: float, ft: float, ee: float, own: Bearing, d: Domain, px: float, py: float) -> bool:
    """Head-on or from starboard, by a course that may be wrong: a slow vessel is passed on the side that fits both."""
    astern = (ft < -ABAFT and own.cruise > d.U * max(ee, 0.0)) or (fo < -ABAFT and own.cruise < d.U)
    ahead = ee < -OPPOSITE and fo > AHEAD and ft > AHEAD
    return not astern and (ahead or own.ex * py - own.ey * px >= 0.0)


def look(
    before: Encounter | None,
    own: Bearing,
    d: Domain,
    entry: float,
    params: ForeignParams,
    acts: bool = False,
    crowd: bool = False,
) -> Encounter | None:
    """The encounter after one more look, `params.period_s` after the last one; None while there is none.

    Args:
        before: as it was, None for a vessel without risk so far
        entry: earliest entry into its domain on the paths, NEVER_S none [s]
        acts: the boat has left its path, perhaps for another vessel: from there no class is made anew for doubt
        crowd: it meets several at once: T_so clears one and rule 17 is for two vessels, so it acts as if it gave way
    """
    risk = entry < NEVER_S
    if before is None:
        if not risk:
            return None
        kind, side = believed(own, d, params)
        g = d.guesses[0]
        before = Encounter(d.number, kind, side, g.ex, g.ey, 0.0, 0.0, 0.0, 0.0, entry)
    elif _turned(before, d, params) or (_provisional(before, d, params) and not acts):
        kind, side = believed(own, d, params)
        g = d.guesses[0]
        before = structs.replace(before, kind=kind, side=0.0 if before.acting > 0.5 else side, ex=g.ex, ey=g.ey)
    if before.kind in _EITHER_SIDE and before.side * _miss(own, d) < -d.C:
        before = structs.replace(before, side=-before.side)
    dt, g = params.period_s, d.guesses[0]
    px, py = d.x - own.x, d.y - own.y
    opening = px * (own.vx - g.vx) + py * (own.vy - g.vy) < 0.0
    clear = before.clear + dt if opening and not risk else 0.0
    calm = 0.0 if risk else before.calm + dt
    if clear >= params.clear_s or (before.acting < 0.5 and calm >= params.calm_s):
        return None
    near = ops.hypot(px, py) < params.near_m
    early = entry < d.T_gw
    due = early or (risk and near) if role(before.kind) == Role.GIVE_WAY else entry < d.T_so or (crowd and early)
    count = min(before.count + dt, params.confirm_s) if due else max(before.count - CONFIRM_DOWN_S, 0.0)
    if due and entry < params.urgent_s:
        count = params.confirm_s
    return structs.replace(before, count=count, clear=clear, calm=calm, entry=entry)


def _turned(before: Encounter, d: Domain, params: ForeignParams) -> bool:
    """Its course is another one than that at which it was classified, or it has got under way or stopped."""
    if d.slow > 0.5:
        return False
    if before.kind == Kind.STATIC:
        return d.vague < 0.5
    g = d.guesses[0]
    off = abs(ops.atan2(before.ex * g.ey - before.ey * g.ex, before.ex * g.ex + before.ey * g.ey))
    return off > params.turned_rad + 2.0 * d.sigma_v / d.U


def _provisional(before: Encounter, d: Domain, params: ForeignParams) -> bool:
    """Its course is not known well enough for the class to be the last word, and nothing has been done yet."""
    return before.acting < 0.5 and d.slow < 0.5 and d.sigma_v > params.unsure_rad * d.U


def due(encounter: Encounter, params: ForeignParams) -> bool:
    """To act for it is due, and confirmed."""
    return encounter.count >= params.confirm_s


def reason(encounter: Encounter) -> Reason:
    """Why we act for it."""
    return Reason.GIVE_WAY if role(encounter.kind) == Role.GIVE_WAY else Reason.STAND_ON


def watched(encounters: Sequence[Encounter]) -> tuple[float, ...]:
    """Numbers of those whose risk keeps the boat off its path: acted for, or ours to keep clear of."""
    return tuple(e.number for e in encounters if e.acting > 0.5 or role(e.kind) == Role.GIVE_WAY)


def earliest(encounters: Sequence[Encounter]) -> Encounter | None:
    """The one that is entered first, the lowest number of equals; None without risk."""
    best = None
    for e in encounters:
        if e.entry < NEVER_S and (best is None or e.entry < best.entry):
            best = e
    return best
