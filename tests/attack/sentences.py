"""Random and mutated sentences into the readers of NMEA 0183, gpsd and AIS: nothing crashes, nothing wrong is believed.

python -m tests.attack.sentences --count 1000000        so many lines into each
"""

from __future__ import annotations

import argparse
import json
import math
import random
import sys
import time
from collections.abc import Callable, Iterator
from typing import Protocol

from msgspec import Struct

from fleet.drivers.ais.codec import position_report, static_report
from fleet.drivers.ais.decoder import Listener
from fleet.drivers.ais.options import AisOptions
from fleet.drivers.gpsd.receiver import GpsdOptions, GpsdReceiver
from fleet.drivers.nmea import encode
from fleet.drivers.nmea.codec import Unusable, checksum, framed, unframed
from fleet.drivers.nmea.receiver import NmeaOptions, Receiver

NOON_NS = 1_764_331_200_000_000_000
MS = 1_000_000
LAT, LON = 44.38, 8.93
PARTS_OF_COUNTS = ("fixes", "late", "messages abandoned")  # counted beside what came of each line


class Result(Struct):
    """What a reader made of it."""

    lines: int = 0
    counted: int = 0
    crashes: int = 0
    positions: int = 0  # believed
    wrong: int = 0  # of those, not said by a whole sentence
    whole: int = 0  # undisturbed sentences
    whole_believed: int = 0
    lucky: int = 0  # mutated sentences whose checksum fits all the same
    cpu_s: float = 0.0


class Reader(Protocol):
    """What is attacked."""

    counts: object

    def take(self, line: bytes, stamp_ns: int) -> None: ...


def mutated(line: bytes, rng: random.Random) -> bytes:
    """Bits flipped, bytes lost, doubled, swapped or added, fields emptied, two sentences run into each other."""
    wrong = bytearray(line)
    kind = rng.randrange(8)
    at = rng.randrange(len(wrong))
    if kind == 0:
        for _ in range(rng.randint(1, 8)):
            i = rng.randrange(len(wrong))
            wrong[i] ^= 1 << rng.randrange(8)
    elif kind == 1:
        del wrong[at:]
    elif kind == 2:
        del wrong[at : at + rng.randint(1, 6)]
    elif kind == 3:
        wrong[at:at] = rng.randbytes(rng.randint(1, 20))
    elif kind == 4:
        wrong[at:at] = wrong[rng.randrange(len(wrong)) :]
    elif kind == 5:
        other = rng.randrange(len(wrong))
        wrong[at], wrong[other] = wrong[other], wrong[at]
    elif kind == 6:
        return framed_anew(bytes(wrong), rng)
    else:
        wrong = bytearray(rng.randbytes(rng.randint(0, 120)))
    return bytes(wrong)


def framed_anew(line: bytes, rng: random.Random) -> bytes:
    """Fields emptied, exchanged or filled with rubbish, and the checksum made right: as a bad receiver would say it."""
    if line[:1] not in (b"$", b"!"):
        return line[::-1]
    fields = line[1:].split(b"*")[0].split(b",")
    for _ in range(rng.randint(1, 4)):
        i, j = rng.randrange(len(fields)), rng.randrange(len(fields))
        rubbish = rng.choice((b"", b"-", b"nan", b"1e9", b"99999", b"0", b"0000.000", b"A", b"W", b"\xb0", fields[j]))
        fields[i] = rubbish
    body = b",".join(fields)
    return line[:1] + body + b"*%02X" % checksum(body)


def honest(line: bytes, start: bytes = b"$") -> bool:
    """Whether a reader has no way to know that a sentence was disturbed."""
    try:
        unframed(line, start)
    except Unusable:
        return False
    return True


def nmea(count: int, rng: random.Random) -> Result:
    """A receiver of 10 Hz; every third line is disturbed, and now and then there is noise."""
    result, receiver = Result(), Receiver(NmeaOptions())
    said: dict[tuple[float, float], bool] = {}

    def place(line: bytes) -> None:
        from fleet.drivers.nmea.codec import decode

        try:
            value = decode(line)
        except Unusable:
            return
        if hasattr(value, "lat_deg"):
            said[value.lat_deg, value.lon_deg] = True

    def lines() -> Iterator[tuple[bytes, bool, int]]:
        k = 0
        while True:
            k += 1
            stamp_ns, arrival = NOON_NS + k * 100 * MS, 10**15 + k * 100 * MS
            lat, lon = LAT + 1e-6 * k, LON + 2e-6 * math.sin(0.01 * k)
            for one in (
                encode.gga(stamp_ns, lat, lon, rng.choice((1, 2, 4, 5)), rng.uniform(0.5, 2.0)),
                encode.rmc(stamp_ns, lat, lon, 1.0, 0.5),
                encode.hdt(rng.uniform(-3.0, 3.0)),
                encode.rot(rng.uniform(-0.4, 0.4)),
                framed(f"GPVTG,{rng.uniform(0, 360):.1f},T,,M,2.0,N,3.7,K,A"),
            ):
                disturbed = rng.random() < 0.4
                line = mutated(one.strip(), rng) if disturbed else one.strip()
                yield line, disturbed, arrival

    def look(now_ns: int) -> list[tuple[float, float]]:
        new = receiver.observed(now_ns)
        return [(new.lat_deg, new.lon_deg)] if new.fix_ns else []

    def true(at: tuple[float, float]) -> bool:
        return at in said

    return _attack(count, result, receiver, lines(), look, true, place, b"$")


def ais(count: int, rng: random.Random) -> Result:
    """Vessels of both classes; every third sentence is disturbed."""
    result, listener = Result(), Listener(AisOptions())
    said: set[tuple[str, float, float]] = set()
    alone = Listener(AisOptions())

    def place(line: bytes) -> None:
        alone.take(line, place.stamp_ns)  # type: ignore[attr-defined]
        for one in alone.heard():
            said.add((one.name, one.lat_deg, one.lon_deg))

    def lines() -> Iterator[tuple[bytes, bool, int]]:
        k = 0
        while True:
            k += 1
            arrival = 10**15 + k * 300 * MS
            mmsi = 247_000_000 + k % 40
            lat, lon = LAT + 1e-5 * k % 10.0, LON + rng.uniform(-0.1, 0.1)
            said_now = position_report(
                mmsi, lat, lon, 3.0, 1.0, rng.choice((0.3, math.nan)), accurate=True, second=k, class_a=k % 2 == 0
            )
            if k % 3 == 0:
                said_now += static_report(mmsi, "VESSEL", rng.uniform(5.0, 300.0), 10.0, class_a=k % 2 == 0)
            for one in said_now:
                disturbed = rng.random() < 0.4
                yield (mutated(one.strip(), rng) if disturbed else one.strip()), disturbed, arrival

    def look(now_ns: int) -> list[tuple[str, float, float]]:
        return [(one.name, one.lat_deg, one.lon_deg) for one in listener.heard()]

    return _attack(count, result, listener, lines(), look, lambda at: at in said, place, b"!")


def gpsd(count: int, rng: random.Random) -> Result:
    """Reports over TCP have no checksum: what is believed must be what JSON's reader of Python finds in the line."""
    result, receiver = Result(), GpsdReceiver(GpsdOptions())
    newest: list[tuple[float, float]] = []

    def place(line: bytes) -> None:
        try:
            report = json.loads(line)
            newest[:] = [(float(report["lat"]), float(report["lon"]))]
        except (ValueError, KeyError, TypeError, RecursionError):
            newest.clear()

    def lines() -> Iterator[tuple[bytes, bool, int]]:
        k = 0
        while True:
            k += 1
            at = f"2025-11-28T{12 + k // 36000 % 12:02d}:{k // 600 % 60:02d}:{k // 10 % 60:02d}.{k % 10}00Z"
            tpv = {"class": "TPV", "device": "/dev/ttyACM0", "mode": 3, "time": at, "lat": LAT + 1e-6 * (k % 432000),
                   "lon": LON, "epx": 3.0, "epy": 4.0, "track": 45.0, "speed": 1.1}  # fmt: skip
            att = {"class": "ATT", "heading": rng.uniform(0.0, 360.0), "rot": rng.uniform(-900.0, 900.0)}
            for report in (tpv, att, {"class": "SKY", "satellites": [{"PRN": 1, "ss": 40.0}]}):
                disturbed = rng.random() < 0.4
                one = json.dumps(report).encode()
                yield (mutated(one, rng) if disturbed else one), disturbed, 10**15 + k * 100 * MS

    def look(now_ns: int) -> list[tuple[float, float]]:
        new = receiver.observed(now_ns)
        return [(new.lat_deg, new.lon_deg)] if new.fix_ns else []

    return _attack(count, result, receiver, lines(), look, lambda at: at in newest, place, b"{")


def _attack(
    count: int,
    result: Result,
    reader: Reader,
    lines: Iterator[tuple[bytes, bool, int]],
    look: Callable[[int], list],  # type: ignore[type-arg]
    true: Callable[[tuple], bool],  # type: ignore[type-arg]
    place: Callable[[bytes], None],
    start: bytes,
) -> Result:
    """So many lines; `place` is told of each line that is whole as far as anybody can tell."""
    for line, disturbed, arrival_ns in lines:
        if result.lines >= count:
            break
        result.lines += 1
        whole = not disturbed or start == b"{" or honest(line, start)
        result.whole += not disturbed
        result.lucky += disturbed and start != b"{" and whole
        place.stamp_ns = arrival_ns  # type: ignore[attr-defined]
        if whole:
            place(line)
        began = time.process_time()
        try:
            reader.take(line, arrival_ns)
            found = look(arrival_ns)
        except Exception as error:  # noqa: BLE001 - whatever it is, it is counted
            result.crashes += 1
            print(f"{line!r}: {error!r}", file=sys.stderr)
            continue
        finally:
            result.cpu_s += time.process_time() - began
        result.positions += len(found)
        result.whole_believed += len(found) if not disturbed else 0
        for at in found:
            if not true(at):
                result.wrong += 1
                print(f"{line!r}: believed {at}", file=sys.stderr)
    counts: dict[str, int] = dict(reader.counts)  # type: ignore[call-overload]
    result.counted = sum(n for what, n in counts.items() if what not in PARTS_OF_COUNTS and ": " not in what)
    return result


ATTACKS = {"nmea": nmea, "gpsd": gpsd, "ais": ais}


def main() -> int:
    """Exit code 0 when nothing crashed, nothing wrong was believed, and every line was counted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=sorted(ATTACKS))
    options = parser.parse_args()
    bad = 0
    for name, attack in ATTACKS.items():
        if options.only in (None, name):
            result = attack(options.count, random.Random(options.seed))
            print(f"{name}: {result}", f"{1e6 * result.cpu_s / max(result.lines, 1):.1f} us of CPU a line", flush=True)
            bad += result.crashes + result.wrong + (result.counted != result.lines) + (result.whole_believed == 0)
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
