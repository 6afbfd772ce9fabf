"""Which alteration: the candidates rolled out with the lags of the hull, the one of least price taken.

numpy works here on arrays, some candidates at a time, until no other can be cheaper. A large decision goes on over a
few ticks, about the moment at which it was begun. Decisions are always made on arrays; the same numbers give the same
choice everywhere: only + - * / sqrt, comparisons, selection, and least and largest values are used.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from functools import lru_cache

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.foreign.banks import ashore
from fleet.avoidance.foreign.domain import Domain
from fleet.avoidance.foreign.encounter import BY_STARBOARD, Bearing
from fleet.avoidance.foreign.nearness import free_after, nearness, stacked
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.rollout import Motion, Way, holding, left_to_turn, motion
from fleet.avoidance.foreign.types import Action, Afloat, Edge, Encounter, Kind, Mate, Reason
from fleet.ops import FloatArray

AT_ONCE, LEAST_AT_ONCE = 64, 12  # ways that are worked out together
WORK, BANK_WORK = 100, 60  # ways times guesses of the vessels in one tick; less beside banks, where ways take longer
MOST_AT_ONCE = 2  # more boats than that: the outermost first
FASTER = 1.05  # an emergency speed that is not this much faster is none
_DEG = ops.PI / 180.0
_LARGEST_TURN = 200.0


class Candidate(Struct, frozen=True, gc=False):
    """An alteration to try, relative to the path."""

    a: float  # [rad]
    factor: float  # of the cruise speed; above 1 the largest speed
    sense: float  # +1 turn by starboard, -1 by port, 0 the short way
    price: float  # of its own, apart from where it leads
    detour: float  # share of the way that is lost while it is held


@lru_cache(maxsize=32)
def candidates(fastest: float, params: ForeignParams) -> tuple[Candidate, ...]:
    """All candidates, the smallest turns first and starboard before port; `fastest` is u_max / u_c."""
    offsets = [(0.0, 0.0)]
    offsets += [(sign * a, 0.0) for a in (30.0, 45.0, 60.0, 75.0, 90.0, 105.0, 120.0) for sign in (1.0, -1.0)]
    offsets += [(sign * a, sign) for a in (150.0, 180.0) for sign in (1.0, -1.0)]
    offsets += [(210.0, 1.0), (240.0, 1.0)]
    table = []
    for degrees, sense in offsets:
        factors = [1.0, 0.5]
        if degrees == 0.0:
            factors.append(0.0)
        elif fastest > FASTER:
            factors.append(fastest)
        for factor in factors:
            sin_a, cos_a = ops.sincos(degrees * _DEG)
            share = min(abs(degrees), _LARGEST_TURN) / 180.0
            price = params.turn * share * share
            price += params.slow * (1.0 - factor) * (1.0 - factor) if factor <= 1.0 else params.emergency
            price += params.port if degrees < 0.0 else 0.0
            price += params.round_turn if abs(degrees) > 180.0 else 0.0
            f = min(factor, 1.0)
            detour = max(0.0, 1.0 - f * cos_a + 0.5 * f * abs(sin_a))
            table.append(Candidate(degrees * _DEG, factor, sense, price, detour))
    return tuple(table)


class Trial(Struct, frozen=True, gc=False):
    """A candidate here and now."""

    price: float  # of its own, the rules' and that of changing the mind included
    action: Action
    detour: float


class Scene(Struct, frozen=True, gc=False):
    """Everything that a decision hangs on."""

    boats: tuple[Afloat, ...]  # those that sail it, the one that decides first
    own: Bearing  # plan of the one that decides
    domains: tuple[Domain, ...]  # of every usable vessel
    encounters: tuple[Encounter, ...]  # those that are open
    mates: tuple[Mate, ...]  # boats that decide for themselves
    edges: tuple[Edge, ...]  # of banks and no-go polygons within reach
    held: Action  # what is sailed now
    foreseen: tuple[tuple[float, float], ...] = ()  # (number, side) of vessels that will be met, but not yet


class Search(Struct, frozen=True, gc=False):
    """A decision under way: what each candidate costs at least."""

    scene: Scene
    trials: tuple[Trial, ...]
    known: tuple[tuple[float, int, int], ...]  # (price so far, candidate, what of it is known), the cheapest first
    target: float  # number of the vessel that it is for
    cause: Reason


def prepare() -> None:
    """Import what decisions need, so that the first one need not wait for it; at any time before."""
    importlib.import_module("numpy")


def begin(scene: Scene, target: float, cause: Reason, params: ForeignParams) -> Search:
    """Of every candidate its own price is known."""
    trials = tuple(_trials(scene, params))
    known = tuple(sorted((each.price, i, 0) for i, each in enumerate(trials)))
    return Search(scene, trials, known, target, cause)


def go_on(search: Search, params: ForeignParams) -> Search:
    """So much more of the decision as one tick has time for, counted in ways and vessels, not in seconds."""
    scene, known = search.scene, search.known
    crews = _crews(scene.boats)
    guesses = max(sum(len(d.guesses) for d in scene.domains), 1)
    work = BANK_WORK if scene.edges else WORK
    left = work
    while known[0][2] < len(crews) and left > 0:
        level = known[0][2]
        crew = crews[level]
        ways = min(max(work // guesses, LEAST_AT_ONCE), AT_ONCE)
        some = [one for one in known if one[2] == level][: max(ways // len(crew), 1)]
        found = _consequences(crew, scene, [search.trials[i] for _, i, _ in some], params)
        more = [(search.trials[i].price + extra, i, level + 1) for extra, (_, i, _) in zip(found, some, strict=True)]
        known = tuple(sorted([*(one for one in known if one not in some), *more]))
        least = work if scene.edges or len(crews) > 1 else work // 2  # little work takes its time, too
        left -= max(len(some) * len(crew) * guesses, least)
    return structs.replace(search, known=known)


def chosen(search: Search) -> Action | None:
    """The alteration of least price, `at` is left 0; None while another one could still be cheaper."""
    _, i, level = search.known[0]
    return search.trials[i].action if level == len(_crews(search.scene.boats)) else None


def choose(scene: Scene, params: ForeignParams) -> Action:
    """The alteration of least price, at once."""
    search, found = begin(scene, -1.0, Reason.NONE, params), None
    while found is None:
        search = go_on(search, params)
        found = chosen(search)
    return found


def _crews(boats: tuple[Afloat, ...]) -> tuple[tuple[Afloat, ...], ...]:
    """Whose ways are worked out first and next: what the outermost boats pay, all of them pay at least."""
    return (outermost(boats), boats) if len(boats) > MOST_AT_ONCE else (boats,)


def outermost(boats: Sequence[Afloat]) -> tuple[Afloat, ...]:
    """The first boat and those farthest north, south, east and west."""
    places = {0}
    for name in ("x", "y"):
        values = [getattr(boat, name) for boat in boats]
        places |= {values.index(min(values)), values.index(max(values))}
    return tuple(boats[i] for i in sorted(places))


def _trials(scene: Scene, params: ForeignParams) -> list[Trial]:
    """The candidates that are open; the path's course at full speed only for who has left it."""
    lead, own, held = scene.boats[0], scene.own, scene.held
    port_is_closed = _port_is_closed(own, scene.domains, scene.encounters)
    trials = []
    for c in candidates(lead.limits.speed_max_mps / ops.maximum(lead.cruise, 1e-6), params):
        if held.acting > 0.5 or c.a != 0.0 or c.factor != 1.0:
            s, k = ops.sincos(c.a)
            action = Action(1.0, c.a, c.factor, own.ex * k - own.ey * s, own.ex * s + own.ey * k, c.sense, 0.0)
            price = c.price + (params.port_turn if port_is_closed and c.a < 0.0 < c.factor else 0.0)
            trials.append(Trial(price + _change(action, held, params), action, c.detour))
    return trials


def _consequences(boats: Sequence[Afloat], scene: Scene, trials: Sequence[Trial], params: ForeignParams) -> list[float]:
    """What each candidate costs by where it leads: delay, vessels, mates, banks. All of it is >= 0."""
    import numpy as np

    domains, encounters, edges = scene.domains, scene.encounters, scene.edges
    horizon = max((d.H for d in domains), default=params.fine_for_s)
    ways = stacked(_ways(boats, [each.action for each in trials], edges, horizon, params))
    met = [d for d in domains if any(e.number == d.number for e in encounters)]
    price = np.array([each.detour for each in trials]) * (free_after(ways, scene.own, met, params) / params.delay_s)
    price = price + nearness(ways, boats[0], domains, _sides(scene, params), scene.mates, params)
    if edges:
        hit = ashore(ways.x[:-1], ways.y[:-1], ways.x[1:], ways.y[1:], edges, params.ashore_m)
        price = price + params.aground * hit.max(axis=0).max(axis=0)
    found: list[float] = price.tolist()
    return found


def _sides(scene: Scene, params: ForeignParams) -> dict[float, tuple[float, float]]:
    """(side, price of the other one) on which each vessel is to be left."""
    sides = {number: (side, params.wrong_side) for number, side in scene.foreseen}
    for e in scene.encounters:
        sides[e.number] = e.side, params.wrong_side if e.kind in BY_STARBOARD else params.other_side
    return sides


def _ways(
    boats: Sequence[Afloat], actions: Sequence[Action], edges: Sequence[Edge], horizon: float, params: ForeignParams
) -> Way[FloatArray]:
    """The ways of all boats on all actions, arrays (boat, action)."""
    import numpy as np

    left = np.array([[left_to_turn(boat.chi, each.cx, each.cy, each.sense) for each in actions] for boat in boats])
    u_d = np.array([[speed(boat, each.factor) for each in actions] for boat in boats])
    full = np.ones_like(left)
    cx, cy = np.array([each.cx for each in actions]) * full, np.array([each.cy for each in actions]) * full
    alone = [motion(boat) for boat in boats]
    m = Motion(*(np.array([[getattr(each, name)] for each in alone]) * full for name in Motion.__struct_fields__))
    return holding(m, left, cx, cy, u_d, edges, horizon, params)


def speed(boat: Afloat, factor: float) -> float:
    """The speed of a boat on an alteration [m/s]."""
    if factor == 0.0:
        return 0.0
    return min(max(factor * boat.cruise, boat.limits.speed_min_mps), boat.limits.speed_max_mps)


def _port_is_closed(own: Bearing, domains: Sequence[Domain], encounters: Sequence[Encounter]) -> bool:
    """Rules 14 and 15 turn to starboard; rule 17 c closes port to who acts for a vessel on its port side."""
    for e in encounters:
        if e.kind in BY_STARBOARD:
            return True
        if e.kind == Kind.CROSSING_STAND_ON and e.acting > 0.5:
            for d in domains:
                if d.number == e.number and own.ex * (d.y - own.y) - own.ey * (d.x - own.x) < 0.0:
                    return True
    return False


def _change(action: Action, held: Action, params: ForeignParams) -> float:
    """The price of another alteration than the one that is sailed."""
    if held.acting < 0.5:
        return 0.0
    turn = ops.atan2(held.cx * action.cy - held.cy * action.cx, held.cx * action.cx + held.cy * action.cy)
    price = params.change / ops.PI * abs(turn) + params.change_speed * abs(action.factor - held.factor)
    return price + (params.flip if action.a * held.a < 0.0 else 0.0)
