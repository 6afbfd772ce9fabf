"""The credentials folder of a boat: there, its own, readable by its owner only, still good?"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from fleet.doctor.finding import Finding, fail, ok, warn
from fleet.errors import ConfigError
from fleet.wire.credentials.roster import day
from fleet.wire.credentials.trust import load


def credentials(folder: str, fleet: str, boat: str) -> Iterator[Finding]:
    """What the agent will say of them when it starts; nothing where there are none, which `reach` speaks of."""
    if not folder:
        return
    make = f"fleet credentials boat {boat} on shore, and copy the folder here"
    try:
        trust = load(folder, fleet, "boat", boat)
    except ConfigError as error:
        yield fail("credentials", str(error), make)
        return
    said = f"{folder}: valid until {day(trust.ends_s)}, roster {trust.roster.number}"
    if trust.warning():
        yield warn(
            "credentials", f"{said}; {trust.warning()}", f"fleet credentials boat {boat} --renew, and copy it here"
        )
    else:
        yield ok("credentials", said)
    if not os.access(Path(folder), os.W_OK):
        yield warn(
            "credentials",
            f"{folder}: a newer roster could not be kept there",
            "chown -R it to who runs the agent, or a revoked station is believed again after a restart",
        )
