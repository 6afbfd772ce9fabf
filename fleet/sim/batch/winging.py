"""A wingman of a batch beside its leader: `fleet.agent.wing` in numbers. For scenarios that are sailed on floats."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import Struct, structs

from fleet.agent.modes import IN_FORMATION
from fleet.agent.step import Decision, State
from fleet.agent.wing import ON_ITS_PATH, STOPPED, InPlace
from fleet.avoidance.types import Peer
from fleet.coordination import Leader
from fleet.mission.beside import Room
from fleet.ops import hypot
from fleet.paths import Path
from fleet.sim.batch.hearing import Believed, Message


class Winged(Struct):
    """What a wingman, or its leader, knows."""

    column: int  # which of the others leads; -1: itself
    path: Path  # of the leader
    room: Room
    lag_s: float  # of the own surge
    apart: frozenset[int]  # the others whose places keep far enough from the own one
    mine: frozenset[int] = frozenset()  # own wingmen that keep clear of this boat, and not it of them
    last: Leader[float] | None = None


def beside(
    wing: Winged, told: Sequence[Message[float]], aged: Sequence[Believed[float]], state: State[float, object]
) -> Leader[float] | None:
    """The leader now; None for the leader itself, and before it was ever heard."""
    if wing.column < 0:
        return None
    m, a = told[wing.column], aged[wing.column]
    lost = m.stamp < 0.0 or a.silent == 1.0
    if not lost:
        moving = m.mode in ON_ITS_PATH
        p = wing.path.at(m.s + (a.age * (m.vx * m.tx + m.vy * m.ty) if moving else 0.0))
        u = max(m.vx * p.tx + m.vy * p.ty, 0.0) if moving else 0.0
        wing.last = Leader(1.0, float(m.mode in STOPPED), p.x, p.y, p.tx, p.ty, p.c, u, 0.0, 0.0)
    last = wing.last
    if last is None:
        return None
    s_cvt = state.wing.s if state.wing is not None else state.s
    room, slope = wing.room.at(s_cvt)
    gains = wing.room.gains(s_cvt, last.U, wing.lag_s)
    good = 0.0 if lost else 1.0
    return Leader(good, last.stopped, last.x, last.y, last.tx, last.ty, last.c, last.U, room, slope, gains)


def minded(
    wing: Winged,
    peers: Sequence[Peer[float]],
    told: Sequence[Message[float]],
    decision: Decision[float] | None,
    here: tuple[float, float],
    radius_m: float,
) -> list[Peer[float]]:
    """The others, those masked that need no looking after: see `fleet.agent.wing.Wings.minded`; never within R."""
    own = decision is not None and InPlace(decision.mode, decision.e, decision.y_e).sure
    x, y = here

    def one(i: int, p: Peer[float], m: Message[float]) -> Peer[float]:
        near = hypot(p.x - x, p.y - y) <= radius_m
        if p.known < 0.5 or near:
            return p
        in_places = own and i in wing.apart and InPlace(m.mode, m.e, m.y_e).sure
        if in_places or (i in wing.mine and m.mode in IN_FORMATION):
            return structs.replace(p, present=0.0)
        return p

    return [one(i, p, m) for i, (p, m) in enumerate(zip(peers, told, strict=True))]
