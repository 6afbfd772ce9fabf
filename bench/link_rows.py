"""From the put of a state until it is in the picture of a peer, against a bare Zenoh message in the same run."""

from __future__ import annotations

import json
import subprocess
import sys
import time

import msgspec
import zenoh
from msgspec import structs

from bench.link_process import BARE_KEY, FLEET, SENDER
from bench.scenes import boat_state
from bench.table import Row, Table
from bench.timing import percentile
from fleet.sim.processes import free_port
from fleet.wire.codec import encode
from fleet.wire.link import LinkConfig
from fleet.wire.zenoh_bus import ZenohBus
from fleet.wire.zenoh_link import session_config

GROUP = "one way through the hub, two processes, wall time"
PACE_S = 0.005


def _spawn(*argv: str) -> subprocess.Popen[bytes]:
    child = subprocess.Popen([sys.executable, "-m", *argv], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert child.stdout is not None
    if not child.stdout.readline():
        raise RuntimeError(f"{argv[0]} did not start")
    return child


def link_rows(table: Table, quick: bool) -> None:
    """Bare message and state in turn, paced."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    hub = _spawn("fleet.sim.hub_process", msgspec.json.encode(LinkConfig(topology="hub", listen=(endpoint,))).decode())
    receiver = _spawn("bench.link_process", endpoint)
    try:
        _send(endpoint, 200 if quick else 1000)
        time.sleep(0.2)
        assert receiver.stdin is not None
        receiver.stdin.close()
        assert receiver.stdout is not None
        figures = json.loads(receiver.stdout.readline())
    finally:
        for child in (receiver, hub):
            if child.stdin is not None and not child.stdin.closed:
                child.stdin.close()
            child.wait(10)
    bare, states = ([(b - a) * 1e-3 for a, b in figures[key]] for key in ("bare", "states"))
    p50 = percentile(bare, 0.5)
    table.add(Row(group=GROUP, name="bare Zenoh message, 250 bytes, into a callback (p50)", value=p50, unit="us"))
    if len(states) < 0.9 * len(bare):
        raise RuntimeError(f"{len(states)} states came of {len(bare)}")
    mine = percentile(states, 0.5)
    note = f"p99 {percentile(states, 0.99):.0f} us (bare {percentile(bare, 0.99):.0f}); no wait for a tick in it"
    name = "state: encode, put, ring, decode, picture (p50)"
    table.add(Row(group=GROUP, name=name, value=mine, unit="us", ratio=mine / p50, over="bare message", note=note))


def _send(endpoint: str, times: int) -> None:
    link = LinkConfig(topology="hub", connect=(endpoint,))
    bus = ZenohBus(FLEET, SENDER, link, time.monotonic_ns)
    with zenoh.open(session_config("client", link)) as session:
        publisher = session.declare_publisher(
            BARE_KEY,
            priority=zenoh.Priority.DATA_HIGH,
            congestion_control=zenoh.CongestionControl.DROP,
            reliability=zenoh.Reliability.BEST_EFFORT,
        )
        while not bus.open():
            time.sleep(0.01)
        time.sleep(0.5)
        filling = bytes(242)
        state = structs.replace(boat_state(SENDER), epoch=time.monotonic_ns())
        for number in range(1, times + 1):
            time.sleep(PACE_S)
            publisher.put(time.monotonic_ns().to_bytes(8, "little") + filling)
            time.sleep(PACE_S)
            bus.put_state(encode(structs.replace(state, seq=number, stamp_ns=time.monotonic_ns())))
        bus.close()
