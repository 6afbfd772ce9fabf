"""MAVLink's numbers and names, as ArduPilot Rover uses them; the one place that imports the dialect."""

from __future__ import annotations

from typing import Any

from fleet.errors import ConfigError

GUIDED, LOITER, HOLD, MANUAL, AUTO, INITIALISING = 15, 5, 4, 0, 10, 16
MODES = {
    0: "MANUAL",
    1: "ACRO",
    3: "STEERING",
    4: "HOLD",
    5: "LOITER",
    6: "FOLLOW",
    7: "SIMPLE",
    10: "AUTO",
    11: "RTL",
    12: "SMART_RTL",
    15: "GUIDED",
    16: "INITIALISING",
}
ARMED = 128  # bit of base_mode
CUSTOM_MODE = 1  # bit of base_mode: custom_mode counts
CRITICAL = 5  # system_status: a failsafe acts

HEARTBEAT, SYS_STATUS, PARAM_VALUE, GPS_RAW_INT, ATTITUDE = 0, 1, 22, 24, 30
GLOBAL_POSITION_INT, COMMAND_ACK, EKF_STATUS_REPORT, STATUSTEXT = 33, 77, 193, 253

DO_SET_MODE, ARM_DISARM, SET_MESSAGE_INTERVAL = 176, 400, 511
ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4
RESULTS = {
    0: "accepted",
    1: "temporarily rejected",
    2: "denied",
    3: "unsupported",
    4: "failed",
    5: "in progress",
    6: "cancelled",
}

BODY_NED = 8
SURGE_AND_YAW_RATE = 0x5C7  # position, acceleration and yaw are to be ignored
PRE_ARM = 0x10000000  # bit of SYS_STATUS: the checks before arming are good
EKF_ABSOLUTE, EKF_CONSTANT, EKF_UNINITIALISED = 0x10, 0x80, 0x400

ONBOARD_CONTROLLER, INVALID_AUTOPILOT, ARDUPILOT, SURFACE_BOAT = 18, 8, 3, 11
AUTOPILOT_COMPONENT, ONBOARD_COMPUTER = 1, 191


def dialect() -> Any:
    """The dialect of ArduPilot; ConfigError where pymavlink is not installed. Takes 0.04 s and 12 MB, once."""
    try:
        from pymavlink.dialects.v20 import ardupilotmega
    except ImportError:
        raise ConfigError(
            "driver mavlink needs pymavlink, which is not installed; pip install 'fleet-usv[mavlink]'"
        ) from None
    return ardupilotmega


def mode_name(mode: int) -> str:
    """The mode as Rover calls it, its number where it has no name here."""
    return MODES.get(mode, f"mode {mode}")
