"""From a boat's configuration to its driver with sensors beside it, and what such a driver can do besides steering."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Protocol, runtime_checkable

from fleet.agent.config import AgentConfig
from fleet.drivers.beside import Beside
from fleet.drivers.kinds import made_by_others
from fleet.drivers.seam import Driver
from fleet.drivers.sensors.equipped import Equipped
from fleet.drivers.sensors.kinds import equipped
from fleet.drivers.simulated import SimulatedDriver
from fleet.errors import ConfigError
from fleet.wire.bus import Bus, Heard


def driver_of(config: AgentConfig, now_ns: Callable[[], int]) -> tuple[Driver, SimulatedDriver | None]:
    """The driver that the configuration asks for, and a simulated boat's link to its world."""
    if config.driver.kind == "simulated":
        world = SimulatedDriver(config.boat, config.driver.world)
        return equipped(config.boat, world, config.driver.sensors, now_ns), world
    driver = equipped(config.boat, hardware(config, now_ns), config.driver.sensors, now_ns)
    if not config.driver.simulated:
        return driver, None
    world = SimulatedDriver(config.boat, config.driver.world)
    return Beside(driver, world), world


def hardware(config: AgentConfig, now_ns: Callable[[], int]) -> Driver:
    """The driver of real hardware, its library imported only now."""
    if config.driver.kind == "mavlink":
        from fleet.drivers.mavlink.driver import MavlinkDriver

        return MavlinkDriver(config.driver.mavlink, now_ns, simulated=config.driver.simulated)
    if config.driver.kind != "can":
        return made_by_others(config.driver.kind, config.boat, config.driver.options, now_ns)
    from fleet.drivers.can.driver import CanDriver

    return CanDriver(config.driver.can, now_ns, simulated=config.driver.simulated, warp=config.clock.warp)


@runtime_checkable
class Converses(Protocol):
    """A driver that waits for operators' words, and has words for them: one that talks to an autopilot."""

    def obeyed(self, kind: str) -> None:
        """A command of an operator was accepted."""

    def said(self) -> list[str]:
        """What the hardware said since the last call."""


@runtime_checkable
class Arms(Protocol):
    """A driver whose hardware is armed before it drives."""

    @property
    def armed(self) -> bool:
        """Whether it is, as the hardware says."""

    def disarm(self) -> None:
        """Ask for it, once; `armed` tells whether it was done."""


@runtime_checkable
class Subscribes(Protocol):
    """A sensor whose values somebody else on board publishes under the boat's own name."""

    key: str
    """Under which part of it."""

    def listen(self, poll: Callable[[], list[Heard]]) -> None:
        """From now on `poll` gives what was published."""


def subscribe(driver: Driver, bus: Bus) -> None:
    """Lets sensors hear what is published for them; before the bus is opened. ConfigError for two under one key."""
    keys_taken: set[str] = set()
    equipped_one = driver
    while isinstance(equipped_one, Beside | Equipped):
        for sensor in equipped_one.sensors if isinstance(equipped_one, Equipped) else ():
            if isinstance(sensor, Subscribes):
                if sensor.key in keys_taken:
                    raise ConfigError(f"driver.sensors: two listen to key {sensor.key!r}; expected another for each")
                keys_taken.add(sensor.key)
                bus.listen_own(sensor.key)
                sensor.listen(partial(bus.poll_own, sensor.key))
        equipped_one = equipped_one.hardware


def parts(driver: Driver) -> tuple[Driver, Equipped | None]:
    """The hardware's own driver, and what holds the sensors beside it, if there are any."""
    sensors = None
    while isinstance(driver, Beside | Equipped):
        sensors = driver if isinstance(driver, Equipped) else sensors
        driver = driver.hardware
    return driver, sensors
