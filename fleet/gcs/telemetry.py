"""What is sent of a boat by itself, and how often. Pure: a boat as it is shown in, the fields of messages out."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from msgspec import Struct

from fleet.agent.modes import Mode
from fleet.drivers.mavlink import words
from fleet.gcs import display
from fleet.gcs import numbers as n
from fleet.gcs.voice import Values
from fleet.mission.model import Geographic
from fleet.wire.messages import BoatState, BoatStatus

RATES: dict[int, float] = {  # message -> Hz; HEARTBEAT is apart: it goes out on every change too
    n.GLOBAL_POSITION_INT: 4.0,
    n.ATTITUDE: 4.0,
    n.VFR_HUD: 2.0,
    n.SYS_STATUS: 1.0,
    n.BATTERY_STATUS: 1.0,
    n.GPS_RAW_INT: 1.0,
    n.EKF_STATUS_REPORT: 1.0,
    n.MISSION_CURRENT: 1.0,
    n.HOME_POSITION: 0.5,
}
SENSORS = 0x2 | 0x4 | 0x20 | 0x200000  # gyroscope, compass, GNSS, estimator
EKF_GOOD, EKF_LOST = 0x33F, 0xA7
UNKNOWN = 65535
NO_CELLS = (UNKNOWN,) * 10
ENDED, UNDER_WAY, WAITS = 5, 3, 2  # mission_state: complete, active, not started
DEG = 180.0 / math.pi


class Shown(Struct):
    """One boat as it is told to ground stations."""

    state: BoatState
    status: BoatStatus | None = None
    mode: int = 4
    armed: bool = False
    home: Geographic | None = None
    item: int = 0  # that it sails to
    items: int = 0
    autopilot: int = words.ARDUPILOT


def _heartbeat(s: Shown) -> Values:
    """What it is and does."""
    base = display.base_mode(s.mode, s.armed)
    kind, status = words.SURFACE_BOAT, display.system_status(s.state)
    return kind, s.autopilot, base, s.mode, status, 3


def _boot_ms(state: BoatState) -> int:
    """Since its agent was started [ms]."""
    return max(0, (state.stamp_ns - state.epoch) // 1_000_000) & 0xFFFFFFFF


def _place(state: BoatState) -> tuple[int, int]:
    return round(state.lat_deg * 1e7), round(state.lon_deg * 1e7)


def _degrees(angle_rad: float) -> float:
    """In [0, 360)."""
    return (angle_rad * DEG) % 360.0


def _percent(s: Shown) -> int:
    battery = s.status.battery_percent if s.status is not None else math.nan
    return round(battery) if 0.0 <= battery <= 100.0 else -1


def _position(s: Shown) -> Values:
    st = s.state
    speed = min(st.sog_mps, 300.0) * 100.0
    velocity = (round(speed * math.cos(st.cog_rad)), round(speed * math.sin(st.cog_rad)), 0)
    heading = round(_degrees(st.heading_rad) * 100.0) % 36000
    return _boot_ms(st), *_place(st), 0, 0, *velocity, heading


def _attitude(s: Shown) -> Values:
    st = s.state
    psi = math.remainder(st.heading_rad, math.tau)
    return _boot_ms(st), 0.0, 0.0, psi, 0.0, 0.0, st.yaw_rate_radps


def _hud(s: Shown) -> Values:
    st = s.state
    most = max(st.plan_speed_mps, abs(st.decided_speed_mps), 0.1)
    throttle = round(100.0 * min(abs(st.decided_speed_mps) / most, 1.0)) if s.armed else 0
    heading = round(_degrees(st.heading_rad)) % 360
    return st.sog_mps, st.sog_mps, heading, throttle, 0.0, 0.0


def _sys_status(s: Shown) -> Values:
    has = SENSORS | words.PRE_ARM
    good = SENSORS if display.sound(s.state) else SENSORS & ~0x200020
    if not s.state.stops and not display.why_not_ready(s.state):
        good |= words.PRE_ARM
    return has, has, good, 0, UNKNOWN, -1, _percent(s), 0, 0, 0, 0, 0, 0


def _battery(s: Shown) -> Values:
    return 0, 0, 0, 32767, *NO_CELLS, -1, -1, -1, _percent(s)


def _fix(s: Shown) -> Values:
    st = s.state
    fix = 3 if display.sound(st) else 1
    error_mm = min(max(1, round(st.position_error_m * 1e3)), 2**32 - 1)
    course, speed = round(_degrees(st.cog_rad) * 100.0) % 36000, round(min(st.sog_mps, 300.0) * 100.0)
    dilution = (UNKNOWN, UNKNOWN)
    return _boot_ms(st) * 1000, fix, *_place(st), 0, *dilution, speed, course, 255, 0, error_mm, error_mm, 0


def _estimator(s: Shown) -> Values:
    flags = EKF_GOOD if display.sound(s.state) else EKF_LOST
    return flags, 0.0, 0.0, 0.0, 0.0, 0.0


def _mission(s: Shown) -> Values:
    going = s.state.mode in (Mode.FOLLOW, Mode.AVOID, Mode.ALONE)
    state = UNDER_WAY if going else WAITS if s.items else 1
    return min(s.item, UNKNOWN), min(s.items, UNKNOWN), state


def _home(s: Shown) -> Values:
    home = s.home
    lat, lon = (round(home.lat_deg * 1e7), round(home.lon_deg * 1e7)) if home is not None else _place(s.state)
    return lat, lon, 0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


def _version(s: Shown) -> Values:
    del s
    capable = n.MAVLINK2 | n.MISSION_INT | n.COMMAND_INT | n.PARAM_FLOAT
    return capable, 4 << 24 | 6 << 16 | 255  # 4.6.0 official: what stations take as their dialect of modes


MAKERS: dict[int, Callable[[Shown], Values]] = {
    n.HEARTBEAT: _heartbeat,
    n.GLOBAL_POSITION_INT: _position,
    n.ATTITUDE: _attitude,
    n.VFR_HUD: _hud,
    n.SYS_STATUS: _sys_status,
    n.BATTERY_STATUS: _battery,
    n.GPS_RAW_INT: _fix,
    n.EKF_STATUS_REPORT: _estimator,
    n.MISSION_CURRENT: _mission,
    n.HOME_POSITION: _home,
    n.AUTOPILOT_VERSION: _version,
}
"""Fields of every message that can be asked for by its number."""


def pieces(mavlink: Any, severity: int, text: str, number: int) -> list[Any]:
    """A STATUSTEXT, in pieces of 50 characters where it is longer; number: of this text, 1 to 65535."""
    plain = "".join(c if " " <= c <= "~" else "?" for c in text)[:400]
    make = mavlink.MAVLink_statustext_message
    if len(plain) <= 50:
        return [make(severity, plain.encode(), 0, 0)]
    cut = [plain[k : k + 50].encode() for k in range(0, len(plain), 50)]
    if len(plain) % 50 == 0:
        cut.append(b"")  # a piece that is not full is the last one
    return [make(severity, piece, number, k) for k, piece in enumerate(cut)]
