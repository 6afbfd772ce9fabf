"""`fleet launch` and `fleet set`: a mission to begin, a formation to change."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from fleet.cli import say
from fleet.cli.options import Connect, FleetName, Json, Link, Operator, Set, Timeout, Yes, seconds
from fleet.cli.outcome import finish, target, with_old
from fleet.errors import FleetError, NobodyReachable, RefusedBySafetyCheck, UsageError

if TYPE_CHECKING:
    from fleet.operator import Fleet
    from fleet.operator.fleet import Change

NONE = "none"
UNITS = {"spacing": "m", "speed": "m/s"}


def launch(
    mission: Annotated[str, typer.Argument(metavar="MISSION", help="A file, or a ready mission: fleet mission list")],
    set_: Set = None,
    in_: Annotated[float, typer.Option("--in", metavar="SECONDS", help="Boats begin together so long after.")] = 2.0,
    yes: Yes = False,
    json: Json = False,
    fleet: FleetName = "demo",
    connect: Connect = None,
    operator: Operator = "",
    timeout: Timeout = 3.0,
) -> None:
    """Give the boats a mission and begin it; asks first."""
    apply_in_s = seconds(in_, "--in", least=-1e-9)
    say.must_be_able_to_ask("launch", yes)
    from fleet.cli.sail import read_mission

    plan = read_mission(mission, list(set_ or []))
    roster = [boat.name for boat in plan.boats]
    reach = Link(fleet, connect, operator, timeout)
    with reach.open() as link:
        if len(link.wait_for(roster)) == len(roster):
            raise NobodyReachable(f"launch: none of {', '.join(roster)} is in reach in fleet {fleet!r}")
        old = _held_title(link)
        say.confirm(f"launch: {target(link, reach, [], tuple(roster))}: {old} -> {plan.title}", yes)
        finish(with_old(link.launch(plan, apply_in_s=apply_in_s), old), json)


def _held_title(fleet: Fleet) -> str:
    try:
        return fleet.formation().mission.title
    except FleetError:
        return NONE


def set_(
    what: Annotated[str, typer.Argument(metavar="spacing|speed", help="What to change.")],
    value: Annotated[str, typer.Argument(metavar="VALUE", help="Metres (slot order turns with the sign), or m/s.")],
    yes: Yes = False,
    json: Json = False,
    fleet: FleetName = "demo",
    connect: Connect = None,
    operator: Operator = "",
    timeout: Timeout = 3.0,
) -> None:
    """Change the formation under way; asks first.

    For example: fleet set spacing -20, fleet set speed 1.2. All boats change together, two seconds later.
    """
    if what not in UNITS:
        raise UsageError(f"set {what!r}: expected spacing or speed")
    unit = UNITS[what]
    wanted = say.number(value, what, unit)
    say.must_be_able_to_ask(f"set {what}", yes)
    reach = Link(fleet, connect, operator, timeout)
    with reach.open() as link:
        held = link.formation()
        old = held.spacing_m if what == "spacing" else held.cruise_mps
        _check_before(held, what, wanted)
        question = f"set {what}: {target(link, reach, [], held.roster)}: {old:g} {unit} -> {wanted:g} {unit}"
        say.confirm(question, yes)
        if not yes and link.formation().revision != held.revision:
            raise FleetError("somebody else changed the formation while you were asked: nothing was sent; look again")
        finish(link.set_spacing(wanted) if what == "spacing" else link.set_speed(wanted), json)


def _check_before(held: Change, what: str, wanted: float) -> None:
    """What the boats would refuse is not sent."""
    from fleet.mission.check import check_formation
    from fleet.mission.plan import build

    spacing_m, cruise_mps = (wanted, held.cruise_mps) if what == "spacing" else (held.spacing_m, wanted)
    problems = check_formation(build(held.mission), spacing_m, cruise_mps)
    if problems:
        raise RefusedBySafetyCheck("\n".join(f"set {what} {wanted:g}: {problem}" for problem in problems))


def add_to(app: typer.Typer) -> None:
    """Register the commands."""
    app.command("launch")(launch)
    app.command("set", context_settings={"ignore_unknown_options": True})(set_)  # so that -20 is a value
