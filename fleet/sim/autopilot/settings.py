"""Parameters of the simulated autopilot: names and defaults of ArduPilot Rover 4.7, so far as anybody asks."""

from __future__ import annotations

DEFAULTS: dict[str, float] = {
    "MAV_SYSID": 1,
    "MAV_GCS_SYSID": 255,
    "MAV_OPTIONS": 0,
    "FRAME_CLASS": 2,
    "INITIAL_MODE": 0,
    "ARMING_CHECK": 1,
    "FS_ACTION": 2,
    "FS_TIMEOUT": 1.5,
    "FS_GCS_ENABLE": 0,
    "FS_GCS_TIMEOUT": 5,
    "FS_EKF_ACTION": 1,
    "FS_EKF_THRESH": 0.8,
    "WP_SPEED": 5,
    "CRUISE_SPEED": 2,
    "ATC_STR_RAT_MAX": 120,
    "LOIT_RADIUS": 2,
    "SCHED_LOOP_RATE": 50,
}
