"""Random and mutated frames into a ground-station bridge with five boats, and well-formed ones that mean nothing.

python -m tests.attack.gcs --count 1000000     the whole of it; the test sends a few thousand
"""

from __future__ import annotations

import argparse
import random
import struct
import time
from typing import Any

from msgspec import Struct

from fleet.gcs.vehicle import MISSION_MESSAGES
from fleet.gcs.wishes import Done
from tests.gcs.deck import MAVLINK, Deck, mission

BOATS = ("b1", "b2", "b3", "b4", "b5")
A_TICK = 20  # frames in a twentieth of a second
MEANT = sorted(
    {"COMMAND_LONG", "COMMAND_INT", "SET_MODE", "PARAM_SET", "PARAM_REQUEST_READ", "PARAM_REQUEST_LIST", "TIMESYNC"}
    | {"FILE_TRANSFER_PROTOCOL", "PING", "HEARTBEAT", "MISSION_SET_CURRENT", "MANUAL_CONTROL"}
    | MISSION_MESSAGES
)
EDGES = (0.0, -0.0, 1.0, -1.0, 1e-30, 1e30, -1e30, float("inf"), float("-inf"), float("nan"), 2989.0, 21196.0, 44.38)


class Result(Struct):
    """What came of it."""

    sent: int = 0
    wishes_of_noise: int = 0  # words to the fleet that nobody said
    by_chance: int = 0  # frames among those whose checksum is right all the same
    unexplained: int = 0  # words in ticks of noise in which no frame was so
    wishes: int = 0  # of well-formed frames with values drawn
    internal_errors: int = 0
    heartbeats: int = 0
    seconds_simulated: float = 0.0
    most_wishes_waiting: int = 0
    most_out: int = 0  # datagrams in one tick
    taken: int = 0
    bad: int = 0
    unchanged: int = 0  # mutated back into what they were, and not sent
    seconds: float = 0.0


def spoil(draw: random.Random, good: bytes) -> bytes:
    """A frame that is none."""
    kind = draw.randrange(4)
    if kind == 0:
        return draw.randbytes(draw.randrange(1, 280))
    frame = bytearray(good)
    if kind == 1:
        for _ in range(draw.randrange(1, 6)):
            frame[draw.randrange(len(frame))] ^= 1 << draw.randrange(8)
    elif kind == 2:
        a = draw.randrange(len(frame))
        frame[a : a + draw.randrange(1, 9)] = draw.randbytes(draw.randrange(0, 9))
    else:
        return bytes(frame[: draw.randrange(len(frame))]) + draw.randbytes(draw.randrange(0, 20))
    return bytes(frame)


def drawn(draw: random.Random, codec: Any) -> bytes:
    """A well-formed frame with any values."""
    name = draw.choice(MEANT)
    kind = getattr(MAVLINK, f"MAVLink_{name.lower()}_message")
    fields: list[Any] = []
    for field, wire in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        length = kind.array_lengths[kind.ordered_fieldnames.index(field)]
        if wire == "char":
            text = draw.choice((b"FLT_SPACING", b"FLT_CRUISE", b"FLT_ALONE", b"FLT_CONTROL", draw.randbytes(8), b""))
            fields.append(text)
        elif length:
            fields.append([draw.randrange(256) for _ in range(length)])
        elif wire in ("float", "double"):
            fields.append(draw.choice(EDGES) if draw.random() < 0.7 else draw.uniform(-200.0, 200.0))
        elif field == "target_system":
            fields.append(draw.choice((0, 1, 1, 2, 3, 9)))
        elif field == "target_component":
            fields.append(draw.choice((0, 1, 1, 154)))
        elif field == "command":
            fields.append(draw.choice((16, 17, 20, 176, 177, 178, 192, 193, 300, 400, 410, 511, 512, 520, 9999)))
        elif field in ("seq", "count"):
            fields.append(draw.choice((0, 1, 2, 3, 500, 65535)))
        elif field == "mission_type":
            fields.append(draw.choice((0, 0, 0, 1, 2, 255, 7)))
        elif field == "custom_mode":
            fields.append(draw.choice((0, 4, 5, 10, 11, 12, 15, 4_000_000_000)))
        else:
            bits = {"int8_t": 7, "uint8_t": 8, "int16_t": 15, "uint16_t": 16, "int32_t": 31, "uint32_t": 32}.get(
                wire, 63
            )
            fields.append(draw.choice((0, 1, (1 << bits) - 1, draw.randrange(1 << bits))))
    codec.srcSystem = draw.choice((255, 254, 1, 0, 77))
    try:
        return bytes(kind(*fields).pack(codec))
    except struct.error:
        return b""


def attack(count: int, seed: int = 1) -> Result:
    """So many frames, half of them noise, half well-formed."""
    draw, result, deck = random.Random(seed), Result(), Deck(*BOATS)
    codec = MAVLINK.MAVLink(None, srcSystem=255, srcComponent=190)
    good = [bytes(m.pack(codec)) for m in _meant(deck)]
    deck.station.read = lambda datagram: None  # type: ignore[method-assign]
    bridge, began = deck.bridge, time.perf_counter()
    while result.sent < count:
        noise = bool(draw.getrandbits(1))
        heard: list[bytes] = []
        for _ in range(min(A_TICK, count - result.sent)):
            peer = (0, ("127.0.0.1", draw.randrange(40)))
            frame = spoil(draw, draw.choice(good)) if noise else drawn(draw, codec)
            if noise and frame in good:
                result.unchanged += 1
                continue
            heard.append(frame)
            bridge.hear(peer, frame, deck.now_s)
            result.sent += 1
        wishes = bridge.take_wishes()
        if noise and wishes:
            result.wishes_of_noise += len(wishes)
            by_chance = sum(map(_whole, heard))
            result.by_chance += by_chance
            result.unexplained += len(wishes) * (by_chance == 0)
        result.wishes += len(wishes)
        result.most_wishes_waiting = max(result.most_wishes_waiting, len(bridge._then))
        for wish in wishes:
            if draw.random() < 0.9:
                ok = bool(draw.getrandbits(1))
                bridge.done(Done(wish.number, ok, "" if ok else "no", value=f"{draw.randrange(99)}-x"), deck.now_s)
        out = bridge.take_outbox()
        result.most_out = max(result.most_out, len(out))
        deck.now_s += 0.05
        result.seconds_simulated += 0.05
        for view in deck.views.values():
            view.heard_s = deck.now_s
        bridge.step(deck.now_s)
        for _, datagram in (*out, *bridge.take_outbox()):
            result.heartbeats += datagram[7:10] == b"\0\0\0"
    result.internal_errors = bridge.counts["internal error"]
    result.taken, result.bad = bridge._frames.counts["taken"], bridge._frames.counts["bad"]
    result.seconds = time.perf_counter() - began
    return result


def _whole(frame: bytes) -> bool:
    """Whether it holds a message with a right checksum, by a decoder that is not ours."""
    codec = MAVLINK.MAVLink(None)
    codec.robust_parsing = True
    kinds = [message.get_type() for message in codec.parse_buffer(frame) or ()]
    return any(kind != "BAD_DATA" and not kind.startswith("UNKNOWN") for kind in kinds)


def _meant(deck: Deck) -> list[Any]:
    """Frames of a station that means what it says."""
    items = mission((0.0, 0.0), (100.0, 0.0))
    item = MAVLINK.MAVLink_mission_item_int_message(1, 1, 0, 3, 16, 0, 1, 0, 0, 0, 0, items[0].x, items[0].y, 0, 0)
    return [
        MAVLINK.MAVLink_command_long_message(1, 1, 176, 0, 1, 5, 0, 0, 0, 0, 0),
        MAVLINK.MAVLink_command_long_message(2, 1, 400, 0, 0, 0, 0, 0, 0, 0, 0),
        MAVLINK.MAVLink_param_set_message(1, 1, b"FLT_CONTROL", 1.0, 9),
        MAVLINK.MAVLink_set_mode_message(1, 1, 11),
        MAVLINK.MAVLink_mission_count_message(1, 1, 3, 0),
        item,
    ]


def main() -> None:
    """From the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.attack.gcs")
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    result = attack(options.count, options.seed)
    for name in result.__struct_fields__:
        print(f"{name:<22} {getattr(result, name)}")


if __name__ == "__main__":
    main()
