"""What GUIDED makes of a set-point, and what LOITER and a speed controller make of a hull. No time, no messages."""

from __future__ import annotations

import math

from msgspec import Struct

FRAMES = (1, 7, 8, 9)
POSITION, VELOCITY, ACCELERATION, YAW, YAW_RATE = 0x7, 0x18, 0x1C0, 0x400, 0x800
TURN_PER_RAD = 1.0  # heading error to yaw rate [1/s]
SURGE_GAIN, YAW_GAIN = 0.35, 0.8  # integral of the error added to a set-point [1/s]: makes it overshoot, as seen
MOST_SURGE_MPS, MOST_YAW_RADPS = 0.4, 0.15  # the integrals stay within


class Aim(Struct, frozen=True):
    """What the boat is to do."""

    speed_mps: float = 0.0
    yaw_rate_radps: float | None = None
    course_rad: float | None = None


class Refused(Exception):
    """A set-point that is dropped; its text is said, or none."""


def aim_of(frame: int, mask: int, vx: float, vy: float, yaw: float, yaw_rate: float) -> Aim:
    """What Rover takes SET_POSITION_TARGET_LOCAL_NED for; targets by position are not imitated."""
    if frame not in FRAMES:
        raise Refused
    if mask & ACCELERATION != ACCELERATION:
        raise Refused("Ignoring SET_POSITION_TARGET_LOCAL_NED; set ACC_IGNORE in mask")
    if mask & POSITION != POSITION:
        raise Refused
    by_yaw, by_rate = not mask & YAW, not mask & YAW_RATE
    if (by_yaw and by_rate) or not math.isfinite(vx + vy + yaw + yaw_rate):
        raise Refused
    moves = not mask & VELOCITY
    speed = math.hypot(vx, vy) if moves else 0.0
    if by_rate:
        return Aim(math.copysign(speed, vx), yaw_rate)
    if by_yaw:
        return Aim(math.copysign(speed, vx), course_rad=yaw)
    if not moves:
        raise Refused
    return Aim(speed, course_rad=math.atan2(vy, vx) if speed > 0.0 else None)


def steer(aim: Aim, psi: float, fastest_mps: float, turn_max: float) -> tuple[float, float]:
    """(surge [m/s], yaw rate [rad/s]) that an aim asks of a boat on heading psi [rad]."""
    rate = aim.yaw_rate_radps or 0.0
    if aim.course_rad is not None:
        rate = TURN_PER_RAD * math.remainder(aim.course_rad - psi, 2.0 * math.pi)
    return min(max(aim.speed_mps, -fastest_mps), fastest_mps), min(max(rate, -turn_max), turn_max)


def stay(dx: float, dy: float, psi: float, radius_m: float) -> tuple[float, float]:
    """(surge, yaw rate) of LOITER for a point at (dx, dy) [m] from the boat: inside its radius the boat only brakes."""
    away_m = math.hypot(dx, dy)
    if away_m < radius_m:
        return 0.0, 0.0
    error = math.remainder(math.atan2(dy, dx) - psi, 2.0 * math.pi)
    speed = min(0.5 * (away_m - radius_m) + 0.2, 1.0)
    if abs(error) > 0.5 * math.pi:
        error, speed = math.remainder(error + math.pi, 2.0 * math.pi), -speed
    return speed * max(0.0, math.cos(error)), TURN_PER_RAD * error


class Loops(Struct):
    """Integrals of the autopilot's speed and turn controllers; what they add makes a hull overshoot a step."""

    surge: float = 0.0
    yaw: float = 0.0

    def ask(self, u_d: float, r_d: float, u: float, r: float, dt: float) -> tuple[float, float]:
        """What is asked of the hull, which has lags of its own."""
        if u_d == 0.0:
            self.surge = 0.0
        self.surge = _within(self.surge + dt * SURGE_GAIN * (u_d - u), MOST_SURGE_MPS)
        self.yaw = _within(self.yaw + dt * YAW_GAIN * (r_d - r), MOST_YAW_RADPS)
        return u_d + self.surge, r_d + self.yaw

    def reset(self) -> None:
        """The boat is not driven."""
        self.surge = self.yaw = 0.0


def _within(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
