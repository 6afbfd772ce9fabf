"""Every wrong family file gets its message, and all of them at once."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Struct, structs

from fleet.errors import FamilyError
from fleet.guidance.limits import Limits
from fleet.sim.sweep import distributions, model
from fleet.sim.sweep.checks import CHECKS
from fleet.sim.sweep.family import load, loads, ready

from .wrong_families import COLUMN, FAMILY, SHIP, WRONG, WRONG_COLUMN, WRONG_SETS, WRONG_SHIP, tables

MANUAL = Path(__file__).parents[3] / "docs" / "sweeps.md"
ROWS = [(FAMILY, *row) for row in WRONG] + [(COLUMN, *row) for row in WRONG_COLUMN]
ROWS += [(SHIP, *row) for row in WRONG_SHIP]


def problems_of(text: str, *overrides: str) -> tuple[str, ...]:
    with pytest.raises(FamilyError) as caught:
        loads(text, "f.toml", overrides)
    return caught.value.problems


@pytest.mark.parametrize("text", [FAMILY, COLUMN, SHIP])
def test_the_families_that_the_table_spoils_are_right(text: str) -> None:
    assert loads(text).cases == 100


@pytest.mark.parametrize(("text", "right", "wrong", "message"), ROWS, ids=[row[3][:60] for row in ROWS])
def test_a_wrong_family_gets_its_message(text: str, right: str, wrong: str, message: str) -> None:
    assert text.count(right) == 1
    assert problems_of(text.replace(right, wrong)) == (message,)


@pytest.mark.parametrize(("given", "message"), WRONG_SETS)
def test_a_wrong_override_gets_its_message(given: str, message: str) -> None:
    assert problems_of(FAMILY, given) == (message,)


def test_every_problem_is_reported_at_once_and_with_the_name_of_the_file() -> None:
    text = FAMILY.replace("loss = 0.1", "loss = 2").replace("cases = 100", "cases = 0").replace("0.0, 0.5", "-1")
    with pytest.raises(FamilyError) as caught:
        loads(text, "f.toml")
    assert str(caught.value).splitlines() == [
        "f.toml: cases = 0 (line 3): expected a whole number from 1 to 1000000",
        "f.toml: radio.loss = 2 (line 13): expected a number from 0 to 1",
        "f.toml: grid.radio.delay_s[0] = -1 (line 17): expected a number from 0 to 10",
    ]


def test_a_missing_file_names_the_ready_family_that_may_be_meant() -> None:
    with pytest.raises(FamilyError, match=r'^two-boats: neither a file nor a ready family; did you mean "two-boat"\?$'):
        load("two-boats")


def test_a_folder_and_a_picture_are_no_families(tmp_path: Path) -> None:
    with pytest.raises(FamilyError, match="cannot be read"):
        load(tmp_path)
    (tmp_path / "f.toml").write_bytes(b"title = '\n\xff\xd8'")
    with pytest.raises(FamilyError, match="line 2: byte 0xff is not UTF-8 text"):
        load(tmp_path / "f.toml")


def test_boats_on_a_small_circle_are_too_near() -> None:
    assert problems_of('title = "c"\nboats = 8\ncases = 1\n[layout]\nkind = "circle"\nradius_m = 9.0\n') == (
        "layout.radius_m = 9 (line 6): 8 boats begin 6.9 m apart; at least 8.0 m",
    )


def test_a_case_whose_boats_never_come_apart_is_named() -> None:
    """At the start 1 in 20 draws is far enough apart, so the trial at loading hardly ever finds fault."""
    text = 'title = "m"\nboats = 2\ncases = 1\n[layout]\nkind = "meeting"\nmeet_s = 20.0\napart_m = 39.8\n'
    family = loads(text, "near", ["layout.apart_m=39.0"])
    too_near = loads(family.text, "near")
    spec = too_near.specs[0]
    layout = structs.replace(spec.layout, apart_m=41.0)
    with pytest.raises(FamilyError, match="near: 2 cases, the first is 3, do not begin 41 m apart"):
        structs.replace(too_near, specs=(structs.replace(spec, layout=layout),)).scenarios(1, 0, [3, 5])


KEYS = ("boats", "cases", "layout", "layout.kind", "layout.cruise_mps", "layout.meet_s", "formation", "radio.loss")
KEYS += ("limits.speed_max_mps", "keeping_clear.params", "trouble.stopped", "timeline", "timeline.0.at_s", "grid")
KEYS += ("grid.boats", "grid.radio", "grid.timeline.0.value", "checks", "environment.gnss_sigma_m", "layout.along_m")
VALUES = ("5", "-1", "1e308", "nan", "inf", "true", '"x"', "[]", "[1, 2]", "{}", "{even=[1, 2]}", "{even=[nan, 1]}")
VALUES += (
    "{normal=[1e308, 1e308]}",
    "{one_of=[inf]}",
    "[{}]",
    "1979-05-27",
    "1000000000000000000000",
    "{kind='circle'}",
)


@given(
    st.sampled_from([FAMILY, COLUMN, SHIP]),
    st.lists(st.tuples(st.sampled_from(KEYS), st.sampled_from(VALUES)), max_size=3),
)
@settings(deadline=None, max_examples=80)
def test_whatever_is_set_a_family_can_be_drawn_or_is_refused(text: str, sets: list[tuple[str, str]]) -> None:
    try:
        family = loads(text, "f", [f"{key}={value}" for key, value in sets], {"cases": 3})
    except FamilyError:
        return
    if family.foreign:
        assert len(family.ships(1, family.points[-1], range(3))) == 3
    else:
        assert family.scenarios(1, family.points[-1], range(3)).count == 3
    assert loads(family.text) == family


# the manual


@pytest.mark.parametrize("part", [FAMILY, COLUMN, SHIP, *tables()])
def test_the_manual_prints_what_the_code_does(part: str) -> None:
    assert part in MANUAL.read_text(encoding="utf-8")


def test_the_manual_lists_the_ready_families_and_the_checks() -> None:
    manual = MANUAL.read_text(encoding="utf-8")
    for name, title in ready():
        assert f"| `{name}` | {title} |" in manual
    for name, check in CHECKS.items():
        side = "at most" if check.at_most else "at least"
        assert f"| `{name}` | {side} | {check.unit} | {check.meaning} |" in manual


def test_the_manual_explains_every_key() -> None:
    words = set(re.findall(r"[a-z_0-9]+", MANUAL.read_text(encoding="utf-8")))
    kinds: list[type[Struct]] = [distributions.Spread, Limits]
    kinds += [kind for kind in vars(model).values() if isinstance(kind, type) and issubclass(kind, Struct)]
    assert {name for kind in kinds if kind is not Struct for name in kind.__struct_fields__} <= words


def test_the_example_in_the_manual_is_a_family() -> None:
    family = loads(MANUAL.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0])
    assert len(family.points) > 1
