"""What a ground station wants of the fleet, on its way to the operator's library and back."""

from __future__ import annotations

from typing import Any, Literal

from msgspec import Struct

Kind = Literal["hold", "stop", "return", "resume", "ready", "take", "start", "set", "chart", "look"]
MERGED: frozenset[str] = frozenset(("hold", "stop", "return", "resume"))
"""Several boats at once are one command."""


class Wish(Struct, frozen=True):
    """One thing to be done."""

    number: int
    kind: Kind
    boat: str
    value: Any = None  # start, chart: Mission; set: (what, value); ready: ids of stops to be released


class Done(Struct, frozen=True):
    """What came of it."""

    number: int
    ok: bool
    text: str = ""  # why not, or a remark
    silent: bool = False  # the boat did not answer
    value: Any = None  # start: mission id; stop: id of the stop; look: (mission id, Mission)
