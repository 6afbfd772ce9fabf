"""What a boat of the fleet looks like as a MAVLink vehicle: modes, arming, health. Pure."""

from __future__ import annotations

from fleet.agent.modes import UNDER_ORDERS, Mode, Reason
from fleet.drivers.mavlink.words import ARMED, AUTO, CUSTOM_MODE, GUIDED, HOLD, LOITER
from fleet.gcs.numbers import RTL, SMART_RTL
from fleet.wire.messages import BoatState

STANDBY, ACTIVE, CRITICAL = 3, 4, 5  # system_status
WAIT_S = 5.0  # a mode that was asked for and accepted is shown so long before the boat is seen in it
GENERIC_MODES = {AUTO: 4 | 8, GUIDED: 8, RTL: 4 | 8, SMART_RTL: 4 | 8, LOITER: 16, HOLD: 0}  # bits of base_mode

NAVIGATION, AUTHORITY, DRIVER, EMPTY = map(
    int, (Reason.NAVIGATION, Reason.AUTHORITY, Reason.DRIVER, Reason.BATTERY_CRITICAL)
)  # plain numbers: an `&` of flags costs a microsecond
BAD = NAVIGATION | AUTHORITY | DRIVER | EMPTY


def modes_of(state: BoatState, going: bool) -> tuple[int, ...]:
    """Modes that a boat may be shown in now; the first one unless another of them was asked for."""
    mode = state.mode
    if mode in (Mode.FOLLOW, Mode.AVOID, Mode.ALONE):
        return (GUIDED,) if going else (AUTO,)
    if mode == Mode.RETURN:
        return RTL, SMART_RTL
    if mode == Mode.HOLD:
        return LOITER, HOLD, GUIDED
    if mode == Mode.STANDBY:
        return HOLD, LOITER, GUIDED
    return (HOLD,)


def shown_mode(state: BoatState, going: bool, asked: int, asked_s: float, now_s: float) -> int:
    """Rover's mode number for what the boat does.

    Args:
        state: as it was heard
        going: the mission that it sails is a ground station's go-to
        asked: mode that a ground station asked for last and got; -1 none
        asked_s: when
        now_s: the time now
    """
    fitting = modes_of(state, going)
    if asked in fitting:
        return asked
    waits = asked >= 0 and now_s - asked_s < WAIT_S and state.mode not in (Mode.NEUTRAL, Mode.FAULT)
    return asked if waits else fitting[0]


def armed(state: BoatState, ready: bool) -> bool:
    """Whether its thrusters may turn by the fleet's orders; `ready`: a ground station has armed it, and it waits."""
    return state.mode in UNDER_ORDERS or (ready and state.mode == Mode.STANDBY)


def base_mode(mode: int, is_armed: bool) -> int:
    """Bits of the HEARTBEAT: armed, the custom mode counts, and what stations go by that know no Rover."""
    return CUSTOM_MODE | GENERIC_MODES.get(mode, 0) | (ARMED if is_armed else 0)


def system_status(state: BoatState) -> int:
    """Of the HEARTBEAT."""
    if state.mode == Mode.FAULT or state.reasons & BAD:
        return CRITICAL
    return ACTIVE if state.mode in UNDER_ORDERS else STANDBY


def sound(state: BoatState) -> bool:
    """Whether its position is one."""
    return state.mode != Mode.FAULT and not state.reasons & NAVIGATION


def why_not_ready(state: BoatState) -> str:
    """Why it cannot be armed; '' when it can."""
    if state.mode == Mode.FAULT or not sound(state):
        return "own navigation is stale or not finite"
    if state.reasons & AUTHORITY:
        return "somebody else commands the boat"
    if state.reasons & DRIVER:
        return "the driver cannot command the boat"
    if state.reasons & EMPTY:
        return "battery critical"
    return ""
