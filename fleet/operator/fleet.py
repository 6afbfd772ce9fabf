"""A fleet as an operator's script sees it.

with Fleet("demo", connect=["tcp/127.0.0.1:7447"], operator="anna") as fleet:
    print(fleet.set_spacing(-20.0).lines())
"""

from __future__ import annotations

import contextlib
import getpass
import re
import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

from msgspec import Struct

from fleet import __version__
from fleet.errors import FleetError, NobodyReachable, UsageError
from fleet.mission.change import changed, words
from fleet.mission.check import check
from fleet.mission.load import decode as decode_mission
from fleet.mission.load import encode as encode_mission
from fleet.mission.model import Mission
from fleet.mission.pattern import Shape
from fleet.mission.plan import shape_of
from fleet.operator.outcome import Outcome
from fleet.wire import keys
from fleet.wire.bus import Shore
from fleet.wire.codec import Refused, decode, decode_formation, decode_mission_order, decode_state, encode
from fleet.wire.credentials.trust import Trust, load
from fleet.wire.formation import order_for, shape_in
from fleet.wire.link import LinkConfig, check_link, warning
from fleet.wire.messages import (
    MAJOR,
    Ack,
    BoatState,
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
GONE_S = 3.0


def default_operator() -> str:
    """The login name, as far as it may stand in a key."""
    try:
        name = re.sub(r"[^a-z0-9-]", "-", getpass.getuser().lower())[:32]
    except (KeyError, OSError):
        name = ""
    return name or "operator-1"


class Time(Protocol):
    """The time that an operator lives by: the module `time`, or a simulation's."""

    def monotonic(self) -> float:
        """Seconds that only grow."""

    def time_ns(self) -> int:
        """UTC [ns]."""

    def sleep(self, seconds: float, /) -> None:
        """Wait."""


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


class BoatView(Struct):
    """What is known of one boat."""

    name: str
    state: BoatState | None = None
    status: BoatStatus | None = None
    heard_s: float = 0.0  # monotonic time of its last state
    alive: bool = False

    def age_s(self) -> float:
        """Time since its last state [s]; infinite when never heard."""
        return time.monotonic() - self.heard_s if self.heard_s else float("inf")


class Change(Struct, frozen=True):
    """The formation that the boats hold: what a change is based on."""

    mission_id: str
    roster: tuple[str, ...]
    mission: Mission
    revision: Revision
    shape: Shape

    @property
    def spacing_m(self) -> float:
        """From slot to slot [m]."""
        return self.shape.spacing_m

    @property
    def cruise_mps(self) -> float:
        """Speed of the formation [m/s]."""
        return self.shape.cruise_mps


class Fleet:
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

    def _ask(self, command: Command, expected: Sequence[str]) -> dict[str, Ack | None]:
        """Ask until every expected boat has answered or the time is over."""
        payload = encode(command)
        if self.trust is not None:
            payload = encode(self.trust.sign("command", payload))
        acks: dict[str, Ack | None] = dict.fromkeys(expected)
        deadline = self._clock.monotonic() + self.timeout_s
        while True:
            left = deadline - self._clock.monotonic()
            missing = [boat for boat, ack in acks.items() if ack is None]
            if left <= 0.0 or (not missing and acks):
                return acks
            target = missing[0] if len(missing) == 1 else "*"
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
        addressed = list(expected) if expected is not None else self._expected(boats)
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
        acks = self._ask(command, addressed)
        olds = {ack.old for ack in acks.values() if ack is not None and ack.old}
        news = {ack.new for ack in acks.values() if ack is not None and ack.new}
        return Outcome(kind, command.id, acks, " | ".join(sorted(olds)), " | ".join(sorted(news)))

    # -- missions and formations -----------------------------------------------------------------------------------
    def _held_by_anybody(self) -> Change | None:
        """The newest mission and formation that any boat holds."""
        missions: dict[str, MissionOrder] = {}
        for answer in self._bus.ask_all(keys.MISSION, b"", min(1.0, self.timeout_s)).values():
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
        for answer in self._bus.ask_all(keys.FORMATION, b"", min(1.0, self.timeout_s)).values():
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

    def mission_of(self, boat: str) -> tuple[str, Mission] | None:
        """(mission id, mission) that one boat holds; None when it holds none, or does not answer."""
        answer = self._bus.ask_all(keys.MISSION, b"", min(1.0, self.timeout_s), boat).get(boat)
        try:
            held = decode(answer, Held) if answer is not None else None
            order = decode_mission_order(held.order) if held is not None and held.order is not None else None
        except Refused:
            return None
        return (order.mission_id, decode_mission(order.mission)) if order is not None else None

    def formation(self) -> Change:
        """The formation that the boats hold; FleetError when they hold none."""
        held = self._held_by_anybody()
        if held is None:
            if not self._bus.alive():
                raise NobodyReachable(f"no boat of fleet {self.fleet!r} is in reach at {', '.join(self._connect)}")
            raise FleetError(f"no boat of fleet {self.fleet!r} holds a mission: `fleet launch MISSION` first")
        return held

    def launch(self, mission: Mission, *, apply_in_s: float = 2.0) -> Outcome:
        """Give the boats of the roster a mission; they begin together after `apply_in_s`."""
        findings = check(mission)
        if findings.problems:
            from fleet.errors import MissionError

            raise MissionError("mission", findings.problems)
        roster = [boat.name for boat in mission.boats]
        stamp_ns = self._clock.time_ns()
        order = MissionOrder(
            MAJOR, f"{stamp_ns}-{self.operator}", self.operator, stamp_ns, encode_mission(mission), apply_in_s
        )
        outcome = self.command("launch", roster, order=self._words("mission", order), expected=roster)
        others = sorted({ack.version for ack in outcome.acks.values() if ack is not None} - {"", __version__})
        note = f"boats run fleet {', '.join(others)}, this is {__version__}" if others else ""
        return Outcome("launch", outcome.id, outcome.acks, outcome.old, mission.title, note)

    def set_spacing(self, spacing_m: float, *, apply_in_s: float = 2.0) -> Outcome:
        """Change the formation distance on all boats together."""
        return self.set("spacing", spacing_m, apply_in_s=apply_in_s)

    def set_speed(self, cruise_mps: float, *, apply_in_s: float = 2.0) -> Outcome:
        """Change the cruise speed on all boats together."""
        return self.set("speed", cruise_mps, apply_in_s=apply_in_s)

    def set_pattern(self, pattern: str, *, apply_in_s: float = 2.0) -> Outcome:
        """Draw the fleet up in another pattern; each boat takes the slot that makes all ways together shortest."""
        return self.set("pattern", pattern, apply_in_s=apply_in_s)

    def set_lateral(self, lateral_m: float, *, apply_in_s: float = 2.0) -> Outcome:
        """Change the distance abeam from slot to slot on all boats together."""
        return self.set("lateral", lateral_m, apply_in_s=apply_in_s)

    def set_leader(self, boat: str, *, apply_in_s: float = 2.0) -> Outcome:
        """This boat leads: it and the leader exchange their slots."""
        return self.set("leader", boat, apply_in_s=apply_in_s)

    def set_slots(self, slots: Mapping[str, float], *, apply_in_s: float = 2.0) -> Outcome:
        """Give some boats other slots; the others keep theirs."""
        return self.set("slots", ",".join(f"{boat}={slot!r}" for boat, slot in slots.items()), apply_in_s=apply_in_s)

    def set(self, what: str, value: float | str, *, apply_in_s: float = 2.0) -> Outcome:
        """Change the formation on all boats together; `what` is a key of `fleet.mission.change.CHANGES`."""
        held = self.formation()
        shape = changed(held.roster, held.shape, what, value)
        revision = Revision(held.revision.counter + 1, self.operator)
        stamp_ns = self._clock.time_ns()
        order = order_for(shape, held.mission, held.mission_id, revision, held.revision, apply_in_s, stamp_ns)
        expected = sorted({*held.roster} | {b for b in self._bus.alive() if b in held.roster})
        outcome = self.command("set", (), order=self._words("formation", order), expected=expected)
        old, new = (words(held.roster, one, what) for one in (held.shape, shape))
        slots = words(held.roster, shape, "slots")
        note = f"slots {slots}" if what != "slots" and shape.slots != held.shape.slots else ""
        return Outcome(f"set {what}", outcome.id, outcome.acks, old, new, note)

    def send_roster(self) -> Outcome:
        """Bring boats and hubs this operator's roster; those that hold a newer one keep theirs."""
        trust = self.trust
        if trust is None:
            raise UsageError("sending the roster needs credentials; expected --credentials FOLDER")
        acks: dict[str, Ack | None] = dict.fromkeys((*self._bus.alive(), *(one.name for one in trust.members("hub"))))
        deadline = self._clock.monotonic() + self.timeout_s
        while (left := deadline - self._clock.monotonic()) > 0.0 and (None in acks.values() or not acks):
            for boat, answer in self._bus.ask_all(keys.ROSTER, trust.envelope, left).items():
                with contextlib.suppress(Refused):
                    acks[boat] = decode(answer, Ack)
            self._clock.sleep(min(ASK_AGAIN_S, max(0.0, deadline - self._clock.monotonic())))
        olds = {ack.old for ack in acks.values() if ack is not None and ack.old}
        return Outcome("roster", "", acks, " | ".join(sorted(olds)), str(trust.roster.number))

    # -- words -----------------------------------------------------------------------------------------------------
    def hold(self, boats: Sequence[str] = ()) -> Outcome:
        """Keep station."""
        return self.command("hold", boats)

    def resume(self, boats: Sequence[str] = (), *, at: str = "") -> Outcome:
        """Go on; after a restart `at` says where: `nearest`, or an abscissa in metres."""
        return self.command("resume", boats, text=at)

    def abort(self, boats: Sequence[str] = ()) -> Outcome:
        """End the mission, then hold."""
        return self.command("abort", boats)

    def return_home(self, boats: Sequence[str] = ()) -> Outcome:
        """Back along the travelled track to home, then hold."""
        return self.command("return", boats)

    def stop_now(self, boats: Sequence[str] = ()) -> Outcome:
        """No thrust, until released."""
        return self.command("stop-now", boats)

    def release(self, boats: Sequence[str] = (), ids: Sequence[str] = ()) -> Outcome:
        """Release stops: the ids named, else every one that the boats publish."""
        names = list(ids)
        if not names:
            deadline = self._clock.monotonic() + min(1.0, self.timeout_s)
            while self._clock.monotonic() < deadline:
                views = [view for view in self.look().values() if view.alive]
                if views and all(view.state is not None for view in views):
                    break
                self._clock.sleep(0.02)
            states = [view.state for view in self.look().values() if not boats or view.name in boats]
            names = sorted({stop for state in states if state is not None for stop in state.stops})
        return self.command("release", boats, names=names)

    def take(self) -> Outcome:
        """Take control."""
        return self.command("take")

    def forget(self, names: Sequence[str]) -> Outcome:
        """Tell the others that these silent boats are gone from the water."""
        reachable = [boat for boat in self._bus.alive() if boat not in names]
        return self.command("forget", (), names=names, expected=sorted(reachable))
