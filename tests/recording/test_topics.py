"""Messages of a run are JSON that viewers accept."""

from __future__ import annotations

import json
import math

import msgspec
import pytest

from fleet.recording.seam import MemoryRecorder
from fleet.recording.topics import (
    Command,
    Event,
    State,
    Status,
    Truth,
    declare_boat,
    declare_fleet,
    encode,
    location_fix,
    viewer_schema,
)

STATE = State(stamp_ns=1, x_m=1.0, y_m=2.0, psi_rad=0.0, sog_mps=1.0, e_s_m=math.nan, reasons=["peer-silent"])


def test_unknown_is_null_and_reads_back_as_unknown() -> None:
    written = encode(STATE)
    assert json.loads(written)["e_s_m"] is None
    assert msgspec.json.decode(written, type=State).e_s_m is None
    assert b"null" in location_fix(1, "a", math.nan, 10.0)


def test_a_position_is_a_location_fix_with_seconds_and_nanoseconds() -> None:
    fix = json.loads(location_fix(1_700_000_000_123_456_789, "otter-1", 44.1, 9.8, 0.25))
    assert fix["timestamp"] == {"sec": 1_700_000_000, "nsec": 123_456_789}
    assert (fix["frame_id"], fix["latitude"], fix["longitude"]) == ("otter-1", 44.1, 9.8)
    assert fix["position_covariance"][0] == fix["position_covariance"][4] == 0.25


def plain(schema: dict[str, object]) -> bool:
    """The rule of the viewers' parser: one type a field, no references, objects list their fields."""
    kind = schema.get("type")
    if kind == "object":
        assert isinstance(schema["properties"], dict)
        return all(plain(one) for one in schema["properties"].values())
    if kind == "array":
        assert isinstance(schema["items"], dict)
        return plain(schema["items"])
    return kind in ("number", "integer", "string", "boolean")


@pytest.mark.parametrize("layout", [Truth, State, Status, Event, Command])
def test_schemas_are_of_the_kind_that_viewers_accept_and_every_field_says_its_unit(
    layout: type[msgspec.Struct],
) -> None:
    schema = json.loads(viewer_schema(layout))
    assert plain(schema)
    assert list(schema["properties"]) == list(layout.__struct_fields__)
    for name, field in schema["properties"].items():
        assert field["description"], name
        for suffix, unit in (("_m", "[m]"), ("_mps", "[m/s]"), ("_rad", "[rad]"), ("_ns", "[ns]"), ("_deg", "[deg]")):
            if name.endswith(suffix):
                assert unit in field["description"]


def test_all_topics_of_a_boat_are_declared_with_plain_schemas() -> None:
    recorder = MemoryRecorder()
    declare_fleet(recorder)
    declare_boat(recorder, "otter-1", truth=True, raw=True)
    assert set(recorder.channels) == {
        "/event", "/command", "/truth/otter-1", "/otter-1/fix", "/otter-1/state", "/otter-1/status",
        "/otter-1/inputs", "/otter-1/decision",
    }  # fmt: skip
    assert recorder.channels["/otter-1/fix"].schema_name == "foxglove.LocationFix"
    assert all(plain(json.loads(one.schema)) for one in recorder.channels.values() if one.schema)
