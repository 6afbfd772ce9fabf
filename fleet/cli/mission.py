"""`fleet mission`: what missions there are, what is in one, and what is wrong with one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fleet.cli import say
from fleet.cli.options import Json, Set, whole
from fleet.errors import MissionError, UsageError

if TYPE_CHECKING:
    from fleet.mission.plan import Plan

app = typer.Typer(
    help="Mission files: list the ready ones, show and check one.", no_args_is_help=True, rich_markup_mode=None
)
Which = Annotated[str, typer.Argument(metavar="MISSION", help="A file, or a ready mission.")]
PICTURES = (".png", ".svg", ".pdf")


@app.command("list")
def list_(json: Json = False) -> None:
    """The missions that come with fleet."""
    from fleet.mission.load import ready

    if json:
        say.out_json([{"name": name, "title": title} for name, title in ready().items()])
        return
    for line in say.aligned(ready().items()):
        say.out(line)


@app.command()
def show(
    mission: Which,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Draw it: .png, .svg or .pdf.")] = None,
    text: Annotated[bool, typer.Option("--text", help="Print the file itself, to copy and change.")] = False,
    set_: Set = None,
    boats: Annotated[int | None, typer.Option(metavar="N", parser=whole, help="As it would be with N boats.")] = None,
) -> None:
    """What is in a mission: paths, boats, formation, timeline and checks; with --out, a picture."""
    if out is not None and out.suffix not in PICTURES:
        raise UsageError(f"--out {out}: expected a name that ends in {', '.join(PICTURES)}")
    if text:
        from fleet.mission.load import text_of

        say.out(text_of(mission).rstrip("\n"))
        if out is None:
            return
    from fleet.cli.sail import read_mission
    from fleet.mission.plan import build

    plan = build(read_mission(mission, list(set_ or []), boats))
    if out is not None:
        from fleet.mission.picture import picture

        try:
            say.note(f"drawn: {picture(plan, out)}")
        except OSError as error:
            raise UsageError(f"--out {out}: {error.strerror or error}") from None
    if text:
        return
    for line in _described(plan):
        say.out(line)
    if out is None:
        say.hint("--out FILE.png draws it, --text prints the file")


def _described(plan: Plan) -> Iterator[str]:
    from fleet.mission.pattern import PATTERNS

    mission = plan.mission
    yield say.paint(mission.title, "bold")
    yield f"datum {mission.datum.lat_deg:.5f}, {mission.datum.lon_deg:.5f} deg; {mission.duration_s:g} s"
    clear = mission.keeping_clear
    shape = plan.shape
    abeam = f", lateral {shape.lateral_m:g} m" if PATTERNS[shape.pattern].lateral else ""
    yield f"formation: {shape.pattern}, spacing {shape.spacing_m:g} m{abeam}, cruise {shape.cruise_mps:g} m/s"
    yield f"keeping clear: {clear.method}, radius {clear.radius_m:g} m; fence: {'yes' if mission.fence else 'none'}"
    yield "\npaths"
    rows = [
        (name, mission.paths[name].__class__.__name__.lower(), f"{path.length:.1f} m", "closed" if path.closed else "")
        for name, path in plan.paths.items()
    ]
    yield from say.aligned(rows, right=(2,), indent="  ")
    yield "\nboats"
    table = [("boat", "path", "slot", "begins at", "hull", "m/s")]
    for boat, planned in zip(mission.boats, plan.boats, strict=True):
        speeds = f"{boat.limits.speed_min_mps:g} to {boat.limits.speed_max_mps:g}"
        late = " (late)" if planned.starts_late else ""
        table.append((boat.name, boat.path, f"{boat.slot:g}", f"s = {planned.s:.1f} m{late}", boat.hull, speeds))
    yield from say.aligned(table, right=(2,), indent="  ")
    if mission.timeline:
        yield "\ntimeline"
        events = sorted(mission.timeline, key=lambda event: event.at_s)
        lines = [
            (f"{e.at_s:g} s", e.do, "" if e.value is None else f"{e.value:g}", ", ".join(e.boats) or "all")
            for e in events
        ]
        yield from say.aligned(lines, right=(0, 2), indent="  ")
    if mission.checks:
        from fleet.mission.checks import CHECKS

        yield "\nchecks"
        checks = [
            (name, f"{CHECKS[name].direction} {limit:g} {CHECKS[name].unit}") for name, limit in mission.checks.items()
        ]
        yield from say.aligned(checks, indent="  ")


@app.command()
def check(mission: Which, set_: Set = None, json: Json = False) -> None:
    """Say everything that is wrong with a mission; exit code 2 if it cannot be sailed."""
    from fleet.mission.load import examine

    title, boats = "", 0
    warnings: tuple[str, ...] = ()
    try:
        found, findings = examine(mission, list(set_ or []))
        title, boats, problems, warnings = found.title, len(found.boats), findings.problems, findings.warnings
    except MissionError as error:
        problems = error.problems
    if json:
        answer = {"mission": mission, "title": title or None, "ok": not problems}
        say.out_json({**answer, "problems": list(problems), "warnings": list(warnings)})
    else:
        for one in warnings:
            say.warning(f"{mission}: {one}")
        for one in problems:
            say.error(f"{mission}: {one}")
        if not problems:
            say.out(f"{mission}: ok: {title} ({say.count(boats, 'boat')}, {say.count(len(warnings), 'warning')})")
    raise typer.Exit(UsageError.exit_code if problems else 0)
