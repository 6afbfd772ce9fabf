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


NEW = "new"  # an authority that lasts as long as the run's folder


def _stations(boats: Iterable[str], operator: str) -> list[tuple[Role, str]]:
    return [*(("boat", one) for one in boats), ("operator", operator), ("hub", HUB)]


def check(folder: Path, fleet: str, boats: Iterable[str], operator: str) -> None:
    """ConfigError unless the folder, an authority's, has one for each station."""
    for role, name in _stations(boats, operator):
        if not (folder / name / files.OWN_CERTIFICATE).exists():
            raise ConfigError(
                f"--credentials {folder}: no folder {name!r}; expected an authority of fleet {fleet!r} with one for "
                f"every station: fleet credentials {role} {name} --authority {folder}"
            )


def found(folder: Path, fleet: str, boats: Iterable[str], operator: str) -> Path:
    """A new authority in a folder, with one for each station."""
    founded = authority.create(folder, fleet, time.time())
    for role, name in _stations(boats, operator):
        founded.issue(role, name, time.time(), days=DAYS)
    return folder
