"""A boat's end of the network over Zenoh.

One ring of a peer's states each, so that nobody's flood evicts another's; callbacks run in Zenoh's receive thread and
only deposit. Opening is tried in a thread of its own, since a boat must go on deciding while the hub is out of reach.
"""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

import zenoh

from fleet.wire import keys, zenoh_log
from fleet.wire.bus import OWN_KEPT, Answer, Heard, Request
from fleet.wire.credentials.trust import Trust
from fleet.wire.link import LinkConfig
from fleet.wire.zenoh_link import MOST_TOKENS, direct, mode_of, session_config

log = logging.getLogger("fleet.wire")
RING = 256  # states of one peer kept between two ticks
REQUESTS = 512  # of each kind, so that no flood of one pushes out another
LARGEST_OWN = 1 << 16  # bytes of a message under the own name: a scan of 8192 beams has half as many
LARGEST = 1 << 20  # bytes of a request, as the codec has it
WAITING_BYTES = 8 << 20  # of requests not yet fetched
MOST_PEERS = 256
ROSTER_LOOK_S = 1.0
SETTLE_S = 1.5  # between a newer roster and new rules: its bringer gets all answers first
LINK_LOOK_NS = 20_000_000  # so long the answer to `link_up` holds: asking costs 25 us, a tick asks five times


def _noted(up: frozenset[str], name: str, appears: bool) -> frozenset[str]:
    """A token appears or goes; names that nobody may have, and more than there can be, are passed over."""
    if not appears:
        return up - {name}
    return up | {name} if name and len(up) < MOST_TOKENS else up


class ZenohBus:
    """A boat's end of the network (see `fleet.wire.bus.Bus`)."""

    def __init__(
        self, fleet: str, boat: str, link: LinkConfig, now_ns: Callable[[], int], trust: Trust | None = None
    ) -> None:
        self._fleet, self._boat, self._link, self._now_ns, self._trust = fleet, boat, link, now_ns, trust
        self._session: zenoh.Session | None = None
        self._rings: dict[str, Any] = {}
        self._wanted: set[str] = set()
        self._subscribers: dict[str, Any] = {}
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._requests: dict[str, deque[tuple[zenoh.Query, int]]] = {what: deque() for what in keys.ASKED}
        self._waiting_bytes = 0
        self._unfetched = 0
        self._lock = threading.Lock()  # of subscribing, which the opening thread does too
        self._answers: deque[Answer] = deque(maxlen=REQUESTS)
        self._own: dict[str, deque[Heard]] = {}
        self._boats_up: frozenset[str] = frozenset()
        self._operators_up: frozenset[str] = frozenset()
        self._link_up, self._link_seen_ns = False, 0
        self._kept: list[Any] = []
        self._asked = 0
        self._opening: threading.Thread | None = None
        self._closing = threading.Event()
        self._announced = False

    # -- opening -----------------------------------------------------------------------------------------------------
    def open(self) -> bool:
        """Start connecting in the background, once; True when connected and declared."""
        if self._opening is None and not self._closing.is_set():
            self._opening = threading.Thread(target=self._open, name="zenoh-open", daemon=True)
            self._opening.start()
        return self._session is not None

    def _open(self) -> None:
        """Connect; with credentials, again with new rules whenever there is a newer roster."""
        number = self._connect()
        while self._trust is not None and not self._closing.wait(ROSTER_LOOK_S):
            self._trust.look()
            if self._trust.roster.number != number and not self._closing.wait(SETTLE_S):
                self._leave()
                number = self._connect()

    def _connect(self) -> int:
        """Try until connected; the number of the roster that the rules were made of."""
        said = False
        while not self._closing.is_set():
            number = self._trust.roster.number if self._trust is not None else 0
            config = session_config(mode_of(self._link.topology), self._link, self._trust)
            try:
                session = zenoh.open(config)
            except zenoh.ZError as error:
                if not said:
                    log.warning("not connected yet, trying on: %s", str(error).split(" at ")[0])
                    said = True
                self._closing.wait(0.5)
                continue
            self._declare(session)
            return number
        return 0

    def _leave(self) -> None:
        """End the session; everything that was declared is declared again in the next one."""
        session, self._session = self._session, None
        with self._lock:
            self._rings, self._subscribers = {}, {}
        self._publishers, self._kept = {}, []
        self._boats_up = self._operators_up = frozenset()
        if session is not None:
            zenoh_log.forget(session)
            with contextlib.suppress(zenoh.ZError):
                session.close()  # type: ignore[no-untyped-call]

    def _declare(self, session: zenoh.Session) -> None:
        for what in (keys.STATE, keys.STATUS, keys.EVENT, keys.MAVLINK):
            pose = what == keys.STATE
            self._publishers[what] = session.declare_publisher(
                keys.key(self._fleet, self._boat, what),
                priority=zenoh.Priority.DATA_HIGH if pose else zenoh.Priority.DATA,
                congestion_control=zenoh.CongestionControl.DROP,
                reliability=zenoh.Reliability.BEST_EFFORT if pose else zenoh.Reliability.RELIABLE,
                express=False,
            )
        for what in keys.ASKED:
            self._kept.append(
                session.declare_queryable(
                    keys.key(self._fleet, self._boat, what),
                    direct(partial(self._deposit_request, what)),
                )
            )
        live = session.liveliness()
        alive = keys.key(self._fleet, "*", keys.ALIVE)
        self._kept.append(live.declare_subscriber(alive, direct(self._on_alive), history=True))
        operators = keys.operator_key(self._fleet, "*")
        self._kept.append(live.declare_subscriber(operators, direct(self._on_operator), history=True))
        self._session = session
        zenoh_log.watch(session, self._trust)
        for boat in tuple(self._wanted):
            self._subscribe(boat)
        if self._announced:
            self._declare_alive(session)
        for what in tuple(self._own):
            self._subscribe_own(what)

    def _deposit_request(self, what: str, query: zenoh.Query) -> None:
        """In Zenoh's thread: keep it for the next tick, or drop and count it when too much waits already."""
        payload = query.payload
        size = 0 if payload is None else len(payload)
        waiting = self._requests[what]
        if len(waiting) >= REQUESTS or size > LARGEST or self._waiting_bytes + size > WAITING_BYTES:
            self._unfetched += 1
            query.drop()  # type: ignore[no-untyped-call]
            return
        self._waiting_bytes += size
        waiting.append((query, size))

    def alone_with_my_name(self) -> bool:
        """False when another station holds this boat's liveliness token."""
        if self._session is None:
            return True
        mine = keys.key(self._fleet, self._boat, keys.ALIVE)
        replies = self._session.liveliness().get(mine, timeout=1.0)
        return not any(reply.ok is not None for reply in replies)

    def announce(self) -> None:
        """Declare the liveliness token."""
        if self._session is not None and not self._announced:
            self._announced = True
            self._declare_alive(self._session)

    def _declare_alive(self, session: zenoh.Session) -> None:
        self._kept.append(session.liveliness().declare_token(keys.key(self._fleet, self._boat, keys.ALIVE)))

    def _on_alive(self, sample: zenoh.Sample) -> None:
        boat = keys.boat_of(str(sample.key_expr))
        if boat != self._boat:
            self._boats_up = _noted(self._boats_up, boat, sample.kind == zenoh.SampleKind.PUT)

    def _on_operator(self, sample: zenoh.Sample) -> None:
        operator = keys.operator_of(str(sample.key_expr))
        self._operators_up = _noted(self._operators_up, operator, sample.kind == zenoh.SampleKind.PUT)

    # -- states ------------------------------------------------------------------------------------------------------
    def watch(self, boat: str) -> None:
        """Listen to this boat's state from now on, in a ring of its own."""
        if boat in self._wanted or len(self._wanted) >= MOST_PEERS:
            return
        self._wanted.add(boat)
        if self._session is not None:
            self._subscribe(boat)

    def _subscribe(self, boat: str) -> None:
        assert self._session is not None
        with self._lock:
            if boat in self._rings:
                return
            subscriber = self._session.declare_subscriber(
                keys.key(self._fleet, boat, keys.STATE),
                zenoh.handlers.RingChannel(RING),
                allowed_origin=zenoh.Locality.REMOTE,
            )
            self._subscribers[boat] = subscriber
            self._rings[boat] = subscriber.handler

    def unwatch(self, boat: str) -> None:
        """Listen to it no longer."""
        self._wanted.discard(boat)
        self._rings.pop(boat, None)
        subscriber = self._subscribers.pop(boat, None)
        if subscriber is not None:
            subscriber.undeclare()

    def poll_states(self, bound: int) -> list[Heard]:
        """States since the last call, at most `bound` a sender."""
        heard: list[Heard] = []
        now = self._now_ns()
        for boat, ring in tuple(self._rings.items()):  # the opening thread may add to it
            for _ in range(bound):
                sample = ring.try_recv()
                if sample is None:
                    break
                heard.append(Heard(boat, sample.payload.to_bytes(), now))
        return heard

    def put_state(self, payload: bytes) -> None:
        """Publish the own state."""
        self.put(keys.STATE, payload)

    def put(self, what: str, payload: bytes) -> None:
        """Publish something of this boat."""
        publisher = self._publishers.get(what)
        if publisher is not None and self._session is not None:
            with contextlib.suppress(zenoh.ZError):
                publisher.put(payload)

    # -- under the own name ------------------------------------------------------------------------------------------
    def listen_own(self, what: str) -> None:
        """Keep what others on board publish under this boat's own name; before `open`."""
        self._own.setdefault(what, deque(maxlen=OWN_KEPT))

    def _subscribe_own(self, what: str) -> None:
        assert self._session is not None
        waiting = self._own[what]

        def deposit(sample: zenoh.Sample) -> None:
            if len(sample.payload) <= LARGEST_OWN:
                waiting.append(Heard(self._boat, sample.payload.to_bytes(), self._now_ns()))

        key = keys.key(self._fleet, self._boat, what)
        self._kept.append(
            self._session.declare_subscriber(key, direct(deposit), allowed_origin=zenoh.Locality.REMOTE)
        )  # fmt: skip

    def poll_own(self, what: str) -> list[Heard]:
        """That, since the last call."""
        waiting = self._own.get(what, deque())
        return [waiting.popleft() for _ in range(len(waiting))]

    # -- questions ---------------------------------------------------------------------------------------------------
    def poll_requests(self, bound: int) -> list[Request]:
        """Requests since the last call."""
        requests: list[Request] = []
        for what, waiting in self._requests.items():  # commands first
            while waiting and len(requests) < bound:
                query, size = waiting.popleft()
                self._waiting_bytes -= size
                payload = query.payload
                requests.append(self._request(what, query, b"" if payload is None else payload.to_bytes()))
        return requests

    def _request(self, what: str, query: zenoh.Query, payload: bytes) -> Request:
        mine = keys.key(self._fleet, self._boat, what)

        def reply(answer: bytes) -> None:
            with contextlib.suppress(zenoh.ZError), query:
                query.reply(mine, answer)

        def drop() -> None:
            with contextlib.suppress(zenoh.ZError), query:
                pass

        return Request(what, payload, reply, drop)

    def ask(self, boat: str, what: str, payload: bytes) -> None:
        """Ask one boat; the answer comes by `poll_answers`."""
        if self._session is None:
            return

        def deposit(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                self._answers.append(Answer(boat, what, reply.ok.payload.to_bytes()))

        with contextlib.suppress(zenoh.ZError):
            self._session.get(
                keys.key(self._fleet, boat, what),
                direct(deposit),
                payload=payload,
                timeout=2.0,
                priority=zenoh.Priority.INTERACTIVE_LOW,
                congestion_control=zenoh.CongestionControl.DROP,
            )

    def poll_answers(self) -> list[Answer]:
        """Answers since the last call."""
        answers: list[Answer] = []
        while self._answers:
            answers.append(self._answers.popleft())
        return answers

    # -- who is there ------------------------------------------------------------------------------------------------
    def link_up(self) -> bool:
        """Whether a router (the hub, or any other boat) is connected."""
        session = self._session
        if session is None:
            return False
        now = time.monotonic_ns()
        if now - self._link_seen_ns >= LINK_LOOK_NS:
            self._link_seen_ns = now
            self._link_up = self._ask_link(session)
        return self._link_up

    def _ask_link(self, session: zenoh.Session) -> bool:
        try:
            return bool(session.info.routers_zid() or (self._link.topology == "mesh" and session.info.peers_zid()))
        except zenoh.ZError:
            return False

    def alive(self) -> frozenset[str]:
        """Boats whose token is up."""
        return self._boats_up

    def operators(self) -> frozenset[str]:
        """Operators whose token is up."""
        return self._operators_up

    def overflowed(self) -> int:
        """Requests dropped here; states that a ring dropped are counted by their sequence numbers instead."""
        return self._unfetched

    def close(self) -> None:
        """Leave the network: token first, then everything else with the session."""
        self._closing.set()
        self._leave()
