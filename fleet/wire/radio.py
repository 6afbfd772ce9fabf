"""The radio of the simulation: delay, loss and outages as the receiving station hears them.

Every draw is a hash of (seed, sender, receiver, purpose, number), so that a run, a lane of a batch and a replay lose
the same messages. It wraps a bus and is itself one.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import TypeVar

from fleet.wire.bus import Answer, Bus, Heard, Request

T = TypeVar("T")
_MASK = (1 << 64) - 1
LEASE_S = 2.0  # an outage longer than this is a link that is down


def mix(*parts: int) -> int:
    """64 well-mixed bits of whole numbers (splitmix64 over the parts)."""
    h = 0
    for part in parts:
        h = (h + (part & _MASK) + 0x9E3779B97F4A7C15) & _MASK
        h = ((h ^ (h >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
        h = ((h ^ (h >> 27)) * 0x94D049BB133111EB) & _MASK
        h ^= h >> 31
    return h


def uniform(*parts: int) -> float:
    """A number in [0, 1) that depends on the parts only."""
    return (mix(*parts) >> 11) * (1.0 / (1 << 53))


def number_of(name: str) -> int:
    """A name as a whole number, the same on every machine."""
    h = 0xCBF29CE484222325
    for byte in name.encode():
        h = ((h ^ byte) * 0x100000001B3) & _MASK
    return h


class RadioBus:
    """A bus heard through a bad radio."""

    def __init__(self, bus: Bus, boat: str, now_ns: Callable[[], int], seed: int = 0) -> None:
        self._bus, self._me, self._now, self._seed = bus, number_of(boat), now_ns, seed
        self.delay_s, self.loss, self.down_since_ns = 0.0, 0.0, 0
        self._states: list[tuple[int, int, Heard]] = []
        self._requests: list[tuple[int, int, Request]] = []
        self._answers: list[tuple[int, int, Answer]] = []
        self._drawn = 0
        self._counts: dict[str, int] = {}

    def set(self, delay_s: float, loss: float) -> None:
        """Delay of every message [s], share of messages lost."""
        self.delay_s, self.loss = delay_s, loss

    def set_down(self, down: bool) -> None:
        """Cut the radio, or restore it."""
        if down != bool(self.down_since_ns):
            self.down_since_ns = self._now() if down else 0

    def _lost(self, sender: str) -> bool:
        if self.down_since_ns:
            return True
        if self.loss <= 0.0:
            return False
        count = self._counts[sender] = self._counts.get(sender, 0) + 1
        return uniform(self._seed, number_of(sender), self._me, count) < self.loss

    def _due(self) -> int:
        self._drawn += 1
        return self._now() + int(self.delay_s * 1e9)

    # -- what is heard through the radio -----------------------------------------------------------------------------
    def poll_states(self, bound: int) -> list[Heard]:
        """States whose delay has passed."""
        heard = self._bus.poll_states(bound)
        if self.delay_s <= 0.0 and self.loss <= 0.0 and not self.down_since_ns and not self._states:
            return heard
        for message in heard:
            if not self._lost(message.sender):
                heapq.heappush(self._states, (self._due(), self._drawn, message))
        return [m._replace(at_ns=due) for due, m in self._fetch(self._states)]

    def poll_requests(self, bound: int) -> list[Request]:
        """Requests whose delay has passed; a lost one is never answered."""
        polled = self._bus.poll_requests(bound)
        if not polled and not self._requests:
            return polled
        for request in polled:
            if self._lost(request.what):
                request.drop()
            else:
                heapq.heappush(self._requests, (self._due(), self._drawn, request))
        return [request for _, request in self._fetch(self._requests)]

    def poll_answers(self) -> list[Answer]:
        """Answers whose delay has passed."""
        polled = self._bus.poll_answers()
        if not polled and not self._answers:
            return polled
        for answer in polled:
            if not self._lost(answer.boat):
                heapq.heappush(self._answers, (self._due(), self._drawn, answer))
        return [answer for _, answer in self._fetch(self._answers)]

    def _fetch(self, queue: list[tuple[int, int, T]]) -> list[tuple[int, T]]:
        now = self._now()
        due: list[tuple[int, T]] = []
        while queue and queue[0][0] <= now:
            at, _, item = heapq.heappop(queue)
            due.append((at, item))
        return due

    def link_up(self) -> bool:
        """Down when the bus is, and while an outage has outlasted the lease."""
        silent_ns = self._now() - self.down_since_ns if self.down_since_ns else 0
        return self._bus.link_up() and silent_ns < LEASE_S * 1e9

    def alive(self) -> frozenset[str]:
        """Boats whose token is up, as far as the link tells."""
        return self._bus.alive() if self.link_up() else frozenset()

    def operators(self) -> frozenset[str]:
        """Operators who are there, as far as the link tells."""
        return self._bus.operators() if self.link_up() else frozenset()

    # -- what passes as it is ----------------------------------------------------------------------------------------
    def put_state(self, payload: bytes) -> None:
        """Publish the own state, unless the radio is cut."""
        if not self.down_since_ns:
            self._bus.put_state(payload)

    def put(self, what: str, payload: bytes) -> None:
        """Publish something, unless the radio is cut."""
        if not self.down_since_ns:
            self._bus.put(what, payload)

    def ask(self, boat: str, what: str, payload: bytes) -> None:
        """Ask a boat, unless the radio is cut."""
        if not self.down_since_ns:
            self._bus.ask(boat, what, payload)

    def open(self) -> bool:
        """Connect."""
        return self._bus.open()

    def alone_with_my_name(self) -> bool:
        """False when somebody else is alive under this name."""
        return self._bus.alone_with_my_name()

    def announce(self) -> None:
        """Declare the token."""
        self._bus.announce()

    def watch(self, boat: str) -> None:
        """Listen to a boat."""
        self._bus.watch(boat)

    def unwatch(self, boat: str) -> None:
        """Listen to it no longer."""
        self._bus.unwatch(boat)

    def listen_own(self, what: str) -> None:
        """Keep what others on board publish."""
        self._bus.listen_own(what)

    def poll_own(self, what: str) -> list[Heard]:
        """That, since the last call; it does not go over the radio."""
        return self._bus.poll_own(what)

    def overflowed(self) -> int:
        """Messages dropped because nobody fetched them."""
        return self._bus.overflowed()

    def close(self) -> None:
        """Leave the network."""
        self._bus.close()
