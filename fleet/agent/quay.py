"""A person's hand on one boat: the driver and the sensors of its agent, in real time, without the agent."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from msgspec.structs import replace

from fleet.agent.config import AgentConfig
from fleet.agent.hardware import Arms, Converses, driver_of, parts
from fleet.agent.sensors import sensors_of
from fleet.drivers.seam import Driver, Informed, Reading
from fleet.errors import FleetError
from fleet.geo import Datum, Plane, plane_of
from fleet.sensing import fusion

TICK_S = 0.05
FRESH_S = 1.5  # what is older does not say how the boat moves now
NS = 1e-9


class Quay:
    """One boat, for as long as the tool runs."""

    def __init__(self, config: AgentConfig, makes: Callable[[AgentConfig, Callable[[], int]], Driver] | None = None):
        """Connects; ConfigError when the configuration cannot work."""
        made = makes or (lambda config, now_ns: driver_of(config, now_ns)[0])
        self.driver = made(config, time.time_ns)  # signatures and receivers want the date
        self.hardware, _ = parts(self.driver)
        self.converses = self.hardware if isinstance(self.hardware, Converses) else None
        self.arms = self.hardware if isinstance(self.hardware, Arms) else None
        self.reading = Reading(stamp_ns=0)
        self.heard: list[str] = []  # what the hardware said
        self.asked = (0.0, 0.0)
        self._plane: Plane | None = None
        self._fused = fusion.NOTHING
        self._read_ns = 0
        self.driver.open()

    @property
    def armed(self) -> bool:
        """Whether the hardware says that it is armed; False where nothing is."""
        return self.arms is not None and self.arms.armed

    # -- time passes -----------------------------------------------------------------------------------------------
    def tick(self) -> None:
        """A twentieth of a second."""
        time.sleep(TICK_S)
        now_ns = time.time_ns()
        reading = self.reading = self.driver.read()
        if reading.raw:
            dt = min((now_ns - self._read_ns) * NS, FRESH_S) if self._read_ns else TICK_S
            self._fused = fusion.fuse(self._fused, sensors_of(reading, self._to_local, now_ns), max(dt, 0.001))
        self._read_ns = now_ns
        self._inform(now_ns)
        self.heard += self.converses.said() if self.converses is not None else ()

    def wait(self, condition: Callable[[], bool], at_most_s: float) -> bool:
        """Tick until it holds; whether it does."""
        deadline = time.monotonic() + at_most_s
        while not condition():
            if time.monotonic() > deadline:
                return False
            self.tick()
        return True

    def find(self, at_most_s: float) -> None:
        """Wait until the hardware speaks; FleetError when it does not."""
        self.tick()
        if not self.wait(lambda: not self.reading.trouble, at_most_s):
            raise FleetError(f"{self.reading.trouble}, after {at_most_s:g} s")

    # -- how the boat moves ----------------------------------------------------------------------------------------
    @property
    def surge_mps(self) -> float:
        """Velocity over ground along the heading; NaN where it is not known. A course does not stand for a heading."""
        r, f = self.reading, self._fused
        if not r.raw:
            return _along(r.v_north_mps, r.v_east_mps, r.heading_rad) if self._fresh() else math.nan
        known = fusion.known(f) and f.no_fix <= FRESH_S and f.no_heading <= FRESH_S
        return _along(f.vx, f.vy, f.psi) if known else math.nan

    @property
    def yaw_rate_radps(self) -> float:
        """+ to starboard, from a gyro or else from headings; NaN where it is not known."""
        r, f = self.reading, self._fused
        if not r.raw:
            return r.yaw_rate_radps if self._fresh() else math.nan
        return f.r if min(f.no_rate, f.no_heading) <= FRESH_S else math.nan

    @property
    def heading_rad(self) -> float:
        """NaN where it is not known."""
        if not self.reading.raw:
            return self.reading.heading_rad
        return self._fused.psi if self._fused.no_heading <= FRESH_S else math.nan

    @property
    def place(self) -> tuple[float, float]:
        """Latitude and longitude [deg]; NaN where they are not known."""
        f = self._fused
        if not self.reading.raw or self._plane is None:
            return self.reading.lat_deg, self.reading.lon_deg
        return self._plane.to_geographic(f.x, f.y) if f.no_fix <= FRESH_S else (math.nan, math.nan)

    def _fresh(self) -> bool:
        return self.reading.stamp_ns > 0 and (time.time_ns() - self.reading.stamp_ns) * NS <= FRESH_S

    def _to_local(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        if self._plane is None:
            self._plane = plane_of(Datum(lat_deg, lon_deg))
        return self._plane.to_local(lat_deg, lon_deg)

    def _inform(self, now_ns: int) -> None:
        """Hardware that does not know how the boat moves is told it, as by an agent.

        What is not known and not asked for either is told as none: the loop then gives no thrust in that axis. So a
        boat with a compass alone can be turned at the quay.
        """
        if not isinstance(self.hardware, Informed):
            return
        surge, yaw_rate = self.surge_mps, self.yaw_rate_radps
        surge = 0.0 if math.isnan(surge) and self.asked[0] == 0.0 else surge
        yaw_rate = 0.0 if math.isnan(yaw_rate) and self.asked[1] == 0.0 else yaw_rate
        if math.isfinite(surge + yaw_rate):
            self.hardware.moves(now_ns, surge, yaw_rate)

    # -- commands --------------------------------------------------------------------------------------------------
    def permit(self) -> None:
        """What an operator's launch is to an agent: the hardware may be taken."""
        if self.converses is not None:
            self.converses.obeyed("launch")

    def drive(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command the boat; '' or why it could not be done."""
        return self.driver.write(surge_mps, yaw_rate_radps)

    def stop(self) -> None:
        """No thrust."""
        self.driver.neutral()

    def disarm(self, at_most_s: float) -> bool:
        """Disarm a boat that nobody else has; whether it is."""
        if self.arms is None or self.reading.authority:
            return not self.armed
        self.arms.disarm()
        return self.wait(lambda: not self.armed, at_most_s)

    def close(self) -> None:
        """Leave the boat in neutral, and disconnect."""
        self.driver.close()


def at_quay(config: AgentConfig, *, arm: bool) -> AgentConfig:
    """The boat's configuration for a tool on the quay: armed if the person at it says so, whatever the agent may."""
    if config.driver.kind != "mavlink":
        return config
    mavlink = replace(config.driver.mavlink, arm="operator" if arm else "never", forward="off")
    return replace(config, driver=replace(config.driver, mavlink=mavlink))


def _along(v_north_mps: float, v_east_mps: float, heading_rad: float) -> float:
    return v_north_mps * math.cos(heading_rad) + v_east_mps * math.sin(heading_rad)
