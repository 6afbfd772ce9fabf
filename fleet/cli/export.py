"""`fleet export`: the fleet for programs that operators have already."""

from __future__ import annotations

import ipaddress
import socket
import time
from typing import Annotated

import typer

from fleet.cli import say
from fleet.cli.ending import Ending
from fleet.cli.options import Connect, Credentials, FleetName, Insecure, Link, Operator, seconds
from fleet.errors import UsageError

app = typer.Typer(no_args_is_help=True, help="The fleet for other programs: AIS targets for plotters.")
LOOK_S = 0.2
DEFAULT_UDP = "127.0.0.1:10110"
MMSI_LAST = 999_999_999


@app.callback()
def export() -> None:
    """The fleet for other programs: AIS targets for plotters."""


@app.command("ais")
def ais(
    udp: Annotated[
        list[str] | None,
        typer.Option(metavar="HOST:PORT", help=f"Where to, several with commas.  [default: {DEFAULT_UDP}]"),
    ] = None,
    lan: Annotated[
        bool, typer.Option("--lan", help="It is meant that everybody on this network sees where the boats are.")
    ] = False,
    mmsi: Annotated[
        list[str] | None,
        typer.Option(metavar="BOAT=MMSI", help="A boat's own MMSI.  [default: one of MID 200, which no country has]"),
    ] = None,
    interval: Annotated[float, typer.Option(metavar="SECONDS", help="Between two reports of a boat.")] = 2.0,
    fleet: FleetName = "demo",
    connect: Connect = None,
    operator: Operator = "",
    credentials: Credentials = None,
    insecure: Insecure = False,
) -> None:
    """Show the fleet as AIS targets in OpenCPN and on plotters of the local network.

    Sends AIVDM sentences (messages 18 and 24) as datagrams until SIGTERM or Ctrl-C. Never to a transmitter.
    """
    interval_s = seconds(interval, "--interval", least=0.0)
    where = [_target(text, lan=lan) for text in _parts(udp) or [DEFAULT_UDP]]
    given = dict(_identity(text) for text in _parts(mmsi))
    from fleet.drivers.ais.codec import must_have_pyais
    from fleet.operator.targets import Targets

    must_have_pyais("fleet export ais")
    ending = Ending()
    targets, sent = Targets(interval_s, given), 0
    with (
        Link(fleet, connect, operator, 3.0, credentials, insecure).open(present=False) as link,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out,
    ):
        out.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        shown = ", ".join(f"{host}:{port}" for host, port in where)
        say.note(
            f"fleet {fleet} as AIS targets to {shown}; on the network only, never to a transmitter; Ctrl-C ends it"
        )
        known: set[str] = set()
        trouble = ""
        while not ending.told.is_set():
            for line in targets.due(link.look(), time.monotonic()):
                now = _send(out, line, where)
                sent += not now
                if now and now != trouble:
                    say.warning(now)
                trouble = now
            for boat in sorted(targets.mmsis.keys() - known):
                say.note(f"  {boat}  MMSI {targets.mmsis[boat]}")
            known |= targets.mmsis.keys()
            ending.told.wait(LOOK_S)
    say.note(f"{sent} sentences sent")
    raise typer.Exit(ending.exit_code)


def _parts(texts: list[str] | None) -> list[str]:
    return [part.strip() for text in texts or [] for part in text.split(",") if part.strip()]


def _target(text: str, *, lan: bool) -> tuple[str, int]:
    """An address to send to; UsageError where it is none, or not of a local network, or not meant."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise UsageError(f"--udp {text!r}: expected HOST:PORT, such as {DEFAULT_UDP}")
    try:
        address = ipaddress.ip_address(socket.getaddrinfo(host, None, socket.AF_INET)[0][4][0])
    except (OSError, UnicodeError):
        raise UsageError(f"--udp {text!r}: no such host") from None
    if not (address.is_private or address.is_link_local or address == ipaddress.ip_address("255.255.255.255")):
        raise UsageError(f"--udp {text!r}: not an address of a local network; AIS targets are for the own network only")
    if not address.is_loopback and not lan:
        raise UsageError(
            f"--udp {text!r}: everybody on that network would see where the boats are; expected an address of this "
            "machine, or --lan where it is meant"
        )
    return str(address), int(port)


def _identity(text: str) -> tuple[str, int]:
    boat, _, number = text.partition("=")
    if not boat or not number.isdigit() or not 0 < int(number) <= MMSI_LAST:
        raise UsageError(f"--mmsi {text!r}: expected BOAT=MMSI, such as b1=200000001")
    return boat, int(number)


def _send(out: socket.socket, line: bytes, where: list[tuple[str, int]]) -> str:
    """'' or why a sentence could not be sent; a plotter that is not there is none of our troubles."""
    for address in where:
        try:
            out.sendto(line, address)
        except ConnectionRefusedError:
            continue
        except OSError as error:
            return f"{address[0]}:{address[1]}: {error.strerror}"
    return ""
