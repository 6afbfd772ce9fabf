"""A turn of a boat's scanner in the world: from hulls as they are to distances as a scanner tells them."""

from __future__ import annotations

import math

from fleet.mission.model import Lidar, Sensed
from fleet.sensing.scan import Scan, packed
from fleet.sim.scanner.rays import Body, Turn, boat, ranges, vessel
from fleet.sim.scanner.responder import MODEL
from fleet.sim.world import World
from fleet.wire.radio import mix

NO_RETURN_MM = 65533
DRAWN_FOR = 240  # of the random numbers of a turn
BEAM_S = MODEL.turn_s / MODEL.around
LOOKED_NS = 500_000_000  # lock-step boats look so often, as agents do


def wanted(world: World) -> bool:
    """Whether a vessel of the mission is seen by scanners only; then every boat has one."""
    return any(isinstance(craft.script.sensed, Lidar) for craft in world.crafts.values())


def cast(world: World, name: str) -> tuple[int, list[int]]:
    """A turn that ends now: when it began [ns], and the distance at each step [mm].

    Every turn has random numbers of its own, those of its end.
    """
    import numpy as np

    ship, environment = world.ships[name], world.plan.mission.environment
    steps = np.arange(MODEL.first, MODEL.last + 1, dtype=np.float64)
    bearings = (MODEL.front - steps) * (2.0 * math.pi / MODEL.around)
    vx, vy = world.velocity(ship)
    turn = Turn(ship.state.x, ship.state.y, ship.state.psi, vx, vy, ship.state.r, BEAM_S)
    found = ranges(turn, bearings, _bodies(world, name), environment.lidar_range_m)
    random = np.random.default_rng(mix(world.seed, ship.number, world.traffic_steps, DRAWN_FOR))
    found = found + environment.lidar_noise_m * random.standard_normal(len(found))
    found[random.random(len(found)) < environment.lidar_loss] = math.inf
    distances = np.where(np.isfinite(found), np.rint(found * 1e3), NO_RETURN_MM).astype(int).tolist()
    return world.now_ns - round(BEAM_S * (len(steps) - 1) * 1e9), distances


def _bodies(world: World, name: str) -> list[Body]:
    """All hulls but the own."""
    bodies = [
        boat(one.state.x, one.state.y, one.state.psi, *world.velocity(one), one.limits.length_m)
        for other, one in world.ships.items()
        if other != name
    ]
    t_s = world.traffic_s
    for craft in world.crafts.values():
        if not _hidden(craft.script.sensed, t_s):
            m = craft.motion
            bodies.append(vessel(m.x, m.y, m.chi, *m.velocity, craft.script.length_m))
    return bodies


def _hidden(sensed: Sensed, t_s: float) -> bool:
    """Whether the water hides a vessel from scanners just then."""
    return isinstance(sensed, Lidar) and any(gap.from_s <= t_s < gap.to_s for gap in sensed.gaps)


class Eye:
    """A boat's scanner in lock-step: scans without a wire."""

    def __init__(self, world: World, name: str) -> None:
        self._world, self._name = world, name
        self._looked_ns = 0

    def scans(self) -> tuple[Scan, ...]:
        """A scan, twice a second."""
        world = self._world
        if world.now_ns - self._looked_ns < LOOKED_NS or world.ships[self._name].lidar_down:
            return ()
        self._looked_ns = world.now_ns
        began_ns, distances = cast(world, self._name)
        metres = packed(one * 1e-3 if one < NO_RETURN_MM else math.nan for one in distances)
        step = 2.0 * math.pi / MODEL.around
        return (Scan(began_ns, MODEL.angle(MODEL.first), -step, metres, MODEL.most_mm * 1e-3, BEAM_S, scanner="lidar"),)
