"""The safety circle: the boat follows a circle about the nearest vehicle in its way (Bibuli et al. 2014, section III).

With the corrections that make it work: the near point of the circle, entry on intrusion and obstruction, release with
hysteresis or when the way opens the range, one side until release. It knows no velocities.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Generic, Literal

from msgspec import Meta, Struct

from fleet import ops
from fleet.avoidance.types import Advice, Own, Peer
from fleet.guidance.limits import Limits
from fleet.ops import R

Positive = Annotated[float, Meta(gt=0.0)]


class CircleParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Tuning of the safety circle."""

    radius_m: Positive = 6.0  # R-bar of the paper's experiments
    side: Literal["closest", "starboard"] = "closest"  # eq. 8, or the COLREGS turn of section IV
    release: Annotated[float, Meta(ge=0.0)] = 0.15  # the radius grows by this share until release
    printed: bool = False  # as printed: far side of the circle, intrusion alone; for comparison only
    k1: Positive = 0.8  # eq. 2 [1/s]
    psi_a: Positive = 1.05  # largest approach angle [rad]
    k_phi: Positive = 0.2  # steepness of the approach [1/m]


class CircleMemory(Struct, Generic[R], frozen=True, gc=False):
    """The latch: which vehicle is circled, on which side."""

    target: R  # its number, -1 for none
    side: R  # +1 it is left to port, -1 to starboard, 0 none


def start_memory(like: R, n_peers: int = 0) -> CircleMemory[R]:  # noqa: ARG001 - every method is started alike
    """Memory of a boat that circles nobody; `like` gives one boat (float) or the lanes (array)."""
    return CircleMemory(ops.full(like, -1.0), ops.zero(like))


class Found(Struct, Generic[R], frozen=True, gc=False):
    """The nearest vehicle in the way."""

    target: R  # number, -1 for none
    d_sq: R  # range squared [m2]
    ex: R  # from it to own [m]
    ey: R
    radius: R  # of its circle [m]


def keep_clear(
    own: Own[R],
    peers: Sequence[Peer[R]],
    memory: CircleMemory[R],
    limits: Limits,
    params: CircleParams,
    dt: float,  # noqa: ARG001 - every method is called alike
) -> tuple[CircleMemory[R], Advice[R]]:
    """Follow the circle about the nearest vehicle in the way; speed stays as wanted.

    Args:
        peers: sorted by number, dead-reckoned to now
        memory: the latch of the last tick
        limits: of the own boat
    """
    found = _nearest(own, peers, memory, params)
    none = ops.zero(own.x)

    def circled(own: Own[R], found: Found[R], memory: CircleMemory[R]) -> tuple[R, R]:
        return _on_circle(own, found, memory, limits, params)

    blocked = found.target >= 0.0
    side, r_d = ops.when(blocked, circled, (none, none), own, found, memory)
    avoiding = ops.flag(blocked, none)
    advice = Advice(avoiding, avoiding, r_d, own.u_d, none, found.target, side)
    return CircleMemory(found.target, side), advice


def _nearest(own: Own[R], peers: Sequence[Peer[R]], memory: CircleMemory[R], params: CircleParams) -> Found[R]:
    """The nearest vehicle that intrudes (d < 2R) and obstructs, the latched one with the larger radius.

    Obstruction, eq. 9: the approach line along gamma hits the circle ahead. A line that opens the range does not
    obstruct, even inside the circle: E . g < 0 and |E x g| < R, E from the vehicle to own.
    """
    none = ops.zero(own.x)
    target, nearest = ops.full(own.x, -1.0), ops.full(own.x, 1e300)
    found_x, found_y, found_r = none, none, ops.full(own.x, params.radius_m)
    for peer in peers:
        ex, ey = own.x - peer.x, own.y - peer.y
        d_sq = ex * ex + ey * ey
        latched = memory.target == peer.number
        radius = params.radius_m + peer.widen
        reach = radius * ops.where(latched, 1.0 + params.release, 1.0)
        reach_sq = reach * reach
        near = (peer.present == 1.0) & (d_sq < 4.0 * reach_sq) & (d_sq < nearest)
        if not ops.some(near):
            continue
        if not params.printed:
            off = ex * own.gy - ey * own.gx
            near = near & (ex * own.gx + ey * own.gy < 0.0) & (off * off < reach_sq)
        target, nearest = ops.where(near, peer.number, target), ops.where(near, d_sq, nearest)
        found_x, found_y = ops.where(near, ex, found_x), ops.where(near, ey, found_y)
        found_r = ops.where(near, radius, found_r)
    return Found(target, nearest, found_x, found_y, found_r)


def _on_circle(
    own: Own[R], found: Found[R], memory: CircleMemory[R], limits: Limits, params: CircleParams
) -> tuple[R, R]:
    """Side and yaw rate [rad/s] that bring the boat onto the circle and along it.

        y = +-(d - R), c = -+1/R, sdot = U cos(beta) R / d        upper signs: the vehicle is left to port
        r_d = phi_dot - k1 wrap(beta - phi) + c sdot,  phi = -psi_a tanh(k_phi y)

    The closest point of the circle carries the frame; alpha is the bearing from the vehicle to own, and the tangent
    alpha - pi/2 the turn to starboard. As printed alpha points the other way and the frame sits on the far side.
    """
    d = ops.sqrt(found.d_sq)
    safe = ops.maximum(d, 1e-3)
    ax, ay = found.ex / safe, found.ey / safe  # unit vector of alpha
    sin_chi, cos_chi = ops.sincos(own.chi)
    abeam = cos_chi * ay - sin_chi * ax  # cosine between the course and the tangent to starboard
    if params.side == "closest":
        chosen = ops.where(abeam >= 0.0, 1.0, -1.0)
    else:
        chosen = ops.full(d, -1.0 if params.printed else 1.0)
    side = ops.where(memory.target == found.target, memory.side, chosen)

    offset = d + found.radius if params.printed else d - found.radius
    bend = 1.0 if params.printed else -1.0
    y = side * offset
    tx, ty = side * ay, -side * ax
    cos_b, sin_b = tx * cos_chi + ty * sin_chi, tx * sin_chi - ty * cos_chi
    speed = ops.hypot(own.vx, own.vy)
    slope = ops.tanh(params.k_phi * y)
    sin_p, cos_p = ops.sincos(-params.psi_a * slope)
    phi_dot = -params.psi_a * params.k_phi * (1.0 - slope * slope) * (speed * sin_b)
    along = speed * cos_b * found.radius / ops.maximum(d, 0.1 * found.radius)
    error = ops.atan2(sin_b * cos_p - cos_b * sin_p, cos_b * cos_p + sin_b * sin_p)
    r_d = phi_dot - params.k1 * error + (bend * side / found.radius) * along
    return side, ops.clip(r_d, -limits.yaw_rate_max_radps, limits.yaw_rate_max_radps)
