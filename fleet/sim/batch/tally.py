"""What is counted while a run goes on, so that no trajectory need be kept; for floats and arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Generic

from msgspec import Struct, structs

from fleet import ops
from fleet.agent.modes import Goal
from fleet.agent.step import Decision, Order
from fleet.ops import R
from fleet.sim.batch.hearing import TICK_S

CHECK_TICKS = 50  # how often it is seen who has finished, and who stands still
STILL_S, STILL_MPS = 60.0, 0.1
MARKS = round(STILL_S / (CHECK_TICKS * TICK_S))
SETTLED_M = 1.0
OFF_PATH_M, OFF_PLACE_M = 1.0, 2.0


class Tally(Struct, Generic[R], frozen=True, gc=False):
    """Of each boat."""

    goal_m: R
    measure_tick: R
    arrived: R  # tick, inf not yet
    avoiding: R  # at the last tick
    switches: R
    ticks: R  # measured
    y_sq: R  # sum of squares of the cross-track error [m2]
    y_most: R
    e_sq: R  # of the true formation error [m2]
    e_most: R
    e_last: R
    unsettled: R  # last tick at which it was 1 m or more
    marks: tuple[R, ...]  # abscissae every 5 s, the oldest first
    under_way: R  # checks for which it has been told to move
    stood: R  # 1 it once made no way good without being told to
    x: R  # at the last check [m]
    y: R
    way: R  # sailed since the start [m]
    ways: tuple[R, ...]  # the same every 5 s, the oldest first
    stopped: R  # 1 it once did not even move
    off_path: R  # ticks 1 m or more off its path; in formations
    off_place: R  # ticks with a formation error of 2 m or more


def begin(like: R, goal_m: R, measure_tick: R, s: R, x: R, y: R) -> Tally[R]:
    """Nothing yet."""
    zero = ops.zero(like)
    return Tally(
        goal_m,
        measure_tick,
        ops.full(like, math.inf),
        zero,
        zero,
        zero,
        zero,
        zero,
        zero,
        zero,
        zero,
        ops.full(like, -1.0),
        (s,) * MARKS,
        zero,
        zero,
        x,
        y,
        zero,
        (zero,) * MARKS,
        zero,
        zero,
        zero,
    )


def count(t: Tally[R], d: Decision[R], e: R | None, now: float) -> Tally[R]:
    """One tick more; e: true formation error, None where there is no formation [m]."""
    counts = ops.flag(t.measure_tick <= now, d.s)
    off = abs(d.y_e) * counts
    e_sq, e_most, e_last, unsettled = t.e_sq, t.e_most, t.e_last, t.unsettled
    off_path, off_place = t.off_path, t.off_place
    if e is not None:
        e_last = abs(e)
        e_now = e_last * counts
        e_sq, e_most = e_sq + e_now * e_now, ops.maximum(e_most, e_now)
        unsettled = ops.where(e_last >= SETTLED_M, now, unsettled)
        off_path = off_path + ops.flag(off >= OFF_PATH_M, off)
        off_place = off_place + ops.flag(e_now >= OFF_PLACE_M, off)
    return Tally(
        t.goal_m,
        t.measure_tick,
        ops.where((d.s >= t.goal_m) & (t.arrived == math.inf), now, t.arrived),
        d.avoiding,
        t.switches + abs(d.avoiding - t.avoiding),
        t.ticks + counts,
        t.y_sq + off * off,
        ops.maximum(t.y_most, off),
        e_sq,
        e_most,
        e_last,
        unsettled,
        t.marks,
        t.under_way,
        t.stood,
        t.x,
        t.y,
        t.way,
        t.ways,
        t.stopped,
        off_path,
        off_place,
    )


def check(t: Tally[R], d: Decision[R], order: Order[R], x: R, y: R) -> Tally[R]:
    """Every 5 s: less than 6 m made good in 60 s, though told to sail and not there yet, is a standstill.

    A boat that sails in circles stands still in this sense; one that moves less than 6 m has stopped, too.
    """
    told = (order.goal == float(Goal.FOLLOW)) & (order.cruise > STILL_MPS) & (d.s < order.s_end)
    under_way = ops.where(told & (t.arrived == math.inf), t.under_way + 1.0, 0.0)
    still = (under_way > MARKS) & (d.s - t.marks[0] < STILL_MPS * STILL_S)
    way = t.way + ops.hypot(x - t.x, y - t.y)
    stopped = still & (way - t.ways[0] < STILL_MPS * STILL_S)
    return structs.replace(
        t,
        marks=(*t.marks[1:], d.s),
        under_way=under_way,
        stood=ops.maximum(t.stood, ops.flag(still, d.s)),
        x=x,
        y=y,
        way=way,
        ways=(*t.ways[1:], way),
        stopped=ops.maximum(t.stopped, ops.flag(stopped, d.s)),
    )


class Apart(Struct, Generic[R], frozen=True, gc=False):
    """Of each pair of boats."""

    dx: R  # from the first to the second, at the last tick [m]
    dy: R
    least_sq: R  # least separation squared, between ticks too [m2]
    inside: R  # ticks within the radius R


def part(a: Apart[R], dx: R, dy: R, radius_m: float) -> Apart[R]:
    """A tick later: both moved in straight lines meanwhile."""
    wx, wy = dx - a.dx, dy - a.dy
    moved = wx * wx + wy * wy
    share = ops.clip(-(a.dx * wx + a.dy * wy) / ops.where(moved > 0.0, moved, 1.0), 0.0, 1.0)
    ex, ey = a.dx + share * wx, a.dy + share * wy
    near = ex * ex + ey * ey
    d_sq = dx * dx + dy * dy
    return Apart(
        dx,
        dy,
        ops.minimum(a.least_sq, near),
        a.inside + ops.flag(d_sq < radius_m * radius_m, d_sq),
    )


def formation_errors(z: Sequence[R], members: Sequence[R], formations: int = 1) -> list[R]:
    """True error of each boat of one scenario: mean of the others' places less its own; boats in ascending order [m].

    z: abscissa less slot offset
    members: number of the formation that it belongs to, 0 none
    formations: how many there are
    """
    if formations > 1:
        each = [_of_one(z, [ops.flag(m == k, m) for m in members]) for k in range(1, formations + 1)]
        return [sum(errors[1:], errors[0]) for errors in zip(*each, strict=True)]
    return _of_one(z, members)


def _of_one(z: Sequence[R], members: Sequence[R]) -> list[R]:
    """The errors in one formation, 0 for boats that are not of it; members: 1 it is."""
    total, number = ops.zero(z[0]), ops.zero(z[0])
    for z_i, m in zip(z, members, strict=True):
        total, number = total + m * z_i, number + m
    return [m * ((total - m * z_i) / ops.maximum(number - 1.0, 1.0) - z_i) for z_i, m in zip(z, members, strict=True)]
