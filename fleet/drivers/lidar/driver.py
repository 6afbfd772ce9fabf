"""A SCIP scanner as a sensor beside the driver: a thread of its own talks to it, and leaves scans for the tick."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable

from fleet.drivers.lidar.config import LidarOptions
from fleet.drivers.lidar.link import Link, LinkLost, scanner_at
from fleet.drivers.lidar.session import Session
from fleet.drivers.seam import Observed
from fleet.drivers.sensors.config import SensorConfig
from fleet.errors import ConfigError
from fleet.sensing.scan import Scan

log = logging.getLogger("fleet.lidar")
KEPT = 8  # scans that wait for a tick; older ones are dropped
AGAIN_S = 1.0  # a lost scanner is tried again so often
FAREWELL_S = 0.5  # its answer to "stop" is waited for so long
BYE = b"QT\n"


class Lidar:
    """See `fleet.drivers.seam.Sensor`."""

    gives = frozenset({"scan"})

    def __init__(self, config: SensorConfig, now_ns: Callable[[], int]) -> None:
        where = f"driver.sensors, {config.called}: endpoint"
        if not config.endpoint:
            raise ConfigError(f"{where}: missing; expected where the scanner is, such as tcp:192.168.0.10")
        self._options = config.options_as(LidarOptions)
        if self._options.from_deg >= self._options.to_deg:
            raise ConfigError(
                f"driver.sensors, {config.called}: options.from_deg = {self._options.from_deg:g}: "
                f"expected less than to_deg = {self._options.to_deg:g}"
            )
        self._link = Link(scanner_at(config.endpoint, config.called))
        self._endpoint, self._name, self._now_ns = config.endpoint, config.called, now_ns
        self._silent_ns = round(config.silent_s * 1e9)
        self._delay_ns = round(config.delay_s * 1e9)
        self._scans: deque[Scan] = deque(maxlen=KEPT)
        self._heard_ns = 0
        self._why = ""  # there is nothing, as the thread knows it
        self._reset = False
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="lidar", daemon=True)
        self.session: Session | None = None
        self.connected = 0  # how often

    def open(self) -> None:
        """Listen from now on; a scanner that is absent is tried again."""
        import numpy  # noqa: F401 - before the first tick, and not in it

        self._heard_ns = self._now_ns()
        self._thread.start()

    def read(self, now_ns: int) -> Observed:
        """Scans since the last call."""
        scans: list[Scan] = []
        while self._scans:
            scans.append(self._scans.popleft())
        if scans:
            self._heard_ns = now_ns
        silent = now_ns - self._heard_ns > self._silent_ns
        return Observed(scans=tuple(scans), trouble=(self._why or "no scans") if silent else "")

    def close(self) -> None:
        """Laser off, disconnect."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(FAREWELL_S + 3.0)

    # -- the thread --------------------------------------------------------------------------------------------------
    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                self._link.open()
                self.connected += 1
                self._talk()
            except LinkLost as lost:
                self._amiss(f"{self._endpoint}: {lost}")
            except Exception as error:
                log.exception("lidar", extra={"event": "lidar"})
                self._amiss(f"{type(error).__name__}: {error}")
            finally:
                self._link.close()
            self._stop.wait(AGAIN_S)

    def _talk(self) -> None:
        """One connection, until it fails or the agent ends."""
        session = self.session = Session(self._options, self._name, reset=self._reset)
        self._link.send(session.begin(self._now_ns(), time.monotonic()))
        told = False
        while not self._stop.is_set():
            chunk = self._link.receive()
            now_ns, wall_s = self._now_ns(), time.monotonic()
            scans, answer = session.take(chunk, now_ns, wall_s) if chunk else ([], b"")
            answer += session.due(now_ns, wall_s)
            self._scans.extend(scans)
            if answer and not session.failed:
                self._link.send(answer)
            if scans and not told:
                told = True
                self._well(session)
            self._why = session.says or (self._why if not scans else "")
            if session.failed:
                self._reset = session.hardware
                self._amiss(f"the scanner at {self._endpoint} {session.failed}")
                break
        self._farewell()

    def _farewell(self) -> None:
        """Laser off: said, and its answer waited for, so that it is not lost with the connection."""
        try:
            self._link.send(BYE)
            until_s = time.monotonic() + FAREWELL_S
            heard = b""
            while time.monotonic() < until_s and b"QT\n00P" not in heard:
                heard = (heard + self._link.receive())[-65536:]
        except LinkLost:
            return

    def _well(self, session: Session) -> None:
        model = session.model
        assert model is not None
        self._why, self._reset = "", False
        name = session.version.get("PROD", model.name)
        words = f"{self._name}: {name}, {session.version.get('FIRM', '')}, {model.rpm / 60:g} turns a second"
        log.info(words, extra={"event": "lidar"})

    def _amiss(self, why: str) -> None:
        if why != self._why:
            log.warning("%s: %s", self._name, why, extra={"event": "lidar"})
        self._why = why
