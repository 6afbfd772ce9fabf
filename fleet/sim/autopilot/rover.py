"""ArduPilot Rover as a boat's computer meets it: modes, arming, set-points, failsafes, streams. Time is handed in.

Imitates what was observed of Rover 4.7, with its traps: a mode asked for while it starts is acknowledged and forgotten,
set-points outside GUIDED vanish, positions go on after their loss, rates are forgotten by a restart.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Hashable
from typing import Any

from fleet.drivers.mavlink import words
from fleet.drivers.mavlink.words import AUTO, GUIDED, HOLD, INITIALISING, LOITER
from fleet.sim.autopilot.guided import Aim, Loops, Refused, aim_of, stay, steer
from fleet.sim.autopilot.hull import Senses, Thrust
from fleet.sim.autopilot.settings import DEFAULTS
from fleet.sim.autopilot.telemetry import Streams
from fleet.sim.autopilot.uploads import Uploads

BOOT_S, ARMABLE_S, READY_S = 6.0, 23.0, 42.0  # INITIALISING ends; MANUAL can be armed; GUIDED can be armed
ESTIMATE_S = 30.0  # the estimator starts to have something
TARGET_S = 3.0  # without a set-point
VARIANCE_S = 8.5  # after the loss of GNSS
SURE_S = 2.0  # after that the estimator says that it holds a constant position
CHECKS_SAID_S = 30.0
NOT_ARMABLE = (AUTO, 11, 12)
NEEDS_POSITION = (LOITER, AUTO, 11, 12, GUIDED)
READY_FLAGS, COLD_FLAGS, LOSING_FLAGS, CONSTANT_FLAGS = 0x33F, 0x400, 0x27, 0xA7
REBOOT = 246
UPLOADS = frozenset(
    f"MISSION_{word}" for word in ("COUNT", "ITEM_INT", "REQUEST_LIST", "REQUEST", "REQUEST_INT", "CLEAR_ALL")
)
MOST_HZ_SHARE = 0.5  # of SCHED_LOOP_RATE
METRES_A_DEGREE = 111_195.0
ALERT, INFO = 2, 6
NS = 1e-9


class Rover:
    """One autopilot."""

    def __init__(self, mavlink: Any, now_ns: int, senses: Senses, *, sysid: int = 1, running_s: float = 0.0) -> None:
        """Args: mavlink: dialect module; running_s: for how long it has been switched on."""
        self.mavlink = mavlink
        self.parameters: dict[str, float] = {**DEFAULTS, "MAV_SYSID": float(sysid)}
        self.sysid = sysid
        self.outbox: deque[tuple[Hashable | None, Any]] = deque()  # (peer, message); None: to all
        self.streams = Streams()
        self.uploads = Uploads(mavlink, lambda peer, message: self.outbox.append((peer, message)))
        self.now_ns, self.senses = now_ns, senses
        self.dropped = 0  # set-points that nothing came of
        self._start(now_ns - int(running_s / NS))
        if running_s > BOOT_S:
            self.mode = int(self.parameters["INITIAL_MODE"])

    def _start(self, at_ns: int) -> None:
        """Power comes on."""
        self.booted_ns = at_ns
        self.mode, self.armed, self.critical = INITIALISING, False, False
        self.aim: Aim | None = None
        self._aimed_ns = 0
        self._loops = Loops()
        self._station = (0.0, 0.0)
        self._gcs_ns = 0
        self._gcs_lost = self._estimator_lost = False
        self._fix_ns = 0 if at_ns + READY_S / NS > self.now_ns else self.now_ns
        self._checks_ns = 0
        self._frozen = self.senses
        self._shown = self.senses
        self._text_id = 0
        self.streams.forget()

    # -- what it knows ---------------------------------------------------------------------------------------------
    @property
    def age_s(self) -> float:
        """Since it was switched on [s]."""
        return (self.now_ns - self.booted_ns) * NS

    @property
    def flags(self) -> int:
        """Of EKF_STATUS_REPORT."""
        if self.age_s < READY_S:
            return COLD_FLAGS if self.age_s < BOOT_S else 0 if self.age_s < ESTIMATE_S else CONSTANT_FLAGS
        lost_s = self._without_fix_s
        if lost_s < VARIANCE_S:
            return READY_FLAGS
        return LOSING_FLAGS if lost_s < VARIANCE_S + SURE_S else CONSTANT_FLAGS

    @property
    def _without_fix_s(self) -> float:
        return (self.now_ns - self._fix_ns) * NS if self._fix_ns else math.inf

    @property
    def positioned(self) -> bool:
        """Whether its estimator has a position."""
        return self.flags == READY_FLAGS

    @property
    def shown(self) -> Senses | None:
        """What it sends as its position: none before the first, and after a loss what it was then."""
        return self._shown if self.age_s >= READY_S else None

    def unfit(self, mode: int) -> str:
        """Why it does not arm in a mode, in its own words."""
        if mode == INITIALISING or self.age_s < ARMABLE_S:
            return "Arm: AHRS: not using configured AHRS type"
        if mode in NOT_ARMABLE:
            return "Arm: Mode not armable"
        if mode in NEEDS_POSITION and not self.positioned:
            return "Arm: Need Position Estimate"
        return ""

    # -- time ------------------------------------------------------------------------------------------------------
    def step(self, now_ns: int, senses: Senses) -> Thrust:
        """So late it is, and so the boat moves: what the hull is told."""
        dt, self.now_ns, self.senses = (now_ns - self.now_ns) * NS, now_ns, senses
        if senses.fix and self.age_s >= READY_S - 1.0:
            self._fix_ns = now_ns
        self._estimate(dt)
        if self.mode == INITIALISING and self.age_s >= BOOT_S:
            self._enter(int(self.parameters["INITIAL_MODE"]))
            self.say(INFO, "ArduRover V4.7.0-dev (simulated by fleet)")
        self._watch()
        self.uploads.step(now_ns)
        return self._drive(dt)

    def _estimate(self, dt: float) -> None:
        """What it believes: without a fix the velocity stays, and the position runs on with it until it gives up."""
        if self._without_fix_s == 0.0:
            self._shown = self.senses
        elif self.flags == READY_FLAGS:
            s = self._shown
            lat = s.lat_deg + dt * s.v_north_mps / METRES_A_DEGREE
            lon = s.lon_deg + dt * s.v_east_mps / (METRES_A_DEGREE * math.cos(math.radians(lat)))
            self._shown = Senses(
                lat, lon, self.senses.psi_rad, s.v_north_mps, s.v_east_mps, self.senses.r_radps, s.u_mps, False
            )

    def _watch(self) -> None:
        """Failsafes."""
        p, lost = self.parameters, False
        if p["FS_GCS_ENABLE"] and self._gcs_ns:
            lost = (self.now_ns - self._gcs_ns) * NS > p["FS_GCS_TIMEOUT"] + p["FS_TIMEOUT"]
        if lost and not self._gcs_lost and self.armed:
            self.say(ALERT, "Radio Failsafe")
            self._fail({2: HOLD, 6: LOITER if self.positioned else HOLD}.get(int(p["FS_ACTION"])))
        self._gcs_lost = lost and self.armed
        variance = not self.positioned and self.age_s > READY_S
        if variance and not self._estimator_lost and self.armed and self.mode in NEEDS_POSITION:
            self.say(ALERT, "EKF variance")
            self.say(ALERT, "EKF failsafe")
            self._fail(HOLD if p["FS_EKF_ACTION"] == 1 else None)
        self._estimator_lost = variance
        self.critical = self._gcs_lost or (variance and self.armed)
        if not self.armed and self.unfit(self.mode) and (self.now_ns - self._checks_ns) * NS > CHECKS_SAID_S:
            self._checks_ns = self.now_ns
            self.say(ALERT, "Pre" + self.unfit(self.mode))

    def _fail(self, mode: int | None) -> None:
        if mode is not None:
            self._enter(mode)
            self.critical = True
            self.beat()

    def _enter(self, mode: int) -> None:
        self.mode, self.aim, self._aimed_ns = mode, None, self.now_ns
        self._loops.reset()
        self._station = (self._shown.lat_deg, self._shown.lon_deg)

    def _drive(self, dt: float) -> Thrust:
        if not self.armed:
            return Thrust()
        s, p = self._shown, self.parameters
        if self.mode == GUIDED:
            if self.aim is not None and (self.now_ns - self._aimed_ns) * NS > TARGET_S:
                self.aim = None
                self.say(4, "target not received last 3secs, stopping")
            turn_max = math.radians(p["ATC_STR_RAT_MAX"])
            asked = steer(self.aim or Aim(), self.senses.psi_rad, p["WP_SPEED"], turn_max)
        elif self.mode == LOITER:
            lat, lon = self._station
            dx = (lat - s.lat_deg) * METRES_A_DEGREE
            dy = (lon - s.lon_deg) * METRES_A_DEGREE * math.cos(math.radians(lat))
            asked = stay(dx, dy, self.senses.psi_rad, p["LOIT_RADIUS"])
        else:
            self._loops.reset()
            return Thrust()
        believed = s.v_north_mps * math.cos(s.psi_rad) + s.v_east_mps * math.sin(s.psi_rad)
        return Thrust(True, *self._loops.ask(*asked, believed, self.senses.r_radps, dt))

    # -- people and accidents --------------------------------------------------------------------------------------
    def pilot(self, mode: int) -> None:
        """A pilot turns the mode switch of the transmitter."""
        self._enter(mode)
        self.beat()

    def reboot(self) -> None:
        """It starts anew."""
        self._start(self.now_ns)

    def say(self, severity: int, text: str) -> None:
        """A STATUSTEXT, in pieces where it is long."""
        make = self.mavlink.MAVLink_statustext_message
        if len(text) <= 50:
            self.outbox.append((None, make(severity, text.encode(), 0, 0)))
            return
        self._text_id += 1
        for k in range(0, len(text), 50):
            self.outbox.append((None, make(severity, text[k : k + 50].encode(), self._text_id, k // 50)))

    def beat(self) -> None:
        """A HEARTBEAT to all, now."""
        self.outbox.append((None, self.heartbeat()))

    def heartbeat(self) -> Any:
        """What it is and does."""
        status = 2 if self.mode == INITIALISING else 5 if self.critical else 3 if self.mode == HOLD else 4
        base = words.CUSTOM_MODE | (words.ARMED if self.armed else 0)
        return self.mavlink.MAVLink_heartbeat_message(words.SURFACE_BOAT, words.ARDUPILOT, base, self.mode, status, 3)

    # -- what is said to it ----------------------------------------------------------------------------------------
    def hear(self, peer: Hashable, message: Any) -> None:
        """A message from a peer."""
        kind = message.get_type()
        self.streams.know(peer)
        if kind == "HEARTBEAT":
            if message.get_srcSystem() == self.parameters["MAV_GCS_SYSID"]:
                self._gcs_ns = self.now_ns
            return
        if getattr(message, "target_system", self.sysid) not in (0, self.sysid):
            return
        if kind == "SET_POSITION_TARGET_LOCAL_NED":
            self._setpoint(message)
        elif kind == "COMMAND_LONG":
            result = self._command(peer, message)
            source = (message.get_srcSystem(), message.get_srcComponent())
            ack = self.mavlink.MAVLink_command_ack_message(message.command, result, 0, 0, *source)
            self.outbox.append((peer, ack))
        elif kind in UPLOADS:
            self.uploads.hear(peer, message, self.now_ns)
        elif kind == "PARAM_SET" and message.param_id in self.parameters:
            self.parameters[message.param_id] = message.param_value  # unchecked, as Rover does
            self._tell(peer, message.param_id)
        elif kind == "PARAM_REQUEST_READ":
            names = list(self.parameters)
            by_number = names[message.param_index] if 0 <= message.param_index < len(names) else ""
            name = message.param_id if message.param_index < 0 else by_number
            if name in self.parameters:
                self._tell(peer, name)
        elif kind == "PARAM_REQUEST_LIST":
            for number, name in enumerate(self.parameters):
                self._tell(peer, name, number)

    def _tell(self, peer: Hashable, name: str, number: int = 65535) -> None:
        value, count = float(self.parameters[name]), len(self.parameters)
        told = self.mavlink.MAVLink_param_value_message(name.encode(), value, 9, count, number)
        self.outbox.append((peer, told))

    def _setpoint(self, m: Any) -> None:
        if self.mode != GUIDED or not self.armed:
            self.dropped += 1
            return
        try:
            self.aim = aim_of(m.coordinate_frame, m.type_mask, m.vx, m.vy, m.yaw, m.yaw_rate)
            self._aimed_ns = self.now_ns
        except Refused as refusal:
            self.dropped += 1
            if str(refusal):
                self.say(4, str(refusal))

    def _command(self, peer: Hashable, m: Any) -> int:
        if m.command == words.DO_SET_MODE:
            return self._set_mode(int(m.param2))
        if m.command == words.ARM_DISARM:
            return self._arm(m.param1 == 1.0)
        if m.command == words.SET_MESSAGE_INTERVAL:
            fastest = MOST_HZ_SHARE * self.parameters["SCHED_LOOP_RATE"]
            return self.streams.ask(peer, int(m.param1), m.param2, fastest)
        if m.command == REBOOT:
            if self.armed:
                return words.FAILED
            self.reboot()
            return words.ACCEPTED
        return words.UNSUPPORTED

    def _set_mode(self, mode: int) -> int:
        if self.mode == INITIALISING:
            return words.ACCEPTED  # and forgotten
        if mode not in words.MODES or mode in (INITIALISING, AUTO):
            return words.FAILED  # AUTO: there is no mission
        if self.armed and mode in NEEDS_POSITION and not self.positioned:
            return words.FAILED
        if mode != self.mode:
            self._enter(mode)
            self.beat()
        return words.ACCEPTED

    def _arm(self, armed: bool) -> int:
        if armed:
            why = self.unfit(self.mode)
            if why:
                self.say(ALERT, why)
                return words.FAILED
        if armed != self.armed:
            self.armed = armed
            self._enter(self.mode)
            self.say(INFO, "Throttle armed" if armed else "Throttle disarmed")
            self.beat()
        return words.ACCEPTED
