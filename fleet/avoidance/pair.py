"""What a boat remembers about each other vehicle, and how it changes at a decision.

Side, stand-on, companion and escort follow from what both boats know; nothing is negotiated. Flags are numbers, 0 or 1.
"""

from __future__ import annotations

from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.avoidance.params import ScoringParams
from fleet.avoidance.types import Own, Peer
from fleet.ops import R

_SIN_HEAD_ON, _COS_HEAD_ON = ops.sincos(0.4)  # relative bearings below 0.4 rad on both sides: head-on
_COS_ALIKE = ops.sincos(ops.PI / 12.0)[1]
_SIN_ABAFT, _COS_ABAFT = ops.sincos(1.96)  # more than 22.5 deg abaft the beam: overtaking


class Pair(Struct, Generic[R], frozen=True, gc=False):
    """Memory of one boat about one other vehicle."""

    side: R  # +1 leaves it to port, -1 to starboard, 0 open
    stand_on: R  # 1 it has to give way, we keep a slightly smaller radius
    conflict: R  # 1 the two motions lead into the wanted radius
    companion: R  # 1 both plans are the same: a neighbour in the formation
    escort: R  # how long both have held each other off their paths [s]


class View(Struct, Generic[R], frozen=True, gc=False):
    """Where another vehicle is and how it moves, and what is kept from it."""

    dx: R  # from own to the peer, north [m]
    dy: R
    d_sq: R  # range squared [m2]
    d: R
    speed: R  # its speed over ground [m/s]
    horizon: R  # how far ahead to look if it is no companion [s]
    margin: R  # for the uncertain relative position, of R_c and the hard radius [m]
    sigma: R  # of the relative position [m]
    wanted: R  # radius R_s with its own margin and widening [m]


class Judged(Struct, Generic[R], frozen=True, gc=False):
    """A pair after a decision's look at it."""

    pair: Pair[R]
    horizon: R  # H_j [s]
    radius: R  # R_j [m]
    yield_companion: R  # 1 it is time to yield to this companion
    yield_other: R  # 1 it is time to yield to this vehicle


def fresh_pair(like: R) -> Pair[R]:
    """A pair that has not met."""
    none = ops.zero(like)
    return Pair(none, none, none, none, none)


def masked(pair: Pair[R], present: R) -> Pair[R]:
    """The pair where the peer is present (1), a fresh one where it is not (0)."""
    here = present == 1.0
    return Pair(
        ops.where(here, pair.side, 0.0),
        ops.where(here, pair.stand_on, 0.0),
        ops.where(here, pair.conflict, 0.0),
        ops.where(here, pair.companion, 0.0),
        ops.where(here, pair.escort, 0.0),
    )


def view(own: Own[R], peer: Peer[R], params: ScoringParams) -> View[R]:
    """How own sees the peer now.

    H = max(30, min(150, own straight, peer's straight)) s; a vehicle without a plan counts as straight for 60 s.
    """
    dx, dy = peer.x - own.x, peer.y - own.y
    d_sq = dx * dx + dy * dy
    its_straight = ops.where(peer.known == 1.0, peer.straight, params.horizon_unknown_s)
    straight = ops.minimum(ops.minimum(its_straight, own.straight), params.horizon_max_s)
    sigma = ops.hypot(own.sigma, peer.sigma)
    return View(
        dx,
        dy,
        d_sq,
        ops.sqrt(d_sq),
        ops.hypot(peer.vx, peer.vy),
        ops.maximum(straight, params.horizon_min_s),
        params.sigmas * sigma,
        sigma,
        params.wanted_m + params.wanted_sigmas * sigma + peer.widen,
    )


def quiet(pair: Pair[R]) -> R:
    """1 where nothing is remembered: a peer out of reach then changes nothing."""
    total = abs(pair.side) + pair.stand_on + pair.conflict + pair.companion + pair.escort
    return ops.flag(total == 0.0, pair.side)


def judge(
    own: Own[R], cos_chi: R, sin_chi: R, speed: R, peer: Peer[R], seen: View[R], pair: Pair[R], params: ScoringParams
) -> Judged[R]:
    """The pair after this decision, and what it asks for.

        miss = p x w / |w|      > 0: the peer is left to port; w = own velocity - peer's
        t_c  = max(0, p . w / |w|^2)
        conflict = d < R_s, or closing and t_c < H and |miss| < R_s

    On conflict an open side becomes +1 (the common sense of turning: each leaves the other to port); -1 only where the
    peer is already more than R_s/2 on the other side and it is late or the peer is unknown. The side is kept until the
    peer opens beyond R_s. Companions have no side. Yielding to another vehicle starts its escort timer anew: both are
    slow then and would count as escorting still (of 62 meetings of 16 boats one came to 4.96 m, 6.22 m with it).

    Args:
        cos_chi, sin_chi: unit vector of the own course
        speed: own speed over ground [m/s]
        pair: as left by the last decision
    """
    wx, wy = own.vx - peer.vx, own.vy - peer.vy
    w_sq = wx * wx + wy * wy + 1e-9
    w = ops.sqrt(w_sq)
    miss = (seen.dx * wy - seen.dy * wx) / w
    nearing = seen.dx * wx + seen.dy * wy
    closing = nearing > 0.0
    t_c = ops.maximum(nearing / w_sq, 0.0)

    companion = _companion(own, peer, seen, pair, params)
    together = companion == 1.0
    horizon = ops.where(together, params.horizon_min_s, seen.horizon)
    inside = seen.d < seen.wanted
    conflict = ops.flag(inside | (closing & (t_c < horizon) & (abs(miss) < seen.wanted)), miss)

    to_port = (miss < -0.5 * seen.wanted) & ((t_c < params.late_s) | (peer.known == 0.0))
    chosen = ops.where((conflict == 1.0) & (pair.side == 0.0), ops.where(to_port, -1.0, 1.0), pair.side)
    past = (nearing <= 0.0) & (seen.d > seen.wanted)
    side = ops.where(past | together, 0.0, chosen)

    begins = (conflict == 1.0) & (pair.conflict == 0.0) & (peer.known == 1.0)
    stand_on = pair.stand_on
    if ops.some(begins):
        stand_on = ops.where(begins, _stands_on(cos_chi, sin_chi, speed, peer, seen), stand_on)
    stand_on = ops.where((conflict == 0.0) & (side == 0.0), 0.0, stand_on)

    radius = ops.where(stand_on == 1.0, params.stand_on_share * seen.wanted, seen.wanted)
    radius = ops.where(together, params.companion_m + seen.margin + peer.widen, radius)
    if ops.some(peer.together == 1.0):
        one = peer.together == 1.0
        horizon = ops.where(one, params.together_s, horizon)
        radius = ops.where(one, params.hard_m + seen.margin + peer.widen, radius)
    escort = _escort(own, cos_chi, sin_chi, w, seen, pair, params)
    too_long = ops.flag(escort > ops.where(together, params.escort_companion_s, params.escort_other_s), miss)
    if ops.some(too_long == 1.0):
        too_long = too_long * _yields(cos_chi, sin_chi, peer, seen, params)
        escort = ops.where((too_long == 1.0) & ops.no(together), 0.0, escort)
    return Judged(
        Pair(side, stand_on, conflict, companion, escort),
        horizon,
        radius,
        too_long * companion,
        too_long * (1.0 - companion),
    )


def _companion(own: Own[R], peer: Peer[R], seen: View[R], pair: Pair[R], params: ScoringParams) -> R:
    """1 where both plans agree in velocity along the paths, and the boats are near; left later than entered.

    So are boats of one formation that are already ahead or astern of each other as their slots are: the formation's law
    keeps them apart, and that one closes up faster than the other sails is no encounter, until it is 30 s away.
    And so are boats that turn together, for one decision about a foreign vessel: their velocities differ while they
    turn, which says nothing of where they will be.
    """
    ex = own.u_d * own.tx - peer.u_d * peer.tx
    ey = own.u_d * own.ty - peer.u_d * peer.ty
    fastest = ops.maximum(ops.maximum(own.u_d, peer.u_d), params.least_cruise_mps)
    was = pair.companion == 1.0
    most = fastest * ops.where(was, params.companion_leave_share, params.companion_share)
    reach = ops.where(was, params.companion_leave_range_m, params.companion_range_m)
    alike = (ex * ex + ey * ey <= most * most) & (seen.d <= reach)
    return ops.flag((peer.known == 1.0) & (alike | (peer.ordered == 1.0) | (peer.together == 1.0)), ex)


def bound_alike(own: Own[R], peer: Peer[R], seen: View[R], params: ScoringParams) -> R:
    """1 for a boat near whose path runs within 15 degrees as ours does, at whatever speed."""
    along = own.tx * peer.tx + own.ty * peer.ty
    return ops.flag((along > _COS_ALIKE) & (seen.d <= params.companion_range_m) & (peer.known == 1.0), along)


def _stands_on(cos_chi: R, sin_chi: R, speed: R, peer: Peer[R], seen: View[R]) -> R:
    """1 where the other has to give way: not head-on, not overtaking it, and overtaken by it or it lies to port.

    Bearings are compared by cosines times range times speed; its course is the direction of its velocity.
    """
    ahead = cos_chi * seen.dx + sin_chi * seen.dy  # d cos(its bearing off the own course)
    abeam = cos_chi * seen.dy - sin_chi * seen.dx  # > 0: it lies to starboard
    ahead_of_it = -(peer.vx * seen.dx + peer.vy * seen.dy)  # d u_j cos(own bearing off its course)
    reach = seen.d * seen.speed
    head_on = (ahead > _COS_HEAD_ON * seen.d) & (ahead_of_it > _COS_HEAD_ON * reach)
    overtaking = (ahead_of_it < _COS_ABAFT * reach) & (speed > seen.speed)
    overtaken = (ahead < _COS_ABAFT * seen.d) & (seen.speed > speed)
    gives_way = head_on | overtaking
    return ops.flag(ops.no(gives_way) & (overtaken | (abeam < 0.0)), ahead)


def _escort(own: Own[R], cos_chi: R, sin_chi: R, w: R, seen: View[R], pair: Pair[R], params: ScoringParams) -> R:
    """The escort timer [s]: up while two boats hold each other off their paths side by side, down four times as fast.

    w: relative speed [m/s].
    """
    beside = (w < params.escort_speed_mps) & (seen.d < 2.0 * seen.wanted)
    if not ops.some(beside | (pair.escort > 0.0)):
        return pair.escort
    cos_ahead = ops.sincos(params.escort_ahead_rad)[1]
    cos_astern = ops.sincos(params.escort_astern_rad)[1]
    cos_held = ops.sincos(params.held_off_rad)[1]
    ahead = cos_chi * seen.dx + sin_chi * seen.dy
    abreast = (ahead < cos_ahead * seen.d) & (ahead > cos_astern * seen.d)
    held_off = cos_chi * own.gx + sin_chi * own.gy < cos_held
    step = ops.where(beside & abreast & held_off, params.period_s, -4.0 * params.period_s)
    return ops.maximum(pair.escort + step, 0.0)


def _yields(cos_chi: R, sin_chi: R, peer: Peer[R], seen: View[R], params: ScoringParams) -> R:
    """1 for the one of two escorting boats that yields: the peer lies to starboard, or is itself not held off."""
    cos_held = ops.sincos(params.held_off_rad)[1]
    starboard = cos_chi * seen.dy - sin_chi * seen.dx > 0.0
    its_way = peer.gx * peer.vx + peer.gy * peer.vy >= cos_held * seen.speed
    return ops.flag(starboard | its_way, seen.d)
