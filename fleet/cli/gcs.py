"""`fleet gcs`: every boat of a fleet as a MAVLink vehicle, for ground stations."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fleet.cli import say
from fleet.cli.ending import Ending
from fleet.cli.options import Connect, Credentials, FleetName, Insecure, Link

DEFAULT = "udp:127.0.0.1:14550"


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command("gcs")(gcs)


def gcs(
    endpoint: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ENDPOINT",
            help=f"udp:HOST:PORT or udpin:HOST:PORT (listen), several times or with commas.  [default: {DEFAULT}]",
        ),
    ] = None,
    autopilot: Annotated[
        str, typer.Option(metavar="ardupilot|generic", help="What boats pass for in HEARTBEATs.")
    ] = "ardupilot",
    sysid: Annotated[list[str] | None, typer.Option(metavar="BOAT=N", help="A boat's system id, 1 to 250.")] = None,
    template: Annotated[
        str, typer.Option(metavar="MISSION", help="Roster, limits, fence and home for uploaded missions.")
    ] = "",
    signing_key: Annotated[
        str, typer.Option(metavar="FILE", help="With a passphrase: sign, and hear only signed.")
    ] = "",
    state_dir: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Where system ids are kept.  [default: ~/.local/state/fleet]")
    ] = None,
    fleet: FleetName = "demo",
    connect: Connect = None,
    operator: Annotated[
        str,
        typer.Option(
            envvar="FLEET_OPERATOR", metavar="NAME", help="Who commands.  [default: gcs, or as the credentials say]"
        ),
    ] = "",
    credentials: Credentials = None,
    insecure: Insecure = False,
) -> None:
    """Show every boat to QGroundControl, Mission Planner or MAVProxy, until SIGTERM or Ctrl-C.

    Uploaded missions become paths, modes and arming become commands of this operator. Prints a line for each boat.
    """
    from fleet.gcs import sysids
    from fleet.gcs.run import ANSWER_S, GcsConfig, Process

    mission = None
    if template:
        from fleet.mission.load import load

        mission = load(template)
    config = GcsConfig(
        endpoints=tuple(part for text in endpoint or [DEFAULT] for part in text.split(",") if part),
        autopilot=autopilot,
        sysids=sysids.parse(list(sysid or [])),
        signing_key=signing_key,
        insecure=insecure,
        template=mission,
        folder=state_dir or Path.home() / ".local" / "state" / "fleet",
    )
    for warning in config.check():
        say.error(warning)
    reach = Link(fleet, connect, operator, ANSWER_S, credentials, insecure)
    who = operator or ("" if reach.folder else "gcs")
    with reach._replace(operator=who).open() as link:
        process = Process(config, link, say.out)
        ending = Ending()
        say.out(f"fleet {fleet} at {', '.join(config.endpoints)} as operator {link.operator}; Ctrl-C ends it")
        process.run(ending.told)
    raise typer.Exit(ending.exit_code)
