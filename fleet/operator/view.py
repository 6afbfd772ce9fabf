"""What an operator knows: boats, and the formation that they hold; and the time that an operator lives by."""

from __future__ import annotations

import getpass
import re
import time
from typing import Protocol

from msgspec import Struct

from fleet.mission.model import Mission
from fleet.mission.pattern import Shape
from fleet.wire.messages import (
    BoatState,
    BoatStatus,
    Revision,
)


def default_operator() -> str:
    """The login name, as far as it may stand in a key."""
    try:
        name = re.sub(r"[^a-z0-9-]", "-", getpass.getuser().lower())[:32]
    except (KeyError, OSError):
        name = ""
    return name or "operator-1"


class Time(Protocol):
    """The time that an operator lives by: the module `time`, or a simulation's."""

    def monotonic(self) -> float:
        """Seconds that only grow."""

    def time_ns(self) -> int:
        """UTC [ns]."""

    def sleep(self, seconds: float, /) -> None:
        """Wait."""


class BoatView(Struct):
    """What is known of one boat."""

    name: str
    state: BoatState | None = None
    status: BoatStatus | None = None
    heard_s: float = 0.0  # monotonic time of its last state
    alive: bool = False

    def age_s(self) -> float:
        """Time since its last state [s]; infinite when never heard."""
        return time.monotonic() - self.heard_s if self.heard_s else float("inf")


class Change(Struct, frozen=True):
    """The formation that the boats hold: what a change is based on."""

    mission_id: str
    roster: tuple[str, ...]
    mission: Mission
    revision: Revision
    shape: Shape

    @property
    def spacing_m(self) -> float:
        """From slot to slot [m]."""
        return self.shape.spacing_m

    @property
    def cruise_mps(self) -> float:
        """Speed of the formation [m/s]."""
        return self.shape.cruise_mps
