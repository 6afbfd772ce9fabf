"""Bytes <-> messages: golden bytes, so that a change of the wire is seen; what is refused, and with which words."""

from __future__ import annotations

import contextlib
import math
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fleet.wire import messages
from fleet.wire.codec import (
    Refused,
    decode,
    decode_command,
    decode_formation,
    decode_mission_order,
    decode_state,
    encode,
)
from fleet.wire.messages import BoatState, Revision, Signed
from tests.wire.samples import COMMAND, FORMATION, MISSION, SAMPLES, STATE

GOLDEN = {
    "BoatState": (
        "dc002301a26231cf17979cfe362a00012acf17979cff3080ea00ce02faf080cb404630a3d70a3d71cb4021dc28f5c28f5ccb3fb999999999"
        "999acb3ff028f5c28f5c29cb3fbc28f5c28f5c29cbbf947ae147ae147bcb3fe000000000000001cb405ed0000000000002ce00040000cb3f"
        "beb851eb851eb8cb3ff051eb851eb852cb3fc0a3d70a3d70a4cb404e000000000000cb3fc1eb851eb851eccb3feccccccccccccdcbbfd000"
        "0000000000cb3fe8000000000000a26232cb4027000000000000a9313730302d616e6e619201a4616e6e619202a3626f6292a27331a27332"
        "c39203a46361726ccb40040000000000009b03cf17979cfe5fe32700c3cb3fe8000000000000cb3fe0000000000000cb3ff8000000000000"
        "cb3ff0000000000000cb3fe800000000000001a56665727279c2"
    ),
    "BoatStatus": (
        "dc002201a262311112a5302e312e30a561766f696491ad6b656570696e6720636c656172a9313730302d616e6e61a954776f20626f617473"
        "a4616e6e61cb4034000000000000cb3ff0000000000000cb4054000000000000016402cb3ff800000000000063030405a96469736b206675"
        "6c6ca7627573206f6666a8756e696379636c6591ae342078206e6f742066696e69746513a0cb0000000000000000cb000000000000000090"
        "a00000c2"
    ),
    "Frames": "9501a4616e6e61c403fe0001a262311a",
    "FormationOrder": (
        "9b01a9313730302d616e6e619202a3626f629201a4616e6e61cbc034000000000000cb3ff0000000000000cb400400000000000015a57765"
        "646765cb40280000000000009292a26231cb000000000000000092a26232cbbff0000000000000"
    ),
    "MissionOrder": "9601a9313730302d616e6e61a4616e6e6116c40180cb4008000000000000",
    "Signed": "93c404626f6479c4097369676e6174757265b26f70657261746f722e616e6e612e30306666",
    "Held": "930193c404626f6479c4097369676e6174757265b26f70657261746f722e616e6e612e30306666cb3ff8000000000000",
    "Command": (
        "9a01a469642d31a4616e6e61a373657491a2623193c404626f6479c4097369676e6174757265b26f70657261746f722e616e6e612e30306666"
        "91a27331a76e656172657374a9313730302d616e6e6117"
    ),
    "Ack": "9901a469642d31a26231c2a3776879a36f6c64a36e6577a5302e312e30c3",
    "FleetEvent": "9601a2623118a46d6f6465af666f6c6c6f77202d3e2061766f6964cb4000000000000000",
    "Echo": "920119",
    "Stops": "92019193c404626f6479c4097369676e6174757265b26f70657261746f722e616e6e612e30306666",
}
FLOATS = [name for name, kind in BoatState.__annotations__.items() if kind == "float"]
kinds = pytest.mark.parametrize("name", sorted(SAMPLES))


# -- golden bytes ------------------------------------------------------------------------------------------------------
@kinds
def test_every_message_has_the_bytes_that_boats_in_the_water_expect(name: str) -> None:
    assert encode(SAMPLES[name]).hex() == GOLDEN[name]


@kinds
def test_every_message_comes_back_as_it_went(name: str) -> None:
    message = SAMPLES[name]
    assert decode(encode(message), type(message)) == message


@kinds
def test_a_newer_minor_that_appends_a_field_is_understood(name: str) -> None:
    message = SAMPLES[name]
    row = msgspec.msgpack.decode(encode(message))
    assert decode(encode([*row, "of a later version"]), type(message)) == message


@kinds
def test_an_older_minor_without_the_appended_fields_is_understood(name: str) -> None:
    kind = type(SAMPLES[name])
    fields = msgspec.structs.fields(kind)
    needed = [f for f in fields if f.required]
    row = msgspec.msgpack.decode(encode(SAMPLES[name]))[: len(needed)]
    assert decode(encode(row), kind) == kind(*[getattr(SAMPLES[name], f.name) for f in needed])


def test_every_message_begins_with_the_major_version() -> None:
    assert all(next(iter(type(m).__struct_fields__)) == "major" for m in SAMPLES.values() if not isinstance(m, Signed))


@pytest.mark.parametrize("name", sorted(set(SAMPLES) - {"Signed"}))
@pytest.mark.parametrize("major", [0, 2, -1, 1 << 40])
def test_another_major_version_is_refused(name: str, major: int) -> None:
    message = msgspec.structs.replace(SAMPLES[name], major=major)
    with pytest.raises(Refused, match="another wire version"):
        decode(encode(message), type(message))


def test_every_message_of_the_wire_is_here() -> None:
    known = {n for n, k in vars(messages).items() if isinstance(k, type) and issubclass(k, msgspec.Struct)}
    assert known - {"Struct", "Revision", "ForeignOrder"} == set(SAMPLES)  # two that are parts of others


# -- refused -----------------------------------------------------------------------------------------------------------
@kinds
def test_a_message_cut_anywhere_is_refused(name: str) -> None:
    payload = encode(SAMPLES[name])
    for length in range(len(payload)):
        with pytest.raises(Refused, match="does not decode"):
            decode(payload[:length], type(SAMPLES[name]))


@kinds
def test_bytes_after_the_end_are_refused(name: str) -> None:
    with pytest.raises(Refused, match="does not decode"):
        decode(encode(SAMPLES[name]) + b"\x00", type(SAMPLES[name]))


@kinds
@settings(max_examples=80, deadline=None)
@given(payload=st.binary(max_size=400))
def test_random_bytes_are_refused_or_a_message_and_nothing_else(name: str, payload: bytes) -> None:
    with contextlib.suppress(Refused):
        decode(payload, type(SAMPLES[name]))


@settings(max_examples=300, deadline=None)
@given(at=st.integers(0, 300), bits=st.integers(1, 255))
def test_a_state_with_a_byte_changed_is_refused_or_possible(at: int, bits: int) -> None:
    payload = bytearray(encode(STATE))
    payload[at % len(payload)] ^= bits
    try:
        state = decode_state(bytes(payload), "b1")
    except Refused:
        return
    assert all(math.isfinite(getattr(state, name)) for name in FLOATS)
    assert abs(state.lat_deg) <= 90.0
    assert 0.0 <= state.sog_mps <= 30.0


@kinds
def test_a_wrong_type_anywhere_is_refused(name: str) -> None:
    kind = type(SAMPLES[name])
    row = msgspec.msgpack.decode(encode(SAMPLES[name]))
    for k in range(len(row)):
        for wrong in ({"a": 1}, [[]], [1, 2, 3, 4, 5, 6, 7], b"\xff" if not isinstance(row[k], bytes) else 5):
            with pytest.raises(Refused):
                decode(encode([*row[:k], wrong, *row[k + 1 :]]), kind)


def test_what_is_nested_a_hundred_thousand_deep_is_refused() -> None:
    with pytest.raises(Refused):
        decode(b"\x91" * 100_000 + b"\x01", messages.Command)


def test_what_is_too_large_is_refused_before_it_is_read() -> None:
    with pytest.raises(Refused, match="too large"):
        decode(bytes((1 << 20) + 1), messages.Command)
    with pytest.raises(Refused, match="too large"):
        decode_state(bytes(4097), "b1")


def test_text_that_is_not_utf8_is_refused() -> None:
    payload = encode(SAMPLES["Echo"]).replace(b"\x92\x01\x19", b"\x92\x01\xa1\xff")
    with pytest.raises(Refused):
        decode(payload, messages.Echo)


# -- states ------------------------------------------------------------------------------------------------------------
def refused(**changes: Any) -> str:
    with pytest.raises(Refused) as caught:
        decode_state(encode(msgspec.structs.replace(STATE, **changes)), "b1")
    return str(caught.value)


def test_a_good_state_is_taken() -> None:
    assert decode_state(encode(STATE), "b1") == STATE


@pytest.mark.parametrize("field", FLOATS)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_state_with_a_number_that_is_none_is_refused(field: str, value: float) -> None:
    assert refused(**{field: value}) == "not finite"


def test_infinities_do_not_cancel() -> None:
    assert refused(s_m=math.inf, along_path_m=-math.inf) == "not finite"


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"boat": "b2"}, "another boat's name"),
        ({"lat_deg": 90.1}, "position not on Earth"),
        ({"lat_deg": -91.0}, "position not on Earth"),
        ({"lon_deg": 180.5}, "position not on Earth"),
        ({"sog_mps": -0.1}, "impossible speed"),
        ({"sog_mps": 30.1}, "impossible speed"),
        ({"plan_speed_mps": 31.0}, "impossible speed"),
        ({"cog_rad": 8.0}, "impossible angle"),
        ({"heading_rad": -8.0}, "impossible angle"),
        ({"plan_course_rad": 1e9}, "impossible angle"),
        ({"tangent_rad": 7.1}, "impossible angle"),
        ({"position_error_m": -1.0}, "impossible number"),
        ({"straight_s": -1.0}, "impossible number"),
        ({"seq": -1}, "impossible number"),
        ({"clock_ns": -1}, "impossible number"),
        ({"stops": ("s",) * 65}, "impossible number"),
        ({"stops": ("s" * 201,)}, "impossible revision"),
        ({"mission_id": "m" * 201}, "impossible revision"),
        ({"held": Revision(-1, "x")}, "impossible revision"),
        ({"in_force": Revision(1 << 41, "x")}, "impossible revision"),
        ({"control": Revision(1, "x" * 33)}, "impossible revision"),
    ],
)
def test_a_state_that_cannot_be_true_is_refused(changes: dict[str, Any], why: str) -> None:
    assert refused(**changes) == why


@pytest.mark.parametrize(
    ("field", "value"),
    [("mode", 255), ("reasons", (1 << 63) - 1), ("stamp_ns", 0), ("stamp_ns", (1 << 63) - 1), ("lap", -1)],
)
def test_modes_and_reasons_of_newer_versions_and_wrong_clocks_pass(field: str, value: int) -> None:
    decode_state(encode(msgspec.structs.replace(STATE, **{field: value})), "b1")


@pytest.mark.parametrize("field", ["seq", "clock_ns"])
def test_whole_numbers_that_cannot_be_negative_are_refused(field: str) -> None:
    assert refused(**{field: -(1 << 63)}) == "impossible number"


@pytest.mark.parametrize(
    "field", ["position_error_m", "straight_s", "s_m", "yaw_rate_radps", "length_m", "along_path_m"]
)
def test_numbers_that_are_finite_but_absurd_are_refused(field: str) -> None:
    assert refused(**{field: 1e300}) == "impossible number"


# -- words of operators ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "changes",
    [
        {"id": ""},
        {"id": "i" * 65},
        {"operator": ""},
        {"operator": "Anna"},
        {"operator": "anna/../bob"},
        {"operator": "anna\n"},
        {"operator": "a" * 33},
        {"names": ("n",) * 257},
        {"boats": ("n",) * 257},
        {"text": "t" * 201},
    ],
)
def test_a_command_that_cannot_be_is_refused(changes: dict[str, Any]) -> None:
    with pytest.raises(Refused):
        decode_command(encode(msgspec.structs.replace(COMMAND, **changes)))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", ["spacing_m", "cruise_mps", "apply_in_s"])
def test_a_formation_with_a_number_that_is_none_is_refused(field: str, value: float) -> None:
    with pytest.raises(Refused, match="not finite"):
        decode_formation(Signed(encode(msgspec.structs.replace(FORMATION, **{field: value}))))


@pytest.mark.parametrize(
    "changes",
    [
        {"apply_in_s": -0.1},
        {"apply_in_s": 3601.0},
        {"revision": Revision(-1, "x")},
        {"revision": Revision(1 << 41, "x")},
        {"revision": Revision(1, "x" * 33)},
        {"mission_id": "m" * 201},
    ],
)
def test_a_formation_that_cannot_be_is_refused(changes: dict[str, Any]) -> None:
    with pytest.raises(Refused, match="impossible order"):
        decode_formation(Signed(encode(msgspec.structs.replace(FORMATION, **changes))))


@pytest.mark.parametrize(
    "changes", [{"apply_in_s": math.nan}, {"apply_in_s": -1.0}, {"mission_id": ""}, {"mission_id": "m" * 201}]
)
def test_a_mission_order_that_cannot_be_is_refused(changes: dict[str, Any]) -> None:
    with pytest.raises(Refused, match="impossible order"):
        decode_mission_order(Signed(encode(msgspec.structs.replace(MISSION, **changes))))


def test_revisions_are_ordered_by_counter_and_then_by_operator() -> None:
    assert Revision(1, "bob") < Revision(2, "anna") < Revision(2, "bob")
    assert Revision() < Revision(1, "anna")
    assert str(Revision()) == "0:launch"
    assert str(Revision(3, "anna")) == "3:anna"
