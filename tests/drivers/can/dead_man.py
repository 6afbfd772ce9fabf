"""What stops the boat, and after how long: a driver on a real bus, a controller and a hull in real time.

    python -m tests.drivers.can.dead_man

A row: what was done while the boat sailed at 1 m/s; seconds until all thrusters are off (least and most of the trials);
how far it then still goes before it is slower than 0.1 m/s; what the agent is told, and after how many seconds.
"""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time
from collections.abc import Callable

import msgspec

from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.driver import CanDriver
from fleet.drivers.seam import Reading
from fleet.mission.load import load
from fleet.mission.plan import build
from fleet.sim.controller.device import CanDevice
from fleet.sim.world import World

CHILD = """
import sys, time, msgspec
from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.driver import CanDriver
driver = CanDriver(msgspec.json.decode(sys.argv[1], type=CanConfig), time.monotonic_ns, simulated=True)
driver.open()
while True:
    driver.write(1.0, 0.0)
    time.sleep(0.1)
"""
TRIALS = 3


class Trial:
    """One boat under way at 1 m/s, in real time."""

    def __init__(self, *, child: bool = False) -> None:
        self.world = World(build(load("overtaking")), time.monotonic_ns())
        self.device = CanDevice(self.world, "b1", 1.0)
        self.ship = self.world.ships["b1"]
        self.writes = True
        self.told: list[tuple[int, str]] = []
        config = msgspec.convert(self.device.keys["can"], CanConfig)
        self.driver = CanDriver(config, time.monotonic_ns, simulated=True)
        self.child: subprocess.Popen[bytes] | None = None
        if child:
            self.child = subprocess.Popen([sys.executable, "-c", CHILD, msgspec.json.encode(config).decode()])
        else:
            self.driver.open()
        self._sets = 0
        for _ in range(450):  # 9 s: the child takes its time to start
            self.once()
        assert self.thrust > 10.0
        assert 0.9 < self.ship.state.u < 1.1

    @property
    def thrust(self) -> float:
        t = self.device.controller.thrusts
        return sum(map(abs, (t.rear_port, t.rear_starboard, t.side_port, t.side_starboard)))

    def once(self) -> None:
        """20 ms of the world, in time with the clock; a navigation set every 50 ms, a command every 100."""
        self.world.step()
        time.sleep(max(0.0, (self.world.now_ns - time.monotonic_ns()) * 1e-9))
        self._sets += 1
        if self._sets % 5 == 0 or self._sets % 5 == 2:
            self.device.exchange(self.world.sense("b1"))
            if self.child is None and self._sets % 5 == 0:
                if self.writes:
                    wrong = self.driver.write(1.0, 0.0)
                    self.told.append((self.world.now_ns, wrong))
                reading = self.driver.read() if self.writes else Reading(0)
                self.told.append((self.world.now_ns, reading.authority or reading.trouble))

    def measure(self, deed: Callable[[Trial], None]) -> tuple[float, float, str, float]:
        """(seconds to no thrust; metres after that, below 0 seconds until it goes on; what is told, after seconds)."""
        self.told.clear()
        deed(self)
        began_ns, off_s, x_off = self.world.now_ns, math.inf, 0.0
        while (self.world.now_ns - began_ns) * 1e-9 < 12.0:
            self.once()
            if self.thrust == 0.0 and off_s == math.inf:
                off_s, x_off = (self.world.now_ns - began_ns) * 1e-9, self.ship.state.x
            if off_s < math.inf and self.ship.state.u < 0.1:
                break
            if off_s < math.inf and self.thrust > 0.0:
                return off_s, off_s - (self.world.now_ns - began_ns) * 1e-9, *self.first_words(began_ns)
        return off_s, self.ship.state.x - x_off, *self.first_words(began_ns)

    def first_words(self, began_ns: int) -> tuple[str, float]:
        """What the agent was told first since then, and after how many seconds."""
        return next(((w, (t - began_ns) * 1e-9) for t, w in self.told if w), ("", math.nan))

    def close(self) -> None:
        """End all of it."""
        if self.child is not None:
            self.child.kill()
            self.child.wait()
        self.driver.close()
        self.device.close()


def killed(trial: Trial) -> None:
    """The agent's process is killed (SIGKILL)."""
    assert trial.child is not None
    trial.child.send_signal(signal.SIGKILL)


def frozen(trial: Trial) -> None:
    """The agent's process is frozen (SIGSTOP)."""
    assert trial.child is not None
    trial.child.send_signal(signal.SIGSTOP)


def hangs(trial: Trial) -> None:
    """The agent's loop hangs, its driver lives on."""
    trial.writes = False


def closed(trial: Trial) -> None:
    """The agent ends in good order and closes its driver."""
    trial.writes = False
    trial.driver.close()


def cut(trial: Trial) -> None:
    """The driver's socket is closed under it."""
    trial.driver._bus.shutdown()  # what a pulled adapter does


def bus_off(trial: Trial) -> None:
    """Bus off."""
    trial.device.trouble("bus-off", 0.0)


def pilot(trial: Trial) -> None:
    """A pilot takes the boat, sticks at rest."""
    trial.device.trouble("pilot-takes", 0.0)


def main() -> None:
    """Print the table."""
    print("| what was done | thrusters off after [s] | then still goes | the agent is told | after [s] |")
    print("|---|---|---|---|---|")
    for deed, child in (
        (killed, True), (frozen, True), (hangs, False), (closed, False), (cut, False), (bus_off, False), (pilot, False),
    ):  # fmt: skip
        rows = []
        for _ in range(TRIALS):
            trial = Trial(child=child)
            try:
                rows.append(trial.measure(deed))
            finally:
                trial.close()
        off, coast, told = [r[0] for r in rows], [r[1] for r in rows], [r[3] for r in rows]
        after = "" if math.isnan(told[0]) else f"{min(told):.2f} to {max(told):.2f}"
        words = rows[0][2] or "-"
        went = f"{max(coast):.1f} m" if min(coast) >= 0.0 else f"sails on {-min(coast):.1f} s later"
        what = (deed.__doc__ or "").rstrip(".")
        print(f"| {what} | {min(off):.2f} to {max(off):.2f} | {went} | {words} | {after} |", flush=True)


if __name__ == "__main__":
    main()
