"""A fleet with credentials, by a clock that tests set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from fleet.wire.credentials import authority
from fleet.wire.credentials.authority import Authority
from fleet.wire.credentials.trust import Trust, load

FLEET = "f"


class Issued:
    """An authority, and the credentials that it gave."""

    def __init__(
        self,
        folder: Path,
        now: Callable[[], float],
        boats: Sequence[str] = ("b1", "b2", "b3"),
        operators: Sequence[str] = ("anna",),
    ) -> None:
        self.folder, self.now = folder, now
        self.authority: Authority = authority.create(folder, FLEET, now())
        for boat in boats:
            self.authority.issue("boat", boat, now())
        for operator in operators:
            self.authority.issue("operator", operator, now())

    def boat(self, name: str) -> Trust:
        """A boat's."""
        return load(self.folder / name, FLEET, "boat", name, now=self.now)

    def operator(self, name: str = "anna") -> Trust:
        """An operator's."""
        return load(self.folder / name, FLEET, "operator", name, now=self.now)
