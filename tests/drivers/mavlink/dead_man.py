"""Who stops the boat when what dies, and after how long: a real agent, the driver, the simulated autopilot, a hull.

python -m tests.drivers.mavlink.dead_man     prints the table of docs/drivers-mavlink.md
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from msgspec import Struct, convert

from fleet.agent.process import join
from fleet.drivers.mavlink.config import MavlinkConfig
from fleet.drivers.mavlink.driver import MavlinkDriver
from fleet.drivers.mavlink.words import mode_name
from fleet.sim.autopilot.device import AutopilotDevice
from tests.agent.harness import Sea, mission

BOAT = "b1"
DRIVES_MPS = 0.2  # a thrust that asks for more still goes on
LOOK_S = 14.0


class Afloat:
    """One boat under an operator's orders at 1 m/s, on its path."""

    def __init__(self, folder: Path) -> None:
        self.sea = Sea(folder, mission(boats=1), ashore=(BOAT,))
        self.device = AutopilotDevice(self.sea.world, BOAT)
        keys = convert(self.device.keys["mavlink"], MavlinkConfig)
        self.driver = MavlinkDriver(keys, lambda: self.sea.now_ns, simulated=True)
        self.driver.open()
        self._steps = 0
        self._world_step = self.sea.world.step
        self.sea.world.step = self._step  # type: ignore[method-assign]
        self.station = self.sea.stations[BOAT]
        self.station.driver = self.driver  # type: ignore[assignment]
        self.station.switch_on()
        assert self.station.agent is not None
        self.sea.each_tick.append(join(self.station.agent, self.driver))
        self.sea.run(2.0)
        assert all(ack.ok for ack in self.sea.launch().values())
        self.sea.run(20.0)
        assert abs(self.sea.speed(BOAT) - 1.0) < 0.1, self.sea.speed(BOAT)

    def _step(self) -> None:
        """20 ms of the world; the device is served 25 times a second."""
        self._world_step()
        self._steps += 1
        if self._steps % 2 == 0:
            self.device.exchange(self.sea.world.sense(BOAT))

    @property
    def drives(self) -> bool:
        """Whether the hull is still driven ahead."""
        ship = self.sea.world.ships[BOAT]
        return bool(ship.powered) and ship.u_d > DRIVES_MPS

    def cut(self) -> None:
        """The cable between agent and autopilot is pulled."""
        self.device._port.hear = self.device._port.speak = lambda: None  # type: ignore[method-assign]

    def close(self) -> None:
        """Free the ports."""
        self.driver.close()
        self.device.close()


class Row(Struct):
    """What the boat did."""

    what: str
    drove_s: float  # on the old command
    stopped_s: float  # until slower than 0.1 m/s; -1 not within the time looked
    mode: str  # of the autopilot in the end
    armed: bool
    says: str  # what the boat publishes in the end
    said_s: float  # when it was first said


def killed(boat: Afloat) -> None:
    """kill -9."""
    boat.sea.kill(BOAT)


def frozen(boat: Afloat) -> None:
    """The computer hangs."""
    boat.sea.freeze(BOAT)


def ended(boat: Afloat) -> None:
    """The process ends in good order."""
    boat.sea.agent(BOAT).close()
    boat.sea.kill(BOAT)


def unplugged(boat: Afloat) -> None:
    """Nothing gets through between agent and autopilot."""
    boat.cut()


def rebooted(boat: Afloat) -> None:
    """The autopilot starts anew."""
    boat.device.trouble("autopilot-restarts", 0.0)


def taken(boat: Afloat) -> None:
    """The pilot turns the mode switch, sticks centred."""
    boat.device.trouble("pilot-takes", 0.0)


def blind(boat: Afloat) -> None:
    """GNSS is lost."""
    boat.sea.world.trouble(BOAT, "gnss-down")


def blind_and_dead(boat: Afloat) -> None:
    """GNSS is lost, and the agent is killed."""
    blind(boat)
    killed(boat)


def stopped(boat: Afloat) -> None:
    """An operator says stop-now."""
    boat.sea.ask("stop-now")


CASES: dict[str, tuple[Callable[[Afloat], None], float]] = {  # and for how long the old command may last at most [s]
    "agent killed": (killed, 3.0),
    "agent's computer frozen": (frozen, 3.0),
    "agent ended in good order": (ended, 0.0),
    "link cut between agent and autopilot": (unplugged, 3.0),
    "autopilot restarted": (rebooted, 0.0),
    "mode taken by the pilot": (taken, 0.0),
    "GNSS lost": (blind, 1.0),
    "GNSS lost and agent killed": (blind_and_dead, 3.0),
    "operator says stop-now": (stopped, 0.0),
}


def measure(what: str, folder: Path) -> Row:
    """Let it happen, and look."""
    boat = Afloat(folder)
    try:
        began_ns = boat.sea.now_ns
        agent: Any = boat.station.agent
        CASES[what][0](boat)
        row = Row(what, 0.0, -1.0, "", False, "", -1.0)
        for _ in range(round(LOOK_S * 10)):
            boat.sea.tick()
            t_s = (boat.sea.now_ns - began_ns) * 1e-9
            if boat.drives:
                row.drove_s = round(t_s, 1)
            if row.stopped_s < 0.0 and boat.sea.speed(BOAT) < 0.1:
                row.stopped_s = round(t_s, 1)
            said = agent.reading.authority or agent.driver_trouble or "; ".join(_reasons(agent))
            if said and row.said_s < 0.0 and boat.station.agent is not None and not boat.station.frozen:
                row.said_s = round(t_s, 1)
                row.says = said
        rover = boat.device.rover
        row.mode, row.armed = mode_name(rover.mode), rover.armed
        return row
    finally:
        boat.close()


def _reasons(agent: Any) -> tuple[str, ...]:
    from fleet.agent.modes import in_words

    return tuple(reason for reason in in_words(int(agent.reasons)) if "recording" not in reason)


def main() -> None:
    """Print the table."""
    print("| what happened | the old command lasted | below 0.1 m/s after | autopilot then | the boat says |")
    print("|---|---|---|---|---|")
    for what in CASES:
        with tempfile.TemporaryDirectory() as folder:
            row = measure(what, Path(folder))
        armed = "armed" if row.armed else "not armed"
        says = f"{row.says} (after {row.said_s:g} s)" if row.says else "nothing"
        stop = f"{row.stopped_s:g} s" if row.stopped_s >= 0.0 else f"not within {LOOK_S:g} s"
        print(f"| {what} | {row.drove_s:g} s | {stop} | {row.mode}, {armed} | {says} |")


if __name__ == "__main__":
    main()
