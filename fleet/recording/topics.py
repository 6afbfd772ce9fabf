"""Topics of a run and what their messages hold: the layouts that viewers and `fleet.analysis` read.

One JSON object a message. Every stamp is UTC in nanoseconds, of the simulation or of the real world. Unknown is null:
NaN is not JSON, and is written as null. Viewers refuse schemas with references or alternatives; `viewer_schema` writes
none.
"""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct

from fleet.recording.seam import Recording

EVENT = "/event"
COMMAND = "/command"
Real = float | None
"""A number, or null where it is not known."""

Stamp = Annotated[int, Meta(description="UTC [ns]")]


class Truth(Struct, frozen=True, kw_only=True, gc=False):
    """`/truth/<boat>`: where a simulated hull is, whatever its sensors and its agent believe. 10 Hz."""

    stamp_ns: Stamp
    x_m: Annotated[Real, Meta(description="north of the datum [m]")]
    y_m: Annotated[Real, Meta(description="east of the datum [m]")]
    psi_rad: Annotated[Real, Meta(description="heading, clockwise from north [rad]")]
    u_mps: Annotated[Real, Meta(description="surge over ground along the heading [m/s]")]
    v_mps: Annotated[Real, Meta(description="sway over ground, + to starboard [m/s]")]
    r_radps: Annotated[Real, Meta(description="yaw rate, + to starboard [rad/s]")]
    vx_mps: Annotated[Real, Meta(description="speed over ground to the north [m/s]")]
    vy_mps: Annotated[Real, Meta(description="speed over ground to the east [m/s]")]
    lat_deg: Annotated[Real, Meta(description="latitude, WGS 84 [deg]")]
    lon_deg: Annotated[Real, Meta(description="longitude, WGS 84 [deg]")]
    length_m: Annotated[Real, Meta(description="length of the hull [m]")]


class State(Struct, frozen=True, kw_only=True):
    """`/<boat>/state`: what a boat published about itself and decided."""

    stamp_ns: Stamp
    x_m: Annotated[Real, Meta(description="own position, north of the datum [m]")]
    y_m: Annotated[Real, Meta(description="own position, east of the datum [m]")]
    psi_rad: Annotated[Real, Meta(description="heading, clockwise from north [rad]")]
    sog_mps: Annotated[Real, Meta(description="speed over ground [m/s]")]
    u_d_mps: Annotated[Real, Meta(description="surge speed asked of the driver [m/s]")] = None
    s_m: Annotated[Real, Meta(description="abscissa of the virtual target, laps counted [m]")] = None
    lap: Annotated[int, Meta(description="laps of a closed path")] = 0
    mode: Annotated[str, Meta(description="standby, follow, avoid, hold, return, alone, neutral, fault")] = ""
    reasons: Annotated[list[str], Meta(description="why, in words")] = []
    y_e_m: Annotated[Real, Meta(description="cross-track error, + to starboard of the path [m]")] = None
    e_s_m: Annotated[Real, Meta(description="along-path error, + behind its slot [m]")] = None
    spacing_m: Annotated[Real, Meta(description="spacing of the formation in force [m]")] = None
    offset_m: Annotated[Real, Meta(description="abscissa offset of the own slot, + ahead [m]")] = None
    cruise_mps: Annotated[Real, Meta(description="cruise speed in force [m/s]")] = None
    nearest: Annotated[str, Meta(description="name of the nearest other boat; empty: none known")] = ""
    nearest_m: Annotated[Real, Meta(description="distance to it between centres, as this boat believes [m]")] = None
    avoiding: Annotated[bool, Meta(description="keeping clear of somebody")] = False
    side: Annotated[str, Meta(description="side the other is left on: port, starboard, or empty")] = ""
    mission_id: Annotated[str, Meta(description="mission it sails")] = ""
    revision: Annotated[int, Meta(description="formation revision in force")] = 0


class Status(Struct, frozen=True, kw_only=True):
    """`/<boat>/status`: counters of an agent since it was started. 1 Hz."""

    stamp_ns: Stamp
    ticks: Annotated[int, Meta(description="ticks of the control loop")] = 0
    ticks_late: Annotated[int, Meta(description="ticks skipped because the loop was late")] = 0
    messages_sent: Annotated[int, Meta(description="messages published")] = 0
    messages_received: Annotated[int, Meta(description="messages heard from others")] = 0
    messages_lost: Annotated[int, Meta(description="gaps in the sequence numbers of the others")] = 0
    messages_refused: Annotated[int, Meta(description="messages that did not decode or were not believed")] = 0
    records_dropped: Annotated[int, Meta(description="messages that the recorder had to drop")] = 0
    tick_mean_us: Annotated[Real, Meta(description="mean duration of a tick [us]")] = None
    tick_max_us: Annotated[Real, Meta(description="longest tick [us]")] = None
    rss_mb: Annotated[Real, Meta(description="memory of the process [MB]")] = None
    recording: Annotated[str, Meta(description="why the recording stopped; empty: it has not")] = ""


UNSAID = "operator"
"""Kind of an event: a word of the timeline that the operator could not say, and why."""


class Event(Struct, frozen=True, kw_only=True):
    """`/event`: something worth a line in the log."""

    stamp_ns: Stamp
    boat: Annotated[str, Meta(description="boat it happened to or on; empty: the whole fleet")] = ""
    kind: Annotated[str, Meta(description="mode, avoid, formation, refused, superseded, trouble, kill, ...")] = ""
    text: Annotated[str, Meta(description="what happened, for a person")] = ""
    reasons: Annotated[list[str], Meta(description="named reasons")] = []
    other: Annotated[str, Meta(description="the other boat or person concerned")] = ""
    value: Annotated[Real, Meta(description="the number it is about, if any, in the unit that the text names")] = None


class Command(Struct, frozen=True, kw_only=True):
    """`/command`: what an operator asked for, and what every boat answered."""

    stamp_ns: Stamp
    command: Annotated[str, Meta(description="the command, as typed")] = ""
    old: Annotated[str, Meta(description="what it replaced, in words")] = ""
    new: Annotated[str, Meta(description="what it set, in words")] = ""
    acks: Annotated[dict[str, str], Meta(description="answer of each boat by name; a silent boat says so")] = {}


def location_fix(stamp_ns: int, boat: str, lat_deg: float, lon_deg: float, variance_m2: float = 0.0) -> bytes:
    """`/<boat>/fix`: a position that viewers put on a map (`foxglove.LocationFix`), encoded."""
    diagonal = [variance_m2, 0.0, 0.0, 0.0, variance_m2, 0.0, 0.0, 0.0, 0.0]
    return msgspec.json.encode(
        {
            "timestamp": {"sec": stamp_ns // 1_000_000_000, "nsec": stamp_ns % 1_000_000_000},
            "frame_id": boat,
            "latitude": lat_deg,
            "longitude": lon_deg,
            "altitude": 0.0,
            "position_covariance": diagonal,
            "position_covariance_type": 2 if variance_m2 > 0.0 else 0,  # 2: diagonal known, 0: unknown
        }
    )


LOCATION_FIX = "foxglove.LocationFix"
_NUMBER = {"type": "number"}
_LOCATION_FIX_SCHEMA: dict[str, Any] = {
    "title": LOCATION_FIX,
    "type": "object",
    "properties": {
        "timestamp": {
            "title": "time",
            "type": "object",
            "properties": {"sec": {"type": "integer", "minimum": 0}, "nsec": {"type": "integer", "minimum": 0}},
        },
        "frame_id": {"type": "string", "description": "name of the boat"},
        "latitude": {**_NUMBER, "description": "WGS 84 [deg]"},
        "longitude": {**_NUMBER, "description": "WGS 84 [deg]"},
        "altitude": {**_NUMBER, "description": "above the ellipsoid; 0: not measured [m]"},
        "position_covariance": {"type": "array", "items": _NUMBER, "description": "east, north, up, by rows [m^2]"},
        "position_covariance_type": {"type": "integer", "description": "0 unknown, 2 diagonal known"},
    },
}


def truth_topic(boat: str) -> str:
    """`/truth/<boat>`."""
    return f"/truth/{boat}"


def traffic_topic(vessel: str) -> str:
    """`/traffic/<vessel>`: as `/truth/<boat>`, for vessels that are not of the fleet."""
    return f"/traffic/{vessel}"


def fix_topic(boat: str) -> str:
    """`/<boat>/fix`."""
    return f"/{boat}/fix"


def state_topic(boat: str) -> str:
    """`/<boat>/state`."""
    return f"/{boat}/state"


def status_topic(boat: str) -> str:
    """`/<boat>/status`."""
    return f"/{boat}/status"


def inputs_topic(boat: str) -> str:
    """`/<boat>/inputs`: what went into a tick, msgpack."""
    return f"/{boat}/inputs"


def decision_topic(boat: str) -> str:
    """`/<boat>/decision`: what came out of it, msgpack."""
    return f"/{boat}/decision"


def viewer_schema(layout: type[Struct]) -> bytes:
    """JSON schema of a message as Lichtblick and Foxglove accept it: one plain type a field, no references."""
    _, components = msgspec.json.schema_components([layout])
    fields = {name: _plain(field) for name, field in components[layout.__name__]["properties"].items()}
    return msgspec.json.encode({"title": f"fleet.{layout.__name__}", "type": "object", "properties": fields})


def _plain(field: dict[str, Any]) -> dict[str, Any]:
    """A field without alternatives: number or null is a number, and a map is an object of no fixed fields."""
    chosen: dict[str, Any] = next((one for one in field.get("anyOf", ()) if one != {"type": "null"}), {})
    kept = {key: value for key, value in {**field, **chosen}.items() if key in ("type", "items", "description")}
    return {**kept, "properties": {}} if kept["type"] == "object" else kept


def declare_fleet(recording: Recording) -> None:
    """Declare the topics that belong to no single boat."""
    for topic, layout in ((EVENT, Event), (COMMAND, Command)):
        recording.channel(topic, f"fleet.{layout.__name__}", "json", viewer_schema(layout))


def declare_boat(recording: Recording, boat: str, *, truth: bool = False, raw: bool = False) -> None:
    """Declare the topics of one boat; `truth` where a world is simulated, `raw` where `step` is recorded for replay."""
    recording.channel(fix_topic(boat), LOCATION_FIX, "json", msgspec.json.encode(_LOCATION_FIX_SCHEMA))
    recording.channel(state_topic(boat), "fleet.State", "json", viewer_schema(State))
    recording.channel(status_topic(boat), "fleet.Status", "json", viewer_schema(Status))
    if truth:
        recording.channel(truth_topic(boat), "fleet.Truth", "json", viewer_schema(Truth))
    if raw:
        recording.channel(inputs_topic(boat), "fleet.Inputs", "msgpack")
        recording.channel(decision_topic(boat), "fleet.Decision", "msgpack")


def declare_vessel(recording: Recording, vessel: str) -> None:
    """Declare the topic of a vessel that is not of the fleet."""
    recording.channel(traffic_topic(vessel), "fleet.Truth", "json", viewer_schema(Truth))


_ENCODER = msgspec.json.Encoder()


def encode(message: Truth | State | Status | Event | Command) -> bytes:
    """A message as it is recorded."""
    return _ENCODER.encode(message)
