"""Where a boat keeps what must survive a restart, and its recordings."""

from __future__ import annotations

import errno
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

from fleet.doctor.finding import Finding, fail, ok, warn

LEAST_BYTES, FEW_BYTES = 100_000_000, 1_000_000_000
SLOW_S = 0.5  # a stop is on disk before it is acknowledged


def disk(folder: Path, what: str = "state") -> Iterator[Finding]:
    """Whether it can be written to, how fast, and how much room there is. Leaves nothing behind."""
    existing = folder
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    try:
        if existing != folder and not os.access(existing, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        took_s = _try(existing)
    except OSError as error:
        yield fail(what, f"{folder}: {error.strerror}", f"give {existing} to who runs the agent (chown)")
        return
    if took_s > SLOW_S:
        yield warn(what, f"{folder}: a small file takes {took_s:.1f} s to write", "another card or disk")
    else:
        yield ok(what, f"{folder} can be {'written to' if existing == folder else 'made'}")
    free = shutil.disk_usage(existing).free
    said = f"{free / 1e9:.1f} GB free"
    if free < LEAST_BYTES:
        yield fail(what, said, f"make room: recordings are below {folder}")
    elif free < FEW_BYTES:
        yield warn(what, said, f"make room: recordings are below {folder}")
    else:
        yield ok(what, said)


def _try(folder: Path) -> float:
    """Write a file as the agent does; seconds."""
    began = time.monotonic()
    file = folder / f".doctor-{os.getpid()}"
    try:
        with file.open("wb") as stream:
            stream.write(b"x" * 4096)
            stream.flush()
            os.fsync(stream.fileno())
    finally:
        file.unlink(missing_ok=True)
    return time.monotonic() - began
