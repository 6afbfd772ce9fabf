"""Fifty boats that only speak, in the publication slots of agents: states ten times a second, status once a second.

`python -m bench.gcs_process ENDPOINT BOATS`; ends with its standard input.
"""

from __future__ import annotations

import sys
import threading
import time

import zenoh
from msgspec import structs

from bench.link_process import FLEET
from bench.scenes import boat_state
from fleet.agent.config import AgentConfig
from fleet.agent.process import end_with_parent
from fleet.wire import keys
from fleet.wire.codec import encode
from fleet.wire.link import LinkConfig
from fleet.wire.messages import MAJOR, BoatStatus
from fleet.wire.zenoh_link import session_config

PERIOD_S = 0.1
SLOTS = AgentConfig().slots
STATUSES = 10  # periods between two of one boat


def status(boat: str) -> BoatStatus:
    """As a boat in formation says it."""
    words = ("0.1.0", "follow", (), "", "", "gcs")
    counts = (1.0, 80.0, 49, 100, 0, 0.0, 100, 0, 0, 0)
    return BoatStatus(MAJOR, boat, 1, 1, *words, 20.0, *counts, "", "", "unicycle")


def main(endpoint: str, boats: int) -> None:
    """Speak until told to end."""
    stop = threading.Event()
    end_with_parent(stop)
    names = [f"b{i + 1}" for i in range(boats)]
    with zenoh.open(session_config("client", LinkConfig(topology="hub", connect=(endpoint,)))) as session:
        tokens = [session.liveliness().declare_token(keys.key(FLEET, name, keys.ALIVE)) for name in names]
        states = [
            session.declare_publisher(
                keys.key(FLEET, name, keys.STATE),
                priority=zenoh.Priority.DATA_HIGH,
                congestion_control=zenoh.CongestionControl.DROP,
                reliability=zenoh.Reliability.BEST_EFFORT,
            )
            for name in names
        ]
        statuses = [session.declare_publisher(keys.key(FLEET, name, keys.STATUS)) for name in names]
        said = [boat_state(name) for name in names]
        told = [encode(status(name)) for name in names]
        print("ready", flush=True)
        seq, due_s = 0, time.monotonic()
        while not stop.is_set():
            seq += 1
            for slot in range(SLOTS):
                due_s += PERIOD_S / SLOTS
                time.sleep(max(0.0, due_s - time.monotonic()))
                stamp_ns = time.time_ns()
                for i in range(slot, boats, SLOTS):
                    states[i].put(encode(structs.replace(said[i], seq=seq, stamp_ns=stamp_ns, epoch=1, mission_id="")))
                    if (seq + i) % STATUSES == 0:
                        statuses[i].put(told[i])
        for token in tokens:
            token.undeclare()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
