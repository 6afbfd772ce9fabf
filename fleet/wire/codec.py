"""Bytes <-> messages. What does not decode, or is not possible, is refused here with a word that says why."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, Final, TypeVar

import msgspec

from fleet.wire.keys import NAME
from fleet.wire.messages import (
    MAJOR,
    Ack,
    BoatState,
    BoatStatus,
    Command,
    Echo,
    FleetEvent,
    ForeignOrder,
    FormationOrder,
    Frames,
    Held,
    MissionOrder,
    Revision,
    Signed,
    Stops,
)

Message = TypeVar("Message")
LARGEST = 1 << 20  # bytes of a message; a mission with ten thousand points is a quarter of it
LARGEST_STATE = 4096
FASTEST_MPS = 30.0
FARTHEST = 1e9  # metres or seconds of anything; a number beyond overflows somewhere in a sum
LARGEST_JUMP = 1000  # revisions
WIDEST_M = 1e5  # spacing, either way; a flat sea is good for less
TEXT = 200

_encoder: Final = msgspec.msgpack.Encoder()
_decoders: Final[dict[type, Any]] = {
    kind: msgspec.msgpack.Decoder(kind)
    for kind in (
        Ack,
        BoatState,
        BoatStatus,
        Command,
        Echo,
        FleetEvent,
        FormationOrder,
        Frames,
        Held,
        MissionOrder,
        Signed,
        Stops,
    )
}
encode = _encoder.encode
"""A message as bytes."""


class Refused(ValueError):
    """A message that is not obeyed; the text says why in a word or two."""


def decode(payload: bytes, kind: type[Message]) -> Message:
    """The message in the payload; Refused when it is none of ours."""
    if len(payload) > (LARGEST_STATE if kind is BoatState else LARGEST):
        raise Refused("too large")
    try:
        message: Message = _decoders[kind].decode(payload)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        raise Refused("does not decode") from None
    if not isinstance(message, Signed) and message.major != MAJOR:  # type: ignore[attr-defined]
        raise Refused("another wire version")
    return message


@lru_cache(maxsize=256)
def decode_state(payload: bytes, sender: str) -> BoatState:
    """The state that `sender` published on its own key; Refused when it cannot be true.

    Receivers in one process share the bytes, and so what was found in them.
    """
    state = decode(payload, BoatState)
    if state.boat != sender:
        raise Refused("another boat's name")
    if state.seq < 0 or state.clock_ns < 0:
        raise Refused("impossible number")
    total = (  # one sum, since this runs for every message heard: a number that is not finite shows in it
        state.lat_deg
        + state.lon_deg
        + state.cog_rad
        + state.sog_mps
        + state.heading_rad
        + state.yaw_rate_radps
        + state.position_error_m
        + state.s_m
        + state.plan_course_rad
        + state.plan_speed_mps
        + state.tangent_rad
        + state.straight_s
        + state.decided_yaw_rate_radps
        + state.decided_speed_mps
        + state.cross_track_m
        + state.along_path_m
        + state.nearest_m
        + state.length_m
    )
    if not math.isfinite(total):
        raise Refused("not finite")
    if abs(state.lat_deg) > 90.0 or abs(state.lon_deg) > 180.0:
        raise Refused("position not on Earth")
    if not 0.0 <= state.sog_mps <= FASTEST_MPS or not 0.0 <= state.plan_speed_mps <= FASTEST_MPS:
        raise Refused("impossible speed")
    if not (
        -7.0 <= state.cog_rad <= 7.0
        and -7.0 <= state.heading_rad <= 7.0
        and -7.0 <= state.plan_course_rad <= 7.0
        and -7.0 <= state.tangent_rad <= 7.0
    ):
        raise Refused("impossible angle")
    if not (
        0.0 <= state.position_error_m <= 1e3
        and 0.0 <= state.straight_s <= FARTHEST
        and -FARTHEST <= state.s_m <= FARTHEST
        and -FARTHEST <= state.cross_track_m <= FARTHEST
        and -FARTHEST <= state.along_path_m <= FARTHEST
        and 0.0 <= state.nearest_m <= FARTHEST
        and -100.0 <= state.yaw_rate_radps <= 100.0
        and -FASTEST_MPS <= state.decided_speed_mps <= FASTEST_MPS
        and 0.0 <= state.length_m <= 1e3
        and state.epoch >= 0
        and state.mode >= 0
        and state.reasons >= 0
        and len(state.stops) <= 64
    ):
        raise Refused("impossible number")
    if len(state.mission_id) > TEXT or len(state.nearest) > TEXT or any(len(stop) > TEXT for stop in state.stops):
        raise Refused("impossible revision")
    if not (_plausible(state.in_force) and _plausible(state.held) and _plausible(state.control)):
        raise Refused("impossible revision")
    if state.foreign is not None and not _possible(state.foreign):
        raise Refused("impossible order")
    return state


def _possible(order: ForeignOrder) -> bool:
    """Whether a boat may have decided that about a vessel."""
    return (
        0 <= order.serial < 1 << 40
        and 0 <= order.apply_ns < 1 << 62
        and abs(order.offset_rad) <= 7.0
        and 0.0 <= order.factor <= 100.0
        and abs(order.course_rad) <= 7.0
        and order.sense in (-1.0, 0.0, 1.0)
        and abs(order.path_rad) <= 7.0
        and 0 <= order.reason <= 100
        and len(order.vessel) <= TEXT
    )


def _plausible(revision: Revision) -> bool:
    return 0 <= revision.counter < 1 << 40 and len(revision.operator) <= 32


def decode_command(payload: bytes) -> Command:
    """A command; Refused when it is malformed."""
    command = decode(payload, Command)
    if not 0 < len(command.id) <= 64 or not plain(command.id) or not NAME.fullmatch(command.operator):
        raise Refused("command without an id or an operator's name")
    if len(command.names) > 256 or len(command.boats) > 256 or len(command.text) > TEXT:
        raise Refused("impossible command")
    words = (command.kind, *command.boats, *command.names)  # they come back in answers and events
    if any(len(word) > 64 for word in words) or not (len(command.mission_id) <= TEXT and plain(command.mission_id)):
        raise Refused("impossible command")
    return command


def plain(text: str) -> bool:
    """Whether a text is of printable ASCII: as many bytes as letters, one line."""
    return text.isascii() and (text.isprintable() or not text)


def decode_formation(signed: Signed) -> FormationOrder:
    """The formation order in an operator's words; Refused when it cannot be one."""
    order = decode(signed.body, FormationOrder)
    slots = [slot for _, slot in order.slots]
    if not math.isfinite(order.spacing_m + order.cruise_mps + order.apply_in_s + order.lateral_m + sum(slots)):
        raise Refused("not finite")
    if not 0.0 <= order.apply_in_s <= 3600.0 or not (_plausible(order.revision) and _plausible(order.based_on)):
        raise Refused("impossible order")
    if max(abs(order.spacing_m), abs(order.lateral_m), *(abs(slot) for slot in slots)) > WIDEST_M:
        raise Refused("is for a formation too long")
    if not 0.0 <= order.cruise_mps <= FASTEST_MPS:
        raise Refused("impossible order")
    if len(order.mission_id) > TEXT or not plain(order.mission_id) or not plain(order.pattern[:TEXT]):
        raise Refused("impossible order")
    return order


def decode_mission_order(signed: Signed) -> MissionOrder:
    """The mission order in an operator's words; Refused when it cannot be one."""
    order = decode(signed.body, MissionOrder)
    if not math.isfinite(order.apply_in_s) or not 0.0 <= order.apply_in_s <= 3600.0:
        raise Refused("impossible order")
    if not 0 < len(order.mission_id) <= TEXT or not plain(order.mission_id) or len(order.operator) > 32:
        raise Refused("impossible order")
    return order


def decode_held(payload: bytes) -> Held:
    """A neighbour's answer about its mission or formation; Refused when it cannot be one."""
    held = decode(payload, Held)
    if not math.isfinite(held.remaining_s):
        raise Refused("not finite")
    return held
