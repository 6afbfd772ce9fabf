"""`fleet agent`: the process of a boat."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fleet.cli import say, service
from fleet.cli.options import endpoints

if TYPE_CHECKING:
    from fleet.agent.config import AgentConfig


def add_to(app: typer.Typer) -> None:
    """Register the commands."""
    service.app.command("run")(agent)
    app.add_typer(service.app, name="agent")


def _text(help_: str, metavar: str = "TEXT") -> Any:
    return typer.Option(metavar=metavar, help=help_, show_default=False)


def agent(
    config: Annotated[Path | None, typer.Option(envvar="FLEET_CONFIG", metavar="FILE", help="A TOML file.")] = None,
    boat: Annotated[str | None, _text("This boat's name.", "NAME")] = None,
    fleet: Annotated[str | None, _text("Which fleet.", "NAME")] = None,
    topology: Annotated[str | None, _text("hub, routed or mesh.")] = None,
    connect: Annotated[list[str] | None, _text("Where others are reached, several with commas.", "ENDPOINT")] = None,
    listen: Annotated[list[str] | None, _text("Where this boat listens.", "ENDPOINT")] = None,
    driver: Annotated[str | None, _text("Which hardware: simulated, can, mavlink.")] = None,
    world: Annotated[str | None, _text("Where the simulated world listens.", "HOST:PORT")] = None,
    mission: Annotated[str | None, _text("A mission to sail without an operator.", "FILE")] = None,
    state_dir: Annotated[str | None, _text("Where stops, mission and progress are kept.", "DIR")] = None,
    record: Annotated[str | None, _text("File of the recording, or none.", "FILE")] = None,
    control_hz: Annotated[float | None, _text("Ticks a second.", "HZ")] = None,
    clock_error_ms: Annotated[float | None, _text("How wrong this machine's clock may be.", "MS")] = None,
    credentials: Annotated[str | None, _text("This boat's folder, made by fleet credentials.", "FOLDER")] = None,
    insecure: Annotated[
        bool | None, typer.Option("--insecure", help="Meant: others may reach it, and nothing is signed.")
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Only print the configuration and where each value came from.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="With --check: print JSON.")] = False,
) -> None:
    """Be one boat's agent, until SIGTERM or Ctrl-C.

    Flags go over FLEET_* variables, these over the configuration file.
    """
    flags: dict[str, Any] = {
        "boat": boat,
        "fleet": fleet,
        "link.topology": topology,
        "link.connect": list(endpoints(connect, "--connect")) or None,
        "link.listen": list(endpoints(listen, "--listen")) or None,
        "link.credentials": credentials,
        "link.insecure": insecure,
        "driver.kind": driver,
        "driver.world": world,
        "mission": mission,
        "state_dir": state_dir,
        "record": record,
        "control_hz": control_hz,
        "clock_error_ms": clock_error_ms,
    }
    from fleet.agent.config import load_config

    resolved = load_config(config, flags)
    if check:
        _show(resolved, config, flags, json)
        return
    import msgspec

    argument = msgspec.json.encode(resolved).decode()
    sys.stdout.flush()
    os.execv(sys.executable, [sys.executable, "-m", "fleet.agent", argument])  # without Typer's memory


def _show(config: AgentConfig, path: Path | None, flags: dict[str, Any], json: bool) -> None:
    """Every value and where it came from."""
    import msgspec

    values = dict(_leaves(msgspec.to_builtins(config)))
    origins = {name: _origin(name, path, flags) for name in values}
    if json:
        say.out_json({name: {"value": value, "from": origins[name]} for name, value in values.items()})
        return
    rows = [(name, _shown(value), origins[name]) for name, value in values.items()]
    for line in say.aligned([("value", "", "from"), *rows]):
        say.out(line)


def _leaves(tree: dict[str, Any], before: str = "") -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []
    for name, value in tree.items():
        found += _leaves(value, f"{before}{name}.") if isinstance(value, dict) else [(before + name, value)]
    return found


def _shown(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "none"
    return str(value) if value != "" else "-"


def _origin(name: str, path: Path | None, flags: dict[str, Any]) -> str:
    """Flag over environment over file over default, as `load_config` has it."""
    from fleet.agent.config import ENVIRONMENT, read_table

    if flags.get(name) is not None:
        return "flag"
    for variable, dotted in ENVIRONMENT.items():
        if dotted == name and os.environ.get(variable):
            return variable
    table: Any = read_table(path) if path is not None else {}
    for part in name.split("."):
        table = table.get(part) if isinstance(table, dict) else None
    return str(path) if table is not None else "default"
