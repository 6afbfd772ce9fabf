"""Where another vehicle is by now, by what it said some time ago."""

from __future__ import annotations

from fleet import ops
from fleet.ops import R

FRESH_S = 0.5
"""A message so young is carried on straight: a turn does not tell within it."""
TURNS_ON_S = 1.0
"""So long a boat is taken to go on turning beyond that: it turns to something."""
MOST_TURN_RAD = 0.6


def reckoned(x: R, y: R, vx: R, vy: R, r: R, age: R) -> tuple[R, R, R, R]:
    """Position and velocity after `age` [s]: straight on, or in a turn where the message is late.

        h = clip(r clip(age - 0.5 s, 0, 1 s), -0.6, 0.6) / 2      half of what it has turned by
        p' = p + Q(h) v age,  v' = Q(2h) v                        Q(a): rotation by a, + to starboard

    Args:
        x, y: position when it spoke [m]
        vx, vy: velocity over ground when it spoke [m/s]
        r: yaw rate when it spoke, + to starboard [rad/s]

    Returns:
        x, y [m], vx, vy [m/s]
    """
    turning = ops.clip(age - FRESH_S, 0.0, TURNS_ON_S)
    if not ops.some(turning > 0.0):
        return x + vx * age, y + vy * age, vx, vy
    s, c = ops.sincos(0.5 * ops.clip(r * turning, -MOST_TURN_RAD, MOST_TURN_RAD))
    mx, my = c * vx - s * vy, s * vx + c * vy
    return x + mx * age, y + my * age, c * mx - s * my, s * mx + c * my
