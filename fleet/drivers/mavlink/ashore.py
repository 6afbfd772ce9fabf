"""A person's tools talk to one autopilot: the agent's own driver, in real time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from fleet.drivers.mavlink.config import MavlinkConfig
from fleet.drivers.mavlink.driver import MavlinkDriver
from fleet.drivers.seam import Reading
from fleet.errors import FleetError

TICK_S = 0.05
ASK_AGAIN_S = 0.7
QUIET_S = 2.5  # an autopilot that told no more for so long does not have the others
AT_ONCE = 4  # parameters asked for in one tick: a telemetry radio has narrow buffers


class Ashore:
    """One autopilot, for as long as the tool runs."""

    def __init__(self, config: MavlinkConfig) -> None:
        self.driver = MavlinkDriver(config, time.time_ns)  # signatures want the date
        self.driver.open()
        self.reading = Reading(stamp_ns=0)
        self.heard: list[str] = []  # what the autopilot said

    def tick(self) -> None:
        """A twentieth of a second."""
        time.sleep(TICK_S)
        self.reading = self.driver.read()
        self.heard += self.driver.said()

    def wait(self, condition: Callable[[], bool], at_most_s: float) -> bool:
        """Tick until it holds; whether it does."""
        deadline = time.monotonic() + at_most_s
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.tick()
        return True

    def find(self, at_most_s: float) -> None:
        """Wait for the autopilot; FleetError when it does not speak."""
        if not self.wait(lambda: self.driver.vehicle.heard_ns > 0, at_most_s):
            raise FleetError(f"{self.reading.trouble or 'no autopilot'}, after {at_most_s:g} s")

    def ask(self, names: Iterable[str], at_most_s: float) -> dict[str, float]:
        """Parameters by name; those that the autopilot does not have are missing."""
        driver, wanted = self.driver, list(names)
        asked = dict.fromkeys(wanted, 0.0)
        began = told = time.monotonic()
        count = 0
        while (now := time.monotonic()) < min(began + at_most_s, told + QUIET_S):
            missing = [name for name in wanted if name not in driver.parameters]
            if len(missing) != count:
                count, told = len(missing), now
            if not missing:
                break
            for name in [name for name in missing if now - asked[name] > ASK_AGAIN_S][:AT_ONCE]:
                driver.link.send(driver.talk.ask_parameter(name))
                asked[name] = now
            self.tick()
        return {name: driver.parameters[name] for name in wanted if name in driver.parameters}

    def close(self) -> None:
        """Disconnect; a boat in GUIDED is left on station."""
        self.driver.close()
