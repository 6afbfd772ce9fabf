"""`fleet agent`: the agent itself, its configuration checked, and the service that runs it."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from fleet.cli import say
from fleet.cli.options import Json, short_for
from fleet.errors import ConfigError, FleetError

app = typer.Typer(
    cls=short_for("run", bare=True),
    help="Be one boat's agent: fleet agent --config FILE; its options: fleet agent run --help.",
    rich_markup_mode=None,
)

ConfigFile = Annotated[Path, typer.Argument(metavar="FILE", help="The boat's configuration, in TOML.")]


@app.command("check")
def check(file: ConfigFile, json: Json = False) -> None:
    """Check a boat's configuration and start nothing; exit code 2 with every misfit.

    Only the file counts, not the environment. What a library or a device has to say is asked by `fleet doctor`.
    """
    from fleet.agent.config import load_config

    try:
        config = load_config(file, {}, {})
    except ConfigError as error:
        if json:
            say.out_json({"file": str(file), "fit": False, "misfits": str(error).splitlines()})
            raise typer.Exit(error.exit_code) from None
        raise
    if json:
        import msgspec

        say.out_json({"file": str(file), "fit": True, "config": msgspec.to_builtins(config)})
    else:
        say.out(f"{file}: boat {config.boat} of fleet {config.fleet}, driver {config.driver.kind}")
        from fleet.wire.link import warning

        if warning(config.link):
            say.warning(warning(config.link))


@app.command("install-service")
def install_service(
    config: Annotated[Path, typer.Option(envvar="FLEET_CONFIG", metavar="FILE", help="The boat's TOML file.")],
    apply: Annotated[bool, typer.Option("--apply", help="Write it below /etc and tell systemd.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite what somebody else wrote.")] = False,
    user: Annotated[str, typer.Option(metavar="NAME", help="Who runs it; fleet is made if need be.")] = "fleet",
    root: Annotated[Path, typer.Option(metavar="DIR", help="Write below this folder, for an image.")] = Path("/"),
) -> None:
    """Print the systemd unit of a boat's agent; with --apply install it.

    The unit names this `fleet` and the file given. It starts nothing: systemctl enable --now does.
    """
    from fleet.agent.config import load_config
    from fleet.agent.service import install, service_of

    service = service_of(load_config(config, {}, {}), config, _program(), user)
    if not apply:
        say.out(service.text.rstrip("\n"))
        return
    root = root.absolute()
    if root == Path("/") and os.geteuid() != 0:
        raise FleetError(f"--apply writes to /etc/systemd/system, which needs root: sudo {_program()} agent ...")
    for line in install(service, root, force=force):
        say.out(line)
    if root == Path("/"):
        say.note(f"start it, now and at every boot: systemctl enable --now {service.name.removesuffix('.service')}")


def _program() -> Path:
    """This `fleet`, as systemd can start it."""
    beside = Path(sys.executable).absolute().with_name("fleet")
    if not beside.exists():
        raise FleetError(f"{beside}: not found; install fleet into the environment of {sys.executable}")
    return beside
