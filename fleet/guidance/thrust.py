"""Four thrusters of a catamaran share a surge force and a yaw moment: a rear pair and a side pair, all along the hull.

Two thrusters of a pair sit at +-arm from the middle line, so that a pair gives

    X = T_port + T_starboard,  N = arm (T_port - T_starboard)

The rear pair drives and steers. The side pair only steers: it pushes one ahead and one astern, equally.
"""

from __future__ import annotations

from typing import Annotated, Generic

from msgspec import Meta, Struct

from fleet import ops
from fleet.ops import R


class Thrusters(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the thrusters can do; defaults are the parts of VIAM-USV2000 (Tran et al. 2021, table 1) and our guesses.

    Rear: Endura C2 30, whose name says 30 lbf; astern assumed half of it. Side: T200 at 12 V, by its maker's figures.
    The arms are those of a boat 2 m long; neither arms nor rates are printed.
    """

    rear_ahead_n: Annotated[float, Meta(gt=0.0, le=1e5)] = 133.0  # of one thruster
    rear_astern_n: Annotated[float, Meta(gt=0.0, le=1e5)] = 66.0
    rear_arm_m: Annotated[float, Meta(gt=0.0, le=10.0)] = 0.4  # from the middle line
    rear_rate_n_per_s: Annotated[float, Meta(gt=0.0)] = 130.0
    side_ahead_n: Annotated[float, Meta(ge=0.0, le=1e5)] = 36.0  # 0: no side thrusters
    side_astern_n: Annotated[float, Meta(ge=0.0, le=1e5)] = 28.0
    side_arm_m: Annotated[float, Meta(gt=0.0, le=10.0)] = 0.5
    side_rate_n_per_s: Annotated[float, Meta(gt=0.0)] = 110.0

    @property
    def side_moment_max(self) -> float:
        """What the side pair gives without pushing the boat [Nm]."""
        return 2.0 * self.side_arm_m * min(self.side_ahead_n, self.side_astern_n)

    @property
    def rear_moment_max(self) -> float:
        """What the rear pair gives without pushing the boat [Nm]."""
        return 2.0 * self.rear_arm_m * min(self.rear_ahead_n, self.rear_astern_n)

    @property
    def moment_max(self) -> float:
        """The largest yaw moment that `allocate` gives [Nm]."""
        return self.side_moment_max + self.rear_moment_max


class Thrusts(Struct, Generic[R], frozen=True, gc=False):
    """Force of each thruster, + ahead [N]."""

    rear_port: R
    rear_starboard: R
    side_port: R
    side_starboard: R


def allocate(surge: R, yaw: R, thrusters: Thrusters) -> Thrusts[R]:
    """Thrusts for a surge force and a yaw moment.

    The moment comes first, from the side pair as far as that goes, the rest from the rear pair as a difference. What
    then is left of the rear pair drives. So a moment up to `moment_max` is given whatever force is asked for, and a
    force beyond what is left is cut. A moment never pushes the boat: at no force asked the sum of the thrusts is zero.

    Args:
        surge: force along the hull, + ahead [N]
        yaw: moment, + turns to starboard [Nm]
        thrusters: limits and arms
    """
    side_max, rear_max = thrusters.side_moment_max, thrusters.rear_moment_max
    by_side = ops.clip(yaw, -side_max, side_max)
    by_rear = ops.clip(yaw - by_side, -rear_max, rear_max)
    side, half = by_side * (0.5 / thrusters.side_arm_m), by_rear * (0.5 / thrusters.rear_arm_m)
    used = abs(half)
    drive = ops.clip(0.5 * surge, used - thrusters.rear_astern_n, thrusters.rear_ahead_n - used)
    return Thrusts(drive + half, drive - half, side, -side)


def resultant(thrusts: Thrusts[R], thrusters: Thrusters) -> tuple[R, R]:
    """(X, N): force [N] and moment [Nm] of all four."""
    rear = thrusters.rear_arm_m * (thrusts.rear_port - thrusts.rear_starboard)
    side = thrusters.side_arm_m * (thrusts.side_port - thrusts.side_starboard)
    drive, balance = thrusts.rear_port + thrusts.rear_starboard, thrusts.side_port + thrusts.side_starboard
    return drive + balance, rear + side


def limited(wanted: Thrusts[R], thrusters: Thrusters) -> Thrusts[R]:
    """The same thrusts, each within the limits of its thruster."""
    rear, side = (-thrusters.rear_astern_n, thrusters.rear_ahead_n), (-thrusters.side_astern_n, thrusters.side_ahead_n)
    return Thrusts(
        ops.clip(wanted.rear_port, *rear),
        ops.clip(wanted.rear_starboard, *rear),
        ops.clip(wanted.side_port, *side),
        ops.clip(wanted.side_starboard, *side),
    )


def slew(now: Thrusts[R], wanted: Thrusts[R], thrusters: Thrusters, dt: float) -> Thrusts[R]:
    """The thrusts dt seconds later: each moves towards what is wanted no faster than its rate."""
    rear, side = dt * thrusters.rear_rate_n_per_s, dt * thrusters.side_rate_n_per_s
    return Thrusts(
        now.rear_port + ops.clip(wanted.rear_port - now.rear_port, -rear, rear),
        now.rear_starboard + ops.clip(wanted.rear_starboard - now.rear_starboard, -rear, rear),
        now.side_port + ops.clip(wanted.side_port - now.side_port, -side, side),
        now.side_starboard + ops.clip(wanted.side_starboard - now.side_starboard, -side, side),
    )
