"""What came of a replay: every number that came out otherwise, and what else there is to say."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import msgspec
from msgspec import Struct

from fleet import __version__


class Difference(Struct, frozen=True):
    """One number that came out otherwise."""

    boat: str
    tick: int
    stamp_ns: int
    field: str
    """Of the decision; `next.` and a field of the state for the tick after; both with `lane.` before it in a batch."""
    recorded: float | str | None  # of a lane: decided alone
    replayed: float | str | None

    @property
    def size(self) -> float:
        """How far apart, infinite where that is not a number."""
        if isinstance(self.recorded, int | float) and isinstance(self.replayed, int | float):
            apart = abs(self.recorded - self.replayed)
            return apart if apart == apart else math.inf  # noqa: PLR0124 - NaN
        return math.inf


class ShellChange(Struct, frozen=True):
    """The shell replaced the state between two ticks: no decision of `step`."""

    boat: str
    tick: int
    stamp_ns: int
    why: str
    fields: tuple[str, ...]
    """Of the state, that changed."""


class BoatReplay(Struct):
    """What came of one boat's recording."""

    boat: str
    version: str = ""
    ticks: int = 0
    """Ticks that were recorded."""
    replayed: int = 0
    differing: int = 0
    """Ticks that came out otherwise."""
    differences: list[Difference] = []
    changes: list[ShellChange] = []
    realigned: int = 0
    """Times that the memory was aligned with other peers; replayed and compared like everything else."""
    starts: int = 0
    """Processes that began in this recording."""
    missing: int = 0
    """Ticks that are not in the recording, though earlier and later ones are."""
    filled: int = 0
    """Ticks whose state lacked fields that this version has."""
    notes: dict[str, int] = {}
    """What else there is to say, with the first tick that it is about."""
    skipped: dict[str, int] = {}
    """Ticks that could not be replayed, by reason."""
    lanes: int = 0
    """Ticks that were decided as a lane of a batch, too."""
    lanes_differing: int = 0
    """Of them, how many came out otherwise than alone."""


class Replay(Struct):
    """What came of a recording."""

    source: str
    boats: list[BoatReplay]
    notes: list[str]

    @property
    def ticks(self) -> int:
        """Ticks replayed, all boats together."""
        return sum(boat.replayed for boat in self.boats)

    @property
    def differences(self) -> list[Difference]:
        """All that were kept, by boat and tick."""
        return [one for boat in self.boats for one in boat.differences]

    @property
    def changes(self) -> list[ShellChange]:
        """What the shell changed."""
        return [one for boat in self.boats for one in boat.changes]

    @property
    def same(self) -> bool:
        """Whether something was replayed, and all of it came out alike."""
        return self.ticks > 0 and not any(boat.differing or boat.lanes_differing for boat in self.boats)

    @property
    def exit_code(self) -> int:
        """0 all alike; 1 otherwise."""
        return 0 if self.same else 1

    def lines(self) -> list[str]:
        """For a person."""
        found = [f"{self.source}: {note}" for note in self.notes]
        for boat in self.boats:
            verdict = (
                f"{boat.differing} differ" if boat.differing else "all alike" if boat.replayed else "nothing to say"
            )
            found.append(
                f"{boat.boat}: {boat.replayed} of {boat.ticks} ticks replayed, {verdict}; "
                f"{boat.starts} starts, {len(boat.changes)} changes by the shell, {boat.missing} ticks missing"
            )
            if boat.lanes:
                alike = f"{boat.lanes_differing} differ" if boat.lanes_differing else "all alike"
                found.append(f"{boat.boat}: {boat.lanes} ticks decided as lanes of a batch, {alike}")
            found += [f"{boat.boat}: from tick {tick}: {note}" for note, tick in boat.notes.items()]
            found += [f"{boat.boat}: {count} ticks not replayed: {why}" for why, count in boat.skipped.items()]
            found += [f"  {line}" for line in summary_of(boat.differences)]
        return found

    def as_json(self) -> dict[str, Any]:
        """The same as one object."""
        return {"same": self.same, "ticks": self.ticks, "version": __version__, **msgspec.to_builtins(self)}


def summary_of(differences: Iterable[Difference]) -> list[str]:
    """One line a field: first tick with both values, how often, the largest size."""
    by_field: dict[tuple[str, str], list[Difference]] = {}
    for one in differences:
        by_field.setdefault((one.boat, one.field), []).append(one)
    return [
        f"{boat} {field}: first at tick {many[0].tick}, recorded {many[0].recorded!r}, replayed {many[0].replayed!r}; "
        f"{len(many)} times, at most {max(one.size for one in many):.3g} apart"
        for (boat, field), many in by_field.items()
    ]
