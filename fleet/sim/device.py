"""What may stand between a simulated hull and its agent: an autopilot, or a thruster controller. It lives in the world.

The agent then has the driver of that device, as on the water. Its link to the world stays for what is simulated beside
the boat: the weather of the radio, and sightings of other vessels.
"""

from __future__ import annotations

from typing import Any, Literal, Protocol

from fleet.drivers.seam import Reading
from fleet.sim.world import World

DriverKind = Literal["simulated", "can", "mavlink"]


class Device(Protocol):
    """One boat's device. It commands the hull through `World.command`, or puts a hull of its own into `Ship.hull`."""

    keys: dict[str, Any]
    """Keys of `[driver]` with which an agent reaches it."""

    def exchange(self, reading: Reading) -> None:
        """20 times a second: take what the agent sent, command the hull, send what the boat's sensors say."""

    def trouble(self, kind: str, value: float) -> None:
        """Something of its own breaks, or is mended; other kinds are passed over."""

    def close(self) -> None:
        """Disconnect."""


def must_have(kind: DriverKind) -> None:
    """ConfigError where the libraries of that kind of driver are not installed."""
    if kind == "can":
        from fleet.drivers.can.driver import must_have_libraries

        must_have_libraries()
    elif kind == "mavlink":
        from fleet.drivers.mavlink.words import dialect

        dialect()


def device(kind: DriverKind, world: World, boat: str, warp: float) -> Device | None:
    """A boat's device for that kind of driver, connected; None where the agent talks to the world itself."""
    if kind == "can":
        from fleet.sim.controller.device import CanDevice

        return CanDevice(world, boat, warp)
    if kind == "mavlink":
        from fleet.sim.autopilot.device import AutopilotDevice

        return AutopilotDevice(world, boat)
    return None
