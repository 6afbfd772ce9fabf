"""What every way of keeping clear takes and gives: the seam behind which methods are exchanged."""

from __future__ import annotations

from typing import Generic

from msgspec import Struct

from fleet.ops import R


class Own(Struct, Generic[R], frozen=True, gc=False):
    """The own boat as keeping clear sees it."""

    x: R  # north [m]
    y: R  # east [m]
    vx: R  # velocity over ground, north [m/s]
    vy: R  # velocity over ground, east [m/s]
    chi: R  # course over ground; the heading below 0.05 m/s [rad]
    gx: R  # unit vector of the course that the path law wants now, gamma = chi_p + phi
    gy: R
    u_d: R  # speed that path and formation want [m/s]
    tx: R  # unit vector of the path's tangent at the virtual target
    ty: R
    y_e: R  # cross-track error, + to starboard of the path [m]
    straight: R  # seconds at u_d for which the path's course stays within 10 deg
    sigma: R  # 1-sigma error of the own position [m]
    r: R = 0.0  # type: ignore[assignment]  # yaw rate, + to starboard [rad/s]


class Peer(Struct, Generic[R], frozen=True, gc=False):
    """Another vehicle, dead-reckoned to now. Sequences of peers are sorted by number."""

    number: R  # its place in the mission's roster, >= 0; strangers above all roster numbers
    present: R  # 1 heard and to be kept clear of; 0 a masked column: neutral to the bit
    x: R
    y: R
    vx: R
    vy: R
    known: R  # 1 it publishes its plan; 0 only positions (silent, a wreck, a stranger)
    gx: R  # its gamma, as a unit vector; its course where unknown
    gy: R
    u_d: R  # speed that its path and formation want; its speed where unknown [m/s]
    tx: R  # its path's tangent, as a unit vector; its course where unknown
    ty: R
    straight: R  # seconds for which its path stays straight
    sigma: R  # 1-sigma error of its position [m]
    widen: R  # metres added to every radius kept from it: silence, uncertain age
    ordered: R = 0.0  # type: ignore[assignment]  # 1 in our formation, on our path, ahead or astern as its slot is
    y_e: R = 0.0  # type: ignore[assignment]  # its cross-track error, + to starboard of its path [m]
    together: R = 0.0  # type: ignore[assignment]  # 1 it turns when we turn: one decision about a foreign vessel for both
    r: R = 0.0  # type: ignore[assignment]  # its yaw rate, + to starboard [rad/s]


class Advice(Struct, Generic[R], frozen=True, gc=False):
    """What keeping clear asks of guidance this tick."""

    avoiding: R  # 1 the boat leaves its plan to keep clear
    steers: R  # 1 use r_d below instead of path-following's yaw rate
    r_d: R  # yaw rate wanted, + to starboard [rad/s]
    u_d: R  # surge speed wanted; equals Own.u_d when nothing is in the way [m/s]
    braking: R  # 1 the last-moment brake holds the boat
    target: R  # number of the vehicle that decides, -1 for none
    side: R  # +1 it is left to port, -1 to starboard, 0 neither
