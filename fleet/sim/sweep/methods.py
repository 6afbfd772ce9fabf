"""Several ways of keeping clear over several families, on the same encounters: one row for each, side by side."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from msgspec import Struct

from fleet.errors import RecordingError, UsageError
from fleet.sim.sweep.family import Family, load, ready
from fleet.sim.sweep.parts import joined, laws_digest, parts_of, unpack
from fleet.sim.sweep.pool import Engine
from fleet.sim.sweep.table import figures

WAYS: dict[str, tuple[str, ...]] = {
    "circle-printed": ("keeping_clear.method=circle", "keeping_clear.params.printed=1"),
    "circle-closest": ("keeping_clear.method=circle", "keeping_clear.side=closest"),
    "circle-starboard": ("keeping_clear.method=circle", "keeping_clear.side=starboard"),
    "scoring": ("keeping_clear.method=scoring",),
}
"""The paper's algorithm as printed, corrected with either side, and the default: what is set for each."""
SHOWN = (
    *(
        "cases",
        "boats_with_goal",
        "collisions",
        "standstills",
        "stopped",
        "inside_radius",
        "min_separation_m",
        "separation_median_m",
    ),
    *("delay_median_s", "delay_p95_s", "settled_median_s", "settled_p95_s", "unsettled", "off_place"),
    "switches_per_boat",
)
"""Figures of a row, by the names of `table.MEANINGS`."""


class Row(Struct, frozen=True, kw_only=True):
    """One family sailed one way; the points of its grid together."""

    family: str
    way: str
    seed: int
    overrides: tuple[str, ...]
    laws: str
    figures: dict[str, Any]

    @property
    def key(self) -> tuple[Any, ...]:
        """What makes two rows the same."""
        return self.family, self.way, self.seed, self.overrides, self.figures["cases"], self.laws


def ways(further: Sequence[str], only: Sequence[str] = ()) -> dict[str, tuple[str, ...]]:
    """Those of `WAYS`, and further methods by name: of another package, or one's own; or some of these only."""
    every = WAYS | {name: (f"keeping_clear.method={name}",) for name in further if name not in WAYS}
    unknown = [name for name in only if name not in every]
    if unknown:
        raise UsageError(f"--way {unknown[0]}: expected one of {', '.join(every)}")
    return {name: settings for name, settings in every.items() if not only or name in only}


def chosen(names: Sequence[str], overrides: Sequence[str], cases: int | None) -> list[Family]:
    """The families named, or all that come with fleet and have no foreign vessels; at most `cases` at a point."""
    every = list(names) or [name for name, _ in ready() if not load(name).foreign]
    found = []
    for name in every:
        family = load(name, overrides)
        if family.foreign:
            raise UsageError(f"{name}: methods of keeping clear within the fleet know no foreign vessels")
        if cases is not None and cases < family.cases:
            family = load(name, overrides, cases=cases)
        found.append(family)
    return found


def sail_ways(
    families: Sequence[Family],
    of: dict[str, tuple[str, ...]],
    overrides: Sequence[str],
    engine: Engine,
    seed: int | None = None,
    known: Sequence[Row] = (),
) -> Iterator[Row]:
    """Every family every way, a row as soon as it is there; those known already are not sailed again."""
    there = {row.key: row for row in known}
    for family in families:
        for way, settings in of.items():
            one = load_way(family, settings)
            number = family.seed if seed is None else seed
            cases = one.cases * len(one.points)
            key = (family.name, way, number, tuple(overrides), cases, laws_digest())
            yield there[key] if key in there else _row(one, way, number, overrides, engine)


def load_way(family: Family, settings: Sequence[str]) -> Family:
    """The same family with another way of keeping clear."""
    from fleet.sim.sweep.family import loads

    return loads(family.text, family.name, settings)


def _row(family: Family, way: str, seed: int, overrides: Sequence[str], engine: Engine) -> Row:
    parts = parts_of([spec.boats for spec in family.specs], family.cases, family.foreign)
    by_point: dict[int, list[Any]] = {}
    for sailed in sorted(engine(family.text, seed, parts), key=lambda sailed: sailed.part):
        if sailed.content is None:
            raise RecordingError(f"{family.name}, {way}: {sailed.part}: not sailed: {sailed.why}")
        by_point.setdefault(sailed.part.point, []).append(unpack(sailed.content))
    found = figures([joined(results) for _, results in sorted(by_point.items())])
    return Row(
        family=family.name,
        way=way,
        seed=seed,
        overrides=tuple(overrides),
        laws=laws_digest(),
        figures={name: found[name] for name in SHOWN},
    )


# -- kept --------------------------------------------------------------------------------------------------------------
def read_rows(file: Path) -> list[Row]:
    """The rows that a file holds; none where there is no file."""
    if not file.exists():
        return []
    try:
        lines = [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]
        return [Row(**{**line, "overrides": tuple(line["overrides"])}) for line in lines]
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise UsageError(f"{file}: not rows of methods: {error}; expected a file that --out wrote") from None


def keep_row(file: Path, row: Row) -> None:
    """One row more."""
    fields = {name: getattr(row, name) for name in row.__struct_fields__}
    try:
        with file.open("a", encoding="utf-8") as to:
            to.write(json.dumps(fields) + "\n")
    except OSError as error:
        raise RecordingError(f"{file}: {error.strerror}") from error


HEADS = ("family", "cases", "method", "collisions", "standstills", "below R", "separation least / median", "delay or settling median / 95 %", "switches")  # fmt: skip  # noqa: E501


def cells(row: Row) -> tuple[str, ...]:
    """A row as words: shares in percent of the cases, metres, seconds."""
    f = row.figures
    settles = f["boats_with_goal"] == 0
    first, second = ("settled_median_s", "settled_p95_s") if settles else ("delay_median_s", "delay_p95_s")
    times = f"{'settled ' if settles else ''}{_s(f[first])} / {_s(f[second])} s"
    if f[first] is None:
        times = "nobody in place" if settles else "nobody arrived"
    return (
        f"{row.family} ({', '.join(row.overrides)})" if row.overrides else row.family,
        str(f["cases"]),
        row.way,
        _share(f["collisions"], f["cases"]),
        _share(f["standstills"], f["cases"]),
        _share(f["inside_radius"], f["cases"]),
        f"{_s(f['min_separation_m'])} / {_s(f['separation_median_m'])} m",
        times,
        _s(f["switches_per_boat"]),
    )


def markdown(rows: Sequence[Row]) -> str:
    """The rows as a table for a page."""
    lines = [HEADS, tuple("---" for _ in HEADS), *map(cells, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _s(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"


def _share(count: int, of: int) -> str:
    share = count / of
    return "0" if not count else f"{share:.1%}" if share < 0.1 else f"{share:.0%}"
