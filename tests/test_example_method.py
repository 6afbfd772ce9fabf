"""The third way of keeping clear of the manual: one file and an entry, and it is asked what every method is asked."""

from __future__ import annotations

import importlib
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from fleet.analysis import series
from fleet.analysis.replay import replay
from fleet.analysis.separation import approaches
from fleet.avoidance import METHODS
from fleet.mission.load import load as load_mission
from fleet.sim.batch import run
from fleet.sim.lockstep import sail_lockstep
from fleet.sim.share import Options
from fleet.sim.sweep.family import load
from tests.avoidance import test_laws as laws

FOLDER = Path(__file__).parent.parent / "docs" / "examples" / "reach"


@pytest.fixture(scope="module", autouse=True)
def installed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """As `pip install docs/examples/reach` would."""
    place = tmp_path_factory.mktemp("site")
    info = place / "reach-1.0.dist-info"
    info.mkdir()
    project = tomllib.loads((FOLDER / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    groups = project["entry-points"].items()
    lines = [f"[{group}]\n" + "".join(f"{name} = {at}\n" for name, at in some.items()) for group, some in groups]
    (info / "entry_points.txt").write_text("\n".join(lines))
    paths = [str(place), str(FOLDER)]
    sys.path[:0] = paths
    importlib.invalidate_caches()
    yield
    for path in paths:
        sys.path.remove(path)
    sys.modules.pop("reach", None)
    METHODS.pop("reach", None)
    METHODS._why.clear()


def params() -> Any:
    return METHODS["reach"].params(6.0, "closest")


def test_it_is_known_by_its_name_wherever_methods_are_named() -> None:
    assert METHODS["reach"].description.startswith("velocity obstacles")
    assert load_mission("overtaking", ("keeping_clear.method=reach",)).keeping_clear.method == "reach"
    tuned = load("two-boat", ("keeping_clear.method=reach", "keeping_clear.params.horizon_s=20"))
    assert tuned.run_options(0)["params"].horizon_s == 20.0


def test_a_boat_alone_decides_as_in_a_lane() -> None:
    laws.test_a_boat_alone_decides_as_in_a_lane("reach", params(), 60)


def test_a_masked_peer_is_the_same_as_none() -> None:
    laws.test_a_masked_peer_is_the_same_as_none("reach", params())


def test_somebody_far_away_changes_nothing() -> None:
    laws.test_somebody_far_away_changes_nothing("reach", params())


def test_its_memory_can_be_written_and_read() -> None:
    memory = METHODS["reach"].start(0.0, 3)
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(memory), type=METHODS["reach"].memory) == memory


def test_a_family_is_sailed_with_it_on_arrays_as_on_floats() -> None:
    family = load("head-on", ("keeping_clear.method=reach", "layout.meet_s=18"))
    scenarios = family.scenarios(3, 0, range(8))
    together = run(scenarios, floats=False, **family.run_options(0))
    alone = run(scenarios.part(slice(4, 5)), floats=True, **family.run_options(0))
    assert together.least_m[4] == alone.least_m[0]
    assert together.collided.sum() == 0
    assert float(np.median(together.least_m)) > 5.5
    assert np.isfinite(together.arrived_s).all()


def test_a_mission_is_sailed_with_it_by_agents_and_replays_to_the_bit(tmp_path: Path) -> None:
    mission = load_mission("three-crossing", ("keeping_clear.method=reach", "duration_s=60"))
    sailed = sail_lockstep(mission, "three-crossing", Options(root=str(tmp_path)))
    least = min(apart.distance_m for apart in approaches(series.load(sailed.folder).tracks))
    assert least > 5.5
    found = replay(sailed.folder)
    assert found.same, found.lines()
