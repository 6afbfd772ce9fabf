"""The loops on the simulated catamaran, and every layer that stops it: helm and controller in memory."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.frames import Status
from fleet.drivers.can.helm import PILOT
from fleet.drivers.can.loops import LoopParams, begin, drive
from fleet.guidance.thrust import Thrusters, Thrusts
from fleet.hulls import Water
from tests.drivers.can.rig import FRAMES, Rig

AHEAD = (1.0, 0.0)


def under_way(command: tuple[float, float] = AHEAD) -> Rig:
    rig = Rig()
    rig.run(1.0)
    rig.run(20.0, command)
    assert set(rig.told) == {""}
    return rig


def test_speed_and_yaw_rate_settle_on_their_set_points() -> None:
    rig = under_way((1.3, 0.3))
    assert rig.hull.u == pytest.approx(1.3, abs=0.005)
    assert rig.hull.r == pytest.approx(0.3, abs=0.003)
    assert max(u for u, _ in rig.speeds) < 1.31
    assert max(r for _, r in rig.speeds) < 0.315


def test_it_follows_with_the_lags_that_the_agents_laws_expect() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.run(12.0, (0.3, 0.0))  # no acceleration limit at such a step
    rig.run(2.0, (0.5, 0.2))
    assert rig.speeds[-1][0] == pytest.approx(0.5 - 0.2 * 3.0 * math.exp(-2.0), abs=0.01)  # two lags of 1 s
    early = [r for _, r in rig.speeds[-80 : -80 + 24]]  # 0.6 s
    assert 0.05 < early[-1] < 0.15


def test_it_goes_astern_and_stops() -> None:
    rig = under_way((-0.6, 0.0))
    assert rig.hull.u == pytest.approx(-0.6, abs=0.005)
    rig.run(15.0, (0.0, 0.0))
    assert abs(rig.hull.u) < 0.01


def test_surge_is_over_ground_in_a_stream() -> None:
    rig = Rig(water=Water(-0.4, 0.1, 0.0, 0.0))
    rig.run(1.0)
    rig.run(25.0, AHEAD)
    assert rig.hull.u == pytest.approx(1.0, abs=0.01)


def test_noise_of_the_sensors_does_not_shake_the_boat() -> None:
    rig = Rig(noise=0.05)  # 5 cm/s, and 0.01 rad/s
    rig.run(1.0)
    rig.run(60.0, AHEAD)
    late = rig.speeds[-1200:]
    assert math.sqrt(sum((u - 1.0) ** 2 for u, _ in late) / len(late)) < 0.02
    assert math.sqrt(sum(r * r for _, r in late) / len(late)) < 0.01


@pytest.mark.parametrize("wrong", [0.7, 1.5])
def test_a_boat_a_third_lighter_or_half_as_heavy_again_than_configured_is_still_steered(wrong: float) -> None:
    loops = LoopParams(
        mass_kg=60.0 * wrong, inertia_kgm2=12.0 * wrong, drag_kg_per_s=15 * wrong, drag_kg_per_m=36 * wrong
    )
    rig = Rig(CanConfig(loops=loops))
    rig.run(1.0)
    rig.run(25.0, (1.0, 0.2))
    assert rig.hull.u == pytest.approx(1.0, abs=0.02)
    assert rig.hull.r == pytest.approx(0.2, abs=0.01)
    assert max(u for u, _ in rig.speeds) < 1.1


@pytest.mark.parametrize(
    ("u", "u_d", "newtons"),
    [(1.0, 1.3, 51.0), (1.3, 1.0, 51.0), (1.0, 0.0, 0.0), (1.0, -0.5, 0.0), (-1.0, -1.0, -51.0)],
)
def test_a_boat_under_way_is_taken_over_with_the_thrust_that_keeps_the_slower_speed(
    u: float, u_d: float, newtons: float
) -> None:
    assert begin(u, 0.1, u_d, LoopParams()).force == pytest.approx(newtons)  # 15 u + 36 u^2


def test_nothing_winds_up_while_the_thrusters_are_at_their_limits() -> None:
    params, thrusters = LoopParams(), Thrusters()
    loops = begin(0.0, 0.0, 5.0, params)
    for _ in range(1000):
        loops, _ = drive(loops, 5.0, 2.0, 0.0, 0.0, 0.05, params, thrusters)
    assert loops.moment == pytest.approx(thrusters.moment_max)
    for _ in range(40):  # 2 s
        loops, thrusts = drive(loops, -1.0, -1.0, 0.0, 0.0, 0.05, params, thrusters)
    assert thrusts.side_port < 0.0


def test_an_agent_that_hangs_is_stopped_by_its_driver_after_half_a_second() -> None:
    rig = under_way()
    rig.agent_hangs = True
    assert 0.4 <= rig.seconds_until_no_thrust() <= 0.6


def test_an_agent_that_is_gone_is_stopped_by_the_controller_after_half_a_second() -> None:
    rig = under_way()
    rig.deaf_controller = True
    assert 0.5 <= rig.seconds_until_no_thrust(command=AHEAD) <= 0.6


def test_neutral_stops_the_thrusters_with_the_next_navigation_set() -> None:
    rig = under_way()
    rig.helm.neutral()
    assert rig.seconds_until_no_thrust() <= 0.1
    sent = rig.sent
    rig.run(5.0)
    assert rig.sent == sent  # silence from then on


def test_without_navigation_nothing_is_sent() -> None:
    rig = under_way()
    rig.deaf_helm = True
    assert rig.seconds_until_no_thrust(command=AHEAD) <= 0.6
    rig.run(2.0, AHEAD)
    assert rig.told[-1] == "the controller on the CAN bus is silent"
    rig.deaf_helm = False
    rig.run(15.0, AHEAD)
    assert rig.told[-1] == ""
    assert rig.hull.u == pytest.approx(1.0, abs=0.02)


def test_after_a_pause_it_sets_off_no_faster_than_from_rest() -> None:
    rig = under_way()
    rig.deaf_helm = rig.agent_hangs = True  # the process is frozen
    rig.run(8.0)
    assert rig.hull.u < 0.1
    rig.deaf_helm = rig.agent_hangs = False
    rig.helm.take(rig.now_ns, *FRAMES.status(Status(99, 1, False, False)))
    rig.now_ns += 1
    rig.helm._nav_ns = rig.now_ns  # the agent's word is there before the first navigation set
    assert rig.helm.command(rig.now_ns, *AHEAD) == ""
    before = len(rig.speeds)
    rig.run(3.0, AHEAD)
    speeds = [u for u, _ in rig.speeds[before:]]
    assert max(b - a for a, b in pairwise(speeds)) < 0.32 * 0.025


def test_a_pilot_who_takes_the_boat_is_not_fought_and_what_was_asked_before_does_not_come_back() -> None:
    rig = under_way()
    rig.controller.pilot(Thrusts(20.0, 10.0, 0.0, 0.0))
    rig.run(0.2, AHEAD)
    reading = rig.helm.reading(rig.now_ns)
    assert (reading.authority, reading.trouble) == (PILOT, "")
    sent = rig.sent
    rig.agent_hangs = True  # as the agent does: it writes nothing while somebody else has the boat
    rig.run(3.0)
    assert rig.sent == sent
    assert rig.controller.thrusts.rear_port == pytest.approx(20.0)
    rig.controller.pilot(None)
    rig.run(1.0)
    assert rig.thrust == 0.0
    assert rig.helm.reading(rig.now_ns).authority == ""
    rig.agent_hangs = False
    rig.run(15.0, AHEAD)
    assert rig.hull.u == pytest.approx(1.0, abs=0.02)


def test_a_thruster_that_fails_is_said_and_the_boat_is_not_commanded() -> None:
    rig = under_way()
    rig.controller.faults = frozenset({"side port thruster failed", "low voltage"})
    rig.run(0.2, AHEAD)
    assert rig.helm.reading(rig.now_ns).trouble == "controller: side port thruster failed"
    assert rig.told[-1] == "controller: side port thruster failed"
    assert rig.seconds_until_no_thrust(command=AHEAD) <= 0.2


def test_water_in_the_hull_is_told_and_sailed_with(caplog: pytest.LogCaptureFixture) -> None:
    rig = under_way()
    rig.controller.faults = frozenset({"water in the hull"})
    rig.run(0.2, AHEAD)
    assert rig.told[-1] == ""
    assert "controller: water in the hull" in caplog.text


def test_a_controller_that_does_not_obey_is_said() -> None:
    rig = Rig()
    rig.deaf_controller = True
    rig.run(1.0)
    rig.run(1.5, AHEAD)
    assert "the controller does not obey: its mode stays standby" in rig.told


def test_before_anything_was_heard_nothing_is_known_and_nothing_can_be_commanded() -> None:
    rig = Rig()
    assert rig.helm.reading(rig.now_ns).stamp_ns == 0
    assert rig.helm.command(rig.now_ns, 1.0, 0.0) == "the controller on the CAN bus is silent"
    assert rig.helm.command(rig.now_ns, math.nan, 0.0) == "set-point nan, 0.0: expected numbers"


def test_the_reading_is_what_the_controller_says() -> None:
    rig = under_way((1.0, -0.2))
    reading = rig.helm.reading(rig.now_ns)
    assert reading.battery_percent == 80.0
    assert (reading.lat_deg, reading.lon_deg) == pytest.approx((44.38, 8.93), abs=1e-7)
    assert -math.pi <= reading.heading_rad <= math.pi
    assert reading.heading_rad == pytest.approx(rig.hull.psi, abs=0.03)
    assert reading.yaw_rate_radps == pytest.approx(-0.2, abs=0.01)
    assert rig.now_ns - reading.stamp_ns <= 50_000_000


def test_a_controller_without_sensors_is_steered_by_what_the_agent_knows() -> None:
    rig = Rig()
    rig.blind = rig.agent_knows = True
    rig.run(1.0)
    rig.run(20.0, (1.3, 0.3))
    assert set(rig.told) == {""}
    assert rig.hull.u == pytest.approx(1.3, abs=0.005)
    assert rig.hull.r == pytest.approx(0.3, abs=0.003)
    assert max(u for u, _ in rig.speeds) < 1.32
    assert max(r for _, r in rig.speeds) < 0.33
    rig.agent_knows = False  # it lost its sensors: what it knew is not used for longer than a command
    assert rig.seconds_until_no_thrust(command=(1.3, 0.3)) == pytest.approx(0.55, abs=0.1)
    rig.run(0.2, (1.3, 0.3))
    assert rig.told[-1] == "no heading, yaw rate or speed on the CAN bus"


def test_without_either_it_is_not_steered_at_all() -> None:
    rig = Rig()
    rig.blind = True
    rig.run(1.0)
    rig.run(2.0, AHEAD)
    assert rig.thrust == 0.0
