"""A simulated laser scanner on a boat of the world: a TCP server on loopback, as a real one is on its own network."""

from __future__ import annotations

import contextlib
import socket
from typing import Any

from fleet.sim.scanner.cast import cast
from fleet.sim.scanner.responder import MODEL, Responder
from fleet.sim.world import SENSE_S, World

LARGEST = 4096
MOST_UNSENT = 1 << 20
TURNS_A_SENSE = SENSE_S / MODEL.turn_s


class ScannerDevice:
    """One boat's scanner; `keys` is its table in `[[driver.sensors]]` of the agent."""

    def __init__(self, world: World, name: str) -> None:
        import numpy  # noqa: F401 - before time runs

        self._world, self._name = world, name
        self._responder = Responder()
        self._started_ns = world.now_ns
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.setblocking(False)
        self._client: socket.socket | None = None
        self._unsent = b""
        self._turns = 0.0
        port = self._server.getsockname()[1]
        self.keys: list[dict[str, Any]] = [{"kind": "lidar", "endpoint": f"tcp:127.0.0.1:{port}"}]

    def exchange(self) -> None:
        """20 times a second: hear and answer; send a turn that is complete."""
        if self._world.ships[self._name].lidar_down:
            self._drop()
            self._started_ns = self._world.now_ns
            return
        self._accept()
        if self._client is None:
            return
        self._hear(self._client)
        self._turns += TURNS_A_SENSE
        if self._turns >= 1.0 - 1e-9:
            self._turns -= 1.0
            if self._responder.laser:
                began_ns, distances = cast(self._world, self._name)
                self._unsent += self._responder.turned(self._ms(began_ns), distances)
        self._speak()

    def _ms(self, at_ns: int) -> int:
        return (at_ns - self._started_ns) // 1_000_000

    def _accept(self) -> None:
        with contextlib.suppress(BlockingIOError):
            client, _ = self._server.accept()
            client.setblocking(False)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._drop()
            self._client = client

    def _hear(self, client: socket.socket) -> None:
        try:
            chunk = client.recv(LARGEST)
        except BlockingIOError:
            return
        except OSError:
            chunk = b""
        if not chunk:
            self._drop()
            return
        self._unsent += self._responder.hear(chunk, self._ms(self._world.now_ns))

    def _speak(self) -> None:
        if self._client is None or not self._unsent:
            return
        try:
            self._unsent = self._unsent[self._client.send(self._unsent) :]
        except BlockingIOError:
            if len(self._unsent) > MOST_UNSENT:  # nobody reads
                self._drop()
        except OSError:
            self._drop()

    def _drop(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client, self._unsent = None, b""
        self._responder.reset()

    def close(self) -> None:
        """Free the port."""
        self._drop()
        self._server.close()
