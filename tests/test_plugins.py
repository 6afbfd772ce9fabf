"""A small package in a folder adds a hull, a way of keeping clear and a driver, each by its entry point."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fleet.agent.config import load_config
from fleet.agent.hardware import hardware
from fleet.avoidance import METHODS
from fleet.drivers.kinds import OTHERS
from fleet.drivers.sensors.kinds import OTHERS as SENSORS
from fleet.drivers.sensors.kinds import equipped
from fleet.errors import ConfigError, UsageError
from fleet.hulls import CALM, HULLS, STEP_S
from fleet.mission.load import examine, load
from fleet.mission.plan import build
from fleet.sim.world import World

HUB = '[link]\ntopology = "hub"\n'
PACKAGE = '''
"""A raft, a boat that never minds anybody, and a driver that counts."""
import types

from fleet.avoidance import METHODS
from fleet.drivers.seam import Observed, Reading
from fleet.hulls import unicycle
from msgspec.structs import replace

raft = types.SimpleNamespace(
    description="a raft, which is slow",
    start=unicycle.start,
    velocity=unicycle.velocity,
    advance=lambda s, u, r, water, limits, dt, powered=1.0: unicycle.advance(s, 0.1 * u, r, water, limits, dt, powered),
    advance_by=unicycle.advance_by,
)
bold = replace(METHODS["circle"], name="bold", description="the circle, again")


class Counting:
    simulated = False

    def __init__(self, boat, step):
        self.boat, self.step, self.count = boat, step, 0

    def open(self): ...
    def neutral(self): ...
    def close(self): ...

    def read(self):
        return Reading(stamp_ns=self.count)

    def write(self, surge_mps, yaw_rate_radps):
        self.count += self.step
        return ""


class Sextant:
    gives = frozenset({"fix"})

    def __init__(self, where):
        self.where = where

    def open(self): ...
    def close(self): ...

    def read(self, now_ns):
        return Observed(fix_ns=now_ns, lat_deg=self.where, lon_deg=8.9, position_error_m=900.0)


def sextant(boat, config, now_ns):
    return Sextant(float(config.options["where"]))


def counting(boat, options, now_ns):
    return Counting(boat, int(options["step"]))


half = types.SimpleNamespace(description="half a hull")
'''
ENTRIES = """
[fleet.hulls]
raft = rafts:raft
half = rafts:half
gone = rafts:nothing_there
broken = rafts_broken:raft
unicycle = rafts:raft

[fleet.keeping_clear]
bold = rafts:bold

[fleet.drivers]
counting = rafts:counting

[fleet.sensors]
sextant = rafts:sextant
"""


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    (tmp_path / "rafts.py").write_text(PACKAGE)
    (tmp_path / "rafts_broken.py").write_text("1 / 0\n")
    info = tmp_path / "rafts-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: rafts\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(ENTRIES)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield
    for kinds, names in ((HULLS, ("raft",)), (METHODS, ("bold",)), (OTHERS, ("counting",)), (SENSORS, ("sextant",))):
        for name in names:
            kinds.pop(name, None)  # type: ignore[attr-defined]
        kinds._why.clear()  # type: ignore[attr-defined]
    sys.modules.pop("rafts", None)


@pytest.mark.usefixtures("installed")
def test_a_hull_of_another_package_is_sailed_by_its_name() -> None:
    mission = load("overtaking", ('boats.0.hull="raft"',))
    world = World(build(mission), 0)
    assert world.ships["b1"].hull.description == "a raft, which is slow"
    state = HULLS["raft"].start(0.0, 0.0, 0.0, 0.0)
    for _ in range(1000):
        state = HULLS["raft"].advance(state, 1.0, 0.0, CALM, world.ships["b1"].limits, STEP_S)
    assert state.u == pytest.approx(0.1, abs=0.01)


@pytest.mark.usefixtures("installed")
def test_a_way_of_keeping_clear_of_another_package_is_chosen_by_its_name() -> None:
    assert load("overtaking", ('keeping_clear.method="bold"',)).keeping_clear.method == "bold"
    assert METHODS["bold"].description == "the circle, again"


@pytest.mark.usefixtures("installed")
def test_a_driver_of_another_package_is_made_from_its_options(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    file.write_text('boat = "b1"\n[driver]\nkind = "counting"\noptions = { step = 3 }\n' + HUB)
    driver = hardware(load_config(file, {}, {}), lambda: 0)
    assert driver.write(1.0, 0.0) == ""
    assert driver.read().stamp_ns == 3


@pytest.mark.usefixtures("installed")
def test_a_sensor_of_another_package_stands_beside_a_driver(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    text = 'boat = "b1"\n[driver]\nkind = "counting"\noptions = { step = 3 }\n[[driver.sensors]]\nkind = "sextant"\n'
    file.write_text(text + 'use = ["fix"]\noptions = { where = 44.5 }\n' + HUB)
    config = load_config(file, {}, {})
    boat = equipped("b1", hardware(config, lambda: 0), config.driver.sensors, lambda: 7)
    reading = boat.read()
    assert (reading.lat_deg, reading.stamp_ns, reading.position_error_m) == (44.5, 7, 900.0)
    file.write_text(text + 'use = ["heading"]\n' + HUB)
    config = load_config(file, {}, {})
    with pytest.raises(ConfigError, match=r"driver.sensors, sextant: KeyError: 'where'"):
        equipped("b1", hardware(config, lambda: 0), config.driver.sensors, lambda: 7)
    file.write_text(text + 'use = ["heading"]\noptions = { where = 1 }\n' + HUB)
    config = load_config(file, {}, {})
    with pytest.raises(ConfigError, match=r"sextant: use: a sensor of kind 'sextant' gives no heading"):
        equipped("b1", hardware(config, lambda: 0), config.driver.sensors, lambda: 7)


@pytest.mark.usefixtures("installed")
def test_options_that_a_driver_does_not_take_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    file.write_text('boat = "b1"\n[driver]\nkind = "counting"\noptions = { step = "far" }\n' + HUB)
    with pytest.raises(ConfigError, match=r"driver.kind 'counting': ValueError: invalid literal"):
        hardware(load_config(file, {}, {}), lambda: 0)


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("half", "rafts:half of rafts has no start, velocity, advance, advance_by"),
        ("gone", "rafts:nothing_there of rafts cannot be loaded: AttributeError: "),
        ("broken", "rafts_broken:raft of rafts cannot be loaded: ZeroDivisionError: division by zero"),
        ("rafft", "no such hull; known: unicycle, otter, catamaran"),
    ],
)
def test_one_that_cannot_be_used_is_refused_with_the_reason(name: str, wrong: str) -> None:
    _, findings = examine("overtaking", (f'boats.0.hull="{name}"',))
    assert len(findings.problems) == 1
    assert wrong in str(findings.problems[0])


@pytest.mark.usefixtures("installed")
def test_a_name_that_is_built_in_cannot_be_taken() -> None:
    assert HULLS["unicycle"].description.startswith("unicycle with first-order lags")


@pytest.mark.usefixtures("installed")
def test_asked_for_by_name_a_broken_one_raises_what_a_person_can_read() -> None:
    with pytest.raises(UsageError, match=r"fleet.hulls: broken: rafts_broken:raft of rafts cannot be loaded"):
        _ = HULLS["broken"]


def test_without_the_package_the_names_are_unknown() -> None:
    assert "raft" not in HULLS
    with pytest.raises(KeyError):
        _ = METHODS["bold"]
