"""`fleet run`: runs that were sailed, their figures, reports, and what a crash left of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fleet.cli import say
from fleet.cli.options import Json, Runs
from fleet.errors import FleetError, RecordingError

if TYPE_CHECKING:
    from fleet.analysis.metrics import Summary
    from fleet.recording.runs import Run

app = typer.Typer(
    help="Runs that were sailed: list, show, report, replay, repair.", no_args_is_help=True, rich_markup_mode=None
)
Which = Annotated[
    str, typer.Argument(metavar="RUN", help="A folder, its name or how it begins, a mission's name, or last.")
]
Lanes = Annotated[
    int,
    typer.Option(
        metavar="N", min=0, max=100_000, help="Decide every tick as one lane of a batch of N, too.", show_default=False
    ),
]
REPAIRED = "repaired"


@app.command("list")
def list_(json: Json = False, runs: Runs = None) -> None:
    """The runs, oldest first, and whether their checks held."""
    from fleet.recording.runs import list_runs

    rows = [_brief(run) for run in list_runs(runs)]
    if json:
        say.out_json(rows)
        return
    if not rows:
        say.note("no runs yet: fleet sim overtaking")
        return
    words = {True: "passed", False: "FAILED", None: "not judged"}
    for line in say.aligned((row["run"], words[row["passed"]], f"{row['kilobytes']} kB") for row in rows):
        say.out(line)


def _brief(run: Run) -> dict[str, Any]:
    """Without reading the recording: a list must be quick."""
    import json

    from fleet.recording.runs import recordings

    try:
        tree = json.loads(run.summary_file.read_text(encoding="utf-8"))
        passed, title = tree.get("passed"), tree.get("mission")
    except (OSError, ValueError, AttributeError):
        passed, title = None, None
    size = sum(path.stat().st_size for path in recordings(run))
    passed = passed if isinstance(passed, bool) else None
    return {"run": run.name, "folder": str(run.folder), "mission": title, "passed": passed, "kilobytes": size // 1024}


def _summary(run: Run) -> Summary:
    from fleet.analysis.metrics import summarise

    return summarise(run.folder)


@app.command()
def replay(run: Which = "last", lanes: Lanes = 0, json: Json = False, runs: Runs = None) -> None:
    """Give what the boats recorded to their laws again, and say where they decide otherwise; exit code 1 if they do.

    RUN may also be one boat's recording, a .mcap file.
    """
    from fleet.analysis.replay import replay as replay_run
    from fleet.recording.runs import find

    where = Path(run)
    replayed = replay_run(where if where.suffix == ".mcap" else find(runs, run).folder, lanes)
    if json:
        say.out_json(replayed.as_json())
    else:
        for line in replayed.lines():
            say.out(line)
    raise typer.Exit(replayed.exit_code)


@app.command()
def show(run: Which = "last", json: Json = False, runs: Runs = None) -> None:
    """The figures and checks of a run, computed from its recording."""
    from fleet.recording.runs import find

    summary = _summary(find(runs, run))
    if json:
        import msgspec

        say.out(msgspec.json.encode(summary).decode())
        return
    from fleet.cli.summary import print_summary

    print_summary(summary)
    say.out(f"run  {summary.run}")


@app.command()
def report(
    run: Which = "last",
    paper: Annotated[
        bool, typer.Option("--paper", help="Also paper.png: the figures in the manner of Bibuli et al. (2014).")
    ] = False,
    json: Json = False,
    runs: Runs = None,
) -> None:
    """Write summary.json, picture.png and report.html of a run into its folder."""
    from fleet.analysis.figures import draw
    from fleet.analysis.figures_paper import draw_paper
    from fleet.analysis.metrics import summarise, write_summary
    from fleet.analysis.report import write_report
    from fleet.analysis.series import load
    from fleet.recording.runs import find

    found = find(runs, run)
    series = load(found.folder, empty=True)
    summary = summarise(found.folder, series=series)
    write_summary(summary, found.summary_file)
    written = {"summary": found.summary_file}
    try:
        written["picture"] = draw(found.folder, found.folder / "picture.png", series)
        if paper:
            written["paper"] = draw_paper(found.folder, found.folder / "paper.png", series)
    except FleetError as error:
        say.hint(str(error))
    written["report"] = write_report(found.folder, None, summary, series)
    if json:
        say.out_json({"run": str(found.folder), **{what: str(path) for what, path in written.items()}})
        return
    for line in say.aligned([(what, str(path)) for what, path in written.items()]):
        say.out(line)


@app.command()
def repair(run: Which = "last", json: Json = False, runs: Runs = None) -> None:
    """Write what a crash left of a run's recordings into new files with an index; the old ones stay as they are."""
    from fleet.recording.runs import find, recordings

    found = find(runs, run)
    files = recordings(found)
    if not files:
        raise RecordingError(f"{found.folder}: no recording in it")
    rows = [_repaired(found, path) for path in files]
    if json:
        say.out_json({"run": str(found.folder), "recordings": rows})
    else:
        for row in rows:
            say.out(_words(row))
    raise typer.Exit(1 if any(row["state"] == "unreadable" for row in rows) else 0)


def _repaired(run: Run, path: Path) -> dict[str, Any]:
    """What was done about one recording."""
    from fleet.recording.reader import RecordingFile
    from fleet.recording.reader import repair as repair_file

    row: dict[str, Any] = {"recording": str(path), "state": "whole"}
    try:
        with RecordingFile(path) as file:
            row["messages"] = file.message_count
            for _ in file.messages():  # an index does not know of bad chunks before they are read
                pass
            if file.whole and not file.bad_chunks:
                return row
        target = run.folder / REPAIRED / path.relative_to(run.folder)
        if target.exists():
            return {**row, "state": "repaired before", "repaired": str(target)}
        done = repair_file(path, target)
    except RecordingError as error:
        return {**row, "state": "unreadable", "why": str(error)}
    return {
        **row,
        "state": "repaired",
        "repaired": str(done.path),
        "messages": done.messages,
        "lost_tail_bytes": done.lost_tail_bytes,
        "bad_chunks": done.bad_chunks,
    }


def _words(row: dict[str, Any]) -> str:
    if row["state"] == "whole":
        return f"{row['recording']}: whole, {row['messages']} messages"
    if row["state"] == "unreadable":
        return f"{row['recording']}: {row['why']}"
    if row["state"] == "repaired before":
        return f"{row['recording']}: repaired before, {row['repaired']}"
    lost = f"{row['lost_tail_bytes']} bytes at the end and {row['bad_chunks']} chunks lost"
    return f"{row['recording']}: {row['messages']} messages recovered, {lost} -> {row['repaired']}"
