"""What we say to an autopilot: set-points, commands, parameters, our own HEARTBEAT. Builds frames, sends none."""

from __future__ import annotations

from typing import Any

from fleet.drivers.mavlink import words

NONE = (0.0,) * 7


class Talk:
    """Encodes for one autopilot, under our own name; one owner, one sequence of numbers."""

    def __init__(self, mavlink: Any, own_sysid: int, sysid: int) -> None:
        self._mavlink = mavlink
        self.codec = mavlink.MAVLink(None, srcSystem=own_sysid, srcComponent=words.ONBOARD_COMPUTER)
        self._to = (sysid, words.AUTOPILOT_COMPONENT)

    def _pack(self, message: Any) -> bytes:
        frame: bytes = bytes(message.pack(self.codec))
        self.codec.seq = (self.codec.seq + 1) % 256
        return frame

    def heartbeat(self) -> bytes:
        """We are there; an autopilot whose MAV_GCS_SYSID we are waits for it."""
        kind, autopilot = words.ONBOARD_CONTROLLER, words.INVALID_AUTOPILOT
        return self._pack(self._mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, 0, 4, 3))

    def setpoint(self, boot_ms: int, surge_mps: float, yaw_rate_radps: float) -> bytes:
        """Surge along the heading [m/s] and yaw rate, + to starboard [rad/s]; obeyed in GUIDED only."""
        zeros = (0.0, 0.0, 0.0)
        return self._pack(
            self._mavlink.MAVLink_set_position_target_local_ned_message(
                boot_ms & 0xFFFFFFFF,
                *self._to,
                words.BODY_NED,
                words.SURGE_AND_YAW_RATE,
                *zeros,
                surge_mps,
                0.0,
                0.0,
                *zeros,
                0.0,
                yaw_rate_radps,
            )
        )

    def command(self, number: int, *params: float, confirmation: int = 0) -> bytes:
        """A COMMAND_LONG."""
        filled = (*params, *NONE)[:7]
        return self._pack(self._mavlink.MAVLink_command_long_message(*self._to, number, confirmation, *filled))

    def set_mode(self, mode: int, confirmation: int = 0) -> bytes:
        """Ask for a mode."""
        return self.command(words.DO_SET_MODE, words.CUSTOM_MODE, mode, confirmation=confirmation)

    def arm(self, armed: bool) -> bytes:
        """Ask to arm or disarm; never forced."""
        return self.command(words.ARM_DISARM, 1.0 if armed else 0.0)

    def rate(self, message: int, hz: float) -> bytes:
        """Ask for a message so many times a second."""
        return self.command(words.SET_MESSAGE_INTERVAL, message, 1e6 / hz)

    def ask_parameter(self, name: str) -> bytes:
        """Ask for a parameter by its name."""
        return self._pack(self._mavlink.MAVLink_param_request_read_message(*self._to, name.encode(), -1))

    def set_parameter(self, name: str, value: float) -> bytes:
        """Set a parameter; the autopilot answers with the value that it holds then."""
        return self._pack(self._mavlink.MAVLink_param_set_message(*self._to, name.encode(), value, 9))
