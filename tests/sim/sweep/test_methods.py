"""Ways of keeping clear side by side: the same encounters, one table."""

from __future__ import annotations

from pathlib import Path

import pytest

from fleet.errors import UsageError
from fleet.sim.sweep.family import load
from fleet.sim.sweep.methods import (
    HEADS,
    WAYS,
    Row,
    cells,
    chosen,
    keep_row,
    load_way,
    markdown,
    read_rows,
    sail_ways,
    ways,
)
from fleet.sim.sweep.parts import Part, pack, sail
from fleet.sim.sweep.pool import Sailed

SMALL = ("layout.meet_s=20", "layout.cruise_mps=1")


def here(text: str, seed: int, parts: tuple[Part, ...]) -> list[Sailed]:
    """An engine without processes."""
    family = load_from(text)
    return [Sailed(part, pack(sail(family, seed, part))) for part in parts]


def load_from(text: str) -> object:
    from fleet.sim.sweep.family import loads

    return loads(text)


def rows_of(*, out: Path | None = None, known: tuple[Row, ...] = ()) -> list[Row]:
    families = chosen(["head-on"], SMALL, 6)
    rows = list(sail_ways(families, ways([], ["circle-printed", "scoring"]), SMALL, here, 5, known))  # type: ignore[arg-type]
    for row in rows:
        if out is not None:
            keep_row(out, row)
    return rows


def test_the_printed_circle_stands_beside_the_default_on_the_same_cases(tmp_path: Path) -> None:
    file = tmp_path / "rows.jsonl"
    printed, scoring = rows_of(out=file)
    assert (printed.way, scoring.way) == ("circle-printed", "scoring")
    assert printed.figures["cases"] == scoring.figures["cases"] == 6
    assert scoring.figures["collisions"] == 0
    assert scoring.figures["min_separation_m"] > 6.0
    assert printed.figures["min_separation_m"] < scoring.figures["min_separation_m"]
    table = markdown([printed, scoring]).splitlines()
    assert len(table) == 4
    assert table[3].startswith("| head-on (layout.meet_s=20, layout.cruise_mps=1) | 6 | scoring | 0 | 0 | 0 |")
    assert len(cells(scoring)) == len(HEADS)

    def never(*_: object) -> list[Sailed]:
        raise AssertionError("sailed again")

    known = read_rows(file)
    again = sail_ways(chosen(["head-on"], SMALL, 6), ways([], ["scoring"]), SMALL, never, 5, known)  # type: ignore[arg-type]
    assert list(again) == [scoring]


def test_every_way_is_a_family_that_can_be_sailed() -> None:
    family = load("two-boat")
    said = {name: load_way(family, settings).run_options(0) for name, settings in WAYS.items()}
    assert said["circle-printed"]["params"].printed is True
    assert [said[name]["side"] for name in ("circle-closest", "circle-starboard")] == ["closest", "starboard"]
    assert said["scoring"]["method"] == "scoring"


def test_all_families_of_boats_of_the_fleet_are_taken_where_none_is_named() -> None:
    names = [family.name for family in chosen([], (), 3)]
    assert "wingman" in names
    assert "fleet" in names
    assert "ship" not in names
    assert all(family.cases <= 3 for family in chosen(["two-boat", "antipodal-exact"], (), 3))


def test_what_cannot_be_sailed_so_is_refused() -> None:
    with pytest.raises(UsageError, match="ship: methods of keeping clear within the fleet know no foreign vessels"):
        chosen(["ship"], (), 3)
    with pytest.raises(UsageError, match="--way circle: expected one of circle-printed, circle-closest"):
        ways([], ["circle"])


def test_a_file_of_something_else_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "rows.jsonl"
    file.write_text("{}\n")
    with pytest.raises(UsageError, match=r"rows.jsonl: not rows of methods: .*expected a file that --out wrote"):
        read_rows(file)
    assert read_rows(tmp_path / "none.jsonl") == []
