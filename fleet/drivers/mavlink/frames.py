"""Bytes to messages: frames are cut out by their headers, those of others passed over unread, bad ones counted.

A bad frame costs one byte: the search goes on right behind its first, so that junk swallows no good frame.
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

V1, V2 = 0xFE, 0xFD
OVERHEAD = {V1: 8, V2: 12}  # header and checksum
SIGNED, SIGNATURE = 0x01, 13  # flag; bytes of a signature
LONGEST = 12 + 255 + SIGNATURE


def _next(buffer: bytes, i: int) -> int:
    """Where the next frame may begin, the end if none does."""
    starts = (buffer.find(V1, i), buffer.find(V2, i), len(buffer))
    return min(start for start in starts if start >= 0)


def cut(payload: bytes) -> Iterator[tuple[bytes, int]]:
    """(frame, sender's sysid) of bytes that hold whole frames, by their headers alone; what is none is passed over."""
    i, n = 0, len(payload)
    while (i := _next(payload, i)) < n:
        overhead = OVERHEAD[payload[i]]
        end = i + overhead + payload[i + 1] if i + overhead <= n else n + 1
        if end <= n and payload[i] == V2 and payload[i + 2] & SIGNED:
            end += SIGNATURE
        if end <= n:
            yield payload[i:end], payload[i + (5 if payload[i] == V2 else 3)]
        i = end if end <= n else i + 1


class Frames:
    """Decodes what one vehicle says."""

    def __init__(
        self,
        mavlink: Any,
        sysid: int | None = None,
        component: int | None = None,
        wanted: frozenset[int] | None = None,
    ) -> None:
        """Args: mavlink: dialect module; sysid, component, wanted: sender and messages listened to, None all."""
        self.codec = mavlink.MAVLink(None)
        self._error = mavlink.MAVError
        self._known = mavlink.mavlink_map
        self._sysid, self._component, self._wanted = sysid, component, wanted
        self.tap: Callable[[bytes], None] | None = None  # gets every frame of our vehicle, as it came
        self._rest = b""
        self.counts: Counter[str] = Counter()  # "taken", "bad", "others"; "junk" in bytes

    def datagram(self, payload: bytes) -> Iterator[Any]:
        """Messages of a datagram, which holds whole frames only."""
        _, found = self._cut(payload, whole=True)
        return iter(found)

    def stream(self, payload: bytes) -> Iterator[Any]:
        """Messages that more bytes of a stream complete."""
        self._rest, found = self._cut(self._rest + payload, whole=False)
        return iter(found)

    def _cut(self, buffer: bytes, *, whole: bool) -> tuple[bytes, list[Any]]:
        found: list[Any] = []
        i, n = 0, len(buffer)
        while i < n:
            overhead = OVERHEAD.get(buffer[i])
            if overhead is None:
                start = _next(buffer, i)
                self.counts["junk"] += start - i
                i = start
                continue
            length = LONGEST if n - i < 3 else overhead + buffer[i + 1]
            if n - i >= 3 and buffer[i] == V2 and buffer[i + 2] & SIGNED:
                length += SIGNATURE
            if n - i < length:
                if not whole:
                    return buffer[i:], found
                self.counts["junk"] += 1
                i += 1
                continue
            verdict = self._read(buffer[i : i + length], found)
            if verdict != "bad" and not (verdict == "others" and self._lost(buffer, i + length)):
                self.counts[verdict] += 1
                if self.tap is not None and buffer[i + (5 if buffer[i] == V2 else 3)] == self._sysid:
                    self.tap(buffer[i : i + length])
                i += length
            else:
                self.counts["bad"] += 1
                i += 1
        return b"", found

    @staticmethod
    def _lost(buffer: bytes, end: int) -> bool:
        """Whether a frame that was not checked ends where no other begins: then its length was none."""
        return end < len(buffer) and buffer[end] not in OVERHEAD

    def _read(self, frame: bytes, found: list[Any]) -> str:
        """What a frame is; a message of our vehicle is added to those found."""
        if frame[0] == V2:
            if frame[2] & ~SIGNED:
                return "bad"
            sysid, component = frame[5], frame[6]
            number = frame[7] | frame[8] << 8 | frame[9] << 16
        else:
            sysid, component, number = frame[3], frame[4], frame[5]
        if (self._sysid is not None and sysid != self._sysid) or (
            self._component is not None and component != self._component
        ):
            return "others"
        if number not in self._known:
            return "others"  # its checksum needs a seed that we do not know
        if self._wanted is not None and number not in self._wanted:
            return "others"
        try:
            message = self.codec.decode(bytearray(frame))
        except (self._error, ValueError, struct.error):
            return "bad"
        found.append(message)
        return "taken"
