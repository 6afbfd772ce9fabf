"""Frames by the DBC: what agent and thruster controller say to each other, as values and as bytes.

Every frame has a check sum; a navigation set of three frames has one over all of them. Bytes to values: `decoder`.
"""

from __future__ import annotations

import binascii
import math
from importlib import resources
from typing import Any

from msgspec import Struct

from fleet.errors import ConfigError
from fleet.guidance.thrust import Thrusts

NAMES = ("Watchdog", "Thrust", "Status", "Position", "Motion", "NavCheck", "Battery")
OFF, STANDBY, COMMANDED, RC, FAULT = range(5)  # modes of the controller
MODES = ("off", "standby", "commanded", "remote control", "fault")
NO_FIX, FIX_2D, FIX_3D, FIX_RTK = range(4)
FAULTS = {
    "FaultRearPort": "rear port thruster failed",
    "FaultRearStarboard": "rear starboard thruster failed",
    "FaultSidePort": "side port thruster failed",
    "FaultSideStarboard": "side starboard thruster failed",
    "EmergencyStop": "emergency stop pressed",
    "Leak": "water in the hull",
    "OverTemperature": "too hot",
    "LowVoltage": "low voltage",
}
STOPPING = frozenset(tuple(FAULTS.values())[:5])
"""Faults with which a boat cannot be commanded; the others are told, and sailed with."""
NO_HEADING, NO_RATE, NO_VELOCITY = 6.5535, -3.2768, -32.768
CRC_BYTES = 2


class Watchdog(Struct, frozen=True, gc=False):
    """Agent to controller: my commands are fresh."""

    counter: int
    run: bool


class Status(Struct, frozen=True, gc=False):
    """Controller to agent: its heartbeat."""

    counter: int
    mode: int
    rc_override: bool
    watchdog_seen: bool
    faults: frozenset[str] = frozenset()


class Navigation(Struct, frozen=True, gc=False):
    """Controller to agent: a whole navigation set; NaN where not available."""

    counter: int
    fix: int
    fused: bool
    lat_deg: float
    lon_deg: float
    heading_rad: float  # in [0, 2 pi)
    yaw_rate_radps: float
    v_north_mps: float
    v_east_mps: float
    position_error_m: float


class Battery(Struct, frozen=True, gc=False):
    """Controller to agent."""

    counter: int
    percent: float  # NaN: not known
    voltage_v: float
    current_a: float


Said = Watchdog | Thrusts[float] | Status | Navigation | Battery
Frame = tuple[int, bytes]


class Frames:
    """The frames of one DBC."""

    def __init__(self, dbc: str = "") -> None:
        import cantools
        from cantools.database.errors import Error

        where = dbc or "viam.dbc"
        try:
            if dbc:
                database: Any = cantools.database.load_file(dbc)
            else:
                text = resources.files("fleet.drivers.can").joinpath("viam.dbc").read_text(encoding="utf-8")
                database = cantools.database.load_string(text, "dbc")
            self._by_name = {name: database.get_message_by_name(name) for name in NAMES}
        except FileNotFoundError:
            raise ConfigError(f"driver.can.dbc {where!r}: no such file; expected a DBC") from None
        except OSError as error:
            raise ConfigError(f"driver.can.dbc {where!r}: cannot be read: {error.strerror}") from None
        except (Error, UnicodeDecodeError) as error:
            raise ConfigError(f"driver.can.dbc {where!r}: not a DBC: {str(error).splitlines()[0]}") from None
        except KeyError as error:
            raise ConfigError(f"driver.can.dbc {where!r}: no message {error}; expected {', '.join(NAMES)}") from None
        shipped = self if not dbc else Frames()
        for name, message in self._by_name.items():
            if dbc:
                _same_signals(where, name, message, shipped._by_name[name])
        self.name_of = {message.frame_id: name for name, message in self._by_name.items()}

    @property
    def thrust_most_n(self) -> float:
        """The largest thrust, ahead and astern, that its signals can carry."""
        signals = [signal for signal in self._by_name["Thrust"].signals if signal.name != "Crc"]
        return float(min(signal.scale * ((1 << (signal.length - 1)) - 1) for signal in signals))

    def message(self, name: str) -> Any:
        """The message as cantools has it."""
        return self._by_name[name]

    def _checked(self, name: str, **signals: float) -> Frame:
        message = self._by_name[name]
        payload = message.encode({**signals, "Crc": 0}, strict=False)[:-CRC_BYTES]
        return message.frame_id, payload + crc16(message.frame_id, payload).to_bytes(CRC_BYTES, "little")

    def watchdog(self, counter: int, run: bool) -> Frame:
        """Agent to controller; with `run` false the thrusters stop at once."""
        return self._checked("Watchdog", Counter=counter & 255, Run=int(run))

    def thrust(self, thrusts: Thrusts[float]) -> Frame:
        """Agent to controller [N], to a tenth."""
        return self._checked(
            "Thrust",
            RearPort=thrusts.rear_port,
            RearStarboard=thrusts.rear_starboard,
            SidePort=thrusts.side_port,
            SideStarboard=thrusts.side_starboard,
        )

    def status(self, status: Status) -> Frame:
        """Controller to agent."""
        faults = {signal: int(words in status.faults) for signal, words in FAULTS.items()}
        return self._checked(
            "Status",
            Counter=status.counter & 255,
            Mode=status.mode,
            RcOverride=int(status.rc_override),
            WatchdogSeen=int(status.watchdog_seen),
            **faults,
        )

    def battery(self, battery: Battery) -> Frame:
        """Controller to agent."""
        percent = 255 if math.isnan(battery.percent) else round(battery.percent)
        return self._checked(
            "Battery",
            Counter=battery.counter & 255,
            Percent=percent,
            Voltage=battery.voltage_v,
            Current=battery.current_a,
        )

    def navigation(self, nav: Navigation) -> tuple[Frame, Frame, Frame]:
        """Controller to agent: Position, Motion, NavCheck."""
        position, motion, check = (self._by_name[name] for name in ("Position", "Motion", "NavCheck"))
        fixed = math.isfinite(nav.lat_deg + nav.lon_deg)
        place = position.encode(
            {"Latitude": nav.lat_deg if fixed else 0.0, "Longitude": nav.lon_deg if fixed else 0.0}, strict=False
        )
        moves = motion.encode(
            {
                "Heading": _or(nav.heading_rad, NO_HEADING),
                "YawRate": _or(nav.yaw_rate_radps, NO_RATE),
                "VelocityNorth": _or(nav.v_north_mps, NO_VELOCITY),
                "VelocityEast": _or(nav.v_east_mps, NO_VELOCITY),
            },
            strict=False,
        )
        head = check.encode(
            {
                "Counter": nav.counter & 255,
                "Fix": nav.fix if fixed else NO_FIX,
                "Fused": int(nav.fused),
                "PositionError": min(nav.position_error_m, 655.35),
                "Crc": 0,
            },
            strict=False,
        )[:4]
        crc = binascii.crc32(place + moves + head).to_bytes(4, "little")
        return (position.frame_id, place), (motion.frame_id, moves), (check.frame_id, head + crc)


def crc16(identifier: int, payload: bytes) -> int:
    """CRC-16/CCITT with initial value 0xFFFF over identifier and payload, so that no frame passes for another."""
    return binascii.crc_hqx(identifier.to_bytes(2, "big") + payload, 0xFFFF)


def _or(value: float, absent: float) -> float:
    return value if math.isfinite(value) else absent


def _same_signals(where: str, name: str, message: Any, shipped: Any) -> None:
    """Identifiers, bits and scales may be another controller's own; names, lengths and check sums may not."""
    missing = {signal.name for signal in shipped.signals} - {signal.name for signal in message.signals}
    if missing:
        raise ConfigError(f"driver.can.dbc {where!r}: {name} has no signal {', '.join(sorted(missing))}")
    if message.length != shipped.length:
        raise ConfigError(f"driver.can.dbc {where!r}: {name} has {message.length} bytes; expected {shipped.length}")
    if message.is_extended_frame:
        raise ConfigError(f"driver.can.dbc {where!r}: {name} has an extended identifier; expected 11 bits")
