"""The receiving end of the link rows: notes when bare messages and states arrive, and answers with the times it took.

`python -m bench.link_process ENDPOINT`; ends with its standard input.
"""

from __future__ import annotations

import sys
import threading
import time

import msgspec
import zenoh

from fleet.agent.picture import Picture
from fleet.agent.process import end_with_parent
from fleet.geo import Datum, plane_of
from fleet.wire.link import LinkConfig
from fleet.wire.zenoh_bus import ZenohBus
from fleet.wire.zenoh_link import session_config

FLEET, SENDER, RECEIVER = "bench", "sender", "receiver"
BARE_KEY = "bench/bare"
LOOK_S = 20e-6


def main(endpoint: str) -> None:
    """Listen until told to end; one line on stdout when ready, one with the figures at the end."""
    stop = threading.Event()
    end_with_parent(stop)
    link = LinkConfig(topology="hub", connect=(endpoint,))
    bare: list[tuple[int, int]] = []  # (sent, received), monotonic

    def arrived(sample: zenoh.Sample) -> None:
        bare.append((int.from_bytes(sample.payload.to_bytes()[:8], "little"), time.monotonic_ns()))

    plane = plane_of(Datum(44.38, 8.93))
    picture = Picture(RECEIVER, plane.to_local, 10.0)
    bus = ZenohBus(FLEET, RECEIVER, link, time.monotonic_ns)
    with zenoh.open(session_config("client", link)) as session:
        subscriber = session.declare_subscriber(BARE_KEY, zenoh.handlers.Callback(arrived, indirect=False))
        while not bus.open():
            time.sleep(0.01)
        bus.watch(SENDER)
        print("ready", flush=True)
        states: list[tuple[int, int]] = []
        while not stop.is_set():
            for heard in bus.poll_states(16):
                state = picture.hear(heard)
                if state is not None:
                    states.append((state.stamp_ns, time.monotonic_ns()))
            time.sleep(LOOK_S)
        print(msgspec.json.encode({"bare": bare, "states": states}).decode(), flush=True)
        subscriber.undeclare()
        bus.close()


if __name__ == "__main__":
    main(sys.argv[1])
