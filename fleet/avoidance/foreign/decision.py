"""Which alteration: the candidates rolled out with the lags of the hull, the one of least price taken.

numpy works here on arrays: the ways of all boats on all candidates, a vertex of each at a time; then prices, some
candidates at a time, until no other can be cheaper. A large decision goes on over a few ticks, about the moment at
which it was begun. The same numbers give the same choice everywhere: only + - * / sqrt, comparisons, selection, and
least and largest values are used.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from functools import lru_cache

from msgspec import Struct, structs

from fleet import ops
from fleet.avoidance.foreign.banks import off_shore, offing
from fleet.avoidance.foreign.domain import Domain
from fleet.avoidance.foreign.encounter import BY_STARBOARD, Bearing
from fleet.avoidance.foreign.nearness import Ways, free_after, nearness, part, stacked
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.foreign.rollout import COARSE_S, Motion, Sailing, left_to_turn, motion, sail_on, set_out
from fleet.avoidance.foreign.types import Action, Afloat, Edge, Encounter, Kind, Mate, Reason
from fleet.ops import FloatArray

AT_ONCE = 64  # ways that are priced together
WORK = 80.0  # of one tick; 1 is about 0.05 ms on a quiet machine
SET_OUT, STEP, FREE_STEP, BANKED_STEP, EDGE, CORNER = 7.0, 1.2, 0.1, 1.5, 0.6, 3.5  # of all ways,
WAYS = 800  # and as much again for each so many of them
PRICE, LEG = 30.0, 3.6e-3  # of a price: calls, and each leg to each guess of a vessel
MOST_AT_ONCE = 2  # more boats than that: the outermost first
ABOUT_RAD = 2.0  # larger turns beside a bank go round off it
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


class Search(Struct, frozen=True, dict=True):
    """A decision under way: what each candidate costs at least.

    The ways themselves are kept beside these numbers, and neither recorded nor compared: who was given the numbers
    alone, as a replay is, works them out anew.
    """

    scene: Scene
    trials: tuple[Trial, ...]
    known: tuple[tuple[float, int, int], ...]  # (price so far, candidate, what of it is known), the cheapest first
    target: float  # number of the vessel that it is for
    cause: Reason
    steps: float = 0.0  # of the ways that are worked out


def prepare() -> None:
    """Import what decisions need, so that the first one need not wait for it; at any time before."""
    importlib.import_module("numpy")


def begin(scene: Scene, target: float, cause: Reason, params: ForeignParams) -> Search:
    """Of every candidate its own price is known."""
    trials = tuple(_trials(scene, cause, params))
    known = tuple(sorted((each.price, i, 0) for i, each in enumerate(trials)))
    return Search(scene, trials, known, target, cause)


def go_on(search: Search, params: ForeignParams) -> Search:
    """So much more of the decision as one tick has time for, counted in steps, ways and vessels, not in seconds."""
    scene, known, left, kept = search.scene, search.known, WORK, search.__dict__
    sailing, ways = _sailed(search, params), kept.get("ways")
    if not sailing.done:
        count = len(scene.boats) * len(search.trials)
        steps, left = _steps(sailing, scene.edges, count, left if search.steps > 0.0 else left - SET_OUT, params)
        sailing = sail_on(sailing, scene.edges, steps, params)
    if sailing.done:
        ways = stacked(sailing.way) if ways is None else ways
        known = _priced(search, ways, left, params)
    search = structs.replace(search, known=known, steps=len(sailing.way.t) - 1.0)
    search.__dict__.update(sailing=sailing, ways=ways)
    return search


def _steps(
    sailing: Sailing[FloatArray], edges: Sequence[Edge], count: int, left: float, params: ForeignParams
) -> tuple[float, float]:
    """(steps of so many ways that there is work left for, what is left after them)."""
    more = 1.0 + count / WAYS
    banked = more * (BANKED_STEP + EDGE * len(edges) + (CORNER if len(edges) > 1 else 0.0)) if edges else 0.0
    fine, coarse = more * STEP + banked, more * FREE_STEP + banked
    t = sailing.way.t[-1]
    turns = max(min(params.fine_for_s, sailing.horizon) - t, 0.0) / params.fine_s
    goes_on = max(sailing.horizon - max(t, params.fine_for_s), 0.0) / (COARSE_S if edges else params.coarse_s)
    turning = min(turns, max(left // fine, 1.0))
    left -= turning * fine
    straight = min(goes_on, left // coarse) if turning == turns and left > 0.0 else 0.0
    return turning + straight, left - straight * coarse


def _priced(search: Search, ways: Ways, left: float, params: ForeignParams) -> tuple[tuple[float, int, int], ...]:
    """What is known when the cheapest have gone on, as many as there is work left for."""
    scene, known = search.scene, search.known
    crews = _crews(scene.boats)
    legs = max(sum(len(d.guesses) for d in scene.domains), 1) * len(ways.t)  # of one way
    while known[0][2] < len(crews):
        level = known[0][2]
        crew = crews[level]
        count = min((left - PRICE) / (LEG * legs), AT_ONCE) // len(crew)
        if count < 1.0 and left < WORK:
            break  # in the next tick; one at least in each
        some = [one for one in known if one[2] == level][: int(max(count, 1.0))]
        numbers = [i for _, i, _ in some]
        found = _consequences(part(ways, crew, numbers), scene, [search.trials[i] for i in numbers], params)
        more = [(search.trials[i].price + extra, i, level + 1) for extra, i in zip(found, numbers, strict=True)]
        known = tuple(sorted([*(one for one in known if one not in some), *more]))
        left -= PRICE + LEG * legs * len(some) * len(crew)
    return known


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


def _crews(boats: Sequence[Afloat]) -> tuple[tuple[int, ...], ...]:
    """Whose ways are priced first and next: what the outermost boats pay, all of them pay at least."""
    everybody = tuple(range(len(boats)))
    return (outermost(boats), everybody) if len(boats) > MOST_AT_ONCE else (everybody,)


def outermost(boats: Sequence[Afloat]) -> tuple[int, ...]:
    """Which is the first boat, and which are farthest north, south, east and west."""
    places = {0}
    for name in ("x", "y"):
        values = [getattr(boat, name) for boat in boats]
        places |= {values.index(min(values)), values.index(max(values))}
    return tuple(sorted(places))


def _trials(scene: Scene, cause: Reason, params: ForeignParams) -> list[Trial]:
    """The candidates that are open; the path's course at full speed only for who has left it."""
    lead, own, held = scene.boats[0], scene.own, scene.held
    port_is_closed = _port_is_closed(own, scene.domains, scene.encounters)
    trials = []
    for c in candidates(lead.limits.speed_max_mps / ops.maximum(lead.cruise, 1e-6), params):
        if held.acting > 0.5 or c.a != 0.0 or c.factor != 1.0:
            s, k = ops.sincos(c.a)
            cx, cy = own.ex * k - own.ey * s, own.ex * s + own.ey * k
            action = round_off(Action(1.0, c.a, c.factor, cx, cy, c.sense, 0.0), lead, scene.edges, params)
            price = c.price + (params.port_turn if port_is_closed and c.a < 0.0 < c.factor else 0.0)
            if cause is Reason.REVIEW and (action.a != held.a or action.factor != held.factor):
                price += params.review_gain
            trials.append(Trial(price + _change(action, held, params), action, c.detour))
    return trials


def round_off(action: Action, boat: Afloat, edges: Sequence[Edge], params: ForeignParams) -> Action:
    """The same, but a large turn beside a bank goes round off it, even where that is the longer way."""
    if not edges or abs(left_to_turn(boat.chi, action.cx, action.cy, 0.0)) < ABOUT_RAD:
        return action
    circle = 2.0 * boat.limits.speed_max_mps / boat.limits.yaw_rate_max_radps
    sense = off_shore(boat.x, boat.y, boat.chi, edges, circle + params.bank_m)
    return structs.replace(action, sense=sense) if sense != 0.0 else action


def _consequences(ways: Ways, scene: Scene, trials: Sequence[Trial], params: ForeignParams) -> list[float]:
    """What each candidate costs by where it leads: delay, vessels, mates, banks. All of it is >= 0.

    Args:
        ways: of the boats that count, on these candidates
    """
    import numpy as np

    domains, encounters, edges = scene.domains, scene.encounters, scene.edges
    met = [d for d in domains if any(e.number == d.number for e in encounters)]
    price = np.array([each.detour for each in trials]) * (free_after(ways, scene.own, met, params) / params.delay_s)
    price = price + nearness(ways, scene.boats[0], domains, _sides(scene, params), scene.mates, params)
    if edges:
        off = offing(ways.x[:-1], ways.y[:-1], ways.x[1:], ways.y[1:], edges, params.ashore_m).min(axis=0).min(axis=0)
        price = price + params.aground * np.where(off < params.ashore_m, 2.0 - off / params.ashore_m, 0.0)
    found: list[float] = price.tolist()
    return found


def _sides(scene: Scene, params: ForeignParams) -> dict[float, tuple[float, float]]:
    """(side, price of the other one) on which each vessel is to be left."""
    sides = {number: (side, params.wrong_side) for number, side in scene.foreseen}
    for e in scene.encounters:
        sides[e.number] = e.side, params.wrong_side if e.kind in BY_STARBOARD else params.other_side
    return sides


def _sailed(search: Search, params: ForeignParams) -> Sailing[FloatArray]:
    """The ways of all boats on all candidates, arrays (boat, candidate), as far as they are worked out."""
    kept: Sailing[FloatArray] | None = search.__dict__.get("sailing")
    if kept is None:
        begun = _set_out(search.scene, search.trials, params)
        kept = sail_on(begun, search.scene.edges, search.steps, params)
    return kept


def _set_out(scene: Scene, trials: Sequence[Trial], params: ForeignParams) -> Sailing[FloatArray]:
    """The start of the ways of all boats on all candidates, arrays (boat, candidate)."""
    import numpy as np

    boats, actions = scene.boats, [each.action for each in trials]
    u_d = np.array([[speed(boat, each.factor) for each in actions] for boat in boats])
    full = np.ones_like(u_d)
    cx, cy, sense = (np.array([getattr(each, name) for each in actions]) * full for name in ("cx", "cy", "sense"))
    alone = [motion(boat) for boat in boats]
    m = Motion(*(np.array([[getattr(each, name)] for each in alone]) * full for name in Motion.__struct_fields__))
    horizon = max((d.H for d in scene.domains), default=params.fine_for_s)
    return set_out(m, left_to_turn(m.chi, cx, cy, sense), cx, cy, u_d, horizon)


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
