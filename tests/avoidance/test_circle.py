"""The safety circle, by hand."""

from __future__ import annotations

import math

import pytest

from fleet.avoidance.circle import CircleMemory, CircleParams, keep_clear, start_memory
from fleet.guidance.limits import Limits
from tests.avoidance.scenes import own_at, peer_at

LIMITS = Limits()
CLOSEST = CircleParams(side="closest")
STARBOARD = CircleParams(side="starboard")
FREE = start_memory(0.0)


def test_nobody_in_the_way_changes_nothing() -> None:
    memory, advice = keep_clear(own_at(u_d=1.1), [peer_at(3.0, 13.0, 0.0, math.pi)], FREE, LIMITS, CLOSEST, 0.1)
    assert memory == FREE
    assert (advice.avoiding, advice.steers, advice.u_d, advice.target) == (0.0, 0.0, 1.1, -1.0)


@pytest.mark.parametrize(
    ("x", "y", "enters"),
    [
        (11.9, 0.0, True),  # intrudes (d < 12) and obstructs
        (12.1, 0.0, False),
        (6.0, 5.9, True),  # the line passes 5.9 m off
        (6.0, 6.1, False),
        (-3.0, 0.0, False),  # inside its circle, but the way opens
        (3.0, 0.0, True),
    ],
)
def test_it_enters_on_intrusion_and_obstruction(x: float, y: float, enters: bool) -> None:
    _, advice = keep_clear(own_at(), [peer_at(3.0, x, y, math.pi)], FREE, LIMITS, CLOSEST, 0.1)
    assert (advice.avoiding == 1.0) == enters


def test_the_latched_vehicle_is_released_only_15_percent_further_off() -> None:
    latched = CircleMemory(3.0, 1.0)
    for y, stays in ((6.8, True), (6.95, False)):
        memory, _ = keep_clear(own_at(), [peer_at(3.0, 6.0, -y, math.pi)], latched, LIMITS, CLOSEST, 0.1)
        assert (memory.target == 3.0) == stays


def test_closest_passes_on_the_near_side_and_starboard_always_leaves_it_to_port() -> None:
    right, left = peer_at(3.0, 9.0, 2.0, math.pi), peer_at(3.0, 9.0, -2.0, math.pi)
    sides = [
        keep_clear(own_at(), [peer], FREE, LIMITS, params, 0.1)[1].side
        for params in (CLOSEST, STARBOARD)
        for peer in (right, left)
    ]
    assert sides == [-1.0, 1.0, 1.0, 1.0]


def test_the_side_is_kept_until_release() -> None:
    memory, advice = keep_clear(
        own_at(), [peer_at(3.0, 9.0, 2.0, math.pi)], CircleMemory(3.0, 1.0), LIMITS, CLOSEST, 0.1
    )
    assert memory.side == 1.0
    assert advice.r_d > 0.0


def test_the_nearest_vehicle_in_the_way_is_circled() -> None:
    peers = [peer_at(2.0, 10.0, 0.0, math.pi), peer_at(5.0, 8.0, 0.0, math.pi), peer_at(6.0, 4.0, 9.0, 0.0)]
    assert keep_clear(own_at(), peers, FREE, LIMITS, CLOSEST, 0.1)[0].target == 5.0


def test_on_the_circle_along_its_tangent_the_yaw_rate_is_speed_over_radius() -> None:
    # 6 m west of the vehicle, sailing south around it, wanting to go east: U / R = 1/6, to port
    own = own_at(x=0.0, y=-6.0, chi=math.pi, gamma=math.pi / 2)
    _, advice = keep_clear(own, [peer_at(3.0, 0.0, 0.0, 0.0, 0.0)], CircleMemory(3.0, 1.0), LIMITS, CLOSEST, 0.1)
    assert advice.r_d == pytest.approx(-1.0 / 6.0)


def test_outside_the_circle_the_boat_approaches_it() -> None:
    # 2 m outside, on the tangent: r_d = -k1 psi_a tanh(k_phi 2) - U R / d / R, both towards the vehicle to port
    own = own_at(x=0.0, y=-8.0, chi=math.pi, gamma=math.pi / 2, u=0.2)
    _, advice = keep_clear(own, [peer_at(3.0, 0.0, 0.0, 0.0, 0.0)], CircleMemory(3.0, 1.0), LIMITS, CLOSEST, 0.1)
    assert advice.r_d == pytest.approx(max(-0.35, -0.8 * 1.05 * math.tanh(0.4) - 0.2 / 8.0))


def test_as_printed_a_vehicle_ahead_turns_to_port_and_stays_latched_when_past() -> None:
    printed = CircleParams(side="starboard", printed=True)
    _, ahead = keep_clear(own_at(), [peer_at(3.0, 9.0, 0.0, math.pi)], FREE, LIMITS, printed, 0.1)
    assert ahead.side == -1.0
    _, astern = keep_clear(own_at(), [peer_at(3.0, -9.0, 0.0, math.pi)], FREE, LIMITS, printed, 0.1)
    assert astern.avoiding == 1.0


def test_widening_grows_the_circle() -> None:
    _, advice = keep_clear(own_at(), [peer_at(3.0, 13.0, 0.0, math.pi, widen=1.0)], FREE, LIMITS, CLOSEST, 0.1)
    assert advice.avoiding == 1.0
