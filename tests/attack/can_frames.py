"""Random and mutated CAN frames into the decoder: no crash, no wrong position, counters right.

python -m tests.attack.can_frames --count 1000000
"""

from __future__ import annotations

import argparse
import random
import sys
import time

from msgspec import Struct

from fleet.drivers.can.decoder import Decoder
from fleet.drivers.can.frames import FIX_3D, Battery, Frame, Frames, Navigation, Status

IDENTIFIERS = (256, 257, 512, 528, 529, 530, 544)


class Result(Struct):
    """What the decoder made of it."""

    frames: int = 0
    counted: int = 0
    crashes: int = 0
    wrong_positions: int = 0  # believed, and not one that was sent whole
    good_heard: int = 0
    good_refused: int = 0  # a whole set, undisturbed, not believed
    lies: int = 0  # single frames believed though nobody sent them so
    refused: int = 0


def _truth(k: int, rng: random.Random) -> Navigation:
    return Navigation(
        k & 255, FIX_3D, True, rng.uniform(44.0, 45.0), rng.uniform(8.0, 9.0), rng.uniform(0.0, 6.28),
        rng.uniform(-0.4, 0.4), rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), 0.02,
    )  # fmt: skip


def _mutated(frame: Frame, rng: random.Random) -> Frame:
    """One to eight flipped bits, bytes lost or added, other bytes, or another identifier."""
    identifier, payload = frame
    wrong = bytearray(payload)
    kind = rng.randrange(5)
    if kind == 0:
        for _ in range(rng.randint(1, 8)):
            bit = rng.randrange(8 * len(wrong))
            wrong[bit // 8] ^= 1 << bit % 8
    elif kind == 1:
        del wrong[rng.randrange(len(wrong)) :]
    elif kind == 2:
        wrong += rng.randbytes(rng.randint(1, 56))
    elif kind == 3:
        wrong = bytearray(rng.randbytes(len(wrong)))
    else:
        identifier = rng.choice(IDENTIFIERS)
    return identifier, bytes(wrong)


def attack(count: int, rng: random.Random) -> Result:
    """So many frames: whole sets, sets of which one frame is mutated, and noise."""
    frames, result = Frames(), Result()
    decoder = Decoder(frames, "agent")
    k = 0
    while result.frames < count:
        k += 1
        truth = _truth(k, rng)
        salvo: list[Frame] = [*frames.navigation(truth)]
        sent = set(salvo)
        kind = rng.randrange(4)
        if kind == 1:
            i = rng.randrange(3)
            salvo[i] = _mutated(salvo[i], rng)
        elif kind == 2:
            random_id = rng.choice((*IDENTIFIERS, rng.randrange(2048)))
            salvo = [(random_id, rng.randbytes(rng.randint(0, 8))) for _ in range(3)]
        elif kind == 3:
            single = frames.status(Status(k & 255, k % 5, False, True)) if k % 2 else frames.battery(
                Battery(k & 255, float(k % 101), 12.0, 1.0)
            )  # fmt: skip
            salvo, sent = [_mutated(single, rng)], {single}
        whole, heard = kind == 0, False
        for identifier, payload in salvo[: count - result.frames]:
            result.frames += 1
            try:
                said = decoder.take(identifier, payload)
            except Exception as error:  # noqa: BLE001 - whatever it is, it is counted
                result.crashes += 1
                print(f"{identifier:#x} {payload.hex()}: {error!r}", file=sys.stderr)
                continue
            if isinstance(said, Navigation):
                heard = True
                near = abs(said.lat_deg - truth.lat_deg) < 1e-7 and abs(said.lon_deg - truth.lon_deg) < 1e-7
                result.wrong_positions += not near
            elif said is not None:
                result.lies += (identifier, payload) not in sent
        result.good_heard += whole and heard
        result.good_refused += whole and not heard and result.frames < count
    counts = decoder.counts
    result.refused = counts.refused
    result.counted = counts.accepted + counts.waiting + counts.foreign + counts.refused
    return result


def main() -> int:
    """Exit code 0 when nothing crashed and no wrong position was believed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    began = time.process_time()
    result = attack(options.count, random.Random(options.seed))
    print(result, f"{time.process_time() - began:.0f} s of CPU")
    return int(result.crashes > 0 or result.wrong_positions > 0 or result.counted != result.frames)


if __name__ == "__main__":
    sys.exit(main())
