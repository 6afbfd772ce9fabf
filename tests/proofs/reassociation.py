"""Does a test break when one expression of a law is re-associated? Every one is tried, one at a time.

A chain such as (a + b) - c becomes a + (b - c), (a * b) / c becomes a * (b / c): the same number on paper. The
reference runs are replayed with the changed module: do decisions differ, or at least numbers inside of the laws? A
chain that neither notices is listed.

python -m tests.proofs.reassociation                  all laws, some two minutes
python -m tests.proofs.reassociation fleet.ops        some modules
"""

from __future__ import annotations

import ast
import importlib.util
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

REFERENCE = Path(__file__).parents[1] / "replay" / "reference"
LAWS = (
    "fleet.ops",
    "fleet.paths.curve",
    "fleet.guidance.virtual_target",
    "fleet.guidance.station",
    "fleet.coordination.consensus",
    "fleet.avoidance.pair",
    "fleet.avoidance.cost",
    "fleet.avoidance.search",
    "fleet.avoidance.brake",
    "fleet.avoidance.scoring",
    "fleet.avoidance.circle",
    "fleet.agent.step",
)
DECISIONS, NUMBERS = 3, 4  # exit codes: what differs
SUMS, PRODUCTS = (ast.Add, ast.Sub), (ast.Mult, ast.Div)


class ReAssociated(ast.NodeTransformer):
    """The tree with its chain number `chosen` bracketed the other way; `seen` are the lines of all chains."""

    def __init__(self, chosen: int) -> None:
        self.chosen = chosen
        self.seen: list[tuple[int, str]] = []

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        left = node.left
        if not isinstance(left, ast.BinOp) or not _chain(left.op, node.op) or _constant(node):
            return node
        self.seen.append((node.lineno, ast.unparse(node)))
        if len(self.seen) - 1 != self.chosen:
            return node
        inner: ast.operator = node.op
        if isinstance(left.op, ast.Sub):
            inner = ast.Add() if isinstance(node.op, ast.Sub) else ast.Sub()
        return ast.copy_location(ast.BinOp(left.left, left.op, ast.BinOp(left.right, inner, node.right)), node)


def _chain(first: ast.operator, second: ast.operator) -> bool:
    sums = isinstance(first, SUMS) and isinstance(second, SUMS)
    return sums or (isinstance(first, ast.Mult) and isinstance(second, PRODUCTS))


def _constant(node: ast.AST) -> bool:
    return not any(isinstance(part, ast.Name | ast.Attribute | ast.Call) for part in ast.walk(node))


class Loader(SourceFileLoader):
    """A module with one chain re-associated."""

    chosen = -1

    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> CodeType:
        """Compile what was changed."""
        tree = ReAssociated(self.chosen).visit(ast.parse(data))
        return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)

    def get_code(self, fullname: str) -> CodeType:
        """Never from a cache."""
        path = self.get_filename(fullname)
        return self.source_to_code(self.get_data(path), path)


class Finder(MetaPathFinder):
    """Gives one module another loader."""

    def __init__(self, module: str, chosen: int) -> None:
        self._module, self._chosen = module, chosen

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The module that is changed, and no other."""
        if fullname != self._module:
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        assert spec is not None
        assert spec.origin is not None
        spec.loader = Loader(fullname, spec.origin)
        spec.loader.chosen = self._chosen
        return spec


def chains(module: str) -> list[tuple[int, str]]:
    """(line, text) of every chain in a module."""
    spec = importlib.util.find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    found = ReAssociated(-1)
    found.visit(ast.parse(Path(spec.origin).read_text(encoding="utf-8")))
    return found.seen


def noticed(module: str, chosen: int) -> int:
    """What differs with that chain re-associated: `DECISIONS`, only `NUMBERS`, or 0; in a process of its own."""
    words = [sys.executable, "-m", "tests.proofs.reassociation", "--changed", module, str(chosen)]
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    if ended.returncode not in (0, DECISIONS, NUMBERS):
        raise RuntimeError(ended.stderr)
    return ended.returncode


def changed(module: str, chosen: int) -> int:
    """The same, in a fresh process."""
    sys.meta_path.insert(0, Finder(module, chosen))
    from fleet.sim.lockstep_reference import compare, unlike_numbers

    if not all(one.same for one in compare(REFERENCE).values()):
        return DECISIONS
    return NUMBERS if unlike_numbers(REFERENCE) else 0


def main(argv: list[str]) -> int:
    """Every chain of the laws; 0 if all are noticed."""
    if argv[:1] == ["--changed"]:
        return changed(argv[1], int(argv[2]))
    total, seen = 0, Counter[int]()
    for module in argv or LAWS:
        found = chains(module)
        verdicts = [noticed(module, i) for i in range(len(found))]
        count = Counter(verdicts)
        total, seen = total + len(found), seen + count
        print(f"{module}: of {len(found)} {count[DECISIONS]} by decisions, {count[NUMBERS]} by numbers", flush=True)
        for (line, text), verdict in zip(found, verdicts, strict=True):
            if not verdict:
                print(f"  not noticed: line {line}: {text}", flush=True)
    print(f"of {total}: {seen[DECISIONS]} by decisions, {seen[NUMBERS]} by numbers, {seen[0]} not")
    return 0 if not seen[0] else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
