"""Can a formation be sailed? Asked of a mission before launch, and of every change while it sails."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import combinations, pairwise

from msgspec import Struct

from fleet.mission.model import Mission
from fleet.mission.plan import BoatPlan, Plan

BETWEEN_SLOTS_M = 2.0  # beyond R: room for the ripples of a formation that corrects itself
CRUISE_MARGIN_MPS = 0.1  # what a boat needs above and below cruise to correct its place
SAMPLES = 300  # places looked at along paths that several boats do not share


class Misfit(Struct, frozen=True):
    """Why a formation cannot be sailed."""

    key: str
    """`spacing_m` or `cruise_mps`: the value that would have to change."""
    text: str


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
    spacing_m: float,
    cruise_mps: float,
    abscissas: Mapping[str, float] | None = None,
    sigma_m: float | None = None,
) -> list[str]:
    """Reasons why the fleet cannot sail with this spacing and cruise speed; empty if it can.

    Args:
        plan: the mission under way
        spacing_m: metres from slot to slot, + ahead; its sign may differ from the present one
        cruise_mps: speed of the formation
        abscissas: where the boats are on their paths, laps counted [m]; None: not asked whether places are off the path
        sigma_m: 1-sigma position error per axis; None: that of the mission's environment
    """
    words = {"spacing_m": f"spacing {spacing_m:g} m", "cruise_mps": f"cruise {cruise_mps:g} m/s"}
    found = [*cruise_misfits(plan, cruise_mps), *spacing_misfits(plan, spacing_m, abscissas, sigma_m)]
    return [f"{words[misfit.key]}: {misfit.text}" for misfit in found]


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


def spacing_misfits(
    plan: Plan, spacing_m: float, abscissas: Mapping[str, float] | None = None, sigma_m: float | None = None
) -> Iterator[Misfit]:
    """Slots too near each other, formations longer than their paths, places off the path."""
    if not math.isfinite(spacing_m):
        yield Misfit("spacing_m", "expected a number")
        return
    need = gap_needed(plan.mission, sigma_m)
    for name in plan.paths:
        yield from _same_path(plan, name, spacing_m, need)
    for near in near_places(plan, spacing_m, need):
        if near.share > 0.5:
            yield Misfit(
                "spacing_m",
                f"the places of {near.first} and {near.second} are {near.least_m:.1f} m apart for most of the way; "
                f"at least {need:.1f} m",
            )
    yield from _ends(plan, spacing_m, abscissas)


def near_places(plan: Plan, spacing_m: float, need: float, *, shared: bool = False) -> Iterator[Nearness]:
    """Pairs of boats whose places in the formation come nearer than `need`; on a shared path only if `shared`."""
    if len(plan.boats) < 2 or not (shared or len({boat.path_name for boat in plan.boats}) > 1):
        return
    tracks = {boat.name: _places(plan, boat, spacing_m) for boat in plan.boats}
    for one, two in combinations(plan.boats, 2):
        if one.path_name == two.path_name and not shared:
            continue
        near = _nearest(tracks[one.name], tracks[two.name], need)
        if near is not None:
            least, at, share = near
            yield Nearness(first=one.name, second=two.name, least_m=least, s_m=at, share=share)


def smallest_gap(plan: Plan, spacing_m: float) -> float:
    """Least distance between slots that share a path [m]; infinite if none do."""
    return min((gap for name in plan.paths for _, _, gap in _gaps(plan, name, spacing_m)), default=math.inf)


def _gaps(plan: Plan, path_name: str, spacing_m: float) -> Iterator[tuple[BoatPlan, BoatPlan, float]]:
    """Neighbours on one path and the metres of path between their places."""
    boats = sorted((b for b in plan.boats if b.path_name == path_name), key=lambda b: b.slot * spacing_m)
    path = plan.paths[path_name]
    if path.closed and len(boats) > 1:  # round the lap the last one is behind the first
        boats.sort(key=lambda b: b.slot * spacing_m % path.length)
        for one, two in list(zip(boats, (*boats[1:], boats[0]), strict=True))[: 1 if len(boats) == 2 else None]:
            yield one, two, min(d := (two.slot - one.slot) * spacing_m % path.length, path.length - d)
        return
    for one, two in pairwise(boats):
        yield one, two, abs((two.slot - one.slot) * spacing_m)


def _same_path(plan: Plan, path_name: str, spacing_m: float, need: float) -> Iterator[Misfit]:
    """Slots too near each other on one path: the worst pair, and how many more. Equal slots are named by `check`."""
    gaps = _gaps(plan, path_name, spacing_m)
    close = [(gap, one, two) for one, two, gap in gaps if gap < need - 1e-9 and one.slot != two.slot]
    if close:
        gap, one, two = min(close, key=lambda item: item[0])
        more = f" (and {len(close) - 1} more)" if len(close) > 1 else ""
        first, second = sorted((one.name, two.name))
        text = f"{first} and {second} are {gap:.1f} m apart on path {path_name}{more}; at least {need:.1f} m"
        yield Misfit("spacing_m", text)


def _ends(plan: Plan, spacing_m: float, abscissas: Mapping[str, float] | None) -> Iterator[Misfit]:
    """Formations longer than the paths, and places beyond their ends."""
    lines = [boat for boat in plan.boats if not boat.path.closed]
    if not lines:
        return
    first = max(lines, key=lambda b: -b.slot * spacing_m)
    last = min(lines, key=lambda b: b.path.length - b.slot * spacing_m)
    room = (last.path.length - last.slot * spacing_m) + first.slot * spacing_m
    if room <= 0.0:
        long = (last.slot - first.slot) * spacing_m
        text = f"from {first.name} to {last.name} the formation is {long:.0f} m long"
        yield Misfit("spacing_m", f"{text}, path {last.path_name} only {last.path.length:.0f} m")
        return
    if not abscissas:
        return
    here = [boat for boat in plan.boats if boat.name in abscissas]
    reference = sum(abscissas[b.name] - b.slot * spacing_m for b in here) / max(len(here), 1)
    for boat in here:
        place = reference + boat.slot * spacing_m
        if not boat.path.closed and not 0.0 <= place <= boat.path.length:
            text = f"the place of {boat.name} would be at {place:.0f} m of path {boat.path_name}"
            yield Misfit("spacing_m", f"{text}, which goes from 0 to {boat.path.length:.0f} m")


Track = list[tuple[float, float, float] | None]


def _places(plan: Plan, boat: BoatPlan, spacing_m: float) -> Track:
    """Where one boat's place is while the formation goes by: (s, x, y), or None off the path's ends."""
    low, high = _span(plan, spacing_m)
    track: Track = []
    for i in range(SAMPLES + 1):
        s = low + (high - low) * i / SAMPLES + boat.slot * spacing_m
        if boat.path.closed:
            s %= boat.path.length
        if 0.0 <= s <= boat.path.length:
            point = boat.path.at(s)
            track.append((s, point.x, point.y))
        else:
            track.append(None)
    return track


def _span(plan: Plan, spacing_m: float) -> tuple[float, float]:
    """First and last abscissa of slot 0 at which the formation is on its paths."""
    lines = [boat for boat in plan.boats if not boat.path.closed]
    if not lines:
        return 0.0, 2.0 * max(boat.path.length for boat in plan.boats)
    low = min(-boat.slot * spacing_m for boat in lines)
    return low, max(boat.path.length - boat.slot * spacing_m for boat in lines)


def _nearest(one: Track, two: Track, need: float) -> tuple[float, float, float] | None:
    """(least distance, abscissa of the first, share of the common way that is too near), or None."""
    pairs = [(math.hypot(a[1] - b[1], a[2] - b[2]), a[0]) for a, b in zip(one, two, strict=True) if a and b]
    close = [pair for pair in pairs if pair[0] < need - 1e-6]
    if not close:
        return None
    least, at = min(close)
    return least, at, len(close) / len(pairs)
