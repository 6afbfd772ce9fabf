"""The simulated radio: delay, loss, outages; the same draws for the same numbers."""

from __future__ import annotations

import math
from typing import Any

import pytest

from fleet.wire import keys
from fleet.wire.memory_bus import MemoryBus, Water
from fleet.wire.radio import RadioBus, mix, number_of, uniform

TICK = 100_000_000


class Air:
    """Boat a speaks, boat b hears through a radio."""

    def __init__(self, *, delay_s: float = 0.0, loss: float = 0.0, seed: int = 0, me: str = "b") -> None:
        self.now = 10**18
        water = Water(lambda: self.now)
        self.a, self.inner = MemoryBus(water, "a"), MemoryBus(water, me)
        self.b = RadioBus(self.inner, me, lambda: self.now, seed)
        self.a.open()
        self.b.open()
        self.b.watch("a")
        self.b.set(delay_s, loss)

    def say(self, count: int) -> list[int]:
        """Numbers of the messages that arrive, one sent at each tick."""
        heard: list[int] = []
        for k in range(count):
            self.a.put_state(str(k).encode())
            heard += [int(m.payload) for m in self.b.poll_states(256)]
            self.now += TICK
        return heard


def test_a_good_radio_loses_and_delays_nothing() -> None:
    assert Air().say(100) == list(range(100))


def test_a_message_is_heard_after_its_delay_and_stamped_with_when_it_was_due() -> None:
    air = Air(delay_s=0.25)
    began = air.now
    air.a.put_state(b"0")
    arrived = []
    for _ in range(5):
        arrived += [(air.now - began, m.at_ns - began) for m in air.b.poll_states(256)]
        air.now += TICK
    assert arrived == [(3 * TICK, 250_000_000)]


def test_the_order_is_kept() -> None:
    air = Air(delay_s=0.35)
    heard = air.say(50)
    assert heard == sorted(heard)
    assert len(heard) == 46


@pytest.mark.parametrize("loss", [0.05, 0.3, 0.9])
def test_as_many_are_lost_as_was_asked_for(loss: float) -> None:
    count = 4000
    lost = count - len(Air(loss=loss, seed=1).say(count))
    assert lost / count == pytest.approx(loss, abs=4.0 * math.sqrt(loss * (1.0 - loss) / count))


def test_all_and_none() -> None:
    assert Air(loss=1.0).say(100) == []
    assert Air(loss=0.0).say(100) == list(range(100))


def test_the_same_seed_loses_the_same_messages() -> None:
    assert Air(loss=0.3, seed=5).say(300) == Air(loss=0.3, seed=5).say(300)
    assert Air(loss=0.3, seed=5).say(300) != Air(loss=0.3, seed=6).say(300)


def test_every_link_draws_for_itself() -> None:
    assert Air(loss=0.3, me="b").say(300) != Air(loss=0.3, me="c").say(300)


def test_losses_come_without_a_pattern() -> None:
    heard = set(Air(loss=0.5, seed=2).say(4000))
    runs = sum((k in heard) != (k + 1 in heard) for k in range(3999))
    assert runs / 3999 == pytest.approx(0.5, abs=0.04)


def test_an_outage_loses_everything_both_ways_and_is_a_link_down_after_two_seconds() -> None:
    air = Air()
    air.inner.watch("b")
    air.b.set_down(True)
    assert air.b.link_up()
    assert air.say(20) == []
    assert not air.b.link_up()
    assert air.b.alive() == air.b.operators() == frozenset()
    air.a.watch("b")
    air.b.put_state(b"x")
    air.b.put(keys.STATUS, b"x")
    assert air.a.poll_states(9) == []
    air.b.set_down(False)
    assert air.b.link_up()
    assert air.say(3) == [0, 1, 2]


def test_a_question_asked_through_a_lossy_radio_is_answered_or_dropped_never_both() -> None:
    air = Air(loss=0.5, seed=3)
    fates: list[str] = []
    for k in range(200):
        air.inner._requests.append(
            request(str(k).encode(), lambda answer: fates.append("answered"), lambda: fates.append("dropped"))
        )
        for asked in air.b.poll_requests(9):
            asked.reply(b"")
        air.now += TICK
    assert len(fates) == 200
    assert 60 < fates.count("dropped") < 140


def request(payload: bytes, reply: Any, drop: Any) -> Any:
    from fleet.wire.bus import Request

    return Request(keys.COMMAND, payload, reply, drop)


def test_the_hash_is_what_it_was_when_runs_were_recorded() -> None:
    assert mix(1, 2, 3) == mix(1, 2, 3)
    assert [mix(0), mix(1), mix(1, 2)] == GOLDEN_MIX
    assert number_of("b1") == GOLDEN_NUMBER
    assert mix(1, 2) != mix(2, 1)


def test_the_numbers_are_even() -> None:
    draws = [uniform(7, k) for k in range(10_000)]
    assert all(0.0 <= u < 1.0 for u in draws)
    assert sum(draws) / len(draws) == pytest.approx(0.5, abs=0.01)
    tenths = [sum(k / 10 <= u < (k + 1) / 10 for u in draws) for k in range(10)]
    assert max(tenths) - min(tenths) < 200


GOLDEN_MIX = [16294208416658607535, 10451216379200822465, 13608149317741381227]
GOLDEN_NUMBER = 623188930078801532
