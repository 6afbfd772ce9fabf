"""A boat in memory: helm, simulated controller and hull, with a counter for a clock and frames that arrive at once."""

from __future__ import annotations

import math
import random

from msgspec.structs import replace

from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.frames import Frames
from fleet.drivers.can.helm import Helm
from fleet.drivers.seam import Reading
from fleet.guidance.thrust import resultant
from fleet.hulls import CALM, Water, catamaran
from fleet.sim.controller.controller import Controller

FRAMES = Frames()
STEP_NS = 25_000_000
DT_S = 0.025
STEPS_A_SET, STEPS_A_TICK = 2, 4  # 20 Hz, 10 Hz
HERE = Reading(1, 44.38, 8.93, 0.0, 0.0, 0.0, 0.0, 0.02, 80.0)


class Rig:
    """One boat; `run` lets time pass."""

    def __init__(self, config: CanConfig | None = None, water: Water[float] = CALM, noise: float = 0.0) -> None:
        self.helm = Helm(config or CanConfig(), FRAMES)
        self.controller = Controller(FRAMES, catamaran.THRUSTERS)
        self.hull = catamaran.start(0.0, 0.0, 0.0, 0.0)
        self.now_ns, self._steps = 1_000_000_000, 0
        self.water, self._noise, self._rng = water, noise, random.Random(4)
        self.told: list[str] = []
        self.sent = 0
        self.deaf_controller = self.deaf_helm = self.agent_hangs = False
        self.speeds: list[tuple[float, float]] = []
        self.blind = self.agent_knows = False  # a controller without sensors; an agent with sensors of its own

    @property
    def thrust(self) -> float:
        """Sum of what all thrusters give, whatever direction [N]."""
        t = self.controller.thrusts
        return sum(map(abs, (t.rear_port, t.rear_starboard, t.side_port, t.side_starboard)))

    def run(self, seconds: float, command: tuple[float, float] | None = None) -> None:
        """Time passes; the agent asks for `command` ten times a second, or for nothing."""
        for _ in range(round(seconds / DT_S)):
            self.now_ns += STEP_NS
            self._steps += 1
            if self._steps % STEPS_A_TICK == 0 and not self.agent_hangs:
                if self.agent_knows:
                    self.helm.moves(self.now_ns, self.hull.u, self.hull.r)
                if command is None:
                    self.helm.neutral()
                else:
                    self.told.append(self.helm.command(self.now_ns, *command))
            if self._steps % STEPS_A_SET == 0:
                self._exchange()
            thrusts = self.controller.advance(self.now_ns, DT_S)
            surge, yaw = resultant(thrusts, catamaran.THRUSTERS)
            self.hull = catamaran.push(self.hull, surge, yaw, self.water, DT_S)
            self.speeds.append((self.hull.u, self.hull.r))

    def _exchange(self) -> None:
        noise = [self._noise * self._rng.gauss(0.0, 1.0) for _ in range(3)]
        vx, vy = catamaran.velocity(self.hull, self.water)
        seen = replace(
            HERE,
            heading_rad=self.hull.psi,
            v_north_mps=vx + noise[0],
            v_east_mps=vy + noise[1],
            yaw_rate_radps=self.hull.r + 0.2 * noise[2],
        )
        if self.blind:
            seen = Reading(0, battery_percent=80.0, raw=True)
        for frame in self.controller.tell(self.now_ns, seen):
            if not self.deaf_helm:
                for answer in self.helm.take(self.now_ns, *frame):
                    self.sent += 1
                    if not self.deaf_controller:
                        self.controller.take(self.now_ns, *answer)

    def seconds_until_no_thrust(self, most_s: float = 5.0, command: tuple[float, float] | None = None) -> float:
        """From now until no thruster gives anything."""
        began = self.now_ns
        while self.thrust > 0.0:
            self.run(DT_S, command)
            if (self.now_ns - began) * 1e-9 > most_s:
                return math.inf
        return (self.now_ns - began) * 1e-9
