"""Random and mutated frames into the decoders of a LIDAR: no crash, no wrong range, counters right.

python -m tests.attack.scip --count 1000000
"""

from __future__ import annotations

import argparse
import math
import random
import sys
import time
from typing import Any

import msgspec
from msgspec import Struct

from fleet.agent.scans import EARLIER, Outlook, ScanParams
from fleet.agent.step import Nav
from fleet.agent.traffic import Traffic
from fleet.drivers.lidar import scip
from fleet.drivers.lidar.scip import Decoder, Measurement, Model, Request
from fleet.sensing.scan import Scan, packed, problem, unpacked
from fleet.sim.scanner.speech import measurement_bytes
from fleet.wire.codec import Refused
from fleet.wire.messages import MAJOR
from fleet.wire.scans import PublishedScan, decode_scan, encode

MODEL = Model("UST-20LX", 20, 60_000, 1440, 0, 1080, 540, 2400)
REQUESTS = (Request("MD", 500, 580), Request("MS", 500, 580), Request("ME", 520, 560), Request("GD", 500, 580))
NOW_NS = 1_700_000_000_000_000_000
STILL: Nav[float] = Nav(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
EMPTY = packed([math.nan] * 81)
STEP = math.radians(0.25)
ONE_LINE = 1.0 / 64.0  # six bits let so many wrong lines pass


class Result(Struct):
    """What the decoders made of it."""

    frames: int = 0
    counted: int = 0
    crashes: int = 0
    good_heard: int = 0
    good_refused: int = 0  # undisturbed, and not believed
    refused: int = 0
    wrong_bit: int = 0  # frames with one wrong bit,
    wrong_bit_passed: int = 0  # of which a range or the time was believed
    wrong_cut: int = 0  # frames with bytes or lines lost, doubled or added,
    wrong_cut_passed: int = 0
    wrong_line: int = 0  # frames with several characters of one line wrong, each of the code,
    wrong_line_passed: int = 0  # six bits of a sum let one in 64 of them pass
    wrong_shown: int = 0  # of which a scan of empty water shows a thing, were it the only scan
    wrong_things: int = 0  # things that went on to keeping clear, with sound scans of the same water before
    wrong_vessels: int = 0  # of which vessels were made
    worst_things: int = 0  # the same, had every scan of the water been one of the wrong ones, ten a second,
    worst_vessels: int = 0
    published: int = 0
    published_refused: int = 0
    published_impossible: int = 0  # believed, and cannot be


def _ranges(sent: list[int], request: Request) -> list[int]:
    most = min(MODEL.most_mm, scip.BEYOND_MM[scip.CHARACTERS[request.command]])
    return [one if MODEL.least_mm <= one <= most else -1 for one in sent]


def _same(said: Measurement, sent: list[int], ms: int, request: Request) -> bool:
    heard = [-1 if math.isnan(one) else round(one * 1e3) for one in unpacked(said.ranges)]
    return said.ms == ms and heard == _ranges(sent, request)


def _cut(frame: bytes, rng: random.Random) -> bytes:
    """Bytes or lines lost, doubled or added."""
    wrong = bytearray(frame)
    kind = rng.randrange(5)
    at = rng.randrange(len(wrong) - 2)
    if kind == 0:
        del wrong[at : at + rng.randint(1, 9)]
    elif kind == 1:
        wrong[at:at] = bytes(rng.randrange(0x30, 0x70) for _ in range(rng.randint(1, 9)))
    elif kind == 2:
        lines = bytes(wrong).split(b"\n")
        k = rng.randrange(1, len(lines) - 2)
        lines[k:k] = [lines[k]]
        wrong = bytearray(b"\n".join(lines))
    elif kind == 3:
        lines = bytes(wrong).split(b"\n")
        del lines[rng.randrange(1, len(lines) - 2)]
        wrong = bytearray(b"\n".join(lines))
    else:
        del wrong[at:]
    return bytes(wrong)


def _line(frame: bytes, rng: random.Random) -> bytes:
    """Two to six characters of one line are others."""
    lines = frame.split(b"\n")
    k = rng.randrange(2, len(lines) - 2)
    line = bytearray(lines[k])
    for _ in range(rng.randint(2, 6)):
        line[rng.randrange(len(line))] = rng.randrange(0x30, 0x70)
    lines[k] = bytes(line)
    return b"\n".join(lines)


def _noise(rng: random.Random) -> bytes:
    """Anything, some of it nearly a reply."""
    head = rng.choice([b"", b"MD", b"MD0500058001000\n99b\n", b"QT\n00P\n", b"PP\n00P\n", b"TM1\n00P\n"])
    return head + rng.randbytes(rng.randint(0, 200)).replace(b"\n\n", b"\n") + b"\n\n"


class Water:
    """Scans of a boat that lies still with nothing around it, ten a second, and what its agent makes of them."""

    def __init__(self) -> None:
        self.outlook, self.traffic = Outlook(ScanParams(every_s=0.05)), Traffic(lambda: (), NOW_NS)
        self.now_ns = NOW_NS
        self.vessels = 0

    def look(self, ranges: bytes) -> int:
        """How many things went on to keeping clear."""
        self.now_ns += 100_000_000
        scan, things = Scan(self.now_ns, 0.0, -STEP, ranges, 60.0), 0
        for sightings in self.outlook.sightings([scan], STILL, lambda x, y: (x * 1e-5, y * 1e-5), self.now_ns):
            things += len(sightings)
            self.traffic.hear(sightings, lambda lat, lon: (lat * 1e5, lon * 1e5), (), self.now_ns)
        self.vessels = max(self.vessels, len(self.traffic.targets(self.now_ns)))
        return things


class _Attack:
    def __init__(self, rng: random.Random) -> None:
        self.rng, self.result = rng, Result()
        self.decoders = {request: Decoder() for request in REQUESTS}
        for request, decoder in self.decoders.items():
            decoder.expect(request, MODEL)
        self.water, self.worst = Water(), Water()

    def scip(self) -> None:
        """One frame of a scanner."""
        rng, result = self.rng, self.result
        request = rng.choice(REQUESTS)
        decoder = self.decoders[request]
        most = 4095 if request.command == "MS" else 70_000
        kind = rng.choice(("good", "bit", "cut", "line", "noise"))
        sent = [0 if kind == "line" else rng.randrange(most + 1) for _ in range(request.values)]
        ms = rng.randrange(scip.TICKS)
        frame = measurement_bytes(request, ms, sent, rng.randrange(100))
        if kind == "bit":
            k = rng.randrange(8 * (len(frame) - 2))
            frame = frame[: k // 8] + bytes([frame[k // 8] ^ 1 << k % 8]) + frame[k // 8 + 1 :]
        elif kind == "cut":
            frame = _cut(frame, rng)
        elif kind == "line":
            frame = _line(frame, rng)
        elif kind == "noise":
            frame = _noise(rng)
        before = _blocks(decoder)
        try:
            heard = decoder.feed(frame + b"\n\n")
        except Exception as error:  # noqa: BLE001 - whatever it is, it is counted
            result.crashes += 1
            print(f"{frame!r}: {error!r}", file=sys.stderr)
            return
        result.frames += 1
        blocks = len([one for one in (frame + b"\n\n").split(b"\n\n") if one.strip(b"\n")])
        result.counted += _blocks(decoder) - before == blocks
        measured = [one for one in heard if isinstance(one, Measurement)]
        right = [_same(one, sent, ms, request) for one in measured]
        if kind == "good":
            result.good_heard += right == [True]
            result.good_refused += right != [True]
        elif kind == "bit":
            result.wrong_bit += 1
            result.wrong_bit_passed += not all(right)
        elif kind == "cut":
            result.wrong_cut += 1
            result.wrong_cut_passed += not all(right)
        elif kind == "line":
            result.wrong_line += 1
            result.wrong_line_passed += not all(right)
            for one in measured:
                result.wrong_shown += Water().look(one.ranges) > 0
                for _ in range(EARLIER):
                    self.water.look(EMPTY[: len(one.ranges)])
                result.wrong_things += self.water.look(one.ranges)
                result.worst_things += self.worst.look(one.ranges)
            result.wrong_vessels = max(result.wrong_vessels, self.water.vessels)
            result.worst_vessels = max(result.worst_vessels, self.worst.vessels)

    def message(self) -> None:
        """One published scan."""
        rng, result = self.rng, self.result

        def strange(good: Any, *odd: Any) -> Any:
            return rng.choice(odd) if rng.random() < 0.1 else good

        said = PublishedScan(
            strange(MAJOR, 2, 0),
            strange(NOW_NS - rng.randrange(10**9), 0, NOW_NS + 10**12, -1, 2**62),
            strange(rng.uniform(-6.0, 6.0), math.inf, math.nan, 99.0),
            strange(rng.choice((0.004, -0.01)), 0.0, math.nan, 1e300, 7.0),
            strange(packed(rng.uniform(-1.0, 90.0) for _ in range(rng.randint(1, 90))), rng.randbytes(43), b""),
            strange(rng.uniform(0.0, 1.0), -1.0, math.nan),
            strange(rng.uniform(5.0, 90.0), 0.0, math.inf, -5.0),
            strange(1e-5, 0.0, -1.0, math.nan, 10.0),
        )
        payload = encode(said)
        if rng.random() < 0.5:
            wrong = bytearray(payload)
            for _ in range(rng.randint(1, 6)):
                wrong[rng.randrange(len(wrong))] = rng.randrange(256)
            payload = bytes(wrong[: rng.randint(1, len(wrong))] if rng.random() < 0.3 else wrong)
        elif rng.random() < 0.2:
            payload = rng.randbytes(rng.randint(0, 100))
        result.published += 1
        try:
            scan = decode_scan(payload, NOW_NS)
        except Refused:
            result.published_refused += 1
            return
        except Exception as error:  # noqa: BLE001 - as above
            result.crashes += 1
            print(f"{payload!r}: {error!r}", file=sys.stderr)
            return
        told = [one for one in unpacked(scan.ranges) if not math.isnan(one)]
        possible = problem(scan) == "" and all(0.0 < one <= scan.range_max_m * 1.0001 for one in told)
        result.published_impossible += not (possible and abs(NOW_NS - scan.stamp_ns) < 2 * 10**9)


def _blocks(decoder: Decoder) -> int:
    counts = decoder.counts
    return counts.scans + counts.replies + counts.refused


def attack(count: int, rng: random.Random) -> Result:
    """So many frames, nine in ten of a scanner, the others published."""
    one = _Attack(rng)
    while one.result.frames + one.result.published + one.result.crashes < count:
        one.message() if rng.random() < 0.1 else one.scip()
    one.result.refused = sum(decoder.counts.refused for decoder in one.decoders.values())
    return one.result


def held(result: Result) -> bool:
    """Whether all is as it should be; of lines wrong in several places no more pass than six bits let."""
    fair = result.wrong_line * ONE_LINE
    return (
        result.crashes == 0
        and result.counted == result.frames
        and result.good_refused == 0
        and result.wrong_bit_passed == 0
        and result.wrong_cut_passed <= fair
        and result.wrong_line_passed <= fair + 4.0 * math.sqrt(fair)
        and result.wrong_things == 0
        and result.worst_things <= result.wrong_line_passed
        and result.wrong_vessels == 0
        and result.published_impossible == 0
    )


def main() -> int:
    """Exit code 0 when it held."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    began = time.process_time()
    result = attack(options.count, random.Random(options.seed))
    for name, value in msgspec.structs.asdict(result).items():
        print(f"{name:24} {value}")
    print(f"{time.process_time() - began:.0f} s of CPU")
    return int(not held(result))


if __name__ == "__main__":
    sys.exit(main())
