"""The table of a batch gives every lane what its own path gives."""

from __future__ import annotations

import math
import struct
import subprocess
import sys

import numpy as np
import pytest

from fleet.paths import Path, arc, polyline, sine, straight, through
from fleet.paths.table import PathTable

PATHS: dict[str, Path] = {
    "line": straight((3.0, -2.0), (103.0, 51.0)),
    "line west": straight((0.0, 0.0), (-0.0, -40.0)),
    "arc": arc((5.0, 7.0), 15.0, 0.3, -2.0),
    "circle": arc((5.0, 7.0), 15.0, 0.3, 2.0 * math.pi),
    "polyline": polyline([(0.0, 0.0), (60.0, 10.0), (70.0, 80.0), (0.0, 90.0)], 8.0),
    "circuit": polyline([(0.0, 0.0), (60.0, 10.0), (70.0, 80.0), (0.0, 90.0)], 8.0, closed=True),
    "sine": sine((0.0, 0.0), (200.0, 30.0), 15.0, 110.0),
    "spline": through([(0.0, 0.0), (30.0, 10.0), (35.0, 60.0), (90.0, 70.0)]),
    "closed spline": through([(0.0, 0.0), (30.0, 10.0), (35.0, 60.0)], closed=True),
}


def bits(values: list[float]) -> list[bytes]:
    return [struct.pack("<d", v) for v in values]


def abscissae(path: Path) -> list[float]:
    """Within, at every junction and its neighbours, beyond both ends, laps."""
    rng = np.random.default_rng(3)
    long = path.length
    inner = rng.uniform(0.0, long, 300).tolist()
    outer = rng.uniform(-3.0 * long, 4.0 * long, 100).tolist()
    edges = [0.0, -0.0, long, -1e-9, 5.0 * long, -long, 1e7, -1e7]
    for s in (*path._starts, long):
        edges += [s, math.nextafter(s, -math.inf), math.nextafter(s, math.inf)]
    return [*inner, *outer, *edges]


@pytest.mark.parametrize("together", [False, True], ids=["alone", "in a table of all"])
@pytest.mark.parametrize("name", PATHS)
def test_every_lane_has_the_bits_of_its_path(name: str, together: bool) -> None:
    path = PATHS[name]
    s = abscissae(path)
    paths = list(PATHS.values()) if together else [path]
    number = paths.index(path)
    others = list(range(len(paths)))
    table = PathTable(paths, [number] * len(s) + others)
    at = np.array([*s, *(1.5 for _ in others)])
    with np.errstate(all="raise", under="ignore"):
        points, ahead = table.at(at), table.straight(at)
    for field in ("x", "y", "tx", "ty", "c"):
        expected = [getattr(path.at(v), field) for v in s]
        assert bits(getattr(points, field)[: len(s)].tolist()) == bits(expected), field
    assert bits(ahead[: len(s)].tolist()) == bits([path.straight(v) for v in s])
    assert table.length[0] == path.length


def test_lanes_are_taken_with_their_paths() -> None:
    paths = list(PATHS.values())
    table = PathTable(paths, list(range(len(paths))))
    lanes = np.array([7, 1, 1, 4])
    part = table.take_lanes(lanes)
    s = np.array([3.0, -2.0, 500.0, 12.25])
    assert part.at(s).x.tolist() == [paths[i].at(v).x for i, v in zip(lanes.tolist(), s.tolist(), strict=True)]
    assert part.closed.tolist() == [paths[i].closed for i in lanes.tolist()]


def test_a_table_of_lines_only_takes_no_lanes_it_does_not_have() -> None:
    lines = [PATHS["line"], PATHS["line west"]]
    table = PathTable(lines, [1, 0, 1])
    assert table.straight(np.array([0.0, 1e3, -5.0])).tolist() == [1e6] * 3


def test_an_agent_does_not_import_the_table() -> None:
    code = (
        "import sys, fleet.paths, fleet.agent.step; "
        "lanes = {'fleet.paths.table', 'fleet.avoidance.search_lanes', 'fleet.ops_lanes', 'numpy'}; "
        "assert not lanes & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
