"""An operator's end of the network over Zenoh."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable
from typing import Any

import zenoh

from fleet.wire import keys
from fleet.wire.credentials.trust import Trust
from fleet.wire.link import LinkConfig
from fleet.wire.zenoh_link import MOST_TOKENS, direct, session_config

KEPT = {keys.STATE: 16384}  # until they are fetched: 100 boats for 16 s
KEPT_OTHERS = 8192  # of each other name
LARGEST_HEARD = 1 << 16  # bytes of a state, a status or an event that an operator's machine keeps


class OperatorBus:
    """An operator's end of the network: hears every boat, asks boats and waits for their answers."""

    def __init__(
        self, fleet: str, operator: str, link: LinkConfig, *, present: bool = True, trust: Trust | None = None
    ) -> None:
        self._fleet, self._operator = fleet, operator
        self._config = session_config("client", link, trust, "operator")
        self._present = present
        self._session: zenoh.Session | None = None
        self._alive: dict[str, bool] = {}
        self._kept: list[Any] = []
        self._rings: list[tuple[str, Any]] = []
        self._numbered: dict[str, zenoh.KeyExpr] = {}  # keys of boats' states

    def open(self, timeout_s: float) -> bool:
        """Connect within the timeout; False when nobody answers at the endpoint."""
        deadline = time.monotonic() + timeout_s
        while True:
            try:
                self._session = zenoh.open(self._config)
                break
            except zenoh.ZError:
                if time.monotonic() >= deadline:
                    return False
                time.sleep(0.1)
        live = self._session.liveliness()
        alive = keys.key(self._fleet, "*", keys.ALIVE)
        self._kept.append(live.declare_subscriber(alive, direct(self._on_alive), history=True))
        for reply in live.get(alive, timeout=timeout_s):
            if reply.ok is not None:
                self._alive.setdefault(keys.boat_of(str(reply.ok.key_expr)), True)
        if self._present:
            self._kept.append(live.declare_token(keys.operator_key(self._fleet, self._operator)))
        return True

    def listen(self, what: Iterable[str]) -> None:
        """Keep what boats publish under these names until `heard` fetches it; the newest, where there is too much.

        In rings of Zenoh's own: a callback into Python costs twice as much, and a thread of Zenoh's waits for it.
        """
        assert self._session is not None
        for name in what:
            ring: Any = zenoh.handlers.RingChannel(KEPT.get(name, KEPT_OTHERS))
            subscriber = self._session.declare_subscriber(keys.key(self._fleet, "*", name), ring)
            self._kept.append(subscriber)
            self._rings.append((name, subscriber.handler))

    def _number(self, session: zenoh.Session) -> None:
        """Declare the keys of boats' states: the hub then says a number for them, and nobody searches for who listens.

        With fifty boats that halves what Zenoh's threads take.
        """
        for boat in tuple(self._alive):
            if boat not in self._numbered:
                self._numbered[boat] = session.declare_keyexpr(keys.key(self._fleet, boat, keys.STATE))

    def heard(self) -> list[tuple[str, str, bytes]]:
        """(what, boat, payload) since the last call."""
        if self._session is not None and len(self._numbered) < len(self._alive):
            self._number(self._session)
        messages: list[tuple[str, str, bytes]] = []
        for what, ring in self._rings:
            while (sample := ring.try_recv()) is not None:
                boat = keys.boat_of(str(sample.key_expr))
                if boat and len(sample.payload) <= LARGEST_HEARD:
                    messages.append((what, boat, sample.payload.to_bytes()))
        return messages

    def _on_alive(self, sample: zenoh.Sample) -> None:
        boat = keys.boat_of(str(sample.key_expr))
        if boat and (boat in self._alive or len(self._alive) < MOST_TOKENS):
            self._alive[boat] = sample.kind == zenoh.SampleKind.PUT

    def alive(self) -> frozenset[str]:
        """Boats whose token is up."""
        return frozenset(boat for boat, up in tuple(self._alive.items()) if up)

    def ask_all(self, what: str, payload: bytes, timeout_s: float, boat: str = "*") -> dict[str, bytes]:
        """Ask all boats (or one) and wait; who did not answer in time is not in the result."""
        assert self._session is not None
        answers: dict[str, bytes] = {}
        replies = self._session.get(
            keys.key(self._fleet, boat, what),
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=timeout_s,
            payload=payload,
            priority=zenoh.Priority.INTERACTIVE_HIGH,
            congestion_control=zenoh.CongestionControl.BLOCK,
            express=True,
        )
        for reply in replies:
            if reply.ok is not None:
                boat_answered = keys.boat_of(str(reply.ok.key_expr))
                if boat_answered:
                    answers[boat_answered] = reply.ok.payload.to_bytes()
        return answers

    def tell(self, what: str, payload: bytes, boat: str) -> None:
        """Ask one boat without waiting; its answer is not looked at."""
        if self._session is not None:
            with contextlib.suppress(zenoh.ZError):
                self._session.get(
                    keys.key(self._fleet, boat, what),
                    direct(lambda reply: None),
                    timeout=1.0,
                    payload=payload,
                    priority=zenoh.Priority.INTERACTIVE_LOW,
                    congestion_control=zenoh.CongestionControl.DROP,
                )

    def close(self) -> None:
        """Leave the network."""
        session, self._session = self._session, None
        if session is not None:
            session.close()  # type: ignore[no-untyped-call]
