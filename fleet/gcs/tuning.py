"""Parameters of a boat: told, set by the way that an operator's changes go, and refused in words."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from fleet.agent.modes import Mode
from fleet.gcs import numbers as n
from fleet.gcs.parameters import NUMBERS, PARAMETERS, worded, wrong
from fleet.gcs.seat import Peer, Station
from fleet.gcs.wishes import Done

if TYPE_CHECKING:
    from fleet.gcs.vehicle import Vehicle


def value_of(v: Vehicle, name: str) -> float:
    """Of a parameter, as it is in force."""
    if name == "FLT_ALONE":
        return float(v.alone)
    if name == "FLT_CONTROL":
        return float(v.shared.controls(v.boat) == v.shared.operator)
    if name in ("MAV_SYSID", "ARMING_CHECK"):
        return float(v.sysid) if name == "MAV_SYSID" else 1.0
    return v.shared.value(v.boat, name, v.now_s)


def tell_parameter(v: Vehicle, peer: Peer | None, name: str, number: int | None = None) -> None:
    """The value in force, with its place in the list."""
    value = v.values[name] = value_of(v, name)
    index = NUMBERS[name] if number is None else number
    make = v.mavlink.MAVLink_param_value_message
    v.send(peer, make(name.encode(), value, n.REAL32, len(PARAMETERS), index))


def read_parameter(v: Vehicle, peer: Peer, m: Any) -> None:
    """One is asked for, by its name or its place."""
    if 0 <= m.param_index < len(PARAMETERS):
        tell_parameter(v, peer, PARAMETERS[m.param_index].name)
    elif m.param_index < 0 and m.param_id in NUMBERS:
        tell_parameter(v, peer, m.param_id)


def watch(v: Vehicle) -> None:
    """Values that somebody else changed are told to all."""
    for name, before in list(v.values.items()):
        if value_of(v, name) != before:
            tell_parameter(v, None, name)


def set_parameter(v: Vehicle, station: Station, m: Any) -> None:
    """One is set: the answer is the value in force, and words where it was refused."""
    peer, name, value = station[0], m.param_id, float(m.param_value)
    if name not in NUMBERS:
        v.say(peer, n.WARNING, f"no parameter {name[:16]}")
        return
    parameter = PARAMETERS[NUMBERS[name]]
    value = round(value, 6)  # a float32 of 0.3 is meant to be 0.3

    def answer(why: str) -> None:
        if why:
            v.say(peer, n.WARNING, f"{name} refused: {why}" if not why.startswith(name) else why)
        tell_parameter(v, None if not why else peer, name)

    why = wrong(parameter, value)
    if not why and name == "FLT_CONTROL":
        take_control(v, station, value, answer)
        return
    why = why or v.shared.seat.refusal(station, v.now_s)
    if why:
        answer(why)
    elif name == "FLT_ALONE":
        v.alone = value == 1.0
        answer("")
    elif parameter.kind == "formation" and v.shared.plan(v.boat) is not None:
        change(v, parameter.change, worded(parameter, value, v.boat), name, value, answer)
    else:
        answer(draft(v, parameter.field, worded(parameter, value, v.boat)))


def draft(v: Vehicle, field: str, value: float | str) -> str:
    """For the next mission; '' or why not."""
    if not field:
        return "no mission; slots are the boats' order until there is one"
    state = v.shared.state(v.boat)
    if state is not None and state.mode in (Mode.FOLLOW, Mode.AVOID) and v.shared.plan(v.boat) is not None:
        return "not while the mission is sailed"
    setattr(v.shared.draft, field, value)
    return ""


def change(v: Vehicle, what: str, value: float | str, name: str, number: float, answer: Callable[[str], None]) -> None:
    """Change the formation that boats sail, as an operator does."""

    def then(done: Done) -> None:
        if done.ok:
            own = name == "FLT_SLOT"
            v.shared.accept(v.boat if own else "", name, number, v.now_s)
            if done.text:
                v.tell(n.WARNING, done.text)
        answer("" if done.ok else done.text)

    v.ask("set", (what, value), then)


def take_control(v: Vehicle, station: Station, value: float, answer: Callable[[str], None]) -> None:
    """`fleet take`; the station has the seat then."""
    if value != 1.0:
        answer("control is not given back; another operator takes it")
        return

    def then(done: Done) -> None:
        if done.ok:
            v.shared.seat.take(station)
            v.tell(n.NOTICE, f"control is with {v.shared.operator}")
        answer("" if done.ok else done.text)

    v.ask("take", None, then)
