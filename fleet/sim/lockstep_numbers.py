"""The numbers inside of the laws: what each of their functions returned over the reference runs, as one hash each.

A decision is often a choice, and a choice hides the last bits of the prices it was made by. So beside the decisions the
values are kept from which they were made: one expression re-associated shows here, though every boat sails on alike.
"""

from __future__ import annotations

import hashlib
import struct
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

from msgspec import Struct
from msgspec.structs import astuple

from fleet.agent.step import step
from fleet.analysis.replay import replay

LAWS = ("fleet.paths.curve", "fleet.guidance", "fleet.coordination", "fleet.avoidance", "fleet.agent.step")


def numbers(recordings: Iterable[Path]) -> dict[str, str]:
    """Hash of all floats that each function of a law returned within `step` while recordings are replayed, by name."""
    hashes: dict[str, Any] = {}
    steps = 0  # how deep in `step` we are

    def look(frame: FrameType, event: str, result: Any) -> None:
        nonlocal steps
        code = frame.f_code
        if code is step.__code__:
            steps += {"call": 1, "return": -1}.get(event, 0)
        module = frame.f_globals.get("__name__", "")
        if event != "return" or not (steps or code is step.__code__) or not module.startswith(LAWS):
            return
        if code.co_name.startswith("<"):  # a loop within a function: newer interpreters do not call it
            return
        name = f"{module}.{code.co_qualname}"
        if name not in hashes:
            hashes[name] = hashlib.blake2b(digest_size=8)
        values = list(_floats(result))
        hashes[name].update(struct.pack(f"<{len(values)}d", *values))

    before = sys.getprofile()
    files = tuple(recordings)
    for recording in files:  # once to fill caches: what is in one is not computed again
        replay(recording)
    for recording in files:
        sys.setprofile(look)
        try:
            replay(recording)
        finally:
            sys.setprofile(before)
    return {name: one.hexdigest() for name, one in sorted(hashes.items())}


def _floats(value: Any) -> Iterator[float]:
    """All floats of a Struct or tuple, in order."""
    if type(value) is float:
        yield value
    elif isinstance(value, Struct):
        for field in astuple(value):
            yield from _floats(field)
    elif isinstance(value, tuple | list):
        for part in value:
            yield from _floats(part)
