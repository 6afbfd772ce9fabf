"""`fleet launch` and `fleet set`: a mission to begin, a formation to change."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from fleet.cli import say
from fleet.cli.options import Json, Link, Set, Yes, linked, seconds
from fleet.cli.outcome import finish, target, with_old
from fleet.errors import FleetError, NobodyReachable, RefusedBySafetyCheck, UsageError

if TYPE_CHECKING:
    from fleet.mission.pattern import Shape
    from fleet.operator import Fleet
    from fleet.operator.view import Change

NONE = "none"


@linked
def launch(
    reach: Link,
    mission: Annotated[str, typer.Argument(metavar="MISSION", help="A file, or a ready mission: fleet mission list")],
    set_: Set = None,
    in_: Annotated[float, typer.Option("--in", metavar="SECONDS", help="Boats begin together so long after.")] = 2.0,
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Give the boats a mission and begin it; asks first."""
    apply_in_s = seconds(in_, "--in", least=-1e-9)
    say.must_be_able_to_ask("launch", yes)
    from fleet.cli.sail import read_mission

    plan = read_mission(mission, list(set_ or []))
    roster = [boat.name for boat in plan.boats]
    with reach.open() as link:
        if len(link.wait_for(roster)) == len(roster):
            raise NobodyReachable(f"launch: none of {', '.join(roster)} is in reach in fleet {reach.fleet!r}")
        old = _held_title(link)
        say.confirm(f"launch: {target(link, reach, [], tuple(roster))}: {old} -> {plan.title}", yes)
        finish(with_old(link.launch(plan, apply_in_s=apply_in_s), old), json)


def _held_title(fleet: Fleet) -> str:
    try:
        return fleet.formation().mission.title
    except FleetError:
        return NONE


@linked
def set_(
    reach: Link,
    what: Annotated[str, typer.Argument(metavar="spacing|lateral|speed|pattern|leader|slots", help="What to change.")],
    value: Annotated[
        str, typer.Argument(metavar="VALUE", help="Metres, m/s, a pattern, a boat, or slots: b1=0,b2=-1.")
    ],
    yes: Yes = False,
    json: Json = False,
) -> None:
    """Change the formation under way; asks first.

    For example: fleet set spacing -20, fleet set pattern wedge, fleet set slots b1=-1,b2=0. All boats change together,
    two seconds later.
    """
    from fleet.mission.change import CHANGES, changed, words

    if what not in CHANGES:
        raise UsageError(f"set {what!r}: expected one of {', '.join(CHANGES)}")
    unit = CHANGES[what].unit
    wanted = say.number(value, what, unit) if unit else value
    say.must_be_able_to_ask(f"set {what}", yes)
    with reach.open() as link:
        held = link.formation()
        shape = changed(held.roster, held.shape, what, wanted)
        _check_before(held, what, value, shape)
        old, new = (words(held.roster, one, what) for one in (held.shape, shape))
        say.confirm(f"set {what}: {target(link, reach, [], held.roster)}: {old} -> {new}", yes)
        if not yes and link.formation().revision != held.revision:
            raise FleetError("somebody else changed the formation while you were asked: nothing was sent; look again")
        finish(link.set(what, wanted), json)


def _check_before(held: Change, what: str, value: str, shape: Shape) -> None:
    """What the boats would refuse is not sent."""
    from fleet.mission.check import check_formation
    from fleet.mission.plan import build

    problems = check_formation(build(held.mission), shape)
    if problems:
        raise RefusedBySafetyCheck("\n".join(f"set {what} {value}: {problem}" for problem in problems))


def add_to(app: typer.Typer) -> None:
    """Register the commands."""
    app.command("launch")(launch)
    app.command("set", context_settings={"ignore_unknown_options": True})(set_)  # so that -20 is a value
