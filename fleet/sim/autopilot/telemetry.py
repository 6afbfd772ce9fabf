"""What the simulated autopilot sends by itself, to whom, and how often."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator
from typing import TYPE_CHECKING, Any

from fleet.drivers.mavlink import words

if TYPE_CHECKING:
    from fleet.sim.autopilot.rover import Rover

DEFAULT_NS = 1_000_000_000
VFR_HUD = 74
SENT = (
    words.SYS_STATUS,
    words.GPS_RAW_INT,
    words.ATTITUDE,
    words.GLOBAL_POSITION_INT,
    VFR_HUD,
    words.EKF_STATUS_REPORT,
)
SENSORS = 0x2 | 0x4 | 0x20  # gyroscope, accelerometer, GNSS... present and healthy
UNKNOWN = 65535


class Streams:
    """Who wants what how often; a restart forgets it."""

    def __init__(self) -> None:
        self._peers: dict[Hashable, dict[int, list[int]]] = {}  # peer -> message -> [period, next]
        self.beat_ns = 0

    def forget(self) -> None:
        """Every peer gets what peers get by default."""
        for peer in self._peers:
            self._peers[peer] = {message: [DEFAULT_NS, 0] for message in SENT}

    def know(self, peer: Hashable) -> None:
        """A peer speaks; it is sent to from now on."""
        if peer not in self._peers:
            self._peers[peer] = {message: [DEFAULT_NS, 0] for message in SENT}

    @property
    def peers(self) -> tuple[Hashable, ...]:
        """Everybody who ever spoke."""
        return tuple(self._peers)

    def lose(self, peer: Hashable) -> None:
        """A peer's port is closed."""
        self._peers.pop(peer, None)

    def ask(self, peer: Hashable, message: int, interval_us: float, fastest_hz: float) -> int:
        """SET_MESSAGE_INTERVAL: the result; too fast is denied, and the old rate stays."""
        if message not in SENT:
            return words.FAILED
        if interval_us <= 0.0:
            period_ns = DEFAULT_NS if interval_us == 0.0 else 1 << 62
        elif 1e6 / interval_us > fastest_hz + 1e-6:
            return words.DENIED
        else:
            period_ns = int(interval_us * 1000.0)
        self._peers[peer][message] = [period_ns, 0]
        return words.ACCEPTED

    def due(self, now_ns: int) -> Iterator[tuple[Hashable, int]]:
        """(peer, message) to be sent now."""
        for peer, wanted in list(self._peers.items()):
            for message, times in wanted.items():
                if now_ns >= times[1]:
                    times[1] = max(times[1] + times[0], now_ns) if times[1] else now_ns + times[0]
                    yield peer, message


def speak(rover: Rover) -> Iterator[tuple[Hashable, Any]]:
    """(peer, message): everything that is due, and what waited to be said."""
    streams, now_ns = rover.streams, rover.now_ns
    if now_ns - streams.beat_ns >= DEFAULT_NS:
        streams.beat_ns = now_ns
        rover.beat()
    while rover.outbox:
        peer, message = rover.outbox.popleft()
        for one in streams.peers if peer is None else (peer,):
            yield one, message
    made: dict[int, Any] = {}
    for peer, number in streams.due(now_ns):
        if number not in made:
            made[number] = _MAKERS[number](rover)
        yield peer, made[number]


def _boot_ms(rover: Rover) -> int:
    return (rover.now_ns - rover.booted_ns) // 1_000_000


def _sys_status(rover: Rover) -> Any:
    ready = 0 if rover.unfit(rover.mode) else words.PRE_ARM
    there = SENSORS | words.PRE_ARM
    percent = rover.senses.battery_percent
    battery = int(percent) if math.isfinite(percent) else -1
    return rover.mavlink.MAVLink_sys_status_message(
        there, there, SENSORS | ready, 100, 12600, -1, battery, 0, 0, 0, 0, 0, 0
    )


def _gps_raw(rover: Rover) -> Any:
    s = rover.senses
    fixed = s.fix and rover.shown is not None
    lat, lon = (round(s.lat_deg * 1e7), round(s.lon_deg * 1e7)) if fixed else (0, 0)
    error_mm = max(1, round(s.error_m * 1e3))  # 0 means that it is not known
    make = rover.mavlink.MAVLink_gps_raw_int_message
    fix = 3 if fixed else 1
    seen = 12 if fixed else 0
    return make(_boot_ms(rover) * 1000, fix, lat, lon, 0, 80, 120, 0, 0, seen, 0, error_mm, error_mm, 200)


def _attitude(rover: Rover) -> Any:
    s = rover.senses
    return rover.mavlink.MAVLink_attitude_message(_boot_ms(rover), 0.0, 0.0, s.psi_rad, 0.0, 0.0, s.r_radps)


def _position(rover: Rover) -> Any:
    s = rover.shown
    make = rover.mavlink.MAVLink_global_position_int_message
    if s is None:
        return make(_boot_ms(rover), 0, 0, 0, 0, 0, 0, 0, UNKNOWN)
    lat, lon = round(s.lat_deg * 1e7), round(s.lon_deg * 1e7)
    velocity = (round(s.v_north_mps * 100), round(s.v_east_mps * 100), 0)
    heading = round(math.degrees(s.psi_rad) * 100) % 36000
    return make(_boot_ms(rover), lat, lon, 0, 0, *velocity, heading)


def _vfr_hud(rover: Rover) -> Any:
    s = rover.shown
    speed = math.hypot(s.v_north_mps, s.v_east_mps) if s is not None else 0.0
    heading = round(math.degrees(rover.senses.psi_rad)) % 360
    return rover.mavlink.MAVLink_vfr_hud_message(0.0, speed, heading, 0, 0.0, 0.0)


def _estimator(rover: Rover) -> Any:
    return rover.mavlink.MAVLink_ekf_status_report_message(rover.flags, 0.1, 0.1, 0.1, 0.1, 0.0)


_MAKERS = {
    words.SYS_STATUS: _sys_status,
    words.GPS_RAW_INT: _gps_raw,
    words.ATTITUDE: _attitude,
    words.GLOBAL_POSITION_INT: _position,
    VFR_HUD: _vfr_hud,
    words.EKF_STATUS_REPORT: _estimator,
}
