"""What a ground station's commands mean for a boat of a fleet."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from fleet.drivers.mavlink.words import AUTO, GUIDED, HOLD, LOITER
from fleet.errors import FleetError
from fleet.gcs import display, tuning
from fleet.gcs import numbers as n
from fleet.gcs.chart import Pose, straight_to
from fleet.gcs.items import place_of
from fleet.gcs.modes import Answer, accept, hold, refuse, set_mode, state_of, tears, wish
from fleet.gcs.seat import Station
from fleet.gcs.telemetry import MAKERS
from fleet.gcs.wishes import Done

if TYPE_CHECKING:
    from fleet.gcs.vehicle import Vehicle

NOWHERE = 2**31 - 1  # of a coordinate that is left as it is


def obey(v: Vehicle, station: Station, m: Any) -> None:
    """A COMMAND_LONG or COMMAND_INT: do it, or say why not; the acknowledgement comes when the boats have answered."""
    peer, sysid = station
    key = (peer, sysid, m.command)
    if key in v.busy:  # said again while it is being done
        return
    v.busy.add(key)
    to = (m.get_srcSystem(), m.get_srcComponent())

    def answer(result: int) -> None:
        v.busy.discard(key)
        v.send(peer, v.mavlink.MAVLink_command_ack_message(m.command, result, 0, 0, *to))

    command = m.command
    if command == n.DO_SET_MODE:
        set_mode(v, station, _whole(m.param2), answer)
    elif command == n.ARM_DISARM:
        arm(v, station, m, answer)
    elif command == n.MISSION_START:
        set_mode(v, station, AUTO, answer)
    elif command == n.RETURN_TO_LAUNCH:
        set_mode(v, station, n.RTL, answer)
    elif command == n.LOITER_UNLIMITED:
        set_mode(v, station, LOITER, answer)
    elif command == n.DO_PAUSE_CONTINUE:
        set_mode(v, station, AUTO if m.param1 == 1.0 else LOITER, answer)
    elif command == n.DO_CHANGE_SPEED:
        change_speed(v, station, m.param2, answer)
    elif command == n.DO_REPOSITION:
        x, y, frame = (m.x, m.y, m.frame) if m.get_type() == "COMMAND_INT" else _degrees(m)
        go_to(v, station, x, y, frame, m.param1, answer)
    elif command in (n.REQUEST_MESSAGE, n.REQUEST_CAPABILITIES, n.GET_HOME):
        number = {n.REQUEST_CAPABILITIES: n.AUTOPILOT_VERSION, n.GET_HOME: n.HOME_POSITION}.get(command)
        hand_out(v, station, _whole(m.param1) if number is None else number, answer)
    elif command == n.SET_MESSAGE_INTERVAL:
        answer(n.ACCEPTED if _whole(m.param1) in MAKERS else n.UNSUPPORTED)  # rates are what they are
    else:
        answer(n.UNSUPPORTED)


def _whole(value: float) -> int:
    return int(value) if math.isfinite(value) and abs(value) < 2**31 else -1


def _degrees(m: Any) -> tuple[int, int, int]:
    """Latitude and longitude of a COMMAND_LONG, frame 0."""
    lat, lon = m.param5, m.param6
    known = math.isfinite(lat) and math.isfinite(lon) and abs(lat) <= 180.0 and abs(lon) <= 180.0
    return (round(lat * 1e7), round(lon * 1e7), 0) if known else (NOWHERE, NOWHERE, 0)


def hand_out(v: Vehicle, station: Station, number: int, answer: Answer) -> None:
    """A message by its number, once."""
    if number not in MAKERS or v.shown is None:
        answer(n.UNSUPPORTED)
        return
    answer(n.ACCEPTED)
    v.report(station[0], number, v.shown)


def arm(v: Vehicle, station: Station, m: Any, answer: Answer) -> None:
    """Arm: lift our own stop, take control if nobody has it, be ready. Disarm: no thrust until armed again."""
    if m.param1 == 0.0:
        _disarm(v, station, answer)
        return
    if m.param1 != 1.0 or m.param2 != 0.0:
        refuse(v, station, answer, "arming by force refused")
        return
    state = state_of(v, station, "arming", answer)
    if state is None:
        return
    foreign = [stop for stop in state.stops if stop not in v.shared.own_stops]
    holder = state.control.operator
    why = v.shared.seat.refusal(station, v.now_s) or display.why_not_ready(state)
    if not why and foreign:
        why = "stopped by another operator; `fleet release` lifts it"
    if not why and holder not in ("", v.shared.operator):
        why = f"{holder} holds control; FLT_CONTROL 1 takes it"
    if why:
        refuse(v, station, answer, f"arming refused: {why}")
        return

    def ready(_: object) -> None:
        v.ready = True

    wish(v, station, "arming", "ready", answer, value=tuple(state.stops), did=ready)


def _disarm(v: Vehicle, station: Station, answer: Answer) -> None:
    """A stop: never refused, never asked whose turn it is."""

    def then(done: Done) -> None:
        if not done.ok:
            refuse(v, station, answer, f"disarming: {done.text}", n.FAILED)
            return
        v.shared.own_stops.add(done.value)
        v.ready = False
        v.tell(n.NOTICE, f"{v.boat} has no thrust until it is armed again")
        accept(v, HOLD, answer)

    v.ask("stop", None, then)


def change_speed(v: Vehicle, station: Station, speed_mps: float, answer: Answer) -> None:
    """The cruise speed of the formation."""
    if speed_mps == -1.0:
        answer(n.ACCEPTED)
        return
    if not 0.0 < speed_mps < 100.0:
        refuse(v, station, answer, f"speed {speed_mps:g} m/s refused: expected more than 0")
        return
    why = v.shared.seat.refusal(station, v.now_s)
    if not why and v.shared.plan(v.boat) is None:
        why = "no mission; FLT_CRUISE sets the next one's"
    if why:
        refuse(v, station, answer, f"speed refused: {why}")
        return
    speed_mps = round(speed_mps, 6)

    def done(why: str) -> None:
        if why:
            refuse(v, station, answer, f"speed refused: {why}")
        else:
            answer(n.ACCEPTED)

    tuning.change(v, "speed", speed_mps, "FLT_CRUISE", speed_mps, done)


def go_to(v: Vehicle, station: Station, x: int, y: int, frame: int, speed_mps: float, answer: Answer) -> None:
    """Straight to a place and hold there: a mission of this boat alone, if that tears no formation."""
    state = state_of(v, station, "go-to", answer)
    if state is None:
        return
    if x == NOWHERE and y == NOWHERE:  # stay
        hold(v, station, LOITER, "LOITER", answer)
        return
    target = place_of(x, y) if frame in n.GLOBAL_FRAMES else None
    why = v.shared.seat.refusal(station, v.now_s) or tears(v, "a go-to")
    if target is None:
        why = f"frame {frame}, {x / 1e7:g}, {y / 1e7:g} is no position"
    if why:
        refuse(v, station, answer, f"go-to refused: {why}")
        return
    assert target is not None
    pose = Pose(state.lat_deg, state.lon_deg, 0.0)
    course = straight_to(pose, target, speed_mps if 0.0 < speed_mps < 100.0 else None)
    try:
        mission = v.shared.mission_for(course, v.boat, alone=True, title=f"{v.boat}: go-to from a ground station")
    except FleetError as error:
        refuse(v, station, answer, f"go-to refused: {error}")
        return

    def sails(mission_id: str | None) -> None:
        v.going = mission_id or "?"
        v.shared.learn(v.going, mission)

    wish(v, station, "go-to", "start", answer, asked=GUIDED, value=mission, did=sails)
