"""The processes of a simulation: hub, world, one real agent a boat. All of them end, whatever happens.

Each child holds a pipe to this process and ends when it closes; `close` ends them in good order, and with SIGKILL those
that do not.
"""

from __future__ import annotations

import contextlib
import json
import select
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import IO, Any

import msgspec

from fleet.agent.clock import ClockSpec
from fleet.agent.config import AgentConfig, DriverConfig
from fleet.errors import FleetError
from fleet.sim.device import DriverKind
from fleet.sim.passes import HUB, WHERE, Transport
from fleet.sim.suite import SensorKind
from fleet.sim.world_process import WorldSpec
from fleet.wire.link import LinkConfig, Topology

START_S = 30.0
END_S = 5.0
LEASE_MS = 500  # all on one machine


def free_port() -> int:
    """A port that nobody uses just now."""
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class Processes:
    """What runs, by name: `hub`, `world`, and the boats."""

    def __init__(
        self,
        folder: Path,
        clock: ClockSpec,
        boats: tuple[str, ...],
        *,
        fleet: str,
        topology: Topology,
        seed: int,
        record: bool,
        hub_port: int = 0,
        control_hz: float = 10.0,
        driver: DriverKind = "simulated",
        credentials: Path | None = None,
        transport: Transport = "tls",
        sensors: SensorKind = "simulated",
    ) -> None:
        self.folder, self.clock, self.fleet, self.topology = folder, clock, fleet, topology
        self._boats, self._seed, self._record, self._hz = boats, seed, record, control_hz
        self._credentials = credentials  # folder with a folder for each station
        self._where = WHERE[transport] if credentials is not None else "tcp/127.0.0.1:{}"
        self._children: dict[str, subprocess.Popen[bytes]] = {}
        self._logs: list[IO[bytes]] = []
        self._pids: list[int] = []
        self._world_port = 0
        self._driver: DriverKind = driver
        self._sensors: SensorKind = sensors
        self._drivers: dict[str, dict[str, Any]] = {}  # keys of `[driver]`, by boat
        self._hub_port = hub_port or free_port()
        self._ports = {boat: free_port() for boat in boats} if topology == "routed" else {}
        if topology == "routed" and hub_port:
            self._ports[boats[0]] = hub_port
        (folder / "logs").mkdir(exist_ok=True)

    @property
    def connect(self) -> tuple[str, ...]:
        """Where an operator connects: the hub, or any boat."""
        ports = [self._hub_port] if self.topology == "hub" else [self._ports[boat] for boat in self._boats]
        return tuple(self._where.format(port) for port in ports)

    @property
    def world_address(self) -> tuple[str, int]:
        """Where the world listens."""
        return ("127.0.0.1", self._world_port)

    def _spawn(self, name: str, *argv: str, answers: bool = False) -> str:
        """Start a Python module; the first line it prints, if it answers."""
        self._forget_pipes(self._children.get(name))
        log = (self.folder / "logs" / f"{name}.log").open("ab")
        self._logs.append(log)
        child = subprocess.Popen(
            [sys.executable, "-m", *argv],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE if answers else log,
            stderr=log,
            start_new_session=True,
        )
        self._children[name] = child
        self._pids.append(child.pid)
        if not answers:
            return ""
        assert child.stdout is not None
        ready, _, _ = select.select([child.stdout], [], [], START_S)
        line = child.stdout.readline().decode() if ready else ""
        if not line:
            raise FleetError(f"the {name} did not start: see {self.folder / 'logs' / f'{name}.log'}")
        return line

    def start_hub(self) -> None:
        """Start the hub, unless boats are routers themselves."""
        if self.topology == "hub":
            link = LinkConfig(
                topology="hub", listen=self.connect, lease_ms=LEASE_MS, keep_alive=4, credentials=self._folder_of(HUB)
            )
            self._spawn("hub", "fleet.sim.hub_process", msgspec.json.encode(link).decode(), answers=True)

    def _folder_of(self, station: str) -> str:
        """Of its credentials; '' for none."""
        return str(self._credentials / station) if self._credentials is not None else ""

    def start_world(self, mission_file: Path, *, waits: bool = False) -> None:
        """Start the world; one that waits moves no hull before it is told to begin."""
        spec = WorldSpec(
            mission_file=str(mission_file),
            clock=self.clock,
            seed=self._seed,
            driver=self._driver,
            sensors=self._sensors,
            waits=waits,
        )
        line = self._spawn("world", "fleet.sim.world_process", msgspec.json.encode(spec).decode(), answers=True)
        answer = json.loads(line)
        self._world_port, self._drivers = int(answer["port"]), answer["drivers"]

    def start_agent(self, boat: str) -> None:
        """Start, or start again, a boat's agent."""
        config = AgentConfig(
            boat=boat,
            fleet=self.fleet,
            link=self._link(boat),
            driver=self._driver_config(boat),
            state_dir=str(self.folder / "state" / boat),
            record=str(self.folder / "boats" / f"{boat}.mcap") if self._record else "none",
            control_hz=self._hz,
            clock_error_ms=0.0,
            clock=self.clock,
            seed=self._seed,
        )
        self._spawn(boat, "fleet.agent", msgspec.json.encode(config).decode(), "--with-parent")

    def _driver_config(self, boat: str) -> DriverConfig:
        world = f"127.0.0.1:{self._world_port}"
        keys = {"kind": self._driver, "simulated": True, "world": world, **self._drivers.get(boat, {})}
        return msgspec.convert(keys, DriverConfig)

    def _link(self, boat: str) -> LinkConfig:
        if self.topology == "hub":
            return LinkConfig(
                topology="hub",
                connect=self.connect,
                lease_ms=LEASE_MS,
                keep_alive=4,
                credentials=self._folder_of(boat),
            )
        before = self._boats[: self._boats.index(boat)]
        after = self._boats[self._boats.index(boat) + 1 :]
        return LinkConfig(
            topology=self.topology,
            connect=tuple(self._where.format(self._ports[other]) for other in (*before, *after)),
            listen=(self._where.format(self._ports[boat]),),
            lease_ms=LEASE_MS,
            keep_alive=4,
            credentials=self._folder_of(boat),
        )

    @staticmethod
    def _forget_pipes(child: subprocess.Popen[bytes] | None) -> None:
        for pipe in (child.stdin, child.stdout) if child is not None else ():
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()

    # -- what may happen to them -----------------------------------------------------------------------------------
    @property
    def pids(self) -> list[int]:
        """Process ids of all that were started, those replaced by a new start too."""
        return list(self._pids)

    def pid(self, name: str) -> int:
        """Process id of `hub`, `world` or a boat."""
        return self._children[name].pid

    def signal(self, name: str, number: int) -> None:
        """Send a signal to a process that runs."""
        child = self._children.get(name)
        if child is not None and child.poll() is None:
            child.send_signal(number)
            if number == signal.SIGKILL:
                child.wait()

    def dead(self) -> list[str]:
        """Processes that have ended by themselves or were killed."""
        return [name for name, child in self._children.items() if child.poll() is not None]

    def close(self) -> None:
        """End all: agents first, so that they leave their boats in neutral."""
        order = [name for name in self._children if name not in ("hub", "world")] + ["world", "hub"]
        children = [self._children[name] for name in order if name in self._children]
        for child in children:
            if child.poll() is None:
                child.send_signal(signal.SIGCONT)
                child.send_signal(signal.SIGTERM)
        deadline = time.monotonic() + END_S
        for child in children:
            with contextlib.suppress(subprocess.TimeoutExpired):
                child.wait(max(0.05, deadline - time.monotonic()))
            if child.poll() is None:
                child.kill()
                child.wait()
            self._forget_pipes(child)
        for log in self._logs:
            log.close()
