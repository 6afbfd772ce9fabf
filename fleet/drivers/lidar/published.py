"""Scans that somebody else's driver on board publishes, as a sensor beside the driver."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable

from fleet.drivers.lidar.config import ScanOptions
from fleet.drivers.lidar.mount import mounted
from fleet.drivers.seam import Observed
from fleet.drivers.sensors.config import SensorConfig
from fleet.errors import ConfigError
from fleet.sensing.scan import Scan
from fleet.wire import keys
from fleet.wire.bus import Heard
from fleet.wire.codec import Refused
from fleet.wire.scans import decode_scan

log = logging.getLogger("fleet.lidar")
TAKEN = frozenset({keys.STATE, keys.STATUS, keys.ALIVE, keys.EVENT, *keys.ASKED})


class PublishedScans:
    """See `fleet.drivers.seam.Sensor`; `fleet.agent.hardware.Subscribes` gives it what was published."""

    gives = frozenset({"scan"})

    def __init__(self, config: SensorConfig, now_ns: Callable[[], int]) -> None:
        where = f"driver.sensors, {config.called}"
        self._options = config.options_as(ScanOptions)
        self.key = self._options.key
        if config.endpoint:
            raise ConfigError(f"{where}: endpoint {config.endpoint!r}: scans come over the boat's link; expected none")
        if self.key.split("/")[0] in TAKEN:
            raise ConfigError(f"{where}: options.key {self.key!r}: the boat itself publishes there; expected another")
        self._name, self._now_ns = config.called, now_ns
        self._silent_ns = round(config.silent_s * 1e9)
        self._poll: Callable[[], list[Heard]] = list
        self._heard_ns = 0
        self._why = ""
        self.taken = 0
        self.refused: Counter[str] = Counter()  # by reason

    def listen(self, poll: Callable[[], list[Heard]]) -> None:
        """From now on `poll` gives what was published."""
        self._poll = poll

    def open(self) -> None:
        """Be ready."""
        import numpy  # noqa: F401 - before the first tick, and not in it

        self._heard_ns = self._now_ns()

    def read(self, now_ns: int) -> Observed:
        """Scans since the last call."""
        scans: list[Scan] = []
        for heard in self._poll():
            try:
                scans.append(mounted(decode_scan(heard.payload, heard.at_ns, self._name), self._options))
            except Refused as why:
                self._refuse(str(why))
        self.taken += len(scans)
        if scans:
            self._heard_ns, self._why = now_ns, ""
        if now_ns - self._heard_ns <= self._silent_ns:
            return Observed(scans=tuple(scans))
        return Observed(trouble=f"scans refused: {self._why}" if self._why else "nobody publishes scans")

    def _refuse(self, why: str) -> None:
        self.refused[why] += 1
        if why != self._why:
            log.warning("%s: scan refused: %s", self._name, why, extra={"event": "scan-refused"})
        self._why = why

    def close(self) -> None:
        """Nothing is open."""
