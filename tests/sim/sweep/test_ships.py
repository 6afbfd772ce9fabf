"""Families with foreign vessels: what is drawn, what is kept of it, and what is told."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs
from typer.testing import CliRunner

from fleet.cli.main import app
from fleet.sim.batch.ships import ShipCase, ship_track
from fleet.sim.batch.ships_cases import IMAZU, c0
from fleet.sim.batch.ships_judge import judge
from fleet.sim.batch.ships_sail import sail as sailed
from fleet.sim.sweep.checks import CHECKS
from fleet.sim.sweep.family import load, loads, ready
from fleet.sim.sweep.parts import Part, joined, pack, parts_of, sail, unpack
from fleet.sim.sweep.pool import local
from fleet.sim.sweep.ships_alone import sail_ship_case
from fleet.sim.sweep.ships_results import METHOD, PER_CASE, ShipResults, figures
from fleet.sim.sweep.store import Sweep

NAMES = [name for name, _ in ready() if load(name).foreign]
SOON = """
title = "A vessel comes soon"
boats = 1
cases = 3
duration_s = 40.0

[layout]
kind = "vessels"
meet_s = 30.0
length_m = 10.0
speed_mps = 2.0
cruise_mps = 1.0
sensor = "exact"
"""


def of_cases(**given: list[float]) -> ShipResults:
    """Results of two cases where all went well, but for what is given."""
    well = {name: [0.0, 0.0] for name in PER_CASE} | {"dom": [1.2, 1.4], "risk": [1.0, 1.0], "side": [1.0, math.nan]}
    values = {name: np.array(row) for name, row in (well | given).items() if name in PER_CASE}
    least = np.array(given.get("least_m", [math.inf, math.inf]))
    zero = np.zeros(2)
    return ShipResults(
        family="f", method=METHOD, seed=1, hull_m=2.4, radius_m=6.0, case=np.arange(2), values=values, least_m=least,
        ship_m=np.array([5.0, 9.0]), late_s=np.array([10.0, 30.0]), unfinished=zero, boat_ticks=10, wall_s=1.0,
    )  # fmt: skip


def test_the_ready_families() -> None:
    assert NAMES == ["bank", "both", "imazu", "ship", "ships", "stopped-ship", "sudden"]


@pytest.mark.parametrize("name", NAMES)
def test_a_case_is_the_same_however_many_are_drawn(name: str) -> None:
    family = load(name)
    many, one = family.ships(5, family.points[-1], range(6)), family.ships(5, family.points[-1], [4])
    assert one == many[4:5]
    assert one != family.ships(6, family.points[-1], [4])


@pytest.mark.parametrize("name", ["ship", "ships", "bank"])
def test_left_alone_every_vessel_passes_within_1_2_of_its_clearance(name: str) -> None:
    for case in load(name).ships(3, 0, range(8)):
        for ship in case.ships:
            assert nearest(case, ship_track(ship, 2400)) <= 1.2 * c0(ship.length) + 0.3


def test_a_vessel_meets_the_boat_on_a_path_that_bends_too() -> None:
    family = loads(SOON, overrides=["layout.bend_deg=60", "layout.bend_before_s=15", "layout.miss=0"])
    for case in family.ships(3, 0, range(5)):
        end = case.path().at(case.path().length)
        assert math.atan2(end.ty, end.tx) == pytest.approx(math.radians(60.0))
        assert nearest(case, ship_track(case.ships[0], 400)) < 0.3


def nearest(case: ShipCase, track: tuple[np.ndarray, np.ndarray, np.ndarray]) -> float:
    """Least distance of the first boat to a vessel if both go on [m]."""
    path = case.path()
    places = [path.at(0.1 * k * case.cruise) for k in range(len(track[0]))]
    return min(math.hypot(p.x - x, p.y - y) for p, x, y in zip(places, track[0], track[1], strict=True))


def test_the_vessels_of_imazu_are_those_of_the_published_cases() -> None:
    family = load("imazu")
    assert len(family.points) == 66
    (case,) = family.ships(1, 3 * 5 - 2, [0])  # the fifth geometry at twice our speed
    assert [round(math.degrees(ship.chi)) for ship in case.ships] == list(IMAZU[4])
    for ship in case.ships:
        x, y, _ = ship_track(ship, 1801)
        assert (ship.U, math.hypot(x[-1] - 180.0, y[-1]) < 0.5) == (2.0, True)


def test_a_formation_lies_in_column_or_abreast_and_its_options_reach_the_boats() -> None:
    column, abreast = (load("ship", ["layout.abreast=" + word], boats=3).ships(1, 0, [0])[0] for word in "01")
    assert [place[:2] for place in column.paths] == [(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]
    assert [place[:2] for place in abreast.paths] == [(0.0, 0.0), (0.0, 10.0), (0.0, 20.0)]
    hard = ["hull=otter", "environment.current_mps=0.3", "environment.current_toward_deg=90", "layout.shoal_m=10"]
    (case,) = load("ship", hard, boats=3).ships(1, 0, [0])
    assert (case.hull, len(case.edges), case.radio.loss) == ("otter", 6, 0.1)
    assert case.current == pytest.approx((0.0, 0.3))


def test_boats_of_both_come_to_one_place_at_about_the_same_time_each_on_its_own_path() -> None:
    for case in load("both").ships(5, 0, range(8)):
        assert case.parties == ((0,), (1,), (2,), (3,))
        where = case.cruise * 120.0, 0.0
        for boat in range(4):
            point = case.path_of(boat).at(case.cruise * 120.0)
            assert math.hypot(point.x - where[0], point.y - where[1]) <= 8.0 * case.cruise + 1e-6
        starts = [case.paths[i][:2] for i in range(4)]
        assert len(set(starts)) == 4
        assert starts[0] == (0.0, 0.0)


def test_a_vessel_turns_to_either_side() -> None:
    turns = [case.ships[0].turn for case in load("sudden").ships(1, 0, range(40))]
    assert {math.copysign(1.0, turn) for turn in turns} == {1.0, -1.0}
    assert all(math.radians(30.0) <= abs(turn) <= math.radians(90.0) for turn in turns)


def test_parts_are_a_few_cases_of_some_seconds() -> None:
    assert [part.count for part in parts_of([5, 1], 8, one_by_one=True)] == [4, 4, 8]


def test_a_part_comes_back_from_its_bytes_and_parts_are_joined_in_order() -> None:
    family = loads(SOON)
    whole = sail(family, 7, Part(0, 0, 3))
    halves = [unpack(pack(sail(family, 7, part))) for part in (Part(0, 0, 1), Part(0, 1, 2))]
    again = joined(halves)
    assert isinstance(whole, ShipResults)
    assert isinstance(again, ShipResults)
    assert again.case.tolist() == [0, 1, 2]
    assert all(np.array_equal(whole.values[name], again.values[name], equal_nan=True) for name in PER_CASE)
    assert np.array_equal(whole.late_s, again.late_s)


def test_another_process_sails_the_same_bits_and_alone_they_are_the_same() -> None:
    family = loads(SOON, overrides=["seed=7"])
    what = Sweep.of(family, "fleet sweep soon")
    (sailed,) = local(1)(what.text, 7, what.parts)
    assert sailed.content is not None
    there = unpack(sailed.content)
    assert isinstance(there, ShipResults)
    alone = sail_ship_case(family, 7, 0, 2)
    assert judge(alone.case, alone.voyage).dom == there.values["dom"][2]
    assert alone.results.late_s[0] == there.late_s[2]


def test_the_figures_of_two_cases_by_hand() -> None:
    found = figures([of_cases(dom=[0.9, 1.4], contact=[0.0, 1.0], decisions=[3.0, 0.0], early=[1.0, 0.0])])
    assert (found["cases"], found["contacts"], found["domain_kept"], found["domain_kept_08"]) == (2, 1, 0.5, 1.0)
    assert (found["side_right"], found["in_time"], found["decisions"]) == (1.0, 0.5, 3.0)
    assert (found["delay_median_s"], found["min_separation_m"]) == (20.0, None)
    assert {check.figure for check in CHECKS.values() if True in check.foreign} <= set(found)


def test_a_case_that_began_inside_is_not_asked_for_the_domain() -> None:
    inside = of_cases(dom=[0.1, 1.4], inside=[1.0, 0.0])
    assert figures([inside])["domain_kept"] == 1.0
    assert inside.failed.tolist() == []
    assert of_cases(dom=[0.1, 1.4]).failed.tolist() == [0]


def test_two_boats_that_touch_are_a_collision_and_no_contact() -> None:
    found = figures([of_cases(least_m=[2.0, 8.0])])
    assert (found["contacts"], found["collisions"], found["inside_radius"]) == (0, 1, 1)


@pytest.mark.parametrize(
    ("seed", "case", "seconds"),
    [(4002, 0, 30.0), (2029, 34, 150.0)],
    ids=["a column turns back at once", "boats abreast come back to their paths"],
)
def test_a_formation_that_turns_together_keeps_its_spacing(seed: int, case: int, seconds: float) -> None:
    """10 m; each turns where the next one is just now, some tenths of a second apart: it was 7.9 and 7.0 m once."""
    (five,) = load("ship", ["boats=5", "layout.abreast={ one_of = [0, 1] }"]).ships(seed, 0, [case])
    five = structs.replace(five, limit_s=seconds)
    voyage = sailed(five)
    assert len({d.boat for d in voyage.decisions}) == 5
    assert judge(five, voyage).closest_m > 9.0


def test_with_and_without_foreign_vessels_is_no_grid() -> None:
    from fleet.errors import FamilyError

    mixed = 'title = "m"\nboats = 1\ncases = 1\n[layout]\n[grid]\n"layout.kind" = ["imazu", "circle"]\n'
    with pytest.raises(FamilyError, match="with and without foreign vessels"):
        loads(mixed)


def test_the_command_line_sweeps_sails_one_alone_and_compares(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    file = tmp_path / "soon.toml"
    file.write_text(SOON + "\n[checks]\ncontacts_max = 3\ndomain_kept_min = 0.0\n")
    runs = ["--runs", str(tmp_path / "runs")]
    swept = CliRunner().invoke(app, ["sweep", str(file), "--jobs", "1", "--json", *runs])
    assert swept.exit_code == 0, swept.output
    told = json.loads(swept.stdout[swept.stdout.index("{") :])
    assert (told["cases"], told["passed"], told["method"]) == (3, True, METHOD)
    page = (Path(told["folder"]) / "report.html").read_text()
    assert "the domain" in page or "domain" in page
    assert page.count("<svg") >= 2
    alone = CliRunner().invoke(app, ["sim", "--case", f"{told['folder']}:1/2", "--json", *runs])
    case = json.loads(alone.stdout[alone.stdout.index("{") :])
    assert (len(case["vessels"]), case["cases"]) == (1, 1)
    assert Path(case["picture"]).stat().st_size > 10_000
    both = CliRunner().invoke(app, ["sweep", "compare", told["folder"], told["folder"], *runs])
    assert both.exit_code == 0, both.output
    assert "3 cases in both" in both.stdout
