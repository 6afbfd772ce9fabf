"""The sensor `gpsd`: a connection to a gpsd, which is asked to report."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from msgspec.structs import replace

from fleet.drivers.gpsd.receiver import WATCH, GpsdOptions, GpsdReceiver
from fleet.drivers.seam import Observed
from fleet.drivers.sensors.config import NAVIGATION, SensorConfig
from fleet.drivers.sensors.lines import Lines
from fleet.drivers.sensors.port import endpoint
from fleet.drivers.sensors.silence import Silence

ENDPOINT = "tcp:127.0.0.1:2947"
LONGEST = 20_000  # SKY lists every satellite


class GpsdSensor:
    """See `fleet.drivers.seam.Sensor`."""

    gives = NAVIGATION

    def __init__(self, config: SensorConfig, now_ns: Callable[[], int]) -> None:
        self._receiver = GpsdReceiver(config.options_as(GpsdOptions), config.delay_s)
        where = endpoint(config.endpoint or ENDPOINT, config.called, kinds=("tcp",))
        self.lines = Lines(where, now_ns, lambda port: (port.send(WATCH), None)[1], LONGEST)
        self._silence = Silence(config.use, config.silent_s)

    def open(self) -> None:
        """Begin to listen."""
        self.lines.port.open()

    def read(self, now_ns: int) -> Observed:
        """What is new."""
        for line, stamp_ns in self.lines.take():
            self._receiver.take(line, stamp_ns)
        said = self._receiver.observed(now_ns)
        for what, stamp_ns in (("fix", said.fix_ns), ("heading", said.heading_ns), ("yaw-rate", said.yaw_rate_ns)):
            if stamp_ns:
                self._silence.gave(what, now_ns, stamp_ns)
        why = {"fix": self._receiver.why_no_fix}
        trouble = self._silence.trouble(now_ns, self.lines.heard_ns, self.lines.port.trouble, why)
        return replace(said, trouble=trouble) if trouble else said

    @property
    def counts(self) -> Counter[str]:
        """What came of all reports."""
        return self.lines.counts + self._receiver.counts

    def close(self) -> None:
        """Stop listening."""
        self.lines.port.close()


def gpsd(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> GpsdSensor:  # noqa: ARG001 - as all factories
    """What gpsd knows."""
    return GpsdSensor(config, now_ns)
