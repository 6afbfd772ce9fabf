"""Trees of numbers, as recorded, compared to the last bit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any


def filled(base: Any, tree: Any) -> Any:
    """The tree, with what only `base` has."""
    if isinstance(base, dict) and isinstance(tree, dict):
        return {**base, **{key: filled(base.get(key), value) for key, value in tree.items()}}
    return tree


def unlike(a: Any, b: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """(field, value in a, value in b) wherever two trees of numbers differ in a bit, of the fields that both have.

    A field that the other version does not know is no difference of decision.
    """
    if isinstance(a, dict) and isinstance(b, dict):
        for key in a:
            if key in b:
                yield from unlike(a[key], b[key], f"{name}.{key}" if name else str(key))
    elif isinstance(a, list | tuple) and isinstance(b, list | tuple):
        if len(a) != len(b):
            yield f"{name}.length", len(a), len(b)
        for i, (one, other) in enumerate(zip(a, b, strict=False)):
            yield from unlike(one, other, f"{name}.{i}")
    elif not _same(a, b):
        yield name, a, b


def _same(a: Any, b: Any) -> bool:
    """Equal to the last bit: -0.0 is not 0.0, NaN is NaN."""
    if isinstance(a, int | float) and isinstance(b, int | float):
        return (a == b and math.copysign(1.0, a) == math.copysign(1.0, b)) or (a != a and b != b)  # noqa: PLR0124
    return bool(a == b)
