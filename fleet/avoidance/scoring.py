"""Velocity scoring: how boats of a fleet keep clear of each other by default.

Twice a second a boat looks at every other vehicle (`pair`), takes its plan if that is free, else the least dear of 205
velocities about it (`search`, `cost`), and holds the decision until the next one. Each tick ends with the `brake`.
Nothing is negotiated: what both know makes both choose sides alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.brake import brake
from fleet.avoidance.cost import Meeting, Threat, legs, meet_on_legs, returned, swept, threat, total, widened
from fleet.avoidance.pair import Pair, bound_alike, fresh_pair, judge, masked, quiet, view
from fleet.avoidance.params import ScoringParams, beside
from fleet.avoidance.search import Choice, Stance, search, speed_of
from fleet.avoidance.types import Advice, Own, Peer
from fleet.guidance.limits import Limits
from fleet.ops import R


class ScoringMemory(Struct, Generic[R], frozen=True, gc=False):
    """What velocity scoring remembers between ticks."""

    cx: R  # unit vector of the course decided last
    cy: R
    factor: R  # of the wanted speed, decided last
    avoiding: R  # 1 the last decision left the plan
    steers: R  # 1 its course is off the wanted one
    yield_companion: R  # how long still to yield to a companion [s]
    yield_other: R  # how long still to yield to another vehicle [s]
    countdown: R  # to the next decision, at the last tick [s]
    target: R  # number of the vehicle that decided, -1 for none
    side: R  # +1 it is left to port, -1 to starboard, 0 neither
    pairs: tuple[Pair[R], ...]  # parallel to the peers


class Look(Struct, Generic[R], frozen=True, gc=False):
    """What all the peers together ask for at a decision."""

    threats: tuple[Threat[R], ...]  # those within reach
    returns: tuple[Threat[R], ...]  # the same, back on their paths; none while the plan is followed
    pairs: tuple[Pair[R], ...]  # parallel to the peers
    beside: R  # 1 a companion, or a boat near is bound the same way
    yield_companion: R  # 1 it is time to yield to a companion
    yield_other: R  # 1 it is time to yield to another vehicle
    target: R  # number of the vehicle to yield to, -1 for none


def start_memory(like: R, n_peers: int) -> ScoringMemory[R]:
    """Memory of a boat that has met nobody; `like` gives one boat (float) or the lanes (array)."""
    none = ops.zero(like)
    one = ops.full(like, 1.0)
    pairs = tuple(fresh_pair(like) for _ in range(n_peers))
    return ScoringMemory(one, none, one, none, none, none, none, none, ops.full(like, -1.0), none, pairs)


def align(memory: ScoringMemory[R], old_numbers: Sequence[float], new_numbers: Sequence[float]) -> ScoringMemory[R]:
    """The memory for another list of peers: pairs follow their vehicle's number, a new one starts fresh."""
    kept = dict(zip(old_numbers, memory.pairs, strict=True))
    pairs = tuple(kept[n] if n in kept else fresh_pair(memory.factor) for n in new_numbers)
    return structs.replace(memory, pairs=pairs)


def keep_clear(
    own: Own[R],
    peers: Sequence[Peer[R]],
    memory: ScoringMemory[R],
    limits: Limits,
    params: ScoringParams,
    dt: float,
) -> tuple[ScoringMemory[R], Advice[R]]:
    """What keeping clear of the peers asks of this tick.

    Args:
        peers: sorted by number, dead-reckoned to now
        memory: of the last tick, its pairs parallel to the peers
        limits: of the own boat
        dt: since the last tick [s]
    """
    if any(not ops.every(peer.present == 1.0) for peer in peers):
        pairs = tuple(masked(pair, peer.present) for pair, peer in zip(memory.pairs, peers, strict=True))
        memory = structs.replace(memory, pairs=pairs)

    def decided(own: Own[R], peers: tuple[Peer[R], ...], memory: ScoringMemory[R]) -> ScoringMemory[R]:
        return _decide(own, peers, memory, limits, params, dt)

    due = memory.countdown - dt <= 0.5 * dt
    held = structs.replace(memory, countdown=memory.countdown - dt)
    memory = ops.when(due, decided, held, own, tuple(peers), memory)
    return memory, _advice(own, peers, memory, limits, params)


def _decide(
    own: Own[R],
    peers: tuple[Peer[R], ...],
    memory: ScoringMemory[R],
    limits: Limits,
    params: ScoringParams,
    dt: float,
) -> ScoringMemory[R]:
    """The memory after a decision.

    The plan is taken if it misses everybody by R_j on the right sides. To end an avoidance it must miss by 0.7 m more,
    and by R_j also those that return to their plans. A decision that comes within half a tick of its time leaves the
    phase as it is; one that comes later starts it anew.
    """
    u_min = limits.speed_min_mps
    cruise = speed_of(own.u_d, 1.0, u_min, params)
    look = _look(own, peers, memory, cruise, params)
    yield_companion = _run_down(memory.yield_companion, look.yield_companion, params)
    yield_other = _run_down(memory.yield_other, look.yield_other, params)

    price, target, side = _plan(own, cruise, look, memory.avoiding, params)
    yielding = ops.flag(yield_other > 0.0, price)
    waiting = ops.flag(yield_companion > 0.0, price)
    follow = Choice(own.gx, own.gy, ops.full(own.x, 1.0), ops.zero(own.x))
    turned = ops.atan2(memory.cx * own.gy - memory.cy * own.gx, memory.cx * own.gx + memory.cy * own.gy)

    def stance(own: Own[R], threats: tuple[Threat[R], ...], held: tuple[R, R, R, R]) -> Stance[R]:
        sin_chi, cos_chi = ops.sincos(own.chi)
        near = swept(ops.hypot(own.vx, own.vy), threats, limits.yaw_rate_max_radps, params)
        return Stance(*held, cos_chi, sin_chi, near)

    def searched(own: Own[R], threats: tuple[Threat[R], ...], held: tuple[R, R, R, R]) -> Choice[R]:
        return search(own, threats, stance(own, threats, held), u_min, params)

    def searched_beside(own: Own[R], threats: tuple[Threat[R], ...], held: tuple[R, R, R, R]) -> Choice[R]:
        return search(own, threats, stance(own, threats, held), u_min, beside(params))

    yields = (yielding == 1.0) | (waiting == 1.0)
    blocked = (price >= params.free) | yields
    given = (own, look.threats, (turned, memory.avoiding, yielding, waiting))
    choice = ops.when(blocked & (look.beside == 0.0), searched, follow, *given)
    choice = ops.when(blocked & (look.beside == 1.0), searched_beside, choice, *given)

    avoiding = ops.flag((choice.steers == 1.0) | (choice.factor < 1.0) | yields, price)
    waits_for = ops.where(look.target >= 0.0, look.target, memory.target)
    target = ops.where(target < 0.0, ops.where(yields, waits_for, -1.0), target)
    left = memory.countdown - dt
    return ScoringMemory(
        choice.cx,
        choice.cy,
        choice.factor,
        avoiding,
        choice.steers,
        yield_companion,
        yield_other,
        ops.where(left < -0.5 * dt, 0.0, left) + params.period_s,
        ops.where(avoiding == 1.0, target, -1.0),
        ops.where(avoiding == 1.0, side, 0.0),
        look.pairs,
    )


def _run_down(timer: R, asked: R, params: ScoringParams) -> R:
    """The yield timer after one decision period: full where asked for [s]."""
    return ops.where(asked == 1.0, params.yield_s, ops.maximum(timer - params.period_s, 0.0))


def _look(
    own: Own[R], peers: tuple[Peer[R], ...], memory: ScoringMemory[R], cruise: R, params: ScoringParams
) -> Look[R]:
    """Look at every peer; those that can neither be met within the horizon nor are remembered are left out exactly."""
    sin_chi, cos_chi = ops.sincos(own.chi)
    speed = ops.hypot(own.vx, own.vy)
    fastest = ops.maximum(speed, cruise)
    none = ops.zero(own.x)
    near, yield_companion, yield_other, target = none, none, none, ops.full(own.x, -1.0)
    threats, returns, pairs = [], [], []
    leaving = ops.some(memory.avoiding == 1.0)
    for peer, pair in zip(peers, memory.pairs, strict=True):
        seen = view(own, peer, params)
        its_fastest = ops.maximum(seen.speed, peer.u_d)
        reach = (fastest + its_fastest) * seen.horizon + seen.wanted + params.hysteresis_m + abs(peer.y_e)
        reach = ops.maximum(reach, ops.maximum(2.0 * seen.wanted, params.companion_leave_range_m)) + 1.0
        here = peer.present
        if ops.every(((seen.d > reach) & (quiet(pair) == 1.0)) | (here == 0.0)):
            pairs.append(pair)
            continue
        judged = judge(own, cos_chi, sin_chi, speed, peer, seen, pair, params)
        pairs.append(judged.pair if ops.every(here == 1.0) else masked(judged.pair, here))
        threats.append(threat(own, peer, seen, judged, params))
        alike = ops.maximum(judged.pair.companion, bound_alike(own, peer, seen, params))
        if leaving:
            returns.append(returned(threats[-1], peer, alike, params))
        near = ops.maximum(near, here * alike)
        yield_companion = ops.maximum(yield_companion, here * judged.yield_companion)
        yield_other = ops.maximum(yield_other, here * judged.yield_other)
        target = ops.where(here * (judged.yield_companion + judged.yield_other) > 0.0, peer.number, target)
    return Look(tuple(threats), tuple(returns), tuple(pairs), near, yield_companion, yield_other, target)


def _plan(own: Own[R], cruise: R, look: Look[R], avoiding: R, params: ScoringParams) -> tuple[R, R, R]:
    """Price of the plan, the number of the vehicle that makes most of it (-1 for none), and the side kept from that.

    A boat that has left its plan asks also what comes if the others end their avoidance as well. Two that look only at
    each other's velocity find their plans free because the other is off its own, return together, and begin again.
    """
    none = ops.zero(own.x)
    worst, crowd, hardest, wrong = none, none, none, none
    most, target, side = none, ops.full(own.x, -1.0), none
    way = legs(own, cruise)
    extra = avoiding * params.hysteresis_m
    grown = ops.some(extra > 0.0)  # by 0 m it would be the same threat
    met = [(each, meet_on_legs(widened(each, extra, params) if grown else each, way)) for each in look.threats]
    met += [(each, Meeting(avoiding * meet_on_legs(each, way).soft, none, none)) for each in look.returns]
    for each, m in met:
        worst, hardest = ops.maximum(worst, m.soft), ops.maximum(hardest, m.hard)
        crowd, wrong = crowd + m.soft, wrong + m.wrong
        part = total(none, m.soft, m.soft, m.hard, m.wrong, params)
        more = part > most
        most, target = ops.where(more, part, most), ops.where(more, each.number, target)
        side = ops.where(more, each.side, side)
    return total(none, worst, crowd, hardest, wrong, params), target, side


def _advice(
    own: Own[R], peers: Sequence[Peer[R]], memory: ScoringMemory[R], limits: Limits, params: ScoringParams
) -> Advice[R]:
    """The decision as a command of this tick: r_d = -k1 wrap(chi - theta), u_d as decided, 0 while braking."""
    avoiding, steers = memory.avoiding == 1.0, memory.steers == 1.0
    wanted = speed_of(own.u_d, memory.factor, limits.speed_min_mps, params)
    u_d = ops.where(avoiding, wanted, own.u_d)

    def turn(chi: R, cx: R, cy: R) -> R:
        sin_chi, cos_chi = ops.sincos(chi)
        r_d = -params.k1 * ops.atan2(cx * sin_chi - cy * cos_chi, cx * cos_chi + cy * sin_chi)
        return ops.clip(r_d, -limits.yaw_rate_max_radps, limits.yaw_rate_max_radps)

    none = ops.zero(own.x)
    r_d = ops.when(steers, turn, none, own.chi, memory.cx, memory.cy)
    stop = brake(own, peers, limits, params)
    held = stop.braking == 1.0
    first = held & ops.no(avoiding)
    return Advice(
        ops.maximum(memory.avoiding, stop.braking),
        memory.steers,
        r_d,
        ops.where(held, 0.0, u_d),
        stop.braking,
        ops.where(first, stop.target, memory.target),
        ops.where(first, 0.0, memory.side),
    )
