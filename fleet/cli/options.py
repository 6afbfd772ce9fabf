"""Options that several commands share."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer
from typer.core import TyperGroup

from fleet.cli import say
from fleet.errors import UsageError

if TYPE_CHECKING:
    from fleet.operator import Fleet

LONGEST_S = 600.0
DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
DEFAULT_SECURE = "tls/127.0.0.1:7447"
_ENDPOINT = re.compile(
    r"(tcp|udp|tls|quic|ws)/(\[[0-9a-fA-F:.%]+\]|[^/:\s]+):(\d{1,5})([?#]\S*)?|(unixsock-stream|serial)/\S+"
)

FleetName = Annotated[str, typer.Option("--fleet", envvar="FLEET_FLEET", metavar="NAME", help="Which fleet.")]
Connect = Annotated[
    list[str] | None,
    typer.Option(
        envvar="FLEET_CONNECT",
        metavar="ENDPOINT",
        help=f"Where the fleet is reached, several with commas.  [default: {DEFAULT_ENDPOINT}]",
    ),
]
Operator = Annotated[
    str, typer.Option(envvar="FLEET_OPERATOR", metavar="NAME", help="Who you are.  [default: your login name]")
]
Timeout = Annotated[float, typer.Option(metavar="SECONDS", help="How long to wait for answers.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON on stdout.")]
Yes = Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")]
Boats = Annotated[list[str] | None, typer.Argument(metavar="[BOAT]...", help="Only these boats; all if none is named.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the mission: formation.spacing_m=15"),
]
Runs = Annotated[
    str | None, typer.Option("--runs", metavar="DIR", help="Where runs are kept.  [default: $FLEET_RUNS, else ./runs]")
]


Credentials = Annotated[
    str | None,
    typer.Option(envvar="FLEET_CREDENTIALS", metavar="FOLDER", help="Your folder, made by fleet credentials."),
]
Insecure = Annotated[
    bool, typer.Option("--insecure", envvar="FLEET_INSECURE", help="Meant: beyond this machine, unsigned, unencrypted.")
]


class Link(NamedTuple):
    """How an operator reaches a fleet."""

    fleet: str
    connect: list[str] | None
    operator: str
    timeout: float
    credentials: str | None = None  # None: as FLEET_CREDENTIALS says
    insecure: bool = False

    @property
    def folder(self) -> str:
        """Of the credentials; '' for none."""
        return os.environ.get("FLEET_CREDENTIALS", "") if self.credentials is None else self.credentials

    @property
    def endpoints(self) -> tuple[str, ...]:
        """The endpoints, found to look like some."""
        return endpoints(self.connect, "--connect") or (DEFAULT_SECURE if self.folder else DEFAULT_ENDPOINT,)

    def open(self, present: bool = True) -> Fleet:
        """A connection, to be used with `with`."""
        timeout_s = seconds(self.timeout, "--timeout", least=0.0)
        addresses = self.endpoints
        from fleet.operator import Fleet

        fleet = Fleet(
            self.fleet,
            connect=addresses,
            operator=self.operator,
            timeout_s=timeout_s,
            present=present,
            credentials=self.folder,
            insecure=self.insecure or os.environ.get("FLEET_INSECURE", "").lower() in ("1", "true"),
        )
        for words in (fleet.insecure, fleet.trust.warning() if fleet.trust is not None else ""):
            if words:
                say.note(words)
        return fleet


def whole(text: str | int) -> int:
    """A whole number of the command line, or the default of one."""
    if not re.fullmatch(r"[+-]?[0-9]{1,40}", str(text)):
        raise typer.BadParameter(f"{text!r}: expected a whole number")
    return int(text)


def linked(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose first parameter is a `Link`, as one that has the options of a link in its place."""

    def link(
        fleet: FleetName = "demo",
        connect: Connect = None,
        operator: Operator = "",
        timeout: Timeout = 3.0,
        credentials: Credentials = None,
        insecure: Insecure = False,
    ) -> Link:
        """The options of a link, and what they are when left out."""
        return Link(fleet, connect, operator, timeout, credentials, insecure)

    def call(**given: Any) -> None:
        command(link(**{name: given.pop(name) for name in Link._fields}), **given)

    _, *own = inspect.signature(command, eval_str=True).parameters.values()
    shared = inspect.signature(link, eval_str=True).parameters.values()
    parameters = [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in (*own, *shared)]
    call.__doc__, call.__name__ = command.__doc__, command.__name__
    call.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    call.__annotations__ = {one.name: one.annotation for one in parameters}
    return call


def endpoints(texts: list[str] | None, option: str) -> tuple[str, ...]:
    """Endpoints from an option that may be repeated and may hold several with commas."""
    found = [part.strip() for text in texts or [] for part in text.split(",") if part.strip()]
    for one in found:
        match = _ENDPOINT.fullmatch(one)
        if match is None or int(match[3] or 0) > 65535:
            raise UsageError(f"{option} {one!r}: expected an endpoint such as {DEFAULT_ENDPOINT}")
    return tuple(found)


def seconds(value: float, option: str, least: float) -> float:
    """A time above `least` (or from 0 on if that is below 0) and at most ten minutes."""
    if not least < value <= LONGEST_S:
        above = "more than 0" if least == 0.0 else "at least 0"
        raise UsageError(f"{option} {value:g}: expected {above} and at most {LONGEST_S:g} s")
    return value


def short_for(word: str, *, bare: bool = False) -> type[TyperGroup]:
    """A group in which `fleet group ...` is short for `fleet group word ...`; with `bare`, `fleet group` is, too."""

    class Words(TyperGroup):
        def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
            """Put the word in where none of ours is first."""
            if bare if not args else args[0] not in (*self.commands, "-h", "--help"):
                args = [word, *args]
            return super().parse_args(ctx, args)

    return Words
