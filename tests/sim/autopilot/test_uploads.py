"""Missions are uploaded to the simulated autopilot as to ArduPilot Rover."""

from __future__ import annotations

from typing import Any

from fleet.sim.autopilot.uploads import CANCELLED, DENIED, UNSUPPORTED, WRONG_SEQUENCE
from tests.sim.autopilot.test_rover import MAVLINK, Lab

ME = MAVLINK.MAVLink(None, srcSystem=255, srcComponent=190)


def count(n: int) -> bytes:
    return bytes(MAVLINK.MAVLink_mission_count_message(1, 1, n, 0).pack(ME))


def item(seq: int, command: int = 16) -> bytes:
    make = MAVLINK.MAVLink_mission_item_int_message
    return bytes(make(1, 1, seq, 6, command, 0, 1, 0.0, 5.0, 0.0, 0.0, 443800000, 89300000, 0.0, 0).pack(ME))


def last(lab: Lab, kind: str) -> Any:
    return lab.of(kind)[-1]


def test_items_are_asked_for_one_by_one_and_acknowledged() -> None:
    lab = Lab()
    lab.tell(count(3))
    for seq in range(3):
        assert last(lab, "MISSION_REQUEST").seq == seq
        lab.tell(item(seq))
    assert last(lab, "MISSION_ACK").type == 0
    lab.tell(bytes(MAVLINK.MAVLink_mission_request_int_message(1, 1, 1, 0).pack(ME)))
    assert (last(lab, "MISSION_ITEM_INT").seq, last(lab, "MISSION_ITEM_INT").param2) == (1, 0.0)


def test_an_item_that_does_not_come_is_asked_for_each_second_and_given_up_after_eight() -> None:
    lab = Lab()
    lab.tell(count(2))
    lab.run(7.9)
    assert [m.seq for m in lab.of("MISSION_REQUEST")] == [0] * 8
    assert not lab.of("MISSION_ACK")
    lab.run(0.3)
    assert last(lab, "MISSION_ACK").type == CANCELLED


def test_what_came_before_an_unsupported_item_is_stored() -> None:
    lab = Lab()
    lab.tell(count(3))
    lab.tell(item(0))
    lab.tell(item(1, command=9999))
    assert last(lab, "MISSION_ACK").type == UNSUPPORTED
    assert len(lab.rover.uploads.stored[0]) == 1


def test_a_wrong_number_and_a_second_sender_are_refused() -> None:
    lab = Lab()
    lab.tell(count(2))
    lab.tell(item(1))
    assert last(lab, "MISSION_ACK").type == WRONG_SEQUENCE
    (said,) = MAVLINK.MAVLink(None).parse_buffer(count(2))
    lab.rover.hear("another", said)
    lab.listen()
    assert last(lab, "MISSION_ACK").type == DENIED
