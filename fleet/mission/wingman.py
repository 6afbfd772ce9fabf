"""Wingmen beside their leaders: can they stay there, and where must they give each other room?

The paths of a wingman and its leader may cross. Where they come near each other, strictly abeam would be on top of the
leader: there the first wingman of a leader falls back on purpose, the second goes ahead, and comes up again. How far is
known beforehand, for every abscissa of its path: see `beside`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

from msgspec import Struct

from fleet.coordination.wingman import LEAST_COS
from fleet.mission.beside import ABEAM, MOST, STEP_M, Beside, Room, room_beside, sail
from fleet.mission.misfit import CRUISE_MARGIN_MPS, Misfit
from fleet.mission.pattern import Shape
from fleet.mission.plan import BoatPlan, Plan
from fleet.paths import PathPoint


class Wingman(Struct, frozen=True):
    """A wingman and what is known of its voyage."""

    boat: BoatPlan
    leader: BoatPlan
    voyage: tuple[Beside, ...]
    room: Room


def wingmen(plan: Plan, shape: Shape, need: float) -> dict[int, Wingman]:
    """Every wingman by its number; `need`: least distance between two boats [m]."""
    found: dict[int, Wingman] = {}
    served: dict[int, int] = {}
    for boat in plan.boats:
        number = shape.leader_of(boat.number)
        if number is None:
            continue
        leader = plan.boats[number]
        served[number] = served.get(number, 0) + 1
        voyage, room = tuple(sail(boat, leader)), ABEAM
        if plan.mission.formation.crossing != "keep-on":
            side = -1.0 if served[number] % 2 else 1.0
            room = room_beside(voyage, boat.limits, shape.cruise_mps, need, side)
        found[boat.number] = Wingman(boat, leader, voyage, room)
    return found


def wingman_misfits(plan: Plan, shape: Shape, need: float) -> Iterator[Misfit]:
    """Paths that are not oriented in the same direction, speeds that nobody has, wingmen on top of each other."""
    if len(plan.boats) < len(plan.mission.boats):
        return  # paths that could not be built are named elsewhere
    if sum(shape.leader_of(boat.number) is None for boat in plan.boats) > 1:
        heads = ", ".join(boat.name for boat in plan.boats if shape.leader_of(boat.number) is None)
        yield Misfit("pattern", f"{heads} have nobody nearer to slot 0 to sail beside; expected one leader")
        return
    found = wingmen(plan, shape, need)
    wrong = [text for one in found.values() if (text := _parts(one) or _too_fast(one, shape.cruise_mps))]
    yield from (Misfit("pattern", text) for text in wrong)
    if not wrong:
        yield from _too_near(found, need)


def _parts(one: Wingman) -> str:
    """Where the paths are not oriented in the same direction."""
    for here in one.voyage:
        if here.cos_beta < LEAST_COS:
            angle = math.degrees(math.acos(max(here.cos_beta, -1.0)))
            where = f"path {one.boat.path_name} at {here.s2:.0f} m, at [{here.own.x:.1f}, {here.own.y:.1f}] m"
            beside = f"path {one.leader.path_name} at {here.s1:.0f} m"
            most = math.degrees(math.acos(LEAST_COS))
            return (
                f"{where}, runs {angle:.0f} deg off {beside}, beside which {one.boat.name} would sail; "
                f"expected paths oriented in the same direction, at most {most:.0f} deg apart"
            )
    return ""


def _too_fast(one: Wingman, cruise_mps: float) -> str:
    """Where staying abeam asks for a speed that the boat has not."""
    low = one.boat.limits.speed_min_mps + CRUISE_MARGIN_MPS
    high = one.boat.limits.speed_max_mps - CRUISE_MARGIN_MPS
    worst = max(one.voyage, key=lambda here: max(here.rate * cruise_mps - high, low - here.rate * cruise_mps))
    u = worst.rate * cruise_mps
    if low - 1e-9 <= u <= high + 1e-9:
        return ""
    where = f"path {one.boat.path_name} at {worst.s2:.0f} m, at [{worst.own.x:.1f}, {worst.own.y:.1f}] m"
    need = f"{one.boat.name} needs {low:g} to {high:g} m/s to keep its place"
    return f"{where}, asks for {u:.2f} m/s to stay abeam; {need}"


def tracks(found: dict[int, Wingman]) -> dict[int, dict[int, tuple[float, float]]]:
    """Where each boat's place is, metre by metre of the first leader: by boat, then by metre.

    Wingmen of wingmen are taken where their own leader is.
    """
    heads = {one.leader.number for one in found.values()} - set(found)
    places: dict[int, dict[int, tuple[float, float]]] = {}
    begins: dict[int, dict[int, float]] = {}
    for head in heads:
        leader = next(one.leader for one in found.values() if one.leader.number == head)
        long = leader.path.length if leader.path.closed else leader.path.length - leader.s
        count = min(int(long / STEP_M), MOST)
        begins[head] = {i: leader.s + i * long / max(count, 1) for i in range(count + 1)}
        places[head] = {i: _xy(leader.path.at(s)) for i, s in begins[head].items()}
    while left := [n for n, one in found.items() if n not in places and one.leader.number in places]:
        for n in left:
            one = found[n]
            voyage = list(sail(one.boat, one.leader, one.room))
            begins[n], places[n], k = {}, {}, 0
            for i, s1 in begins[one.leader.number].items():
                while k + 1 < len(voyage) and voyage[k].s1 < s1 - 1e-6:
                    k += 1
                if voyage and abs(voyage[k].s1 - s1) < 2.0 * STEP_M:
                    begins[n][i], places[n][i] = voyage[k].s2, _xy(voyage[k].own)
    return places


def apart(found: dict[int, Wingman], need: float) -> Iterator[tuple[int, int, float, tuple[float, float], float]]:
    """Each pair: the two numbers, their least distance, where, and the share of the way on which it is below `need`."""
    places = tracks(found)
    for one, two in combinations(sorted(places), 2):
        common = places[one].keys() & places[two].keys()
        if not common:
            continue
        away = {i: math.dist(places[one][i], places[two][i]) for i in common}
        at = min(away, key=lambda i: (away[i], i))
        yield one, two, away[at], places[one][at], sum(d < need - 1e-6 for d in away.values()) / len(away)


def _too_near(found: dict[int, Wingman], need: float) -> Iterator[Misfit]:
    """Boats whose places are near each other for most of the way; elsewhere they keep clear when they meet."""
    names = {boat.number: boat.name for one in found.values() for boat in (one.boat, one.leader)}
    for one, two, least, (x, y), share in apart(found, need - 1.0):
        if share > 0.5:
            text = f"the places of {names[one]} and {names[two]} are {least:.1f} m apart at [{x:.1f}, {y:.1f}] m"
            yield Misfit("pattern", f"{text}, and near each other for most of the way; at least {need:.1f} m")


def _xy(p: PathPoint[float]) -> tuple[float, float]:
    return p.x, p.y
