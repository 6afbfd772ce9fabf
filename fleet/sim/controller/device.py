"""The simulated controller on a bus of its own: python-can's UDP multicast, which stays on this machine."""

from __future__ import annotations

import contextlib
import socket
from typing import Any

from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.driver import BUS_OFF, connect
from fleet.drivers.can.frames import Frames
from fleet.drivers.can.helm import WALL_S
from fleet.drivers.can.loops import NO_THRUST
from fleet.drivers.seam import Reading
from fleet.guidance.limits import Limits
from fleet.guidance.thrust import Thrusts, resultant
from fleet.hulls import HullState, Water, catamaran
from fleet.sim.controller.controller import WATCHDOG_S, Controller
from fleet.sim.world import World

GROUP = "239.74.163.2"  # python-can's own; boats differ in the port
MOST_JUNK = 100  # passed over in one exchange
STAYS_HERE = 0  # hops: the frames never leave this machine
ALL_FAILED = frozenset(
    f"{where} thruster failed" for where in ("rear port", "rear starboard", "side port", "side starboard")
)


class Driven:
    """The catamaran, pushed by the controller's thrusters whatever set-point the world has."""

    description = catamaran.description

    def __init__(self, world: World, controller: Controller) -> None:
        self._world, self._controller = world, controller

    def start(self, x: float, y: float, psi: float, u: float) -> HullState[float]:
        """A boat on its course, at speed u."""
        return catamaran.start(x, y, psi, u)

    def velocity(self, state: HullState[float], water: Water[float]) -> tuple[float, float]:
        """(vx, vy): velocity over ground, north and east [m/s]."""
        return catamaran.velocity(state, water)

    def advance(
        self,
        state: HullState[float],
        u_d: float,  # noqa: ARG002 - a hull takes set-points; this one's come over the bus, as thrusts
        r_d: float,  # noqa: ARG002
        water: Water[float],
        limits: Limits,  # noqa: ARG002
        dt: float,
        powered: float = 1.0,
    ) -> HullState[float]:
        """The boat dt seconds later; powered 0: its thrusters do not answer."""
        thrusts = self._controller.advance(self._world.now_ns, dt)
        surge, yaw = resultant(thrusts if powered == 1.0 else NO_THRUST, catamaran.THRUSTERS)
        return catamaran.push(state, surge, yaw, water, dt)

    def advance_by(
        self,
        steps: int,
        state: HullState[float],
        u_d: float,
        r_d: float,
        water: Water[float],
        limits: Limits,
        dt: float,
        powered: float,
    ) -> HullState[float]:
        """`steps` times `advance`."""
        for _ in range(steps):
            state = self.advance(state, u_d, r_d, water, limits, dt, powered)
        return state


def free_udp_port() -> int:
    """A port that nobody uses just now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        port: int = probe.getsockname()[1]
        return port


class CanDevice:
    """See `fleet.sim.device.Device`."""

    def __init__(self, world: World, boat: str, warp: float) -> None:
        self._world, self._boat = world, boat
        self._ship = world.ships[boat]
        self._frames = Frames()
        self.controller = Controller(self._frames, catamaran.THRUSTERS, max(WATCHDOG_S, WALL_S * warp))
        state = self._ship.state
        self._ship.hull = Driven(world, self.controller)  # type: ignore[assignment]
        self._ship.state = catamaran.start(state.x, state.y, state.psi, state.u)
        options: dict[str, str | bool | int | float] = {"port": free_udp_port(), "hop_limit": STAYS_HERE}
        self._config = CanConfig(interface="udp_multicast", channel=GROUP, options=options)
        environment = world.plan.mission.environment
        self.keys: dict[str, Any] = {
            "can": {
                "interface": "udp_multicast",
                "channel": GROUP,
                "options": options,
                "velocity_error_mps": environment.gnss_velocity_mps,
                "heading_error_deg": environment.heading_noise_deg,
            }
        }
        self._bus: Any = connect(self._config)

    def exchange(self, reading: Reading) -> None:
        """Take what the agent sent, tell what the sensors say."""
        world, controller = self._world, self.controller
        world.command(self._boat, True, 0.0, 0.0)  # the bus is the controller's; its own watchdog stops the thrusters
        controller.faults = ALL_FAILED if self._ship.actuator_down else frozenset()
        if self._bus is None:
            return
        import can

        while (message := self._received()) is not None:
            plain = not (message.is_extended_id or message.is_remote_frame or message.is_error_frame or message.is_fd)
            controller.take(world.now_ns, message.arbitration_id, bytes(message.data), plain=plain)
        with contextlib.suppress(can.CanError, OSError):
            for identifier, payload in controller.tell(world.now_ns, reading):
                self._bus.send(can.Message(arbitration_id=identifier, data=payload, is_extended_id=False))

    def _received(self) -> Any:
        """The next message, or None; what is not a frame is passed over."""
        import can

        for _ in range(MOST_JUNK):
            try:
                return self._bus.recv(0.0)
            except (can.CanError, OSError):
                continue
        return None

    def trouble(self, kind: str, value: float) -> None:
        """`pilot-takes` (with so much thrust ahead, each rear thruster [N]), `pilot-gives`, `bus-off`, `bus-on`."""
        if kind == "pilot-takes":
            self.controller.pilot(Thrusts(value, value, 0.0, 0.0))
        elif kind == "pilot-gives":
            self.controller.pilot(None)
        elif kind == "bus-off" and self._bus is not None:
            import can

            with contextlib.suppress(can.CanError, OSError):
                self._bus.send(
                    can.Message(arbitration_id=BUS_OFF, is_error_frame=True, data=bytes(8), is_extended_id=False)
                )
            self.close()
        elif kind == "bus-on" and self._bus is None:
            self._bus = connect(self._config)

    def close(self) -> None:
        """Disconnect."""
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.shutdown()
