"""The mission protocol of one boat: asked for item by item, stored only when complete. Frames and times handed in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from msgspec import Struct

from fleet.gcs import numbers as n
from fleet.gcs.items import Item, item_of, refusal
from fleet.gcs.seat import Peer, Station

AGAIN_S, CANCEL_S = 1.0, 8.0
MOST = 500  # items

Source = tuple[int, int]
"""System and component of who asks."""


class Upload(Struct):
    """One that is under way."""

    peer: Peer
    source: Source
    count: int
    items: list[Item]
    asked_s: float
    heard_s: float
    checking: bool = False  # all items are there, the fleet's own checks are not done


class Missions:
    """Up and down."""

    def __init__(
        self,
        mavlink: Any,
        send: Callable[[Peer, Any], None],
        say: Callable[[Peer, int, str], None],
        shown: Callable[[], tuple[Item, ...]],
        complete: Callable[[Peer, tuple[Item, ...]], None],
        refusal: Callable[[Station], str],
        *,
        home_first: bool,
    ) -> None:
        """Args: send, say: a message, a STATUSTEXT to a peer; shown: what is downloaded; complete: an upload is;
        refusal: why a station may not upload.
        """
        self._mavlink, self._send, self._say = mavlink, send, say
        self._shown, self._complete, self._home_first, self._refusal = shown, complete, home_first, refusal
        self._down: dict[Peer, tuple[Item, ...]] = {}  # a download keeps to what it began with
        self.upload: Upload | None = None

    def hear(self, peer: Peer, m: Any, now_s: float) -> None:
        """A message of the mission protocol."""
        kind, source = m.get_type(), (m.get_srcSystem(), m.get_srcComponent())
        if kind == "MISSION_COUNT":
            self._begin(peer, source, m, now_s)
        elif kind in ("MISSION_ITEM", "MISSION_ITEM_INT"):
            self._take(peer, source, m, now_s)
        elif kind == "MISSION_REQUEST_LIST":
            self._list(peer, source, m.mission_type)
        elif kind in ("MISSION_REQUEST", "MISSION_REQUEST_INT"):
            self._hand_out(peer, source, m, whole=kind == "MISSION_REQUEST_INT")
        elif kind == "MISSION_CLEAR_ALL":
            if m.mission_type in (n.MISSION, n.ALL_KINDS):
                self._complete_empty(peer, source, m.mission_type)
            else:
                self._acknowledge(peer, source, n.MISSION_ACCEPTED, m.mission_type)  # there is none
        elif kind in ("MISSION_WRITE_PARTIAL_LIST", "MISSION_REQUEST_PARTIAL_LIST"):
            self._acknowledge(peer, source, n.MISSION_UNSUPPORTED, m.mission_type)

    def step(self, now_s: float) -> None:
        """Ask again after a second; give up after eight."""
        upload = self.upload
        if upload is None or upload.checking:
            return
        if now_s - upload.heard_s >= CANCEL_S:
            self._end(upload, n.CANCELLED, "the upload was not finished")
        elif now_s - upload.asked_s >= AGAIN_S:
            self._ask(upload, now_s)

    def checked(self, items: tuple[Item, ...], refused: str, result: int = n.INVALID) -> None:
        """The fleet's checks of a complete upload are done; '' or why it cannot be sailed."""
        upload = self.upload
        if upload is not None and upload.checking and tuple(upload.items) == items:
            self._end(upload, result if refused else n.MISSION_ACCEPTED, refused)

    # -- up --------------------------------------------------------------------------------------------------------
    def _begin(self, peer: Peer, source: Source, m: Any, now_s: float) -> None:
        if m.mission_type != n.MISSION:
            known = m.mission_type in (n.FENCE, n.RALLY)
            self._acknowledge(peer, source, n.MISSION_UNSUPPORTED if m.count or not known else 0, m.mission_type)
            if m.count and known:
                self._say(peer, n.WARNING, "fences and rally points cannot be uploaded: a mission file has the fence")
            return
        upload = self.upload
        if upload is not None and (upload.peer, upload.source) != (peer, source):
            self._acknowledge(peer, source, n.MISSION_DENIED)
            self._say(peer, n.WARNING, "another ground station is uploading")
            return
        why = self._refusal((peer, source[0]))
        if why:
            self._acknowledge(peer, source, n.MISSION_DENIED)
            self._say(peer, n.WARNING, f"mission refused: {why}")
            return
        if m.count > MOST:
            self.upload = None
            self._acknowledge(peer, source, n.NO_SPACE)
            self._say(peer, n.WARNING, f"{m.count} items; at most {MOST}")
        elif m.count == 0:
            self._complete_empty(peer, source, n.MISSION)
        else:
            self.upload = Upload(peer, source, m.count, [], now_s, now_s)
            self._ask(self.upload, now_s)

    def _complete_empty(self, peer: Peer, source: Source, kind: int) -> None:
        upload = self.upload
        if upload is not None and (upload.peer, upload.source) != (peer, source):
            self._acknowledge(peer, source, n.MISSION_DENIED, kind)
            return
        why = self._refusal((peer, source[0]))
        if why:
            self._acknowledge(peer, source, n.MISSION_DENIED, kind)
            self._say(peer, n.WARNING, f"clearing refused: {why}")
            return
        self.upload = None
        self._complete(peer, ())
        self._acknowledge(peer, source, n.MISSION_ACCEPTED, kind)

    def _take(self, peer: Peer, source: Source, m: Any, now_s: float) -> None:
        upload = self.upload
        if upload is None or m.mission_type != n.MISSION:
            self._acknowledge(peer, source, n.MISSION_ERROR, m.mission_type)  # nobody asked for it
            return
        if (upload.peer, upload.source) != (peer, source):
            self._acknowledge(peer, source, n.MISSION_DENIED)
            return
        upload.heard_s = now_s
        if upload.checking:
            return
        expected = len(upload.items)
        if m.seq == expected - 1:  # sent twice
            return
        if m.seq != expected:
            self._acknowledge(peer, source, n.WRONG_SEQUENCE)
            return
        item = item_of(m)
        result, why = refusal(item, home=self._home_first and item.seq == 0)
        if result:
            self._end(upload, result, why)
            return
        upload.items.append(item)
        if len(upload.items) < upload.count:
            self._ask(upload, now_s)
        else:
            upload.checking = True
            self._complete(peer, tuple(upload.items))

    def _ask(self, upload: Upload, now_s: float) -> None:
        upload.asked_s = now_s
        make = self._mavlink.MAVLink_mission_request_int_message
        self._send(upload.peer, make(*upload.source, len(upload.items), n.MISSION))

    def _end(self, upload: Upload, result: int, why: str) -> None:
        self.upload = None
        if why:
            self._say(upload.peer, n.WARNING, f"mission refused: {why}" if result != n.CANCELLED else why)
        self._acknowledge(upload.peer, upload.source, result)

    def _acknowledge(self, peer: Peer, source: Source, result: int, kind: int = n.MISSION) -> None:
        self._send(peer, self._mavlink.MAVLink_mission_ack_message(*source, result, kind))

    # -- down ------------------------------------------------------------------------------------------------------
    def _list(self, peer: Peer, source: Source, kind: int) -> None:
        items = self._shown() if kind == n.MISSION else ()
        if kind == n.MISSION:
            if peer not in self._down and len(self._down) >= 16:
                del self._down[next(iter(self._down))]
            self._down[peer] = items
        self._send(peer, self._mavlink.MAVLink_mission_count_message(*source, len(items), kind))

    def _hand_out(self, peer: Peer, source: Source, m: Any, *, whole: bool) -> None:
        items = self._down.get(peer) or self._shown() if m.mission_type == n.MISSION else ()
        if m.seq >= len(items):
            self._acknowledge(peer, source, n.WRONG_SEQUENCE, m.mission_type)
            return
        item = items[m.seq]
        name = "mission_item_int" if whole else "mission_item"
        x, y = (item.x, item.y) if whole else (item.x / 1e7, item.y / 1e7)
        make = getattr(self._mavlink, f"MAVLink_{name}_message")
        head = (item.seq, item.frame, item.command, item.current, item.autocontinue)
        self._send(peer, make(*source, *head, *item.params, x, y, item.z, m.mission_type))
