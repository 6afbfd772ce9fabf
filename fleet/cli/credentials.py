"""`fleet credentials`: the fleet's own authority, and a folder for each station."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fleet.cli import say
from fleet.cli.options import Connect, Credentials, FleetName, Json, Link, Operator, Timeout
from fleet.cli.outcome import finish
from fleet.errors import UsageError

if TYPE_CHECKING:
    from fleet.wire.credentials.roster import Identity, Role, Roster

HOME = Path("credentials")
NEAR_END_S = 30 * 86400

app = typer.Typer(
    help="Give boats and operators certificates, revoke them, show them.", no_args_is_help=True, rich_markup_mode=None
)

Authority = Annotated[
    Path,
    typer.Option("--authority", envvar="FLEET_AUTHORITY", metavar="FOLDER", help="Of the authority; keep it on shore."),
]
Name = Annotated[str, typer.Argument(metavar="NAME", help="Of the station.")]
Days = Annotated[float, typer.Option(metavar="DAYS", help="How long it is valid.")]
Hosts = Annotated[
    list[str] | None,
    typer.Option(metavar="HOST", help="Names and addresses where others connect to it, several with commas."),
]
Renew = Annotated[bool, typer.Option("--renew", help="A new one beside one that is still valid.")]


@app.command("init")
def init(
    fleet: Annotated[str, typer.Option("--fleet", envvar="FLEET_FLEET", metavar="NAME", help="Which fleet.")] = "demo",
    authority: Authority = HOME,
) -> None:
    """Found the authority of a fleet, in a folder of its own."""
    from fleet.wire.credentials.authority import create

    made = create(authority, fleet, time.time())
    say.out(f"{authority}: authority of fleet {fleet}, valid until {made.certificate.not_valid_after_utc:%Y-%m-%d}")
    say.out("Its key gives certificates to anybody: keep the folder on shore, and a copy in a safe place.")


def _issue(role: Role, name: str, authority: Path, days: float, hosts: list[str] | None, renew: bool) -> None:
    from fleet.wire.credentials.authority import load

    named = [one.strip() for text in hosts or [] for one in text.split(",") if one.strip()]
    founded = load(authority)
    folder = founded.issue(role, name, time.time(), days=days, hosts=named, renew=renew)
    say.out(f"{folder}: certificate and key of {founded.roster.members[-1].words}, valid {days:g} days")
    use = {"boat": f'link.credentials = "..." of {name}', "operator": "--credentials", "hub": "fleet hub --credentials"}
    say.out(f"Copy the folder to its machine, and name it there ({use[role]}).")
    say.out(f"Roster {founded.roster.number} is new: bring it to the others with `fleet credentials send`, or copy it.")


@app.command("boat")
def boat(
    name: Name, authority: Authority = HOME, hosts: Hosts = None, days: Days = 365.0, renew: Renew = False
) -> None:
    """Give a boat a certificate and a key."""
    _issue("boat", name, authority, days, hosts, renew)


@app.command("operator")
def operator(
    name: Name, authority: Authority = HOME, hosts: Hosts = None, days: Days = 365.0, renew: Renew = False
) -> None:
    """Give an operator a certificate and a key."""
    _issue("operator", name, authority, days, hosts, renew)


@app.command("hub")
def hub(name: Name, authority: Authority = HOME, hosts: Hosts = None, days: Days = 365.0, renew: Renew = False) -> None:
    """Give a hub a certificate and a key."""
    _issue("hub", name, authority, days, hosts, renew)


@app.command("revoke")
def revoke(name: Name, authority: Authority = HOME) -> None:
    """Nobody is to believe this name's certificates any more."""
    from fleet.wire.credentials.authority import load

    founded = load(authority)
    for one in founded.revoke(name, time.time()):
        say.out(f"{one.words}: revoked")
    say.out(
        f"Roster {founded.roster.number} says so: bring it to every station with `fleet credentials send`, or copy it."
    )


@app.command("show")
def show(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="[FOLDER]", envvar="FLEET_AUTHORITY", help="Of the authority, or of a station.", show_default=False
        ),
    ] = HOME,
    json: Json = False,
) -> None:
    """Show who belongs to the fleet: role, end, fingerprint, revoked or not; never a key."""
    from fleet.wire.credentials import files
    from fleet.wire.credentials.roster import read_body, read_envelope

    where = str(folder / files.ROSTER)
    roster = read_body(read_envelope(files.read(folder, files.ROSTER), where), where)
    if json:
        say.out_json(
            {"fleet": roster.fleet, "roster": roster.number, "members": [_facts(one) for one in roster.members]}
        )
        return
    say.out(f"fleet {roster.fleet}, roster {roster.number}, made {_day(roster.stamp_s)}")
    for line in say.aligned(_rows(roster)):
        say.out(line)


def _rows(roster: Roster) -> list[tuple[str, ...]]:
    head = ("role", "name", "serial", "ends", "state", "fingerprint (SHA-256)")
    return [head, *(tuple(str(_facts(one)[key]) for key in _facts(one)) for one in roster.members)]


def _facts(one: Identity) -> dict[str, Any]:
    now_s = time.time()
    left_s = one.ends_s - now_s
    state = one.trouble(now_s) or (f"ends in {left_s / 86400:.0f} days" if left_s < NEAR_END_S else "valid")
    if one.revoked_s:
        state = f"revoked {_day(one.revoked_s)}"
    return {
        "role": one.role,
        "name": one.name,
        "serial": one.serial,
        "ends": _day(one.ends_s),
        "state": state,
        "fingerprint": one.fingerprint,
    }


def _day(seconds: float) -> str:
    return time.strftime("%Y-%m-%d", time.gmtime(seconds))


@app.command("send")
def send(
    json: Json = False,
    fleet: FleetName = "demo",
    connect: Connect = None,
    operator: Operator = "",
    timeout: Timeout = 3.0,
    credentials: Credentials = None,
) -> None:
    """Bring boats and hubs the roster in your folder; they keep it if it is newer than theirs."""
    link = Link(fleet, connect, operator, timeout, credentials)
    if not link.folder:
        raise UsageError("credentials send: expected --credentials FOLDER, an operator's")
    with link.open() as reached:
        finish(reached.send_roster(), json)
