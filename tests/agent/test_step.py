"""`step`: one boat or a thousand, the same bits; within the limits whatever it is told."""

from __future__ import annotations

import math
import random
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Struct

from fleet import ops
from fleet.agent.modes import Goal, Mode
from fleet.agent.step import Decision, Nav, Order, State, StepParams, start, step
from fleet.avoidance import METHODS
from fleet.avoidance.types import Peer
from fleet.coordination import Leader, Member
from fleet.guidance import FollowParams, Limits, StationParams
from fleet.paths import PathPoint

LIMITS = Limits(speed_min_mps=0.2)
FAR = 1e6
DT = 0.1


class Line:
    """A straight path, or a lane each: (x0, y0) and its course."""

    def __init__(self, x0: Any, y0: Any, chi: Any) -> None:
        self.x0, self.y0 = x0, y0
        self.ty, self.tx = ops.sincos(chi)

    def at(self, s: Any) -> PathPoint[Any]:
        return PathPoint(self.x0 + s * self.tx, self.y0 + s * self.ty, self.tx, self.ty, ops.zero(s))

    def straight(self, s: Any) -> Any:
        return ops.full(s, FAR)


class Case(Struct):
    """One boat's situation, as rows of numbers."""

    nav: list[float]
    members: list[list[float]]
    peers: list[list[float]]
    order: list[float]
    path: list[float]


def params_of(method: str) -> StepParams:
    keep = METHODS[method].params(6.0, "closest")
    return StepParams(follow=FollowParams(), station=StationParams(), limits=LIMITS, keep=keep)


def a_case(rng: random.Random, peers: int = 2, members: int = 2) -> Case:
    x, y, chi = rng.uniform(-50, 50), rng.uniform(-50, 50), rng.uniform(-math.pi, math.pi)
    u = rng.choice([0.0, 0.03, 0.5, 1.0, 1.5])
    nav = [1.0, x, y, rng.uniform(-math.pi, math.pi), u * math.cos(chi), u * math.sin(chi), rng.uniform(-0.3, 0.3), 0.1]
    kind = rng.random()
    if kind < 0.15:
        nav[rng.randrange(1, 8)] = rng.choice([math.nan, math.inf, -math.inf])
    elif kind < 0.25:
        nav[0] = 0.0
    else:
        nav[7] = rng.choice([0.0, 0.5, 2.0])
    goal = float(rng.choice(list(Goal)))
    others = [
        [
            float(k),
            1.0,
            x + rng.uniform(-25, 25),
            y + rng.uniform(-25, 25),
            rng.uniform(-1, 1),
            rng.uniform(-1, 1),
            float(rng.random() < 0.7),
            math.cos(chi + k),
            math.sin(chi + k),
            rng.choice([0.0, 1.0]),
            math.cos(chi),
            math.sin(chi),
            rng.choice([0.0, 5.0, 100000.0]),
            rng.choice([0.0, 0.5]),
            rng.choice([0.0, 2.0]),
        ]
        for k in range(peers)
    ]
    formation = [[rng.choice([0.0, 0.3, 1.0]), rng.uniform(-40, 40)] for _ in range(members)]
    order = [goal, rng.uniform(-20, 20), 1.0, 0.2, 1.5, 0.3, rng.choice([5.0, 1e18])]
    return Case(nav, formation, others, order, [x + rng.uniform(-9, 9), y + rng.uniform(-9, 9), chi])


def leader_of(case: Case, k: int) -> list[float]:
    """Somebody to sail beside: at times lost, at times stopped."""
    (heard, _), (moving, _), (x, y, chi) = *case.members, case.path
    good, stopped = float(heard > 0.0), float(moving == 0.0)
    return [good, stopped, x + k * DT, y + 9.0, math.cos(chi), math.sin(chi), 0.01, 1.0, -2.0, 0.1]


def one(case: Case, method: str, ticks: int, *, beside: bool = False) -> list[list[float]]:
    """The boat alone: rows of state and decision, a tick each."""
    m, params = METHODS[method], params_of(method)
    state: Any = start(0.0, 0.0, m.start(0.0, len(case.peers)))
    rows = []
    for k in range(ticks):
        state, decision = step(
            state,
            Nav(*moved(case.nav, k)),
            [Member(*row) for row in case.members],
            [Peer(*drifted(row, k)) for row in case.peers],
            Order(*case.order),
            Line(*case.path),
            m,
            params,
            DT,
            leader=Leader(*leader_of(case, k)) if beside else None,
        )
        rows.append(flat(state) + flat(decision))
    return rows


def lanes(cases: list[Case], method: str, ticks: int, *, beside: bool = False) -> list[list[list[float]]]:
    """The same boats as lanes of arrays; rows as `one` gives them, a lane each."""
    m, params = METHODS[method], params_of(method)

    def columns(rows: list[list[float]]) -> list[Any]:
        return [np.array(column) for column in zip(*rows, strict=True)]

    like = np.zeros(len(cases))
    state: Any = start(like, like, m.start(like, len(cases[0].peers)))
    ticks_of_lanes: list[list[list[float]]] = []
    with np.errstate(all="ignore"):
        for k in range(ticks):
            state, decision = step(
                state,
                Nav(*columns([moved(case.nav, k) for case in cases])),
                [Member(*columns([c.members[j] for c in cases])) for j in range(len(cases[0].members))],
                [Peer(*columns([drifted(c.peers[j], k) for c in cases])) for j in range(len(cases[0].peers))],
                Order(*columns([case.order for case in cases])),
                Line(*columns([case.path for case in cases])),
                m,
                params,
                DT,
                leader=Leader(*columns([leader_of(case, k) for case in cases])) if beside else None,
            )
            values = [np.broadcast_to(np.asarray(v, dtype=float), like.shape) for v in flat(state) + flat(decision)]
            ticks_of_lanes.append(np.array(values).T.tolist())
    return [[rows[lane] for rows in ticks_of_lanes] for lane in range(len(cases))]


def moved(nav: list[float], k: int) -> list[float]:
    return [nav[0], nav[1] + k * DT * nav[4], nav[2] + k * DT * nav[5], *nav[3:]]


def drifted(peer: list[float], k: int) -> list[float]:
    return [*peer[:2], peer[2] + k * DT * peer[4], peer[3] + k * DT * peer[5], *peer[4:]]


def flat(value: Any) -> list[Any]:
    if isinstance(value, Struct):
        return [x for name in value.__struct_fields__ for x in flat(getattr(value, name))]
    if isinstance(value, tuple):
        return [x for item in value for x in flat(item)]
    return [] if value is None else [value]


def same(a: list[list[float]], b: list[list[float]]) -> bool:
    return np.array(a).tobytes() == np.array(b).tobytes()


@pytest.mark.parametrize("method", sorted(METHODS))
@pytest.mark.parametrize("count", [1, 2, 1000])
def test_a_lane_gets_what_the_boat_alone_gets_to_the_last_bit(method: str, count: int) -> None:
    rng = random.Random(count)
    cases = [a_case(rng) for _ in range(count)]
    together = lanes(cases, method, 7)
    for lane in range(min(count, 150)):
        assert same(one(cases[lane], method, 7), together[lane]), (lane, cases[lane])


def test_a_lane_of_wingmen_gets_what_the_wingman_alone_gets_to_the_last_bit() -> None:
    rng = random.Random(7)
    cases = [a_case(rng) for _ in range(300)]
    together = lanes(cases, "scoring", 7, beside=True)
    for lane in range(60):
        assert same(one(cases[lane], "scoring", 7, beside=True), together[lane]), (lane, cases[lane])


def test_every_goal_is_among_those_cases() -> None:
    rng = random.Random(1000)
    cases = [a_case(rng) for _ in range(150)]
    assert {case.order[0] for case in cases} == {float(goal) for goal in Goal}
    assert sum(not math.isfinite(sum(case.nav)) for case in cases) > 10


@pytest.mark.parametrize("method", sorted(METHODS))
def test_a_boat_of_floats_decides_floats(method: str) -> None:
    for row in one(a_case(random.Random(3)), method, 3):
        assert all(type(value) is float for value in row)


numbers = st.floats(allow_nan=True, allow_infinity=True)
moderate = st.floats(-200.0, 200.0)


@settings(max_examples=120, deadline=None)
@given(
    nav=st.lists(st.one_of(moderate, numbers), min_size=7, max_size=7),
    sound=st.sampled_from([0.0, 1.0]),
    goal=st.sampled_from(list(Goal)),
    seed=st.integers(0, 10_000),
    method=st.sampled_from(sorted(METHODS)),
    members=st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(-1e9, 1e9)), max_size=4),
)
def test_nothing_reaches_the_driver_that_is_not_within_the_limits(
    nav: list[float], sound: float, goal: Goal, seed: int, method: str, members: list[tuple[float, float]]
) -> None:
    case = a_case(random.Random(seed), peers=2)
    case.nav, case.order[0], case.members = [sound, *nav], float(goal), [list(row) for row in members]
    m = METHODS[method]
    state: Any = start(0.0, 0.0, m.start(0.0, 2))
    for k in range(3):
        state, decision = step(
            state,
            Nav(*moved(case.nav, k)),
            [Member(*row) for row in case.members],
            [Peer(*row) for row in case.peers],
            Order(*case.order),
            Line(*case.path),
            m,
            params_of(method),
            DT,
        )
        assert 0.0 <= decision.u_d <= LIMITS.speed_max_mps
        assert -LIMITS.yaw_rate_max_radps <= decision.r_d <= LIMITS.yaw_rate_max_radps
        assert all(math.isfinite(value) for value in flat(decision)), decision
        assert math.isfinite(state.s)
        if decision.powered < 0.5:
            assert decision.u_d == decision.r_d == 0.0
        if decision.mode in (Mode.FAULT, Mode.NEUTRAL, Mode.STANDBY):
            assert decision.powered == 0.0


# -- by hand -----------------------------------------------------------------------------------------------------------
NORTH = Line(0.0, 0.0, 0.0)


def decide(
    goal: Goal, nav: Nav[float] | None = None, state: Any = None, members: Any = (), s_end: float = 1e18
) -> tuple[State[float, Any], Decision[float]]:
    m = METHODS["circle"]
    nav = nav if nav is not None else Nav(1.0, 10.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    state = state if state is not None else start(0.0, 10.0, m.start(0.0, 0))
    return step(
        state, nav, members, [], Order(float(goal), 0.0, 1.0, 0.2, 1.5, 0.3, s_end), NORTH, m, params_of("circle"), DT
    )


def test_on_its_path_and_in_its_place_a_boat_goes_straight_on_at_cruise_speed() -> None:
    _, decision = decide(Goal.FOLLOW)
    assert (decision.mode, decision.u_d, decision.r_d, decision.e) == (Mode.FOLLOW, 1.0, 0.0, 0.0)


@pytest.mark.parametrize(("goal", "mode"), [(g, Mode[g.name]) for g in Goal])
def test_every_goal_has_its_mode(goal: Goal, mode: Mode) -> None:
    _, decision = decide(goal)
    assert decision.mode == mode
    assert decision.powered == (0.0 if goal in (Goal.STANDBY, Goal.NEUTRAL) else 1.0)


def test_ten_metres_behind_its_place_a_boat_speeds_up() -> None:
    _, decision = decide(Goal.FOLLOW, members=[Member(1.0, 20.0)])
    assert decision.e == 10.0
    assert decision.u_d == pytest.approx(1.0 + 0.5 * math.tanh(3.0))


def test_alone_a_boat_keeps_cruise_speed_whatever_the_formation_says() -> None:
    assert decide(Goal.ALONE, members=[Member(1.0, 20.0)])[1].u_d == 1.0


def test_navigation_that_fails_stops_the_boat_at_once_and_for_three_seconds_after() -> None:
    state, _ = decide(Goal.FOLLOW)
    state, decision = decide(Goal.FOLLOW, Nav(1.0, math.nan, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), state)
    assert (decision.mode, decision.powered) == (Mode.FAULT, 0.0)
    modes = []
    for _ in range(31):
        state, decision = decide(Goal.FOLLOW, None, state)
        modes.append(decision.mode)
    assert modes[:29] == [Mode.FAULT] * 29
    assert modes[-1] == Mode.FOLLOW


def test_at_the_end_of_its_path_a_boat_holds_and_goes_on_holding() -> None:
    state, decision = decide(Goal.FOLLOW, s_end=10.0)
    assert decision.mode == Mode.HOLD
    assert decide(Goal.FOLLOW, None, state, s_end=1e18)[1].mode == Mode.HOLD


# -- no numpy ----------------------------------------------------------------------------------------------------------
WITHOUT = """
import sys, tempfile, pathlib
from tests.agent.harness import mission, sailing
import fleet.agent.agent
sea = sailing(pathlib.Path(tempfile.mkdtemp()), mission(3, method=sys.argv[1]), 10.0)
sea.change(spacing_m=15.0)
sea.command("hold"); sea.run(2.0); sea.command("resume"); sea.cut("b2"); sea.run(5.0); sea.restart("b3"); sea.run(2.0)
sea.command("return"); sea.run(2.0)
print(",".join(name for name in ("numpy", "matplotlib", "typer", "rich", "zenoh", "mcap") if name in sys.modules))
"""


@pytest.mark.parametrize("method", sorted(METHODS))
def test_an_agent_that_sails_imports_no_numpy(method: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, method], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == ""
