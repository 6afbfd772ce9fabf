"""The hub: a router that boats and operators connect to."""

from __future__ import annotations

import contextlib
import logging
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import zenoh
from msgspec import structs

from fleet.errors import FleetError
from fleet.wire import keys, zenoh_log
from fleet.wire.codec import Refused, encode
from fleet.wire.credentials.trust import Trust
from fleet.wire.link import LinkConfig
from fleet.wire.messages import MAJOR, Ack
from fleet.wire.zenoh_link import direct, session_config

log = logging.getLogger("fleet.wire")
LOOK_S = 1.0
SETTLE_S = 1.5  # between a newer roster and new rules: its bringer gets all answers first
REOPEN_S = 5.0  # the port of the session before may take a moment to be free
PULSE = "fleet-hub/pulse"  # a message to itself: what does not come back has not gone through


def run_hub(
    link: LinkConfig,
    stop: threading.Event,
    ready: Callable[[], None],
    trust: Trust | None = None,
    alive: Callable[[], None] = lambda: None,
) -> None:
    """Be the hub until `stop`; with credentials, under new rules whenever there is a newer roster.

    Args:
        link: where it listens, and with which credentials
        stop: ends it
        ready: called once, when it listens
        trust: its credentials, if any
        alive: called about once a second, each time a message has gone through the hub and come back

    Raises:
        FleetError: it cannot listen
    """
    link = structs.replace(link, topology="hub")
    first = True
    while not stop.is_set():
        number = trust.roster.number if trust is not None else 0
        session = _open(link, trust, stop, patient=not first)
        if session is None:
            return
        with session:
            back = threading.Event()
            kept: list[Any] = [session.declare_subscriber(PULSE, direct(partial(_came, back)))]
            if trust is not None:
                zenoh_log.watch(session, trust)
                kept.append(_roster_desk(session, trust))
            if first:
                ready()
            first = False
            while not stop.is_set() and (trust is None or trust.roster.number == number):
                back.clear()
                session.put(PULSE, b"")
                if back.wait(LOOK_S):
                    alive()
                stop.wait(LOOK_S)
                if trust is not None:
                    trust.look()
            stop.wait(SETTLE_S)
            zenoh_log.forget(session)
            for one in kept:
                one.undeclare()


def _came(back: threading.Event, _: zenoh.Sample) -> None:
    back.set()


def _open(link: LinkConfig, trust: Trust | None, stop: threading.Event, *, patient: bool) -> zenoh.Session | None:
    deadline = time.monotonic() + (REOPEN_S if patient else 0.0)
    while True:
        try:
            return zenoh.open(session_config("router", link, trust, "hub"))
        except zenoh.ZError as error:
            if time.monotonic() >= deadline:
                where = ", ".join(link.listen)
                raise FleetError(f"cannot listen at {where}: {str(error).split(' at ')[0]}") from None
        if stop.wait(0.1):
            return None


def _roster_desk(session: zenoh.Session, trust: Trust) -> zenoh.Queryable[None]:
    """Where operators bring newer rosters, under the hub's own name."""
    mine = keys.key(trust.roster.fleet, trust.name, keys.ROSTER)

    def take(query: zenoh.Query) -> None:
        """A roster that somebody brings: taken where it is newer; the answer says what was and what is in force."""
        payload, old = query.payload, trust.roster.number
        try:
            newer = trust.told(b"" if payload is None else payload.to_bytes(), "the wire")
            ack = Ack(MAJOR, "", trust.name, True, "" if newer else "not newer", str(old), str(trust.roster.number))
        except Refused as refusal:
            log.warning("refused: %s", refusal, extra={"event": "refused"})
            ack = Ack(MAJOR, "", trust.name, False, str(refusal), str(old), str(old))
        with contextlib.suppress(zenoh.ZError), query:
            query.reply(mine, encode(ack))

    return session.declare_queryable(mine, take)
