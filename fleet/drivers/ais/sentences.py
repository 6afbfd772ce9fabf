"""AIVDM sentences to whole messages: checksums, fragments, TAG blocks passed over. Pure; nothing of pyais here."""

from __future__ import annotations

import re
from typing import NamedTuple

from msgspec import Struct

from fleet.drivers.nmea.codec import Unusable, unframed

TOGETHER_NS = 4_000_000_000  # fragments of one message come within this
MOST_PARTS = 64  # messages that are not whole yet
MOST_FRAGMENTS = 5
_PAYLOAD = re.compile(r"[0-W`-w]{1,82}")
_ADDRESS = re.compile(r"[A-Z]{2}VD[MO]")


class Message(NamedTuple):
    """A whole message, in six-bit ASCII."""

    payload: bytes
    fill: int  # bits at its end that do not count


class Parts(Struct):
    """Fragments of one message, by number from 1."""

    begun_ns: int
    got: dict[int, tuple[str, int]]


class Assembler:
    """Puts fragments together."""

    def __init__(self) -> None:
        self._waiting: dict[tuple[str, ...], Parts] = {}
        self.abandoned = 0  # messages of which fragments never came

    def take(self, line: bytes, stamp_ns: int) -> Message | None:
        """A sentence; the message that it completes, if it does; Unusable with the reason."""
        address, *fields = unframed(_without_tag(line), b"!")
        if not _ADDRESS.fullmatch(address):
            raise Unusable("not used")
        if address.endswith("VDO"):
            raise Unusable("own vessel")
        if len(fields) != 6:
            raise Unusable("not six fields")
        count, number, sequence, channel, payload, fill = fields
        if not _PAYLOAD.fullmatch(payload) or fill not in ("0", "1", "2", "3", "4", "5"):
            raise Unusable("not six-bit ASCII")
        if count == number == "1":
            return Message(payload.encode("ascii"), int(fill))
        self._forget(stamp_ns)
        if not (count.isdigit() and number.isdigit() and 1 <= int(number) <= int(count) <= MOST_FRAGMENTS):
            raise Unusable("fragment number")
        key = (address, count, sequence, channel)
        parts = self._waiting.setdefault(key, Parts(stamp_ns, {}))
        if int(number) in parts.got:  # another message under the same number
            self.abandoned += 1
            parts = self._waiting[key] = Parts(stamp_ns, {})
        parts.got[int(number)] = (payload, int(fill))
        if len(parts.got) < int(count):
            return None
        del self._waiting[key]
        pieces = [parts.got[i + 1] for i in range(int(count))]
        if any(piece[1] for piece in pieces[:-1]):
            raise Unusable("fill bits inside")
        return Message("".join(piece[0] for piece in pieces).encode("ascii"), pieces[-1][1])

    def _forget(self, now_ns: int) -> None:
        """Drop what will not be completed."""
        old = [key for key, parts in self._waiting.items() if now_ns - parts.begun_ns > TOGETHER_NS]
        while len(self._waiting) - len(old) >= MOST_PARTS:
            old.append(min(self._waiting.keys() - old, key=lambda key: self._waiting[key].begun_ns))
        for key in old:
            del self._waiting[key]
            self.abandoned += 1


def _without_tag(line: bytes) -> bytes:
    r"""The sentence behind a TAG block `\s:station,c:time*hh\`."""
    return line[line.find(b"\\", 1) + 1 :] if line.startswith(b"\\") else line
