"""A scenario alone, on floats, and as one lane of a batch: the same bits, tick by tick."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from fleet.agent.step import StepParams
from fleet.avoidance import METHODS
from fleet.guidance import FollowParams, StationParams
from fleet.paths import polyline, sine
from fleet.sim.batch import Scenarios, run
from fleet.sim.batch.block import Rules
from fleet.sim.batch.families import antipodal, crossing, lossy, swap, two_boat
from fleet.sim.batch.lanes import BatchSea, table_of
from fleet.sim.batch.lone import LoneSea
from fleet.sim.batch.mail import delay_ticks
from fleet.sim.batch.results import PER_BOAT, PER_SCENARIO
from fleet.sim.sweep.family import load


def rules_of(scenarios: Scenarios, method: str, **given: Any) -> Rules:
    params = StepParams(
        follow=FollowParams(),
        station=StationParams(),
        limits=scenarios.limits,
        keep=METHODS[method].params(6.0, "closest"),
    )
    return Rules(
        method=METHODS[method],
        params=params,
        hulls=scenarios.hulls,
        radius_m=6.0,
        formations=int(scenarios.member.max()),
        clock_error_s=scenarios.clock_error_s,
        gnss_sigma_m=scenarios.gnss_sigma_m,
        gnss_white_m=scenarios.gnss_white_m,
        gnss_velocity_mps=scenarios.gnss_velocity_mps,
        **given,
    )


def numbers(value: Any) -> list[Any]:
    """All values of a Struct or tuple, in order."""
    if isinstance(value, msgspec.Struct):
        return [v for field in msgspec.structs.astuple(value) for v in numbers(field)]
    if isinstance(value, tuple):
        return [v for field in value for v in numbers(field)]
    return [] if value is None else [value]


def lanes_of(sea: BatchSea | LoneSea, column: int) -> np.ndarray:
    """Everything that the boats of one scenario decided, remember and are: (value, boat)."""
    rows = []
    if isinstance(sea, BatchSea):
        block = sea.blocks[0]
        for value in numbers((block.decision, block.state, block.hull, block.weights, sea.tallies[0])):
            full = np.broadcast_to(value, block.hull.x.shape)
            rows.append(full.reshape(sea.scenarios.boats, -1)[:, column])
        return np.array(rows)
    for block, counted in zip(sea.blocks, sea.tallies, strict=True):
        values = numbers((block.decision, block.state, block.hull, block.weights, counted))
        assert {type(v) for v in values} == {float}
        rows.append(values)
    return np.array(rows).T


def batch_sea(scenarios: Scenarios, rules: Rules) -> BatchSea:
    slots = int(delay_ticks(scenarios.delay_s).max()) + 1
    return BatchSea(scenarios, rules, np.arange(scenarios.count), table_of(scenarios), slots)


def changed(scenarios: Scenarios, **fields: Any) -> Scenarios:
    return msgspec.structs.replace(scenarios, **fields)


def bent(scenarios: Scenarios) -> Scenarios:
    """The same starts, on a sine and on a circuit."""
    paths = (
        sine((-60.0, 0.0), (400.0, 0.0), 12.0, 90.0),
        polyline([(-60.0, -20.0), (0.0, -20.0), (0.0, 30.0), (-60.0, 30.0)], 10.0, closed=True),
    )
    return changed(scenarios, paths=paths, path=np.broadcast_to(np.arange(scenarios.boats) % 2, scenarios.x.shape))


SEEN_TICKS = 700
CASES = {
    "two": (two_boat(12, 3), 5, 0),
    "two, otter, current, noise": (
        two_boat(12, 4, hulls=("otter",), current_n=0.2, current_e=-0.1, gnss_sigma_m=0.5, gnss_white_m=0.1), 7, 300
    ),
    "three on curves": (bent(antipodal(8, 5, 3, radius=20.0)), 2, 0),
    "three of two hulls, curved paths, velocity noise": (load("fleet", boats=3).scenarios(3, 0, range(8)), 3, 200),
    "two formations": (load("meeting", boats=4).scenarios(3, 0, range(6)), 2, 600),
    "eight": (crossing(6, 6, 8), 1, 500),
    "swap of three": (swap(6, 7, 3), 4, 0),
    "lossy column": (lossy(6, 8, 3, loss=np.array([0.0, 0.3, 0.5, 0.9, 0.95, 0.5]),
                           delay_s=np.array([0.0, 0.5, 2.0, 0.25, 0.0, 1.0]), clock_error_s=0.1), 4, 700),
    "lossy crossing, one deaf, one falls silent": (
        changed(crossing(6, 9, 3, loss=0.5, delay_s=0.4), mute_s=np.tile([np.inf, 50.0, np.inf], (6, 1)),
                avoids=np.tile([1.0, 1.0, 0.0], (6, 1))), 3, 450
    ),
}  # fmt: skip


@pytest.mark.parametrize("method", ["scoring", "circle"])
@pytest.mark.parametrize("name", CASES)
def test_a_lone_scenario_decides_and_remembers_as_in_the_batch(name: str, method: str) -> None:
    scenarios, column, skipped = CASES[name]
    rules = rules_of(scenarios, method)
    batch, lone = batch_sea(scenarios, rules), LoneSea(scenarios.part([column]), rules)
    avoided = 0.0
    for now in range(skipped + SEEN_TICKS if name != "eight" else 900):
        batch.tick(now)
        lone.tick(now)
        if now % 50 == 49:
            batch.check()
            lone.check()
        if now >= skipped and now % 7 == 0:
            one, many = lanes_of(lone, 0), lanes_of(batch, column)
            assert one.shape == many.shape
            assert np.array_equal(one, many), (now, np.argwhere(one != many)[:5])
        avoided += float(sum(b.decision.avoiding for b in lone.blocks if b.decision is not None))
    assert avoided > 0.0 or name in ("swap of three", "lossy column") or (name, method) == ("three on curves", "circle")


@pytest.mark.parametrize("method", ["scoring", "circle"])
def test_chunks_and_compaction_and_floats_change_no_result(method: str) -> None:
    scenarios = antipodal(14, 11, 2, radius=12.0, limit_s=60.0)
    whole = run(scenarios, method, floats=False, record=[4])
    pieces = run(scenarios, method, lanes=6, floats=False, record=[4])
    alone = run(scenarios.only(4), method, record=[4])
    for name in (*PER_SCENARIO, *PER_BOAT, "case"):
        assert np.array_equal(getattr(whole, name), getattr(pieces, name)), name
        assert np.array_equal(getattr(whole, name)[4:5], getattr(alone, name)), name
    for field in type(whole.traces[0]).__struct_fields__:
        a, b, c = (getattr(r.traces[0], field) for r in (whole, pieces, alone))
        assert np.array_equal(a, b), field
        assert np.array_equal(a, c), field
    assert alone.traces[0].x.shape == (round(alone.ended_s[0] / 0.1), 2)
