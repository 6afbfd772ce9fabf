"""A boat with an autopilot of its own: its frames go through unchanged, both ways, and nobody speaks in its name."""

from __future__ import annotations

import pytest
from msgspec import structs

from fleet.drivers.mavlink.frames import cut
from fleet.drivers.mavlink.handing import Handing, sets_point
from fleet.gcs.bridge import Bridge
from fleet.wire.messages import FleetEvent, Revision
from tests.gcs.deck import MAVLINK, Deck

PILOT = MAVLINK.MAVLink(None, srcSystem=7, srcComponent=1)


def frame(name: str, *fields: object, sysid: int = 7, component: int = 1) -> bytes:
    codec = MAVLINK.MAVLink(None, srcSystem=sysid, srcComponent=component)
    return bytes(getattr(MAVLINK, f"MAVLink_{name}_message")(*fields).pack(codec))


BEAT = frame("heartbeat", 11, 3, 129, 15, 4, 3)
MODE = frame("command_long", 7, 1, 176, 0, 1, 4, 0, 0, 0, 0, 0, sysid=255, component=190)


class Piloted(Deck):
    """b1 without, b2 with an autopilot of its own, sysid 7."""

    def __init__(self, *, takes: bool = True) -> None:
        self._takes = takes
        super().__init__("b1", "b2")

    def run(self, seconds: float = 0.05) -> None:
        view = self.views["b2"]
        assert view.status is not None
        view.status = structs.replace(view.status, autopilot=7, takes_frames=self._takes)
        super().run(seconds)


def test_no_second_heartbeat_speaks_for_an_autopilot() -> None:
    deck = Piloted()
    deck.run(3.0)
    assert {m.get_srcSystem() for m in deck.station.heard} == {1}


def test_its_frames_arrive_byte_for_byte_whatever_they_are() -> None:
    deck = Piloted()
    unknown = bytes((0xFD, 3, 0, 0, 9, 7, 1, 0x01, 0x02, 0x03)) + b"abc" + b"\x11\x22"  # an id that no dialect has
    old = bytes((0xFE, 2, 0, 7, 1, 5)) + b"ab" + b"\x33\x44"
    sent: list[bytes] = []
    deck.bridge.up("b2", BEAT + unknown + old + frame("heartbeat", 11, 3, 0, 0, 4, 3, sysid=1))
    for peer, datagram in deck.bridge.take_outbox():
        assert peer is None
        sent.append(datagram)
    assert sent == [BEAT, unknown, old], "and none that another made"


def test_what_is_for_it_goes_to_the_boat_byte_for_byte() -> None:
    deck = Piloted()
    deck.hear(deck.station.peer, MODE)
    deck.station.mode(1, 4)
    assert deck.bridge.passages.take() == {"b2": MODE}
    assert [m.command for m in deck.station.all("COMMAND_ACK")] == [176], "only b1's"


def test_what_is_for_all_goes_to_both() -> None:
    deck = Piloted()
    beat = frame("heartbeat", 6, 8, 0, 0, 4, 3, sysid=255)
    deck.hear(deck.station.peer, beat)
    assert deck.bridge.passages.take() == {"b2": beat}
    deck.station.say("param_request_list", 0, 1)
    assert deck.station.all("PARAM_VALUE", 1)
    assert deck.bridge.passages.take()["b2"]


def test_frames_for_a_boat_that_somebody_else_commands_do_not_go_on_and_it_is_said_once() -> None:
    deck = Piloted()
    deck.change("b2", control=Revision(1, "anna"))
    deck.run()
    for _ in range(3):
        deck.hear(deck.station.peer, MODE)
    assert deck.bridge.passages.take() == {}
    assert deck.station.texts(7) == ["anna holds control; `fleet take` takes it over"]
    assert deck.station.last("STATUSTEXT").get_srcComponent() == 191


def test_a_boat_that_takes_none_says_why() -> None:
    deck = Piloted(takes=False)
    deck.hear(deck.station.peer, MODE)
    assert deck.bridge.passages.take() == {}
    assert 'driver.mavlink.forward is not "both"' in deck.station.texts(7)[0]


def test_the_fleets_events_are_said_by_its_companion() -> None:
    deck = Piloted()
    deck.events = [
        FleetEvent(1, "b2", 1, "mode", "follow -> hold"),
        FleetEvent(1, "b2", 1, "autopilot", "Throttle armed"),
    ]
    deck.run()
    assert deck.station.texts(7) == ["fleet mode: follow -> hold"]


# -- on the boat ---------------------------------------------------------------------------------------------------
def test_frames_are_handed_on_only_while_somebody_listens() -> None:
    handing = Handing(7, 254)
    handing.tap(BEAT)
    assert handing.give(10.0) == b""
    handing.listened(10.0)
    handing.tap(BEAT)
    handing.tap(MODE)
    assert handing.give(11.0) == BEAT + MODE
    handing.tap(BEAT)
    assert handing.give(16.0) == b""


def test_the_agents_own_name_is_not_taken_by_a_ground_station() -> None:
    handing = Handing(7, 254)
    forged = frame("heartbeat", 6, 8, 0, 0, 4, 3, sysid=254)
    assert handing.take(forged, 1.0, driving=False) == ([], "a ground station uses sysid 254, which is not its own")
    assert handing.take(MODE, 1.0, driving=False) == ([MODE], "")


SET_POINTS = [
    frame("set_position_target_local_ned", 0, 7, 1, 8, 0x5C7, *(0.0,) * 11, sysid=255),
    frame("set_attitude_target", 0, 7, 1, 0, [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0, 0.0, sysid=255),
    frame("command_int", 7, 1, 0, 192, 0, 0, 0.0, 0.0, 0.0, 0.0, 1, 2, 0.0, sysid=255),
    frame("command_long", 7, 1, 192, 0, *(0.0,) * 7, sysid=255),
]


@pytest.mark.parametrize("point", SET_POINTS)
def test_set_points_of_a_ground_station_do_not_take_turns_with_the_agents(point: bytes) -> None:
    assert sets_point(point)
    assert Handing(7, 254).take(point, 1.0, driving=True)[0] == []
    assert Handing(7, 254).take(point, 1.0, driving=False)[0] == [point]
    assert not sets_point(MODE)


def test_a_flood_is_bounded_both_ways() -> None:
    handing = Handing(7, 254)
    handing.listened(0.0)
    passed = sum(len(handing.take(MODE * 10, k * 0.1, driving=False)[0]) for k in range(100)) * len(MODE)
    assert passed <= 2000 * 11
    sent = 0
    for k in range(100):
        handing.listened(k * 0.1)
        for _ in range(1000):
            handing.tap(BEAT)
        sent += len(handing.give(k * 0.1))
    assert sent <= 8000 * 10 + 16000
    assert handing.dropped > 0


def test_noise_is_cut_into_nothing_that_is_no_frame() -> None:
    assert list(cut(b"\x00\x01" + BEAT + b"\xfd\xff")) == [(BEAT, 7)]
    assert list(cut(b"\xfd")) == []


def test_a_bridge_passes_over_frames_in_the_name_of_its_own_vehicles() -> None:
    deck = Piloted()
    bridge: Bridge = deck.bridge
    deck.hear(deck.station.peer, frame("command_long", 1, 1, 176, 0, 1, 4, 0, 0, 0, 0, 0, sysid=7))
    deck.hear(deck.station.peer, frame("command_long", 1, 1, 176, 0, 1, 4, 0, 0, 0, 0, 0, sysid=1))
    assert bridge.counts["own"] == 2
    assert not deck.station.all("COMMAND_ACK")
