"""Families of scenarios: how their starts are drawn. Case n of a seed is the same however many are drawn with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from fleet import ops
from fleet.agent.modes import Goal
from fleet.ops import FloatArray
from fleet.paths import Path, straight
from fleet.sim.batch.draws import Purpose, begin, uniform
from fleet.sim.batch.scenarios import Change, IntArray, Scenarios, assemble

MEET_S = 70.0  # before boats meet, and the same again after it
NEAR_S, NEAR_M = 3.0, 3.0  # of the meeting point, each boat, either way: as many would collide as in the yardstick
APART_M = 20.0  # at the start
LONG_M = 3000.0


class Draw:
    """Numbers of a set of cases; each call draws further ones."""

    def __init__(self, seed: int, case: IntArray, boats: int, attempt: int = 0) -> None:
        self._seed, self._case, self._boats, self._attempt = seed, case, boats, attempt
        self._purpose = int(Purpose.START)

    def per_boat(self, low: float, high: float) -> FloatArray:
        """(B, K) even in [low, high)."""
        return self._even(np.arange(self._boats)[None, :], low, high)

    def per_scenario(self, low: float, high: float) -> FloatArray:
        """(B,) even in [low, high)."""
        return self._even(np.array([[-1]]), low, high)[:, 0]

    def _even(self, boat: IntArray, low: float, high: float) -> FloatArray:
        self._purpose += 1
        h = begin(self._seed, self._case[:, None], boat, boat, self._attempt, self._purpose)
        return low + (high - low) * uniform(h)


def cases_of(cases: int | IntArray) -> IntArray:
    """0 .. n - 1, or the cases given."""
    return np.arange(cases) if isinstance(cases, int) else np.asarray(cases, dtype=np.intp)


def lines(x: FloatArray, y: FloatArray, c: FloatArray, s: FloatArray, long: float) -> tuple[tuple[Path, ...], IntArray]:
    """A straight path per boat from (x, y) along the unit vector (c, s); and their numbers (B, K)."""
    paths = []
    for x0, y0, tx, ty in zip(
        x.ravel().tolist(), y.ravel().tolist(), c.ravel().tolist(), s.ravel().tolist(), strict=True
    ):
        paths.append(straight((x0, y0), (x0 + long * tx, y0 + long * ty)))
    return tuple(paths), np.arange(x.size).reshape(x.shape)


def _nearest(x: FloatArray, y: FloatArray) -> FloatArray:
    """(B,) least distance of two boats [m]."""
    least = np.full(len(x), np.inf)
    for i in range(x.shape[1]):
        for j in range(i):
            least = np.minimum(least, ops.hypot(x[:, i] - x[:, j], y[:, i] - y[:, j]))
    return least


def crossing(cases: int | IntArray, seed: int, boats: int = 8, family: str = "crossing", **given: Any) -> Scenarios:
    """Straight paths of random heading and speed 0.7-1.5 m/s that meet near one point within 3 s and 3 m.

    Without avoidance 65 % of the pairs would collide, least separation 1.8 m in the median.
    """
    case = cases_of(cases)
    shape = (len(case), boats)
    chi, speed, x, y = np.zeros(shape), np.ones(shape), np.zeros(shape), np.zeros(shape)
    left = np.arange(len(case))
    for attempt in range(200):
        draw = Draw(seed, case[left], boats, attempt)
        new_chi = draw.per_boat(-np.pi, np.pi)
        new_speed = draw.per_boat(0.7, 1.5)
        before = new_speed * (MEET_S + draw.per_boat(-NEAR_S, NEAR_S))
        aside = draw.per_boat(-NEAR_M, NEAR_M)
        s, c = ops.sincos(new_chi)
        chi[left], speed[left] = new_chi, new_speed
        x[left], y[left] = -before * c - aside * s, aside * c - before * s
        left = left[_nearest(x[left], y[left]) <= APART_M]
        if not len(left):
            break
    s, c = ops.sincos(chi)
    goal_m = 2.0 * MEET_S * speed
    paths, path = lines(x, y, c, s, LONG_M)
    return assemble(family, seed, case, paths, path, x, y, chi, cruise=speed, goal_m=goal_m, **given)


def two_boat(cases: int | IntArray, seed: int, **given: Any) -> Scenarios:
    """Two boats from all round: head-on, crossing, overtaking."""
    return crossing(cases, seed, 2, "two-boat", **given)


def four(cases: int | IntArray, seed: int, **given: Any) -> Scenarios:
    """Four boats that meet near one point."""
    return crossing(cases, seed, 4, "four", **given)


def circle_radius(boats: int) -> float:
    """40 m up to four boats, 50 m to eight, then 4.5 m per boat; 70 m for 16, as in the yardstick [m]."""
    if boats == 16:
        return 70.0
    return 40.0 if boats <= 4 else 50.0 if boats <= 8 else 4.5 * boats


def antipodal(cases: int | IntArray, seed: int, boats: int = 8, radius: float | None = None, **given: Any) -> Scenarios:
    """Boats on a circle, each bound for the opposite point at about 1 m/s; small perturbations."""
    case = cases_of(cases)
    r = circle_radius(boats) if radius is None else radius
    draw = Draw(seed, case, boats)
    place = np.arange(boats) * (2.0 * np.pi / boats) + draw.per_boat(-0.05, 0.05)
    chi = ops.wrap(place + np.pi)
    s, c = ops.sincos(place)
    x = r * c + draw.per_boat(-1.0, 1.0)
    y = r * s + draw.per_boat(-1.0, 1.0)
    speed = draw.per_boat(0.95, 1.05)
    s, c = ops.sincos(chi)
    paths, path = lines(x, y, c, s, LONG_M)
    return assemble("antipodal", seed, case, paths, path, x, y, chi, cruise=speed, goal_m=2.0 * r, **given)


def _column(case: IntArray, boats: int, spacing: FloatArray, draw: Draw, along: float, across: float) -> dict[str, Any]:
    """Boats in column on one path to the north, the first one ahead, a little off their places."""
    place = np.arange(boats - 1, -1, -1.0) * spacing[:, None]
    s = place + draw.per_boat(-along, along)
    y = draw.per_boat(-across, across)
    psi = draw.per_boat(-0.2, 0.2)
    path = np.zeros((len(case), boats), dtype=np.intp)
    return {"path": path, "x": s, "y": y, "psi": psi, "s": s, "offset": place, "member": 1.0}


def _water(draw: Draw, most: float) -> dict[str, FloatArray]:
    """A current of up to `most` m/s from anywhere."""
    speed, toward = draw.per_scenario(0.0, most), draw.per_scenario(-np.pi, np.pi)
    s, c = ops.sincos(toward)
    return {"current_n": speed * c, "current_e": speed * s}


def swap(
    cases: int | IntArray, seed: int, boats: int = 2, limit_s: float | None = None, current: float = 0.3, **given: Any
) -> Scenarios:
    """Overtaking: a column whose spacing goes from +D to -D after 30 s; random starts, speeds and currents."""
    case = cases_of(cases)
    draw = Draw(seed, case, boats)
    spacing = draw.per_scenario(15.0, 25.0) if boats == 2 else draw.per_scenario(13.0, 17.0)
    start = _column(case, boats, spacing, draw, 4.0, 4.0)
    cruise = np.repeat(draw.per_scenario(0.9, 1.1)[:, None], boats, axis=1)
    u = cruise * draw.per_boat(0.8, 1.2)
    slots = np.arange(boats - 1, -1, -1.0)
    change = Change(
        at_s=np.full(len(case), 30.0),
        goal=np.full(cruise.shape, float(Goal.FOLLOW)),
        offset=-slots * spacing[:, None],
        cruise=cruise,
    )
    path = straight((0.0, 0.0), (LONG_M, 0.0))
    time_s = limit_s if limit_s is not None else 30.0 + (270.0 if boats == 2 else 800.0)
    return assemble(
        "swap", seed, case, (path,), start.pop("path"), start.pop("x"), start.pop("y"), start.pop("psi"),
        cruise=cruise, u=u, u_min=0.7, u_max=1.3, limit_s=time_s, measure_s=30.0, changes=(change,),
        **{**start, **_water(draw, current), **given},
    )  # fmt: skip


def lossy(
    cases: int | IntArray,
    seed: int,
    boats: int = 5,
    loss: float | FloatArray = 0.3,
    delay_s: float | FloatArray = 0.5,
    limit_s: float = 300.0,
    **given: Any,
) -> Scenarios:
    """A column of 15 m that opens to 20 m after 100 s and closes again after 200 s, through loss and delay."""
    case = cases_of(cases)
    draw = Draw(seed, case, boats)
    start = _column(case, boats, np.full(len(case), 15.0), draw, 4.0, 4.0)
    shape = start["x"].shape
    slots = np.arange(boats - 1, -1, -1.0)
    changes = tuple(
        Change(
            at_s=np.full(len(case), at_s),
            goal=np.full(shape, float(Goal.FOLLOW)),
            offset=np.broadcast_to(slots * spacing, shape).copy(),
            cruise=np.ones(shape),
        )
        for at_s, spacing in ((100.0, 20.0), (200.0, 15.0))
    )
    path = straight((0.0, 0.0), (LONG_M, 0.0))
    return assemble(
        "lossy", seed, case, (path,), start.pop("path"), start.pop("x"), start.pop("y"), start.pop("psi"),
        u_min=0.7, u_max=1.3, limit_s=limit_s, measure_s=30.0, changes=changes, loss=loss, delay_s=delay_s,
        **{**start, **_water(draw, 0.2), **given},
    )  # fmt: skip


FAMILIES: dict[str, Callable[..., Scenarios]] = {
    "two-boat": two_boat,
    "four": four,
    "crossing": crossing,
    "antipodal": antipodal,
    "swap": swap,
    "lossy": lossy,
}
"""Generators by name: (cases, seed, ...) -> Scenarios."""
