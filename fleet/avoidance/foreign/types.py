"""What keeping clear of foreign vessels takes, remembers and gives. All values are floats: SI, radians, NED."""

from __future__ import annotations

from enum import IntEnum
from typing import Protocol, TypeAlias

from msgspec import Struct

from fleet.guidance.limits import Limits
from fleet.paths import PathPoint

NEVER_S = 1.0e6
"""A time that does not come within any horizon [s]."""

Edge: TypeAlias = tuple[float, float, float, float]
"""One edge of a bank or of a no-go polygon: x1, y1, x2, y2 [m]. Either side may be the water."""


class Kind(IntEnum):
    """What meets us, seen from the own boat. The first rule that fits is the class (rules 13 to 15)."""

    NONE = 0  # no risk of collision so far
    STATIC = 1  # slower than its course can be told: kept clear of
    OVERTAKING = 2  # we overtake it
    OVERTAKEN = 3  # it overtakes us
    HEAD_ON = 4
    CROSSING_GIVE_WAY = 5  # it crosses from starboard
    CROSSING_STAND_ON = 6  # it crosses from port


class Role(IntEnum):
    """Who keeps clear of whom (rules 16, 17)."""

    NONE = 0
    GIVE_WAY = 1
    STAND_ON = 2


class Reason(IntEnum):
    """Why the present action was begun, or the last one ended."""

    NONE = 0
    GIVE_WAY = 1  # rule 16: early and substantial
    STAND_ON = 2  # rule 17 a ii: the other does not keep clear, and alone it is just still possible
    HELD_FAILS = 3  # the action sailed so far does not keep clear any more
    BANK = 4  # the action sailed so far leads to a bank
    NEW_TARGET = 5  # one more vessel, and the action sailed so far is bad for it
    CLEAR = 6  # the path is clear again
    ORDER = 7  # the leader of the formation says so
    NO_ORDER = 8  # the leader says nothing, it is too near: decided alone
    BESIDE = 9  # far enough to the side: goes on parallel to the path until that is clear
    PASSED = 10  # the vessel that it was for is past, but another one keeps the boat off its path
    REVIEW = 11  # held for a minute without getting clear: is there a better one by now?


class PathLike(Protocol):
    """The path ahead of a boat."""

    def at(self, s: float) -> PathPoint[float]:
        """Point, tangent and curvature at the abscissa."""

    def straight(self, s: float) -> float:
        """Metres for which the course stays within 10 deg."""


class TargetLike(Protocol):
    """A foreign vessel, dead-reckoned to now: `fleet.sensing.Target` is one."""

    @property
    def number(self) -> float:
        """Its number, for good: memory is kept by it."""

    @property
    def x(self) -> float:
        """North [m]."""

    @property
    def y(self) -> float:
        """East [m]."""

    @property
    def vx(self) -> float:
        """Velocity over ground, north [m/s]."""

    @property
    def vy(self) -> float:
        """Velocity over ground, east [m/s]."""

    @property
    def P11(self) -> float:
        """Variance of the position per axis now [m2]."""

    @property
    def P22(self) -> float:
        """Variance of the velocity per axis [m2/s2]."""

    @property
    def om(self) -> float:
        """Turn rate that counts, + to starboard; 0 where it is not to be trusted [rad/s]."""

    @property
    def length(self) -> float:
        """Length of its hull [m]."""

    @property
    def usable(self) -> float:
        """1 its velocity is known well enough to decide by."""


class Afloat(Struct, frozen=True, gc=False):
    """How one boat of the fleet lies and moves."""

    x: float  # north [m]
    y: float  # east [m]
    chi: float  # course over ground; the heading below 0.05 m/s [rad]
    U: float  # speed over ground [m/s]
    r: float  # yaw rate, + to starboard [rad/s]
    s: float  # abscissa of its virtual target [m]
    cruise: float  # speed it sails along its path [m/s]
    limits: Limits


class Boat(Afloat, frozen=True, gc=False):
    """One boat of the fleet, on its path: the own one, or a mate that sails the same decision."""

    path: PathLike


class Mate(Struct, frozen=True, gc=False):
    """A boat of the fleet that decides for itself: a disc with its present velocity for 20 s."""

    x: float
    y: float
    vx: float
    vy: float


class Encounter(Struct, frozen=True, gc=False):
    """What is remembered of one foreign vessel, from the first risk until it is past and clear."""

    number: float
    kind: float  # Kind
    side: float  # +1 wanted: leave it to port, -1 to starboard, 0 either
    ex: float  # its course when it was classified, unit vector
    ey: float
    acting: float  # 1 we have acted for it
    count: float  # seconds for which acting has been due
    clear: float  # seconds without risk while the range opens
    calm: float  # seconds without risk
    entry: float  # time until we enter its domain on our path; NEVER_S no risk [s]


class Action(Struct, frozen=True, gc=False):
    """An alteration that is held. With acting 0 the boat follows its path and the rest is without meaning."""

    acting: float
    a: float  # course relative to the path's when it was decided, + to starboard, -180 to +240 deg [rad]
    factor: float  # of the cruise speed; 0 stop, above 1 emergency
    cx: float  # course over ground, unit vector
    cy: float
    sense: float  # +1 turn by starboard, -1 by port, whichever way is longer; 0 the short way
    at: float  # time from which it is sailed, on the clock of `now` [s]


FOLLOW_PATH = Action(acting=0.0, a=0.0, factor=1.0, cx=1.0, cy=0.0, sense=0.0, at=0.0)
"""No alteration."""


class Order(Struct, frozen=True, gc=False):
    """The leader's decision for its formation, repeated in every state message."""

    who: float  # number of the leader
    serial: float  # counts its decisions, resuming included
    action: Action  # acting 0: everybody resumes; `at` on the receiver's clock
    target: float  # number of the vessel that decides, -1 none
    reason: float  # Reason


class Contact(Struct, frozen=True, gc=False):
    """One foreign vessel as it is shown to people."""

    number: float
    kind: float  # Kind
    role: float  # Role
    side: float  # +1 to be left to port, -1 to starboard, 0 either
    acting: float  # 1 we act, or have acted, for it
    entry: float  # seconds until its domain is entered on the own path, NEVER_S none
    distance: float  # from the own centre to the core of its domain [m]
    clearance: float  # C, wanted between own centre and core [m]


class Advice(Struct, frozen=True, gc=False):
    """What keeping clear of foreign vessels asks this tick."""

    acting: float  # 1 sail cx, cy, u_d, r_d below; 0 follow the path
    cx: float  # course over ground to sail, after the banks, unit vector
    cy: float
    u_d: float  # speed to sail [m/s]
    r_d: float  # yaw rate for that course, within the limits, + to starboard [rad/s]
    a: float  # decided course relative to the path's [rad]
    factor: float  # decided speed as a share of the cruise speed
    sense: float  # +1 by starboard, -1 by port, 0 the short way
    banked: float  # 1 a bank bends the course
    target: float  # number of the vessel that decides, -1 none
    kind: float  # Kind of it
    role: float  # Role towards it
    reason: float  # Reason
    entry: float  # earliest entry into any domain on the own path, NEVER_S none [s]
    decided: float  # 1 a new decision was made in this tick, resuming included
    serial: float  # counts decisions
    contacts: tuple[Contact, ...]  # every usable vessel, by number
