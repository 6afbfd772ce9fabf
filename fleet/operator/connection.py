"""An operator's connection to a fleet: the picture of it, and questions to boats with their answers."""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

from msgspec import Struct

from fleet.errors import NobodyReachable, UsageError
from fleet.mission.load import decode as decode_mission
from fleet.mission.plan import shape_of
from fleet.operator.outcome import Outcome
from fleet.operator.view import BoatView, Change, Time, default_operator
from fleet.wire import keys
from fleet.wire.bus import Shore
from fleet.wire.codec import Refused, decode, decode_formation, decode_mission_order, decode_state, encode
from fleet.wire.credentials.trust import Trust, load
from fleet.wire.formation import shape_in
from fleet.wire.link import LinkConfig, check_link, warning
from fleet.wire.messages import (
    MAJOR,
    Ack,
    BoatStatus,
    Command,
    FleetEvent,
    FormationOrder,
    Frames,
    Held,
    MissionOrder,
    Revision,
    Signed,
)

DEFAULT_CONNECT = ("tcp/127.0.0.1:7447",)
DEFAULT_SECURE = ("tls/127.0.0.1:7447",)
ASK_AGAIN_S = 0.5
AT_ONCE = ("stop-now", "hold", "abort")  # said before anybody is asked who is of the mission
GONE_S = 3.0


def _new_id() -> str:
    return uuid.uuid4().hex


def _over_zenoh(fleet: str, operator: str, link: LinkConfig, present: bool, trust: Trust | None) -> Shore:
    from fleet.wire.zenoh_shore import OperatorBus

    return OperatorBus(fleet, operator, link, present=present, trust=trust)


class OperatorConfig(Struct, frozen=True, kw_only=True):
    """Who commands which fleet, and how it is reached."""

    fleet: str = "demo"
    connect: tuple[str, ...] = DEFAULT_CONNECT
    operator: str = ""
    timeout_s: float = 3.0


class Connection:
    """A connection to a fleet. Commands wait at most `timeout_s` and name every boat that did not answer."""

    def __init__(
        self,
        fleet: str = "demo",
        *,
        connect: Sequence[str] = (),
        operator: str = "",
        timeout_s: float = 3.0,
        present: bool = True,
        credentials: str | Path = "",
        insecure: bool = False,
        trust: Trust | None = None,
        bus: Shore | None = None,
        clock: Time = time,
        new_id: Callable[[], str] = _new_id,
    ) -> None:
        self.fleet = keys.valid_name("fleet", fleet)
        self.trust = load(credentials, self.fleet, "operator", operator) if credentials else trust
        named = self.trust.name if self.trust is not None else default_operator()
        self.operator = keys.valid_name("operator", operator or named)
        if not timeout_s > 0.0:
            raise UsageError(f"timeout {timeout_s:g} s: expected more than 0")
        self.timeout_s = timeout_s
        self._connect = tuple(connect) or (DEFAULT_CONNECT if self.trust is None else DEFAULT_SECURE)
        folder = str(self.trust.folder) if self.trust is not None else ""
        link = LinkConfig(topology="hub", connect=self._connect, credentials=folder, insecure=insecure)
        check_link(link, connect="--connect")
        self.insecure = warning(link)
        self._bus = bus if bus is not None else _over_zenoh(self.fleet, self.operator, link, present, self.trust)
        self._said_ns = 0
        self._clock, self._new_id = clock, new_id
        self.boats: dict[str, BoatView] = {}
        self.events: list[FleetEvent] = []

    def __enter__(self) -> Self:
        """Connect; NobodyReachable when nothing answers at the endpoints."""
        if not self._bus.open(self.timeout_s):
            raise NobodyReachable(
                f"nothing answers at {', '.join(self._connect)}: is the hub, or a boat, up there? (--connect)"
            )
        self._bus.listen((keys.STATE, keys.STATUS, keys.EVENT))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bus.close()

    # -- the picture -----------------------------------------------------------------------------------------------
    def look(
        self, tap: Callable[[str, str, bytes], None] | None = None, *, newest: bool = False
    ) -> dict[str, BoatView]:
        """The boats, with what was heard since the last look; `tap` gets each message (what, boat, payload).

        With `newest` only the last state of each boat is read: for who looks less often than boats speak.
        """
        heard = self._bus.heard()
        last = {boat: i for i, (what, boat, _) in enumerate(heard) if what == keys.STATE} if newest else {}
        for i, (what, boat, payload) in enumerate(heard):
            if last.get(boat, i) != i and what == keys.STATE:
                continue
            if tap is not None:
                tap(what, boat, payload)
            try:
                self._take(what, boat, payload)
            except Refused:
                continue
        alive = self._bus.alive()
        for boat in alive:
            self.boats.setdefault(boat, BoatView(boat))
        for view in self.boats.values():
            view.alive = view.name in alive
        return self.boats

    def _take(self, what: str, boat: str, payload: bytes) -> None:
        if what == keys.MAVLINK:
            return
        if what == keys.EVENT:
            if len(self.events) < 10_000:
                self.events.append(decode(payload, FleetEvent))
            return
        view = self.boats.setdefault(boat, BoatView(boat))
        if what == keys.STATE:
            view.state, view.heard_s = decode_state(payload, boat), time.monotonic()
        else:
            view.status = decode(payload, BoatStatus)

    def wait_for(self, boats: Sequence[str], timeout_s: float | None = None) -> tuple[str, ...]:
        """Wait until these boats are alive and heard; returns those that are not in time."""
        deadline = self._clock.monotonic() + (self.timeout_s if timeout_s is None else timeout_s)
        while True:
            views = self.look()
            missing = tuple(b for b in boats if b not in views or not views[b].alive or views[b].state is None)
            if not missing or self._clock.monotonic() >= deadline:
                return missing
            self._clock.sleep(0.02)

    def reachable(self) -> tuple[str, ...]:
        """Boats that are alive."""
        return tuple(sorted(self._bus.alive()))

    # -- asking ----------------------------------------------------------------------------------------------------
    def hear_too(self, what: str) -> None:
        """Have what boats publish under another name; it goes to the tap of `look`."""
        self._bus.listen((what,))

    def pass_on(self, boat: str, frames: bytes = b"") -> None:
        """Frames for a boat's own autopilot, without waiting; with none, say that somebody listens to it."""
        body = encode(Frames(MAJOR, self.operator, frames, boat, self._now_ns()))
        payload = encode(self.trust.sign("frames", body)) if self.trust is not None else body
        self._bus.tell(keys.MAVLINK, payload, boat)

    def _ask(
        self, command: Command, expected: Sequence[str], deadline: float, *, all_at_once: bool = False
    ) -> dict[str, Ack | None]:
        """Ask until every expected boat has answered or the time is over; all at once: whoever else hears it, too."""
        payload = encode(command)
        if self.trust is not None:
            payload = encode(self.trust.sign("command", payload))
        acks: dict[str, Ack | None] = dict.fromkeys(expected)
        while True:
            left = deadline - self._clock.monotonic()
            missing = [boat for boat, ack in acks.items() if ack is None]
            if left <= 0.0 or (not missing and acks):
                return acks
            target = missing[0] if len(missing) == 1 and not all_at_once else "*"
            all_at_once = False
            began = self._clock.monotonic()
            for boat, answer in self._bus.ask_all(keys.COMMAND, payload, max(left, 0.05), target).items():
                if command.boats and boat not in command.boats:
                    continue
                try:
                    ack = decode(answer, Ack)
                except Refused:
                    continue
                if ack.boat == boat and ack.id == command.id:
                    acks[boat] = ack
            if any(ack is None for ack in acks.values()) or not acks:
                now = self._clock.monotonic()
                self._clock.sleep(max(0.0, min(ASK_AGAIN_S - (now - began), deadline - now)))

    def _now_ns(self) -> int:
        """UTC [ns], more with every word: boats obey none that is older than the one before."""
        self._said_ns = max(self._clock.time_ns(), self._said_ns + 1)
        return self._said_ns

    def _words(self, purpose: str, order: MissionOrder | FormationOrder) -> Signed:
        """An order, signed where there are credentials."""
        body = encode(order)
        return self.trust.sign(purpose, body) if self.trust is not None else Signed(body)

    def _expected(self, boats: Sequence[str]) -> list[str]:
        if boats:
            return list(boats)
        names = set(self._bus.alive())
        change = self._held_by_anybody()
        if change is not None:
            names |= set(change.roster)
        return sorted(names)

    def command(
        self,
        kind: str,
        boats: Sequence[str] = (),
        *,
        order: Signed | None = None,
        names: Sequence[str] = (),
        text: str = "",
        expected: Sequence[str] | None = None,
    ) -> Outcome:
        """Say something to boats, and collect their answers."""
        first = sorted(self._bus.alive()) if kind in AT_ONCE and not boats else []
        addressed = first or (list(expected) if expected is not None else self._expected(boats))
        if not addressed:
            raise NobodyReachable(f"{kind}: no boat of fleet {self.fleet!r} is in reach at {', '.join(self._connect)}")
        command = Command(
            MAJOR,
            ("all-" if kind == "stop-now" and not boats else "") + self._new_id(),  # neighbours hand such a stop on
            self.operator,
            kind,
            tuple(boats),
            order,
            tuple(names),
            text,
            stamp_ns=self._now_ns(),
        )
        deadline = self._clock.monotonic() + self.timeout_s
        acks = self._ask(command, addressed, deadline, all_at_once=bool(first))
        if first:  # only then: boats are asked for it, and answer when they can
            others = [boat for boat in self._expected(()) if boat not in acks]
            acks |= self._ask(command, others, deadline) if others else {}
        olds = {ack.old for ack in acks.values() if ack is not None and ack.old}
        news = {ack.new for ack in acks.values() if ack is not None and ack.new}
        return Outcome(kind, command.id, acks, " | ".join(sorted(olds)), " | ".join(sorted(news)))

    def _held(self, what: str, patient: bool) -> dict[str, bytes]:
        """What boats hold, of those that answer within a second; patiently, if none does, within the time to wait."""
        soon = self._bus.ask_all(what, b"", min(1.0, self.timeout_s))
        return soon if soon or not patient else self._bus.ask_all(what, b"", self.timeout_s)

    def _held_by_anybody(self, patient: bool = False) -> Change | None:
        """The newest mission and formation that any boat holds; patiently, NobodyReachable when none there answers."""
        held_by = self._held(keys.MISSION, patient)
        if patient and not held_by and (there := sorted(self._bus.alive())):
            raise NobodyReachable(f"{', '.join(there)}: no answer within {self.timeout_s:g} s; try a longer --timeout")
        missions: dict[str, MissionOrder] = {}
        for answer in held_by.values():
            try:
                held = decode(answer, Held)
                if held.order is not None:
                    if self.trust is not None:
                        self.trust.signer("mission", held.order)
                    order = decode_mission_order(held.order)
                    missions[order.mission_id] = order
            except Refused:
                continue
        if not missions:
            return None
        order = max(missions.values(), key=lambda one: (one.stamp_ns, one.mission_id))
        mission = decode_mission(order.mission)
        newest = Change(
            order.mission_id,
            tuple(boat.name for boat in mission.boats),
            mission,
            Revision(),
            shape_of(mission),
        )
        for answer in self._held(keys.FORMATION, patient).values():
            try:
                held = decode(answer, Held)
                if self.trust is not None and held.order is not None:
                    self.trust.signer("formation", held.order)
                formation = decode_formation(held.order) if held.order is not None else None
                if formation is None or formation.mission_id != newest.mission_id:
                    continue
                if newest.revision < formation.revision:
                    shape = shape_in(formation, mission)
                    newest = Change(newest.mission_id, newest.roster, mission, formation.revision, shape)
            except Refused:
                continue
        return newest
