"""The world as a process: real agents' drivers talk to it over datagrams on loopback."""

from __future__ import annotations

import contextlib
import json
import socket
import sys
import threading
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from fleet.agent.clock import ClockSpec, SystemClock
from fleet.agent.process import end_on_signals, end_with_parent
from fleet.drivers.simulated import Sensed, Setpoint
from fleet.mission.load import decode
from fleet.mission.plan import build
from fleet.recording.topics import Truth
from fleet.sim.device import Device, DriverKind, device
from fleet.sim.scanner.cast import wanted
from fleet.sim.scanner.device import ScannerDevice
from fleet.sim.suite import SensorKind, Suite
from fleet.sim.world import SENSE_S, STEP_NS, STEPS_A_SENSE, World

LARGEST = 65000
TRUTH_EVERY = 2  # senses: 10 Hz
NEVER_NS = 1 << 62
WATCHDOG_WALL_S = 0.25  # a busy machine may delay a set-point so long, which at high warp is more than the watchdog
MOST_STEPS = 50  # caught up at once; a machine that stalls longer loses time in the open


class WorldSpec(Struct, frozen=True, kw_only=True):
    """What a world process is told when it starts."""

    mission_file: str  # encoded mission
    clock: ClockSpec
    seed: int = 0
    driver: DriverKind = "simulated"
    sensors: SensorKind = "simulated"
    waits: bool = False  # for a `Begin`


class Trouble(Struct, frozen=True, array_like=True, tag="trouble"):
    """Supervisor to world: something breaks, or is mended."""

    boat: str
    kind: str
    value: float = 0.0


class Watch(Struct, frozen=True, array_like=True, tag="watch"):
    """Supervisor to world: send the truth here."""


class Begin(Struct, frozen=True, array_like=True, tag="begin"):
    """Supervisor to world: from then on hulls move; a world that waits keeps them where they start until then."""

    at_ns: int


class TruthOfAll(Struct, frozen=True, array_like=True, tag="truth"):
    """World to supervisor, ten times a second."""

    truths: dict[str, Truth]
    late_steps: int
    traffic: dict[str, Truth] = {}


_decode = msgspec.msgpack.Decoder(Setpoint | Trouble | Watch | Begin).decode
_encode = msgspec.msgpack.Encoder().encode


class WorldProcess:
    """Keeps the world in time with the clock, and answers datagrams."""

    def __init__(self, spec: WorldSpec) -> None:
        mission = decode(Path(spec.mission_file).read_bytes())
        self._clock = SystemClock(spec.clock)
        self._world = World(build(mission), self._clock.now_ns(), spec.seed)
        self._world.watchdog_s = max(self._world.watchdog_s, WATCHDOG_WALL_S * spec.clock.warp)
        if spec.waits:
            self._world.begins_ns = NEVER_NS
        self._radio = mission.radio
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)
        self._agents: dict[str, tuple[str, int]] = {}
        self._devices: dict[str, Device] = {}
        for boat in self._world.ships:
            between = device(spec.driver, self._world, boat, spec.clock.warp)
            if between is not None:
                self._devices[boat] = between
        self._suites: dict[str, Suite] = {}
        if spec.sensors == "nmea":
            self._suites = {boat: Suite(mission.environment, spec.clock.warp) for boat in self._world.ships}
        self._scanners: dict[str, ScannerDevice] = {}
        if wanted(self._world):
            self._scanners = {boat: ScannerDevice(self._world, boat) for boat in self._world.ships}
        self._watchers: set[tuple[str, int]] = set()
        self._late_steps = 0
        self._blind = spec.driver == "can"  # a thruster controller without sensors of its own; an autopilot has some

    @property
    def port(self) -> int:
        """Where it listens."""
        port: int = self._socket.getsockname()[1]
        return port

    @property
    def drivers(self) -> dict[str, dict[str, Any]]:
        """By boat: keys of `[driver]` with which its agent reaches its sensors, and what is between it and the hull."""
        keys: dict[str, dict[str, Any]] = {boat: dict(between.keys) for boat, between in self._devices.items()}
        for sensors in (self._suites, self._scanners):
            for boat, one in sensors.items():
                mine = keys.setdefault(boat, {})
                mine["sensors"] = [*mine.get("sensors", ()), *one.keys]
        return keys

    def run(self, stop: threading.Event) -> None:
        """Until stopped."""
        senses = 0
        deadline_ns = self._world.now_ns
        while not stop.is_set():
            deadline_ns += int(SENSE_S * 1e9)
            self._clock.sleep_until(deadline_ns, stop)
            self._receive()
            behind = (self._clock.now_ns() - self._world.now_ns) // STEP_NS
            self._late_steps += max(0, behind - 2 * STEPS_A_SENSE)
            for _ in range(min(behind, MOST_STEPS)):
                self._world.step()
            senses += 1
            self._tell(senses % TRUTH_EVERY == 0)
            deadline_ns = max(deadline_ns, self._clock.now_ns() - int(SENSE_S * 1e9))

    def _receive(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while True:
                try:
                    payload, address = self._socket.recvfrom(LARGEST)
                except ConnectionRefusedError:
                    continue
                with contextlib.suppress(msgspec.DecodeError):
                    self._take(_decode(payload), address)

    def _take(self, message: Setpoint | Trouble | Watch | Begin, address: tuple[str, int]) -> None:
        if isinstance(message, Setpoint):
            if message.boat in self._world.ships:
                self._agents[message.boat] = address
                if message.boat not in self._devices:
                    self._world.command(message.boat, message.powered, message.surge_mps, message.yaw_rate_radps)
        elif isinstance(message, Watch):
            self._watchers.add(address)
        elif isinstance(message, Begin):
            self._world.begins_ns = message.at_ns
        elif message.boat in self._world.ships:
            self._world.trouble(message.boat, message.kind, message.value)
            if message.boat in self._devices:
                self._devices[message.boat].trouble(message.kind, message.value)

    def _tell(self, truth: bool) -> None:
        world, radio = self._world, self._radio
        for boat in world.ships:
            if boat not in self._agents and boat not in self._devices:
                continue
            reading = world.sense(boat)
            rest = self._suites[boat].tell(reading) if boat in self._suites else reading
            if boat in self._scanners:
                self._scanners[boat].exchange()
            if boat in self._devices:
                self._devices[boat].exchange(rest if self._blind else reading)
            reading = rest
            if boat in self._agents:
                sensed = Sensed(reading, radio.delay_s, radio.loss, world.ships[boat].radio_down)
                self._send(_encode(sensed), self._agents[boat])
        if truth and self._watchers:
            boats = {boat: world.truth(boat) for boat in world.ships}
            vessels = {vessel: world.vessel(vessel) for vessel in world.crafts}
            payload = _encode(TruthOfAll(boats, self._late_steps, vessels))
            for watcher in self._watchers:
                self._send(payload, watcher)

    def _send(self, payload: bytes, address: tuple[str, int]) -> None:
        with contextlib.suppress(BlockingIOError, ConnectionRefusedError):
            self._socket.sendto(payload, address)

    def close(self) -> None:
        """Free the ports."""
        for between in self._devices.values():
            between.close()
        for suite in self._suites.values():
            suite.close()
        for scanner in self._scanners.values():
            scanner.close()
        self._socket.close()


def main(spec_json: str) -> None:
    """Run a world; its port is the one line on stdout."""
    stop = threading.Event()
    end_on_signals(stop)
    process = WorldProcess(msgspec.json.decode(spec_json, type=WorldSpec))
    print(json.dumps({"port": process.port, "drivers": process.drivers}), flush=True)
    end_with_parent(stop)
    try:
        process.run(stop)
    finally:
        process.close()


if __name__ == "__main__":
    main(sys.argv[1])
