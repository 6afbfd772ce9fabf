"""What an autopilot's messages say about its boat, and what of it can be believed. Times are handed in.

Position and velocity are good only while the estimator says so, while they are fresh, and while they agree with each
other: an autopilot goes on sending them, at 0, 0 before a fix and frozen after the loss of one.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from typing import Any

from fleet import ops
from fleet.drivers.mavlink import words
from fleet.drivers.mavlink.gate import Gate
from fleet.drivers.seam import Reading

METRES_A_DEGREE = 111_195.0  # of latitude
FASTEST_MPS = 30.0
POSITION_S = 1.0  # a position, an attitude older than that says nothing
ESTIMATOR_S = 2.5  # so, the estimator's report
GNSS_S = 1.0  # without a fix, where there was one: the estimator notices 8 s later
FROZEN_S, FROZEN_MPS = 1.5, 0.3  # a boat that moves changes its position
SILENT_S = 3.0  # without a HEARTBEAT, of which one comes a second
REBOOT_MS, REBOOT_TIMES = 1000, 3  # the time since boot has gone back by so much, in so many messages in a row
AHEAD_S, AHEAD_TIMES = 0.2, 5  # a message from the future is believed when so many in a row are
LEAK = 2e-4  # two clocks drift apart by no more
GNSS_ERROR_M = 2.0  # 1 sigma, where the receiver does not say
MOST_TEXTS = 32
REFUSALS = ("Arm:", "PreArm:")
REFUSAL_S = 35.0  # the checks before arming are said again every 30 s
NS = 1e-9


class Vehicle:
    """The boat as its autopilot tells it."""

    def __init__(self) -> None:
        self.heard_ns = 0  # last HEARTBEAT
        self.mode = -1
        self.armed = False
        self.critical = False
        self.ready = False  # the checks before arming are good, in the mode that it is in
        self.reboots = 0
        self.texts: deque[tuple[int, str]] = deque(maxlen=MOST_TEXTS)  # (severity, text), to be told
        self.refusal = ""
        self.seen_ns: dict[int, int] = {}  # message -> when it arrived last
        self.received: Counter[int] = Counter()  # messages of each number
        self.counts: Counter[str] = Counter()  # values refused
        self.kind = self.autopilot = -1  # MAV_TYPE and MAV_AUTOPILOT
        self._refusal_ns = 0
        self._parts: dict[int, dict[int, str]] = {}  # long texts
        self._offset_ns: float | None = None  # own clock less the autopilot's time since boot
        self._offset_at_ns = 0
        self._boot_ms = self._backwards = self._ahead = 0
        self._flags = 0
        self._fixed = False  # there was a fix
        self._fix_ns = 0
        self._error_m = GNSS_ERROR_M
        self._battery = math.nan
        self._fresh()

    def _fresh(self) -> None:
        """Nothing is known of where the boat is."""
        self._position_ns = self._moved_ns = self._attitude_ns = 0
        self._lat = self._lon = self._vn = self._ve = self._psi = self._r = math.nan
        self._place, self._motion = Gate(5.0, 10.0, agree=10), Gate(3.0, 5.0)
        self._turning = Gate(0.5, 4.0)

    # -- hearing ---------------------------------------------------------------------------------------------------
    def take(self, message: Any, now_ns: int) -> None:
        """What a message says."""
        number: int = message.get_msgId()
        if number == words.GLOBAL_POSITION_INT:
            self._take_position(message, now_ns)
        elif number == words.ATTITUDE:
            self._take_attitude(message, now_ns)
        elif number == words.HEARTBEAT:
            self._take_heartbeat(message, now_ns)
        elif number == words.EKF_STATUS_REPORT:
            self._flags = message.flags
        elif number == words.GPS_RAW_INT:
            self._take_fix(message, now_ns)
        elif number == words.SYS_STATUS:
            checked = message.onboard_control_sensors_present & message.onboard_control_sensors_enabled
            self.ready = bool(checked & message.onboard_control_sensors_health & words.PRE_ARM)
            self._battery = float(message.battery_remaining) if 0 <= message.battery_remaining <= 100 else math.nan
        elif number == words.STATUSTEXT:
            self._take_text(message, now_ns)
        self.seen_ns[number] = now_ns
        self.received[number] += 1

    def _take_heartbeat(self, message: Any, now_ns: int) -> None:
        if message.autopilot == words.INVALID_AUTOPILOT:
            return  # a camera, a gimbal
        self.heard_ns, self.mode = now_ns, message.custom_mode
        self.kind, self.autopilot = message.type, message.autopilot
        self.armed = bool(message.base_mode & words.ARMED)
        self.critical = message.system_status == words.CRITICAL
        if self.armed:
            self.refusal = ""

    def _stamp(self, boot_ms: int, now_ns: int) -> int | None:
        """When a message was made, by our clock [ns]: the quickest ones tell how the clocks lie. None: not believed."""
        if boot_ms < self._boot_ms - REBOOT_MS:
            self._backwards += 1
            if self._backwards < REBOOT_TIMES:
                return None
            self._reboot()
        self._backwards = 0
        offset_ns, before_ns = float(now_ns - boot_ms * 1_000_000), self._offset_ns
        if before_ns is not None:
            if offset_ns < before_ns - AHEAD_S / NS:
                self._ahead += 1
                if self._ahead < AHEAD_TIMES:
                    self.counts["time"] += 1
                    return None
                before_ns = offset_ns
            offset_ns = min(offset_ns, before_ns + LEAK * (now_ns - self._offset_at_ns))
        self._ahead = 0
        self._boot_ms, self._offset_ns, self._offset_at_ns = boot_ms, offset_ns, now_ns
        return boot_ms * 1_000_000 + int(offset_ns)

    def _reboot(self) -> None:
        self.reboots += 1
        self._offset_ns, self._fixed, self._flags, self.ready, self._boot_ms = None, False, 0, False, 0
        self.seen_ns.clear()
        self._fresh()

    def _take_position(self, message: Any, now_ns: int) -> None:
        lat, lon = message.lat * 1e-7, message.lon * 1e-7
        vn, ve = message.vx * 0.01, message.vy * 0.01
        if (lat == 0.0 and lon == 0.0) or abs(lat) > 90.0 or abs(lon) > 180.0 or math.hypot(vn, ve) > FASTEST_MPS:
            self.counts["position"] += 1
            return
        stamp_ns = self._stamp(message.time_boot_ms, now_ns)
        if stamp_ns is None or stamp_ns < self._position_ns:
            return
        north = lat * METRES_A_DEGREE
        east = lon * METRES_A_DEGREE * math.cos(math.radians(lat))
        there, moves = self._place.passes((north, east), stamp_ns), self._motion.passes((vn, ve), stamp_ns)
        if not (there and moves):
            self.counts["position"] += 1
            return
        if (lat, lon) != (self._lat, self._lon) or math.hypot(vn, ve) < FROZEN_MPS:
            self._moved_ns = stamp_ns
        self._position_ns, self._lat, self._lon, self._vn, self._ve = stamp_ns, lat, lon, vn, ve

    def _take_attitude(self, message: Any, now_ns: int) -> None:
        psi, r = message.yaw, message.yawspeed
        if not (abs(psi) <= 6.3 and abs(r) <= 10.0):
            self.counts["attitude"] += 1
            return
        stamp_ns = self._stamp(message.time_boot_ms, now_ns)
        if stamp_ns is None or stamp_ns < self._attitude_ns:
            return
        if not self._turning.passes((math.cos(psi), math.sin(psi)), stamp_ns):
            self.counts["attitude"] += 1
            return
        self._attitude_ns, self._psi, self._r = stamp_ns, ops.wrap(psi), r

    def _take_fix(self, message: Any, now_ns: int) -> None:
        if message.fix_type >= 3:
            self._fixed, self._fix_ns = True, now_ns
            h_acc_m = getattr(message, "h_acc", 0) * 1e-3
            self._error_m = h_acc_m if 0.0 < h_acc_m < 100.0 else GNSS_ERROR_M

    def _take_text(self, message: Any, now_ns: int) -> None:
        piece = "".join(c if " " <= c <= "~" else "?" for c in message.text)
        if message.id:
            parts = self._parts.setdefault(message.id, {})
            parts[message.chunk_seq] = piece
            if len(piece) >= 50 and len(parts) < 8:
                return
            piece = "".join(parts[i] for i in sorted(parts))
            self._parts.clear()
        if piece.startswith(REFUSALS):
            self.refusal, self._refusal_ns = piece, now_ns
        self.texts.append((message.severity, piece))

    # -- asking ----------------------------------------------------------------------------------------------------
    def silent_s(self, now_ns: int) -> float:
        """Since the last HEARTBEAT; inf before the first [s]."""
        return (now_ns - self.heard_ns) * NS if self.heard_ns else math.inf

    def why_not_ready(self, now_ns: int) -> str:
        """What the checks before arming found, in the autopilot's words."""
        fresh = self.refusal and (now_ns - self._refusal_ns) * NS < REFUSAL_S
        return self.refusal if fresh else "its checks before arming are not good yet"

    def lost(self, now_ns: int) -> str:
        """Why its navigation cannot be used; '' when it can."""

        def age_s(stamp_ns: int) -> float:
            return (now_ns - stamp_ns) * NS if stamp_ns else math.inf

        if age_s(self.seen_ns.get(words.EKF_STATUS_REPORT, 0)) > ESTIMATOR_S:
            return "the estimator does not report"
        bad = self._flags & (words.EKF_CONSTANT | words.EKF_UNINITIALISED)
        if not self._flags & words.EKF_ABSOLUTE or bad:
            return f"the estimator has no position (flags {self._flags:#x})"
        if self._fixed and age_s(self._fix_ns) > GNSS_S:
            return "the GNSS receiver has lost its fix"
        if age_s(self._position_ns) > POSITION_S or age_s(self._attitude_ns) > POSITION_S:
            return "position or attitude is old"
        if (self._position_ns - self._moved_ns) * NS > FROZEN_S:
            return "the position stands still at speed: it is frozen"
        return ""

    def reading(self, now_ns: int) -> Reading:
        """Its navigation, or nothing; authority and trouble are the driver's to say."""
        if self.lost(now_ns):
            return Reading(stamp_ns=now_ns, battery_percent=self._battery)
        between_s = (self._position_ns - self._attitude_ns) * NS
        return Reading(
            stamp_ns=self._position_ns,
            lat_deg=self._lat,
            lon_deg=self._lon,
            heading_rad=ops.wrap(self._psi + self._r * between_s),
            v_north_mps=self._vn,
            v_east_mps=self._ve,
            yaw_rate_radps=self._r,
            position_error_m=self._error_m,
            battery_percent=self._battery,
        )

    @property
    def speed_mps(self) -> float:
        """Over ground, as last believed [m/s]."""
        return math.hypot(self._vn, self._ve)
