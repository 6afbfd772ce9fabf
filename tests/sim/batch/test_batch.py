"""Families, draws and what is counted."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from fleet.agent.modes import Goal
from fleet.agent.step import Decision, Order
from fleet.avoidance.circle import CircleParams
from fleet.paths import straight
from fleet.sim.batch import Change, Scenarios, assemble, run, tally
from fleet.sim.batch.draws import begin, more, normal, uniform
from fleet.sim.batch.families import FAMILIES, antipodal, crossing, lossy, swap, two_boat
from fleet.sim.batch.results import Results
from fleet.sim.batch.tally import formation_errors
from fleet.wire import radio

LIMIT_S = 150.0


def test_draws_are_those_of_the_radio_alone_and_in_lanes() -> None:
    parts = [3, 17, -1, 2**63 + 5, 0]
    h = 0
    for part in parts:
        h = more(h, part)
    assert h == radio.mix(*parts)
    assert uniform(h) == radio.uniform(*parts)
    cases = np.arange(50)
    lanes = more(begin(9, cases, 2), 77)
    alone = [radio.mix(9, case, 2, 77) for case in cases.tolist()]
    assert lanes.tolist() == alone
    assert uniform(lanes).tolist() == [uniform(h) for h in alone]
    assert normal(lanes, 10).tolist() == [normal(h, 10) for h in alone]


def test_normal_numbers_are_normal() -> None:
    values = normal(begin(1, np.arange(40_000)), 10)
    assert abs(values.mean()) < 0.02
    assert abs(values.std() - 1.0) < 0.01
    assert abs((values < 1.0).mean() - 0.8413) < 0.01


@pytest.mark.parametrize("family", FAMILIES)
def test_a_case_is_the_same_however_many_are_drawn(family: str) -> None:
    many, one = FAMILIES[family](9, 5), FAMILIES[family](np.array([6]), 5)
    only = many.only(6)
    assert [p.at(7.0) for p in one.paths] == [p.at(7.0) for p in only.paths]
    for name in ("x", "y", "psi", "u", "s", "cruise", "offset", "goal_m", "current_n", "limit_s"):
        assert np.array_equal(getattr(one, name), getattr(only, name)), name
    assert not np.array_equal(many.x, FAMILIES[family](9, 6).x)


def test_a_case_that_is_not_there_is_named() -> None:
    with pytest.raises(KeyError, match="two-boat has no case 7"):
        two_boat(3, 1).only(7)


def sailed(scenarios: Scenarios, method: str = "scoring", **given: Any) -> Results:
    return run(scenarios, method, floats=False, **given)


def test_the_yardstick_in_small() -> None:
    scoring = sailed(two_boat(60, 21))
    assert scoring.collided.sum() == 0
    assert scoring.standstill.sum() == 0
    assert 7.4 <= np.median(scoring.least_m) <= 7.8
    starboard = sailed(two_boat(60, 21), "circle", params=CircleParams(side="starboard"))
    assert starboard.collided.mean() <= 0.08
    assert 4.6 <= np.median(starboard.least_m) <= 5.8
    assert starboard.standstill.sum() == 0
    deaf = two_boat(60, 21)
    nobody = sailed(structs.replace(deaf, avoids=np.zeros_like(deaf.avoids)), "circle")
    assert 0.5 <= nobody.collided.mean() <= 0.8
    assert abs(nobody.delay_s).max() < 0.2
    assert nobody.switches.sum() == 0


def test_least_separation_is_exact_between_ticks() -> None:
    """Two boats pass head-on, 1 m apart, both at 1.5 m/s: at no tick they are abeam exactly."""
    paths = (straight((0.0, 0.0), (100.0, 0.0)), straight((20.05, 1.0), (-100.0, 1.0)))
    one = assemble(
        "pass", 1, np.array([0]), paths, [[0, 1]], [[0.0, 20.05]], [[0.0, 1.0]], [[0.0, np.pi]],
        cruise=1.5, avoids=0.0, limit_s=20.0,
    )  # fmt: skip
    result = run(one)
    assert result.least_m[0] == pytest.approx(1.0, abs=1e-6)
    assert result.collided[0] == 1.0
    assert result.inside_s[0] == pytest.approx(2.0 * np.sqrt(35.0) / 3.0, abs=0.2)


def held(at_s: float, goal: float, scenarios: Scenarios) -> Scenarios:
    shape = scenarios.x.shape
    change = Change(
        at_s=np.full(shape[0], at_s),
        goal=np.full(shape, goal),
        offset=scenarios.offset,
        cruise=scenarios.cruise,
    )
    return structs.replace(scenarios, changes=(change,))


def test_a_boat_that_was_told_to_hold_does_not_stand_still() -> None:
    one = assemble(
        "hold", 1, np.array([0]), (straight((0.0, 0.0), (100.0, 0.0)),), 0, [[0.0]], [[0.0]], 0.0, limit_s=130.0
    )
    told = run(held(20.0, 3.0, one), record=[0])
    assert told.stood[0, 0] == 0.0
    assert told.traces[0].mode[-1, 0] == 3.0
    drifting = run(held(20.0, 6.0, one))  # neutral: it was not told to sail either
    assert drifting.stood[0, 0] == 0.0
    stuck = run(
        structs.replace(
            one, u=one.u * 0.0, cruise=one.cruise * 0.0 + 0.2, limits=structs.replace(one.limits, speed_max_mps=0.05)
        )
    )
    assert stuck.stood[0, 0] == 1.0


def test_the_swap_settles_and_keeps_apart() -> None:
    result = sailed(swap(8, 3, limit_s=200.0))
    assert result.collided.sum() == 0
    assert result.stood.sum() == 0.0
    assert result.settled_s.max() < 150.0
    assert result.least_m.min() > 6.0
    assert result.cross_track_most_m.max() > 3.0
    assert result.formation_end_m.max() < 0.2


def test_a_column_that_closes_up_stays_on_its_path() -> None:
    column = lossy(4, 3, loss=0.0, delay_s=0.0)
    result = sailed(column)
    assert result.cross_track_most_m.max() < 0.1
    assert result.switches.sum() == 0
    apart = np.broadcast_to(np.arange(5), column.path.shape).copy()  # five paths that lie on each other
    strangers = structs.replace(column, path=apart, paths=column.paths * 5)
    assert sailed(strangers).cross_track_most_m.max() > 1.0


def test_loss_is_as_often_as_said_and_a_perfect_radio_loses_nothing() -> None:
    clean, bad = (
        sailed(lossy(4, 3, 3, loss=loss, delay_s=delay, limit_s=LIMIT_S)) for loss, delay in ((0, 0), (0.5, 1.0))
    )
    assert clean.formation_rms_m.mean() < bad.formation_rms_m.mean() + 0.5
    assert bad.collided.sum() == 0
    assert (clean.formation_rms_m != bad.formation_rms_m).all()


def test_two_formations_know_nothing_of_each_other() -> None:
    both = formation_errors([10.0, 4.0, 100.0, 103.0, 7.0], [1.0, 1.0, 2.0, 2.0, 0.0], 2)
    assert both == [-6.0, 6.0, 3.0, -3.0, 0.0]
    lanes = [np.array([z, z + 1.0]) for z in (10.0, 4.0, 100.0, 103.0, 7.0)]
    members = [np.full(2, m) for m in (1.0, 1.0, 2.0, 2.0, 0.0)]
    assert [e.tolist() for e in formation_errors(lanes, members, 2)] == [[e, e] for e in both]


def test_a_boat_that_sails_in_circles_stands_still_but_has_not_stopped() -> None:
    nothing = Decision(*[0.0] * len(Decision.__struct_fields__))
    order = Order(float(Goal.FOLLOW), 0.0, 1.0, 0.0, 1.5, 0.3, 1e9)
    circling = lying = tally.begin(0.0, np.inf, 0.0, 0.0, 5.0, 0.0)
    for k in range(1, 15):
        circling = tally.check(circling, nothing, order, 5.0 * np.cos(0.2 * k), 5.0 * np.sin(0.2 * k))
        lying = tally.check(lying, nothing, order, 5.0 + 0.4 * (k % 2), 0.0)
    assert (circling.stood, circling.stopped) == (1.0, 0.0)
    assert (lying.stood, lying.stopped) == (1.0, 1.0)


def test_a_silent_boat_leaves_the_sums_and_stays_an_obstacle() -> None:
    column = lossy(2, 5, 3, loss=0.0, delay_s=0.0, limit_s=90.0)
    mute = structs.replace(column, mute_s=np.tile([np.inf, 30.0, np.inf], (2, 1)))
    result = run(mute, floats=False, record=[0])
    assert result.collided.sum() == 0
    assert np.isfinite(result.least_m).all()
    assert result.traces[0].x.shape == (900, 3)


def test_summary_names_the_cases_that_failed() -> None:
    result = sailed(antipodal(6, 2, 3, radius=20.0, limit_s=80.0), "circle", params=CircleParams(printed=True))
    summary = result.summary()
    assert summary["collisions"] == 6
    assert summary["failed_seeds"] == [0, 1, 2, 3, 4, 5]
    assert summary["cases"] == 6


REFERENCE = {
    "scoring": "b189d79a3a7d5cfa",
    "circle": "a91b69ccedea4afb",
}
"""Digests of what two and three boats decide. A law that was changed on purpose changes them; nothing else may."""


@pytest.mark.parametrize("method", REFERENCE)
def test_decisions_are_those_of_the_reference(method: str) -> None:
    digest = hashlib.sha256()
    for scenarios in (two_boat(np.array([3]), 11), crossing(np.array([5]), 11, 3), swap(np.array([1]), 11)):
        trace = run(
            structs.replace(scenarios, limit_s=np.array([100.0])), method, record=scenarios.case.tolist()
        ).traces[0]
        for field in ("x", "y", "psi", "u", "s", "e", "y_e", "u_d", "r_d", "mode", "avoiding"):
            digest.update((getattr(trace, field) + 0.0).tobytes())
    assert digest.hexdigest()[:16] == REFERENCE[method], f"{method}: decisions differ from the reference"
