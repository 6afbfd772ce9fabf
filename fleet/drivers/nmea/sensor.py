"""The sensors `nmea` and `ais`: lines from a port, to what they say about the own boat and about others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from msgspec.structs import replace

from fleet.drivers.ais.codec import must_have_pyais
from fleet.drivers.ais.decoder import Listener
from fleet.drivers.ais.options import AisOptions
from fleet.drivers.nmea.receiver import NmeaOptions, Receiver
from fleet.drivers.seam import Observed
from fleet.drivers.sensors.config import NAVIGATION, SensorConfig
from fleet.drivers.sensors.lines import Lines
from fleet.drivers.sensors.port import endpoint
from fleet.drivers.sensors.silence import Silence


class LineSensor:
    """See `fleet.drivers.seam.Sensor`."""

    def __init__(
        self, config: SensorConfig, now_ns: Callable[[], int], receiver: Receiver | None, listener: Listener | None
    ) -> None:
        self._receiver, self._listener = receiver, listener
        own = NAVIGATION if receiver is not None else frozenset[str]()
        self.gives = own | (frozenset({"traffic"}) if listener is not None else frozenset())
        self.lines = Lines(endpoint(config.endpoint, config.called, insecure=config.insecure), now_ns)
        self._silence = Silence(config.use or (() if own else ("traffic",)), config.silent_s)

    def open(self) -> None:
        """Begin to listen."""
        self.lines.port.open()

    def read(self, now_ns: int) -> Observed:
        """What is new."""
        receiver, listener = self._receiver, self._listener
        for line, stamp_ns in self.lines.take():
            if line[:1] == b"!" or line[:1] == b"\\":
                if listener is not None:
                    listener.take(line, stamp_ns)
            elif receiver is not None:
                receiver.take(line, stamp_ns)
        said = receiver.observed(now_ns) if receiver is not None else Observed()
        silence = self._silence
        for what, stamp_ns in (("fix", said.fix_ns), ("heading", said.heading_ns), ("yaw-rate", said.yaw_rate_ns)):
            if stamp_ns:
                silence.gave(what, now_ns, stamp_ns)
        why = {"fix": receiver.why_no_fix, "heading": receiver.why_no_heading} if receiver is not None else {}
        trouble = silence.trouble(now_ns, self.lines.heard_ns, self.lines.port.trouble, why)
        heard = listener.heard() if listener is not None else ()
        return replace(said, trouble=trouble, sightings=heard) if trouble or heard else said

    @property
    def counts(self) -> Counter[str]:
        """What came of all sentences."""
        found = Counter(self.lines.counts)
        for part in (self._receiver, self._listener):
            if part is not None:
                found += part.counts
        return found

    def close(self) -> None:
        """Stop listening."""
        self.lines.port.close()


def nmea(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> LineSensor:  # noqa: ARG001 - as all factories
    """A GNSS receiver, a compass, or a multiplexed line with AIS on it."""
    options = config.options_as(NmeaOptions)
    wanted = not config.use or "traffic" in config.use
    hears = wanted and must_have_pyais(config.called, needed="traffic" in config.use)
    return LineSensor(config, now_ns, Receiver(options, config.delay_s), Listener(options) if hears else None)


def ais(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> LineSensor:  # noqa: ARG001
    """An AIS receiver."""
    must_have_pyais(config.called)
    return LineSensor(config, now_ns, None, Listener(config.options_as(AisOptions)))
