"""Boats afloat in real time: real agent processes, a real hub, devices on real sockets, hulls in this process.

What `tests.proofs.dead_man` breaks, and looks at.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Literal

import msgspec
from msgspec import Struct

from fleet.agent.config import AgentConfig, DriverConfig
from fleet.mission.model import Lost, Mission
from fleet.mission.plan import build
from fleet.operator import Fleet
from fleet.sim.device import device
from fleet.sim.processes import free_port
from fleet.sim.world import World
from fleet.wire.link import LinkConfig
from tests.agent.harness import mission

Kind = Literal["mavlink", "can"]
FLEET = "afloat"
LEASE_MS = 2000  # as on the water
NEVER_NS = 1 << 62
DRIVES_MPS, DRIVES_N = 0.2, 1.0  # an autopilot that asks the hull for more, thrusters that push more: it is driven
APPLY_S = 2.0
READY_S, UNDER_WAY_S = 40.0, 30.0
STEADY_S = 3.0  # at speed, before anything happens
PIDFD_OPEN, PIDFD_GETFD = 434, 438  # x86-64 and arm64 alike


class Look(Struct, frozen=True):
    """One boat at one moment."""

    at_s: float  # monotonic
    drives: bool
    speed_mps: float


class Boat:
    """An agent's process, what it tells its service manager, and what its hull does."""

    def __init__(self, name: str, folder: Path, config: AgentConfig) -> None:
        self.name = name
        self.looks: list[Look] = []
        self.told: list[tuple[float, str]] = []  # when, and what it does and why
        self._manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._manager.bind(str(folder / f"{name}.notify"))
        self._manager.setblocking(False)
        environment = {**os.environ, "NOTIFY_SOCKET": str(folder / f"{name}.notify")}
        with (folder / f"{name}.log").open("wb") as log:
            argv = [sys.executable, "-m", "fleet.agent", msgspec.json.encode(config).decode()]
            self.process = subprocess.Popen(argv, env=environment, stderr=log, stdout=log)

    def hear(self) -> None:
        """What it told since the last call."""
        with contextlib.suppress(BlockingIOError):
            while True:
                for line in self._manager.recv(4096).decode().split("\n"):
                    if line.startswith("STATUS="):
                        self.told.append((time.monotonic(), line.removeprefix("STATUS=")))

    def close(self) -> None:
        """End it."""
        self.process.kill()
        self.process.wait()
        self._manager.close()


class Afloat:
    """Boats in column at 1 m/s under an operator's orders, on a line."""

    def __init__(self, kind: Kind, boats: int = 1, alone_for_s: float = 30.0) -> None:
        self.kind = kind
        self._place = tempfile.TemporaryDirectory(prefix="fleet-afloat-")
        folder = Path(self._place.name)
        self.plan: Mission = mission(boats, lost=Lost(alone_for_s=alone_for_s))
        self.world = World(build(self.plan), time.time_ns())
        self.world.begins_ns = NEVER_NS
        self.lock = threading.Lock()
        names = tuple(self.world.ships)
        self.devices: dict[str, Any] = {name: device(kind, self.world, name, 1.0) for name in names}
        port = free_port()
        self._connect = (f"tcp/127.0.0.1:{port}",)
        listens = LinkConfig(topology="hub", listen=self._connect, lease_ms=LEASE_MS)
        module = [sys.executable, "-m", "fleet.sim.hub_process", msgspec.json.encode(listens).decode()]
        self.hub = subprocess.Popen(module, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self.hub.stdout is not None
        assert self.hub.stdout.readline(), "no hub"
        self.boats = [Boat(name, folder, self._config(name, folder)) for name in names]
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="world")
        self._thread.start()
        self.fleet: Fleet | None = None

    def _config(self, name: str, folder: Path) -> AgentConfig:
        return AgentConfig(
            boat=name,
            fleet=FLEET,
            link=LinkConfig(topology="hub", connect=self._connect, lease_ms=LEASE_MS),
            driver=msgspec.convert({"kind": self.kind, **self.devices[name].keys}, DriverConfig),
            state_dir=str(folder / name),
            record="none",
            clock_error_ms=0.0,
        )

    def sail(self) -> None:
        """Launch, and wait until all are under way at 1 m/s."""
        names = [boat.name for boat in self.boats]
        self.fleet = Fleet(FLEET, connect=self._connect, operator="anna", timeout_s=5.0)
        self.fleet.__enter__()
        missing = self.fleet.wait_for(names, READY_S)
        assert not missing, f"not ready: {missing}"
        self.world.begins_ns = time.time_ns() + int(APPLY_S * 1e9)
        outcome = self.fleet.launch(self.plan, apply_in_s=APPLY_S)
        assert outcome.ok, outcome.lines()
        self.wait(lambda: all(self._steady(boat) for boat in self.boats), UNDER_WAY_S, "under way at 1 m/s")

    def _steady(self, boat: Boat) -> bool:
        now = time.monotonic()
        late = [look for look in boat.looks if look.at_s > now - STEADY_S]
        begun = boat.looks and boat.looks[0].at_s < now - STEADY_S - APPLY_S
        return bool(begun) and all(look.drives and abs(look.speed_mps - 1.0) < 0.15 for look in late)

    def wait(self, condition: Any, within_s: float, what: str) -> None:
        """Until it holds."""
        deadline = time.monotonic() + within_s
        while not condition():
            assert time.monotonic() < deadline, f"not within {within_s:g} s: {what}"
            time.sleep(0.02)

    # -- the water ---------------------------------------------------------------------------------------------------
    def _run(self) -> None:
        """20 ms at a time, in time with the clock; devices are served 25 times a second."""
        steps = 0
        began_ns, began = self.world.now_ns, time.monotonic_ns()
        while not self._stop.is_set():
            ahead = (self.world.now_ns - began_ns) - (time.monotonic_ns() - began)
            if ahead > 0:
                time.sleep(ahead * 1e-9)
            with self.lock:
                self.world.step()
                steps += 1
                if steps % 2 == 0:
                    for name, one in self.devices.items():
                        one.exchange(self.world.sense(name))
                if self.world.now_ns > self.world.begins_ns:
                    for boat in self.boats:
                        boat.looks.append(Look(time.monotonic(), self.drives(boat.name), self.speed(boat.name)))
            for boat in self.boats:
                boat.hear()

    def drives(self, name: str) -> bool:
        """Whether the hull is driven."""
        if self.kind == "can":
            t = self.devices[name].controller.thrusts
            return sum(map(abs, (t.rear_port, t.rear_starboard, t.side_port, t.side_starboard))) > DRIVES_N
        ship = self.world.ships[name]
        return bool(ship.powered) and ship.u_d > DRIVES_MPS

    def speed(self, name: str) -> float:
        """Over ground [m/s]."""
        vx, vy = self.world.velocity(self.world.ships[name])
        return float((vx * vx + vy * vy) ** 0.5)

    # -- what may happen ---------------------------------------------------------------------------------------------
    def signal(self, number: int) -> None:
        """To the first boat's agent."""
        self.boats[0].process.send_signal(number)

    def trouble(self, kind: str) -> None:
        """Of the first boat and its device."""
        name = self.boats[0].name
        with self.lock:
            self.world.trouble(name, kind)
            self.devices[name].trouble(kind, 0.0)

    def cut(self) -> None:
        """Nothing more gets through between the first boat's agent and its device."""
        one = self.devices[self.boats[0].name]
        with self.lock:
            if self.kind == "can":
                one.close()
            else:
                one._port.hear = one._port.speak = lambda: None

    def close_socket(self) -> None:
        """The sockets of the first boat's driver are shut under it, in its own process."""
        port = self._device_port()
        shut = [fd for fd in _udp_sockets(self.boats[0].process.pid) if _belongs(fd, port)]
        assert shut, "the driver's socket was not found"
        for one in shut:
            with contextlib.suppress(OSError), one:  # ENOTCONN, and shut all the same
                one.shutdown(socket.SHUT_RDWR)

    def _device_port(self) -> int:
        keys = self.devices[self.boats[0].name].keys
        if self.kind == "can":
            return int(keys["can"]["options"]["port"])
        return int(keys["mavlink"]["endpoint"].rpartition(":")[2])

    def close(self) -> None:
        """End all of it."""
        self._stop.set()
        self._thread.join()
        if self.fleet is not None:
            self.fleet.__exit__(None, None, None)
        for boat in self.boats:
            with contextlib.suppress(ProcessLookupError):
                boat.process.send_signal(signal.SIGCONT)
            boat.close()
        self.hub.kill()
        self.hub.wait()
        for pipe in (self.hub.stdin, self.hub.stdout):
            if pipe is not None:
                pipe.close()
        for one in self.devices.values():
            one.close()
        self._place.cleanup()


def _udp_sockets(pid: int) -> list[socket.socket]:
    """Another process's UDP sockets, as ours too (pidfd_getfd)."""
    call = ctypes.CDLL(None, use_errno=True).syscall
    process = call(PIDFD_OPEN, pid, 0)
    found = []
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):
            if not os.readlink(entry).startswith("socket:"):
                continue
            fd = call(PIDFD_GETFD, process, int(entry.name), 0)
            if fd < 0:
                raise OSError(ctypes.get_errno(), "pidfd_getfd")
            one = socket.socket(fileno=fd)
            if one.family == socket.AF_INET and one.type == socket.SOCK_DGRAM:
                found.append(one)
            else:
                one.close()
    os.close(process)
    return found


def _belongs(one: socket.socket, port: int) -> bool:
    """Whether a socket is bound to a port, or connected to it."""
    ours = one.getsockname()[1] == port
    try:
        return ours or one.getpeername()[1] == port
    except OSError:
        return ours
