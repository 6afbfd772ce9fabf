"""Parts of a sweep: so many cases of one point, their results as bytes, and what sails them."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import Struct

import fleet
from fleet.errors import RecordingError
from fleet.sim.batch import Results, run

if TYPE_CHECKING:
    from fleet.sim.sweep.family import Family

MOST_LANES, LEAST_LANES, SHARES = 4096, 1024, 4
LAWS = (
    *("ops.py", "ops_lanes.py", "geo.py", "paths", "guidance", "coordination", "avoidance", "hulls", "agent"),
    *("sim/batch", "sim/sweep"),
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
    "store",
    "table",
    "worker",
}
"""Modules of sweeps that do not: they carry, keep and tell."""


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


def parts_of(boats: Sequence[int], cases: int) -> tuple[Part, ...]:
    """The parts of a sweep, in order: whatever sails them, the same ones.

    A part is about 4096 lanes, where arrays stay in the cache, or a quarter of a smaller sweep.

    Args:
        boats: of a case, at each point
        cases: of each point
    """
    most = min(MOST_LANES, max(LEAST_LANES, sum(boats) * cases // SHARES))
    parts = []
    for point, of_case in enumerate(boats):
        number = -(-cases // max(1, most // of_case))
        size = -(-cases // number)
        parts += [Part(point, first, min(size, cases - first)) for first in range(0, cases, size)]
    return tuple(parts)


def sail(family: Family, seed: int, part: Part) -> Results:
    """Sail the cases of a part."""
    point = family.points[part.point]
    cases = np.arange(part.first, part.first + part.count)
    return run(family.scenarios(seed, point, cases), **family.run_options(point))


def pack(results: Results) -> bytes:
    """Results without traces as the bytes of an npz file."""
    fields = {name: getattr(results, name) for name in results.__struct_fields__ if name != "traces"}
    arrays: dict[str, Any] = {name: value for name, value in fields.items() if isinstance(value, np.ndarray)}
    values = {name: value for name, value in fields.items() if name not in arrays}
    to = io.BytesIO()
    np.savez(to, values=np.frombuffer(json.dumps(values).encode(), dtype=np.uint8), **arrays)
    return to.getvalue()


def unpack(content: bytes, where: str = "part") -> Results:
    """What `pack` was given.

    Raises:
        RecordingError: these are not the bytes of a part
    """
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            values = json.loads(file["values"].tobytes())
            return Results(traces=[], **values, **{name: file[name] for name in file.files if name != "values"})
    except (ValueError, KeyError, TypeError, OSError, EOFError, zipfile.BadZipFile) as error:
        raise RecordingError(f"{where}: not a part of a sweep, or damaged: {error}") from error


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
