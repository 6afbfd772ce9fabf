"""What holds for every method and every scene."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet.avoidance import METHODS
from fleet.avoidance.circle import CircleParams
from fleet.avoidance.types import Own, Peer
from fleet.guidance.limits import Limits
from tests.avoidance.scenes import flags, lane, lanes, own_at, owns, peer_at, peers_of, rotated

LIMITS = Limits(speed_min_mps=0.1)
CASES = [
    pytest.param("scoring", METHODS["scoring"].params(6.0, "closest"), id="scoring"),
    pytest.param("circle", CircleParams(side="closest"), id="circle"),
    pytest.param("circle", CircleParams(side="starboard"), id="starboard"),
    pytest.param("circle", CircleParams(printed=True), id="printed"),
]
both = pytest.mark.parametrize(("name", "params"), CASES)
scenes = st.tuples(owns, peers_of(2.0), peers_of(3.0), peers_of(7.0))


def ticks(name: str, params: Any, scene: tuple[Any, ...], count: int = 7, memory: Any = None) -> tuple[Any, Any]:
    """Memory and advices of some ticks in which everybody goes straight on."""
    method = METHODS[name]
    own, peers = scene[0], list(scene[1:])
    memory = method.start(own.x, len(peers)) if memory is None else memory
    advices = []
    for _ in range(count):
        memory, advice = method.keep_clear(own, peers, memory, LIMITS, params, 0.1)
        advices.append(advice)
        own = msgspec.structs.replace(own, x=own.x + 0.1 * own.vx, y=own.y + 0.1 * own.vy)
        peers = [msgspec.structs.replace(p, x=p.x + 0.1 * p.vx, y=p.y + 0.1 * p.vy) for p in peers]
    return memory, tuple(advices)


def random_scenes(count: int, peers: int, seed: int) -> list[tuple[Any, ...]]:
    rng = np.random.default_rng(seed)

    def angle() -> float:
        return float(rng.uniform(-math.pi, math.pi))

    def speed() -> float:
        return float(rng.choice([0.0, 0.6, 1.0, rng.uniform(0.0, 1.5)]))

    result = []
    for _ in range(count):
        chi = angle()
        own = own_at(
            chi=chi, u=speed(), gamma=chi + 0.3 * angle(), chi_p=chi, y_e=float(rng.normal(0.0, 5.0)), u_d=speed()
        )
        scene: list[Any] = [own]
        for k in range(peers):
            c = angle()
            x, y = rng.normal(0.0, 15.0, 2).tolist()
            scene.append(
                peer_at(
                    float(k), x, y, c, speed(), gamma=c + 0.2 * angle(), known=float(rng.integers(2)),
                    present=float(rng.random() < 0.8), widen=float(rng.integers(2)), sigma=0.5,
                )
            )  # fmt: skip
        result.append(tuple(scene))
    return result


@both
@pytest.mark.parametrize("count", [1, 2, 300])
def test_a_boat_alone_decides_as_in_a_lane(name: str, params: Any, count: int) -> None:
    cases = random_scenes(count, 4, count)
    with np.errstate(all="raise"):
        memory, advices = ticks(name, params, lanes(cases))
    for k, case in enumerate(cases):
        alone_memory, alone_advices = ticks(name, params, case)
        assert lane(memory, k) == alone_memory
        assert lane(advices, k) == alone_advices


@both
def test_lanes_that_decide_at_different_ticks_decide_as_alone(name: str, params: Any) -> None:
    if name == "circle":
        return
    cases = random_scenes(20, 3, 11)
    method = METHODS[name]
    starts = [
        msgspec.structs.replace(method.start(0.0, 3), countdown=0.1 * (k % 5), avoiding=float(k % 2), cy=0.6, cx=0.8)
        for k in range(20)
    ]
    memory, advices = ticks(name, params, lanes(cases), memory=lanes(starts))
    for k, case in enumerate(cases):
        assert (lane(memory, k), lane(advices, k)) == ticks(name, params, case, memory=starts[k])


@both
@given(scene=scenes, mask=st.tuples(flags, flags, flags))
@settings(max_examples=60, deadline=None)
def test_a_masked_peer_is_the_same_as_none(
    name: str, params: Any, scene: tuple[Own[float], ...], mask: tuple[float, ...]
) -> None:
    own, peers = scene[0], scene[1:]
    hidden = tuple(msgspec.structs.replace(p, present=m) for p, m in zip(peers, mask, strict=True))
    shown = tuple(p for p, m in zip(peers, mask, strict=True) if m == 1.0)
    memory, advices = ticks(name, params, (own, *hidden))
    alone_memory, alone_advices = ticks(name, params, (own, *shown))
    assert advices == alone_advices
    aligned = METHODS[name].align(memory, [p.number for p in hidden], [p.number for p in shown])
    assert aligned == alone_memory


@both
@given(scene=scenes)
@settings(max_examples=40, deadline=None)
def test_somebody_far_away_changes_nothing(name: str, params: Any, scene: tuple[Any, ...]) -> None:
    far = peer_at(9.0, 3000.0, -2000.0, 2.5, 1.4)
    memory, advices = ticks(name, params, scene)
    with_far, same = ticks(name, params, (*scene, far))
    assert advices == same
    assert METHODS[name].align(with_far, [2.0, 3.0, 7.0, 9.0], [2.0, 3.0, 7.0]) == memory


def test_out_of_reach_the_lane_that_reckons_agrees_with_the_boat_that_skips() -> None:
    # one lane near, the other far: the near lane makes the law look at the peer in both
    own = own_at()
    cases = [(own, peer_at(1.0, x, 0.0, math.pi)) for x in (30.0, 307.0, 308.0, 309.0, 310.0, 400.0)]
    params = METHODS["scoring"].params(6.0, "closest")
    memory, advices = ticks("scoring", params, lanes(cases))
    for k, case in enumerate(cases):
        assert (lane(memory, k), lane(advices, k)) == ticks("scoring", params, case)


@both
@given(scene=scenes)
@settings(max_examples=40, deadline=None)
def test_the_order_of_peers_does_not_matter_to_pairs_and_hardly_to_prices(
    name: str, params: Any, scene: tuple[Any, ...]
) -> None:
    own, a, b, c = scene
    memory, advices = ticks(name, params, scene, count=1)
    other, turned = ticks(name, params, (own, c, a, b), count=1)
    aligned = METHODS[name].align(other, [7.0, 2.0, 3.0], [2.0, 3.0, 7.0])
    if name == "scoring":
        assert aligned.pairs == memory.pairs
    assert turned[0].avoiding == advices[0].avoiding


@both
@given(angle=st.floats(-math.pi, math.pi), seed=st.integers(0, 10_000))
@settings(max_examples=60, deadline=None)
def test_a_scene_turned_as_a_whole_is_decided_alike(name: str, params: Any, angle: float, seed: int) -> None:
    scene = random_scenes(1, 3, seed)[0]
    _, advices = ticks(name, params, scene, count=1)
    _, turned = ticks(name, params, tuple(rotated(each, angle) for each in scene), count=1)
    before, after = advices[0], turned[0]
    assert (after.avoiding, after.steers, after.target) == (before.avoiding, before.steers, before.target)
    assert (after.u_d, after.r_d) == (pytest.approx(before.u_d), pytest.approx(before.r_d, abs=1e-9))


@both
@given(scene=scenes)
@settings(max_examples=60, deadline=None)
def test_advice_stays_within_the_hull(name: str, params: Any, scene: tuple[Own[float] | Peer[float], ...]) -> None:
    _, advices = ticks(name, params, scene)
    for advice in advices:
        assert abs(advice.r_d) <= LIMITS.yaw_rate_max_radps
        assert 0.0 <= advice.u_d <= max(scene[0].u_d, 0.3)
        assert all(type(value) is float for value in msgspec.structs.astuple(advice))
