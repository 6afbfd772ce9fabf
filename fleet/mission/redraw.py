"""From one formation to another: all boats move together, so that no two meet that need not.

Ahead and abeam every boat goes from its old place to its new one in step with the others. Seen from the formation those
are straight lines, and where slots were exchanged they may cross: then boats that go to starboard go ahead for a while,
those that go to port fall back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from msgspec import Struct

from fleet.mission.pattern import Place, Shape
from fleet.mission.plan import BoatPlan
from fleet.paths import shift_length

AT_LEAST_MPS = 0.05  # along the path, relative to the formation
SHARE = 0.7  # of what speed limits leave above and below cruise
ROOM = 1.5  # of the least distance between slots, from boat to boat where their ways cross
MOST_BOATS = 200  # whose ways are held against each other


class Redrawing(Struct, frozen=True):
    """How a formation becomes another."""

    before: tuple[Place, ...]
    after: tuple[Place, ...]
    detours: tuple[float, ...]
    """Metres that boats go ahead on the way, + ahead."""
    duration_s: float

    def ahead(self, number: int, since_s: float) -> float:
        """o_i so long after the beginning [m]."""
        return self._at(number, since_s)[0]

    def places(self, since_s: float) -> tuple[Place, ...]:
        """Where everybody's place is so long after the beginning."""
        return tuple(self._at(number, since_s) for number in range(len(self.after)))

    def _at(self, number: int, since_s: float) -> Place:
        phase = min(max(since_s / self.duration_s, 0.0), 1.0)
        done = phase * phase * (3.0 - 2.0 * phase)
        bump = 16.0 * (phase * (1.0 - phase)) ** 2
        (a, b), (x, y) = self.before[number], self.after[number]
        return a + done * (x - a) + bump * self.detours[number], b + done * (y - b)


def redrawing(before: Sequence[Place], after: Shape, boats: Sequence[BoatPlan], need: float) -> Redrawing | None:
    """How the fleet comes from its places to a formation's; None where nobody changes lanes, and speed alone does it.

    Args:
        before: places now
        after: the formation to come
        boats: the roster
        need: least distance between two slots [m]
    """
    there = tuple(after.place(i) for i in range(len(before)))
    if all(b == y for (_, b), (_, y) in zip(before, there, strict=True)):
        return None
    detours = _detours(before, there, need)
    spare = min(
        min(b.limits.speed_max_mps - after.cruise_mps, after.cruise_mps - b.limits.speed_min_mps) for b in boats
    )
    rate = max(SHARE * spare, AT_LEAST_MPS)
    along = [1.5 * abs(x - a) + 3.1 * abs(d) for (a, _), (x, _), d in zip(before, there, detours, strict=True)]
    abeam = [_lane_change_s(boat, before[boat.number], there[boat.number], after.cruise_mps) for boat in boats]
    return Redrawing(tuple(before), there, detours, max(max(along) / rate, *abeam))


def _lane_change_s(boat: BoatPlan, here: Place, there: Place, cruise_mps: float) -> float:
    radius = boat.limits.speed_max_mps / boat.limits.yaw_rate_max_radps
    return shift_length(there[1] - here[1], radius) / cruise_mps


def _detours(before: Sequence[Place], after: Sequence[Place], need: float) -> tuple[float, ...]:
    """How far each boat goes ahead or falls back, so that those whose ways cross pass each other clear."""
    count = len(before)
    levels = [0] * count
    if count > MOST_BOATS:
        return (0.0,) * count
    across = [y - b for (_, b), (_, y) in zip(before, after, strict=True)]
    for i in sorted(range(count), key=lambda i: (abs(across[i]), i)):
        if across[i] == 0.0:
            continue
        taken = {
            levels[j]
            for j in range(count)
            if j != i
            and (across[j] == 0.0 or (abs(across[j]), j) < (abs(across[i]), i))
            and _meet(before[i], after[i], before[j], after[j], need)
        }
        step = 1 if across[i] > 0.0 else -1
        while levels[i] in taken:
            levels[i] += step
    return tuple(ROOM * need * level for level in levels)


def _meet(a: Place, b: Place, c: Place, d: Place, need: float) -> bool:
    """Whether two boats that go from a to b and from c to d in step come nearer than they may."""
    x, y = a[0] - c[0], a[1] - c[1]
    vx, vy = b[0] - d[0] - x, b[1] - d[1] - y
    v_sq = vx * vx + vy * vy
    t = min(max(-(x * vx + y * vy) / v_sq, 0.0), 1.0) if v_sq > 0.0 else 0.0
    return math.hypot(x + t * vx, y + t * vy) < need - 1e-9
