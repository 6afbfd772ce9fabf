"""Words to the fleet: in their order, stops at once, equal ones together; what comes back is said in words."""

from __future__ import annotations

import threading
from typing import Any

from fleet.errors import NobodyReachable
from fleet.gcs.captain import Captain, fulfil
from fleet.gcs.wishes import Done, Wish
from fleet.operator import Outcome
from fleet.wire.messages import MAJOR, Ack


class Fleet:
    """Answers as it is told to; notes what it was asked."""

    def __init__(self) -> None:
        self.said: list[tuple[str, tuple[str, ...]]] = []
        self.go = threading.Event()
        self.go.set()
        self.refuses = ""
        self.silent: tuple[str, ...] = ()

    def _word(self, kind: str, boats: list[str]) -> Outcome:
        self.go.wait(10.0)
        self.said.append((kind, tuple(boats)))
        acks: dict[str, Ack | None] = {
            boat: None if boat in self.silent else Ack(MAJOR, "1", boat, not self.refuses, self.refuses)
            for boat in boats
        }
        return Outcome(kind, "id-1", acks)

    def hold(self, boats: list[str]) -> Outcome:
        return self._word("hold", boats)

    def resume(self, boats: list[str]) -> Outcome:
        return self._word("resume", boats)

    def return_home(self, boats: list[str]) -> Outcome:
        return self._word("return", boats)

    def stop_now(self, boats: list[str]) -> Outcome:
        self.said.append(("stop", tuple(boats)))
        return Outcome("stop-now", "stop-1", {boat: Ack(MAJOR, "1", boat, True, "") for boat in boats})

    def set(self, what: str, value: float) -> Outcome:
        return self._word(f"set {what} {value:g}", ["b1", "b2"])


def wishes(*kinds: tuple[str, str]) -> list[Wish]:
    return [Wish(i, kind, boat) for i, (kind, boat) in enumerate(kinds)]  # type: ignore[arg-type]


def finished(captain: Captain, count: int) -> list[Done]:
    """So many, however long it takes."""
    found: list[Done] = []
    wait = threading.Event()
    for _ in range(2000):
        found += captain.done()
        if len(found) >= count:
            return found
        wait.wait(0.005)
    raise AssertionError(found)


def test_equal_words_in_a_row_are_one_command_and_the_order_stays() -> None:
    fleet: Any = Fleet()
    captain = Captain(fleet)
    captain.ask(wishes(("hold", "b1"), ("hold", "b2"), ("hold", "b1"), ("resume", "b1"), ("hold", "b1")))
    captain.start()
    assert {done.number for done in finished(captain, 5)} == set(range(5))
    captain.close()
    assert fleet.said == [("hold", ("b1", "b2")), ("resume", ("b1",)), ("hold", ("b1",))]


def test_a_stop_does_not_wait_for_words_that_wait_for_boats() -> None:
    fleet: Any = Fleet()
    fleet.go.clear()
    captain = Captain(fleet)
    captain.start()
    captain.ask(wishes(("return", "b1"), ("stop", "b1")))
    assert [(done.number, done.value) for done in finished(captain, 1)] == [(1, "stop-1")]
    fleet.go.set()
    finished(captain, 1)
    captain.close()


def test_what_a_boat_refuses_and_what_it_does_not_answer_are_told_apart() -> None:
    fleet: Any = Fleet()
    fleet.silent = ("b2",)
    fleet.refuses = "bob holds control"
    one, two = fulfil(fleet, wishes(("hold", "b1"), ("hold", "b2")))
    assert (one.ok, one.text, one.silent) == (False, "bob holds control", False)
    assert (two.ok, two.text, two.silent) == (False, "b2 does not answer", True)


def test_a_change_that_one_boat_has_reaches_the_others_by_itself() -> None:
    fleet: Any = Fleet()
    fleet.silent = ("b2",)
    done = fulfil(fleet, [Wish(0, "set", "b1", ("spacing", 12.0))])[0]
    assert (done.ok, done.text) == (True, "b2 did not answer")
    fleet.silent, fleet.refuses = (), "too close"
    done = fulfil(fleet, [Wish(0, "set", "b1", ("spacing", 3.0))])[0]
    assert (done.ok, done.text) == (False, "too close"), "the same words once"


def test_nobody_in_reach_is_an_answer_too() -> None:
    fleet: Any = Fleet()

    def lost(boats: list[str]) -> Outcome:
        raise NobodyReachable("hold: no boat\nin reach")

    fleet.hold = lost
    assert fulfil(fleet, wishes(("hold", "b1"))) == [Done(0, False, "hold: no boat in reach", True)]
