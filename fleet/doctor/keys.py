"""The credentials folder of a boat: there, readable by its owner only, still good?"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

from fleet.doctor.finding import Finding, fail, ok


def credentials(folder: str, boat: str) -> Iterator[Finding]:
    """What is to be said about it; nothing where there is none, which `reach` speaks of."""
    if not folder:
        return
    place, make = Path(folder), f"fleet credentials boat {boat}, and copy the folder here"
    try:
        files = sorted(one for one in place.iterdir() if one.is_file())
    except OSError as error:
        yield fail("credentials", f"{place}: {error.strerror}", make)
        return
    if not files:
        yield fail("credentials", f"{place}: empty", make)
        return
    unread = [one.name for one in files if not os.access(one, os.R_OK)]
    if unread:
        yield fail("credentials", f"{place}: {', '.join(unread)}: no permission", "chown them to who runs the agent")
        return
    yield ok("credentials", f"{place}: {len(files)} files")
    open_ones = [one.name for one in files if "key" in one.name and stat.S_IMODE(one.stat().st_mode) & 0o077]
    if open_ones:
        yield fail("credentials", f"{', '.join(open_ones)}: others may read it", f"chmod 600 {place}/*key*")
