"""The bus in memory: the honest twin of `zenoh_bus`, for lock-step simulation and for tests.

A `Water` joins the stations; what one publishes lies in the others' rings at once. Delay and loss are the radio's
(`fleet.wire.radio`), which sits on the receiving side of either bus.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from fleet.wire import keys
from fleet.wire.bus import OWN_KEPT, Answer, Heard, Request

RING = 256


class Water:
    """What joins the stations of one process."""

    def __init__(self, now_ns: Callable[[], int]) -> None:
        self.now_ns = now_ns
        self.boats: dict[str, MemoryBus] = {}
        self.tokens: set[str] = set()
        self.operators: set[str] = set()
        self.published: deque[tuple[str, str, bytes]] = deque(maxlen=65536)  # (what, boat, payload), for operators

    def ask_all(self, what: str, payload: bytes, on_answer: Callable[[str, bytes], None], boat: str = "*") -> None:
        """Ask boats as an operator does; answers arrive when the boats tick."""
        for name, bus in self.boats.items():
            if boat in ("*", name):
                bus.deposit_request(what, payload, lambda answer, name=name: on_answer(name, answer))  # type: ignore[misc]


class MemoryBus:
    """A boat's end of the water (see `fleet.wire.bus.Bus`)."""

    def __init__(self, water: Water, boat: str) -> None:
        self._water, self._boat = water, boat
        self._rings: dict[str, deque[Heard]] = {}
        self._requests: deque[Request] = deque(maxlen=512)
        self._answers: deque[Answer] = deque(maxlen=512)
        self._own: dict[str, deque[Heard]] = {}
        self._open = False
        self._lost = 0
        self.cut = False  # the own link is down

    def open(self) -> bool:
        """Join the water."""
        if not self._open:
            self._open = True
            self._water.boats.setdefault(self._boat, self)
        return True

    def alone_with_my_name(self) -> bool:
        """False when another station holds this name's token."""
        return self._boat not in self._water.tokens

    def announce(self) -> None:
        """Declare the token."""
        self._water.tokens.add(self._boat)

    def link_up(self) -> bool:
        """Whether the link is not cut."""
        return self._open and not self.cut

    def watch(self, boat: str) -> None:
        """Listen to a boat."""
        self._rings.setdefault(boat, deque(maxlen=RING))

    def unwatch(self, boat: str) -> None:
        """Listen to it no longer."""
        self._rings.pop(boat, None)

    def put_state(self, payload: bytes) -> None:
        """Publish the own state."""
        self.put(keys.STATE, payload)

    def put(self, what: str, payload: bytes) -> None:
        """Publish something of this boat."""
        if self.cut or not self._open:
            return
        self._water.published.append((what, self._boat, payload))
        if what == keys.STATE:
            now = self._water.now_ns()
            for other in self._water.boats.values():
                if other is not self and not other.cut:
                    other.deposit_state(self._boat, payload, now)

    def deposit_state(self, sender: str, payload: bytes, at_ns: int) -> None:
        """A state arrives."""
        ring = self._rings.get(sender)
        if ring is not None:
            self._lost += len(ring) == RING
            ring.append(Heard(sender, payload, at_ns))

    def poll_states(self, bound: int) -> list[Heard]:
        """States since the last call, at most `bound` a sender."""
        return [ring.popleft() for ring in self._rings.values() for _ in range(min(bound, len(ring)))]

    def deposit_request(self, what: str, payload: bytes, reply: Callable[[bytes], None]) -> None:
        """A request arrives."""
        if not self.cut:
            self._requests.append(Request(what, payload, reply, lambda: None))

    def poll_requests(self, bound: int) -> list[Request]:
        """Requests since the last call."""
        return [self._requests.popleft() for _ in range(min(bound, len(self._requests)))]

    def ask(self, boat: str, what: str, payload: bytes) -> None:
        """Ask one boat."""
        other = self._water.boats.get(boat)
        if other is None or self.cut:
            return

        def take(answer: bytes) -> None:
            if not (self.cut or other.cut):
                self._answers.append(Answer(boat, what, answer))

        other.deposit_request(what, payload, take)

    def poll_answers(self) -> list[Answer]:
        """Answers since the last call."""
        return [self._answers.popleft() for _ in range(len(self._answers))]

    def listen_own(self, what: str) -> None:
        """Keep what others publish under this boat's own name."""
        self._own.setdefault(what, deque(maxlen=OWN_KEPT))

    def deposit_own(self, what: str, payload: bytes) -> None:
        """Somebody on board has published."""
        if what in self._own and not self.cut:
            self._own[what].append(Heard(self._boat, payload, self._water.now_ns()))

    def poll_own(self, what: str) -> list[Heard]:
        """That, since the last call."""
        waiting = self._own.get(what, deque())
        return [waiting.popleft() for _ in range(len(waiting))]

    def alive(self) -> frozenset[str]:
        """Boats whose token is up."""
        return frozenset(self._water.tokens - {self._boat}) if self.link_up() else frozenset()

    def operators(self) -> frozenset[str]:
        """Operators who are there."""
        return frozenset(self._water.operators) if self.link_up() else frozenset()

    def overflowed(self) -> int:
        """Messages dropped because nobody fetched them."""
        return self._lost

    def close(self) -> None:
        """Leave the water."""
        self._open = False
        self._water.tokens.discard(self._boat)
        if self._water.boats.get(self._boat) is self:
            del self._water.boats[self._boat]
