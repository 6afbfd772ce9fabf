"""Can a formation be sailed? Asked of a mission before launch, and of every change while it sails."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import combinations, pairwise

from msgspec import Struct

from fleet.mission.lanes import lane_misfits
from fleet.mission.misfit import CRUISE_MARGIN_MPS, Misfit
from fleet.mission.model import Mission
from fleet.mission.pattern import PATTERNS, Shape
from fleet.mission.plan import BoatPlan, Plan
from fleet.mission.redraw import redrawing
from fleet.mission.wingman import wingman_misfits

BETWEEN_SLOTS_M = 2.0  # beyond R: room for the ripples of a formation that corrects itself
SAMPLES = 300  # places looked at along paths that several boats do not share


class Nearness(Struct, frozen=True):
    """Two boats whose places come nearer to each other than slots may be."""

    first: str
    second: str
    least_m: float
    s_m: float
    """Abscissa of the first one's place, where they are nearest."""
    share: float
    """Part of their common way on which they are too near."""


def check_formation(
    plan: Plan,
    shape: Shape,
    abscissas: Mapping[str, float] | None = None,
    sigma_m: float | None = None,
    before: Shape | None = None,
) -> list[str]:
    """Reasons why the fleet cannot sail so; empty if it can.

    Args:
        plan: the mission under way
        shape: what is asked for
        abscissas: where the boats are on their paths, laps counted [m]; None: not asked whether places are off the path
        sigma_m: 1-sigma position error per axis; None: that of the mission's environment
        before: the formation until then; None: not asked whether there is path enough for the change
    """
    words = {
        "spacing_m": f"spacing {shape.spacing_m:g} m",
        "cruise_mps": f"cruise {shape.cruise_mps:g} m/s",
        "lateral_m": f"lateral {shape.lateral_m:g} m",
        "pattern": f"pattern {shape.pattern}",
        "slots": "slots",
    }
    return [f"{words[misfit.key]}: {misfit.text}" for misfit in misfits(plan, shape, abscissas, sigma_m, before)]


def misfits(
    plan: Plan,
    shape: Shape,
    abscissas: Mapping[str, float] | None = None,
    sigma_m: float | None = None,
    before: Shape | None = None,
) -> Iterator[Misfit]:
    """Why a formation cannot be sailed: see `check_formation`."""
    yield from cruise_misfits(plan, shape.cruise_mps)
    yield from place_misfits(plan, shape, abscissas, sigma_m, before)


def gap_needed(mission: Mission, sigma_m: float | None = None) -> float:
    """Least distance between two slots [m]: R + 2, or R + 0.5 and the margin for two position errors."""
    if sigma_m is None:
        sigma_m = math.hypot(mission.environment.gnss_sigma_m, mission.environment.gnss_white_m)
    radius = mission.keeping_clear.radius_m
    return max(radius + BETWEEN_SLOTS_M, radius + 0.5 + 2.0 * math.sqrt(2.0) * sigma_m)


def cruise_misfits(plan: Plan, cruise_mps: float) -> Iterator[Misfit]:
    """The boats that could not correct their places at this cruise speed, those with equal limits together."""
    unable: dict[tuple[float, float], list[str]] = {}
    for boat in plan.boats:
        low = boat.limits.speed_min_mps + CRUISE_MARGIN_MPS
        high = boat.limits.speed_max_mps - CRUISE_MARGIN_MPS
        if low <= high + 1e-9 and not low - 1e-9 <= cruise_mps <= high + 1e-9:
            unable.setdefault((low, high), []).append(boat.name)
    for (low, high), names in unable.items():
        more = f" (and {len(names) - 1} more)" if len(names) > 1 else ""
        yield Misfit("cruise_mps", f"{names[0]}{more} needs {low:g} to {high:g} m/s to keep its place")


def place_misfits(
    plan: Plan,
    shape: Shape,
    abscissas: Mapping[str, float] | None = None,
    sigma_m: float | None = None,
    before: Shape | None = None,
) -> Iterator[Misfit]:
    """Slots too near each other, formations longer than their paths, places off the path, lanes nobody can sail."""
    for key, value in (("spacing_m", shape.spacing_m), ("lateral_m", shape.lateral_m)):
        if not math.isfinite(value):
            yield Misfit(key, "expected a number")
            return
    need = gap_needed(plan.mission, sigma_m)
    if shape.pattern == "wingman":
        yield from wingman_misfits(plan, shape, need)
        return
    if PATTERNS[shape.pattern].lateral and len({boat.path_name for boat in plan.boats}) > 1:
        one, two = next((a, b) for a, b in combinations(plan.boats, 2) if a.path_name != b.path_name)
        where = f"{one.name} sails path {one.path_name}, {two.name} path {two.path_name}"
        yield Misfit("pattern", f"{where}; expected one path for all")
        return
    for name in plan.paths:
        yield from _same_path(plan, name, shape, need)
    for near in near_places(plan, shape, need):
        if near.share > 0.5:
            yield Misfit(
                "spacing_m",
                f"the places of {near.first} and {near.second} are {near.least_m:.1f} m apart for most of the way; "
                f"at least {need:.1f} m",
            )
    yield from lane_misfits(plan, shape)
    yield from _ends(plan, shape, abscissas)
    if before is not None and abscissas:
        yield from _change(plan, before, shape, abscissas, need)


def near_places(plan: Plan, shape: Shape, need: float, *, shared: bool = False) -> Iterator[Nearness]:
    """Pairs of boats whose places in the formation come nearer than `need`; on a shared path only if `shared`."""
    if len(plan.boats) < 2 or not (shared or len({boat.path_name for boat in plan.boats}) > 1):
        return
    tracks = {boat.name: _places(plan, boat, shape) for boat in plan.boats}
    for one, two in combinations(plan.boats, 2):
        if one.path_name == two.path_name and not shared:
            continue
        near = _nearest(tracks[one.name], tracks[two.name], need)
        if near is not None:
            least, at, share = near
            yield Nearness(first=one.name, second=two.name, least_m=least, s_m=at, share=share)


def smallest_gap(plan: Plan, shape: Shape) -> float:
    """Least distance between slots that share a path [m]; infinite if none do."""
    if shape.pattern == "wingman":
        return math.inf
    return min((gap for name in plan.paths for _, _, gap in _gaps(plan, name, shape)), default=math.inf)


def _gaps(plan: Plan, path_name: str, shape: Shape) -> Iterator[tuple[BoatPlan, BoatPlan, float]]:
    """Neighbours on one path, and the metres between their places where it is straight."""
    boats = sorted((b for b in plan.boats if b.path_name == path_name), key=lambda b: shape.place(b.number))
    if PATTERNS[shape.pattern].lateral:
        yield from _gaps_abeam(boats, shape)
        return
    path = plan.paths[path_name]
    if path.closed and len(boats) > 1:  # round the lap the last one is behind the first
        boats.sort(key=lambda b: shape.ahead(b.number) % path.length)
        for one, two in list(zip(boats, (*boats[1:], boats[0]), strict=True))[: 1 if len(boats) == 2 else None]:
            d = (shape.ahead(two.number) - shape.ahead(one.number)) % path.length
            yield one, two, min(d, path.length - d)
        return
    for one, two in pairwise(boats):
        yield one, two, abs(shape.ahead(two.number) - shape.ahead(one.number))


def _gaps_abeam(boats: list[BoatPlan], shape: Shape) -> Iterator[tuple[BoatPlan, BoatPlan, float]]:
    """Each boat and the nearest of those before it."""
    for i, two in enumerate(boats):
        x, y = shape.place(two.number)
        apart = [(math.hypot(x - a, y - b), j) for j, (a, b) in enumerate(shape.place(o.number) for o in boats[:i])]
        if apart:
            gap, j = min(apart)
            yield boats[j], two, gap


def _same_path(plan: Plan, path_name: str, shape: Shape, need: float) -> Iterator[Misfit]:
    """Slots too near each other on one path: the worst pair, and how many more; or one slot for two boats."""
    gaps = list(_gaps(plan, path_name, shape))
    for gap, one, two in ((g, a, b) for a, b, g in gaps):
        if gap == 0.0 and shape.slots[one.number] == shape.slots[two.number]:
            text = f"{one.name} and {two.name} both have slot {shape.slots[one.number]:g} on path {path_name}"
            yield Misfit("slots", text)
            return
    close = [(gap, one, two) for one, two, gap in gaps if gap < need - 1e-9]
    if close:
        gap, one, two = min(close, key=lambda item: item[0])
        more = f" (and {len(close) - 1} more)" if len(close) > 1 else ""
        first, second = sorted((one.name, two.name))
        text = f"{first} and {second} are {gap:.1f} m apart on path {path_name}{more}; at least {need:.1f} m"
        yield Misfit("lateral_m" if shape.pattern == "abreast" else "spacing_m", text)


def _ends(plan: Plan, shape: Shape, abscissas: Mapping[str, float] | None) -> Iterator[Misfit]:
    """Formations longer than the paths, and places beyond their ends."""
    lines = [boat for boat in plan.boats if not boat.path.closed]
    if not lines:
        return
    first = max(lines, key=lambda b: -shape.ahead(b.number))
    last = min(lines, key=lambda b: b.path.length - shape.ahead(b.number))
    room = (last.path.length - shape.ahead(last.number)) + shape.ahead(first.number)
    if room <= 0.0:
        long = shape.ahead(last.number) - shape.ahead(first.number)
        text = f"from {first.name} to {last.name} the formation is {long:.0f} m long"
        yield Misfit("spacing_m", f"{text}, path {last.path_name} only {last.path.length:.0f} m")
        return
    if not abscissas:
        return
    here = [boat for boat in plan.boats if boat.name in abscissas]
    reference = sum(abscissas[b.name] - shape.ahead(b.number) for b in here) / max(len(here), 1)
    for boat in here:
        place = reference + shape.ahead(boat.number)
        if not boat.path.closed and not 0.0 <= place <= boat.path.length:
            text = f"the place of {boat.name} would be at {place:.0f} m of path {boat.path_name}"
            yield Misfit("spacing_m", f"{text}, which goes from 0 to {boat.path.length:.0f} m")


def _change(plan: Plan, before: Shape, after: Shape, abscissas: Mapping[str, float], need: float) -> Iterator[Misfit]:
    """A change of lanes for which too little path is left."""
    here = [before.place(boat.number) for boat in plan.boats]
    change = redrawing(here, after, plan.boats, need)
    lines = [boat for boat in plan.boats if not boat.path.closed and boat.name in abscissas]
    if change is None or not lines:
        return
    boat = min(lines, key=lambda b: b.path.length - abscissas[b.name])
    left, way = boat.path.length - abscissas[boat.name], change.duration_s * after.cruise_mps
    if left < way:
        text = f"changing lanes takes {change.duration_s:.0f} s, {way:.0f} m of path"
        yield Misfit("pattern", f"{text}; {boat.name} has {max(left, 0.0):.0f} m of path {boat.path_name} left")


Track = list[tuple[float, float, float] | None]


def _places(plan: Plan, boat: BoatPlan, shape: Shape) -> Track:
    """Where one boat's place is while the formation goes by: (s, x, y), or None off the path's ends."""
    low, high = _span(plan, shape)
    lane, ahead = boat.lane(shape), shape.ahead(boat.number)
    track: Track = []
    for i in range(SAMPLES + 1):
        s = low + (high - low) * i / SAMPLES + ahead
        if boat.path.closed:
            s %= boat.path.length
        if 0.0 <= s <= boat.path.length:
            point = lane.at(s)
            track.append((s, point.x, point.y))
        else:
            track.append(None)
    return track


def _span(plan: Plan, shape: Shape) -> tuple[float, float]:
    """First and last abscissa of slot 0 at which the formation is on its paths."""
    lines = [boat for boat in plan.boats if not boat.path.closed]
    if not lines:
        return 0.0, 2.0 * max(boat.path.length for boat in plan.boats)
    low = min(-shape.ahead(boat.number) for boat in lines)
    return low, max(boat.path.length - shape.ahead(boat.number) for boat in lines)


def _nearest(one: Track, two: Track, need: float) -> tuple[float, float, float] | None:
    """(least distance, abscissa of the first, share of the common way that is too near), or None."""
    pairs = [(math.hypot(a[1] - b[1], a[2] - b[2]), a[0]) for a, b in zip(one, two, strict=True) if a and b]
    close = [pair for pair in pairs if pair[0] < need - 1e-6]
    if not close:
        return None
    least, at = min(close)
    return least, at, len(close) / len(pairs)
