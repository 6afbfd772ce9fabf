"""Two boats under one name, restarts, replays, impostors (DESIGN section 4, Identity)."""

from __future__ import annotations

from pathlib import Path

import pytest

from fleet.agent.modes import Mode, Reason
from fleet.wire.messages import BoatState
from tests.agent.harness import Sea, forged, mission, sailing

FAR_NORTH_DEG = 0.0002  # 22 m


class Impostor:
    """Another process under the name of b2, some way off, with states that are well-formed."""

    def __init__(self, sea: Sea, epoch: int = 0, to: tuple[str, ...] | None = None) -> None:
        self.sea, self.model, self.seq, self.to = sea, sea.state("b2"), 0, to
        self.epoch = epoch or self.model.epoch + 12345
        self.speaks = True
        sea.each_tick.append(self.speak)

    def speak(self) -> None:
        if not self.speaks:
            return
        self.seq += 1
        self.sea.say_as("b2", self.state(), self.to)

    def state(self) -> bytes:
        lat_deg = self.model.lat_deg + FAR_NORTH_DEG
        return forged(self.model, epoch=self.epoch, seq=self.seq, stamp_ns=self.sea.now_ns, lat_deg=lat_deg)


def obstacles_of(sea: Sea, boat: str, name: str) -> list[float]:
    agent = sea.agent(boat)
    return sorted(peer.x for peer in agent.peers if agent.picture.name_of(peer.number) == name)


def test_a_new_epoch_replaces_the_old_at_once(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0))
    old = sea.state("b2").epoch
    sea.restart("b2")
    sea.run(0.3)  # as soon as the old one has missed its turn: one forged message must not replace a boat that speaks
    track = sea.agent("b1").picture.others["b2"].track
    assert track is not None
    assert track.state.epoch != old
    sea.run(3.0)
    assert len(sea.agent("b1").peers) == 1, "nothing is left of the old one"
    assert Reason.IDENTITY_CLASH not in sea.reasons("b1")


def test_two_epochs_that_alternate_for_a_second_are_a_clash(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    Impostor(sea)
    sea.run(0.8)
    assert Reason.IDENTITY_CLASH not in sea.reasons("b1")
    sea.run(0.5)
    assert Reason.IDENTITY_CLASH in sea.reasons("b1")
    assert "two boats use one name" in sea.statuses["b1"].reasons, "the operator is told"


def test_in_a_clash_both_are_obstacles_and_neither_is_a_member(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    assert sea.members("b1") == 2
    Impostor(sea)
    sea.run(2.0)
    assert len(obstacles_of(sea, "b1", "b2")) == 2
    assert sea.members("b1") == 1
    assert [peer.known for peer in sea.agent("b1").peers if sea.agent("b1").picture.name_of(peer.number) == "b2"] == [
        0,
        0,
    ]


def test_a_boat_whose_name_another_uses_says_so_itself(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    Impostor(sea)
    sea.run(2.0)
    assert Reason.IDENTITY_CLASH in sea.reasons("b2")


def test_when_the_impostor_falls_silent_the_boat_is_itself_again(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    impostor = Impostor(sea)
    sea.run(3.0)
    impostor.speaks = False
    sea.run(4.0)
    assert Reason.IDENTITY_CLASH not in sea.reasons("b1")
    assert obstacles_of(sea, "b1", "b2") == [pytest.approx(sea.where("b2")[0], abs=0.5)]
    assert sea.members("b1") == 2


def test_when_the_true_boat_falls_silent_the_other_stays_an_obstacle(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    Impostor(sea)
    sea.run(3.0)
    sea.freeze("b2")
    sea.run(3.0)
    assert len(obstacles_of(sea, "b1", "b2")) == 1


def test_an_impostor_that_comes_and_goes_evicts_nobody(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    impostor = Impostor(sea)
    for _ in range(4):
        impostor.speaks = True
        sea.run(0.3)
        impostor.speaks = False
        sea.run(3.0)
        assert obstacles_of(sea, "b1", "b2") == [pytest.approx(sea.where("b2")[0], abs=0.5)]
        assert sea.members("b1") == 2


def test_old_states_played_again_are_refused_and_the_good_boat_stays(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    kept: list[bytes] = []
    sea.each_tick.append(lambda: kept.append(sea.raw["b2"]))
    sea.run(5.0)
    sea.each_tick.clear()
    for payload in kept:
        sea.say_as("b2", payload)
        sea.tick()
        assert sea.members("b1") == 2
    assert sea.agent("b1").picture.refused["old or doubled"] == len(kept)


def test_states_of_the_process_before_played_again_are_refused(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    kept: list[bytes] = []
    sea.each_tick.append(lambda: kept.append(sea.raw["b2"]))
    sea.run(5.0)
    sea.each_tick.clear()
    sea.restart("b2")
    sea.run(5.0)
    for payload in kept:
        sea.say_as("b2", payload)
        sea.tick()
        assert len(obstacles_of(sea, "b1", "b2")) == 1
        assert sea.members("b1") == 2
    assert sea.agent("b1").picture.refused["replay"] == len(kept)


def test_states_of_yesterday_played_to_a_boat_that_never_heard_them_are_refused(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    yesterday = sea.now_ns - 86_400 * 10**9
    impostor = Impostor(sea, epoch=yesterday)
    impostor.state = lambda: forged(  # type: ignore[method-assign]
        impostor.model, epoch=yesterday, seq=impostor.seq, stamp_ns=yesterday + impostor.seq * 10**8
    )
    sea.run(3.0)
    assert sea.agent("b1").picture.refused["replay"] > 20
    assert sea.members("b1") == 2
    assert Reason.IDENTITY_CLASH not in sea.reasons("b1")


def test_one_message_with_a_huge_number_does_not_shut_out_the_true_boat(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    state: BoatState = sea.state("b2")
    sea.say_as("b2", forged(state, seq=1 << 60))
    sea.run(1.0)
    assert sea.members("b1") == 2
    assert sea.agent("b1").picture.refused["impossible sequence number"] == 1


def test_a_boat_back_from_a_long_outage_may_have_counted_on(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    sea.cut("b2")
    sea.run(150.0)
    sea.mend("b2")
    sea.run(0.3)
    assert sea.agent("b1").picture.refused.total() == 0


def test_a_jump_is_believed_when_it_is_confirmed_ten_times_in_a_row_and_not_before(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    agent = sea.agent("b1")

    def jumps(count: int) -> None:
        for _ in range(count):
            sea.stations["b2"].frozen = True
            sea.tick()
            model = sea.state("b2")
            seq = model.seq + 1 + jumps.sent  # type: ignore[attr-defined]
            jumps.sent += 1  # type: ignore[attr-defined]
            sea.say_as("b2", forged(model, seq=seq, stamp_ns=sea.now_ns, lat_deg=model.lat_deg + 0.01))

    jumps.sent = 0  # type: ignore[attr-defined]
    x, _ = sea.where("b2")
    jumps(9)
    sea.tick()
    track = agent.picture.others["b2"].track
    assert track is not None
    assert track.x == pytest.approx(x, abs=2.0)
    jumps(2)
    sea.tick()
    assert track.x == pytest.approx(x + 1111.0, abs=20.0)


def test_doubts_do_not_add_up_over_good_messages(tmp_path: Path) -> None:
    sea = sailing(tmp_path)
    picture = sea.agent("b1").picture
    for k in range(30):
        model = sea.state("b2")
        if k % 2:
            sea.say_as("b2", forged(model, seq=model.seq + 1, stamp_ns=sea.now_ns, lat_deg=model.lat_deg + 0.01))
        sea.tick()
    track = picture.others["b2"].track
    assert track is not None
    assert track.x == pytest.approx(sea.where("b2")[0], abs=2.0)
    assert picture.refused["impossible jump"] == 15


def test_an_agent_that_finds_its_own_name_alive_stands_by(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(2, 12.0))
    sea.agent("b2").name_taken = True  # as the announcer finds out
    sea.run(0.5)
    sea.launch()
    sea.run(5.0)
    assert sea.mode("b2") == Mode.STANDBY
    assert Reason.NAME_TAKEN in sea.reasons("b2")
    assert not sea.powered("b2")


def test_a_name_is_found_to_be_alive(tmp_path: Path) -> None:
    from fleet.wire.memory_bus import MemoryBus

    sea = Sea(tmp_path, mission(2, 12.0))
    twin = MemoryBus(sea.water, "b2")
    twin.open()
    assert not twin.alone_with_my_name()
    sea.kill("b2")
    assert twin.alone_with_my_name()


def test_simulated_boats_are_never_members_of_a_real_boats_formation(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(3, 12.0))
    sea.kill("b1")
    sea.stations["b1"].driver.simulated = False
    sea.stations["b1"].switch_on()
    sea.run(0.5)
    assert all(ack.ok for ack in sea.launch().values())
    sea.run(10.0)
    assert sea.members("b1") == 0
    assert sea.members("b2") == sea.members("b3") == 1, "nor a real one of theirs"
    assert len(sea.agent("b1").peers) == 2, "but it keeps clear of them"


def test_a_real_boat_takes_neither_mission_nor_formation_from_simulated_ones(tmp_path: Path) -> None:
    sea = Sea(tmp_path, mission(3, 12.0), ashore=("b1",))
    sea.run(0.5)
    sea.launch()
    sea.run(5.0)
    sea.stations["b1"].driver.simulated = False
    sea.stations["b1"].switch_on()
    sea.run(5.0)
    assert not sea.holds_mission("b1")
