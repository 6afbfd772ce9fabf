"""Coordinated path-following: every boat takes its slot by its own speed (Bibuli 2014, eq. 4, signs put right)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic

from msgspec import Struct

from fleet import ops
from fleet.ops import R

FARTHEST_M = 10.0  # one straggler must not halt the fleet: with it, 200 m behind, the others settled in 60 s, not 300


class Member(Struct, Generic[R], frozen=True, gc=False):
    """A boat of the same mission and formation revision."""

    weight: R  # 1 present, 0 not; in between while it comes back, so that its return is no bump
    z: R  # its abscissa less its slot's offset, s_j - o_j [m]


def along_path_error(z: R, members: Sequence[Member[R]]) -> R:
    """Formation error of a boat at z = s_i - o_i: + the others' places are ahead of its own [m].

        e_i = sum_j w_j clip(z_j - z_i, -10, 10) / max(1, sum_j w_j)

    Args:
        z: own abscissa less own slot offset [m]
        members: the other boats, in the order of the roster; weight 0 is neutral to the bit

    Source: Bibuli et al. (2014), eq. 4; with two boats it is the paper's error with slots (D*, 0).
    """
    total = ops.zero(z)
    weights = ops.zero(z)
    for member in members:
        total = total + member.weight * ops.clip(member.z - z, -FARTHEST_M, FARTHEST_M)
        weights = weights + member.weight
    return total / ops.maximum(weights, 1.0)


def formation_speed(e: R, cruise: R, u_min: R, u_max: R, gain: R) -> R:
    """Speed that closes the formation error e [m/s].

        u_d = C + (u_max - C if e > 0 else C - u_min) tanh(k_u e)

    Args:
        e: along-path error, + when the boat is behind its place [m]
        cruise: commanded cruise speed C, within u_min .. u_max [m/s]
        u_min: slowest speed in formation [m/s]
        u_max: fastest speed in formation [m/s]
        gain: k_u [1/m]

    Source: Bibuli et al. (2014), eq. 4; equal to it when C is the middle of the limits.
    """
    reach = ops.where(e > 0.0, u_max - cruise, cruise - u_min)
    return cruise + reach * ops.tanh(gain * e)
