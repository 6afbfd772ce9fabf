"""Other vessels in a mission: changed by name, kept when boats are multiplied, sent, written and drawn."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from fleet.mission.load import decode, encode, load
from fleet.mission.model import Ais, Positions, Steady
from fleet.mission.picture import picture
from fleet.mission.plan import build
from fleet.sim.share import as_toml


def test_a_vessel_is_changed_by_its_name() -> None:
    (ferry,) = load("ship", ["traffic.ferry.length_m=80", "traffic.ferry.sensed.interval_s=4"]).traffic
    assert ferry.length_m == 80.0
    assert ferry.sensed == Ais(interval_s=4.0)
    (ferry,) = load("ship", ["traffic.0.sensed={kind='positions', range_m=200}"]).traffic
    assert ferry.sensed == Positions(range_m=200.0)


def test_more_boats_meet_the_same_vessels() -> None:
    assert load("harbour", (), 6).traffic == load("harbour").traffic
    assert [vessel.name for vessel in load("harbour").traffic] == ["coaster", "launch", "yacht", "barge"]


def test_vessels_survive_the_wire_and_the_file_of_a_run(tmp_path: Path) -> None:
    mission = load("harbour")
    assert decode(encode(mission)) == mission
    file = tmp_path / "mission.toml"
    file.write_bytes(as_toml(mission))
    assert load(file) == mission


def test_a_vessel_is_heard_by_ais_and_keeps_its_course_unless_it_is_said_otherwise() -> None:
    mission = load("ship", ["traffic.ferry={name='x', length_m=30, speed_mps=3, track={kind='course', start=[300, 500], course_deg=270}}"])  # fmt: skip  # noqa: E501
    (vessel,) = mission.traffic
    assert (vessel.sensed, vessel.changes, vessel.gives_way) == (Ais(), (), False)
    assert isinstance(vessel.track, Steady)


def test_places_of_vessels_may_be_given_on_the_globe() -> None:
    from fleet.sim.traffic import begin, scripts

    place = "{kind='course', start={lat_deg=44.385, lon_deg=8.93}, course_deg=180}"
    (script,) = scripts(build(load("ship", [f"traffic.ferry.track={place}"])))
    assert begin(script).x == pytest.approx(555.7, abs=0.5)


@pytest.mark.parametrize("ending", ["svg", "png"])
def test_a_mission_with_vessels_is_drawn(tmp_path: Path, ending: str) -> None:
    pytest.importorskip("matplotlib")
    drawn = picture(build(load("harbour")), tmp_path / f"m.{ending}")
    assert drawn.stat().st_size > 5000


def test_the_ready_files_say_what_their_titles_say() -> None:
    folder = Path(__file__).parents[2] / "fleet" / "mission" / "ready"
    ship, harbour = (tomllib.loads((folder / f"{name}.toml").read_text()) for name in ("ship", "harbour"))
    assert len(ship["boats"]) == 5
    assert {vessel["sensed"]["kind"] for vessel in harbour["traffic"]} == {"ais", "positions"}
    assert any(change["do"] == "turn" for vessel in harbour["traffic"] for change in vessel.get("changes", ()))
