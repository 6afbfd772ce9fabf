"""What joins the boats of a lock-step simulation: water that carries what they say, a boat's hardware, a boat's disk.

What is said in one tick is heard in the next, so that it does not matter who ticks first.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

import msgspec

from fleet.agent.picture import Directions, directions
from fleet.agent.store import Store, T
from fleet.drivers.seam import Reading
from fleet.sim.scanner.cast import Eye, wanted
from fleet.sim.world import World
from fleet.wire import keys
from fleet.wire.bus import Answer, Request
from fleet.wire.memory_bus import MemoryBus, Water
from fleet.wire.messages import BoatState

Tap = Callable[[str, str, bytes], None]
EVENTS_KEPT = 10_000
NOBODY: frozenset[str] = frozenset()


class Tide(Water):
    """The water of one simulation."""

    def __init__(self, now_ns: Callable[[], int], operator: str) -> None:
        super().__init__(now_ns)
        self.operator, self.ashore = operator, NOBODY
        self.moorings: dict[str, Mooring] = {}
        self._said: list[tuple[str, str, bytes]] = []
        self._asked: list[tuple[Mooring, str, str, bytes]] = []
        self._alive: dict[str, frozenset[str]] = {}
        self._heard: dict[str, tuple[BoatState, Directions]] = {}

    def directions(self, state: BoatState) -> Directions:
        """As `fleet.agent.picture.directions`, once for all who hear the same message in this process."""
        last = self._heard.get(state.boat)
        if last is None or last[0] is not state:
            last = self._heard[state.boat] = state, directions(state)
        return last[1]

    def say(self, what: str, boat: str, payload: bytes) -> None:
        """A boat publishes something."""
        self._said.append((what, boat, payload))

    def ask(self, sender: Mooring, boat: str, what: str, payload: bytes) -> None:
        """A boat asks another."""
        self._asked.append((sender, boat, what, payload))

    def flow(self, tap: Tap) -> None:
        """End of a tick: what was said lies in the others' rings; `tap` gets everything."""
        now_ns = self.now_ns()
        for what, boat, payload in self._said:
            tap(what, boat, payload)
            if what == keys.STATE:
                for name, mooring in self.moorings.items():
                    if name != boat and not mooring.cut:
                        mooring.deposit_state(boat, payload, now_ns)
        self._said.clear()
        for sender, boat, what, payload in self._asked:
            other = self.moorings.get(boat)
            if other is not None:
                other.deposit_request(what, payload, sender.take_answer(boat, what))
        self._asked.clear()

    def token(self, boat: str, up: bool) -> None:
        """A liveliness token appears, or goes."""
        if up:
            self.tokens.add(boat)
        else:
            self.tokens.discard(boat)
        self._alive.clear()

    def alive_but(self, boat: str) -> frozenset[str]:
        """Boats whose token is up, this one apart."""
        alive = self._alive.get(boat)
        if alive is None:
            alive = self._alive[boat] = frozenset(self.tokens - {boat})
        return alive


class Mooring(MemoryBus):
    """A boat's end of the water."""

    def __init__(self, tide: Tide, boat: str) -> None:
        super().__init__(tide, boat)
        self._tide = tide

    def open(self) -> bool:
        """Join the water."""
        if not self._open:
            self._open = True
            self._tide.moorings[self._boat] = self
        return True

    def announce(self) -> None:
        """Declare the token."""
        self._tide.token(self._boat, True)

    def put(self, what: str, payload: bytes) -> None:
        """Publish something; the others hear it in the next tick."""
        if self._open and not self.cut:
            self._tide.say(what, self._boat, payload)

    def ask(self, boat: str, what: str, payload: bytes) -> None:
        """Ask one boat; it reads the question in the next tick."""
        if self._open and not self.cut:
            self._tide.ask(self, boat, what, payload)

    def take_answer(self, boat: str, what: str) -> Callable[[bytes], None]:
        """Where the answer to a question goes."""
        return lambda answer: self._answers.append(Answer(boat, what, answer))

    def deposit(self, request: Request) -> None:
        """A question arrives whose asker also wants to know when it is lost."""
        self._requests.append(request)

    def alive(self) -> frozenset[str]:
        """Boats whose token is up."""
        return self._tide.alive_but(self._boat) if self.link_up() else NOBODY

    def operators(self) -> frozenset[str]:
        """The operator, while it is there."""
        return self._tide.ashore if self.link_up() else NOBODY

    def close(self) -> None:
        """Leave the water; the token goes with it."""
        self._open = False
        self._tide.token(self._boat, False)
        if self._tide.moorings.get(self._boat) is self:
            del self._tide.moorings[self._boat]


class LockstepShore:
    """The operator's end (see `fleet.wire.bus.Shore`); while it waits, the simulation ticks."""

    def __init__(self, tide: Tide, tick: Callable[[], None]) -> None:
        self._tide, self._tick = tide, tick
        self._latest: dict[tuple[str, str], bytes] = {}
        self._events: deque[tuple[str, str, bytes]] = deque(maxlen=EVENTS_KEPT)

    def hear(self, what: str, boat: str, payload: bytes) -> None:
        """A boat said something: kept until it is fetched, of states and statuses the newest."""
        if what == keys.EVENT:
            self._events.append((what, boat, payload))
        else:
            self._latest[what, boat] = payload

    def open(self, timeout_s: float) -> bool:  # noqa: ARG002 - nothing to wait for
        """The operator is there."""
        self._tide.ashore = frozenset((self._tide.operator,))
        return True

    def listen(self, what: Iterable[str]) -> None:
        """It hears everything."""

    def heard(self) -> list[tuple[str, str, bytes]]:
        """(what, boat, payload) since the last call."""
        messages = [(what, boat, payload) for (what, boat), payload in self._latest.items()]
        messages += self._events
        self._latest.clear()
        self._events.clear()
        return messages

    def alive(self) -> frozenset[str]:
        """Boats whose token is up."""
        return frozenset(self._tide.tokens)

    def ask_all(self, what: str, payload: bytes, timeout_s: float, boat: str = "*") -> dict[str, bytes]:
        """Ask all boats (or one), and let time pass until all have answered or it is over."""
        answers: dict[str, bytes] = {}
        waiting: set[str] = set()

        def take(name: str) -> Callable[[bytes], None]:
            def reply(answer: bytes) -> None:
                answers[name] = answer
                waiting.discard(name)

            return reply

        def lose(name: str) -> Callable[[], None]:
            return lambda: waiting.discard(name)

        for name, mooring in self._tide.moorings.items():
            if boat in ("*", name) and not mooring.cut:
                waiting.add(name)
                mooring.deposit(Request(what, payload, take(name), lose(name)))
        deadline_ns = self._tide.now_ns() + int(timeout_s * 1e9)
        while waiting and self._tide.now_ns() < deadline_ns:
            self._tick()
        return answers

    def tell(self, what: str, payload: bytes, boat: str) -> None:
        """Ask one boat; time does not pass for it."""
        mooring = self._tide.moorings.get(boat)
        if mooring is not None and not mooring.cut:
            mooring.deposit(Request(what, payload, lambda answer: None, lambda: None))

    def close(self) -> None:
        """The operator leaves."""
        self._tide.ashore = NOBODY


class WorldDriver:
    """A boat in the world, driven by calls (see `fleet.drivers.seam.Driver`)."""

    simulated = True

    def __init__(self, world: World, boat: str) -> None:
        self._world, self._boat = world, boat
        self._eye = Eye(world, boat) if wanted(world) else None

    def open(self) -> None:
        """Nothing to connect."""

    def read(self) -> Reading:
        """What the sensors say now."""
        reading = self._world.sense(self._boat)
        scans = self._eye.scans() if self._eye is not None else ()
        return msgspec.structs.replace(reading, scans=scans) if scans else reading

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command the boat."""
        self._world.command(self._boat, True, surge_mps, yaw_rate_radps)
        return ""

    def neutral(self) -> None:
        """No thrust."""
        self._world.command(self._boat, False, 0.0, 0.0)

    def close(self) -> None:
        """Leave the boat in neutral."""
        self.neutral()


class MemoryStore(Store):
    """A boat's disk in memory: it outlives the boat's agent, not the simulation."""

    def __init__(self) -> None:  # neither folder nor thread
        self._files: dict[str, bytes] = {}
        self.trouble = ""

    def stops(self) -> tuple[str, ...]:
        """Stops not released."""
        content = self._files.get("stops")
        return () if content is None else msgspec.msgpack.decode(content, type=tuple[str, ...])

    def _read(self, name: str, kind: type[T]) -> T | None:
        content = self._files.get(name)
        return None if content is None else msgspec.msgpack.decode(content, type=kind)

    def _put(self, name: str, content: bytes, then: Callable[[], None] | None) -> None:
        self._files[name] = content
        if then is not None:
            then()

    def close(self) -> None:
        """Everything is written."""
