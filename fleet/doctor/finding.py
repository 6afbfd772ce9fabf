"""What a look at a boat finds."""

from __future__ import annotations

from typing import Literal

from msgspec import Struct

Verdict = Literal["ok", "warn", "fail"]


class Finding(Struct, frozen=True):
    """One thing looked at."""

    subject: str  # clock, disk, serial, ...
    verdict: Verdict  # fail: do not sail like this
    found: str
    do: str = ""  # what to do about it; empty where it is ok


def ok(subject: str, found: str) -> Finding:
    """As it should be."""
    return Finding(subject, "ok", found)


def warn(subject: str, found: str, do: str) -> Finding:
    """It sails, but."""
    return Finding(subject, "warn", found, do)


def fail(subject: str, found: str, do: str) -> Finding:
    """Not fit to sail."""
    return Finding(subject, "fail", found, do)
