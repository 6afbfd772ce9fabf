"""What a boat does when its sensors are lost one by one: real agents in memory, that hear sentences and nothing else.

python -m tests.drivers.sensors.losses
"""

from __future__ import annotations

import math
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from msgspec import Struct
from msgspec.structs import replace

from fleet.agent.modes import Mode
from fleet.drivers.nmea import encode
from fleet.drivers.nmea.codec import Gga, Rmc, decode
from fleet.drivers.nmea.sensor import LineSensor, nmea
from fleet.drivers.seam import Reading
from fleet.drivers.sensors.config import EVERYTHING, SensorConfig
from fleet.drivers.sensors.equipped import Equipped, Fitted
from fleet.mission.model import Environment
from fleet.sim.suite import Spoken
from tests.agent.harness import MemoryDriver, Sea, mission, sailing

REAL = Environment(gnss_white_m=0.3, gnss_velocity_mps=0.05, heading_noise_deg=1.5, yaw_rate_noise_degps=0.3)
Spoil = Callable[[list[bytes]], list[bytes]]


class Wire:
    """A port in memory."""

    trouble = ""

    def __init__(self) -> None:
        self.waiting: list[tuple[bytes, int]] = []
        self.heard_ns = 0
        self.counts: Counter[str] = Counter()

    @property
    def port(self) -> Wire:
        """Itself."""
        return self

    def open(self) -> None:
        """Nothing to connect."""

    def close(self) -> None:
        """Nothing to disconnect."""

    def take(self) -> list[tuple[bytes, int]]:
        """What has arrived."""
        waiting, self.waiting = self.waiting, []
        return waiting


class Wired:
    """A boat's thrusters; what its sensors say goes over the wire, as sentences."""

    simulated = True

    def __init__(self, driver: MemoryDriver, wire: Wire, now_ns: Callable[[], int]) -> None:
        self._driver, self._wire, self._now_ns = driver, wire, now_ns
        self._spoken = Spoken()
        self.spoil: Spoil = lambda lines: lines
        self.open, self.write = driver.open, driver.write
        self.neutral, self.close = driver.neutral, driver.close

    def read(self) -> Reading:
        """What has no sentence."""
        lines, left = self._spoken.say(self._driver.read())
        now_ns = self._now_ns()
        for line in self.spoil(lines):
            self._wire.waiting.append((line.strip(), now_ns))
            self._wire.heard_ns = now_ns
        return left


def rewired(sea: Sea, boat: str = "b1") -> tuple[Wired, LineSensor]:
    """From now on this boat's agent hears sentences and nothing else."""
    station, wire = sea.stations[boat], Wire()
    sensor = nmea(boat, SensorConfig(kind="nmea", endpoint="udp:127.0.0.1:10110"), station.now_ns)
    sensor.lines = wire  # type: ignore[assignment]
    wired = Wired(station.driver, wire, station.now_ns)
    sea.agent(boat).driver = Equipped(wired, [Fitted("nmea", sensor, EVERYTHING)], station.now_ns)
    return wired, sensor


def without(*kinds: str) -> Spoil:
    """All but sentences of some kinds."""
    return lambda lines: [line for line in lines if not any(kind.encode() in line[:7] for kind in kinds)]


def stale(lag_s: float) -> Callable[[Sea], Spoil]:
    """Sentences that come so late."""

    def make(sea: Sea) -> Spoil:
        held: list[tuple[int, list[bytes]]] = []

        def spoil(lines: list[bytes]) -> list[bytes]:
            held.append((sea.now_ns, lines))
            due = []
            while held and (sea.now_ns - held[0][0]) * 1e-9 >= lag_s:
                due += held.pop(0)[1]
            return due

        return spoil

    return make


def void(lines: list[bytes]) -> list[bytes]:
    """A receiver that says it has no fix, where it has none."""

    def said(line: bytes) -> bytes:
        stamp_ns = int(line[7:9]) * 3600 * 10**9 + int(line[9:11]) * 60 * 10**9 + round(float(line[11:17]) * 1e9)
        if b"RMC" in line[:7]:
            return encode.rmc(stamp_ns, math.nan, math.nan, math.nan, math.nan)
        return encode.gga(stamp_ns, math.nan, math.nan, 0, 99.0)

    return [said(line) if line[3:6] in (b"GGA", b"RMC") else line for line in lines]


def aside(metres: float) -> Spoil:
    """A receiver that is wrong by so much to the east, all of a sudden."""

    def spoil(lines: list[bytes]) -> list[bytes]:
        found = []
        for line in lines:
            said = decode(line.strip()) if line.startswith(b"$") else None
            if isinstance(said, Gga | Rmc):
                stamp_ns = round(said.time_s * 1e9)
                lon = said.lon_deg + metres / (111_195.0 * math.cos(math.radians(said.lat_deg)))
                line = (  # noqa: PLW2901
                    encode.gga(stamp_ns, said.lat_deg, lon, said.quality, said.hdop)
                    if isinstance(said, Gga)
                    else encode.rmc(stamp_ns, said.lat_deg, lon, said.v_north_mps, said.v_east_mps)
                )
            found.append(line)
        return found

    return spoil


def spoilt_checksums(lines: list[bytes]) -> list[bytes]:
    """The first and the third sentence of a burst with a bit flipped."""
    found = []
    for i, line in enumerate(lines):
        wrong = bytearray(line)
        if i % 2 == 0:
            wrong[8] ^= 4
        found.append(bytes(wrong))
    return found


LOSSES: dict[str, Callable[[Sea], Spoil]] = {
    "nothing": lambda sea: lambda lines: lines,
    "GNSS receiver silent": lambda sea: without("GGA", "RMC"),
    "GNSS receiver says void": lambda sea: void,
    "compass silent": lambda sea: without("HDT"),
    "turn indicator silent": lambda sea: without("ROT"),
    "compass and turn indicator silent": lambda sea: without("HDT", "ROT"),
    "the whole line cut": lambda sea: lambda lines: [],
    "the line 0.4 s late": stale(0.4),
    "the line 2 s late": stale(2.0),
    "receiver 30 m aside at once": lambda sea: aside(30.0),
    "GGA and heading with wrong checksums": lambda sea: spoilt_checksums,
}


class Outcome(Struct):
    """What came of a loss."""

    told_s: float  # until the status named it; inf: never
    what: str  # how
    stopped_s: float  # until the boat was without thrust; inf: it sailed on
    aside_m: float  # farthest from the path meanwhile, and for a minute at most
    error_m: float  # what it believed its error to be at the end


def lose(name: str, folder: Path, seconds: float = 60.0) -> Outcome:
    """Sail a line at 1 m/s, lose something, look for a minute."""
    sea = sailing(folder, replace(mission(1), environment=REAL), 4.0)
    wired, _ = rewired(sea)
    sea.run(8.0)
    assert sea.mode("b1") == Mode.FOLLOW
    wired.spoil = LOSSES[name](sea)
    began, told, stopped, aside_m, what = sea.time_s, math.inf, math.inf, 0.0, ""
    while sea.time_s - began < seconds:
        sea.run(0.1)
        agent = sea.agent("b1")
        if agent.reading.amiss and told == math.inf:
            told, what = sea.time_s - began, agent.reading.amiss[0]
        if not sea.powered("b1") and stopped == math.inf:
            stopped = sea.time_s - began
        aside_m = max(aside_m, abs(sea.where("b1")[1]))
    return Outcome(told, what, stopped, aside_m, sea.agent("b1").nav.sigma)


def main() -> None:
    """Print the table."""
    print(f"{'lost':45}{'named after':>12}  {'as':38}{'no thrust after':>16}{'off path':>10}{'1 sigma':>9}")
    for name in LOSSES:
        with tempfile.TemporaryDirectory() as folder:
            it = lose(name, Path(folder))
        told = f"{it.told_s:.1f} s" if math.isfinite(it.told_s) else "-"
        stopped = f"{it.stopped_s:.1f} s" if math.isfinite(it.stopped_s) else "sails on"
        print(
            f"{name:45}{told:>12}  {it.what or '-':38}{stopped:>16}{it.aside_m:8.2f} m{it.error_m:7.2f} m", flush=True
        )


if __name__ == "__main__":
    main()
