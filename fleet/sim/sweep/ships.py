"""Scenarios with foreign vessels from a family: every number drawn as in other families, sailed by `batch.ships`."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Sequence

import numpy as np

from fleet.avoidance.foreign import Edge
from fleet.ops import FloatArray
from fleet.paths import PathPoint
from fleet.sim.batch.ships import Bend, Ship, ShipCase
from fleet.sim.batch.ships_cases import IMAZU, NEAR_EQUAL_MPS, SLOW_AHEAD, c0
from fleet.sim.batch.ships_judge import judge
from fleet.sim.batch.ships_radio import Radio
from fleet.sim.batch.ships_sail import sail
from fleet.sim.sweep.distributions import Draw, Drawn, Spread, radians, support
from fleet.sim.sweep.model import Imazu, Spec, Vessels
from fleet.sim.sweep.ships_results import ShipResults, gathered

ATTEMPTS = 1000
LONG_M = 1.0e4
SHOAL_EDGES = 6
MOST_VESSELS = 8
EVENLY = Spread(even=(0.0, 1.0))


def foreign(spec: Spec) -> bool:
    """Whether a family is one of foreign vessels."""
    return isinstance(spec.layout, Vessels | Imazu)


def ship_cases(name: str, spec: Spec, seed: int, cases: Sequence[int]) -> Iterator[ShipCase]:
    """Some cases of a seed; each is the same with whichever others it is drawn."""
    for case in cases:
        layout = spec.layout
        assert isinstance(layout, Vessels | Imazu)
        draw = Draw(seed, np.array([case]), MOST_VESSELS)
        cruise = _one(draw, layout.cruise_mps if spec.formation is None else spec.formation.cruise_mps)
        spacing = 0.0 if spec.formation is None else _one(draw, spec.formation.spacing_m)
        abreast = isinstance(layout, Vessels) and _one(draw, layout.abreast) >= 0.5
        paths = tuple(
            (0.0, spacing * i, 0.0) if abreast else (spacing * i, 0.0, spacing * i) for i in range(spec.boats)
        )
        current, toward = _one(draw, spec.environment.current_mps), _one(draw, spec.environment.current_toward_deg)
        radio = Radio(delay_s=_one(draw, spec.radio.delay_s), loss=_one(draw, spec.radio.loss))
        alone = ShipCase(
            suite=name, seed=seed, case=int(case), cruise=cruise, paths=paths, ships=(), meet_s=0.0,
            limit_s=60.0 + 3.0 * support(layout.meet_s)[1], hull=spec.hull, limits=spec.limits, radio=radio,
            radius_m=spec.keeping_clear.radius_m,
            current=(current * math.cos(math.radians(toward)), current * math.sin(math.radians(toward))),
        )  # fmt: skip
        if spec.duration_s is not None:
            alone = _with(alone, limit_s=spec.duration_s)
        yield _imazu(alone, layout) if isinstance(layout, Imazu) else _vessels(alone, layout, spec, draw)


def sail_part(name: str, spec: Spec, seed: int, cases: Sequence[int]) -> ShipResults:
    """Sail and judge some cases, one after the other."""
    began = time.perf_counter()
    sailed = [(case, sail(case)) for case in ship_cases(name, spec, seed, cases)]
    outcomes = [judge(case, voyage) for case, voyage in sailed]
    ticks = sum(voyage.x.size for _, voyage in sailed)
    return gathered(name, seed, spec, outcomes, ticks, time.perf_counter() - began)


def _with(case: ShipCase, **more: object) -> ShipCase:
    from msgspec import structs

    return structs.replace(case, **more)


def _one(draw: Draw, value: Drawn) -> float:
    """A number of the case."""
    return float(draw.per_scenario(value)[0])


def _vessels(alone: ShipCase, layout: Vessels, spec: Spec, draw: Draw) -> ShipCase:
    """So many vessels, each meeting the boats at a time of its own; shore and shoal."""
    number = min(max(int(_one(draw, layout.vessels)), 1), MOST_VESSELS)
    turn = math.radians(_one(draw, layout.bend_deg))
    meet = draw.per_boat(layout.meet_s)[0, :number]
    meet_s = float(meet.max())
    if turn != 0.0:
        alone = _with(alone, bend=Bend(at_m=alone.cruise * (meet_s - layout.bend_before_s), turn=turn))
    path = alone.path()
    where = [path.at(alone.cruise * float(t)) for t in meet]
    shares = draw.per_boat(EVENLY)[0]
    if layout.crossing_deg is not None:
        alone = _crossing(alone, layout, spec.boats, float(meet[0]), draw)
    ships = []
    for k, point in enumerate(where):
        word = ("ais" if shares[k] < 0.5 else "positions") if layout.sensor == "mixed" else layout.sensor
        ships.append(_meeting(alone, layout, k, float(meet[k]), point, word, draw.used))
    edges: tuple[Edge, ...] = ()
    if layout.bank_m is not None:
        edges = ((-LONG_M, layout.bank_m, LONG_M, layout.bank_m),)
    if layout.shoal_m > 0.0:
        aside = _one(draw, layout.shoal_aside_m)
        middle = path.at(alone.cruise * meet_s)
        edges = (*edges, *_shoal(middle.x - aside * middle.ty, middle.y + aside * middle.tx, layout.shoal_m))
    return _with(alone, ships=tuple(ships), meet_s=meet_s, edges=edges)


def _crossing(alone: ShipCase, layout: Vessels, boats: int, meet_s: float, draw: Draw) -> ShipCase:
    """Boats that sail each alone, through the place where the first one would meet the first vessel."""
    assert layout.crossing_deg is not None
    chi = draw.per_boat(radians(layout.crossing_deg))[0, :boats]
    late = draw.per_boat(layout.crossing_late_s)[0, :boats]
    chi[0], late[0] = 0.0, 0.0
    back = alone.cruise * (meet_s + late)
    north, east = alone.cruise * meet_s - back * np.cos(chi), -back * np.sin(chi)
    paths = tuple((x, y, 0.0) for x, y in zip(north.tolist(), east.tolist(), strict=True))
    return _with(alone, paths=paths, courses=tuple(chi.tolist()))


def _meeting(
    alone: ShipCase, layout: Vessels, k: int, meet_s: float, point: PathPoint[float], sensor: str, used: int
) -> Ship:
    """Vessel k, drawn again until it is not almost as fast on the same course: it would never come by."""
    for attempt in range(ATTEMPTS):
        draw = Draw(alone.seed, np.array([alone.case]), k + 1, attempt, used)

        def mine(value: Drawn, draw: Draw = draw) -> float:
            numbers: FloatArray = draw.per_boat(value)
            return float(numbers[0, k])

        length, U, chi = mine(layout.length_m), mine(layout.speed_mps), mine(radians(layout.course_deg))
        miss = mine(layout.miss) * c0(length)
        if mine(EVENLY) < mine(layout.opposite):
            chi += math.pi
        before, turn, rate = mine(layout.turn_before_s), mine(layout.turn_deg), mine(layout.turn_rate_radps)
        turn *= 1.0 if mine(EVENLY) < 0.5 else -1.0
        vx, vy = U * math.cos(chi), U * math.sin(chi)
        wx, wy = alone.cruise * point.tx - vx, alone.cruise * point.ty - vy
        w = math.hypot(wx, wy)
        if w >= NEAR_EQUAL_MPS or attempt == ATTEMPTS - 1:
            break
    w = max(w, NEAR_EQUAL_MPS)
    return Ship(
        x=point.x - miss * wy / w - vx * meet_s,
        y=point.y + miss * wx / w - vy * meet_s,
        chi=chi,
        U=U,
        length=length,
        turns_s=meet_s - before if turn != 0.0 else math.inf,
        turn=math.radians(turn),
        rate=rate,
        sensor=sensor,
    )


def _shoal(x: float, y: float, radius: float) -> tuple[Edge, ...]:
    """A hexagon round a point."""
    corners = [
        (x + radius * math.cos(i * math.tau / SHOAL_EDGES), y + radius * math.sin(i * math.tau / SHOAL_EDGES))
        for i in range(SHOAL_EDGES)
    ]
    return tuple((*corners[i - 1], *corners[i]) for i in range(SHOAL_EDGES))


def _imazu(alone: ShipCase, layout: Imazu) -> ShipCase:
    """One of Imazu's 22 geometries; a vessel ahead on our course has half our speed, the others `multiple` times it."""
    ships = []
    for k, degrees in enumerate(IMAZU[layout.geometry - 1]):
        U = alone.cruise * (SLOW_AHEAD if degrees == 0 else layout.multiple)
        chi = math.radians(degrees)
        x, y = layout.meet_s * (alone.cruise - U * math.cos(chi)), -layout.meet_s * U * math.sin(chi)
        share = Draw(alone.seed, np.array([alone.case]), k + 1).per_boat(EVENLY)[0, k]
        word = ("ais" if share < 0.5 else "positions") if layout.sensor == "mixed" else layout.sensor
        ships.append(Ship(x=x, y=y, chi=chi, U=U, length=layout.length_m, sensor=word))
    return _with(alone, ships=tuple(ships), meet_s=layout.meet_s)
