"""A simulated autopilot between a hull of the world and its agent."""

from __future__ import annotations

import math
from typing import Any

from fleet.drivers.mavlink.words import GUIDED, MANUAL, dialect
from fleet.drivers.seam import Reading
from fleet.sim.autopilot.hull import Senses
from fleet.sim.autopilot.port import Port
from fleet.sim.autopilot.rover import Rover
from fleet.sim.world import World

OWN_SYSID, MOST_SYSIDS = 254, 250
RUNNING_S = 120.0  # switched on so long before the simulation begins: it can be armed
LOITER_ELSE_HOLD = 6.0


class AutopilotDevice:
    """See `fleet.sim.device.Device`. It is set up as docs/drivers-mavlink.md says, and armed by the agent."""

    def __init__(self, world: World, boat: str) -> None:
        self._world, self._boat = world, boat
        mavlink = dialect()
        self._reading = Reading(stamp_ns=0)
        sysid = world.plan.boat(boat).number % MOST_SYSIDS + 1
        self.rover = Rover(mavlink, world.now_ns, self._senses(), sysid=sysid, running_s=RUNNING_S)
        self.rover.parameters |= {"MAV_GCS_SYSID": OWN_SYSID, "FS_GCS_ENABLE": 1.0, "FS_ACTION": LOITER_ELSE_HOLD}
        self._port = Port(mavlink, self.rover)
        endpoint = f"udp:127.0.0.1:{self._port.number}"
        talk = {"endpoint": endpoint, "sysid": sysid, "own_sysid": OWN_SYSID, "arm": "operator", "forward": "both"}
        self.keys: dict[str, Any] = {"mavlink": talk}

    def _senses(self) -> Senses:
        """The estimator fuses all sensors but the position's slow error; only GNSS can be lost."""
        ship, reading = self._world.ships[self._boat], self._reading
        s = ship.state
        fix = math.isfinite(reading.lat_deg) or not ship.gnss_down
        lat, lon = reading.lat_deg, reading.lon_deg
        if not math.isfinite(lat + lon):
            lat, lon = self._world.plan.plane.to_geographic(s.x, s.y)
        waits = self._world.now_ns <= self._world.begins_ns  # held where it starts, whatever speed it will have
        vx, vy = (0.0, 0.0) if waits else self._world.velocity(ship)
        error_m, percent = reading.position_error_m, ship.battery_percent
        return Senses(lat, lon, s.psi, vx, vy, s.r, s.u, fix, error_m, percent)

    def exchange(self, reading: Reading) -> None:
        """The autopilot hears, decides, commands the hull, and speaks."""
        self._reading = reading
        self._port.hear()
        thrust = self.rover.step(self._world.now_ns, self._senses())
        self._world.command(self._boat, thrust.powered, thrust.surge_mps, thrust.yaw_rate_radps)
        self._port.speak()

    def trouble(self, kind: str, value: float) -> None:  # noqa: ARG002 - none of them has a value
        """`pilot-takes`, `pilot-gives`: the transmitter's switch, to MANUAL and back; `autopilot-restarts`."""
        if kind == "pilot-takes":
            self.rover.pilot(MANUAL)
        elif kind == "pilot-gives":
            self.rover.pilot(GUIDED)
        elif kind == "autopilot-restarts":
            self.rover.reboot()

    def close(self) -> None:
        """Free the port."""
        self._port.close()
