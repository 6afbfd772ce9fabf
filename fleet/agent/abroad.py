"""Foreign vessels in a tick: whose decision the boat sails, and how it goes together with keeping clear of the fleet.

Pure, and part of `step`. Arrays do not come here: a batch has no foreign vessels.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeGuard

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.foreign import law
from fleet.avoidance.foreign.memory import Memory
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.types import Advice, Boat, Edge, Mate, Order, PathLike
from fleet.avoidance.types import Peer
from fleet.guidance import Limits
from fleet.paths import Lane, Path
from fleet.sensing import Target

ALONE, LEADS, FOLLOWS = 0.0, 1.0, 2.0
STANDING_MPS = 0.05  # a boat that keeps its station goes this fast, for the law
ACTS_FOR_S = 30.0  # an alteration lasts longer than that as a rule; then the course goes back to the path
BACK_M = 1.0  # so near to its path a boat is back on it
DRIFTS_MPS = 0.05  # slower boats have no course


class Fellow(Struct, frozen=True, gc=False):
    """A boat of the formation, whose way a leader checks with its own."""

    number: float  # in the roster
    abeam: float  # of its lane, metres to starboard of its path
    x: float  # north [m]
    y: float  # east [m]
    chi: float  # course over ground [rad]
    U: float  # speed over ground [m/s]
    r: float  # yaw rate [rad/s]
    s: float  # abscissa of its virtual target [m]


class Abroad(Struct, frozen=True, gc=False):
    """What a boat knows of foreign vessels this tick, and of who decides about them."""

    now: float  # since the mission was launched [s]
    targets: tuple[Target, ...]
    part: float  # ALONE, LEADS or FOLLOWS
    fellows: tuple[Fellow, ...]  # of a leader
    heard: Order | None  # of a follower: the leader's decision
    edges: tuple[Edge, ...]  # of the fence
    party: tuple[float, ...] = ()  # numbers of the other boats that sail the leader's decision


class Watch(Struct, frozen=True, gc=False):
    """What a boat remembers of foreign vessels, and what it was advised last."""

    memory: Memory
    advice: Advice
    returns: float = 0.0  # 1 back to the path with the party, until it is on it


class Sea(Struct, frozen=True):
    """What stays while a boat sails, of what the law needs."""

    params: ForeignParams
    roster: tuple[tuple[Path, Limits], ...]  # of the mission


def watch(
    abroad: Abroad, before: Watch | None, boat: Boat, peers: Sequence[Peer[Any]], e: Any, sea: Sea
) -> Watch | None:
    """The watch after this tick; None when there is nothing to remember.

    Args:
        abroad: what there is
        before: the watch so far
        boat: the own one
        peers: of the fleet
        e: along-path error; within 10 m the boat is in its place [m]
        sea: what stays
    """
    memory, params = before.memory if before is not None else law.START, sea.params
    in_place, targets, edges, now = abs(e) <= params.slot_m, abroad.targets, abroad.edges, abroad.now
    if abroad.part == FOLLOWS:
        mates = _mates(peers, ())
        memory, advice = law.sail_order(
            boat, targets, mates, edges, abroad.heard, in_place, memory, params, now
        )  # fmt: skip
    else:
        fellows = abroad.fellows if abroad.part == LEADS and in_place else ()
        mates = _mates(peers, tuple(fellow.number for fellow in fellows))
        boats = (boat, *(_boat(fellow, boat.cruise, sea) for fellow in fellows))
        memory, advice = law.keep_clear(boats, targets, mates, edges, memory, params, now)
    returns = 1.0 if _returns(before, memory, abroad.part, boat) else 0.0
    idle = not targets and memory.ordered.acting < 0.5 and memory.sailed.acting < 0.5 and returns < 0.5
    return None if idle else Watch(memory, advice, returns)


def _returns(before: Watch | None, memory: Memory, part: float, boat: Boat) -> bool:
    """On its way back to the path after a decision that it sailed with others."""
    if before is None or part == ALONE or memory.alone > 0.5 or memory.sailed.acting > 0.5:
        return False
    point = boat.path.at(boat.s)
    aside = point.tx * (boat.y - point.y) - point.ty * (boat.x - point.x)
    return (before.memory.sailed.acting > 0.5 or before.returns > 0.5) and abs(aside) > BACK_M


def together(peers: Sequence[Peer[Any]], abroad: Abroad, watched: Watch | None) -> Sequence[Peer[Any]]:
    """The peers, those marked that turn when the own boat does: one decision for all, or its end.

    While it is sailed their plan is the own one, whatever they said last: all have the same order.
    """
    if watched is None or abroad.part == ALONE or watched.memory.alone > 0.5:
        return peers
    advice = watched.advice
    if advice.acting < 0.5 and watched.returns < 0.5:
        return peers
    if advice.acting < 0.5 or advice.banked > 0.5:
        return [structs.replace(p, together=1.0) if p.number in abroad.party else p for p in peers]
    order = {"gx": advice.cx, "gy": advice.cy, "tx": advice.cx, "ty": advice.cy, "u_d": advice.u_d}
    return [structs.replace(p, together=1.0, **order) if p.number in abroad.party else p for p in peers]


def own_boat(
    own: Any, U: Any, r: Any, s: Any, cruise: Any, standing: Any, path: Any, limits: Limits
) -> Boat:  # of values that a batch has as arrays
    """The own boat as the law takes it; one that keeps its station is all but standing."""
    return Boat(own.x, own.y, own.chi, U, r, s, STANDING_MPS if standing else cruise, limits, path)


def _boat(fellow: Fellow, cruise: float, sea: Sea) -> Boat:
    path, limits = sea.roster[int(fellow.number)]
    lane: PathLike = path if fellow.abeam == 0.0 else Lane(path, fellow.abeam)
    return Boat(fellow.x, fellow.y, fellow.chi, fellow.U, fellow.r, fellow.s, cruise, limits, lane)


def _mates(peers: Sequence[Peer[Any]], fellows: tuple[float, ...]) -> tuple[Mate, ...]:
    """Boats of the fleet that decide for themselves."""
    return tuple(
        Mate(peer.x, peer.y, peer.vx, peer.vy) for peer in peers if peer.present > 0.5 and peer.number not in fellows
    )


def acts(watched: Watch | None) -> TypeGuard[Watch]:
    """Whether the boat leaves its path for a foreign vessel."""
    return watched is not None and watched.advice.acting > 0.5


def instead(own: Any, watched: Watch) -> Any:
    """The own boat with the advised course and speed for its plan: what the fleet's keeping clear then starts from."""
    advice = watched.advice
    return structs.replace(  # an Own
        own,
        gx=advice.cx,
        gy=advice.cy,
        u_d=advice.u_d,
        tx=advice.cx,
        ty=advice.cy,
        y_e=0.0,
        straight=ACTS_FOR_S,
    )


def side_of(watched: Watch) -> float:
    """The side on which the vessel that decides is left: +1 to port, -1 to starboard, 0 either."""
    number = watched.advice.target
    return next((contact.side for contact in watched.advice.contacts if contact.number == number), 0.0)


def course_of(vx: float, vy: float, psi: float) -> tuple[float, float]:
    """Course and speed over ground; the heading for a boat that drifts."""
    U = ops.hypot(vx, vy)
    return (ops.atan2(vy, vx) if U >= DRIFTS_MPS else psi), U
