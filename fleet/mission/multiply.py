"""A mission for N boats, made from one for a few."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from itertools import count

from msgspec import structs

from fleet.errors import UsageError
from fleet.mission.formation import gap_needed
from fleet.mission.model import Boat, Event, Mission, Start
from fleet.mission.pattern import PATTERNS, slots_of
from fleet.mission.plan import BoatPlan, Plan, attempt

MOST = 1000  # boats


def multiply(mission: Mission, boats: int) -> Mission:
    """The mission with so many boats.

    Fewer: the first ones of the roster. More: the roster's boats are repeated in turn, each time on the same path with
    the next slot of that path, and begin one spacing further on, behind the others as a rule. If the column then
    reaches back beyond the start of a path, every boat that begins on a path is moved ahead by the same distance.
    Entries of the timeline that name boats left out lose those names, and go if none is left.
    """
    if not 1 <= boats <= MOST:
        raise UsageError(f"--boats {boats}: expected 1 to {MOST}")
    roster = list(mission.boats[:boats])
    plan, problems = attempt(mission)
    if boats > len(roster) and not problems and len(plan.boats) == len(roster):
        roster = _more(plan, boats)
    return structs.replace(mission, boats=tuple(roster), timeline=tuple(_timeline(mission, roster)))


def _timeline(mission: Mission, roster: Sequence[Boat]) -> Iterator[Event]:
    """The timeline without the boats that are left out."""
    gone = {boat.name for boat in mission.boats} - {boat.name for boat in roster}
    for event in mission.timeline:
        kept = tuple(name for name in event.boats if name not in gone)
        value = event.value
        if isinstance(value, str) and event.do in ("set slots", "set leader"):
            value = ",".join(part for part in re.split(r"[,\s]+", value.strip()) if part.partition("=")[0] not in gone)
        if (kept or not event.boats) and value != "":
            yield structs.replace(event, boats=kept, value=value)


def _more(plan: Plan, boats: int) -> list[Boat]:
    """The roster with further boats in the next slots."""
    mission = plan.mission
    pattern = mission.boats
    names = _names([boat.name for boat in pattern])
    taken = {name: [(boat.slot, boat.s) for boat in plan.boats if boat.path_name == name] for name in plan.paths}
    roster = list(pattern)
    for i in range(len(pattern), boats):
        boat = pattern[i % len(pattern)]
        step = _step([slot for slot, _ in taken[boat.path]])
        if PATTERNS[mission.formation.pattern].lateral:
            slot, s = _next_place(plan, taken[boat.path], boats)
        elif mission.formation.pattern == "wingman":
            known = {one.slot for one in roster}
            slot = next(one for one in slots_of("wingman", boats + len(known)) if one not in known)
            s = _free_start(
                plan, plan.boats[i % len(pattern)], [t for _, t in taken[boat.path]], boat.start.s_m or 0.0, -1.0
            )
        else:
            slot, s = (max if step > 0.0 else min)(taken[boat.path])
            slot += step
            s = _free_start(plan, plan.boats[i % len(pattern)], [t for _, t in taken[boat.path]], s, step)
        taken[boat.path].append((slot, s))
        start = Start(s_m=s, speed_mps=boat.start.speed_mps)
        roster.append(structs.replace(boat, name=next(names), slot=slot, start=start))
    return _ahead(plan, roster)


def _next_place(plan: Plan, taken: Sequence[tuple[float, float]], boats: int) -> tuple[float, float]:
    """The pattern's next free slot, and the abscissa there, as the first boat of the path lies."""
    shape, (first, s) = plan.shape, taken[0]
    place = PATTERNS[shape.pattern].place
    known = [slot for slot, _ in taken]
    slot = next(slot for slot in slots_of(shape.pattern, boats + len(known)) if slot not in known)
    ahead, reference = (place(one, shape.spacing_m, shape.lateral_m)[0] for one in (slot, first))
    return slot, s + ahead - reference


def _step(slots: Sequence[float]) -> float:
    """From one slot of a path to the next: as written, and backwards where there is only one."""
    if len(slots) < 2 or slots[-1] == slots[-2]:
        return -1.0
    return slots[-1] - slots[-2]


def _free_start(plan: Plan, boat: BoatPlan, taken: Sequence[float], neighbour: float, step: float) -> float:
    """The nearest free abscissa, whole strides beyond the boat of the slot next to it."""
    need = gap_needed(plan.mission)
    along = step * plan.mission.formation.spacing_m
    stride = math.copysign(max(abs(along), need), along)
    length = boat.path.length
    if not boat.path.closed:
        return (max(taken) if stride > 0.0 else min(taken)) + stride
    for k in range(1, math.ceil(length / need) + 1):
        s = (neighbour + k * stride) % length
        if all(min((s - t) % length, (t - s) % length) >= need - 1e-9 for t in taken):
            return s
    return (neighbour + stride) % length  # the circuit is full, which `check` says better


def _ahead(plan: Plan, roster: list[Boat]) -> list[Boat]:
    """The boats moved ahead on their paths until the last of them is on its path."""
    behind = min((b.start.s_m or 0.0 for b in roster if not plan.paths[b.path].closed), default=0.0)
    if behind >= 0.0:
        return roster
    return [
        structs.replace(boat, start=structs.replace(boat.start, s_m=boat.start.s_m - behind))
        if boat.start.s_m is not None and not plan.paths[boat.path].closed
        else boat
        for boat in roster
    ]


def _names(known: Sequence[str]) -> Iterator[str]:
    """Further names after the pattern of the first one: b1, b2 -> b3, b4, ..."""
    found = re.fullmatch(r"(.*?)(\d+)", known[0])
    stem = found[1] if found else known[0] + "-"
    for number in count(int(found[2]) if found else 2):
        name = f"{stem}{number}"
        if name not in known:
            yield name
