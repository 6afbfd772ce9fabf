"""The world: hulls, other vessels, water and wind, sensors, and the radio's weather. No networks, no clocks.

Hulls are advanced in steps of 20 ms. Every random number is a hash of (seed, boat, step, purpose).
"""

from __future__ import annotations

import math
from collections import deque

from msgspec import Struct, structs

from fleet.drivers.seam import Reading, Sighting
from fleet.guidance import Limits
from fleet.hulls import HULLS, STEP_S, Hull, HullState, Water
from fleet.mission.model import Environment
from fleet.mission.plan import Plan
from fleet.recording.topics import Truth
from fleet.sim import traffic
from fleet.wire.radio import number_of, uniform

LEEWAY = 0.03  # drift of a hull at rest, as a share of the wind's speed
WATCHDOG_S = 1.0  # without a set-point for so long, the thrusters stop
CORRELATION_S = 60.0  # of the slow part of the GNSS error
SENSE_S = 0.05
STEP_NS = int(STEP_S * 1e9)
STEPS_A_SENSE = round(SENSE_S / STEP_S)
MOST_SIGHTINGS = 256  # that wait for a boat whose agent does not read


class Ship(Struct):
    """One simulated boat."""

    name: str
    hull: Hull
    limits: Limits
    state: HullState[float]
    number: int
    powered: float = 0.0
    u_d: float = 0.0
    r_d: float = 0.0
    commanded_ns: int = 0
    battery_percent: float = 100.0
    gnss_down: bool = False
    compass_down: bool = False
    gyro_down: bool = False
    lidar_down: bool = False
    actuator_down: bool = False
    radio_down: bool = False
    error_n: float = 0.0  # slow part of the GNSS error [m]
    error_e: float = 0.0


class Craft(Struct):
    """One vessel that is not of the fleet."""

    script: traffic.Script
    motion: traffic.Motion
    reports: int  # so far


def noisy(environment: Environment) -> bool:
    """Whether velocity, heading and yaw rate are measured as real sensors do; then boats get them raw."""
    return environment.gnss_velocity_mps + environment.heading_noise_deg + environment.yaw_rate_noise_degps > 0.0


class World:
    """Truth, and what sensors make of it."""

    def __init__(self, plan: Plan, start_ns: int, seed: int = 0) -> None:
        self.plan, self.now_ns, self.seed = plan, start_ns, seed
        self.watchdog_s = WATCHDOG_S
        self.begins_ns = 0  # hulls do not move before
        self._steps = 0
        environment = plan.mission.environment
        toward = math.radians(environment.current_toward_deg)
        leeway = LEEWAY * environment.wind_mps
        downwind = math.radians(environment.wind_from_deg + 180.0)
        self.water: Water[float] = Water(
            environment.current_mps * math.cos(toward),
            environment.current_mps * math.sin(toward),
            leeway * math.cos(downwind),
            leeway * math.sin(downwind),
        )
        self.ships: dict[str, Ship] = {}
        for boat in plan.boats:
            hull = HULLS[boat.hull]
            state = hull.start(boat.x, boat.y, boat.psi, boat.u)
            self.ships[boat.name] = Ship(boat.name, hull, boat.limits, state, number_of(boat.name))
        self.crafts: dict[str, Craft] = {}
        for script in traffic.scripts(plan):
            self.crafts[script.name] = Craft(script, traffic.begin(script), traffic.reports(script, 0.0, seed))
        self.traffic_steps = 0
        self._sightings: dict[str, deque[Sighting]] = {boat: deque(maxlen=MOST_SIGHTINGS) for boat in self.ships}

    def command(self, boat: str, powered: bool, surge_mps: float, yaw_rate_radps: float) -> None:
        """A set-point arrives at a boat's thrusters."""
        ship = self.ships.get(boat)
        if ship is None or not math.isfinite(surge_mps + yaw_rate_radps):
            return
        ship.powered = 1.0 if powered else 0.0
        ship.u_d, ship.r_d, ship.commanded_ns = surge_mps, yaw_rate_radps, self.now_ns

    def trouble(self, boat: str, kind: str, value: float = 0.0) -> None:
        """Something breaks, or is mended: the simulator's part of the timeline."""
        ship = self.ships[boat]
        if kind == "battery":
            ship.battery_percent = value
        elif kind in ("gnss-down", "gnss-up"):
            ship.gnss_down = kind == "gnss-down"
        elif kind in ("compass-down", "compass-up"):
            ship.compass_down = kind == "compass-down"
        elif kind in ("gyro-down", "gyro-up"):
            ship.gyro_down = kind == "gyro-down"
        elif kind in ("lidar-down", "lidar-up"):
            ship.lidar_down = kind == "lidar-down"
        elif kind in ("actuator-down", "actuator-up"):
            ship.actuator_down = kind == "actuator-down"
        elif kind in ("radio-down", "radio-up"):
            ship.radio_down = kind == "radio-down"

    def step(self) -> None:
        """20 ms pass."""
        self.now_ns += STEP_NS
        self._steps += 1
        if self.now_ns <= self.begins_ns:
            return
        for ship in self.ships.values():
            alive = (self.now_ns - ship.commanded_ns) * 1e-9 < self.watchdog_s and not ship.actuator_down
            ship.state = ship.hull.advance(
                ship.state, ship.u_d, ship.r_d, self.water, ship.limits, STEP_S, ship.powered if alive else 0.0
            )
        if self._steps % STEPS_A_SENSE == 0:
            self._drift_gnss()
        if self.crafts:
            self._move_traffic()

    @property
    def traffic_s(self) -> float:
        """For how long the other vessels have been under way [s]."""
        return self.traffic_steps * STEP_S

    def _move_traffic(self) -> None:
        """The other vessels go on, and are heard or seen."""
        self.traffic_steps += 1
        t_s = self.traffic_steps * STEP_S
        bodies = [(ship.state.x, ship.state.y, *self.velocity(ship)) for ship in self.ships.values()]
        for craft in self.crafts.values():
            craft.motion = traffic.advance(craft.script, craft.motion, t_s, bodies, STEP_S)
            number = traffic.reports(craft.script, t_s, self.seed)
            if number > craft.reports:
                craft.reports = number
                for ship in self.ships.values():
                    heard = traffic.report(
                        craft.script, craft.motion, self._listener(ship), number, self.now_ns, t_s, self.seed
                    )
                    if heard is not None:
                        self._sightings[ship.name].append(heard)

    def _listener(self, ship: Ship) -> traffic.Listener:
        knows = not ship.gnss_down
        place = (ship.state.x, ship.state.y, ship.error_n, ship.error_e)
        return traffic.Listener(ship.number, *place, knows, self.plan.plane)

    def _normal(self, ship: Ship, purpose: int) -> float:
        """A standard normal number (Box-Muller over two hashes)."""
        u1 = uniform(self.seed, ship.number, self._steps, purpose)
        u2 = uniform(self.seed, ship.number, self._steps, purpose + 1)
        return math.sqrt(-2.0 * math.log(1.0 - u1)) * math.cos(2.0 * math.pi * u2)

    def _drift_gnss(self) -> None:
        sigma = self.plan.mission.environment.gnss_sigma_m
        if sigma <= 0.0:
            return
        keep = math.exp(-SENSE_S / CORRELATION_S)
        kick = sigma * math.sqrt(1.0 - keep * keep)
        for ship in self.ships.values():
            ship.error_n = keep * ship.error_n + kick * self._normal(ship, 10)
            ship.error_e = keep * ship.error_e + kick * self._normal(ship, 12)

    def velocity(self, ship: Ship) -> tuple[float, float]:
        """Velocity over ground, north and east [m/s]."""
        return ship.hull.velocity(ship.state, self.water)

    def sense(self, boat: str) -> Reading:
        """What a boat's sensors say now, and what they saw of others since they were asked last."""
        ship = self.ships[boat]
        trouble = "the thrusters do not answer" if ship.actuator_down else ""
        sightings = tuple(self._sightings[boat])
        self._sightings[boat].clear()
        environment = self.plan.mission.environment
        white = environment.gnss_white_m
        raw = noisy(environment) or ship.compass_down or ship.gyro_down
        if ship.gnss_down and not raw:
            return Reading(
                stamp_ns=self.now_ns, battery_percent=ship.battery_percent, trouble=trouble, sightings=sightings
            )
        x = ship.state.x + ship.error_n + (white * self._normal(ship, 20) if white > 0.0 else 0.0)
        y = ship.state.y + ship.error_e + (white * self._normal(ship, 22) if white > 0.0 else 0.0)
        lat_deg, lon_deg = self.plan.plane.to_geographic(x, y)
        v_north, v_east = self.velocity(ship)
        reading = Reading(
            stamp_ns=self.now_ns,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            heading_rad=ship.state.psi,
            v_north_mps=v_north,
            v_east_mps=v_east,
            yaw_rate_radps=ship.state.r,
            position_error_m=math.hypot(environment.gnss_sigma_m, white),
            battery_percent=ship.battery_percent,
            trouble=trouble,
            sightings=sightings,
        )
        return self._raw(ship, reading, environment) if raw else reading

    def _raw(self, ship: Ship, reading: Reading, environment: Environment) -> Reading:
        """The reading as sensors give it: each with its noise, and NaN from one that is down."""
        sigma_v = environment.gnss_velocity_mps
        sigma_psi = math.radians(environment.heading_noise_deg)
        sigma_r = math.radians(environment.yaw_rate_noise_degps)
        fix = math.nan if ship.gnss_down else 0.0
        compass = math.nan if ship.compass_down else sigma_psi * self._normal(ship, 30)
        gyro = math.nan if ship.gyro_down else sigma_r * self._normal(ship, 32)
        return structs.replace(
            reading,
            raw=True,
            lat_deg=reading.lat_deg + fix,
            lon_deg=reading.lon_deg + fix,
            v_north_mps=reading.v_north_mps + fix + sigma_v * self._normal(ship, 34),
            v_east_mps=reading.v_east_mps + fix + sigma_v * self._normal(ship, 36),
            heading_rad=reading.heading_rad + compass,
            yaw_rate_radps=reading.yaw_rate_radps + gyro,
            velocity_error_mps=sigma_v,
            heading_error_rad=sigma_psi,
        )

    def vessel(self, name: str) -> Truth:
        """Where another vessel really is."""
        craft = self.crafts[name]
        m = craft.motion
        vx, vy = m.velocity
        lat_deg, lon_deg = self.plan.plane.to_geographic(m.x, m.y)
        return Truth(
            stamp_ns=self.now_ns,
            x_m=m.x,
            y_m=m.y,
            psi_rad=m.chi,
            u_mps=m.speed,
            v_mps=0.0,
            r_radps=None,
            vx_mps=vx,
            vy_mps=vy,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            length_m=craft.script.length_m,
        )

    def truth(self, boat: str) -> Truth:
        """Where a hull really is."""
        ship = self.ships[boat]
        s = ship.state
        v_north, v_east = self.velocity(ship)
        lat_deg, lon_deg = self.plan.plane.to_geographic(s.x, s.y)
        return Truth(
            stamp_ns=self.now_ns,
            x_m=s.x,
            y_m=s.y,
            psi_rad=s.psi,
            u_mps=s.u,
            v_mps=s.v,
            r_radps=s.r,
            vx_mps=v_north,
            vy_mps=v_east,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            length_m=ship.limits.length_m,
        )
