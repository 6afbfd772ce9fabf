"""The `can` driver: a thread of its own takes frames from python-can's bus, and sends what the helm hands out."""

from __future__ import annotations

import contextlib
import logging
import math
import threading
import time
from collections.abc import Callable
from typing import Any

from fleet.drivers.can.config import CanConfig
from fleet.drivers.can.frames import Frame, Frames
from fleet.drivers.can.helm import Helm
from fleet.drivers.seam import Reading
from fleet.errors import ConfigError

log = logging.getLogger("fleet.can")
LISTEN_S = 0.02  # a frame is waited for so long; a farewell goes out as soon
STALLED_S = 0.5  # a thread that was away for so long finds old frames
AGAIN_S = 1.0  # a lost bus is opened again so often
BUS_OFF = 0x40  # of SocketCAN's error frames
MOST_ERRORS = 5  # one after the other, and the bus is taken for lost
SEND_S = 0.05


def must_have_libraries() -> None:
    """ConfigError where python-can and cantools are not installed."""
    try:
        import can  # noqa: F401
        import cantools  # noqa: F401
    except ImportError as error:
        raise ConfigError(
            f"driver can needs {error.name}, which is not installed; pip install 'fleet-usv[can]'"
        ) from None


def connect(config: CanConfig) -> Any:
    """python-can's bus; ConfigError where such a bus cannot be."""
    import can
    from can.interfaces import VALID_INTERFACES

    if config.interface not in VALID_INTERFACES:
        known = ", ".join(sorted(VALID_INTERFACES))
        raise ConfigError(f"driver.can.interface {config.interface!r}: no such interface; expected one of {known}")
    try:
        options: dict[str, Any] = {**config.options}
        return can.Bus(interface=config.interface, channel=config.channel, **options)
    except (can.CanError, OSError, ValueError, TypeError, ImportError, NotImplementedError) as error:
        raise ConfigError(
            f"driver.can.channel {config.channel!r}: {config.interface} cannot open it: {error}"
        ) from None


def _must_fit(config: CanConfig, frames: Frames) -> None:
    thrusters = config.thrusters
    for key in ("rear_ahead_n", "rear_astern_n", "side_ahead_n", "side_astern_n"):
        value = getattr(thrusters, key)
        if value > frames.thrust_most_n:
            raise ConfigError(
                f"driver.can.thrusters.{key} = {value:g}: expected at most {frames.thrust_most_n:g}, "
                "what a Thrust frame carries"
            )


class CanDriver:
    """See `fleet.drivers.seam.Driver`."""

    def __init__(
        self, config: CanConfig, now_ns: Callable[[], int], *, simulated: bool = False, warp: float = 1.0
    ) -> None:
        self.simulated = simulated
        self._config, self._now_ns = config, now_ns
        self._warp = warp
        self._helm: Helm | None = None
        self._lock = threading.Lock()
        self._bus: Any = None
        self._bus_trouble = ""
        self._errors = self._unsent = 0
        self._listened_s = math.inf
        self.reopened = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="can", daemon=True)

    def open(self) -> None:
        """Read the DBC, connect, listen."""
        must_have_libraries()
        frames = Frames(self._config.dbc)
        _must_fit(self._config, frames)
        self._helm = Helm(self._config, frames, warp=self._warp)
        self._bus = connect(self._config)
        self._thread.start()

    @property
    def helm(self) -> Helm:
        """What it knows; only after `open`."""
        assert self._helm is not None
        return self._helm

    def read(self) -> Reading:
        """The newest reading."""
        with self._lock:
            now_ns = self._now_ns()
            reading = self.helm.reading(now_ns)
        if not self._bus_trouble:
            return reading
        from msgspec.structs import replace

        return replace(reading, trouble=self._bus_trouble)

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command the boat; the next navigation set carries it to the thrusters."""
        with self._lock:
            return self._bus_trouble or self.helm.command(self._now_ns(), surge_mps, yaw_rate_radps)

    def moves(self, stamp_ns: int, surge_mps: float, yaw_rate_radps: float) -> None:
        """How the boat moves, for a controller without sensors."""
        with self._lock:
            self.helm.moves(stamp_ns, surge_mps, yaw_rate_radps)

    def neutral(self) -> None:
        """No thrust."""
        with self._lock:
            self.helm.neutral()

    def close(self) -> None:
        """Leave the boat in neutral and disconnect."""
        if self._helm is None:
            return
        self.neutral()
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(2.0)
        self._leave()

    # -- the thread ------------------------------------------------------------------------------------------------
    def _run(self) -> None:
        while not self._stop.is_set():
            if self._bus is None:
                self._reopen()
                continue
            try:
                message = self._listen()
                if message is not None:
                    self._errors = 0
                    self._take(message)
                else:
                    self._say_farewell()
            except Exception as error:  # noqa: BLE001 - whatever an adapter's library raises, this thread must go on
                self._errors += 1
                if max(self._errors, self._unsent) >= MOST_ERRORS:
                    self._lose(f"CAN bus: {error}")

    def _listen(self) -> Any:
        """The next message, or None; what queued while the process was stopped is old, and thrown away."""
        message = self._bus.recv(LISTEN_S)
        now_s = time.monotonic()
        if now_s - self._listened_s > STALLED_S:
            while message is not None:
                message = self._bus.recv(0.0)
        self._listened_s = now_s
        return message

    def _take(self, message: Any) -> None:
        if message.is_error_frame:
            if message.arbitration_id & BUS_OFF:
                self._lose("CAN bus off")
            return
        plain = not (message.is_extended_id or message.is_remote_frame or message.is_fd)
        with self._lock:
            frames = self.helm.take(self._now_ns(), message.arbitration_id, bytes(message.data), plain=plain)
        self._send(frames)

    def _say_farewell(self) -> None:
        with self._lock:
            if self.helm.commanded:
                return
            frames = self.helm.farewell()
        self._send(frames)

    def _send(self, frames: list[Frame]) -> None:
        from can import Message

        try:
            for identifier, payload in frames:
                self._bus.send(Message(arbitration_id=identifier, data=payload, is_extended_id=False), SEND_S)
        except Exception:
            self._unsent += 1  # frames that still come in between do not make up for it
            raise
        self._unsent = 0 if frames else self._unsent

    def _lose(self, why: str) -> None:
        """Let go of a bus that does not work; the controller's watchdog stops the boat."""
        log.error(why, extra={"event": "can-lost"})
        with self._lock:
            self._bus_trouble = why
            self.helm.forget()
        self._shut()

    def _reopen(self) -> None:
        self._stop.wait(AGAIN_S / self._warp)
        if self._stop.is_set():
            return
        try:
            self._bus = connect(self._config)
        except ConfigError as error:
            with self._lock:
                self._bus_trouble = str(error)
            return
        self._errors = self._unsent = 0
        self._listened_s = math.inf
        log.warning("the CAN bus is open again", extra={"event": "can-again"})
        with self._lock:
            self._bus_trouble = ""
        self.reopened += 1

    def _leave(self) -> None:
        try:
            if self._bus is not None:
                self._send(self.helm.farewell())
        except Exception as error:  # noqa: BLE001 - the controller's watchdog stops the boat without it
            log.warning("no farewell on the CAN bus: %s", error)
        self._shut()

    def _shut(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            with contextlib.suppress(Exception):  # it is given up in any case
                bus.shutdown()
