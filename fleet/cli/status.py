"""`fleet status`: where the boats are and what they do."""

from __future__ import annotations

import signal
import sys
import time
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fleet.cli import boats, say
from fleet.cli.options import Json, Link, linked
from fleet.errors import FleetError, NobodyReachable

if TYPE_CHECKING:
    from fleet.operator import Fleet

WATCH_S = 0.5
HEAR_S = 1.3  # every boat says its status once a second
AROUND = 8


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command("status")(status)


@linked
def status(
    reach: Link,
    watch: Annotated[bool, typer.Option("--watch", "-w", help="Go on until Ctrl-C; with --json, a line each.")] = False,
    json: Json = False,
) -> None:
    """Show where the boats are and what they do.

    Mode, abscissa, speed, errors, nearest boat, age, and why a boat is not simply following.
    """
    with reach.open(present=watch) as link:
        picture = _first(link)
        if not watch:
            _print(picture, json)
            return
        _watch(link, picture, json)


def _first(fleet: Fleet) -> dict[str, Any]:
    """Wait until every boat was heard, at most as long as said."""
    roster = _roster(fleet)
    deadline = time.monotonic() + min(HEAR_S, fleet.timeout_s)
    while time.monotonic() < deadline:
        alive = [view for view in fleet.look().values() if view.alive]
        if alive and all(view.state is not None and view.status is not None for view in alive):
            break
        time.sleep(0.02)
    fleet.look()
    if not any(view.alive or view.state is not None for view in fleet.boats.values()):
        raise NobodyReachable(f"no boat of fleet {fleet.fleet!r} is in reach")
    return _picture(fleet, roster)


def _roster(fleet: Fleet) -> tuple[str, ...]:
    """Boats of the mission that is held: one that is not heard is shown all the same."""
    try:
        return fleet.formation().roster
    except FleetError:
        return ()


def _picture(fleet: Fleet, roster: tuple[str, ...]) -> dict[str, Any]:
    """The fleet as one object."""
    from fleet.operator import BoatView

    names = sorted({*fleet.boats, *roster})
    return {
        "fleet": fleet.fleet,
        "stamp_ns": time.time_ns(),
        "boats": [boats.facts(fleet.boats.get(name) or BoatView(name)) for name in names],
    }


def _said(picture: dict[str, Any]) -> str:
    """Fleet, mission, formation and control: one value where the boats agree."""
    rows = [row for row in picture["boats"] if row["alive"]]

    def each(key: str, form: str = "{}") -> str:
        values = dict.fromkeys(form.format(row[key]) for row in rows if row.get(key) is not None)
        return " / ".join(values) or "none"

    up = f"{len(rows)} of {say.count(len(picture['boats']), 'boat')} alive"
    formation = f"spacing {each('spacing_m', '{:g} m')}, cruise {each('cruise_mps', '{:g} m/s')}"
    if any(row.get("pattern") not in (None, "column") for row in rows):
        formation = f"{each('pattern')}, {formation}, lateral {each('lateral_m', '{:g} m')}"
    slots = ", ".join(f"{row['boat']}={row['slot']:g}" for row in rows if row.get("slot") is not None)
    revision = each("formation_in_force")
    mission = each("mission")
    if mission == "none":
        return f"fleet {picture['fleet']}: {up}; no mission; control: {each('controller')}"
    head = f"fleet {picture['fleet']}: {up}; control: {each('controller')}"
    shown = f"\nslots: {slots}" if slots else ""
    return f"{head}\n{mission}\nformation: {formation}, revision {revision}{shown}"


def _print(picture: dict[str, Any], json: bool) -> None:
    if json:
        say.out_json(picture)
        return
    say.out(_said(picture))
    say.out()
    rows = [[*boats.HEADS, "why"], [*boats.UNITS, ""]]
    rows += [[*boats.cells(row), boats.why(row)] for row in picture["boats"]]
    for line in say.aligned(rows, right=boats.RIGHT):
        say.out(line)


def _watch(fleet: Fleet, picture: dict[str, Any], json: bool) -> None:
    """Show it twice a second until interrupted."""
    signal.signal(signal.SIGINT, signal.default_int_handler)  # also where a shell put us into the background
    roster = tuple(row["boat"] for row in picture["boats"])
    if json or not sys.stdout.isatty():
        while True:
            if json:
                say.out_json(picture, indent=None)
            else:
                _print(picture, json)
                say.out()
            time.sleep(WATCH_S)
            fleet.look()
            picture = _picture(fleet, roster)
    from rich.text import Text

    from fleet.cli import live

    with live.Screen(WATCH_S) as screen:
        while True:
            table = live.boats_table(picture["boats"], screen.width, max(3, screen.height - AROUND))
            screen.draw(Text(_said(picture), no_wrap=True, overflow="ellipsis"), Text(), table, live.signs())
            deadline = time.monotonic() + WATCH_S
            while time.monotonic() < deadline:
                fleet.look()
                time.sleep(0.05)
            picture = _picture(fleet, roster)
