"""Frames by the DBC: what agent and thruster controller say to each other, as values and as bytes.

Nothing is believed for being well-formed: every frame has a check sum, a navigation set of three frames has one over
all of them, and counters must have moved.
"""

from __future__ import annotations

import binascii
import math
from importlib import resources
from typing import Any, Literal

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
SPEED_MOST_MPS, YAW_RATE_MOST_RADPS = 15.0, 3.0  # faster is not believed of such a boat
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


class Counts(Struct):
    """What became of every frame."""

    accepted: int = 0
    waiting: int = 0  # Position and Motion, which count only with their NavCheck
    foreign: int = 0  # not for us: other identifiers, extended, remote
    length: int = 0
    check: int = 0  # the check sum is wrong, or a navigation set is not whole
    repeated: int = 0  # its counter has not moved
    implausible: int = 0

    @property
    def refused(self) -> int:
        """Frames for us that were not believed."""
        return self.length + self.check + self.repeated + self.implausible


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


Side = Literal["agent", "controller"]
HEARD: dict[Side, tuple[str, ...]] = {
    "agent": ("Status", "Position", "Motion", "NavCheck", "Battery"),
    "controller": ("Watchdog", "Thrust"),
}


class Decoder:
    """Bytes to values on one side of the bus; whatever comes, it counts and goes on."""

    def __init__(self, frames: Frames, side: Side) -> None:
        self.counts = Counts()
        self._frames = frames
        self._heard = {frames.message(name).frame_id: name for name in HEARD[side]}
        self._lengths = {frames.message(name).frame_id: frames.message(name).length for name in HEARD[side]}
        self._last: dict[str, int] = {}
        self._place = self._moves = b""

    def take(self, identifier: int, payload: bytes, *, plain: bool = True) -> Said | None:
        """What a frame says; None when it says nothing yet, is not for us, or is not believed.

        Args:
            identifier: of 11 bits
            payload: its bytes
            plain: a data frame with an identifier of 11 bits
        """
        name = self._heard.get(identifier) if plain else None
        counts = self.counts
        if name is None:
            counts.foreign += 1
        elif len(payload) != self._lengths[identifier]:
            counts.length += 1
        elif name == "Position":
            self._place = payload
            counts.waiting += 1
        elif name == "Motion":
            self._moves = payload
            counts.waiting += 1
        elif name == "NavCheck":
            return self._navigation(payload)
        elif crc16(identifier, payload[:-CRC_BYTES]) != int.from_bytes(payload[-CRC_BYTES:], "little"):
            counts.check += 1
        else:
            return self._single(name, self._frames.message(name).decode(payload, decode_choices=False))
        return None

    def _single(self, name: str, s: dict[str, Any]) -> Said | None:
        if "Counter" in s and self._repeated(name, s["Counter"]):
            return None
        said: Said | None = None
        if name == "Watchdog":
            said = Watchdog(s["Counter"], s["Run"] == 1)
        elif name == "Thrust":
            said = Thrusts(s["RearPort"], s["RearStarboard"], s["SidePort"], s["SideStarboard"])
        elif name == "Status" and s["Mode"] < len(MODES):
            faults = frozenset(words for signal, words in FAULTS.items() if s[signal])
            said = Status(s["Counter"], s["Mode"], s["RcOverride"] == 1, s["WatchdogSeen"] == 1, faults)
        elif name == "Battery" and (s["Percent"] <= 100 or s["Percent"] == 255):
            percent = math.nan if s["Percent"] == 255 else float(s["Percent"])
            said = Battery(s["Counter"], percent, s["Voltage"], s["Current"])
        return self._count(said)

    def _navigation(self, check: bytes) -> Navigation | None:
        place, moves = self._place, self._moves
        self._place = self._moves = b""
        whole = binascii.crc32(place + moves + check[:4]) == int.from_bytes(check[4:], "little")
        if not (place and moves and whole):
            self.counts.check += 1
            return None
        decoded = {
            **self._decoded("Position", place),
            **self._decoded("Motion", moves),
            **self._decoded("NavCheck", check),
        }
        if self._repeated("NavCheck", decoded["Counter"]):
            return None
        nav = _navigation(decoded)
        self._count(nav if plausible(nav) else None)
        return nav if plausible(nav) else None

    def _decoded(self, name: str, payload: bytes) -> dict[str, Any]:
        decoded: dict[str, Any] = self._frames.message(name).decode(payload, decode_choices=False)
        return decoded

    def _repeated(self, name: str, counter: int) -> bool:
        again = self._last.get(name) == counter
        self._last[name] = counter
        self.counts.repeated += again
        return again

    def _count(self, said: Said | None) -> Said | None:
        if said is None:
            self.counts.implausible += 1
        else:
            self.counts.accepted += 1
        return said


def crc16(identifier: int, payload: bytes) -> int:
    """CRC-16/CCITT with initial value 0xFFFF over identifier and payload, so that no frame passes for another."""
    return binascii.crc_hqx(identifier.to_bytes(2, "big") + payload, 0xFFFF)


def plausible(nav: Navigation) -> bool:
    """A boat can be there, and move like that."""
    at_zero = nav.lat_deg == nav.lon_deg == 0.0
    off_the_globe = abs(nav.lat_deg) > 90.0 or abs(nav.lon_deg) > 180.0
    too_fast = math.hypot(nav.v_north_mps, nav.v_east_mps) > SPEED_MOST_MPS
    spins = abs(nav.yaw_rate_radps) > YAW_RATE_MOST_RADPS or nav.heading_rad > 6.28325
    return not (at_zero or off_the_globe or too_fast or spins) and nav.fix <= FIX_RTK


def _navigation(s: dict[str, Any]) -> Navigation:
    """A 2D fix is none: its height is guessed, and its position is wrong by as much."""
    fixed = s["Fix"] >= FIX_3D
    return Navigation(
        counter=s["Counter"],
        fix=s["Fix"],
        fused=s["Fused"] == 1,
        lat_deg=s["Latitude"] if fixed else math.nan,
        lon_deg=s["Longitude"] if fixed else math.nan,
        heading_rad=s["Heading"] if s["Heading"] < NO_HEADING - 1e-5 else math.nan,
        yaw_rate_radps=s["YawRate"] if s["YawRate"] > NO_RATE + 1e-5 else math.nan,
        v_north_mps=s["VelocityNorth"] if fixed and s["VelocityNorth"] > NO_VELOCITY + 1e-4 else math.nan,
        v_east_mps=s["VelocityEast"] if fixed and s["VelocityEast"] > NO_VELOCITY + 1e-4 else math.nan,
        position_error_m=s["PositionError"],
    )


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
