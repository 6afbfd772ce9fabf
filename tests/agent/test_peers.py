"""Trouble with the others: silence, lost tokens, wrecks, their return (DESIGN section 3, rows 1 and 2)."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import pytest

from fleet.agent.modes import Mode, Reason
from fleet.mission.model import Start
from tests.agent.harness import CIRCUIT, TICK_NS, Sea, mission, sailing


def peer_of(sea: Sea, boat: str, other: str):
    """What `boat` hands to keeping clear about `other`."""
    agent = sea.agent(boat)
    number = agent.picture.others[other].number
    return next((peer for peer in agent.peers if peer.number == number), None)


def test_a_silent_boat_leaves_the_sums_within_seven_periods(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    assert [sea.members(boat) for boat in sea.agents()] == [2, 2, 2]
    sea.freeze("b2")
    sea.run(0.6)
    assert sea.members("b1") == sea.members("b3") == 2, "not before seven periods have passed"
    sea.run(0.2)
    assert sea.members("b1") == sea.members("b3") == 1
    assert Reason.PEER_SILENT in sea.reasons("b1")
    assert Reason.PEER_SILENT in sea.reasons("b3")


def test_a_silent_boat_is_left_out_at_once_and_not_faded_out(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.freeze("b2")
    weights: list[float] = []
    sea.each_tick.append(lambda: weights.append(sea.agent("b1").picture.others["b2"].weight))
    sea.run(2.0)
    assert set(weights) == {1.0, 0.0}


def test_a_silent_boat_stays_an_obstacle_for_as_long_as_it_is_silent(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    sea.run(120.0)
    assert peer_of(sea, "b1", "b2") is not None
    assert peer_of(sea, "b3", "b2") is not None


def test_the_radius_about_a_silent_boat_grows_by_20_cm_a_second_up_to_half_of_it(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    heard = sea.now_ns
    grown: list[tuple[float, float]] = []

    def look() -> None:
        peer = peer_of(sea, "b1", "b2")
        if peer.known == 0.0:
            grown.append(((sea.now_ns - heard) * 1e-9, peer.widen))

    sea.each_tick.append(look)
    sea.run(30.0)
    assert 0.3 <= grown[0][0] <= 0.4, "its token is gone: 0.3 s"
    assert all(widen == pytest.approx(min(0.2 * age, 3.0)) for age, widen in grown)
    assert grown[-1][1] == 3.0, "R / 2"


def test_a_silent_boat_is_anywhere_between_where_it_was_and_10_s_along_its_path(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    x0, _ = sea.where("b2")
    sea.kill("b2")
    sea.run(11.0)
    ahead, behind = peer_of(sea, "b1", "b2"), peer_of(sea, "b3", "b2")
    assert ahead.x == pytest.approx(x0 + 10.0, abs=0.3), "the boat ahead of it must count with its having sailed on"
    assert behind.x == pytest.approx(max(x0, sea.where("b3")[0]), abs=0.3), "the boat behind with its having stopped"
    sea.run(60.0)
    assert x0 - 0.3 <= peer_of(sea, "b1", "b2").x <= x0 + 10.3
    assert (behind.vx, behind.vy, behind.known) == (0.0, 0.0, 0.0)


def test_a_silent_boat_on_a_bend_is_predicted_along_its_path_not_off_the_tangent(tmp_path: Path) -> None:
    starts = [Start(s_m=s) for s in (45.0, 30.0)]
    sea = sailing(tmp_path, mission(2, 12.0, path=CIRCUIT, starts=starts), 5.0)
    path = sea.plan.boats[0].path
    sea.run_until(lambda: path.straight(sea.state("b1").s_m % path.length) < 2.0, 60.0)
    said = sea.state("b1")
    sea.kill("b1")
    sea.run(10.0)
    on_path = path.at(said.s_m + 10.0 * said.sog_mps)
    track = sea.agent("b2").picture.others["b1"].track
    assert track is not None
    agent = sea.agent("b2")
    at_end = agent.picture._silent_peer(
        agent.picture.others["b1"],
        track,
        sea.now_ns,
        (on_path.x, on_path.y),
        agent.company.along,
    )
    assert math.hypot(at_end.x - on_path.x, at_end.y - on_path.y) < 0.5


def test_an_operator_can_have_a_silent_boat_forgotten(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    sea.run(5.0)
    acks = sea.command("forget", names=("b2",))
    assert all(ack.ok for ack in acks.values())
    sea.tick()
    assert peer_of(sea, "b1", "b2") is None
    assert Reason.PEER_SILENT not in sea.reasons("b1")


def test_a_forgotten_boat_that_speaks_again_is_seen_again(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.cut("b2")
    sea.run(5.0)
    sea.command("forget", names=("b2",))
    sea.tick()
    assert peer_of(sea, "b1", "b2") is None
    sea.mend("b2")
    sea.run(0.2)
    assert peer_of(sea, "b1", "b2") is not None


@pytest.mark.parametrize("boats", [2, 3])
def test_the_return_of_a_silent_boat_is_no_bump_in_the_speed(tmp_path: Path, boats: int) -> None:
    sea = sailing(tmp_path, mission(boats, 12.0))
    sea.cut("b2")
    sea.run(3.0)
    ship = sea.world.ships["b2"]
    ship.state = type(ship.state)(ship.state.x - 15.0, *list_of(ship.state)[1:])  # far out of its place
    sea.run(20.0)
    at = len(sea.stations["b1"].history)
    sea.mend("b2")
    sea.run(10.0)
    assert sea.members("b1") == boats - 1
    speeds = [decision.u_plan for decision in sea.stations["b1"].history[at - 1 :]]
    steps = [abs(b - a) for a, b in itertools.pairwise(speeds)]
    assert max(speeds) - min(speeds) > 0.15, "it does come back into the sums"
    assert max(steps) <= 0.15, "tanh(0.3 / m x 10 m x 0.05) (C - u_min) a tick; all at once it would be 0.99 m/s"


def list_of(state: object) -> list[float]:
    return [getattr(state, name) for name in state.__struct_fields__]  # type: ignore[attr-defined]


def test_a_lost_token_shortens_the_patience_to_300_ms(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")  # its socket closes, its token goes
    sea.run(0.2)
    assert sea.members("b1") == 2
    sea.run(0.2)
    assert sea.members("b1") == 1


def test_a_boat_with_fresh_state_is_never_dropped_though_every_token_is_gone(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.water.tokens.clear()  # a dying hub deletes them all at once
    counts: list[int] = []
    sea.each_tick.append(lambda: counts.extend(sea.members(boat) for boat in sea.agents()))
    sea.run(10.0)
    assert set(counts) == {2}


def test_tokens_say_nothing_while_the_own_link_is_down(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    agent = sea.agent("b1")
    assert agent.bus.link_up()
    station = sea.stations["b1"]
    assert station.bus is not None
    station.bus.cut = True
    sea.run(0.6)
    assert sea.members("b1") == 2, "no token is seen, but that is our own fault: 0.7 s hold"
    sea.run(0.2)
    assert sea.members("b1") == 0


def test_a_radio_that_loses_every_tenth_message_and_is_200_ms_late_drops_nobody(tmp_path: Path) -> None:
    sea = sailing(tmp_path, delay_s=0.2, loss=0.1, seed=3)
    silent: list[bool] = []
    sea.each_tick.append(lambda: silent.extend(Reason.PEER_SILENT in sea.reasons(boat) for boat in sea.agents()))
    sea.run(60.0)
    assert not any(silent)
    lost = sum(other.lost for other in sea.agent("b1").picture.others.values())
    heard = sum(other.heard for other in sea.agent("b1").picture.others.values())
    assert 0.05 < lost / (lost + heard) < 0.16


@pytest.mark.parametrize("method", ["scoring", "circle"])
def test_a_dead_boat_on_the_path_is_passed_and_not_rammed(tmp_path: Path, method: str) -> None:
    sea = sailing(tmp_path, mission(3, 12.0, method=method))
    sea.kill("b1")
    x1, _ = sea.where("b1")
    sea.run(90.0)
    assert sea.least_m > 3.5, "hulls touch at 2.4 m"
    assert sea.where("b2")[0] > x1 + 10.0
    assert sea.where("b3")[0] > x1 + 5.0


def test_a_killed_boat_is_back_in_formation_soon_after_its_restart(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.kill("b2")
    sea.run(3.0)
    sea.restart("b2")
    sea.run(5.0)
    assert sea.mode("b2") in (Mode.FOLLOW, Mode.AVOID)
    assert sea.members("b1") == sea.members("b2") == 2
    assert sea.says("b2", "resumed")


def test_nothing_is_random(tmp_path: Path) -> None:
    def run(folder: Path) -> list[float]:
        sea = sailing(folder, delay_s=0.1, loss=0.2, seed=7)
        sea.change(spacing_m=15.0)
        sea.run(20.0)
        return [coordinate for boat in sea.agents() for coordinate in sea.where(boat)]

    assert run(tmp_path / "one") == run(tmp_path / "two")


def test_a_tick_lasts_a_tenth_of_a_second(tmp_path: Path) -> None:
    sea = Sea(tmp_path)
    sea.run(1.0)
    assert sea.time_s == pytest.approx(10 * TICK_NS * 1e-9)
