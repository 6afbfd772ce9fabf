"""Run folders: where a run keeps its mission, recordings, figures and report.

runs/20261122T155035Z-overtaking/
    mission.toml      as it was sailed
    run.mcap          the whole run, by the process that supervised it
    boats/<name>.mcap what each boat recorded itself
    summary.json      figures and checks
    report.html       and pictures
"""

from __future__ import annotations

import os
import re
from datetime import UTC, datetime
from pathlib import Path

from msgspec import Struct

from fleet.errors import RecordingError
from fleet.recording.disk import in_words, parts

_NAME = re.compile(r"^(\d{8}T\d{6}Z)-([a-z0-9-]+)$")
ROOT_VARIABLE = "FLEET_RUNS"
OTHERS = ("sweep.json", "case.json")  # in folders that are not runs of a mission


class Run(Struct, frozen=True):
    """A run folder."""

    folder: Path

    @property
    def name(self) -> str:
        """Name of the folder."""
        return self.folder.name

    @property
    def mission_file(self) -> Path:
        """The mission as it was sailed."""
        return self.folder / "mission.toml"

    @property
    def recording(self) -> Path:
        """The whole run."""
        return self.folder / "run.mcap"

    @property
    def summary_file(self) -> Path:
        """Figures and checks."""
        return self.folder / "summary.json"

    @property
    def report_file(self) -> Path:
        """The page for people."""
        return self.folder / "report.html"

    def boat_recording(self, boat: str) -> Path:
        """What one boat recorded itself."""
        return self.folder / "boats" / f"{boat}.mcap"

    def boats(self) -> list[str]:
        """Boats that recorded themselves."""
        return sorted({path.name.split(".")[0] for path in (self.folder / "boats").glob("*.mcap")})


def default_root() -> Path:
    """Where runs are kept: `$FLEET_RUNS`, else `./runs`."""
    return Path(os.environ.get(ROOT_VARIABLE) or "runs")


def new_run(root: Path | str | None, mission_name: str, now: datetime | None = None) -> Run:
    """Make the folder of a new run; its name is unique even when two start in one second.

    Raises:
        RecordingError: the folder cannot be made
    """
    base = Path(root) if root is not None else default_root()
    stamp = (now or datetime.now(UTC)).astimezone(UTC).strftime("%Y%m%dT%H%M%SZ")
    word = re.sub(r"[^a-z0-9]+", "-", Path(mission_name).stem.lower()).strip("-")[:48].rstrip("-") or "mission"
    for again in range(1, 1000):
        folder = base / (f"{stamp}-{word}" if again == 1 else f"{stamp}-{word}-{again}")
        try:
            folder.mkdir(parents=True)
            (folder / "boats").mkdir()
        except FileExistsError:
            continue
        except OSError as error:
            raise RecordingError(f"cannot make the run folder {folder}: {in_words(error)}") from error
        return Run(folder)
    raise RecordingError(f"{base}: 999 runs of {word} in one second; name another folder with ${ROOT_VARIABLE}")


def list_runs(root: Path | str | None = None) -> list[Run]:
    """Runs of missions below `root`, oldest first."""
    return [run for run in list_folders(root) if not any((run.folder / one).exists() for one in OTHERS)]


def list_folders(root: Path | str | None = None) -> list[Run]:
    """All that `new_run` made below `root`, sweeps too, oldest first."""
    base = Path(root) if root is not None else default_root()
    if not base.is_dir():
        return []
    folders = [one for one in base.iterdir() if _NAME.match(one.name) and one.is_dir()]
    return [Run(one) for one in sorted(folders, key=lambda one: (one.name[:16], len(one.name), one.name))]


def find(root: Path | str | None, which: Path | str = "last") -> Run:
    """A run by path, by name, by the beginning of its name, by its mission (the latest), or `last`.

    Raises:
        RecordingError: there is none, or several; the message names what there is
    """
    base = Path(root) if root is not None else default_root()
    path = Path(which)
    if path.is_dir() and (_NAME.match(path.name) or any((path / one).exists() for one in ("run.mcap", "mission.toml"))):
        return Run(path)
    if path.is_file() and path.suffix == ".mcap":
        return Run(path.parent.parent if path.parent.name == "boats" else path.parent)
    runs = list_runs(base)
    if not runs:
        raise RecordingError(f"no run in {base}: expected folders such as 20261122T155035Z-overtaking")
    if str(which) == "last":
        return runs[-1]
    by_name = [run for run in runs if run.name == str(which)] or [r for r in runs if r.name.startswith(str(which))]
    if len(by_name) == 1:
        return by_name[0]
    by_mission = [run for run in runs if re.sub(r"-\d+$", "", run.name[17:]) == str(which) or run.name[17:] == which]
    if by_mission and not by_name:
        return by_mission[-1]
    what = "several runs begin with" if by_name else "no run called"
    raise RecordingError(f"{what} {which} in {base}; there are {_some(by_name or runs)}")


def _some(runs: list[Run]) -> str:
    names = ", ".join(run.name for run in runs[-5:])
    return names if len(runs) <= 5 else f"{names} and {len(runs) - 5} older"


def recordings(run: Run) -> list[Path]:
    """Every recording of a run with all its parts."""
    whole = parts(run.recording)
    return whole + [one for boat in run.boats() for one in parts(run.boat_recording(boat))]
