"""Boats that have an autopilot of their own: its frames go through unchanged, both ways. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from fleet.drivers.mavlink.frames import cut

if TYPE_CHECKING:
    from fleet.gcs.shared import Shared

MOST_WAITING = 256  # frames for one boat; beyond that the newest are dropped
MOST_BYTES = 4096
AGAIN_S = 5.0  # between two refusals in the same words


class Passages:
    """Boats by the system id of their autopilots."""

    def __init__(self) -> None:
        self._boats: dict[int, str] = {}
        self._sysids: dict[str, int] = {}
        self._waiting: dict[str, list[bytes]] = {}
        self._refused: dict[str, tuple[str, float]] = {}  # said last, and until when it is not said again
        self.dropped = 0

    def open(self, boat: str, sysid: int) -> None:
        """A boat is one of them."""
        self._boats[sysid], self._sysids[boat], self._waiting[boat] = boat, sysid, []

    def has(self, sysid: int) -> bool:
        """Whether an autopilot has that number."""
        return sysid in self._boats

    def of_boat(self, boat: str) -> int | None:
        """Number of a boat's autopilot."""
        return self._sysids.get(boat)

    @property
    def boats(self) -> tuple[str, ...]:
        """All of them."""
        return tuple(self._sysids)

    def up(self, boat: str, payload: bytes) -> Iterator[bytes]:
        """Frames from a boat, one by one; those that are not its autopilot's are dropped."""
        sysid = self._sysids.get(boat)
        if sysid is None:
            return
        for frame, source in cut(payload):
            if source == sysid:
                yield frame
            else:
                self.dropped += 1

    def down(self, target: int, frame: bytes, shared: Shared, now_s: float) -> list[tuple[int, str]]:
        """A frame for an autopilot, 0 all of them; (sysid, why) where it does not go on, now and then."""
        refused = []
        for sysid, boat in [(target, self._boats[target])] if target in self._boats else list(self._boats.items()):
            if target not in (0, sysid):
                continue
            why = self._refusal(boat, shared)
            if why:
                said, until_s = self._refused.get(boat, ("", 0.0))
                if target and (said != why or now_s >= until_s):
                    self._refused[boat] = (why, now_s + AGAIN_S)
                    refused.append((sysid, why))
                continue
            self._refused.pop(boat, None)
            waiting = self._waiting[boat]
            if len(waiting) < MOST_WAITING:
                waiting.append(frame)
            else:
                self.dropped += 1
        return refused

    @staticmethod
    def _refusal(boat: str, shared: Shared) -> str:
        status, holder = shared.status(boat), shared.controls(boat)
        if status is not None and not status.takes_frames:
            return f'{boat} takes no frames for its autopilot: driver.mavlink.forward is not "both"'
        if holder not in ("", shared.operator):
            return f"{holder} holds control; `fleet take` takes it over"
        return ""

    def take(self) -> dict[str, bytes]:
        """What is to be sent to each boat."""
        out: dict[str, bytes] = {}
        for boat, waiting in self._waiting.items():
            size = count = 0
            for frame in waiting:
                if size + len(frame) > MOST_BYTES:
                    break
                size, count = size + len(frame), count + 1
            if count:
                out[boat] = b"".join(waiting[:count])
                del waiting[:count]
        return out
