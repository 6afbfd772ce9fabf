"""`fleet sim`: sail a mission with real agents, and judge it."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fleet.cli import say
from fleet.cli.options import Json, Runs, Set, whole
from fleet.errors import FleetError, MissionError, UsageError

if TYPE_CHECKING:
    from fleet.analysis.metrics import Summary
    from fleet.mission.model import Mission
    from fleet.sim.sail import Options, Progress, Sailing, Watcher

SLOWEST, FASTEST = 0.1, 100.0
HUB_PORT = 7447
INTERRUPTED = 130


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command("sim")(sim)


def sim(
    mission: Annotated[
        str | None, typer.Argument(metavar="MISSION", help="A file, or a ready mission: fleet mission list")
    ] = None,
    boats: Annotated[int | None, typer.Option(metavar="N", parser=whole, help="Sail with N boats.")] = None,
    warp: Annotated[float, typer.Option(metavar="K", help="Run all clocks K times as fast, 0.1 to 100.")] = 1.0,
    seed: Annotated[int, typer.Option(metavar="N", parser=whole, help="Seed of noise and radio faults.")] = 0,
    method: Annotated[str | None, typer.Option(metavar="NAME", help="How boats keep clear: scoring, circle.")] = None,
    set_: Set = None,
    topology: Annotated[Literal["hub", "routed"], typer.Option(help="How stations reach each other.")] = "hub",
    keep: Annotated[bool, typer.Option("--keep", help="Sail on until Ctrl-C; other terminals may command.")] = False,
    json: Json = False,
    picture: Annotated[bool, typer.Option("--picture/--no-picture", help="Draw picture.png and report.html.")] = True,
    record: Annotated[
        Literal["full", "none"], typer.Option(help="Without a recording there are no figures and no checks.")
    ] = "full",
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="One process, no clock: as fast as it goes, the same bits every time.")
    ] = False,
    driver: Annotated[
        Literal["simulated", "can", "mavlink"],
        typer.Option(help="Between agent and hull: nothing, a simulated thruster controller (can) or autopilot."),
    ] = "simulated",
    sensors: Annotated[
        Literal["simulated", "nmea"],
        typer.Option(help="How boats sense: by values, or by sentences of NMEA 0183 and AIS that agents read."),
    ] = "simulated",
    case: Annotated[
        str | None,
        typer.Option(metavar="FAMILY:CASE", help="Sail one case of a sweep alone, instead of a mission."),
    ] = None,
    credentials: Annotated[
        str,
        typer.Option(metavar="new|FOLDER", help="Sail over TLS, with signed words: of a new authority, or this one's."),
    ] = "",
    runs: Runs = None,
) -> None:
    """Sail a mission in simulation, with real agents; or, with --case, one case of a sweep.

    Starts a hub, a world and one agent process a boat, and ends them all. Exit code 0 only if all checks of the
    mission hold, 1 otherwise.
    """
    if case is not None:
        given = {"MISSION": mission is not None, "--warp": warp != 1.0, "--seed": seed != 0, "--set": bool(set_),
                 "--topology": topology != "hub", "--driver": driver != "simulated", "--keep": keep,
                 "--sensors": sensors != "simulated",
                 "--lockstep": lockstep, "--credentials": bool(credentials)}  # fmt: skip
        wrong = [name for name, there in given.items() if there]
        if wrong:
            raise UsageError(f"--case {case} says all about what is sailed: expected no {', '.join(wrong)} with it")
        from fleet.cli.case import sail_case

        recorded = record == "full"
        raise typer.Exit(sail_case(case, boats, method, json=json, picture=picture, record=recorded, runs=runs))
    if mission is None:
        raise UsageError("expected a MISSION (fleet mission list names the ready ones), or --case FAMILY:CASE")
    if not SLOWEST <= warp <= FASTEST:
        raise UsageError(f"--warp {warp:g}: expected {SLOWEST:g} to {FASTEST:g}")
    clocked = warp != 1.0 or topology != "hub" or driver != "simulated" or sensors != "simulated"
    if lockstep and (keep or clocked or credentials):
        raise UsageError(
            "--lockstep has neither clock nor network: expected no --warp, --topology, --driver, --sensors, --keep or "
            "--credentials with it"
        )
    from fleet.sim.sweep.model import MOST_SEED

    if not 0 <= seed <= MOST_SEED:
        raise UsageError(f"--seed {seed}: expected 0 to {MOST_SEED}")
    plan = read_mission(mission, list(set_ or []), boats, method)
    from fleet.sim.sail import Options

    port = HUB_PORT if keep and _free(HUB_PORT) else 0
    options = Options(
        warp=warp,
        seed=seed,
        topology=topology,
        record=record == "full",
        driver=driver,
        credentials=credentials,
        sensors=sensors,
        keep=keep,
        hub_port=port,
        root=runs,
    )
    raise typer.Exit(_sail(plan, mission, options, json, picture, lockstep))


def read_mission(where: str, overrides: list[str], boats: int | None = None, method: str | None = None) -> Mission:
    """The mission, with its warnings on stderr; MissionError with every problem."""
    from fleet.mission.load import examine

    plan, findings = examine(where, overrides, boats, method)
    if findings.problems:
        raise MissionError(where, findings.problems)
    for one in findings.warnings:
        say.warning(f"{where}: {one}")
    return plan


def _sail(mission: Mission, name: str, options: Options, json: bool, picture: bool, lockstep: bool) -> int:
    """Sail; the exit code."""
    from fleet.cli.watch import watcher

    began, interrupted = time.monotonic(), False
    last: list[Progress] = []
    with interruptible():
        agents = say.count(len(mission.boats), "agent")
        say.note(f"{agents} in lock-step ..." if lockstep else f"starting {options.topology}, world and {agents} ...")
        watch = watcher(options.warp)

        def look(progress: Progress) -> None:
            last[:] = [progress]
            watch(progress)

        sailing = _sailing(mission, name, options, look, lockstep)
        if not lockstep and options.keep:
            _tell_how_to_command(sailing)
        try:
            with watch:
                sailing.sail()
        except KeyboardInterrupt:
            interrupted = True
            ended = bool(last) and last[0].t_s >= mission.duration_s
            if not (options.keep and ended):
                say.note(f"interrupted; what was sailed: {sailing.run.folder}")
                return INTERRUPTED
    wall_s = time.monotonic() - began
    summary = _judge(sailing, mission, options.record, wall_s, last[0].t_s)
    written = _write(sailing, summary, picture and options.record)
    _report(summary, written, json)
    if interrupted:
        return INTERRUPTED
    return 0 if summary.passed else 1


def _sailing(mission: Mission, name: str, options: Options, look: Watcher, lockstep: bool) -> Any:
    """What sails it: real processes, or one in lock-step."""
    if lockstep:
        from fleet.sim.lockstep import LockstepSailing

        return LockstepSailing(mission, name, options, look)
    from fleet.sim.sail import Sailing

    return Sailing(mission, name, options, look)


@contextmanager
def interruptible() -> Iterator[None]:
    """SIGINT, SIGTERM and SIGHUP interrupt once; while everything ends, further ones are ignored."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def interrupt(*_: object) -> None:
        for number in numbers:
            signal.signal(number, signal.SIG_IGN)
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _free(port: int) -> bool:
    import socket

    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def _tell_how_to_command(sailing: Sailing) -> None:
    from fleet.sim.sail import FLEET

    endpoint = sailing.processes.connect[0]
    say.note(f"from another terminal: export FLEET_FLEET={FLEET} FLEET_CONNECT={endpoint}")
    if sailing.credentials is not None:
        from fleet.sim.sail import OPERATOR

        say.note(f"and export FLEET_CREDENTIALS={sailing.credentials / OPERATOR} FLEET_OPERATOR={OPERATOR}")
    say.note("to look: fleet status --watch; to command: fleet take, then fleet set spacing 15")


def _judge(sailing: Sailing, mission: Mission, recorded: bool, wall_s: float, t_s: float) -> Summary:
    """The figures; without a recording there are none, and no check holds."""
    from fleet.analysis.metrics import FIGURES, Summary, summarise
    from fleet.mission.checks import evaluate

    if recorded:
        return summarise(sailing.run.folder, wall_s)
    say.warning("not recorded: no figures, and the checks cannot be judged")
    figures: dict[str, Any] = {**dict.fromkeys(FIGURES), "simulated_s": t_s, "wall_s": wall_s}
    checks = list(evaluate(mission.checks, {}))
    return Summary(
        mission=mission.title,
        passed=not checks,
        checks=checks,
        boats=[boat.name for boat in mission.boats],
        run=str(sailing.run.folder),
        **figures,
    )


def _write(sailing: Sailing, summary: Summary, drawn: bool) -> list[tuple[str, Path]]:
    """Write what belongs into the run's folder; (what, where)."""
    from fleet.analysis.metrics import write_summary

    run = sailing.run
    write_summary(summary, run.summary_file)
    written = [("run", run.folder)]
    if not drawn:
        return written
    from fleet.analysis.figures import draw
    from fleet.analysis.report import write_report
    from fleet.analysis.series import load

    series = load(run.folder)
    try:
        written.append(("picture", draw(run.folder, run.folder / "picture.png", series)))
    except FleetError as error:
        say.hint(str(error))
    written.append(("report", write_report(run.folder, None, summary, series)))
    return written


def _report(summary: Summary, written: list[tuple[str, Path]], json: bool) -> None:
    from fleet.cli.summary import print_summary

    if json:
        import msgspec

        say.out(msgspec.json.encode(summary).decode())
        return
    say.note("")
    print_summary(summary)
    for line in say.aligned([(what, str(where)) for what, where in written]):
        say.out(line)
