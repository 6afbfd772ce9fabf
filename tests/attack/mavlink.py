"""Random and mutated frames into the MAVLink driver, over its real socket, while a good autopilot goes on speaking.

python -m tests.attack.mavlink --count 1000000     the whole of it; the test sends 10,000
"""

from __future__ import annotations

import argparse
import math
import random
import socket
import time
from collections import Counter

from msgspec import Struct

from fleet.drivers.mavlink.config import MavlinkConfig
from fleet.drivers.mavlink.driver import MavlinkDriver
from fleet.drivers.mavlink.words import dialect

BEGIN_NS = 1_700_000_000_000_000_000
TICK_NS = 100_000_000
LAT, LON = 44.38, 8.93
NORTH_MPS = 1.0
METRES_A_DEGREE = 111_195.0
A_TICK = 100  # bad frames
WORST_M = 1.0


class Result(Struct):
    """What came of it."""

    sent: int = 0
    ticks: int = 0
    good_sent: int = 0
    taken: int = 0
    bad: int = 0
    others: int = 0
    junk: int = 0
    values_refused: int = 0
    unchanged: int = 0  # mutated back into what they were
    lucky: int = 0  # bad frames whose checksum is right
    worst_m: float = 0.0
    unknown_ticks: int = 0  # ticks in which the driver did not say where the boat is
    foreign_authority: int = 0  # ticks in which it said that somebody else commands
    seconds: float = 0.0


class Autopilot:
    """Says the truth: 1 m/s north, armed, in GUIDED."""

    def __init__(self) -> None:
        self.m = dialect()
        self.codec = self.m.MAVLink(None, srcSystem=1, srcComponent=1)

    def frames(self, t_s: float, second: bool) -> list[bytes]:
        """What is due at a tick."""
        m, ms = self.m, round(t_s * 1000.0)
        lat = round((LAT + NORTH_MPS * t_s / METRES_A_DEGREE) * 1e7)
        said = [
            m.MAVLink_global_position_int_message(ms, lat, round(LON * 1e7), 0, 0, 100, 0, 0, 0),
            m.MAVLink_attitude_message(ms, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
            m.MAVLink_ekf_status_report_message(0x33F, 0.1, 0.1, 0.1, 0.1, 0.0),
            m.MAVLink_gps_raw_int_message(ms * 1000, 3, lat, 0, 0, 80, 120, 0, 0, 12, 0, 500, 500, 0),
        ]
        if second:
            said.append(m.MAVLink_heartbeat_message(11, 3, 129, 15, 4, 3))
            said.append(m.MAVLink_sys_status_message(2, 2, 2, 0, 12000, -1, 80, 0, 0, 0, 0, 0, 0))
        out = []
        for message in said:
            out.append(bytes(message.pack(self.codec)))
            self.codec.seq = (self.codec.seq + 1) % 256
        return out


def spoil(draw: random.Random, good: list[bytes]) -> bytes:
    """A frame that is none: noise, a header with noise behind it, or a good frame with something changed."""
    kind = draw.randrange(5)
    if kind == 0:
        return draw.randbytes(draw.randrange(1, 280))
    if kind == 1:
        number = draw.choice((0, 1, 24, 30, 33, 77, 193, 253))
        body = draw.randbytes(draw.randrange(0, 60))
        return bytes((0xFD, len(body), 0, 0, draw.randrange(256), 1, 1, number, 0, 0)) + body + draw.randbytes(2)
    frame = bytearray(draw.choice(good))
    if kind == 2:
        for _ in range(draw.randrange(1, 6)):
            frame[draw.randrange(len(frame))] ^= 1 << draw.randrange(8)
    elif kind == 3:
        a = draw.randrange(len(frame))
        frame[a : a + draw.randrange(1, 9)] = draw.randbytes(draw.randrange(0, 9))
    else:
        k = draw.randrange(10, len(frame) - 2)
        frame[k:-2] = draw.randbytes(len(frame) - 2 - k)
    return bytes(frame)


def attack(count: int, seed: int = 1, lucky: int = 0) -> Result:
    """Send so many; `lucky` of 100,000 get the right checksum, as one of 65,536 does by chance."""
    draw, result, pilot = random.Random(seed), Result(), Autopilot()
    now_ns = BEGIN_NS
    theirs = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    theirs.bind(("127.0.0.1", 0))
    endpoint = f"udp:127.0.0.1:{theirs.getsockname()[1]}"
    driver = MavlinkDriver(MavlinkConfig(endpoint=endpoint), lambda: now_ns)
    driver.open()
    _, ours = theirs.recvfrom(500)
    good: list[bytes] = []
    began = time.perf_counter()
    while result.sent < count:
        now_ns += TICK_NS
        t_s = (now_ns - BEGIN_NS) * 1e-9
        good = pilot.frames(t_s, result.ticks % 10 == 0)
        batch = [(frame, True) for frame in good]
        if result.ticks >= 20:  # it knows where it is by then
            batch += [(spoil(draw, good), False) for _ in range(min(A_TICK, count - result.sent))]
        draw.shuffle(batch)
        for frame, is_good in batch:
            repaired = not is_good and lucky > 0 and draw.randrange(100_000) < lucky
            theirs.sendto(_with_checksum(pilot, frame) if repaired else frame, ours)
            result.lucky += repaired
            result.good_sent += is_good
            result.sent += not is_good
            result.unchanged += not is_good and frame in good
        reading = driver.read()
        driver.said()
        result.ticks += 1
        if result.ticks <= 20:
            continue
        if math.isfinite(reading.lat_deg):
            age_s = (now_ns - reading.stamp_ns) * 1e-9
            north = (reading.lat_deg - LAT) * METRES_A_DEGREE + reading.v_north_mps * age_s - NORTH_MPS * t_s
            east = (reading.lon_deg - LON) * METRES_A_DEGREE * math.cos(math.radians(LAT))
            result.worst_m = max(result.worst_m, math.hypot(north, east))
        else:
            result.unknown_ticks += 1
        result.foreign_authority += bool(reading.authority)
    counts: Counter[str] = driver.frames.counts
    result.taken, result.bad, result.others, result.junk = (counts[k] for k in ("taken", "bad", "others", "junk"))
    result.values_refused = driver.vehicle.counts.total()
    result.seconds = time.perf_counter() - began
    driver.close()
    theirs.close()
    return result


def _with_checksum(pilot: Autopilot, frame: bytes) -> bytes:
    """The frame with a checksum that is right, if it looks like one."""
    if len(frame) < 12 or frame[0] != 0xFD or frame[1] != len(frame) - 12:
        return frame
    known = pilot.m.mavlink_map.get(frame[7] | frame[8] << 8 | frame[9] << 16)
    if known is None:
        return frame
    crc = pilot.m.x25crc(bytearray(frame[1:-2]) + bytes((known.crc_extra,))).crc
    return frame[:-2] + crc.to_bytes(2, "little")


def main() -> None:
    """Attack, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--lucky", type=int, default=0, help="of 100,000, get a checksum that is right")
    given = parser.parse_args()
    result = attack(given.count, given.seed, given.lucky)
    for name in result.__struct_fields__:
        print(f"{name:18} {getattr(result, name):g}")


if __name__ == "__main__":
    main()
