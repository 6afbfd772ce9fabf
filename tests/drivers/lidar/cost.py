"""What a scanner costs: 1,081 beams, 40 turns a second, over TCP, as the agent's thread reads them.

python -m tests.drivers.lidar.cost
"""

from __future__ import annotations

import math
import multiprocessing
import socket
import time
from multiprocessing.connection import Connection

import numpy as np
from msgspec.structs import replace

from fleet.agent.scans import Outlook, ScanParams
from fleet.agent.step import Nav
from fleet.drivers.lidar.driver import Lidar
from fleet.drivers.lidar.scip import Decoder, Request
from fleet.drivers.sensors.config import SensorConfig
from fleet.sensing.clusters import clusters
from fleet.sensing.scan import Scan, packed
from fleet.sim.scanner.rays import Turn, ranges, vessel
from fleet.sim.scanner.responder import MODEL, Responder
from fleet.sim.scanner.speech import measurement_bytes

FAST = replace(MODEL, rpm=2400)
SECONDS = 20.0
BEARINGS = (FAST.front - np.arange(1081)) * (2.0 * math.pi / FAST.around)
NAV: Nav[float] = Nav(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.05, 0.5)


def scene() -> list[int]:
    """Three vessels and a bank [mm]."""
    bodies = [vessel(20.0, -8.0, 0.6, 0.0, 0.0, 8.0), vessel(40.0, 12.0, 1.5, 0.0, 0.0, 15.0)]
    bodies += [vessel(12.0, 9.0, 0.0, 0.0, 0.0, 3.0), vessel(0.0, -30.0, 0.0, 0.0, 0.0, 100.0)]
    found = ranges(Turn(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), BEARINGS, bodies, 60.0)
    return [round(one * 1e3) if one < 60.0 else 65533 for one in found.tolist()]


def scanner(port: Connection) -> None:
    """A scanner in a process of its own, until the connection ends."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port.send(server.getsockname()[1])
        client, _ = server.accept()
        client.settimeout(0.001)
        responder, distances, due = Responder(FAST), scene(), time.monotonic()
        try:
            while True:
                try:
                    chunk = client.recv(4096)
                    if not chunk:
                        return
                    client.sendall(responder.hear(chunk, round(time.monotonic() * 1e3)))
                except TimeoutError:
                    pass
                if time.monotonic() >= due:
                    due += 0.025
                    client.sendall(responder.turned(round(time.monotonic() * 1e3) - 19, distances))
        except OSError:
            return


def each() -> None:
    """Decoding and clustering, one call each."""
    request = Request("MD", 0, 1080)
    decoder = Decoder()
    decoder.expect(request, FAST)
    frame = measurement_bytes(request, 5, scene())
    scan = Scan(1, math.radians(135.0), -math.radians(0.25), packed(one * 1e-3 for one in scene()), 60.0)
    wet = np.random.default_rng(1).uniform(3.0, 30.0, 1081)
    rain = replace(scan, ranges=packed(wet.tolist()))
    for words, work in (
        ("decode a scan of 1,081 beams", lambda: decoder.feed(frame)),
        ("clusters of four things", lambda: clusters(scan)),
        ("clusters in rain: every beam meets a drop", lambda: clusters(rain)),
    ):
        times = []
        for _ in range(300):
            began = time.process_time()
            work()
            times.append(time.process_time() - began)
        print(f"{words}: {1e6 * sorted(times)[150]:.0f} us")


def running() -> None:
    """The sensor's thread and what the agent makes of its scans, ten ticks a second."""
    ours, theirs = multiprocessing.Pipe()
    child = multiprocessing.get_context("spawn").Process(target=scanner, args=(theirs,), daemon=True)
    child.start()
    config = SensorConfig(kind="lidar", endpoint=f"tcp:127.0.0.1:{ours.recv()}", options={"rate_hz": 40.0})
    lidar, outlook = Lidar(config, time.time_ns), Outlook(ScanParams())
    lidar.open()
    while not lidar.read(time.time_ns()).scans:
        time.sleep(0.05)
    began, cpu, scans = time.monotonic(), time.process_time(), 0
    while time.monotonic() - began < SECONDS:
        now_ns = time.time_ns()
        said = lidar.read(now_ns)
        scans += len(said.scans)
        for _ in outlook.sightings(said.scans, NAV, lambda x, y: (x * 1e-5, y * 1e-5), now_ns):
            pass
        time.sleep(0.1)
    wall = time.monotonic() - began
    print(f"{scans / wall:.1f} scans a second: {100.0 * (time.process_time() - cpu) / wall:.2f} % of a core")
    lidar.close()
    child.join(5.0)


if __name__ == "__main__":
    each()
    running()
