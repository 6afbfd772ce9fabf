"""Suites of meetings with foreign vessels, named on the command line: `python -m fleet.sim.batch.ships_table two`."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator, Sequence

from fleet.sim.batch import ships_cases
from fleet.sim.batch.ships import ShipCase
from fleet.sim.batch.ships_judge import run_suite

SUITES: dict[str, Callable[[int, int], Iterator[ShipCase]]] = {
    "two": ships_cases.two,
    "two-exact": lambda seed, count: ships_cases.two(seed, count, "exact"),
    "two-ais": lambda seed, count: ships_cases.two(seed, count, "ais"),
    "two-positions": lambda seed, count: ships_cases.two(seed, count, "positions"),
    "several": ships_cases.several,
    "imazu-1": lambda seed, count: ships_cases.imazu(seed, 1.0, repeat=max(count // 22, 1)),
    "imazu-2": lambda seed, count: ships_cases.imazu(seed, 2.0, repeat=max(count // 22, 1)),
    "imazu-5": lambda seed, count: ships_cases.imazu(seed, 5.0, repeat=max(count // 22, 1)),
    "imazu-1-ais": lambda seed, count: ships_cases.imazu(seed, 1.0, "ais", max(count // 22, 1)),
    "imazu-1-positions": lambda seed, count: ships_cases.imazu(seed, 1.0, "positions", max(count // 22, 1)),
    "sudden": ships_cases.sudden,
    "sudden-exact": lambda seed, count: ships_cases.sudden(seed, count, "exact"),
    "stopped": ships_cases.stopped,
    "open": lambda seed, count: ships_cases.channel(seed, count, math.inf),
    "bank-15": lambda seed, count: ships_cases.channel(seed, count, longest=15.0),
    "bank-60": ships_cases.channel,
    "column-3": ships_cases.formation,
    "abreast-3": lambda seed, count: ships_cases.formation(seed, count, abreast=True),
    "column-5": lambda seed, count: ships_cases.formation(seed, count, 5),
    "abreast-5": lambda seed, count: ships_cases.formation(seed, count, 5, True),
}
"""Suites by name: (seed, number of scenarios) -> scenarios."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Sail the suites that are named and print their figures."""
    parser = argparse.ArgumentParser(prog="python -m fleet.sim.batch.ships_table", description=__doc__)
    parser.add_argument("suite", nargs="+", choices=SUITES, metavar="SUITE", help=", ".join(SUITES))
    parser.add_argument("--count", type=int, default=20, help="scenarios of each suite (default 20)")
    parser.add_argument("--seed", type=int, default=1, help="default 1")
    given = parser.parse_args(arguments)
    for name in given.suite:
        for label, figure in run_suite(SUITES[name](given.seed, given.count)).figures().items():
            print(f"{label:>22}  {round(figure, 2) if isinstance(figure, float) else figure}")
        print()


if __name__ == "__main__":
    main()
