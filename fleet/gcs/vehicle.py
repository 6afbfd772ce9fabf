"""One boat of the fleet as a MAVLink vehicle: messages in, messages and wishes out. No socket, no clock, no fleet."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from fleet.agent.modes import Mode
from fleet.errors import FleetError
from fleet.gcs import commands, display, modes, tuning
from fleet.gcs import numbers as n
from fleet.gcs.items import Item, WrongItem, course_of, item_of
from fleet.gcs.parameters import PARAMETERS
from fleet.gcs.seat import Peer, Station
from fleet.gcs.shared import Charted, Shared
from fleet.gcs.telemetry import RATES, Shown, pieces
from fleet.gcs.uploads import Missions
from fleet.gcs.wishes import Done, Kind
from fleet.mission.model import Geographic
from fleet.wire.messages import BoatState

HEARTBEAT_S = 1.0
PERIODS = {message: 1.0 / hz for message, hz in RATES.items()}
STAGGER_S, STAGGERED = 0.05, 5  # vehicles do not all speak at once
QUIET_S = 3.0  # without a state
TEXTS_S, MOST_TEXTS = 0.2, 10  # one more text in so long, and so many at once
WATCHED_S = 1.0  # between two looks whether a parameter has changed
MISSION_MESSAGES = frozenset(
    f"MISSION_{word}"
    for word in (
        *("COUNT", "ITEM", "ITEM_INT", "CLEAR_ALL", "WRITE_PARTIAL_LIST"),
        *("REQUEST", "REQUEST_INT", "REQUEST_LIST", "REQUEST_PARTIAL_LIST"),
    )
)
GUIDED_ITEM = 2  # `current` of an item that is a place to go to at once

Send = Callable[[Peer | None, Any], None]
Report = Callable[[Peer | None, int, Shown], None]
Ask = Callable[[Kind, str, Any, Callable[[Done], None]], None]
"""(kind, boat, value, what to do with the answer)."""


class Vehicle:
    """See the module."""

    def __init__(
        self,
        mavlink: Any,
        boat: str,
        sysid: int,
        shared: Shared,
        send: Send,
        report: Report,
        ask: Ask,
        *,
        autopilot: int,
    ) -> None:
        """Args: send: a message to a peer, None to all; report: one of `MAKERS`, by its number, of the boat as it is
        shown; ask: a wish, and what to do when it is done.
        """
        self.mavlink, self.boat, self.sysid, self.shared = mavlink, boat, sysid, shared
        self.send, self.report, self._ask, self._autopilot = send, report, ask, autopilot
        self.missions = Missions(
            mavlink, send, self.say, self.items, self._uploaded, self._may, home_first=shared.home_first
        )
        self.ready = self.alone = False
        self.alone_charted: Charted | None = None
        self.going = ""  # id of the mission that is a go-to
        self.asked, self.asked_s = -1, 0.0
        self.now_s = 0.0
        self.quiet = True  # not heard: it sends nothing
        self.shown: Shown | None = None
        self.busy: set[tuple[Peer, int, int]] = set()  # commands that are being done: peer, system, command
        self._home: Geographic | None = None
        self._beat_s = -math.inf
        self._beaten: tuple[int, bool, int] | None = None
        self._due: dict[int, float] = {}
        self._next_s = 0.0  # nothing falls due before
        self._says: tuple[object, ...] = ()
        self._item = 0
        self._texts, self._room, self._room_s = 0, float(MOST_TEXTS), 0.0
        self.values: dict[str, float] = {}
        self._watched_s = 0.0

    # -- time ------------------------------------------------------------------------------------------------------
    def step(self, now_s: float) -> None:
        """So late it is: what falls due."""
        self.now_s = now_s
        self.missions.step(now_s)
        view = self.shared.views.get(self.boat)
        heard = view is not None and view.state is not None and view.alive and now_s - view.heard_s < QUIET_S
        if not heard:
            if not self.quiet:
                self.quiet, self.ready = True, False
                self.tell(n.CRITICAL, f"{self.boat} is not heard any more: no HEARTBEAT until it is")
            return
        assert view is not None
        assert view.state is not None
        if now_s - self._watched_s >= WATCHED_S:
            self._watched_s = now_s
            tuning.watch(self)
        says = _says(view.state)
        if says == self._says and now_s < self._next_s and not self.quiet:
            return
        self._says = says
        shown = self._look(now_s)
        if self.quiet:
            self.quiet = False
            self._due = dict.fromkeys(PERIODS, now_s + STAGGER_S * (self.sysid % STAGGERED))
            self._beaten = None
        beat = (shown.mode, shown.armed, display.system_status(shown.state))
        if beat != self._beaten or now_s - self._beat_s >= HEARTBEAT_S:
            self._beaten, self._beat_s = beat, now_s
            self.report(None, n.HEARTBEAT, shown)
        self._stream(now_s, shown)
        self._progress(shown)

    def _stream(self, now_s: float, shown: Shown) -> None:
        """The messages that are due."""
        for message, period_s in PERIODS.items():
            due_s = self._due[message]
            if now_s >= due_s:
                self._due[message] = due_s + period_s if now_s - due_s < period_s else now_s + period_s
                self.report(None, message, shown)
        self._next_s = min(self._beat_s + HEARTBEAT_S, *self._due.values())

    def _look(self, now_s: float) -> Shown:
        """What the boat looks like now."""
        view = self.shared.views[self.boat]
        state = view.state
        assert state is not None
        if state.mode != Mode.STANDBY or state.stops:
            self.ready = False
        if self._home is None and display.sound(state):
            self._home = Geographic(lat_deg=state.lat_deg, lon_deg=state.lon_deg)
        going = bool(self.going) and state.mission_id == self.going
        items = self.items()
        sails = state.mode != Mode.STANDBY
        shown = self.shown or Shown(state, autopilot=self._autopilot)
        shown.state, shown.status = state, view.status
        shown.home = self.shared.homes.get(state.mission_id, self._home)
        shown.mode = display.shown_mode(state, going, self.asked, self.asked_s, now_s)
        shown.armed = display.armed(state, self.ready)
        shown.items = len(items)
        shown.item = self.shared.progress(self.boat, items) if sails and self._sailed(items) else 0
        self.shown = shown
        return shown

    def beat(self) -> None:
        """A HEARTBEAT now: something has changed."""
        if not self.quiet:
            self._beat_s = self.now_s
            shown = self._look(self.now_s)
            self._beaten = (shown.mode, shown.armed, display.system_status(shown.state))
            self.report(None, n.HEARTBEAT, shown)

    def _progress(self, shown: Shown) -> None:
        """Items that were passed."""
        if shown.item > self._item > 0:
            for seq in range(self._item, shown.item):
                self.send(None, self.mavlink.MAVLink_mission_item_reached_message(seq))
        self._item = shown.item

    # -- texts -----------------------------------------------------------------------------------------------------
    def say(self, peer: Peer | None, severity: int, text: str) -> None:
        """A STATUSTEXT to a peer, or to all; too many are passed over."""
        self._room = min(float(MOST_TEXTS), self._room + (self.now_s - self._room_s) / TEXTS_S)
        self._room_s = self.now_s
        if self._room < 1.0:
            return
        self._room -= 1.0
        self._texts = self._texts % 65535 + 1
        for piece in pieces(self.mavlink, severity, text, self._texts):
            self.send(peer, piece)

    def tell(self, severity: int, text: str) -> None:
        """A STATUSTEXT to all."""
        self.say(None, severity, text)

    # -- hearing ---------------------------------------------------------------------------------------------------
    def hear(self, station: Station, m: Any, now_s: float) -> None:
        """A message for this boat from a ground station."""
        self.now_s = now_s
        kind, peer = m.get_type(), station[0]
        if kind in MISSION_MESSAGES:
            if getattr(m, "current", 0) == GUIDED_ITEM and kind in ("MISSION_ITEM", "MISSION_ITEM_INT"):
                self._guided(station, m)
            else:
                self.missions.hear(peer, m, now_s)
        elif kind in ("COMMAND_LONG", "COMMAND_INT"):
            commands.obey(self, station, m)
        elif kind == "SET_MODE":
            modes.set_mode_unanswered(self, station, m.custom_mode)
        elif kind == "PARAM_REQUEST_LIST":
            for number, parameter in enumerate(PARAMETERS):
                tuning.tell_parameter(self, peer, parameter.name, number)
        elif kind == "PARAM_REQUEST_READ":
            tuning.read_parameter(self, peer, m)
        elif kind == "PARAM_SET":
            tuning.set_parameter(self, station, m)
        elif kind == "MISSION_SET_CURRENT":
            self.say(peer, n.WARNING, "a boat begins where it is nearest to its path: items cannot be chosen")
        elif kind == "FILE_TRANSFER_PROTOCOL":
            self._no_files(peer, m)
        elif kind in ("MANUAL_CONTROL", "RC_CHANNELS_OVERRIDE"):
            self.say(peer, n.WARNING, "no manual control: boats of the fleet steer themselves")

    def ask(self, kind: Kind, value: Any, then: Callable[[Done], None]) -> None:
        """A wish about this boat."""
        self._ask(kind, self.boat, value, then)

    def _no_files(self, peer: Peer, m: Any) -> None:
        """There are none: a negative acknowledgement, so that nobody waits."""
        sent = bytes(m.payload[:12])
        number = (int.from_bytes(sent[:2], "little") + 1) % 65536
        answer = number.to_bytes(2, "little") + bytes((sent[2], 129, 1, sent[3], 0, 0)) + bytes(4) + bytes((7,))
        payload = list(answer.ljust(251, b"\0"))
        to = (m.get_srcSystem(), m.get_srcComponent())
        self.send(peer, self.mavlink.MAVLink_file_transfer_protocol_message(0, *to, payload))

    def _may(self, station: Station) -> str:
        """Why a station may not command; '' when it may."""
        return self.shared.seat.refusal(station, self.now_s)

    # -- missions --------------------------------------------------------------------------------------------------
    @property
    def charted(self) -> Charted | None:
        """What was uploaded for this boat: for it alone, or for its formation."""
        return self.alone_charted if self.alone else self.shared.charted

    def _sailed(self, items: tuple[Item, ...]) -> bool:
        """Whether these are the items that it sails by."""
        charted, state = self.charted, self.shared.state(self.boat)
        return (
            charted is None
            or charted.items is not items
            or (state is not None and charted.mission_id == state.mission_id)
        )

    def items(self) -> tuple[Item, ...]:
        """What is downloaded: what was uploaded and waits or is sailed; else the mission that the boat holds."""
        charted, state = self.charted, self.shared.state(self.boat)
        if charted is not None and (
            not charted.mission_id or (state is not None and state.mission_id == charted.mission_id)
        ):
            return charted.items
        return self.shared.items(self.boat) or (charted.items if charted is not None else ())

    def _keep(self, charted: Charted | None) -> None:
        if self.alone:
            self.alone_charted = charted
        else:
            self.shared.charted = charted

    def _uploaded(self, peer: Peer, items: tuple[Item, ...]) -> None:
        """All items are there: would the fleet sail it?"""
        if not items:
            self._keep(None)
            return
        alone = self.alone
        try:
            course = course_of(items, home_first=self.shared.home_first)
            mission = self.shared.mission_for(course, self.boat, alone=alone)
        except WrongItem as error:
            self.missions.checked(items, str(error), error.result)
            return
        except FleetError as error:
            self.missions.checked(items, str(error))
            return

        def then(done: Done) -> None:
            if done.ok and self.alone == alone:
                self._keep(Charted(items, course, self.boat, alone))
                whom = self.boat if alone else ", ".join(boat.name for boat in mission.boats)
                self.say(peer, n.NOTICE, f"mission for {whom}; AUTO starts it")
            self.missions.checked(items, "" if done.ok else done.text)

        self.ask("chart", mission, then)

    def _guided(self, station: Station, m: Any) -> None:
        """A place to go to, as an item of a mission; acknowledged as one."""
        item, peer = item_of(m), station[0]
        to = (m.get_srcSystem(), m.get_srcComponent())

        def answer(result: int) -> None:
            code = n.MISSION_ACCEPTED if result == n.ACCEPTED else n.MISSION_ERROR
            self.send(peer, self.mavlink.MAVLink_mission_ack_message(*to, code, n.MISSION))

        commands.go_to(self, station, item.x, item.y, item.frame, 0.0, answer)


def _says(state: BoatState) -> tuple[object, ...]:
    """What is shown at once when it changes; anything else can wait until a message is due that tells it."""
    return state.mode, state.reasons, state.stops, state.mission_id
