"""A sweep's folder: what is sailed, every finished part in a file of its own, figures and page.

runs/20261122T155035Z-sweep-crossing/
    sweep.json                   what is sailed, complete: the family's text too
    parts/0000-000512.npz        results of a part; there whole, or not at all
    summary.json, report.html    once the sweep has ended
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from fleet import __version__
from fleet.errors import RecordingError, UsageError
from fleet.recording.disk import DiskStream, in_words, sync_folder
from fleet.recording.runs import list_folders, new_run
from fleet.sim.sweep.family import Family, loads
from fleet.sim.sweep.parts import AnyResults, Part, joined, laws_digest, parts_of, unpack


class Sweep(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is sailed: `sweep.json`."""

    family: str
    text: str
    """The family file, with everything that the command line changed."""
    method: str
    boats: tuple[int, ...]
    """Of a case, at each point."""
    cases: int
    """Of each point."""
    seed: int
    points: tuple[str, ...]
    """Labels of the grid's points; one, empty, without a grid."""
    parts: tuple[Part, ...]
    command: str
    version: str
    laws: str
    """Digest of the code that decides."""

    @classmethod
    def of(cls, family: Family, command: str) -> Sweep:
        """All cases of all points of a family."""
        boats = tuple(spec.boats for spec in family.specs)
        return cls(
            family=family.name,
            text=family.text,
            method=family.method,
            boats=boats,
            cases=family.cases,
            seed=family.seed,
            points=tuple(point.label for point in family.points),
            parts=parts_of(boats, family.cases, family.foreign),
            command=command,
            version=__version__,
            laws=laws_digest(),
        )

    @property
    def total(self) -> int:
        """Cases of all points."""
        return self.cases * len(self.points)

    @property
    def most_boats(self) -> int:
        """Of a case; the most at any point of the grid."""
        return max(self.boats)


class Store:
    """The folder of a sweep."""

    def __init__(self, folder: Path, sweep: Sweep) -> None:
        self.folder, self.sweep = folder, sweep
        self.family = loads(sweep.text)

    @property
    def summary_file(self) -> Path:
        """Figures."""
        return self.folder / "summary.json"

    @property
    def report_file(self) -> Path:
        """The page for people."""
        return self.folder / "report.html"

    def part_file(self, part: Part) -> Path:
        """Results of a part."""
        return self.folder / "parts" / f"{part.name}.npz"

    def keep(self, part: Part, content: bytes) -> None:
        """Keep the results of a part, once: it is there whole, even after a power cut, or not at all.

        Raises:
            RecordingError: it cannot be written; nothing is left of it
        """
        _write(self.part_file(part), content)

    def missing(self) -> tuple[list[Part], list[str]]:
        """Parts still to be sailed, and what was found damaged among those that are there."""
        left, damaged = [], []
        for part in self.sweep.parts:
            if not self.part_file(part).exists():
                left.append(part)
                continue
            try:
                self.read(part)
            except RecordingError as error:
                left.append(part)
                damaged.append(str(error))
        return left, damaged

    def read(self, part: Part) -> AnyResults:
        """Results of a part that is there.

        Raises:
            RecordingError: it cannot be read, or is not that part
        """
        path = self.part_file(part)
        try:
            results = unpack(path.read_bytes(), str(path))
        except OSError as error:
            raise RecordingError(f"cannot read {path}: {error.strerror or error}") from error
        if results.case.tolist() != list(range(part.first, part.first + part.count)):
            raise RecordingError(f"{path}: not {part}, but cases {results.case[:1]} ... {results.case[-1:]}")
        return results

    def results(self, parts: Iterable[Part] | None = None) -> list[Any]:
        """Of each point, in the order of its cases, whoever sailed them when; None: nothing is there of it."""
        found: list[list[AnyResults]] = [[] for _ in self.sweep.points]
        chosen = set(self.sweep.parts if parts is None else parts)
        for part in self.sweep.parts:
            if part in chosen and self.part_file(part).exists():
                found[part.point].append(self.read(part))
        return [joined(point) if point else None for point in found]

    @contextmanager
    def alone(self) -> Iterator[None]:
        """While this process sails the sweep, no other does.

        Raises:
            UsageError: another one does so now
        """
        with (self.folder / "sweep.json").open("rb") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise UsageError(f"{self.folder}: another process sails this sweep now; expected it to end") from None
            yield


def create(root: Path | str | None, sweep: Sweep) -> Store:
    """A new folder for a sweep.

    Raises:
        RecordingError: it cannot be made
    """
    folder = new_run(root, f"sweep-{sweep.family}").folder
    with suppress(OSError):
        (folder / "boats").rmdir()
    try:
        (folder / "parts").mkdir()
    except OSError as error:
        raise RecordingError(in_words(error)) from error
    _write(folder / "sweep.json", msgspec.json.format(msgspec.json.encode(sweep), indent=1) + b"\n")
    return Store(folder, sweep)


def find(which: str, root: Path | str | None = None) -> Store:
    """A sweep by its folder, the folder's name, the name's beginning, its family (the latest), or `last`.

    Raises:
        UsageError: there is none, or several; the message names what there is
    """
    if is_sweep(which):
        return _opened(Path(which))
    there = sweeps(root)
    if which == "last" and there:
        return _opened(there[-1])
    named = [one for one in there if one.name == which] or [one for one in there if one.name.startswith(which)]
    if len(named) == 1:
        return _opened(named[0])
    of_family = [one for one in there if one.name.partition("-sweep-")[2] == which]
    if of_family and not named:
        return _opened(of_family[-1])
    names = ", ".join(one.name for one in (named or there)[-5:]) or "none"
    what = "several sweeps begin so" if named else "no sweep"
    raise UsageError(f"{which}: {what}; expected a folder with a sweep.json, or a name of one; there are: {names}")


def sweeps(root: Path | str | None = None) -> list[Path]:
    """Folders of sweeps below `root`, oldest first."""
    return [run.folder for run in list_folders(root) if is_sweep(run.folder)]


def is_sweep(where: Path | str) -> bool:
    """Whether this is the folder of a sweep."""
    return (Path(where) / "sweep.json").is_file()


def _opened(folder: Path) -> Store:
    path = folder / "sweep.json"
    try:
        return Store(folder, msgspec.json.decode(path.read_bytes(), type=Sweep))
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error.strerror or error}") from error
    except msgspec.MsgspecError as error:
        raise RecordingError(f"{path}: not a sweep that this version reads: {error}") from error


def write_text(path: Path, text: str) -> None:
    """Write a file of the folder whole, or leave what was there."""
    _write(path, text.encode())


def _write(path: Path, content: bytes) -> None:
    """Under another name first, then to its own."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        stream = DiskStream(draft, os.O_CREAT | os.O_TRUNC)
        try:
            stream.write(content)
            os.fsync(stream.fileno())
        finally:
            stream.close()
        draft.replace(path)
        sync_folder(path.parent)
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        error.filename = error.filename or str(path)
        raise RecordingError(in_words(error)) from error
