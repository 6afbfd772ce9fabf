"""What an operator's connection says to whom, and in which order."""

from __future__ import annotations

import time
from collections.abc import Sequence

import pytest

from fleet.mission.load import encode as encode_mission
from fleet.mission.load import load
from fleet.operator import Fleet
from fleet.wire import keys
from fleet.wire.codec import decode, encode
from fleet.wire.messages import MAJOR, Ack, Command, Held, MissionOrder, Signed

MISSION = load("overtaking")  # of b1 and b2


class Shore:
    """Boats that answer at once, if they are alive; what was asked, in order."""

    def __init__(self, *alive: str) -> None:
        self.asked: list[tuple[str, str]] = []
        self._alive = frozenset(alive)

    def open(self, timeout_s: float) -> bool:  # noqa: ARG002
        return True

    def listen(self, what: Sequence[str]) -> None: ...

    def heard(self) -> list[tuple[str, str, bytes]]:
        return []

    def alive(self) -> frozenset[str]:
        return self._alive

    def ask_all(self, what: str, payload: bytes, timeout_s: float, boat: str = "*") -> dict[str, bytes]:  # noqa: ARG002
        self.asked.append((what, boat))
        who = [one for one in sorted(self._alive) if boat in ("*", one)]
        if what == keys.COMMAND:
            said = decode(payload, Command)
            return {one: encode(Ack(MAJOR, said.id, one, True, "")) for one in who}
        order = MissionOrder(MAJOR, "m", "anna", 1, encode_mission(MISSION), 0.0) if what == keys.MISSION else None
        return {one: encode(Held(MAJOR, Signed(encode(order)) if order is not None else None, 0.0)) for one in who}

    def tell(self, what: str, payload: bytes, boat: str) -> None: ...

    def close(self) -> None: ...


@pytest.mark.parametrize("word", ["stop_now", "hold", "abort"])
def test_a_word_that_stops_is_said_before_anybody_is_asked_anything(word: str) -> None:
    shore = Shore("b1", "b2")
    outcome = getattr(Fleet(operator="anna", bus=shore), word)()
    assert outcome.ok
    assert shore.asked[0] == (keys.COMMAND, "*"), "and to all, whether known to be alive or not"
    assert [what for what, _ in shore.asked].count(keys.COMMAND) == 1


def test_a_boat_of_the_mission_that_is_gone_is_named_as_one_that_did_not_answer() -> None:
    began = time.monotonic()
    outcome = Fleet(operator="anna", bus=Shore("b1"), timeout_s=0.2).stop_now()
    assert {boat: ack is not None for boat, ack in outcome.acks.items()} == {"b1": True, "b2": False}
    assert not outcome.ok
    assert time.monotonic() - began < 2.0


def test_other_words_are_for_everybody_of_the_mission_from_the_beginning() -> None:
    shore = Shore("b1", "b2")
    assert Fleet(operator="anna", bus=shore).resume().ok
    assert shore.asked[0][0] == keys.MISSION
