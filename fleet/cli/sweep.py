"""`fleet sweep`: a family of scenarios by the thousand, on all cores; kept, resumed, compared."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fleet.cli import say
from fleet.cli.methods import methods
from fleet.cli.options import Json, Runs, short_for, whole
from fleet.cli.sail import INTERRUPTED, interruptible
from fleet.errors import FleetError, RecordingError, UsageError

if TYPE_CHECKING:
    from fleet.sim.sweep.pool import Engine
    from fleet.sim.sweep.run import Ended
    from fleet.sim.sweep.store import Store

MOST_JOBS = 256


app = typer.Typer(
    cls=short_for("run"),
    help="Families of scenarios by the thousand: fleet sweep FAMILY sails one.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
FamilyName = Annotated[str, typer.Argument(metavar="FAMILY", help="A file, or a ready family: fleet sweep list")]
Which = Annotated[str, typer.Argument(metavar="SWEEP", help="A folder, its name or how it begins, a family, or last.")]


@app.command()
def run(
    family: Annotated[
        str | None, typer.Argument(metavar="FAMILY", help="A file, or a ready family: fleet sweep list")
    ] = None,
    boats: Annotated[int | None, typer.Option(metavar="N", parser=whole, help="Boats of a scenario.")] = None,
    cases: Annotated[
        int | None, typer.Option(metavar="N", parser=whole, help="Scenarios of each point of the grid.")
    ] = None,
    seed: Annotated[int | None, typer.Option(metavar="S", parser=whole, help="Seed of all that is drawn.")] = None,
    method: Annotated[str | None, typer.Option(metavar="NAME", help="How boats keep clear: scoring, circle.")] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the family.")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(metavar="J", parser=whole, help="Processes.  [default: one a core]")
    ] = None,
    dask: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Sail on a Dask cluster: tcp://HOST:PORT, or local:N.")
    ] = None,
    resume: Annotated[
        str | None, typer.Option(metavar="SWEEP", help="Sail what is missing of a sweep: its folder, or last.")
    ] = None,
    json: Json = False,
    picture: Annotated[bool, typer.Option("--picture/--no-picture", help="Draw report.html.")] = True,
    runs: Runs = None,
) -> None:
    """Sail a family of scenarios; the word `run` may be left out.

    What has been sailed is kept at once: a sweep that was interrupted goes on with --resume, and ends as if it had not
    been. Exit code 0 if the family's checks hold, 1 otherwise.
    """
    if jobs is not None and not 1 <= jobs <= MOST_JOBS:
        raise UsageError(f"--jobs {jobs}: expected 1 to {MOST_JOBS}")
    if jobs is not None and dask is not None:
        raise UsageError("--jobs and --dask: expected one of them; the cluster has its own number of processes")
    engine = _engine(jobs, dask)
    if resume is not None:
        given = {"FAMILY": family, "--boats": boats, "--cases": cases, "--seed": seed, "--method": method}
        wrong = [name for name, value in {**given, "--set": set_ or None}.items() if value is not None]
        if wrong:
            raise UsageError(f"--resume goes on with what the sweep is: expected no {', '.join(wrong)} with it")
        from fleet.sim.sweep.store import find

        store = find(resume, runs)
    elif family is None:
        raise UsageError("expected a FAMILY (fleet sweep list names the ready ones), or --resume SWEEP")
    else:
        from fleet.sim.sweep.family import load
        from fleet.sim.sweep.store import Sweep, create

        made = load(family, set_ or [], boats=boats, cases=cases, seed=seed, method=method)
        store = create(runs, Sweep.of(made, shlex.join(["fleet", *sys.argv[1:]])))
    raise typer.Exit(_sail(store, engine, json, picture))


def _engine(jobs: int | None, dask: str | None) -> Engine:
    if dask is not None:
        from fleet.sim.sweep.cluster import dask as on_cluster

        return on_cluster(dask)
    from fleet.sim.sweep.pool import cores, local

    return local(cores() if jobs is None else jobs)


def _sail(store: Store, engine: Engine, json: bool, picture: bool) -> int:
    """Sail, judge, tell; the exit code."""
    from fleet.cli.progress import watcher
    from fleet.sim.sweep.run import sail

    parts, boats = say.count(len(store.sweep.parts), "part"), say.count(store.sweep.most_boats, "boat")
    say.note(f"{store.family.title}: {store.sweep.total} cases of {boats} in {parts}")
    with interruptible():
        try:
            with watcher() as look:
                ended = sail(store, engine, look)
        except KeyboardInterrupt:
            say.note("interrupted")
            _tell_how_to_resume(store)
            return INTERRUPTED
        except UsageError:
            raise
        except FleetError as error:
            say.error(str(error))
            _tell_how_to_resume(store)
            return error.exit_code
        for one in ended.damaged:
            say.warning(f"sailed again: {one}")
        for lost in ended.lost:
            say.error(f"{lost.part}: not sailed: {lost.why}")
        return _judge(store, ended, json, picture)


def _tell_how_to_resume(store: Store) -> None:
    left, _ = store.missing()
    whole = len(store.sweep.parts)
    say.note(f"kept: {whole - len(left)} of {whole} parts, in {store.folder}")
    say.hint(f"fleet sweep --resume {shlex.quote(str(store.folder))}")


def _judge(store: Store, ended: Ended, json: bool, picture: bool) -> int:
    """Figures, page and verdict."""
    import json as json_

    from fleet.sim.sweep.store import write_text
    from fleet.sim.sweep.table import summary

    results = store.results()
    found = summary(store, results, ended)
    try:
        write_text(store.summary_file, json_.dumps(found, indent=1, ensure_ascii=False) + "\n")
        if picture:
            from fleet.sim.sweep.page import write_page

            write_page(store, results, found)
    except RecordingError as error:
        say.error(str(error))
        _tell_how_to_resume(store)
        return error.exit_code
    if json:
        say.out_json(found)
    else:
        from fleet.cli.swept import print_sweep

        print_sweep(store, found, picture)
    if not found["complete"]:
        _tell_how_to_resume(store)
    return 0 if found["passed"] else 1


app.command("methods")(methods)


# -- looking -----------------------------------------------------------------------------------------------------------
@app.command("list")
def list_(json: Json = False, runs: Runs = None) -> None:
    """The families that come with fleet, and the sweeps that were sailed."""
    from fleet.sim.sweep.family import ready
    from fleet.sim.sweep.store import sweeps

    families, sailed = dict(ready()), [_brief(folder) for folder in sweeps(runs)]
    if json:
        rows = [{"name": name, "title": title} for name, title in families.items()]
        say.out_json({"families": rows, "sweeps": sailed})
        return
    for line in say.aligned(families.items()):
        say.out(line)
    words = {True: "passed", False: "FAILED", None: "not ended"}
    if sailed:
        say.out("\nsailed")
    for line in say.aligned([(row["sweep"], words[row["passed"]]) for row in sailed], indent="  "):
        say.out(line)


def _brief(folder: Path) -> dict[str, Any]:
    import json

    try:
        passed = json.loads((folder / "summary.json").read_text(encoding="utf-8")).get("passed")
    except (OSError, ValueError, AttributeError):
        passed = None
    return {"sweep": folder.name, "folder": str(folder), "passed": passed if isinstance(passed, bool) else None}


@app.command()
def show(family: FamilyName) -> None:
    """Print the file of a family, to copy and change."""
    from fleet.sim.sweep.family import load

    say.out(load(family).text.rstrip("\n"))


@app.command()
def compare(a: Which, b: Which, json: Json = False, runs: Runs = None) -> None:
    """Two sweeps side by side; case by case where both sailed the same scenarios."""
    from fleet.sim.sweep.compare import compare as compare_sweeps
    from fleet.sim.sweep.store import find

    found = compare_sweeps(find(a, runs), find(b, runs))
    if json:
        say.out_json(found)
        return
    from fleet.cli.swept import compared

    for line in compared(found):
        say.out(line)
