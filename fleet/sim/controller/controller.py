"""The controller itself: it obeys thrust frames while the watchdog is fresh, and stops the thrusters when it is not.

Frames and time are handed in, frames are handed out; no bus. Remote control, faults and battery are simulated.
"""

from __future__ import annotations

import math

from fleet.drivers.can.decoder import Decoder
from fleet.drivers.can.frames import (
    COMMANDED,
    FAULT,
    FIX_3D,
    NO_FIX,
    RC,
    STANDBY,
    STOPPING,
    Battery,
    Frame,
    Frames,
    Navigation,
    Status,
    Watchdog,
)
from fleet.drivers.can.loops import NO_THRUST
from fleet.drivers.seam import Reading
from fleet.guidance.thrust import Thrusters, Thrusts, limited, slew

WATCHDOG_S = 0.5
"""Without a new watchdog frame for so long, the thrusters stop."""
STATUS_EVERY = 2  # navigation sets: 10 Hz
BATTERY_EVERY = 20
FULL_V, EMPTY_V = 13.0, 11.0  # lead-acid, 12 V
CURRENT_A_PER_N = 30.0 / 133.0  # of a thruster: 30 A at full thrust


class Controller:
    """One boat's thruster controller, with its sensors."""

    def __init__(self, frames: Frames, thrusters: Thrusters, watchdog_s: float = WATCHDOG_S) -> None:
        self._frames, self._thrusters, self.watchdog_s = frames, thrusters, watchdog_s
        self.decoder = Decoder(frames, "controller")
        self.thrusts: Thrusts[float] = NO_THRUST  # what they give now
        self._wanted: Thrusts[float] = NO_THRUST
        self._watched_ns = -(1 << 62)
        self._run = False
        self._pilot: Thrusts[float] | None = None
        self.faults: frozenset[str] = frozenset()
        self._sets = 0

    def pilot(self, thrusts: Thrusts[float] | None) -> None:
        """A pilot takes the boat by remote control and asks for these thrusts; None: gives it back."""
        self._pilot = thrusts
        self._run = False  # what the agent asked for before does not come back to life

    def take(self, now_ns: int, identifier: int, payload: bytes, *, plain: bool = True) -> None:
        """A frame arrives."""
        said = self.decoder.take(identifier, payload, plain=plain)
        if isinstance(said, Watchdog):
            self._watched_ns, self._run = now_ns, said.run and self._pilot is None
        elif isinstance(said, Thrusts):
            self._wanted = limited(said, self._thrusters)

    def mode(self, now_ns: int) -> int:
        """Who has the thrusters."""
        if self.faults & STOPPING:
            return FAULT
        if self._pilot is not None:
            return RC
        return COMMANDED if self._run and self._watched(now_ns) else STANDBY

    def _watched(self, now_ns: int) -> bool:
        return (now_ns - self._watched_ns) * 1e-9 <= self.watchdog_s

    def advance(self, now_ns: int, dt: float) -> Thrusts[float]:
        """The thrusters dt seconds later: towards what their master asks, or off at once."""
        mode = self.mode(now_ns)
        if mode == RC and self._pilot is not None:
            self.thrusts = slew(self.thrusts, limited(self._pilot, self._thrusters), self._thrusters, dt)
        elif mode == COMMANDED:
            self.thrusts = slew(self.thrusts, self._wanted, self._thrusters, dt)
        else:
            self.thrusts = NO_THRUST
        return self.thrusts

    def tell(self, now_ns: int, reading: Reading) -> list[Frame]:
        """The frames that are due with a navigation set; the sensors' stamp is that of the frames' arrival."""
        self._sets += 1
        nav = Navigation(
            counter=self._sets,
            fix=FIX_3D if math.isfinite(reading.lat_deg) else NO_FIX,
            fused=not reading.raw,
            lat_deg=reading.lat_deg,
            lon_deg=reading.lon_deg,
            heading_rad=reading.heading_rad % (2.0 * math.pi),
            yaw_rate_radps=reading.yaw_rate_radps,
            v_north_mps=reading.v_north_mps,
            v_east_mps=reading.v_east_mps,
            position_error_m=reading.position_error_m,
        )
        frames = list(self._frames.navigation(nav))
        if self._sets % STATUS_EVERY == 1:
            mode, watched = self.mode(now_ns), self._watched(now_ns)
            frames.insert(
                0, self._frames.status(Status(self._sets // 2, mode, self._pilot is not None, watched, self.faults))
            )
        if self._sets % BATTERY_EVERY == 1:
            percent = reading.battery_percent
            voltage = EMPTY_V + 0.01 * (FULL_V - EMPTY_V) * percent if math.isfinite(percent) else 0.0
            t = self.thrusts
            current = CURRENT_A_PER_N * sum(map(abs, (t.rear_port, t.rear_starboard, t.side_port, t.side_starboard)))
            frames.append(self._frames.battery(Battery(self._sets // BATTERY_EVERY, percent, voltage, current)))
        return frames
