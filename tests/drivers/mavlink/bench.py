"""One boat on a bench: the driver and the simulated autopilot over real UDP sockets, a hull, and a counter for a clock.

    bench = Bench()
    bench.launch()
    bench.run(5.0, drive=(1.0, 0.0))

A tick is a tenth of a second. Datagrams on loopback are there when `sendto` returns: nothing waits, nothing sleeps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from msgspec import structs

from fleet.drivers.mavlink.config import MavlinkConfig
from fleet.drivers.mavlink.driver import MavlinkDriver
from fleet.drivers.mavlink.words import dialect, mode_name
from fleet.drivers.seam import Reading
from fleet.geo import Datum, plane_of
from fleet.guidance import Limits
from fleet.hulls import CALM, HULLS, STEP_S, HullState
from fleet.sim.autopilot.hull import Senses, Thrust
from fleet.sim.autopilot.port import Port
from fleet.sim.autopilot.rover import Rover

TICK_NS, STEP_NS, STEPS = 100_000_000, 20_000_000, 5
BEGIN_NS = 1_700_000_000_000_000_000
RUNNING_S = 100.0
Drive = tuple[float, float] | None
NOTHING = Reading(stamp_ns=0)


class Bench:
    """A boat at sea, its autopilot, and the driver of its agent."""

    def __init__(
        self,
        *,
        hull: str = "unicycle",
        running_s: float = RUNNING_S,
        arm: str = "operator",
        key: bytes = b"",
        **config: Any,
    ) -> None:
        self.mavlink = dialect()
        self.now_ns = BEGIN_NS
        self.plane = plane_of(Datum(44.38, 8.93))
        self.hull, self.limits = HULLS[hull], Limits()
        self.state: HullState[float] = self.hull.start(10.0, 20.0, 0.5, 0.0)
        self.fix = True
        self.thrust = Thrust()
        self.rover = Rover(self.mavlink, self.now_ns, self.senses(), running_s=running_s)
        self.port = Port(self.mavlink, self.rover, key)
        given = {"endpoint": f"udp:127.0.0.1:{self.port.number}", "arm": arm, **config}
        self.config = MavlinkConfig(**given)
        self.driver = self.new_driver()
        self.reading = NOTHING
        self.refused = ""  # what the last `write` said
        self.heard: list[str] = []  # texts of the autopilot
        self.driver_alive = True
        self.look: Callable[[], None] = lambda: None

    def new_driver(self) -> MavlinkDriver:
        """Another process's driver."""
        driver = MavlinkDriver(self.config, lambda: self.now_ns)
        driver.open()
        return driver

    def senses(self) -> Senses:
        """What the hull does."""
        s = self.state
        lat, lon = self.plane.to_geographic(s.x, s.y)
        vx, vy = self.hull.velocity(s, CALM)
        return Senses(lat, lon, s.psi, vx, vy, s.r, s.u, fix=self.fix)

    def sail(self) -> None:
        """A tenth of a second passes for hull and autopilot."""
        for _ in range(STEPS):
            self.now_ns += STEP_NS
            powered = 1.0 if self.thrust.powered else 0.0
            surge, rate = self.thrust.surge_mps, self.thrust.yaw_rate_radps
            self.state = self.hull.advance(self.state, surge, rate, CALM, self.limits, STEP_S, powered)
            self.port.hear()
            self.thrust = self.rover.step(self.now_ns, self.senses())
            self.port.speak()

    def tick(self, drive: Drive = None) -> None:
        """A tick of an agent that drives so, or wants no thrust."""
        self.sail()
        if self.driver_alive:
            self.reading = self.driver.read()
            if drive is not None:
                self.refused = self.driver.write(*drive)
            else:
                self.driver.neutral()
            self.heard += self.driver.said()
        self.look()

    def run(self, seconds: float, drive: Drive = None) -> None:
        """So many ticks."""
        for _ in range(round(seconds * 10)):
            self.tick(drive)

    def until(self, condition: Callable[[], bool], at_most_s: float, drive: Drive = None) -> float:
        """Tick until it holds; after how long."""
        began_ns = self.now_ns
        while not condition():
            assert (self.now_ns - began_ns) * 1e-9 < at_most_s, f"not within {at_most_s} s: {self}"
            self.tick(drive)
        return (self.now_ns - began_ns) * 1e-9

    def launch(self, drive: Drive = (0.0, 0.0), at_most_s: float = 20.0) -> float:
        """An operator says launch; until the boat can be driven."""
        self.run(2.0)
        self.driver.obeyed("launch")
        return self.until(lambda: self.rover.armed and not self.driver.write(0.0, 0.0), at_most_s, drive)

    @property
    def mode(self) -> str:
        """Of the autopilot."""
        return mode_name(self.rover.mode)

    @property
    def known(self) -> bool:
        """Whether the driver says where the boat is."""
        return math.isfinite(self.reading.lat_deg)

    def shift(self, **changes: Any) -> None:
        """The hull is somewhere else, or does something else."""
        self.state = structs.replace(self.state, **changes)

    def __repr__(self) -> str:
        return f"{self.mode}, armed {self.rover.armed}, u {self.state.u:.2f}, refused {self.refused!r}, {self.reading}"

    def close(self) -> None:
        """Free the ports."""
        self.driver.close()
        self.port.close()


@contextmanager
def on_a_bench(**more: Any) -> Iterator[Bench]:
    """A bench that is cleared away."""
    bench = Bench(**more)
    try:
        yield bench
    finally:
        bench.close()
