"""A family of scenarios as written in its file, at one point of its grid; what it means is checked in `check`."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from fleet.guidance.limits import Limits
from fleet.mission.model import KeepingClear, Name, NotNegative, Positive
from fleet.sim.sweep.distributions import Drawn, Spread

MOST_BOATS = 100
MOST_CASES = 1_000_000
MOST_SEED = 1_000_000_000

Above = Annotated[float, Meta(gt=0.0)] | Spread
AtLeast0 = Annotated[float, Meta(ge=0.0)] | Spread
Lost = Annotated[float, Meta(ge=0.0, le=1.0)] | Spread
Late = Annotated[float, Meta(ge=0.0, le=10.0)] | Spread  # older positions are not believed
Angle = Annotated[float, Meta(ge=0.0, le=80.0)] | Spread
Turn = Annotated[float, Meta(ge=-150.0, le=150.0)] | Spread
Numbers = tuple[Annotated[int, Meta(ge=1, le=MOST_BOATS)], ...]


class Meeting(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="meeting"):
    """Straight paths that meet near one point; the boats would be there at about the same time."""

    heading_deg: Drawn = Spread(even=(-180.0, 180.0))  # per boat
    relative_deg: Drawn | None = None  # per boat but the first: heading less that of the first, instead of heading_deg
    cruise_mps: Above = 1.0  # per boat
    meet_s: Positive = 70.0  # until they meet, and the same again after it
    late_s: Drawn = 0.0  # per boat: before the meeting it is so much farther off
    aside_m: Drawn = 0.0  # per boat: its path passes the point so far off
    apart_m: NotNegative = 20.0  # at the start at least; what is nearer is drawn again


class Circle(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="circle"):
    """Boats evenly round a circle, each bound for the opposite point. All offsets 0: exactly symmetric."""

    radius_m: Positive | None = None  # by the number of boats
    place_rad: Drawn = 0.0  # per boat, along the circle
    offset_m: Drawn = 0.0  # per boat, north and east
    cruise_mps: Above = 1.0  # per boat


class Column(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="column"):
    """A formation in column on one straight path, the first boat ahead."""

    along_m: Drawn = 0.0  # per boat: off its place
    across_m: Drawn = 0.0  # per boat: + to starboard of the path
    heading_rad: Drawn = 0.0  # per boat: off the path's course
    speed_share: AtLeast0 = 1.0  # per boat: speed at the start, of cruise


class Merging(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="merging"):
    """Paths from both sides that bend into parallel lanes; boats take the paths in turn.

    With a formation each boat begins near its place, otherwise so that rank for rank they come to the bend together.
    """

    paths: Annotated[int, Meta(ge=1, le=MOST_BOATS)] | None = None  # as many as boats
    lane_m: NotNegative = 8.0  # from lane to lane; 0: all into one
    angle_deg: Angle = 45.0  # per path: by which it bends, from the side its lane lies on; a middle lane is straight
    corner_radius_m: Positive = 15.0
    meet_s: Positive = 70.0  # until the bend
    after_m: Positive = 100.0  # from the bend to where a boat has arrived
    rank_m: Positive = 15.0  # from boat to boat on one path, without a formation
    cruise_mps: Above | None = None  # per boat, without a formation
    late_s: Drawn = 0.0  # per boat
    across_m: Drawn = 0.0  # per boat


class Anywhere(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="anywhere"):
    """Paths all over the place, straight or bent; each boat but the first would meet one of those before it.

    Every start leaves a way out: boats that all stop at once do not touch.
    """

    heading_deg: Drawn = Spread(even=(-180.0, 180.0))  # per boat: at the start
    turn_deg: Turn = 0.0  # per boat: by which its path bends on the way, + to starboard
    cruise_mps: Above = 1.0  # per boat
    meet_s: Above = Spread(even=(20.0, 80.0))  # per boat: when it would meet the other
    late_s: Drawn = 0.0  # per boat: so much farther off at the start
    aside_m: Drawn = 0.0  # per boat: its path passes the other so far off
    after_s: Positive = 60.0  # from meeting to goal
    apart_m: NotNegative = 12.0  # at the start at least; what is nearer is drawn again


class Formations(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="formations"):
    """Two formations of half of the boats each, in column or abreast, whose middles meet at one point."""

    course_deg: Drawn = Spread(even=(-180.0, 180.0))  # per case: of the second one; that of the first is north
    abreast: Lost = 0.0  # per formation: of at least 0.5 it sails abreast, else in column
    lateral_m: Positive = 12.0  # from boat to boat, abreast
    meet_s: Positive = 70.0  # until they meet
    late_s: Drawn = 0.0  # per formation
    aside_m: Drawn = 0.0  # per formation: its middle passes the point so far off
    along_m: Drawn = 0.0  # per boat: off its place
    across_m: Drawn = 0.0  # per boat: + to starboard of its path


class Circuit(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="circuit"):
    """A formation in column on a closed path, the boats at first anywhere along it, in any order."""

    north_m: Positive = 40.0  # sides of the rectangle, its corners rounded
    east_m: Positive = 30.0
    corner_radius_m: Positive = 12.0
    apart_m: NotNegative = 10.0  # along the path, at the start
    across_m: Drawn = 0.0  # per boat: + to starboard of the path
    speed_share: AtLeast0 = 0.0  # per boat: speed at the start, of cruise


class Wingman(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="wingman"):
    """A leader on a straight path to the north; its wingman sails a sine that crosses the path, beside it."""

    wavelength_m: Positive = 220.0  # twice as long as from crossing to crossing
    amplitude_m: Above = 15.0  # per case
    cruise_mps: Above = 1.0  # per case: of the leader
    phase_m: Drawn = 0.0  # per case: how far from a crossing it begins, along the straight path
    along_m: Drawn = 0.0  # per boat: off its place
    across_m: Drawn = 0.0  # per boat: + to starboard of its path
    crossing: Literal["give-room", "keep-on"] = "give-room"


Sensor = Literal["exact", "ais", "positions", "mixed"]


class Vessels(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="vessels"):
    """Foreign vessels meet one boat, or a formation, that sails north; they follow their courses and see nobody.

    With `crossing_deg` the boats are no formation: each sails alone, and all come to the place of the meeting.
    """

    cruise_mps: Above = Spread(even=(0.5, 1.5))  # per case, without a formation
    vessels: Above = 1.0  # per case, rounded down, at most 8
    meet_s: Above = 120.0  # per vessel: when it would pass the boats
    length_m: Above = Spread(even=(5.0, 60.0))  # per vessel
    speed_mps: AtLeast0 = Spread(even=(0.0, 8.0))  # per vessel
    course_deg: Drawn = Spread(even=(-180.0, 180.0))  # per vessel
    opposite: Lost = 0.0  # share of the vessels whose course is the other way round
    miss: Drawn = Spread(even=(-1.2, 1.2))  # per vessel: passes the first boat so far off, as a share of its clearance
    sensor: Sensor = "mixed"
    turn_deg: AtLeast0 = 0.0  # per vessel: it turns by so much, to either side,
    turn_before_s: AtLeast0 = Spread(even=(10.0, 60.0))  # per vessel: so long before it would pass,
    turn_rate_radps: Above = Spread(even=(0.03, 0.1))  # per vessel
    crossing_deg: Drawn | None = None  # per boat but the first: its course; north is that of the first
    crossing_late_s: Drawn = 0.0  # per boat but the first: it comes there so much later
    abreast: Lost = 0.0  # per case: from 0.5 on the formation sails abreast, else in column
    bend_deg: Turn = 0.0  # per case: by which the boats' path bends, + to starboard,
    bend_before_s: NotNegative = 30.0  # so long before the last vessel would pass
    bank_m: Positive | None = None  # a shore so far to starboard of the path, north to south
    shoal_m: NotNegative = 0.0  # radius of a six-sided shoal beside the meeting
    shoal_aside_m: Drawn = 60.0  # per case: its middle so far to starboard of the path


class Imazu(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="imazu"):
    """One of the 22 geometries of Imazu, one to three vessels that all meet the boat in one point."""

    geometry: Annotated[int, Meta(ge=1, le=22)] = 1
    multiple: Positive = 1.0  # of our speed is theirs; one ahead on our course has half of ours
    cruise_mps: Above = 1.0  # per case
    meet_s: Positive = 180.0
    length_m: Positive = 20.0
    sensor: Sensor = "exact"


Layout = Meeting | Circle | Column | Merging | Anywhere | Formations | Circuit | Wingman | Vessels | Imazu


class Formation(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The formation at the start; per scenario."""

    spacing_m: Drawn
    cruise_mps: Above
    gain_per_m: Positive = 0.3  # k_u
    speed_min_mps: NotNegative | None = None  # of boats in formation; their own limits
    speed_max_mps: Positive | None = None


class Radio(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Radio between every two boats; per scenario."""

    delay_s: Late = 0.0
    loss: Lost = 0.0
    clock_error_s: NotNegative = 0.0  # of two clocks: others are kept farther off by this times their speed


class Environment(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Water and air per scenario, and sensors."""

    current_mps: AtLeast0 = 0.0
    current_toward_deg: Drawn = 0.0
    wind_mps: AtLeast0 = 0.0
    wind_from_deg: Drawn = 0.0
    gnss_sigma_m: NotNegative = 0.0  # 1-sigma per axis, correlated over 60 s (Gauss-Markov)
    gnss_white_m: NotNegative = 0.0  # 1-sigma per axis, white
    gnss_velocity_mps: NotNegative = 0.0  # 1-sigma per axis, white


class Tuned(KeepingClear, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How boats keep clear of each other, and the tuning of the method where it differs."""

    params: dict[str, float] = field(default_factory=dict)


class Trouble(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Boats, by number from 1, that do not do as they should."""

    not_avoiding: Numbers = ()  # keep clear of nobody
    stopped: Numbers = ()  # lie without thrust where the others meet, not under command
    stopped_m: Drawn = 0.0  # per boat: off that point, north and east
    mute: Numbers = ()  # are never heard again
    mute_at_s: AtLeast0 | None = None  # per boat: from then on


class Event(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An operator's command to the formation."""

    at_s: NotNegative
    do: Literal["set spacing", "set speed", "hold", "resume"]
    value: float | None = None
    times: float | None = None  # what was drawn for the start


class Spec(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A family file, without its grid."""

    title: Annotated[str, Meta(min_length=1, max_length=200)]
    name: Name | None = None
    boats: Annotated[int, Meta(ge=1, le=MOST_BOATS)]
    cases: Annotated[int, Meta(ge=1, le=MOST_CASES)]
    layout: Layout
    seed: Annotated[int, Meta(ge=0, le=MOST_SEED)] = 1
    duration_s: Positive | None = None  # three times the longest way, and a minute
    measure_from_s: NotNegative = 0.0  # from when on errors of track and formation count
    hull: str = "unicycle"
    hulls: tuple[str, ...] = ()  # instead: each boat has one of these, drawn
    limits: Limits = field(default_factory=Limits)
    formation: Formation | None = None
    keeping_clear: Tuned = field(default_factory=Tuned)
    radio: Radio = field(default_factory=Radio)
    environment: Environment = field(default_factory=Environment)
    trouble: Trouble = field(default_factory=Trouble)
    timeline: tuple[Event, ...] = ()
    checks: dict[str, float] = {}
