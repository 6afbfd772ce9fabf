"""Two sweeps side by side; case by case where both sailed the same scenarios."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np

from fleet.ops import FloatArray
from fleet.sim.batch import Results
from fleet.sim.sweep.family import case_name
from fleet.sim.sweep.store import Store, Sweep
from fleet.sim.sweep.table import Figures, figures

JUDGING = ("title", "name", "checks", "keeping_clear", "cases", "boats", "seed", "grid")
"""Keys of a family file that do not say what boats meet; numbers are compared by themselves, points by their labels."""
EQUAL_M, EQUAL_S = 0.005, 0.05  # changes below are none


def compare(a: Store, b: Store) -> dict[str, Any]:
    """Figures of both, and what became of the cases that both sailed.

    Returns:
        `comparable`, `why` (not), `a` and `b` (what they are), `points` (label, figures of both, `paired`), `together`
    """
    why = differences(a.sweep, b.sweep)
    results_a, results_b = by_label(a), by_label(b)
    labels = list(dict.fromkeys([*results_a, *results_b]))
    points = []
    for label in labels:
        one, other = results_a.get(label), results_b.get(label)
        points.append(
            {
                "label": label,
                "a": figures([one]) if one is not None else None,
                "b": figures([other]) if other is not None else None,
                "paired": None if why or one is None or other is None else paired([one], [other]),
            }
        )
    both = [label for label in labels if label in results_a and label in results_b]
    pairs = [results_a[label] for label in both], [results_b[label] for label in both]
    return {
        "comparable": not why,
        "why": why,
        "a": _said(a, results_a),
        "b": _said(b, results_b),
        "points": points,
        "together": {
            "a": figures(list(results_a.values())) if results_a else None,
            "b": figures(list(results_b.values())) if results_b else None,
            "paired": paired(*pairs) if both and not why else None,
        },
        "worse": [] if why else _turned(b, results_a, results_b),
        "better": [] if why else _turned(a, results_b, results_a),
    }


def by_label(store: Store) -> dict[str, Results]:
    """Results of the points that are there, by their label."""
    return {
        label: one for label, one in zip(store.sweep.points, store.results(), strict=True) if one is not None
    }  # fmt: skip


def differences(a: Sweep, b: Sweep) -> list[str]:
    """Why the cases of two sweeps are not the same scenarios; none if they are."""
    why = []
    if a.family != b.family:
        why.append(f"families {a.family} and {b.family}")
    elif _scenario(a.text) != _scenario(b.text):
        keys = sorted(
            k for k in {*_scenario(a.text), *_scenario(b.text)} if _scenario(a.text).get(k) != _scenario(b.text).get(k)
        )
        why.append(f"family {a.family} with other scenarios: {', '.join(keys)}")
    in_a, in_b = dict(zip(a.points, a.boats, strict=True)), dict(zip(b.points, b.boats, strict=True))
    if any(in_a[label] != in_b[label] for label in in_a if label in in_b):
        why.append(f"{a.most_boats} and {b.most_boats} boats")
    if a.seed != b.seed:
        why.append(f"seeds {a.seed} and {b.seed}")
    if not set(a.points) & set(b.points):
        why.append("no point of the grid in common")
    return why


def _scenario(text: str) -> dict[str, Any]:
    return {key: value for key, value in tomllib.loads(text).items() if key not in JUDGING}


def _said(store: Store, results: dict[str, Results]) -> Figures:
    sweep = store.sweep
    return {
        "folder": str(store.folder),
        "family": sweep.family,
        "method": ", ".join(dict.fromkeys(one.method for one in results.values())) or sweep.method,
        "boats": sweep.most_boats,
        "seed": sweep.seed,
        "cases": sum(len(one.case) for one in results.values()),
        "of": sweep.total,
        "laws": sweep.laws,
    }


def paired(a: list[Results], b: list[Results]) -> Figures:
    """What changed from `a` to `b`, over the cases that both have.

    `collisions` and `standstills`: in both, only in a, only in b. Changes are b less a: of the least separation of a
    case, and of the delay of a boat that arrived in both.
    """
    rows = [_common(one, other) for one, other in zip(a, b, strict=True)]

    def both(name: str) -> tuple[FloatArray, FloatArray]:
        return (
            np.concatenate([np.ravel(getattr(one, name)[i]) for one, (i, _) in zip(a, rows, strict=True)]),
            np.concatenate([np.ravel(getattr(one, name)[j]) for one, (_, j) in zip(b, rows, strict=True)]),
        )

    return {
        "cases": sum(len(i) for i, _ in rows),
        "collisions": _only(*both("collided")),
        "standstills": _only(*both("standstill")),
        "separation": _change(*both("least_m"), EQUAL_M),
        "delay": _change(*both("delay_s"), EQUAL_S),
    }


def _common(a: Results, b: Results) -> tuple[Any, Any]:
    """Rows of the cases that both have, in the same order."""
    _, i, j = np.intersect1d(a.case, b.case, assume_unique=True, return_indices=True)
    return i, j


def _only(a: FloatArray, b: FloatArray) -> dict[str, int]:
    return {
        "both": int((a * b).sum()),
        "only_a": int((a * (1.0 - b)).sum()),
        "only_b": int((b * (1.0 - a)).sum()),
    }


def _change(a: FloatArray, b: FloatArray, equal: float) -> dict[str, float | int | None]:
    """Median change and how many went which way; what is not finite in both is left out."""
    known = np.isfinite(a) & np.isfinite(b)
    change = b[known] - a[known]
    return {
        "number": len(change),
        "median": float(np.median(change)) if len(change) else None,
        "least": float(change.min()) if len(change) else None,
        "most": float(change.max()) if len(change) else None,
        "less": int((change < -equal).sum()),
        "equal": int((abs(change) <= equal).sum()),
        "more": int((change > equal).sum()),
    }


def _turned(of: Store, before: dict[str, Results], after: dict[str, Results]) -> list[str]:
    """Cases that fail in `after` and did not in `before`, as `fleet sim --case` calls them."""
    names = []
    for point in of.family.points:
        one, other = before.get(point.label), after.get(point.label)
        if one is None or other is None:
            continue
        fresh = sorted(set(other.failed.tolist()) & set(one.case.tolist()) - set(one.failed.tolist()))
        names += [case_name(of.family, of.sweep.seed, point.number, case) for case in fresh]
    return names
