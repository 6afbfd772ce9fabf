"""Parts of a sweep: so many cases of one point, their results as bytes, and what sails them."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from msgspec import Struct

import fleet
from fleet.errors import RecordingError
from fleet.sim.batch import Results, run
from fleet.sim.sweep.ships import sail_part
from fleet.sim.sweep.ships_results import ShipResults

if TYPE_CHECKING:
    from fleet.sim.sweep.family import Family

MOST_LANES, LEAST_LANES, SHARES = 4096, 1024, 4
AT_A_TIME = 20  # boats of a part with foreign vessels: some seconds
LAWS = (
    *("ops.py", "ops_lanes.py", "geo.py", "paths", "guidance", "coordination", "avoidance", "hulls", "agent"),
    *("sensing", "sim/batch", "sim/sweep"),
)
"""What decides where a boat goes."""
TELLING = {
    "__init__",
    "alone",
    "checks",
    "cluster",
    "compare",
    "page",
    "parts",
    "pictures",
    "pool",
    "run",
    "ships_alone",
    "ships_pictures",
    "store",
    "table",
    "worker",
}
"""Modules of sweeps that do not: they carry, keep and tell."""


AnyResults: TypeAlias = Results | ShipResults
OF_SHIPS = "ships."
"""Begins the names of arrays of `ShipResults.values` in a file."""


class Part(Struct, frozen=True, order=True):
    """Cases `first` ... `first + count - 1` of a point."""

    point: int
    first: int
    count: int

    @property
    def name(self) -> str:
        """As its file is called, without ending."""
        return f"{self.point:04d}-{self.first:06d}"

    def __str__(self) -> str:
        return f"point {self.point}, cases {self.first} to {self.first + self.count - 1}"


def parts_of(boats: Sequence[int], cases: int, one_by_one: bool = False) -> tuple[Part, ...]:
    """The parts of a sweep, in order: whatever sails them, the same ones.

    A part is about 4096 lanes, where arrays stay in the cache, or a quarter of a smaller sweep.

    Args:
        boats: of a case, at each point
        cases: of each point
        one_by_one: cases are sailed one after the other; small parts then lose less when one is lost
    """
    most = AT_A_TIME if one_by_one else min(MOST_LANES, max(LEAST_LANES, sum(boats) * cases // SHARES))
    parts = []
    for point, of_case in enumerate(boats):
        number = -(-cases // max(1, most // of_case))
        size = -(-cases // number)
        parts += [Part(point, first, min(size, cases - first)) for first in range(0, cases, size)]
    return tuple(parts)


def sail(family: Family, seed: int, part: Part) -> AnyResults:
    """Sail the cases of a part."""
    point = family.points[part.point]
    if family.foreign:
        return sail_part(family.name, family.spec(point), seed, range(part.first, part.first + part.count))
    cases = np.arange(part.first, part.first + part.count)
    return run(family.scenarios(seed, point, cases), **family.run_options(point))


def pack(results: AnyResults) -> bytes:
    """Results without traces as the bytes of an npz file."""
    fields = {name: getattr(results, name) for name in results.__struct_fields__ if name != "traces"}
    if isinstance(results, ShipResults):
        fields |= {OF_SHIPS + name: values for name, values in fields.pop("values").items()}
    arrays: dict[str, Any] = {name: value for name, value in fields.items() if isinstance(value, np.ndarray)}
    values = {name: value for name, value in fields.items() if name not in arrays}
    to = io.BytesIO()
    np.savez(to, values=np.frombuffer(json.dumps(values).encode(), dtype=np.uint8), **arrays)
    return to.getvalue()


def unpack(content: bytes, where: str = "part") -> AnyResults:
    """What `pack` was given.

    Raises:
        RecordingError: these are not the bytes of a part
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            values = json.loads(file["values"].tobytes())
            arrays = {name: file[name] for name in file.files if name != "values"}
            of_ships = {name.removeprefix(OF_SHIPS): arrays.pop(name) for name in list(arrays) if OF_SHIPS in name}
            if of_ships:
                return ShipResults(values=of_ships, **values, **arrays)
            return Results(traces=[], **values, **arrays)
    except (ValueError, KeyError, TypeError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise RecordingError(f"{where}: not a part of a sweep, or damaged: {error}") from error


def joined(parts: Sequence[Any]) -> AnyResults:
    """Parts of one point, one after the other."""
    results: AnyResults = type(parts[0]).joined(parts)
    return results


@cache
def laws_digest() -> str:
    """Of all the code that decides where a boat goes: parts of two digests are not of one sweep."""
    root = Path(fleet.__file__).parent
    digest = hashlib.sha256(np.__version__.encode())
    for name in LAWS:
        place = root / name
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            if file.parent.name == "sweep" and file.stem in TELLING:
                continue
            digest.update(str(file.relative_to(root)).encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]
