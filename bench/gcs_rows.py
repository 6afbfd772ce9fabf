"""CPU of one ground-station bridge with fifty boats: states at 10 Hz in, every boat a MAVLink vehicle out."""

from __future__ import annotations

import contextlib
import select
import socket
import subprocess
import sys
import tempfile
import time

import msgspec

from bench.link_process import FLEET
from bench.procs import memory_mib, threads
from bench.table import Row, Table
from bench.timing import REFERENCE_US, calibration, timed
from fleet.drivers.mavlink.frames import Frames
from fleet.drivers.mavlink.words import dialect
from fleet.sim.processes import free_port
from fleet.wire.link import LinkConfig

GROUP = "a ground-station bridge, 50 boats at 10 Hz, one ground station"
BOATS = 50
BEATS_S, WARM_S = 1.0, 4.0


class Station:
    """A ground station that listens and beats."""

    def __init__(self) -> None:
        mavlink = dialect()
        self._mavlink, self._codec = mavlink, mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        self.datagrams: list[bytes] = []
        self._peer: tuple[str, int] | None = None
        self._beat_s = 0.0

    def listen(self, seconds: float) -> None:
        """Take in what arrives."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            select.select([self.socket], [], [], 0.1)
            with contextlib.suppress(BlockingIOError):
                while True:
                    payload, self._peer = self.socket.recvfrom(2048)
                    self.datagrams.append(payload)
            if self._peer is not None and time.monotonic() - self._beat_s >= BEATS_S:
                self._beat_s = time.monotonic()
                beat = self._mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
                self.socket.sendto(bytes(beat.pack(self._codec)), self._peer)


def gcs_rows(table: Table, quick: bool) -> None:
    """The bridge as a process of its own."""
    endpoint, station = f"tcp/127.0.0.1:{free_port()}", Station()
    children: list[subprocess.Popen[bytes]] = []

    def start(*argv: str) -> subprocess.Popen[bytes]:
        child = subprocess.Popen([sys.executable, "-m", *argv], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        children.append(child)
        assert child.stdout is not None
        if not child.stdout.readline():
            raise RuntimeError(f"{argv[0]} did not start")
        return child

    with tempfile.TemporaryDirectory() as folder:
        try:
            start("fleet.sim.hub_process", msgspec.json.encode(LinkConfig(topology="hub", listen=(endpoint,))).decode())
            start("bench.gcs_process", endpoint, str(BOATS))
            where = f"udp:127.0.0.1:{station.socket.getsockname()[1]}"
            options = ("--fleet", FLEET, "--connect", endpoint, "--endpoint", where, "--state-dir", folder)
            bridge = start("fleet.cli.main", "gcs", *options)
            station.listen(WARM_S)
            station.datagrams.clear()
            before, began = threads(bridge.pid), time.monotonic()
            station.listen(5.0 if quick else 20.0)
            wall_s, spent = time.monotonic() - began, threads(bridge.pid).since(before)
            scale = max(timed(calibration).us / REFERENCE_US, 1.0)
            resident, _ = memory_mib(bridge.pid)
        finally:
            for child in reversed(children):
                if child.stdin is not None:
                    child.stdin.close()
                child.terminate()
                child.wait(10)
            station.socket.close()
    frames = Frames(dialect())
    messages = [m for payload in station.datagrams for m in frames.datagram(payload)]
    seen = len({m.get_srcSystem() for m in messages if m.get_type() == "HEARTBEAT"})
    if seen != BOATS:
        raise RuntimeError(f"{seen} vehicles of {BOATS} were seen")
    share = 100.0 * spent.all * 1e-9 / wall_s
    note = f"loop {100e-9 * spent.loop / wall_s:.1f}, Zenoh {100e-9 * spent.zenoh / wall_s:.1f}, {resident:.0f} MiB; "
    note += f"{len(messages) / wall_s:.0f} messages/s out"
    table.add(Row(group=GROUP, name="CPU of the bridge", value=share, unit="% core", aim=10.0, scale=scale, note=note))
