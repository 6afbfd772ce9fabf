"""Stations that mean ill, with credentials of every wrong kind: raw Zenoh sessions, beside the fleet's own agents."""

from __future__ import annotations

import contextlib
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import zenoh
from msgspec import structs

from fleet.agent.modes import Mode
from fleet.wire import keys
from fleet.wire.codec import encode
from fleet.wire.credentials import files
from fleet.wire.messages import MAJOR, BoatState, Held, Signed, Stops

NEAR_DEG = 0.0005  # 55 m
PERIOD_S = 0.1
RETRY = {"period_init_ms": 200, "period_max_ms": 500, "period_increase_factor": 1.5}


def config(endpoint: str, folder: Path, authority: Path, *, shows: bool = True) -> zenoh.Config:
    """A session that believes the fleet's authority and shows what is in the folder, or nothing."""
    tls: dict[str, Any] = {"root_ca_certificate": str(authority / files.AUTHORITY_CERTIFICATE), "enable_mtls": shows}
    if shows:
        tls["connect_private_key"] = str(folder / files.OWN_KEY)
        tls["connect_certificate"] = str(folder / files.OWN_CERTIFICATE)
    return zenoh.Config.from_json5(
        json.dumps(
            {
                "mode": "client",
                "connect": {"endpoints": [endpoint], "timeout_ms": 700, "exit_on_failure": True, "retry": RETRY},
                "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
                "transport": {"shared_memory": {"enabled": False}, "link": {"tls": tls}},
            }
        )
    )


def connects(endpoint: str, folder: Path, authority: Path, *, shows: bool = True) -> bool:
    """Whether such a station gets a session at all."""
    try:
        with zenoh.open(config(endpoint, folder, authority, shows=shows)):
            return True
    except zenoh.ZError:
        return False


class Imposter:
    """One session of a station that the network lets in."""

    def __init__(self, fleet: str, name: str, endpoint: str, folder: Path, authority: Path) -> None:
        self.fleet, self.name = fleet, name
        self.session = zenoh.open(config(endpoint, folder, authority))
        self._epoch = time.time_ns()
        self._kept: list[Any] = []
        self._seq = 0

    def close(self) -> None:
        """Leave."""
        for one in self._kept:
            one.undeclare()
        self.session.close()  # type: ignore[no-untyped-call]

    def key(self, boat: str, what: str) -> str:
        """As in `fleet.wire.keys`."""
        return keys.key(self.fleet, boat, what)

    def puts(self, boat: str, what: str, payload: bytes) -> None:
        """Publish on somebody's key."""
        self.session.put(self.key(boat, what), payload)

    def asks(self, boat: str, what: str, payload: bytes) -> list[bytes]:
        """Answers to a question."""
        replies = self.session.get(
            self.key(boat, what),
            target=zenoh.QueryTarget.ALL,
            timeout=1.0,
            payload=payload,
            consolidation=zenoh.ConsolidationMode.NONE,
        )
        return [reply.ok.payload.to_bytes() for reply in replies if reply.ok is not None]

    def hears(self, boat: str, what: str) -> bool:
        """Whether somebody's messages reach it within a second."""
        with_ring = self.session.declare_subscriber(self.key(boat, what), zenoh.handlers.RingChannel(8))
        try:
            return until(lambda: with_ring.try_recv() is not None, 1.0)
        finally:
            with_ring.undeclare()  # type: ignore[no-untyped-call]

    def lives(self) -> None:
        """Be alive under the own name."""
        self._kept.append(self.session.liveliness().declare_token(self.key(self.name, keys.ALIVE)))

    def answers(self, what: str, payload: bytes) -> None:
        """Have an answer to what boats ask their neighbours."""
        mine = self.key(self.name, what)

        def reply(query: zenoh.Query) -> None:
            with query:
                query.reply(mine, payload)

        self._kept.append(self.session.declare_queryable(mine, reply))

    def holds(self, words: Signed) -> None:
        """Say that these are the words of its mission."""
        self.answers(keys.MISSION, encode(Held(MAJOR, words, 0.0)))

    def knows_stops(self, *words: Signed) -> None:
        """Say that these are the words of the stops that it knows."""
        self.answers(keys.STOPS, encode(Stops(MAJOR, words)))

    def state(self, like: BoatState, **changes: Any) -> BoatState:
        """A state of its own that can be believed, 55 m from another boat."""
        self._seq += 1
        return structs.replace(
            like,
            boat=self.name,
            epoch=self._epoch,
            seq=self._seq,
            stamp_ns=time.time_ns(),
            lat_deg=like.lat_deg + NEAR_DEG,
            mode=int(Mode.FOLLOW),
            reasons=0,
            **changes,
        )

    def sails(self, like: Callable[[], BoatState], seconds: float, done: Callable[[], bool], **changes: Any) -> None:
        """Publish states of its own until that has come about, or the time is over."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and not done():
            self.puts(self.name, keys.STATE, encode(self.state(like(), **changes)))
            time.sleep(PERIOD_S)


@contextlib.contextmanager
def imposter(*args: Any) -> Iterator[Imposter]:
    """An imposter that leaves in the end."""
    one = Imposter(*args)
    try:
        yield one
    finally:
        one.close()


def until(holds: Callable[[], bool], seconds: float) -> bool:
    """Whether it holds in time."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() >= end:
            return False
        time.sleep(0.02)
    return True
