"""The grid of a family: dotted keys and the values that they take; a family at every point."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import msgspec

from fleet.mission.overrides import put
from fleet.mission.problem import Key, Problem, dotted, show
from fleet.mission.structure import problems
from fleet.sim.sweep.check import check
from fleet.sim.sweep.model import Spec
from fleet.sim.sweep.ships import foreign

Words = tuple[str, ...]
MOST_POINTS = 1000
ONCE = ("title", "name", "cases", "seed", "checks", "grid")  # the same at every point


class Grid:
    """The table `[grid]` of a family's tree, taken in with its keys split at the dots."""

    def __init__(self, tree: dict[str, Any], lines: Mapping[Key, int]) -> None:
        """Splits `"radio.loss" = [...]` at its dots, in the tree and in the lines of its keys."""
        self._tree = tree
        self.lines = {_split(key): line for key, line in lines.items()}
        self.wrong: list[Problem] = []
        self.points: list[dict[str, Any]] = [{}]
        self._axes: dict[Words, Sequence[Any]] = {}
        grid = tree.get("grid", {})
        if isinstance(grid, dict):
            nested: dict[str, Any] = {}
            for key, values in _leaves(grid, ()):
                outcome = put(nested, list(key), values)
                if isinstance(outcome, Problem):
                    self.wrong.append(Problem(("grid", *outcome.where), outcome.wrong))
            if grid:
                tree["grid"] = nested

    def settle(self, overridden: Sequence[Key]) -> None:
        """Take the grid out of the tree, which overrides have changed; what they set is not varied any more."""
        grid = self._tree.pop("grid", {})
        if not isinstance(grid, dict):
            self.wrong.append(Problem(("grid",), 'expected a table of lists, as in "radio.loss" = [0.0, 0.1]', grid))
            return
        for key, values in _leaves(grid, ()):
            if any(key == tuple(map(str, name[: len(key)])) for name in overridden):
                continue
            wrong = _unfit(key, values)
            if wrong:
                self.wrong.append(wrong)
            else:
                self._axes[key] = values
        count = math.prod(len(values) for values in self._axes.values())
        if count > MOST_POINTS:
            self.wrong.append(Problem(("grid",), f"{count} points; at most {MOST_POINTS}"))
        if not self.wrong:
            names = [".".join(key) for key in self._axes]
            self.points = [dict(zip(names, values, strict=True)) for values in product(*self._axes.values())]

    def trees(self) -> Iterator[tuple[dict[str, Any], dict[Words, int]]]:
        """The tree of each point, and for each key that is varied the place of its value in its list."""
        for places in product(*(range(len(values)) for values in self._axes.values())):
            tree = copy.deepcopy(self._tree)
            at: dict[Words, int] = {}
            for (key, values), place in zip(self._axes.items(), places, strict=True):
                put(tree, list(key), values[place])
                at[key] = place
            yield tree, at

    def obstacles(self) -> list[Problem]:
        """Keys that cannot be set, since a part of them is no table."""
        found = []
        for key, values in self._axes.items():
            outcome = put(copy.deepcopy(self._tree), list(key), values[0])
            if isinstance(outcome, Problem):
                found.append(Problem(("grid", *key), outcome.wrong))
        return found

    def known(self, key: Key) -> bool:
        """Whether the tree without the grid has a key."""
        here: Any = self._tree
        for part in key:
            if not isinstance(here, dict) or part not in here:
                return False
            here = here[part]
        return True

    def moved(self, problem: Problem, at: Mapping[Words, int]) -> Problem:
        """A problem at a key that is varied stands in the grid."""
        for key, place in at.items():
            words = tuple(map(str, problem.where))
            if words[: len(key)] == key:
                rest = () if problem.wrong.startswith("unknown key") else (place, *problem.where[len(key) :])
                return Problem(("grid", *key, *rest), problem.wrong, problem.value)
            if key[: len(words)] == words and not self.known(problem.where):
                return Problem(("grid", *problem.where), problem.wrong, problem.value)
        return problem

    def label(self, values: Mapping[str, Any]) -> str:
        """`loss 0.1, delay_s 0.5`: the last parts of the keys, where they tell them apart."""
        short = [key.rpartition(".")[2] for key in values]
        names = short if len(set(short)) == len(short) else list(values)
        return ", ".join(
            f"{name} {value if isinstance(value, str) else show(value)}"
            for name, value in zip(names, values.values(), strict=True)
        )

    def written(self) -> dict[str, Any]:
        """`grid` as a family's text has it; nothing where nothing is varied."""
        return {"grid": {".".join(key): values for key, values in self._axes.items()}} if self._axes else {}


def specs_of(tree: dict[str, Any], grid: Grid) -> tuple[tuple[Spec, ...], list[Problem]]:
    """The family at every point of its grid, and everything that is wrong with any of them, each once."""
    grid.wrong += grid.obstacles()
    if grid.wrong:
        return (), [*grid.wrong, *problems(tree, Spec)]
    found: dict[str, Problem] = {}
    specs = []
    for one, at in grid.trees():
        wrong: Sequence[Problem] = problems(one, Spec)
        if not wrong:
            specs.append(msgspec.convert(one, Spec))
            wrong = check(specs[-1])
        for problem in wrong:
            moved = grid.moved(problem, at)
            found.setdefault(moved.text(), moved)
    if len({foreign(spec) for spec in specs}) > 1:
        mixed = Problem(("grid", "layout", "kind"), "with and without foreign vessels; expected one of the two")
        found[mixed.text()] = mixed
    return tuple(specs), list(found.values())


def _leaves(table: Mapping[str, Any], where: Words) -> Iterator[tuple[Words, Any]]:
    """Every value that is no table, with its key split at the dots."""
    for name, value in table.items():
        key = (*where, *name.split("."))
        if isinstance(value, dict):
            yield from _leaves(value, key)
        else:
            yield key, value


def _split(key: Key) -> Key:
    """`("grid", "radio.loss", 2)` as `("grid", "radio", "loss", 2)`."""
    if key[:1] != ("grid",):
        return key
    return tuple(part for word in key for part in (word.split(".") if isinstance(word, str) else (word,)))


def _unfit(key: Words, values: Any) -> Problem | None:
    """What is wrong with one list of the grid."""
    where = ("grid", *key)
    if key[0] in ONCE:
        return Problem(where, f"{dotted(key)} is the same at every point; it cannot be varied")
    if not isinstance(values, list):
        return Problem(where, "expected a list of values", values)
    if not values:
        return Problem(where, "expected at least one value", values)
    for i, value in enumerate(values):
        if not isinstance(value, int | float | str) or isinstance(value, bool):
            return Problem((*where, i), "expected a number or text", value)
        if value in values[:i]:
            return Problem((*where, i), "a value before it is the same", value)
    return None
