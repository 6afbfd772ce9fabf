"""What the driver knows, and what it sends: frames and time are handed in, frames are handed out. No bus, no clock.

Thrust is worked out from every navigation set that arrives (20 Hz), and goes out with a watchdog frame, as long as a
command of the agent is fresh, the controller is heard, and nobody else has the boat. When that ends, one frame says so;
then nothing goes out, and the controller would stop the thrusters by itself too.
"""

from __future__ import annotations

import logging
import math

from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.decoder import Decoder
from fleet.drivers.can.frames import (
    COMMANDED,
    FAULT,
    MODES,
    STOPPING,
    Battery,
    Frame,
    Frames,
    Navigation,
    Status,
)
from fleet.drivers.can.loops import NO_THRUST, Loops, begin, drive
from fleet.drivers.seam import Reading

log = logging.getLogger("fleet.can")
WALL_S = 0.25  # a busy machine may delay a frame so long, which at high warp is more than the limits
OBEYS_S = 1.0  # a controller that is commanded for so long and does not follow is reported
DT_MOST_S = 0.2  # the loops take no longer step
PILOT = "pilot with the remote control"


class Helm:
    """One boat's driver without its bus."""

    def __init__(self, config: CanConfig, frames: Frames, *, warp: float = 1.0) -> None:
        self._config, self._frames = config, frames
        self.decoder = Decoder(frames, "agent")
        self._age_s = max(config.command_age_s, WALL_S * warp)
        self._silent_s = max(config.silent_s, WALL_S * warp)
        self._command: tuple[float, float] | None = None
        self._command_ns = 0
        self._since_ns = 0  # of uninterrupted commands
        self._loops: Loops | None = None
        self._loops_ns = 0
        self._counter = 0
        self._status: Status | None = None
        self._battery_percent = math.nan
        self._nav: Navigation | None = None
        self._nav_ns = 0
        self._told: tuple[float, float] | None = None  # surge and yaw rate, where the agent knows them
        self._told_ns = 0
        self._heard_ns = 0
        self._neutral_due = True

    # -- the agent's side ------------------------------------------------------------------------------------------
    def command(self, now_ns: int, u_d: float, r_d: float) -> str:
        """A set-point: surge over ground [m/s] and yaw rate [rad/s]; '' or why it cannot be followed."""
        if not math.isfinite(u_d + r_d):
            return f"set-point {u_d}, {r_d}: expected numbers"
        trouble = self.trouble(now_ns) or self._deaf(now_ns)
        if trouble:
            self._command = None
            return trouble
        if self._command is None or (now_ns - self._command_ns) * 1e-9 > self._age_s:
            self._since_ns = now_ns
        self._command, self._command_ns = (u_d, r_d), now_ns
        status = self._status
        if (
            status is not None
            and status.mode != COMMANDED
            and (now_ns - self._since_ns) * 1e-9 > max(OBEYS_S, self._age_s)
        ):
            self._command = None
            return f"the controller does not obey: its mode stays {MODES[status.mode]}"
        return ""

    def neutral(self) -> None:
        """No thrust, said once; then silence keeps it so."""
        self._neutral_due = self._neutral_due or self._command is not None
        self._command = None

    def moves(self, now_ns: int, u: float, r: float) -> None:
        """How the boat moves, as the agent knows it; used while the controller does not say so."""
        if math.isfinite(u + r):
            self._told, self._told_ns = (u, r), now_ns

    def reading(self, now_ns: int) -> Reading:
        """What is known of the boat."""
        nav, status, config = self._nav, self._status, self._config
        rc = status is not None and status.rc_override and not self._silent(now_ns)
        trouble = "" if rc else self.trouble(now_ns)
        if nav is None:
            return Reading(0, battery_percent=self._battery_percent, authority=PILOT if rc else "", trouble=trouble)
        heading = nav.heading_rad
        return Reading(
            stamp_ns=self._nav_ns,
            lat_deg=nav.lat_deg,
            lon_deg=nav.lon_deg,
            heading_rad=heading - 2.0 * math.pi if heading > math.pi else heading,
            v_north_mps=nav.v_north_mps,
            v_east_mps=nav.v_east_mps,
            yaw_rate_radps=nav.yaw_rate_radps,
            position_error_m=nav.position_error_m,
            battery_percent=self._battery_percent,
            authority=PILOT if rc else "",
            trouble=trouble,
            raw=not nav.fused,
            velocity_error_mps=0.0 if nav.fused else config.velocity_error_mps,
            heading_error_rad=0.0 if nav.fused else math.radians(config.heading_error_deg),
        )

    def trouble(self, now_ns: int) -> str:
        """Why the boat cannot be commanded, as far as the controller says."""
        if self._silent(now_ns):
            return "the controller on the CAN bus is silent"
        assert self._status is not None
        stopping = sorted(self._status.faults & STOPPING)
        if stopping or self._status.mode == FAULT:
            return f"controller: {', '.join(stopping) or 'fault'}"
        return ""

    def _silent(self, now_ns: int) -> bool:
        return self._status is None or (now_ns - self._heard_ns) * 1e-9 > self._silent_s

    def _deaf(self, now_ns: int) -> str:
        """The loops have nothing to work with."""
        why = self._deaf_bus(now_ns)
        return why if why and (self._told is None or (now_ns - self._told_ns) * 1e-9 > self._age_s) else ""

    def _deaf_bus(self, now_ns: int) -> str:
        """The controller does not say how the boat moves."""
        nav = self._nav
        if nav is None or (now_ns - self._nav_ns) * 1e-9 > self._silent_s:
            return "no navigation on the CAN bus"
        if not math.isfinite(nav.heading_rad + nav.yaw_rate_radps + nav.v_north_mps + nav.v_east_mps):
            return "no heading, yaw rate or speed on the CAN bus"
        return ""

    @property
    def commanded(self) -> bool:
        """Whether a command is in force."""
        return self._command is not None

    # -- the bus's side --------------------------------------------------------------------------------------------
    def take(self, now_ns: int, identifier: int, payload: bytes, *, plain: bool = True) -> list[Frame]:
        """A frame arrives; the frames that are due now."""
        said = self.decoder.take(identifier, payload, plain=plain)
        if isinstance(said, Status):
            self._hear(said, now_ns)
            return self._steer(now_ns) if self._deaf_bus(now_ns) and self._told is not None else []
        if isinstance(said, Battery):
            self._battery_percent = said.percent
        elif isinstance(said, Navigation):
            self._nav, self._nav_ns = said, now_ns
            if not self._deaf_bus(now_ns) or self._told is None:
                return self._steer(now_ns)
        return []

    def _hear(self, status: Status, now_ns: int) -> None:
        before = self._status.faults if self._status is not None else frozenset()
        if status.faults != before:
            log.warning(
                "controller: %s", ", ".join(sorted(status.faults)) or "no faults", extra={"event": "can-faults"}
            )
        self._status, self._heard_ns = status, now_ns
        if status.rc_override:
            self._command = None  # the pilot has the boat; a command from before does not come back to life

    def _motion(self, now_ns: int) -> tuple[float, float]:
        """Surge and yaw rate: of the controller, else as the agent told them."""
        nav = self._nav
        if nav is None or self._deaf_bus(now_ns):
            assert self._told is not None
            return self._told
        c, s = math.cos(nav.heading_rad), math.sin(nav.heading_rad)
        return nav.v_north_mps * c + nav.v_east_mps * s, nav.yaw_rate_radps

    def _steer(self, now_ns: int) -> list[Frame]:
        """Thrust and watchdog for a fresh command; nothing for a stale one."""
        command = self._command
        if command is None or (now_ns - self._command_ns) * 1e-9 > self._age_s or self._deaf(now_ns):
            self._neutral_due = self._neutral_due or self._loops is not None
            self._loops = None
            return self.farewell()
        u, r = self._motion(now_ns)
        config, dt = self._config, (now_ns - self._loops_ns) * 1e-9
        loops = self._loops
        if loops is None or dt > self._age_s:  # what they remember is of another moment
            loops, dt = begin(u, r, command[0], config.loops), 0.0
        dt = min(dt, DT_MOST_S)
        self._loops, thrusts = drive(loops, *command, u, r, dt, config.loops, config.thrusters)
        self._loops_ns = now_ns
        return [self._frames.thrust(thrusts), self._watch(True)]

    def farewell(self) -> list[Frame]:
        """The frames that stop the thrusters, if that was asked for and not said yet."""
        if not self._neutral_due:
            return []
        self._neutral_due = False
        rc = self._status is not None and self._status.rc_override
        return [] if rc else [self._frames.thrust(NO_THRUST), self._watch(False)]

    def forget(self) -> None:
        """The bus is gone: commands and loops begin anew when it is back."""
        self._command, self._loops, self._status, self._nav = None, None, None, None
        self._told = None

    def _watch(self, run: bool) -> Frame:
        self._counter = (self._counter + 1) & 255
        return self._frames.watchdog(self._counter, run)
