"""What a timeline can order: operators' commands, and trouble that the simulator makes."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import Struct

from fleet.mission.formation import cruise_misfits, spacing_misfits
from fleet.mission.model import Event
from fleet.mission.plan import Plan
from fleet.mission.problem import Key, Problem, hint


class Action(Struct, frozen=True):
    """One thing that an entry of the timeline can do."""

    by: str
    """`operator`: sent as a command over the wire. `simulator`: done to the boat."""
    meaning: str
    value: str | None = None
    """What the value is; None: it takes none."""
    fleet_wide: bool = False
    """It concerns the formation: no boats can be named."""
    named: bool = False
    """Boats must be named."""
    undoes: str | None = None
    """The action that must have come before."""


ACTIONS: dict[str, Action] = {
    "set spacing": Action("operator", "the formation's spacing", value="metres", fleet_wide=True),
    "set speed": Action("operator", "the formation's cruise speed", value="m/s", fleet_wide=True),
    "hold": Action("operator", "keep station"),
    "resume": Action("operator", "go on after a hold", undoes="hold"),
    "abort": Action("operator", "end the mission, then hold"),
    "return": Action("operator", "back along the travelled track to home"),
    "stop-now": Action("operator", "no thrust until released"),
    "release": Action("operator", "lift the stop", undoes="stop-now"),
    "take": Action("operator", "take control of the fleet"),
    "forget": Action("operator", "stop keeping clear of a boat that fell silent", named=True),
    "kill": Action("simulator", "end the agent's process; the hull drifts on"),
    "start": Action("simulator", "start the agent; where it is a boat's first action, the boat begins without one"),
    "freeze": Action("simulator", "stop the agent's process without ending it"),
    "thaw": Action("simulator", "let a frozen agent go on", undoes="freeze"),
    "radio-down": Action("simulator", "the boat neither sends nor hears"),
    "radio-up": Action("simulator", "its radio works again", undoes="radio-down"),
    "gnss-down": Action("simulator", "the boat loses its position"),
    "gnss-up": Action("simulator", "the position is back", undoes="gnss-down"),
    "actuator-down": Action("simulator", "the boat no longer obeys its commands"),
    "actuator-up": Action("simulator", "it obeys again", undoes="actuator-down"),
    "battery": Action("simulator", "the battery falls to a level", value="percent"),
}


def timeline_problems(plan: Plan) -> Iterator[Problem]:
    """Entries that cannot be carried out."""
    names = [boat.name for boat in plan.mission.boats]
    for i, event in enumerate(plan.mission.timeline):
        key: Key = ("timeline", i)
        if event.at_s > plan.mission.duration_s:
            yield Problem((*key, "at_s"), f"after the end, duration_s = {plan.mission.duration_s:g}", event.at_s)
        for j, name in enumerate(event.boats):
            if name not in names:
                yield Problem((*key, "boats", j), f"no such boat{hint(name, names)}", name)
        action = ACTIONS.get(event.do)
        if action is None:
            yield Problem((*key, "do"), f"no such action{hint(event.do, ACTIONS)}", event.do)
            continue
        if action.value is None and event.value is not None:
            yield Problem((*key, "value"), f"{event.do} takes no value", event.value)
        elif action.value is not None and event.value is None:
            yield Problem((*key, "value"), f"missing, {event.do} needs one: {action.value}")
        if action.fleet_wide and event.boats:
            yield Problem((*key, "boats"), f"{event.do} concerns the whole fleet; expected none", event.boats)
        if action.named and not event.boats:
            yield Problem((*key, "boats"), f"missing, {event.do} needs the names of boats")
        if event.value is not None:
            yield from _value_problems(plan, event, event.value, (*key, "value"))


def timeline_warnings(plan: Plan) -> Iterator[Problem]:
    """Entries that will do nothing, or that come too late, as far as can be told beforehand."""
    yield from _idle(plan)
    yield from _too_late(plan)


def _value_problems(plan: Plan, event: Event, value: float, key: Key) -> Iterator[Problem]:
    """Values that the boats would refuse."""
    if event.do == "set spacing":
        for misfit in spacing_misfits(plan, value):
            yield Problem(key, misfit.text, value)
    elif event.do == "set speed":
        for misfit in cruise_misfits(plan, value):
            yield Problem(key, misfit.text, value)
    elif event.do == "battery" and not 0.0 <= value <= 100.0:
        yield Problem(key, "expected percent, from 0 to 100", value)


def _idle(plan: Plan) -> Iterator[Problem]:
    """Undoing what was not done; starting what runs; killing what does not."""
    done: set[tuple[str, str]] = {(boat.name, "start") for boat in plan.boats if not boat.starts_late}
    everybody = tuple(boat.name for boat in plan.boats)
    for i, event in _in_order(plan):
        action = ACTIONS[event.do]
        for name in event.boats or everybody:
            runs = (name, "start") in done
            if event.do in ("start", "kill") and runs == (event.do == "start"):
                wrong = "already runs" if runs else "does not run"
                yield Problem(("timeline", i, "do"), f"the agent of {name} {wrong} at {event.at_s:g} s", event.do)
            if action.undoes is not None and (name, action.undoes) not in done:
                yield Problem(("timeline", i, "do"), f"{name} had no {action.undoes} before {event.at_s:g} s", event.do)
            done.discard((name, "start" if event.do == "kill" else action.undoes or ""))
            done.add((name, event.do))


def _too_late(plan: Plan) -> Iterator[Problem]:
    """Changes for which the path is over, or not yet long enough, if the fleet keeps to its cruise speed until then."""
    lines = [boat for boat in plan.boats if not boat.path.closed]
    sailing = [boat for boat in plan.boats if not boat.starts_late]
    if not lines or not sailing:
        return
    spacing, cruise = plan.mission.formation.spacing_m, plan.mission.formation.cruise_mps
    reference = sum(boat.s - boat.slot * spacing for boat in sailing) / len(sailing)
    now = 0.0
    for i, event in _in_order(plan):
        reference, now = reference + cruise * (event.at_s - now), event.at_s
        if any(reference + boat.slot * spacing >= boat.path.length for boat in lines):
            wrong = "by then the foremost boat has reached the end of its path, and the mission is over"
            yield Problem(("timeline", i, "at_s"), wrong, event.at_s)
            return
        if event.do == "set speed" and event.value is not None:
            cruise = event.value
        if event.do == "set spacing" and event.value is not None:
            places = {boat.name: reference + boat.slot * spacing for boat in sailing}
            for misfit in spacing_misfits(plan, event.value, places):
                yield Problem(("timeline", i, "value"), f"about {event.at_s:g} s {misfit.text}", event.value)
            reference += sum(boat.slot * (spacing - event.value) for boat in sailing) / len(sailing)
            spacing = event.value


def _in_order(plan: Plan) -> list[tuple[int, Event]]:
    """The entries by time, with their places in the file."""
    return sorted(enumerate(plan.mission.timeline), key=lambda item: item[1].at_s)
