"""A boat with a real autopilot, as far as one can be had: its driver, the simulated one over UDP, and the bridge."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

import pytest

from fleet.drivers.mavlink.words import GUIDED, HOLD
from tests.drivers.mavlink.bench import Bench, on_a_bench
from tests.gcs.deck import MAVLINK

CODEC = MAVLINK.MAVLink(None, srcSystem=255, srcComponent=190)


def said(name: str, *fields: object, sysid: int = 255) -> bytes:
    codec = MAVLINK.MAVLink(None, srcSystem=sysid, srcComponent=190)
    return bytes(getattr(MAVLINK, f"MAVLink_{name}_message")(*fields).pack(codec))


@pytest.fixture
def bench() -> Iterator[Bench]:
    with on_a_bench(forward="both") as one:
        yield one


def mode(number: int) -> bytes:
    return said("command_long", 1, 1, 176, 0, 1, number, 0, 0, 0, 0, 0)


def heard(bench: Bench, seconds: float, until: Callable[[], bool] = lambda: False) -> list[object]:
    """What a ground station gets of the autopilot."""
    reader, messages = MAVLINK.MAVLink(None), []
    for _ in range(round(seconds * 10)):
        bench.driver.hand_in(b"")
        bench.run(0.1)
        messages += reader.parse_buffer(bytearray(bench.driver.handed_on())) or []
        if until():
            break
    return messages


def test_a_ground_station_hears_the_autopilot_itself(bench: Bench) -> None:
    messages = heard(bench, 5.0)
    kinds = {m.get_type() for m in messages}
    assert {"HEARTBEAT", "GLOBAL_POSITION_INT", "ATTITUDE", "SYS_STATUS", "VFR_HUD"} <= kinds, "those unread here, too"
    assert {(m.get_srcSystem(), m.get_srcComponent()) for m in messages} == {(1, 1)}
    numbers = [m.get_seq() for m in messages]
    assert all((b - a) % 256 == 1 for a, b in pairwise(numbers)), "none is missing"


def test_parameters_of_the_autopilot_are_set_and_answered_through_the_boat(bench: Bench) -> None:
    heard(bench, 2.0)
    assert bench.driver.hand_in(said("param_set", 1, 1, b"WP_SPEED", 3.0, 9)) == ""
    answers = [m for m in heard(bench, 1.0) if m.get_type() == "PARAM_VALUE"]
    assert [(m.param_id, m.param_value) for m in answers] == [("WP_SPEED", 3.0)]
    assert bench.rover.parameters["WP_SPEED"] == 3.0


def test_a_mode_that_a_ground_station_sets_is_a_loss_of_authority_and_not_fought(bench: Bench) -> None:
    bench.launch()
    bench.run(3.0, (1.0, 0.0))
    assert bench.driver.hand_in(mode(HOLD)) == ""
    bench.run(3.0, (1.0, 0.0))
    assert bench.rover.mode == HOLD
    assert bench.reading.authority == "pilot or ground station: HOLD"
    assert bench.driver.hand_in(mode(GUIDED)) == ""
    bench.run(3.0, (1.0, 0.0))
    assert bench.reading.authority == ""
    assert bench.state.u > 0.3, "given back, it goes on"


def test_a_ground_stations_set_points_do_not_take_turns_with_the_agents(bench: Bench) -> None:
    bench.launch()
    bench.run(5.0, (1.0, 0.0))
    astern = said("set_position_target_local_ned", 0, 1, 1, 8, 0x5C7, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0)
    for _ in range(20):
        assert bench.driver.hand_in(astern) == "a ground station's set-point: the agent steers"
        bench.run(0.1, (1.0, 0.0))
    assert bench.state.u > 0.9


def test_a_heartbeat_under_the_agents_name_does_not_keep_the_failsafe_quiet(bench: Bench) -> None:
    bench.rover.parameters |= {"MAV_GCS_SYSID": 254.0, "FS_GCS_ENABLE": 1.0}
    bench.launch()
    bench.run(2.0, (1.0, 0.0))
    forged = said("heartbeat", 6, 8, 0, 0, 4, 3, sysid=254)
    assert "which is not its own" in bench.driver.hand_in(forged)


def test_out_hands_nothing_in_and_off_hands_nothing_on() -> None:
    with on_a_bench(forward="out") as bench:
        assert heard(bench, 2.0)
        assert bench.driver.hand_in(mode(HOLD)) == 'driver.mavlink.forward is not "both"'
    with on_a_bench() as bench:
        assert bench.driver.sysid == 0
        assert not heard(bench, 2.0)
