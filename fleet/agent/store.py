"""What must survive a restart, on this boat's disk: stops at once, mission and formation when they change, progress.

Written by a thread of its own, since a slow card must not make a tick late; each file is replaced whole, so that a cut
of power leaves the old one or the new one.
"""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import msgspec
from msgspec import Struct

from fleet.wire.messages import Revision, Signed

T = TypeVar("T")
UNKNOWN_BOOT = "unknown"


class Progress(Struct, frozen=True, array_like=True):
    """Where the boat was; written once a second while it sails."""

    boot_id: str
    stamp_ns: int
    mission_id: str
    lat_deg: float
    lon_deg: float
    s_m: float
    goal: int
    ended: bool
    track: tuple[tuple[float, float], ...] = ()  # travelled, lat and lon, thinned


class Kept(Struct, frozen=True, array_like=True):
    """The mission and the formation as operators wrote them."""

    mission: Signed | None
    formation: Signed | None
    control: Revision
    known_missions: tuple[str, ...] = ()
    released: tuple[str, ...] = ()
    said: tuple[tuple[str, int], ...] = ()  # signer, stamp of the last word that was obeyed
    stop_words: tuple[tuple[str, Signed], ...] = ()


def boot_id() -> str:
    """The id of this boot of the machine."""
    try:
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        return UNKNOWN_BOOT


class Store:
    """Files in one folder."""

    def __init__(self, folder: Path, *, threaded: bool = True) -> None:
        self._folder = folder
        self._queue: queue.SimpleQueue[tuple[str, bytes, Callable[[], None] | None] | None] = queue.SimpleQueue()
        self.trouble = ""
        self._thread = threading.Thread(target=self._run, name="store", daemon=True) if threaded else None
        folder.mkdir(parents=True, exist_ok=True)
        if self._thread is not None:
            self._thread.start()

    # -- reading, at the start ---------------------------------------------------------------------------------------
    def stops(self) -> tuple[str, ...]:
        """Stops not released. A file that cannot be read counts as a stop: better neutral than wrong."""
        path = self._folder / "stops"
        try:
            return msgspec.msgpack.decode(path.read_bytes(), type=tuple[str, ...])
        except FileNotFoundError:
            return ()
        except (OSError, msgspec.DecodeError):
            return ("unreadable-stops-file",)

    def kept(self) -> Kept | None:
        """The mission last held."""
        return self._read("kept", Kept)

    def progress(self) -> Progress | None:
        """Where the boat was."""
        return self._read("progress", Progress)

    def _read(self, name: str, kind: type[T]) -> T | None:
        try:
            return msgspec.msgpack.decode((self._folder / name).read_bytes(), type=kind)
        except (OSError, msgspec.DecodeError):
            return None

    # -- writing ---------------------------------------------------------------------------------------------------
    def save_stops(self, stops: tuple[str, ...], then: Callable[[], None]) -> None:
        """Write the stops, then call `then`: an acknowledged stop is on disk."""
        self._put("stops", msgspec.msgpack.encode(stops), then)

    def save_kept(self, kept: Kept) -> None:
        """Write mission and formation."""
        self._put("kept", msgspec.msgpack.encode(kept), None)

    def save_progress(self, progress: Progress) -> None:
        """Write where the boat is."""
        self._put("progress", msgspec.msgpack.encode(progress), None)

    def _put(self, name: str, content: bytes, then: Callable[[], None] | None) -> None:
        if self._thread is not None:
            self._queue.put((name, content, then))
        else:
            self._write(name, content, then)

    def _run(self) -> None:
        while (job := self._queue.get()) is not None:
            self._write(*job)

    def _write(self, name: str, content: bytes, then: Callable[[], None] | None) -> None:
        new = self._folder / f"{name}.new"
        try:
            with new.open("wb") as file:
                file.write(content)
                file.flush()
                if name != "progress":
                    os.fsync(file.fileno())
            new.replace(self._folder / name)
            if name != "progress":
                folder = os.open(self._folder, os.O_RDONLY)
                os.fsync(folder)
                os.close(folder)
            self.trouble = ""
        except OSError as error:
            self.trouble = f"{self._folder / name}: {error.strerror}"
            return
        if then is not None:
            then()

    def close(self) -> None:
        """Write what is left and end."""
        if self._thread is not None:
            self._queue.put(None)
            self._thread.join(timeout=2.0)
