"""What a ground station's modes mean for a boat of a fleet: hold, start, resume, return."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from fleet.agent.modes import Mode, Reason
from fleet.drivers.mavlink.words import AUTO, GUIDED, HOLD, LOITER, mode_name
from fleet.errors import FleetError
from fleet.gcs import numbers as n
from fleet.gcs.seat import Station
from fleet.gcs.wishes import Done, Kind
from fleet.wire.messages import BoatState

if TYPE_CHECKING:
    from fleet.gcs.vehicle import Vehicle

Answer = Callable[[int], None]
"""Takes the result of a command."""
SAILS = (Mode.FOLLOW, Mode.AVOID, Mode.ALONE)


def refuse(v: Vehicle, station: Station, answer: Answer, why: str, result: int = n.DENIED) -> None:
    """Say why, and that it is not done."""
    v.say(station[0], n.WARNING, why)
    answer(result)


def state_of(v: Vehicle, station: Station, what: str, answer: Answer) -> BoatState | None:
    """The boat's state; refuses where it is not heard."""
    state = v.shared.state(v.boat)
    if state is None or v.quiet:
        refuse(v, station, answer, f"{what} refused: {v.boat} is not heard", n.FAILED)
        return None
    return state


def wish(
    v: Vehicle,
    station: Station,
    what: str,
    kind: Kind,
    answer: Answer,
    *,
    asked: int = -1,
    value: Any = None,
    did: Callable[[Any], None] = lambda value: None,
) -> None:
    """Ask the fleet; acknowledge when it has answered.

    Args: asked: mode to be shown then, -1 none; did: takes what came of it, once the boats have agreed.
    """

    def acknowledge(done: Done) -> None:
        """The boats have answered, or not in time."""
        if not done.ok:
            refuse(v, station, answer, f"{what} refused: {done.text}", n.FAILED if done.silent else n.DENIED)
            return
        did(done.value)
        if done.text:
            v.tell(n.WARNING, f"{what}: {done.text}")
        accept(v, asked, answer)

    v.ask(kind, value, acknowledge)


def accept(v: Vehicle, asked: int, answer: Answer) -> None:
    """It is done: acknowledged, and shown at once."""
    if asked >= 0:
        v.asked, v.asked_s = asked, v.now_s
    answer(n.ACCEPTED)
    v.beat()


def set_mode(v: Vehicle, station: Station, mode: int, answer: Answer) -> None:
    """HOLD, LOITER: hold. AUTO: start or resume. RTL: return. GUIDED: hold, and wait for a place to go to."""
    name = mode_name(mode)
    if mode not in n.OBEYED_MODES:
        known = ", ".join(mode_name(one) for one in n.OBEYED_MODES)
        refuse(v, station, answer, f"{name} refused: boats of a fleet know {known}")
        return
    if mode in (HOLD, LOITER):
        hold(v, station, mode, name, answer)
        return
    state = state_of(v, station, name, answer)
    if state is None:
        return
    if mode == GUIDED:
        if state.mode in SAILS or state.mode == Mode.RETURN:
            hold(v, station, mode, name, answer)
        else:
            accept(v, mode, answer)
        return
    why = v.shared.seat.refusal(station, v.now_s)
    if why:
        refuse(v, station, answer, f"{name} refused: {why}")
    elif mode == AUTO:
        _auto(v, station, state, answer)
    else:
        wish(v, station, name, "return", answer, asked=mode)


def set_mode_unanswered(v: Vehicle, station: Station, mode: int) -> None:
    """SET_MODE, the old way, that nobody acknowledges; one at a time."""
    key = (*station, -1)
    if key not in v.busy:
        v.busy.add(key)
        set_mode(v, station, mode, lambda result: v.busy.discard(key))


def hold(v: Vehicle, station: Station, mode: int, name: str, answer: Answer) -> None:
    """Anybody may stop a boat, and one that is not heard is asked all the same."""
    state = v.shared.state(v.boat)
    if mode == HOLD and state is not None and state.mode == Mode.STANDBY and not v.quiet:
        accept(v, mode, answer)  # it has no thrust; LOITER makes it keep station
        return
    wish(v, station, name, "hold", answer, asked=mode)


def _auto(v: Vehicle, station: Station, state: BoatState, answer: Answer) -> None:
    """What was uploaded and waits is started; else the boat goes on with the mission that it holds."""
    charted = v.charted
    over = not state.mission_id or bool(state.reasons & (Reason.MISSION_ENDED | Reason.ABORTED))
    if charted is not None and (not charted.mission_id or over):
        start(v, station, answer)
    elif state.mode in SAILS:
        accept(v, AUTO, answer)
    elif over:
        why = "the mission has ended" if state.mission_id else "no mission"
        refuse(v, station, answer, f"AUTO refused: {why}; upload one", n.FAILED)
    else:
        wish(v, station, "AUTO", "resume", answer, asked=AUTO)


def start(v: Vehicle, station: Station, answer: Answer) -> None:
    """Launch what was uploaded, as the formation is now."""
    charted = v.charted
    assert charted is not None
    why = tears(v, "a mission of its own") if charted.alone else ""
    if why:
        refuse(v, station, answer, f"AUTO refused: {why}")
        return
    try:
        mission = v.shared.mission_for(charted.course, charted.boat, alone=charted.alone)
    except FleetError as error:
        refuse(v, station, answer, f"AUTO refused: {error}")
        return
    roster = [boat.name for boat in mission.boats]
    if v.boat not in roster:
        refuse(v, station, answer, f"AUTO refused: what was uploaded is for {', '.join(roster)}")
        return

    def sails(mission_id: str | None) -> None:
        charted.mission_id = mission_id or "?"
        v.shared.learn(charted.mission_id, mission)

    wish(v, station, "AUTO", "start", answer, asked=AUTO, value=mission, did=sails)


def tears(v: Vehicle, what: str) -> str:
    """Why a boat cannot leave its formation now; '' when it sails in none."""
    state = v.shared.state(v.boat)
    company = v.shared.in_company(v.boat)
    if state is not None and state.mode in SAILS and company > 1:
        return f"{what} would take {v.boat} out of a formation of {company}; HOLD it first"
    if state is not None and state.mode in SAILS and state.mission_id and not company:
        return f"{v.boat} sails a mission that is not known here yet"
    return ""
