"""Words that need nothing but boats: hold, resume, abort, return, stop-now, release, take, forget."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from fleet.cli import say
from fleet.cli.options import Boats, Json, Link, Yes, linked
from fleet.cli.outcome import everybody, finish, target, with_old
from fleet.errors import UsageError

if TYPE_CHECKING:
    from fleet.operator import Fleet, Outcome


def named(boats: list[str] | None) -> list[str]:
    """Names of boats, each once, found to be names."""
    from fleet.wire.keys import valid_name

    return [valid_name("boat", boat) for boat in dict.fromkeys(boats or [])]


def in_words(fleet: Fleet, boats: list[str], what: Callable[[Any], str]) -> str:
    """What the boats' states say now: one word where they agree."""
    wanted = boats or list(fleet.reachable())
    fleet.wait_for(wanted, min(1.0, fleet.timeout_s))
    found = {n: what(v.state) for n, v in sorted(fleet.boats.items()) if n in wanted and v.state is not None}
    if len(set(found.values())) == 1:
        return next(iter(found.values()))
    return ", ".join(f"{name} {word}" for name, word in found.items()) or "unknown"


def modes_now(fleet: Fleet, boats: list[str]) -> str:
    """The modes of boats."""
    from fleet.agent.modes import mode_word

    return in_words(fleet, boats, lambda state: mode_word(state.mode))


@linked
def resume(
    reach: Link,
    boats: Boats = None,
    at: Annotated[str, typer.Option(metavar="nearest|S", help="Where on the path, after a restart: metres.")] = "",
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Go on with the mission; asks first."""
    if at not in ("", "nearest"):
        say.number(at, "--at", "m", "nearest, or an abscissa")
    names = named(boats)
    say.must_be_able_to_ask("resume", yes)
    with reach.open() as link:
        where = f" at {at}{'' if at == 'nearest' else ' m'}" if at else ""
        whom = target(link, reach, names, everybody(link))
        say.confirm(f"resume{where}: {whom}: {modes_now(link, names)} -> follow", yes)
        finish(link.resume(names, at=at), json)


class Word(NamedTuple):
    """A command that needs nothing but boats."""

    name: str
    help: str
    asks: bool
    new: str
    """What it changes, for the question."""
    old: Callable[[Fleet, list[str]], str]
    say: Callable[[Fleet, list[str]], Outcome]


def _stops(fleet: Fleet, boats: list[str]) -> str:
    return in_words(fleet, boats, lambda state: f"stopped by {', '.join(state.stops)}" if state.stops else "no stop")


WORDS = (
    Word("hold", "Keep station; never asks.", False, "hold", modes_now, lambda fleet, boats: fleet.hold(boats)),
    Word(
        "abort",
        "End the mission, then hold; never asks.",
        False,
        "hold",
        modes_now,
        lambda fleet, boats: fleet.abort(boats),
    ),
    Word(
        "return",
        "Back along the travelled track to home, then hold; asks first.",
        True,
        "return",
        modes_now,
        lambda fleet, boats: fleet.return_home(boats),
    ),
    Word(
        "stop-now",
        "No thrust until released, across restarts; never asks.",
        False,
        "neutral",
        modes_now,
        lambda fleet, boats: fleet.stop_now(boats),
    ),
    Word(
        "release",
        "Lift stops; the boats hold until resumed; asks first.",
        True,
        "released, holding",
        _stops,
        lambda fleet, boats: fleet.release(boats),
    ),
)


def _add_word(app: typer.Typer, word: Word) -> None:
    @linked
    def command(reach: Link, boats: Boats = None, json: Json = False, yes: Yes = False) -> None:
        """Ask where that is wanted, say it, print the answers."""
        names = named(boats)
        if word.asks:
            say.must_be_able_to_ask(word.name, yes)
        with reach.open() as link:
            if word.asks and not yes:
                question = (
                    f"{word.name}: {target(link, reach, names, everybody(link))}: {word.old(link, names)} -> {word.new}"
                )
                say.confirm(question, yes)
            finish(word.say(link, names), json)

    app.command(word.name, help=word.help)(command)


@linked
def take(
    reach: Link,
    json: Json = False,
) -> None:
    """Take control of the fleet from whoever holds it.

    One operator holds control; others may watch, hold, abort and stop.
    """
    with reach.open() as link:
        outcome = link.take()
        before = [name for name in outcome.old.split(" | ") if name != outcome.new]  # a neighbour's word may come first
        finish(with_old(outcome, " | ".join(before) or outcome.old), json)


@linked
def forget(
    reach: Link,
    boats: Annotated[list[str], typer.Argument(metavar="BOAT...", help="Boats that are gone from the water.")],
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Stop keeping clear of boats that are gone; asks first."""
    names = named(boats)
    say.must_be_able_to_ask("forget", yes)
    with reach.open() as link:
        alive = [name for name in names if name in link.reachable()]
        if alive:
            raise UsageError(f"forget {', '.join(alive)}: still alive; expected boats that fell silent")
        gone = ", ".join(names)
        say.confirm(
            f"forget: the boats of fleet {reach.fleet} no longer keep clear of {gone}: is it out of the water?", yes
        )
        finish(link.forget(names), json)


def add_to(app: typer.Typer) -> None:
    """Register the commands."""
    app.command("resume")(resume)
    for word in WORDS:
        _add_word(app, word)
    app.command("take")(take)
    app.command("forget")(forget)
