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

    Operator: `set spacing`, `set speed` (with value), `hold`, `resume`, `abort`, `return`, `stop-now`, `release`,
    `take`, `forget`. Simulator: `kill`, `start`, `freeze`, `thaw` (an agent), `radio-down`, `radio-up` (its radio),
    `gnss-down`, `gnss-up`, `actuator-down`, `actuator-up`, `battery` (value: percent).
    """

    at_s: NotNegative
    do: str
    value: float | None = None
    boats: tuple[str, ...] = ()  # empty: all


class Environment(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Water, air and sensors of the simulation."""

    current_mps: NotNegative = 0.0
    current_toward_deg: float = 0.0
    wind_mps: NotNegative = 0.0
    wind_from_deg: float = 0.0
    gnss_sigma_m: NotNegative = 0.0  # 1-sigma per axis, correlated over 60 s (Gauss-Markov)
    gnss_white_m: NotNegative = 0.0  # 1-sigma per axis, white


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
    environment: Environment = field(default_factory=Environment)
    radio: Radio = field(default_factory=Radio)
    checks: dict[str, float] = {}
