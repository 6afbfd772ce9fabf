"""A mission as written in its file: typed, with units in the names; what it means is checked in `fleet.mission.check`.

Positions are `[north_m, east_m]` from the datum or `{lat_deg = , lon_deg = }`. The same structs travel on the wire, so
that a boat checks what an operator sends exactly as the operator's machine did.
"""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from fleet.guidance.limits import Limits

Positive = Annotated[float, Meta(gt=0.0)]
NotNegative = Annotated[float, Meta(ge=0.0)]
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Name = Annotated[str, Meta(pattern=r"^[a-z0-9-]{1,32}\Z")]


class Geographic(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A position on WGS 84."""

    lat_deg: Annotated[float, Meta(ge=-90.0, le=90.0)]
    lon_deg: Annotated[float, Meta(ge=-180.0, le=180.0)]


Metres = tuple[float, float]
"""[north_m, east_m] from the datum."""
Place = Metres | Geographic


class Straight(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="straight"):
    """A straight line."""

    start: Place
    end: Place


class Arc(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="arc"):
    """Part of a circle, or a whole one (`turn_deg = 360` or `-360`: a closed circuit)."""

    centre: Place
    radius_m: Positive
    from_deg: float  # bearing of the start from the centre
    turn_deg: float  # + clockwise (to starboard)


class Polyline(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="polyline"):
    """Straight legs with corners rounded by arcs."""

    points: Annotated[tuple[Place, ...], Meta(min_length=2)]
    corner_radius_m: Positive
    closed: bool = False


class Sine(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="sine"):
    """A sine about the line from start to end, first to starboard for a positive amplitude."""

    start: Place
    end: Place
    amplitude_m: float
    wavelength_m: Annotated[float, Meta(ge=1.0)]


class Through(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="through"):
    """A smooth curve through points (cubic spline)."""

    points: Annotated[tuple[Place, ...], Meta(min_length=3)]
    closed: bool = False


PathSpec = Straight | Arc | Polyline | Sine | Through


class Start(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a simulated boat lies at first: `position` and `heading_deg`, or `s_m` (and `offset_m`) on its path."""

    position: Place | None = None
    heading_deg: float | None = None
    s_m: float | None = None
    offset_m: float = 0.0  # + to starboard of the path
    speed_mps: NotNegative = 0.0


class Boat(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One boat of the roster: its number is its place in the list."""

    name: Name
    path: str
    slot: float  # place in the formation: o_i = slot * spacing, + ahead
    start: Start
    hull: str = "unicycle"
    limits: Limits = field(default_factory=Limits)


class Formation(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The formation at launch."""

    spacing_m: float
    cruise_mps: Positive
    gain_per_m: Positive = 0.3  # k_u
    pattern: Literal["column", "abreast", "echelon", "wedge", "wingman"] = "column"
    lateral_m: float | None = None  # from slot to slot abeam, + to starboard; None: as much as the spacing
    vacancies: Literal["keep-gaps", "close-up"] = "keep-gaps"  # slots of boats that left: empty, or filled again
    crossing: Literal["give-room", "keep-on"] = "give-room"  # wingmen where paths come near: fall back, or stay abeam


class KeepingClear(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How boats of the fleet keep clear of each other."""

    method: Name = "scoring"
    radius_m: Positive = 6.0  # safety radius R, between centres
    side: Literal["closest", "starboard"] = "closest"  # rule of the circle method


class Fence(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The area that no boat leaves: a simple polygon."""

    points: Annotated[tuple[Place, ...], Meta(min_length=3)]


class Battery(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Levels at which a boat goes home, and at which it stops."""

    reserve_percent: Annotated[float, Meta(ge=0.0, le=100.0)] = 20.0
    critical_percent: Annotated[float, Meta(ge=0.0, le=100.0)] = 5.0


class Lost(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a boat does when a link or the operator is lost."""

    alone_for_s: NotNegative = 30.0  # cruise on the own path while the own link is down, then hold
    operator: Literal["continue", "hold", "return"] = "continue"
    operator_after_s: Positive = 10.0


class Event(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One entry of the timeline: an operator's command, or trouble that the simulator makes.

    Operator: `set spacing`, `set speed`, `set lateral`, `set pattern`, `set leader`, `set slots` (with value), `hold`,
    `resume`, `abort`, `return`, `stop-now`, `release`, `take`, `forget`. Simulator: `kill`, `start`, `freeze`, `thaw`
    (an agent), `radio-down`, `radio-up` (its radio), `gnss-down`, `gnss-up`, `compass-down`, `compass-up`, `gyro-down`,
    `gyro-up`, `lidar-down`, `lidar-up`, `actuator-down`, `actuator-up`, `pilot-takes`, `pilot-gives`, `bus-off`,
    `bus-on`, `battery` (value: percent).
    """

    at_s: NotNegative
    do: str
    value: float | str | None = None
    boats: tuple[str, ...] = ()  # empty: all

    @property
    def number(self) -> float:
        """The value where it is a number, else 0."""
        return self.value if isinstance(self.value, float) else 0.0


class Environment(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Water, air and sensors of the simulation."""

    current_mps: NotNegative = 0.0
    current_toward_deg: float = 0.0
    wind_mps: NotNegative = 0.0
    wind_from_deg: float = 0.0
    gnss_sigma_m: NotNegative = 0.0  # 1-sigma per axis, correlated over 60 s (Gauss-Markov)
    gnss_white_m: NotNegative = 0.0  # 1-sigma per axis, white
    gnss_velocity_mps: NotNegative = 0.0  # 1-sigma per axis
    heading_noise_deg: NotNegative = 0.0  # 1-sigma
    yaw_rate_noise_degps: NotNegative = 0.0  # 1-sigma
    lidar_range_m: Annotated[float, Meta(ge=5.0, le=200.0)] = 60.0  # of the boats' laser scanners, if they have any
    lidar_noise_m: NotNegative = 0.03  # 1-sigma of a range
    lidar_loss: Share = 0.05  # of its returns


class Gap(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A time in which nothing is received of a vessel."""

    from_s: NotNegative
    to_s: Positive


class Ais(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="ais"):
    """The vessel has AIS: it tells its position, course, speed and perhaps its size, and its name."""

    interval_s: Annotated[float, Meta(ge=2.0, le=10.0)] = 6.0
    noise_m: NotNegative = 2.0  # 1-sigma per axis of the position that it tells
    velocity_noise_mps: NotNegative = 0.1  # 1-sigma per axis of the velocity that it tells
    tells_size: bool = True
    range_m: Positive = 10_000.0
    loss: Share = 0.1  # of reports, each receiver for itself
    gaps: tuple[Gap, ...] = ()


class Positions(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="positions"):
    """The boats' own sensors see the vessel: bare positions, neither name nor velocity."""

    rate_hz: Annotated[float, Meta(ge=0.5, le=5.0)] = 1.0
    noise_m: NotNegative = 2.0  # 1-sigma per axis
    size_error: Annotated[float, Meta(ge=0.0, lt=1.0)] = 0.25  # the length seen is wrong by at most this share
    range_m: Positive = 400.0
    loss: Share = 0.1
    gaps: tuple[Gap, ...] = ()


class Lidar(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="lidar"):
    """The vessel tells nothing, and is seen as boats' laser scanners see its hull: every boat then has one."""

    gaps: tuple[Gap, ...] = ()  # in which the water hides it


Sensed = Ais | Positions | Lidar


class Steady(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="course"):
    """A vessel on one course."""

    start: Place
    course_deg: float


class Legs(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind", tag="waypoints"):
    """A vessel from point to point; beyond the last it keeps its course."""

    points: Annotated[tuple[Place, ...], Meta(min_length=2)]


class Change(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a vessel does at a time: `turn` (value: degrees, + to starboard), `speed` (value: m/s) or `stop`."""

    at_s: NotNegative
    do: Literal["turn", "speed", "stop"]
    value: float | None = None


class Vessel(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Another vessel in the simulation, that knows nothing of the fleet."""

    name: Name
    length_m: Annotated[float, Meta(ge=5.0, le=100.0)]
    speed_mps: Annotated[float, Meta(ge=0.0, le=8.0)]
    track: Steady | Legs
    changes: tuple[Change, ...] = ()
    gives_way: bool = False
    sensed: Sensed = field(default_factory=Ais)


class Radio(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Radio between every two stations, as the receiving one hears it."""

    delay_s: NotNegative = 0.0
    loss: Share = 0.0


class Mission(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A mission file."""

    title: Annotated[str, Meta(min_length=1, max_length=200)]
    datum: Geographic
    paths: dict[str, PathSpec]
    boats: Annotated[tuple[Boat, ...], Meta(min_length=1)]
    formation: Formation
    duration_s: Positive  # of the simulation; the mission itself ends at the end of the path
    keeping_clear: KeepingClear = field(default_factory=KeepingClear)
    fence: Fence | None = None
    home: Place | None = None
    battery: Battery = field(default_factory=Battery)
    lost: Lost = field(default_factory=Lost)
    state_hz: Annotated[float, Meta(ge=1.0, le=50.0)] = 10.0
    timeline: tuple[Event, ...] = ()
    traffic: tuple[Vessel, ...] = ()
    environment: Environment = field(default_factory=Environment)
    radio: Radio = field(default_factory=Radio)
    checks: dict[str, float] = {}
