"""A simulated boat's driver of real hardware, and beside it the link to its world: sightings, the radio's weather."""

from __future__ import annotations

from msgspec.structs import replace

from fleet.drivers.seam import Driver, Reading
from fleet.drivers.simulated import SimulatedDriver


class Beside:
    """See `fleet.drivers.seam.Driver`: the hardware's own, with what the world's sensors saw of others."""

    simulated = True

    def __init__(self, driver: Driver, world: SimulatedDriver) -> None:
        self._driver, self._world = driver, world

    @property
    def hardware(self) -> Driver:
        """The driver beside which the world is."""
        return self._driver

    def open(self) -> None:
        """Connect both."""
        self._driver.open()
        self._world.open()

    def read(self) -> Reading:
        """The hardware's reading, with sightings; the radio's weather is then in the world's `sensed`."""
        reading, sightings = self._driver.read(), self._world.read().sightings
        return replace(reading, sightings=(*reading.sightings, *sightings)) if sightings else reading

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command the boat."""
        return self._driver.write(surge_mps, yaw_rate_radps)

    def neutral(self) -> None:
        """No thrust."""
        self._driver.neutral()

    def close(self) -> None:
        """Leave the boat in neutral and disconnect both."""
        self._driver.close()
        self._world.close()
