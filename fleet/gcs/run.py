"""A bridge as a process: sockets, the operator's library and the engine joined, until it is told to stop."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from msgspec import Struct

from fleet.drivers.mavlink.signing import Signing
from fleet.drivers.mavlink.words import ARDUPILOT, dialect
from fleet.errors import ConfigError, UsageError
from fleet.gcs.bridge import Bridge
from fleet.gcs.captain import Captain
from fleet.gcs.numbers import GENERIC
from fleet.gcs.port import DEFAULT, Port, is_loopback, parse
from fleet.gcs.sysids import Sysids
from fleet.mission.model import Mission
from fleet.operator import Fleet
from fleet.wire import keys

LOOP_S = 0.05
LISTEN_S = 2.0  # boats with autopilots are told so often that somebody listens
FOLLOW_S = 1.0  # the timestamp of signatures follows the clock
ANSWER_S = 2.0  # for boats' answers: ground stations wait for three seconds


class GcsConfig(Struct, frozen=True, kw_only=True):
    """How ground stations are reached, and what they see."""

    endpoints: tuple[str, ...] = DEFAULT
    autopilot: str = "ardupilot"
    sysids: dict[str, int] = {}
    signing_key: str = ""
    insecure: bool = False
    template: Mission | None = None
    folder: Path | None = None  # where numbers are remembered

    def check(self) -> list[str]:
        """What is to be said at every start; UsageError for what cannot work."""
        dialect()
        if self.signing_key:
            Signing(self.signing_key, "--signing-key")
        if self.autopilot not in ("ardupilot", "generic"):
            raise UsageError(f"--autopilot {self.autopilot!r}: expected ardupilot or generic")
        try:
            open_ones = [text for text in self.endpoints if not is_loopback(parse(text)[1][0])]
        except ConfigError as error:
            raise UsageError(f"--{error}") from None
        if not open_ones or self.signing_key:
            return []
        where = ", ".join(open_ones)
        if not self.insecure:
            raise UsageError(
                f"--endpoint {where}: beyond this machine, where MAVLink lets anybody command the boats; expected "
                "--signing-key FILE, or --insecure on a network that you trust"
            )
        return [f"INSECURE: whoever reaches {where} can command the boats (--insecure)"]


class Signer:
    """Signs what all vehicles say, and checks what they hear; nothing without a key."""

    def __init__(self, key: str) -> None:
        self._signing = Signing(key, "--signing-key") if key else None
        self._codecs: list[Any] = []

    def __call__(self, codec: Any) -> None:
        """One more codec."""
        if self._signing is not None:
            self._codecs.append(codec)
            self._signing.begin((codec,), time.time_ns())
            self.follow()

    def follow(self) -> None:
        """Timestamps follow the clock, together."""
        if self._signing is not None:
            self._signing.follow(tuple(self._codecs), time.time_ns())


class Process:
    """One bridge."""

    def __init__(self, config: GcsConfig, fleet: Fleet, note: Callable[[str], None]) -> None:
        """ConfigError when an endpoint or a key cannot be had."""
        self._fleet, self._note = fleet, note
        self._signer = Signer(config.signing_key)
        self.port = Port(config.endpoints)
        file = config.folder / f"gcs-{fleet.fleet}.json" if config.folder is not None else None
        self.bridge = Bridge(
            dialect(),
            Sysids(config.sysids, file),
            operator=fleet.operator,
            autopilot=GENERIC if config.autopilot == "generic" else ARDUPILOT,
            template=config.template,
            sign=self._signer,
        )
        self._captain = Captain(fleet)
        fleet.hear_too(keys.MAVLINK)
        self._listened_s = self._followed_s = 0.0

    def run(self, stop: threading.Event) -> None:
        """Until `stop`."""
        self._captain.start()
        try:
            due_s = time.monotonic()
            while not stop.is_set():
                self.port.wait(due_s - time.monotonic())
                now_s = time.monotonic()
                self._hear(now_s)
                if now_s >= due_s:
                    due_s = max(due_s + LOOP_S, now_s)
                    self._turn(now_s)
                self._settle(now_s)
        finally:
            self._captain.close()
            self.port.close()

    def _hear(self, now_s: float) -> None:
        """Ground stations."""
        for peer, datagram in self.port.receive(now_s):
            if self.bridge.hear(peer, datagram, now_s):
                self.port.welcome(peer, now_s)

    def _turn(self, now_s: float) -> None:
        """The fleet, and what falls due."""
        fleet, bridge = self._fleet, self.bridge
        views = fleet.look(self._tap if bridge.passages.boats else None, newest=True)
        events, fleet.events = fleet.events, []
        bridge.look(views, events, now_s)
        bridge.step(now_s)
        if now_s - self._followed_s >= FOLLOW_S:
            self._followed_s = now_s
            self._signer.follow()
        if bridge.passages.boats and now_s - self._listened_s >= LISTEN_S:
            self._listened_s = now_s
            for boat in bridge.passages.boats:
                fleet.pass_on(boat)
        for note in bridge.notes:
            self._note(note)
        bridge.notes.clear()

    def _tap(self, what: str, boat: str, payload: bytes) -> None:
        if what == keys.MAVLINK:
            self.bridge.up(boat, payload)

    def _settle(self, now_s: float) -> None:
        """What came of wishes, what is wished, what is sent."""
        bridge, captain = self.bridge, self._captain
        for done in captain.done():
            bridge.done(done, now_s)
        captain.ask(bridge.take_wishes())
        for boat, frames in bridge.passages.take().items():
            self._fleet.pass_on(boat, frames)
        self.port.send(bridge.take_outbox(), now_s)
