"""What a timeline can order: operators' commands, and trouble that the simulator makes."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec import Struct

from fleet.errors import UsageError
from fleet.mission.change import CHANGES, changed
from fleet.mission.formation import cruise_misfits, place_misfits
from fleet.mission.model import Event
from fleet.mission.pattern import Shape
from fleet.mission.plan import Plan
from fleet.mission.problem import Key, Problem, hint


class Action(Struct, frozen=True):
    """One thing that an entry of the timeline can do."""

    by: str
    """`operator`: sent as a command over the wire. `simulator`: done to the boat."""
    meaning: str
    value: str | None = None
    """What the value is; None: it takes none."""
    words: bool = False
    """The value is words, not a number."""
    fleet_wide: bool = False
    """It concerns the formation: no boats can be named."""
    named: bool = False
    """Boats must be named."""
    undoes: str | None = None
    """The action that must have come before."""


ACTIONS: dict[str, Action] = {
    "set spacing": Action("operator", "the formation's spacing", value="metres", fleet_wide=True),
    "set speed": Action("operator", "the formation's cruise speed", value="m/s", fleet_wide=True),
    "set lateral": Action("operator", "metres from slot to slot abeam", value="metres", fleet_wide=True),
    "set pattern": Action(
        "operator", "the formation's pattern", value=CHANGES["pattern"].value, words=True, fleet_wide=True
    ),
    "set leader": Action(
        "operator",
        "a boat leads; it and the leader exchange slots",
        value="the name of a boat",
        words=True,
        fleet_wide=True,
    ),
    "set slots": Action(
        "operator",
        "other slots for some boats",
        value='their slots, such as "b1=-1,b2=0"',
        words=True,
        fleet_wide=True,
    ),
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
    "compass-down": Action("simulator", "the boat loses its heading"),
    "compass-up": Action("simulator", "the heading is back", undoes="compass-down"),
    "gyro-down": Action("simulator", "the boat loses its yaw rate"),
    "gyro-up": Action("simulator", "the yaw rate is back", undoes="gyro-down"),
    "lidar-down": Action("simulator", "the boat's laser scanner is dead"),
    "lidar-up": Action("simulator", "it was switched on again", undoes="lidar-down"),
    "actuator-down": Action("simulator", "the boat no longer obeys its commands"),
    "actuator-up": Action("simulator", "it obeys again", undoes="actuator-down"),
    "pilot-takes": Action("simulator", "a pilot takes the boat by remote control; needs `--driver`"),
    "pilot-gives": Action("simulator", "the pilot gives it back", undoes="pilot-takes"),
    "autopilot-restarts": Action("simulator", "the boat's autopilot starts anew; needs `--driver mavlink`"),
    "bus-off": Action("simulator", "the boat's CAN bus fails; needs `--driver can`"),
    "bus-on": Action("simulator", "the CAN bus works again", undoes="bus-off"),
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
        elif action.value is not None and isinstance(event.value, str) != action.words:
            expected = "text" if action.words else "a number"
            yield Problem((*key, "value"), f"expected {expected}: {action.value}", event.value)
        elif event.do == "battery" and not 0.0 <= event.number <= 100.0:
            yield Problem((*key, "value"), "expected percent, from 0 to 100", event.value)
        if action.fleet_wide and event.boats:
            yield Problem((*key, "boats"), f"{event.do} concerns the whole fleet; expected none", event.boats)
        if action.named and not event.boats:
            yield Problem((*key, "boats"), f"missing, {event.do} needs the names of boats")
    yield from _changes(plan)


def timeline_warnings(plan: Plan) -> Iterator[Problem]:
    """Entries that will do nothing, or that come too late, as far as can be told beforehand."""
    yield from _idle(plan)
    yield from _too_late(plan)


def shapes(plan: Plan) -> Iterator[tuple[int, Event, Shape]]:
    """The changes of the formation by time: place in the file, entry, and the formation from then on.

    Entries that cannot be carried out change nothing.
    """
    yield from ((i, event, shape) for i, event, shape, wrong in _steps(plan) if not wrong)


def _steps(plan: Plan) -> Iterator[tuple[int, Event, Shape, str]]:
    """As `shapes`, with those whose value means nothing, and why."""
    names = [boat.name for boat in plan.mission.boats]
    shape = plan.shape
    for i, event in _in_order(plan):
        action = ACTIONS.get(event.do)
        fits = action is not None and action.fleet_wide and isinstance(event.value, str) == action.words
        if event.value is None or not fits:
            continue
        try:
            shape = changed(names, shape, event.do.removeprefix("set "), event.value)
        except UsageError as error:
            yield i, event, shape, str(error)
        else:
            yield i, event, shape, ""


def _changes(plan: Plan) -> Iterator[Problem]:
    """Changes of the formation that mean nothing, or that the boats would refuse."""
    for i, event, shape, wrong in _steps(plan) if plan.boats else ():
        key: Key = ("timeline", i, "value")
        if wrong:
            yield Problem(key, wrong, event.value)
            continue
        found = cruise_misfits(plan, shape.cruise_mps) if event.do == "set speed" else place_misfits(plan, shape)
        for misfit in found:
            if misfit.key != "slots" or event.do == "set slots":  # those at launch are named with their boats
                yield Problem(key, misfit.text, event.value)


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
    shape = plan.shape
    later = {i: changed for i, _, changed in shapes(plan)}
    reference = sum(boat.s - shape.ahead(boat.number) for boat in sailing) / len(sailing)
    now = 0.0
    for i, event in _in_order(plan):
        reference, now = reference + shape.cruise_mps * (event.at_s - now), event.at_s
        if any(reference + shape.ahead(boat.number) >= boat.path.length for boat in lines):
            wrong = "by then the foremost boat has reached the end of its path, and the mission is over"
            yield Problem(("timeline", i, "at_s"), wrong, event.at_s)
            return
        if i in later:
            new = later[i]
            places = {boat.name: reference + shape.ahead(boat.number) for boat in sailing}
            if event.do != "set speed":
                for misfit in place_misfits(plan, new, places, before=shape):
                    yield Problem(("timeline", i, "value"), f"about {event.at_s:g} s {misfit.text}", event.value)
            reference += sum(shape.ahead(b.number) - new.ahead(b.number) for b in sailing) / len(sailing)
            shape = new


def _in_order(plan: Plan) -> list[tuple[int, Event]]:
    """The entries by time, with their places in the file."""
    return sorted(enumerate(plan.mission.timeline), key=lambda item: item[1].at_s)
