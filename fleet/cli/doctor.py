"""`fleet doctor`: is what a boat runs on fit for it?"""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fleet.cli import say
from fleet.cli.options import Json, seconds
from fleet.errors import UsageError

if TYPE_CHECKING:
    from fleet.doctor.finding import Finding as General
    from fleet.drivers.mavlink.ashore import Ashore
    from fleet.drivers.mavlink.checklist import Finding

FIND_S, MEASURE_S = 5.0, 3.0

app = typer.Typer()
COLOURS = {"ok": "green", "warn": "yellow", "fail": "red"}

Endpoint = Annotated[
    str,
    typer.Argument(metavar="ENDPOINT", help="udp:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT or serial:DEVICE:BAUD."),
]
Sysid = Annotated[int, typer.Option(metavar="N", help="Of the autopilot, 1 to 255.")]
SigningKey = Annotated[
    str, typer.Option(metavar="FILE", help="With a passphrase, where the autopilot wants signatures.")
]
OwnSysid = Annotated[int, typer.Option(metavar="N", help="Of the agent that will talk to it, 1 to 255.")]


def config(endpoint: str, sysid: int, own_sysid: int, **more: Any) -> Any:
    """A configuration of the driver, checked."""
    from fleet.drivers.mavlink.config import MavlinkConfig

    for option, value in (("--sysid", sysid), ("--own-sysid", own_sysid)):
        if not 1 <= value <= 255:
            raise UsageError(f"{option} {value}: expected 1 to 255")
    made = MavlinkConfig(endpoint=endpoint, sysid=sysid, own_sysid=own_sysid, **more)
    made.check()
    return made


@app.callback(invoke_without_command=True)
def whole(
    context: typer.Context,
    config: Annotated[
        Path | None, typer.Option(envvar="FLEET_CONFIG", metavar="FILE", help="The boat's TOML file.")
    ] = None,
    timeout: Annotated[float, typer.Option(metavar="SECONDS", help="How long to wait for each answer.")] = 5.0,
    json: Json = False,
) -> None:
    """Look at a boat as a whole: clock, disk, ports, CAN, links, credentials, versions, driver; and say what to do.

    Changes nothing and commands nothing. Exit code 1 if something must be done before the boat sails. `fleet doctor
    mavlink` looks closer at an autopilot.
    """
    if context.invoked_subcommand is not None:
        return
    patience_s = seconds(timeout, "--timeout", least=0.0)
    from fleet.agent.config import load_config
    from fleet.doctor.examine import examine

    boat = load_config(config) if config is not None else None
    findings = []
    for one in examine(boat, patience_s):
        findings.append(one)
        if not json:
            _say(one)
    bad = [one for one in findings if one.verdict == "fail"]
    if json:
        import msgspec

        name = boat.boat if boat is not None else None
        say.out_json({"boat": name, "findings": msgspec.to_builtins(findings), "fit": not bad})
    if bad:
        say.error(f"not fit yet: {say.count(len(bad), 'thing')} to mend")
        raise typer.Exit(1)


def _say(one: General) -> None:
    """A finding, and below it what to do."""
    say.out(f"{say.paint(f'{one.verdict:4}', COLOURS[one.verdict])}  {one.subject:11}  {one.found}")
    if one.do:
        say.out(f"      {'':11}  -> {one.do}")


@app.command("mavlink")
def mavlink(
    endpoint: Endpoint,
    sysid: Sysid = 1,
    own_sysid: OwnSysid = 254,
    signing_key: SigningKey = "",
    speed: Annotated[float, typer.Option(metavar="MPS", help="Fastest speed of the boat in a mission.")] = 1.5,
    timeout: Annotated[float, typer.Option(metavar="SECONDS", help="How long to wait for parameters.")] = 8.0,
    json: Json = False,
) -> None:
    """Check an autopilot's parameters and streams for this use, and print what to change; changes nothing.

    Asks the streams' rates, as the driver does. Exit code 1 if something must be changed.
    """
    patience_s = seconds(timeout, "--timeout", least=0.0)
    if not 0.0 < speed <= 30.0:
        raise UsageError(f"--speed {speed:g}: expected more than 0 and at most 30 m/s")
    chosen = config(endpoint, sysid, own_sysid, signing_key=signing_key)
    from fleet.drivers.mavlink.ashore import Ashore
    from fleet.drivers.mavlink.checklist import judge, rules

    link = Ashore(chosen)
    try:
        link.find(FIND_S)
        checks = rules(sysid, own_sysid, speed)
        held = link.ask([name for rule in checks for name in rule.names], patience_s)
        findings = [judge(rule, held) for rule in checks]
        state = _state(link)
    finally:
        link.close()
    bad = [f for f in findings if f.verdict in ("change", "unknown")]
    if json:
        import msgspec

        say.out_json({**state, "parameters": msgspec.to_builtins(findings), "fit": not bad})
    else:
        _print(state, findings)
    if bad:
        say.error(f"not fit yet: {say.count(len(bad), 'parameter')} to change")
        raise typer.Exit(1)


def _state(link: Ashore) -> dict[str, Any]:
    """What it is, and how often its streams come."""
    from fleet.drivers.mavlink import words
    from fleet.drivers.mavlink.driver import STREAMS

    vehicle = link.driver.vehicle
    link.wait(lambda: False, 1.0)
    before, began = vehicle.received.copy(), time.monotonic()
    link.wait(lambda: False, MEASURE_S)
    passed_s = time.monotonic() - began
    known = words.dialect().mavlink_map
    return {
        "ardupilot": vehicle.autopilot == words.ARDUPILOT,
        "boat": vehicle.kind == words.SURFACE_BOAT,
        "mode": words.mode_name(vehicle.mode),
        "armed": vehicle.armed,
        "navigation": vehicle.lost(time.time_ns()) or "good",
        "arming": "ready" if vehicle.ready else vehicle.why_not_ready(time.time_ns()),
        "rates_hz": {
            known[message].msgname: {
                "wanted": hz,
                "now": round((vehicle.received[message] - before[message]) / passed_s, 1),
            }
            for message, hz in STREAMS.items()
        },
        "said": list(dict.fromkeys(link.heard)),
    }


def _print(state: dict[str, Any], findings: list[Finding]) -> None:
    kind = "ArduPilot" if state["ardupilot"] else "not ArduPilot: the driver is made for ArduPilot Rover"
    boat = "surface boat" if state["boat"] else "not a surface boat"
    armed = "armed" if state["armed"] else "not armed"
    say.out(f"autopilot: {kind}, {boat}, {state['mode']}, {armed}")
    say.out(f"navigation: {state['navigation']}")
    say.out(f"arming: {state['arming']}")
    for text in state["said"]:
        say.out(f"it says: {text}")
    rates = [(name, f"{r['now']:g} Hz", f"wanted {r['wanted']:g}") for name, r in state["rates_hz"].items()]
    for line in [*say.aligned(rates, right=(1,)), ""]:
        say.out(line)
    rows = [("parameter", "now", "wanted", "", "")]
    for f in findings:
        now = "no answer" if f.value is None else f"{f.value:g}"
        rows.append((f.name, now, f.wanted, f.verdict, "" if f.verdict in ("ok", "absent") else f.why))
    for line in say.aligned(rows):
        say.out(line)
    changes = [f for f in findings if f.verdict in ("change", "advice")]
    if changes:
        say.out("\nto change, in a ground station or by `param set`:")
        for f in changes:
            say.out(f"  {f.name} {f.set_to:g}")
