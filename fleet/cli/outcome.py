"""What every command to the fleet has in common: whom it is for, and what came of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from fleet.cli import say
from fleet.cli.options import Link
from fleet.errors import FleetError, NobodyReachable, RefusedBySafetyCheck

if TYPE_CHECKING:
    from fleet.operator import Fleet, Outcome


def finish(outcome: Outcome, json: bool) -> None:
    """Print what the boats answered, and end with the code that says how it went."""
    if json:
        say.out_json({**outcome.as_json(), "exit_code": outcome.exit_code})
    else:
        for line in outcome.lines():
            say.out(line)
    code = outcome.exit_code
    if code == NobodyReachable.exit_code:
        say.error("no boat answered")
    elif code == RefusedBySafetyCheck.exit_code:
        say.error("refused by a safety check")
    elif code:
        done = len(outcome.acknowledged)
        say.error(f"{len(outcome.acks) - done} of {say.count(len(outcome.acks), 'boat')} did not acknowledge")
    raise typer.Exit(code)


def target(fleet: Fleet, link: Link, boats: list[str], everybody: tuple[str, ...]) -> str:
    """`fleet demo at tcp/127.0.0.1:7447, ALL 2 boats (b1, b2)`, with those out of reach named."""
    names = boats or list(everybody)
    whom = f"ALL {say.count(len(names), 'boat')}" if not boats else say.count(len(names), "boat")
    out_of_reach = [name for name in names if name not in fleet.reachable()]
    missing = f"; NOT IN REACH: {', '.join(out_of_reach)}" if out_of_reach else ""
    return f"fleet {fleet.fleet} at {', '.join(link.endpoints)}, {whom} ({', '.join(names)}){missing}"


def everybody(fleet: Fleet) -> tuple[str, ...]:
    """All boats that a command without names addresses: those in reach, and the roster."""
    try:
        roster = fleet.formation().roster
    except FleetError:
        roster = ()
    names = tuple(sorted({*fleet.reachable(), *roster}))
    if not names:
        raise NobodyReachable(f"no boat of fleet {fleet.fleet!r} is in reach")
    return names


def with_old(outcome: Outcome, old: str) -> Outcome:
    """The outcome with words for what was before: a mission's title in place of its id."""
    from msgspec import structs

    return structs.replace(outcome, old=old)
