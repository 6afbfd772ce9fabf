"""What came of a command: old and new value, and one line a boat."""

from __future__ import annotations

from typing import Any

from msgspec import Struct

from fleet.wire.messages import Ack

ACKNOWLEDGED, REFUSED, SILENT = "acknowledged", "refused", "not answered"


class Outcome(Struct, frozen=True):
    """The boats' answers to one command."""

    command: str
    id: str
    acks: dict[str, Ack | None]
    """By boat; None: it did not answer in time."""
    old: str = ""
    new: str = ""
    note: str = ""

    @property
    def acknowledged(self) -> tuple[str, ...]:
        """Boats that do it."""
        return tuple(boat for boat, ack in self.acks.items() if ack is not None and ack.ok)

    @property
    def refused(self) -> dict[str, str]:
        """Boats that refused, and why."""
        return {boat: ack.reason for boat, ack in self.acks.items() if ack is not None and not ack.ok}

    @property
    def silent(self) -> tuple[str, ...]:
        """Boats that did not answer."""
        return tuple(boat for boat, ack in self.acks.items() if ack is None)

    @property
    def ok(self) -> bool:
        """Every boat acknowledged."""
        return bool(self.acks) and all(ack is not None and ack.ok for ack in self.acks.values())

    @property
    def exit_code(self) -> int:
        """0 done; 3 some boats did not acknowledge; 4 no boat reachable; 5 refused by a safety check."""
        if all(ack is None for ack in self.acks.values()):
            return 4
        if any(ack is not None and not ack.ok and ack.safety for ack in self.acks.values()):
            return 5
        return 0 if self.ok else 3

    def lines(self) -> list[str]:
        """For a person: what was asked, then each boat."""
        change = f": {self.old or '-'} -> {self.new or '-'}" if self.old or self.new else ""
        lines = [f"{self.command}{change}"]
        width = max((len(boat) for boat in self.acks), default=0)
        for boat, ack in sorted(self.acks.items()):
            if ack is None:
                text = SILENT
            elif ack.ok:
                text = ACKNOWLEDGED + (f" ({ack.reason})" if ack.reason else "")
            else:
                text = f"{REFUSED}: {ack.reason}"
            lines.append(f"  {boat:<{width}}  {text}")
        if self.note:
            lines.append(f"  {self.note}")
        return lines

    def as_json(self) -> dict[str, Any]:
        """The same as one object."""
        return {
            "command": self.command,
            "id": self.id,
            "ok": self.ok,
            "old": self.old,
            "new": self.new,
            "note": self.note,
            "boats": {
                boat: {"answer": SILENT, "reason": ""}
                if ack is None
                else {"answer": ACKNOWLEDGED if ack.ok else REFUSED, "reason": ack.reason, "version": ack.version}
                for boat, ack in sorted(self.acks.items())
            },
        }
