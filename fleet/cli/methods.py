"""`fleet sweep methods`: ways of keeping clear side by side, over many families, in one table."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from fleet.cli import say
from fleet.cli.options import Json, whole
from fleet.cli.sail import INTERRUPTED, interruptible
from fleet.errors import UsageError

MOST_JOBS = 256


def methods(
    families: Annotated[
        list[str] | None,
        typer.Argument(metavar="[FAMILY]...", help="Files, or ready families; all of boats of the fleet if none."),
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option("--method", metavar="NAME", help="A further method, such as one of your own; as often as needed."),
    ] = None,
    way: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Only this one; as often as needed: circle-printed, scoring, ..."),
    ] = None,
    cases: Annotated[
        int, typer.Option(metavar="N", parser=whole, help="Scenarios of each point of a grid, at most.")
    ] = 20,
    seed: Annotated[int | None, typer.Option(metavar="S", parser=whole, help="Seed of all that is drawn.")] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the families.")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(metavar="J", parser=whole, help="Processes.  [default: one a core]")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Keep rows here, and do not sail again what is there.")
    ] = None,
    markdown: Annotated[bool, typer.Option("--markdown", help="Print the table for a page.")] = False,
    json: Json = False,
) -> None:
    """The paper's circle as printed, corrected with either side, and the default, over families, in one table.

    Every method sails the same encounters. What went wrong is figures here, no failure: exit code 0.
    """
    from fleet.sim.sweep.methods import HEADS, cells, chosen, keep_row, read_rows, sail_ways, ways
    from fleet.sim.sweep.methods import markdown as as_markdown
    from fleet.sim.sweep.model import MOST_CASES, MOST_SEED
    from fleet.sim.sweep.pool import cores, local

    if jobs is not None and not 1 <= jobs <= MOST_JOBS:
        raise UsageError(f"--jobs {jobs}: expected 1 to {MOST_JOBS}")
    if not 1 <= cases <= MOST_CASES:
        raise UsageError(f"--cases {cases}: expected 1 to {MOST_CASES}")
    if seed is not None and not 0 <= seed <= MOST_SEED:
        raise UsageError(f"--seed {seed}: expected 0 to {MOST_SEED}")
    overrides = list(set_ or [])
    found = chosen(families or [], overrides, cases)
    known = read_rows(out) if out is not None else []
    keys = {row.key for row in known}
    rows: list[Any] = []
    with interruptible():
        try:
            sailing = sail_ways(found, ways(method or [], way or []), overrides, local(jobs or cores()), seed, known)
            for row in sailing:
                rows.append(row)
                say.note(", ".join(cells(row)))
                if out is not None and row.key not in keys:
                    keep_row(out, row)
        except KeyboardInterrupt:
            say.note("interrupted")
            if out is not None:
                say.hint("the same command goes on with what --out keeps")
            raise typer.Exit(INTERRUPTED) from None
    if json:
        say.out_json([{name: getattr(row, name) for name in row.__struct_fields__} for row in rows])
    elif markdown:
        say.out(as_markdown(rows))
    else:
        for line in say.aligned([HEADS, *map(cells, rows)], indent="  "):
            say.out(line)
