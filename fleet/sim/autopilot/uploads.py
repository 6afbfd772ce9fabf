"""Missions to the simulated autopilot: asked for item by item, stored as they come. It stores them and sails none."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

from msgspec import Struct

AGAIN_NS, CANCEL_NS = 1_000_000_000, 8_000_000_000
ACCEPTED, UNSUPPORTED, INVALID, WRONG_SEQUENCE, DENIED, CANCELLED = 0, 3, 5, 13, 14, 15
SUPPORTED = frozenset((16, 17, 18, 19, 20, 93, 112, 177, 178, 179, 183, 201, 213, 222))
KINDS = (0, 1, 2)  # mission, fence, rally points


class Upload(Struct):
    """One that is under way."""

    peer: Hashable
    source: tuple[int, int]
    kind: int
    count: int
    next: int
    asked_ns: int
    heard_ns: int


class Uploads:
    """What the autopilot stores, and who is sending."""

    def __init__(self, mavlink: Any, send: Callable[[Hashable, Any], None]) -> None:
        self._mavlink, self._send = mavlink, send
        self.stored: dict[int, list[Any]] = {kind: [] for kind in KINDS}
        self._now: Upload | None = None

    def hear(self, peer: Hashable, m: Any, now_ns: int) -> None:
        """A message of the mission protocol."""
        kind, source = m.get_type(), (m.get_srcSystem(), m.get_srcComponent())
        if m.mission_type not in KINDS:
            self._acknowledge(peer, source, INVALID, m.mission_type)
        elif kind == "MISSION_COUNT":
            self._begin(peer, source, m, now_ns)
        elif kind == "MISSION_ITEM_INT" and self._now is not None and self._now.peer == peer:
            self._take(self._now, m, now_ns)
        elif kind == "MISSION_REQUEST_LIST":
            count = len(self.stored[m.mission_type])
            self._send(peer, self._mavlink.MAVLink_mission_count_message(*source, count, m.mission_type))
        elif kind in ("MISSION_REQUEST", "MISSION_REQUEST_INT") and m.seq < len(self.stored[m.mission_type]):
            self._send(peer, self._copy(self.stored[m.mission_type][m.seq], source))
        elif kind == "MISSION_CLEAR_ALL":
            self.stored[m.mission_type] = []
            self._acknowledge(peer, source, ACCEPTED, m.mission_type)

    def step(self, now_ns: int) -> None:
        """Ask again after a second; give up after eight."""
        upload = self._now
        if upload is None:
            return
        if now_ns - upload.heard_ns >= CANCEL_NS:
            self._end(upload, CANCELLED)
        elif now_ns - upload.asked_ns >= AGAIN_NS:
            self._ask(upload, now_ns)

    def _begin(self, peer: Hashable, source: tuple[int, int], m: Any, now_ns: int) -> None:
        if self._now is not None and self._now.peer != peer:
            self._acknowledge(peer, source, DENIED, m.mission_type)
            return
        self.stored[m.mission_type] = []
        self._now = Upload(peer, source, m.mission_type, m.count, 0, now_ns, now_ns)
        if m.count:
            self._ask(self._now, now_ns)
        else:
            self._end(self._now, ACCEPTED)

    def _take(self, upload: Upload, m: Any, now_ns: int) -> None:
        upload.heard_ns = now_ns
        if m.seq != upload.next:
            self._acknowledge(upload.peer, upload.source, WRONG_SEQUENCE, upload.kind)
            return
        if upload.kind == 0 and m.command not in SUPPORTED:
            self._end(upload, UNSUPPORTED)  # what came before is stored already
            return
        self.stored[upload.kind].append(m)
        upload.next += 1
        if upload.next < upload.count:
            self._ask(upload, now_ns)
        else:
            self._end(upload, ACCEPTED)

    def _ask(self, upload: Upload, now_ns: int) -> None:
        upload.asked_ns = now_ns
        make = self._mavlink.MAVLink_mission_request_message
        self._send(upload.peer, make(*upload.source, upload.next, upload.kind))

    def _end(self, upload: Upload, result: int) -> None:
        self._now = None
        self._acknowledge(upload.peer, upload.source, result, upload.kind)

    def _acknowledge(self, peer: Hashable, source: tuple[int, int], result: int, kind: int) -> None:
        self._send(peer, self._mavlink.MAVLink_mission_ack_message(*source, result, kind))

    def _copy(self, m: Any, source: tuple[int, int]) -> Any:
        p = (m.param1, 0.0 if m.command == 16 else m.param2, m.param3, m.param4)  # the acceptance radius is dropped
        place = (m.x, m.y, m.z, m.mission_type)
        make = self._mavlink.MAVLink_mission_item_int_message
        return make(*source, m.seq, m.frame, m.command, m.current, m.autocontinue, *p, *place)
