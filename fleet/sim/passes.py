"""Credentials for a simulated fleet: those of an authority in a folder, or of one founded for the run."""

from __future__ import annotations

import time
from collections.abc import Iterable
from pathlib import Path
from typing import Literal

from fleet.errors import ConfigError
from fleet.wire.credentials import authority, files
from fleet.wire.credentials.roster import Role

HUB = "hub"
DAYS = 60.0  # of a run's own
Transport = Literal["tls", "quic"]
WHERE = {"tls": "tls/127.0.0.1:{}", "quic": "quic/127.0.0.1:{}?mixed_rel=1"}


def passes(wanted: str, run: Path, fleet: str, boats: Iterable[str], operator: str) -> Path:
    """The folder that holds one folder for each station.

    Args:
        wanted: `new`, for an authority that lasts as long as the run's folder, or the folder of an authority
        run: folder of the run
        fleet: its name
        boats: who sails
        operator: who launches

    Raises:
        ConfigError: a station has no folder there
    """
    stations: list[tuple[Role, str]] = [*(("boat", one) for one in boats), ("operator", operator), ("hub", HUB)]
    if wanted != "new":
        place = Path(wanted)
        for role, name in stations:
            if not (place / name / files.OWN_CERTIFICATE).exists():
                raise ConfigError(
                    f"--credentials {wanted}: no folder {name!r}; expected an authority of fleet {fleet!r} with one "
                    f"for every station: fleet credentials {role} {name} --authority {wanted}"
                )
        return place
    place = run / "credentials"
    founded = authority.create(place, fleet, time.time())
    for role, name in stations:
        founded.issue(role, name, time.time(), days=DAYS)
    return place
