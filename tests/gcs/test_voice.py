"""Frames packed from plain values are those of the dialect's own objects, to the last bit."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from itertools import chain, count, islice, repeat
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from fleet.drivers.mavlink.words import dialect
from fleet.gcs.telemetry import MAKERS, Shown
from fleet.gcs.voice import Values, Voice
from fleet.mission.model import Geographic
from tests.wire.samples import STATE, STATUS

MAVLINK = dialect()


def arguments(kind: Any, values: Values) -> Iterator[Any]:
    """What the constructor of a message takes: arrays as lists, what is left out as zeros."""
    rest = chain(values, repeat(0))
    for name, type_ in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        many = kind.array_lengths[kind.ordered_fieldnames.index(name)]
        yield list(islice(rest, many)) if many and type_ != "char" else next(rest)


def said_by_the_dialect(voice: Voice, number: int, values: Values) -> bytes:
    kind = MAVLINK.mavlink_map[number]
    return voice.message(kind(*arguments(kind, values)))


def some_values(kind: Any) -> Iterator[Any]:
    """No two that follow one another are alike, so that fields in the wrong place are seen."""
    numbers = count(1)
    for name, type_ in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        many = kind.array_lengths[kind.ordered_fieldnames.index(name)]
        if type_ == "char":
            yield b"ab" if many else b"c"
        else:
            yield from (next(numbers) % 100 for _ in range(many or 1))


def two_voices(signed: bool) -> tuple[Voice, Voice]:
    """That say the same if they say it right."""
    voices = Voice(MAVLINK, 250, 191), Voice(MAVLINK, 250, 191)
    for signing in (voice.codec.signing for voice in voices if signed):
        signing.secret_key = hashlib.sha256(b"a long passphrase").digest()
        signing.sign_outgoing, signing.link_id, signing.timestamp = True, 3, 0x0102030405
    return voices


def test_an_attitude_by_hand() -> None:
    voice = Voice(MAVLINK, 7, 1)
    frame = voice.values(30, (1000, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0))
    # zeros at the end are left out: of 28 bytes the milliseconds, roll, pitch and yaw remain
    head = bytes((0xFD, 16, 0, 0, 0, 7, 1, 30, 0, 0))
    assert frame[:-2] == head + (1000).to_bytes(4, "little") + bytes(8) + bytes((0, 0, 0x80, 0x3F))
    decoded = MAVLINK.MAVLink(None).decode(bytearray(frame))  # the checksum is right
    assert (decoded.get_type(), decoded.get_srcSystem(), decoded.yaw) == ("ATTITUDE", 7, 1.0)


def test_a_message_of_zeros_keeps_one_byte() -> None:
    assert Voice(MAVLINK, 7, 1).values(74, (0.0, 0.0, 0, 0, 0.0, 0.0))[1] == 1


def test_every_message_of_the_dialect() -> None:
    for signed in (False, True):
        ours, theirs = two_voices(signed)
        for number, kind in MAVLINK.mavlink_map.items():
            values = tuple(some_values(kind))
            frames = ours.values(number, values), said_by_the_dialect(theirs, number, values)
            assert frames[0] == frames[1], kind.msgname


@pytest.mark.parametrize("signed", [False, True])
@given(
    numbers=st.fixed_dictionaries(
        {
            "lat_deg": st.floats(-90.0, 90.0),
            "lon_deg": st.floats(-180.0, 180.0),
            "sog_mps": st.floats(0.0, 30.0),
            "cog_rad": st.floats(-7.0, 7.0),
            "heading_rad": st.floats(-7.0, 7.0),
            "yaw_rate_radps": st.floats(-100.0, 100.0),
            "position_error_m": st.floats(0.0, 1e3),
            "mode": st.integers(0, 9),
            "reasons": st.integers(0, 1 << 16),
        }
    ),
    battery=st.floats(-10.0, 110.0),
    armed=st.booleans(),
    home=st.booleans(),
)
def test_what_boats_are_shown_by(
    signed: bool, numbers: dict[str, Any], battery: float, armed: bool, home: bool
) -> None:
    state, status = structs.replace(STATE, **numbers), structs.replace(STATUS, battery_percent=battery)
    place = Geographic(lat_deg=state.lat_deg, lon_deg=state.lon_deg) if home else None
    shown = Shown(state, status, mode=15, armed=armed, home=place, item=3, items=70000)
    ours, theirs = two_voices(signed)
    for number, make in MAKERS.items():
        values = make(shown)
        assert ours.values(number, values) == said_by_the_dialect(theirs, number, values)


def test_one_sequence_whichever_way_it_is_said() -> None:
    voice = Voice(MAVLINK, 3, 1)
    ways = (voice.values, lambda number, values: said_by_the_dialect(voice, number, values))
    assert [ways[i % 2](42, (i,))[4] for i in range(300)] == [i % 256 for i in range(300)]
