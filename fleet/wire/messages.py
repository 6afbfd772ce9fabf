"""The messages: msgpack arrays that begin with the wire's major version; fields are only appended, with a default.

At this edge values are words with units; angles in radians clockwise from north, positions on WGS 84, stamps in
nanoseconds of UTC as the sender's clock has it.
"""

from __future__ import annotations

from msgspec import Struct

MAJOR = 1


class Revision(Struct, frozen=True, array_like=True, order=True):
    """Which formation within one mission: the larger counter is newer, equal counters go by the operator's name."""

    counter: int = 0
    operator: str = ""

    def __str__(self) -> str:
        return f"{self.counter}:{self.operator or 'launch'}"


class ForeignOrder(Struct, frozen=True, array_like=True, gc=False):
    """How a boat keeps clear of a vessel that is not of the fleet; its formation sails a leader's with it."""

    serial: int  # counts decisions, resuming included
    apply_ns: int  # from then on it is sailed, by the sender's clock
    acting: bool  # False: back to the path
    offset_rad: float  # from the course of the path when it was decided
    factor: float  # of the cruise speed
    course_rad: float
    sense: float  # +1 turn by starboard, -1 by port, 0 the short way
    path_rad: float  # course of the sender's path now
    reason: int  # fleet.avoidance.foreign.types.Reason
    vessel: str
    alone: bool = False  # it decides for itself only


class BoatState(Struct, frozen=True, array_like=True, gc=False):
    """What a boat publishes at every tick."""

    major: int
    boat: str
    epoch: int  # new for every start of the process
    seq: int  # one more with every message
    stamp_ns: int
    clock_ns: int  # how wrong the sender's clock may be; at most 100 ms counts as disciplined
    lat_deg: float
    lon_deg: float
    cog_rad: float
    sog_mps: float
    heading_rad: float
    yaw_rate_radps: float
    position_error_m: float  # 1 sigma
    lap: int
    s_m: float  # virtual-target abscissa, cumulative over laps
    mode: int  # fleet.agent.modes.Mode
    reasons: int  # bits of fleet.agent.modes.Reason
    plan_course_rad: float  # what path-following wants now, avoidance apart
    plan_speed_mps: float
    tangent_rad: float  # course of the path at the virtual target
    straight_s: float  # seconds for which the path's course stays within 10 deg
    decided_yaw_rate_radps: float
    decided_speed_mps: float
    cross_track_m: float
    along_path_m: float  # formation error: + behind its place
    nearest: str  # name of the nearest vehicle, "" for none
    nearest_m: float
    mission_id: str  # "" none
    in_force: Revision  # of the formation that it sails
    held: Revision  # newest formation that it holds, possibly not yet in force
    stops: tuple[str, ...]  # ids of stops not released
    simulated: bool
    control: Revision  # who holds control
    length_m: float = 2.4
    foreign: ForeignOrder | None = None  # while there are vessels that are not of the fleet


class BoatStatus(Struct, frozen=True, array_like=True):
    """What a boat publishes once a second and when something changed."""

    major: int
    boat: str
    epoch: int
    stamp_ns: int
    version: str
    mode: str
    reasons: tuple[str, ...]  # in words
    mission_id: str
    mission_title: str
    controller: str  # operator who holds control, "" nobody
    spacing_m: float
    cruise_mps: float
    battery_percent: float  # NaN when unknown
    peers: int
    ticks: int
    ticks_late: int
    worst_late_ms: float
    messages_heard: int
    messages_lost: int
    messages_refused: int
    requests_refused: int
    recording: str  # "" well; otherwise what is wrong
    driver: str
    hull: str
    refusals: tuple[str, ...] = ()  # why messages were refused, with counts, in words
    switched_ns: int = 0  # when the formation in force took effect
    pattern: str = ""  # of the formation in force
    lateral_m: float = 0.0
    slot: float = 0.0  # its own
    traffic: tuple[str, ...] = ()  # vessels that are not of the fleet, in words
    security: str = ""  # what is not well with its credentials; "" well, or not asked for
    roster: int = 0  # number of the roster in force; 0: no credentials
    autopilot: int = 0  # MAVLink sysid of its autopilot, whose frames it hands on; 0 none
    takes_frames: bool = False  # it hands frames of ground stations on to its autopilot, too


class FormationOrder(Struct, frozen=True, array_like=True):
    """An operator's change of the formation."""

    major: int
    mission_id: str
    revision: Revision
    based_on: Revision
    spacing_m: float
    cruise_mps: float
    apply_in_s: float = 2.0  # counted from receipt; relays pass on what remains
    stamp_ns: int = 0
    pattern: str = ""  # fleet.mission.pattern; "" as the mission says, and so lateral and slots
    lateral_m: float = 0.0  # from slot to slot abeam, + to starboard
    slots: tuple[tuple[str, float], ...] = ()  # of every boat of the roster


class MissionOrder(Struct, frozen=True, array_like=True):
    """An operator's launch: the mission, who takes part, and formation revision 0."""

    major: int
    mission_id: str
    operator: str
    stamp_ns: int
    mission: bytes  # fleet.mission.load.encode
    apply_in_s: float = 2.0


class Signed(Struct, frozen=True, array_like=True):
    """An operator's words as they were written, so that a boat can hand them on but not alter them."""

    body: bytes
    signature: bytes = b""
    signer: str = ""  # common name of the signer's certificate


class Held(Struct, frozen=True, array_like=True):
    """A boat's answer to who asks for its mission or formation."""

    major: int
    order: Signed | None
    remaining_s: float  # until it applies; 0 when it is in force


class Stops(Struct, frozen=True, array_like=True):
    """A boat's answer to who asks for the stops of the whole fleet that it knows: the words of the operators."""

    major: int
    words: tuple[Signed, ...]


class Command(Struct, frozen=True, array_like=True):
    """An operator's word to boats; the same id twice is obeyed once and acknowledged twice."""

    major: int
    id: str
    operator: str
    kind: str
    boats: tuple[str, ...]  # empty: all
    order: Signed | None = None  # launch: MissionOrder; set: FormationOrder
    names: tuple[str, ...] = ()  # release: ids of stops; forget: boats
    text: str = ""  # resume: "nearest" or an abscissa in metres
    mission_id: str = ""
    stamp_ns: int = 0


class Ack(Struct, frozen=True, array_like=True):
    """A boat's answer to a command."""

    major: int
    id: str
    boat: str
    ok: bool
    reason: str  # why refused, in words; or a remark
    old: str = ""
    new: str = ""
    version: str = ""
    safety: bool = False  # refused by a safety check


class FleetEvent(Struct, frozen=True, array_like=True):
    """Something happened on a boat: mode changes, avoidance, refusals, supersessions."""

    major: int
    boat: str
    stamp_ns: int
    kind: str
    text: str
    value: float = 0.0


class Frames(Struct, frozen=True, array_like=True):
    """An operator's machine to a boat with an autopilot: somebody listens, and frames for the autopilot, if any."""

    major: int
    operator: str
    frames: bytes = b""
    boat: str = ""
    stamp_ns: int = 0


class Echo(Struct, frozen=True, array_like=True):
    """Asked of a peer once a second while clocks are not disciplined; it comes back as it went."""

    major: int
    stamp_ns: int
