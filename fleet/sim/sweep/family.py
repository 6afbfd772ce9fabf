"""Families of scenarios from files, by ready name, with overrides; and the scenarios of any case of them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from msgspec import Struct, structs

from fleet.avoidance import METHODS, Side
from fleet.errors import FamilyError, UsageError
from fleet.guidance.limits import Limits
from fleet.mission.overrides import apply, apply_option
from fleet.mission.problem import Key, texts
from fleet.mission.toml_file import parse, ready_files, text_at
from fleet.mission.toml_lines import key_lines
from fleet.sim.batch import Scenarios
from fleet.sim.batch.scenarios import IntArray
from fleet.sim.batch.ships import ShipCase
from fleet.sim.sweep.grid import Grid, specs_of
from fleet.sim.sweep.layouts import Crowded
from fleet.sim.sweep.model import MOST_CASES, MOST_SEED, Spec
from fleet.sim.sweep.scenes import scenes
from fleet.sim.sweep.ships import foreign, ship_cases

WHAT = "family"


class Point(Struct, frozen=True, kw_only=True):
    """One point of a family's grid."""

    number: int
    """From 0."""
    values: dict[str, float | int | str]
    """What is varied, by dotted key."""
    label: str
    """`loss 0.1, delay_s 0.5`; empty without a grid."""


class Family(Struct, frozen=True, kw_only=True):
    """A family, found to be right at every point of its grid; what the grid varies is that of its first point."""

    name: str
    title: str
    boats: int
    cases: int
    """At every point."""
    seed: int
    method: str
    radius_m: float
    side: Side
    hulls: tuple[str, ...]
    limits: Limits
    checks: dict[str, float]
    points: tuple[Point, ...]
    """Exactly one, of no values, without a grid."""
    specs: tuple[Spec, ...]
    """Of each point."""
    text: str
    """Its file with everything that was changed; `loads` makes the same family of it."""

    def spec(self, point: int | Point) -> Spec:
        """The family at one point."""
        return self.specs[point.number if isinstance(point, Point) else point]

    def scenarios(self, seed: int, point: int | Point, cases: IntArray | Sequence[int]) -> Scenarios:
        """Some cases; a case draws the same numbers however many there are, and at every point."""
        try:
            return scenes(self.name, self.spec(point), seed, np.asarray(cases, dtype=np.intp))
        except Crowded as crowded:
            raise FamilyError(self.name, (str(crowded),)) from None

    @property
    def foreign(self) -> bool:
        """Boats meet foreign vessels: `ships` says what, instead of `scenarios`."""
        return foreign(self.specs[0])

    def ships(self, seed: int, point: int | Point, cases: Sequence[int]) -> tuple[ShipCase, ...]:
        """Some cases with foreign vessels."""
        return tuple(ship_cases(self.name, self.spec(point), seed, cases))

    def run_options(self, point: int | Point) -> dict[str, Any]:
        """Arguments of `fleet.sim.batch.run` beside the scenarios."""
        keep = self.spec(point).keeping_clear
        params = None
        if keep.params:
            params = METHODS[keep.method].params(keep.radius_m, keep.side)
            given = {name: type(getattr(params, name))(value) for name, value in keep.params.items()}
            params = structs.replace(params, **given)
        return {"method": keep.method, "radius_m": keep.radius_m, "side": keep.side, "params": params}


def ready() -> list[tuple[str, str]]:
    """Names and titles of the families that come with fleet."""
    known = _ready_files()
    return [(name, tomllib.loads(known[name].read_text(encoding="utf-8"))["title"]) for name in sorted(known)]


def text_of(where: str | Path) -> str:
    """The text of a family file, or of a ready family: something to copy and change."""
    return text_at(where, _ready_files(), WHAT, FamilyError)


def load(
    where: str | Path,
    overrides: Sequence[str] = (),
    *,
    boats: int | None = None,
    cases: int | None = None,
    seed: int | None = None,
    method: str | None = None,
) -> Family:
    """The family at a path or of a ready name; FamilyError with everything that is wrong.

    Args:
        where: path of a file, or a ready name
        overrides: `dotted.key=value`; a key that the grid varies is not varied any more
        boats: instead of those written
        cases: at every point, instead of those written
        seed: of all that is drawn, instead of that written
        method: how boats keep clear, instead of what is written
    """
    options = {"boats": boats, "cases": cases, "seed": seed, "keeping_clear.method": method}
    return loads(text_of(where), str(where), overrides, options)


def loads(
    text: str, where: str = WHAT, overrides: Sequence[str] = (), options: Mapping[str, int | str | None] | None = None
) -> Family:
    """The family in a text; `where` is how messages call it, and what it is called if it has no name.

    Args:
        options: what options of the command line set, by dotted key; messages name the option: `--` and its last word
    """
    tree = parse(text, where, FamilyError)
    grid = Grid(tree, key_lines(text))
    given = {key: value for key, value in (options or {}).items() if value is not None}
    keys, refused = apply(tree, overrides)
    lines: dict[Key, int | str] = {**grid.lines, **dict.fromkeys(keys, 0)}
    for key, value in given.items():
        refused += apply_option(tree, key, value, f"--{key.split('.')[-1]}", lines)
    grid.settle([*keys, *(tuple(key.split(".")) for key in given)])
    specs, found = specs_of(tree, grid)
    if refused or found:
        raise FamilyError(where, texts([*refused, *found], lines))
    first = specs[0]
    name = first.name or _name_of(where)
    if overrides or given:
        text = tomli_w.dumps({"name": name, **tree, **grid.written()})
    elif first.name is None:
        text = f'name = "{name}"\n{text}'
    keep = first.keeping_clear
    return Family(
        name=name,
        title=first.title,
        boats=first.boats,
        cases=first.cases,
        seed=first.seed,
        method=keep.method,
        radius_m=keep.radius_m,
        side=keep.side,
        hulls=first.hulls or (first.hull,),
        limits=first.limits,
        checks=first.checks,
        points=tuple(Point(number=i, values=values, label=grid.label(values)) for i, values in enumerate(grid.points)),
        specs=tuple(structs.replace(spec, name=name) for spec in specs),
        text=text,
    )


def case_name(family: Family, seed: int, point: int, case: int) -> str:
    """`SEED/CASE`, or `SEED/POINT/CASE` where the family has a grid."""
    return f"{seed}/{case}" if len(family.points) == 1 else f"{seed}/{point}/{case}"


def read_case(family: Family, text: str) -> tuple[int, int, int]:
    """(seed, point, case) of a name; UsageError where it names no case of the family."""
    gridded = len(family.points) > 1
    parts = text.split("/")
    if len(parts) != 2 + gridded or not all(re.fullmatch(r"[0-9]{1,16}", part) for part in parts):
        form = "SEED/POINT/CASE" if gridded else "SEED/CASE"
        raise UsageError(f'case "{text}": expected {form}, whole numbers, as in {case_name(family, 1, 0, 17)}')
    seed, *between, case = map(int, parts)
    point = between[0] if between else 0
    for what, value, most in (("seed", seed, MOST_SEED), ("case", case, MOST_CASES - 1)):
        if value > most:
            raise UsageError(f'case "{text}": {what} {value}: expected 0 to {most}')
    if point >= len(family.points):
        raise UsageError(f'case "{text}": point {point}: {family.name} has points 0 to {len(family.points) - 1}')
    return seed, point, case


def _ready_files() -> dict[str, Any]:
    return ready_files("fleet.sim.sweep", "families")


def _name_of(where: str) -> str:
    """A name from a path: small letters, digits and hyphens."""
    name = re.sub(r"[^a-z0-9]+", "-", Path(where).stem.lower()).strip("-")
    return name[:32] or WHAT
