"""Numbers of boats: unique, 1 to 250, and the same the next time."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Mapping
from pathlib import Path

import msgspec

from fleet.errors import UsageError

LEAST, MOST = 1, 250


def parse(texts: list[str]) -> dict[str, int]:
    """`b1=3`, several: boat to number; UsageError."""
    found: dict[str, int] = {}
    for text in (part for one in texts for part in one.split(",") if part):
        boat, _, number = text.partition("=")
        if not boat or not number.isdigit() or not LEAST <= int(number) <= MOST:
            raise UsageError(f"--sysid {text!r}: expected BOAT=N with N from {LEAST} to {MOST}, such as b1=1")
        if boat in found:
            raise UsageError(f"--sysid {text!r}: {boat} is named twice")
        other = next((name for name, known in found.items() if known == int(number)), "")
        if other:
            raise UsageError(f"--sysid {text!r}: {other} has {number} already")
        found[boat] = int(number)
    return found


class Sysids:
    """Configured ones first, then those remembered, then those of autopilots, then the lowest free one."""

    def __init__(self, configured: Mapping[str, int], file: Path | None = None) -> None:
        """Args: file: where numbers are remembered; None: nowhere."""
        self._configured, self._file = dict(configured), file
        self._kept: dict[str, int] = {}
        if file is not None:
            with contextlib.suppress(OSError, msgspec.DecodeError, msgspec.ValidationError):
                kept = msgspec.json.decode(file.read_bytes(), type=dict[str, int])
                self._kept = {boat: number for boat, number in kept.items() if LEAST <= number <= MOST}
        taken = set(self._configured.values())
        self._kept = {b: k for b, k in self._kept.items() if k not in taken and b not in self._configured}
        self._given: dict[str, int] = {}

    def knows(self, boat: str) -> bool:
        """Whether its number was given before."""
        return boat in self._configured or boat in self._kept

    def of(self, boat: str, autopilot: int = 0) -> tuple[int, str]:
        """(number, why not) of a boat; autopilot: the number that its own autopilot has, 0 for none."""
        holders = {number: name for name, number in self._given.items()}
        configured = self._configured.get(boat)
        if autopilot:
            if configured not in (None, autopilot):
                return 0, f"its autopilot has sysid {autopilot}, --sysid says {configured}"
            reserved = next((b for b, k in self._configured.items() if k == autopilot and b != boat), "")
            other = holders.get(autopilot, reserved)
            if other or not LEAST <= autopilot <= MOST:
                why = f"which {other} has" if other else f"expected {LEAST} to {MOST}"
                return 0, f"its autopilot has sysid {autopilot}, {why}: give it another, or {other or boat} by --sysid"
            return self._give(boat, autopilot), ""
        number = configured or self._kept.get(boat, 0)
        if number in holders or (number and number in self._others_configured(boat)):
            if configured:
                return 0, f"sysid {number} is that of {holders[number]}"
            number = 0
        if not number:
            reserved_numbers = {*holders, *self._configured.values(), *self._kept.values()}
            free = (k for k in range(LEAST, MOST + 1) if k not in reserved_numbers)
            number = next(free, 0) or next((k for k in range(LEAST, MOST + 1) if k not in holders), 0)
        if not number:
            return 0, f"all numbers from {LEAST} to {MOST} are given"
        return self._give(boat, number), ""

    def _others_configured(self, boat: str) -> set[int]:
        return {number for name, number in self._configured.items() if name != boat}

    def _give(self, boat: str, number: int) -> int:
        self._given[boat] = number
        if self._kept.get(boat) != number and boat not in self._configured:
            self._kept = {b: k for b, k in self._kept.items() if k != number}
            self._kept[boat] = number
            self._remember()
        return number

    def _remember(self) -> None:
        if self._file is None:
            return
        with contextlib.suppress(OSError):  # numbers are then the same only as long as this process
            self._file.parent.mkdir(parents=True, exist_ok=True)
            beside = self._file.with_name(self._file.name + ".new")
            beside.write_bytes(msgspec.json.encode(self._kept, order="sorted"))
            os.replace(beside, self._file)
