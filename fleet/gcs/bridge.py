"""All boats of a fleet as vehicles on one link. Bytes and times in, bytes and wishes out."""

from __future__ import annotations

import logging
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from fleet.drivers.mavlink.frames import Frames
from fleet.gcs import numbers as n
from fleet.gcs.passage import Passages
from fleet.gcs.seat import Peer, Station
from fleet.gcs.shared import Shared
from fleet.gcs.sysids import Sysids
from fleet.gcs.telemetry import MAKERS, Shown, pieces
from fleet.gcs.vehicle import Vehicle
from fleet.gcs.voice import Voice
from fleet.gcs.wishes import Done, Kind, Wish
from fleet.mission.model import Mission
from fleet.operator.view import BoatView
from fleet.wire.messages import FleetEvent

log = logging.getLogger("fleet.gcs")
LOOK_AGAIN_S = 2.0
MOST_WISHES = 256
GATHER_S = 1.5  # boats are heard in any order; those that have no number yet get theirs by name
SEVERITIES = {"refused": n.WARNING, "mode": n.NOTICE, "trouble": n.ERROR, "stop": n.CRITICAL, "superseded": n.WARNING}
"""Of events; others are told as information."""


def in_order(boat: str) -> list[tuple[int, str]]:
    """b2 before b10."""
    return [(int(part), "") if part.isdigit() else (0, part) for part in re.split(r"(\d+)", boat)]


class Bridge:
    """The engine; a socket and a fleet are joined to it by `run`."""

    def __init__(
        self,
        mavlink: Any,
        sysids: Sysids,
        *,
        operator: str,
        autopilot: int,
        template: Mission | None = None,
        sign: Callable[[Any], None] = lambda codec: None,
    ) -> None:
        """Args: sign: makes a codec sign and check, where there is a key."""
        self.mavlink, self._sysids, self._autopilot, self._sign = mavlink, sysids, autopilot, sign
        self.shared = Shared(operator, template, home_first=autopilot != n.GENERIC)
        self.vehicles: dict[str, Vehicle] = {}
        self.passages = Passages()
        self.outbox: list[tuple[Peer | None, bytes]] = []  # (peer, frame); None: to all
        self.wishes: list[Wish] = []
        self.notes: list[str] = []  # for whoever started the bridge
        self.counts: Counter[str] = Counter()
        self._frames = Frames(mavlink)
        sign(self._frames.codec)
        self._by_sysid: dict[int, Vehicle] = {}
        self._then: dict[int, Callable[[Done], None]] = {}
        self._number = 0
        self._looked_s: dict[str, float] = {}
        self._admitted: dict[str, None] = {}
        self._began_s: float | None = None
        self._own = mavlink.MAVLink(None, srcSystem=0, srcComponent=n.COMPANION)
        self._texts = 0

    # -- who there is ----------------------------------------------------------------------------------------------
    def look(self, views: Mapping[str, BoatView], events: Iterable[FleetEvent], now_s: float) -> None:
        """What the fleet says now."""
        self.shared.views = dict(views)
        self._began_s = now_s if self._began_s is None else self._began_s
        new = sorted((boat for boat in views if boat not in self._admitted), key=in_order)
        for boat in (*self._admitted, *new):
            view = views.get(boat)
            if view is None:
                continue
            if view.status is None or view.state is None:  # its status says whether it has an autopilot of its own
                continue
            waits = now_s - self._began_s < GATHER_S and not self._sysids.knows(boat)
            if not waits and boat not in self._admitted:
                self._admitted[boat] = None
                self._admit(boat, view.status.autopilot)
            mission_id = view.state.mission_id
            if mission_id and mission_id not in self.shared.plans and view.alive:
                self._ask_mission(boat, mission_id, now_s)
        for event in events:
            self._tell(event)

    def _admit(self, boat: str, autopilot: int) -> None:
        """A boat that is heard for the first time."""
        sysid, why = self._sysids.of(boat, autopilot)
        if why:
            self.notes.append(f"{boat}: not shown: {why}")
            return
        if autopilot:
            self.passages.open(boat, sysid)
            self.notes.append(f"{boat}: sysid {sysid}, its autopilot's own frames")
            return
        voice = Voice(self.mavlink, sysid, n.COMPONENT)
        self._sign(voice.codec)

        def send(peer: Peer | None, message: Any) -> None:
            self.outbox.append((peer, voice.message(message)))

        def report(peer: Peer | None, number: int, shown: Shown) -> None:
            self.outbox.append((peer, voice.values(number, MAKERS[number](shown))))

        vehicle = Vehicle(self.mavlink, boat, sysid, self.shared, send, report, self._ask, autopilot=self._autopilot)
        self.vehicles[boat] = self._by_sysid[sysid] = vehicle
        self.notes.append(f"{boat}: sysid {sysid}")

    def _ask_mission(self, boat: str, mission_id: str, now_s: float) -> None:
        if now_s - self._looked_s.get(mission_id, -1e9) < LOOK_AGAIN_S:
            return
        if len(self._looked_s) > 256:
            self._looked_s.clear()
        self._looked_s[mission_id] = now_s

        def then(done: Done) -> None:
            if done.ok and done.value is not None:
                self.shared.learn(*done.value)

        self._ask("look", boat, None, then)

    def _tell(self, event: FleetEvent) -> None:
        """An event of a boat as a STATUSTEXT: of the vehicle, or of the companion of its autopilot."""
        if event.kind == "refused" and f" of {self.shared.operator}: " in event.text:
            return  # it is said to who asked
        severity = SEVERITIES.get(event.kind, n.INFO)
        vehicle, passage = self.vehicles.get(event.boat), self.passages.of_boat(event.boat)
        if vehicle is not None and not vehicle.quiet:
            vehicle.tell(severity, f"{event.kind}: {event.text}")
        elif passage is not None and event.kind != "autopilot":  # that it says itself
            self._companion_says(passage, severity, f"fleet {event.kind}: {event.text}")

    def _companion_says(self, sysid: int, severity: int, text: str) -> None:
        codec = self._own
        codec.srcSystem = sysid
        self._texts = self._texts % 65535 + 1
        for piece in pieces(self.mavlink, severity, text, self._texts):
            self.outbox.append((None, bytes(piece.pack(codec))))
            codec.seq = (codec.seq + 1) % 256

    # -- wishes ----------------------------------------------------------------------------------------------------
    def _ask(self, kind: Kind, boat: str, value: Any, then: Callable[[Done], None]) -> None:
        self._number += 1
        if len(self._then) >= MOST_WISHES and kind not in ("hold", "stop"):
            then(Done(self._number, False, "too much is being done already", silent=True))
            return
        self._then[self._number] = then
        self.wishes.append(Wish(self._number, kind, boat, value))

    def done(self, done: Done, now_s: float) -> None:
        """A wish is done."""
        then = self._then.pop(done.number, None)
        if then is not None:
            for vehicle in self.vehicles.values():
                vehicle.now_s = now_s
            then(done)

    # -- frames ----------------------------------------------------------------------------------------------------
    def hear(self, peer: Peer, datagram: bytes, now_s: float) -> bool:
        """A datagram of a ground station; whether there was anything in it."""
        heard = False
        for m in self._frames.datagram(datagram):
            sysid = m.get_srcSystem()
            if sysid in self._by_sysid or self.passages.has(sysid) or sysid == 0:
                self.counts["own"] += 1  # an echo of what we said
                continue
            heard = True
            self.counts["heard"] += 1
            station: Station = (peer, sysid)
            self.shared.seat.heard(station, now_s)
            self._take(station, m, now_s)
        return heard

    def _take(self, station: Station, m: Any, now_s: float) -> None:
        kind = m.get_type()
        if kind == "TIMESYNC":
            self._synchronise(station, m, now_s)
            return
        if kind == "PING":
            self._pong(station, m)
            return
        target = getattr(m, "target_system", 0)
        if not hasattr(m, "target_system") and kind != "HEARTBEAT":
            self.counts["passed over"] += 1
            return
        frame = bytes(m.get_msgbuf())
        for why in self.passages.down(target, frame, self.shared, now_s):
            self._companion_says(why[0], n.WARNING, why[1])
        if kind == "HEARTBEAT":
            return
        if getattr(m, "target_component", n.COMPONENT) not in (0, n.COMPONENT):
            return
        for vehicle in self._addressed(target):
            try:
                vehicle.hear(station, m, now_s)
            except Exception:  # noqa: BLE001  one message costs itself, not the bridge
                self._failed(f"{kind} could not be taken in")

    def _failed(self, what: str) -> None:
        """A mistake of ours, to be called while handling it."""
        if not self.counts["internal error"]:
            log.exception("%s", what)
        self.counts["internal error"] += 1

    def _addressed(self, target: int) -> list[Vehicle]:
        if target:
            vehicle = self._by_sysid.get(target)
            return [vehicle] if vehicle is not None else []
        return list(self.vehicles.values())

    def _first(self) -> Vehicle | None:
        return min((v for v in self.vehicles.values() if not v.quiet), key=lambda v: v.sysid, default=None)

    def _synchronise(self, station: Station, m: Any, now_s: float) -> None:
        vehicle = self._first()
        if vehicle is not None and m.tc1 == 0:
            vehicle.send(station[0], self.mavlink.MAVLink_timesync_message(int(now_s * 1e9), m.ts1))

    def _pong(self, station: Station, m: Any) -> None:
        vehicle = self._first()
        if vehicle is not None and m.target_system == 0:
            to = (m.get_srcSystem(), m.get_srcComponent())
            vehicle.send(station[0], self.mavlink.MAVLink_ping_message(m.time_usec, m.seq, *to))

    def up(self, boat: str, payload: bytes) -> None:
        """Frames of a boat's own autopilot."""
        for frame in self.passages.up(boat, payload):
            self.outbox.append((None, frame))

    # -- time ------------------------------------------------------------------------------------------------------
    def step(self, now_s: float) -> None:
        """So late it is."""
        for vehicle in self.vehicles.values():
            try:
                vehicle.step(now_s)
            except Exception:  # noqa: BLE001  one boat costs itself, not the bridge
                self._failed(f"{vehicle.boat} could not be shown")

    def take_outbox(self) -> list[tuple[Peer | None, bytes]]:
        """What is to be sent."""
        out, self.outbox = self.outbox, []
        return out

    def take_wishes(self) -> list[Wish]:
        """What the fleet is to be told."""
        wishes, self.wishes = self.wishes, []
        return wishes
