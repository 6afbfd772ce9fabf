"""A driver with sensors beside it: the driver steers, the sensors say where the boat is and who else is there."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from fleet.drivers.seam import Driver, Observed, Reading, Scan, Sensor, Sighting
from fleet.drivers.sensors.choice import Choice
from fleet.drivers.sensors.config import EVERYTHING, NAVIGATION

log = logging.getLogger("fleet.sensors")
OWN = "the driver"
FUSED_MPS, FUSED_RAD = 0.1, 0.03  # 1 sigma of what a driver gives fused, and tells no error of
MOST_SIGHTINGS, MOST_SCANS = 512, 16  # of one reading


class Fitted(Struct, frozen=True):
    """A sensor in its place; the driver's own measurements have none."""

    name: str
    sensor: Sensor | None
    use: frozenset[str]


class Equipped:
    """See `fleet.drivers.seam.Driver`.

    Position with velocity, heading, and yaw rate are each taken from the first sensor in rank that gives them
    (`Choice`), the driver's own come last unless it is given a rank. The reading is raw: the agent fuses it. Traffic
    and scans of all sensors are handed on.
    """

    def __init__(self, driver: Driver, fitted: Sequence[Fitted], now_ns: Callable[[], int]) -> None:
        self._driver, self._now_ns = driver, now_ns
        self.simulated = driver.simulated
        named = any(one.sensor is None for one in fitted)
        self._fitted = [*fitted] if named else [*fitted, Fitted(OWN, None, frozenset())]
        self.navigates = any(one.use & NAVIGATION for one in self._fitted if one.sensor is not None)
        self._choices = {what: Choice() for what in sorted(NAVIGATION)}
        self._own_ns = dict.fromkeys(NAVIGATION, 0)  # newest of the driver's own values
        self._amiss: dict[str, str] = {}
        self._notes: list[str] = []

    @property
    def hardware(self) -> Driver:
        """The driver that steers."""
        return self._driver

    @property
    def sensors(self) -> tuple[Sensor, ...]:
        """Those beside it."""
        return tuple(one.sensor for one in self._fitted if one.sensor is not None)

    def open(self) -> None:
        """Connect all."""
        self._driver.open()
        for one in self._fitted:
            if one.sensor is not None:
                one.sensor.open()

    def read(self) -> Reading:
        """The newest reading."""
        now_ns = self._now_ns()
        own = self._driver.read()
        found: dict[str, Any] = {}
        sightings: list[Sighting] = [*own.sightings]
        scans: list[Scan] = [*own.scans]
        for rank, one in enumerate(self._fitted):
            if one.sensor is None:
                said = self._own(own)
            else:
                said = self._asked(one, one.sensor, now_ns)
                sightings += said.sightings if "traffic" in one.use else ()
                scans += said.scans if "scan" in one.use else ()
            if self.navigates:
                found |= self._navigation(rank, one.use or EVERYTHING, said, now_ns)
        amiss = (*own.amiss, *(f"{name}: {why}" for name, why in self._amiss.items()))
        more = {"sightings": tuple(sightings[-MOST_SIGHTINGS:]), "scans": tuple(scans[-MOST_SCANS:]), "amiss": amiss}
        if not self.navigates:
            return replace(own, **more) if sightings or scans or amiss else own
        return Reading(
            battery_percent=own.battery_percent,
            authority=own.authority,
            trouble=own.trouble,
            raw=True,
            **{"stamp_ns": 0, **found, **more},
        )

    def _asked(self, one: Fitted, sensor: Sensor, now_ns: int) -> Observed:
        """What a sensor says; one that raises, of whatever package, is in trouble and nothing else."""
        try:
            said = sensor.read(now_ns)
        except Exception as error:  # noqa: BLE001 - a stranger's code must not end an agent
            said = Observed(trouble=f"its driver failed: {type(error).__name__}: {error}")
        before = self._amiss.get(one.name, "")
        if said.trouble != before:
            self._note(f"{one.name}: {said.trouble or 'well again'}")
            self._amiss[one.name] = said.trouble
            if not said.trouble:
                del self._amiss[one.name]
        return said

    def _own(self, own: Reading) -> Observed:
        """What the driver measures, as a sensor would say it: what is new."""
        if own.stamp_ns <= 0:
            return Observed()
        stamps = {
            "fix": own.stamp_ns,
            "heading": own.heading_stamp_ns or own.stamp_ns,
            "yaw-rate": own.yaw_rate_stamp_ns or own.stamp_ns,
        }
        new = {what: stamp if stamp > self._own_ns[what] else 0 for what, stamp in stamps.items()}
        self._own_ns = stamps
        return Observed(
            fix_ns=new["fix"] if math.isfinite(own.lat_deg + own.lon_deg) else 0,
            lat_deg=own.lat_deg,
            lon_deg=own.lon_deg,
            position_error_m=own.position_error_m,
            v_north_mps=own.v_north_mps,
            v_east_mps=own.v_east_mps,
            velocity_error_mps=own.velocity_error_mps if own.raw else FUSED_MPS,
            heading_ns=new["heading"] if math.isfinite(own.heading_rad) else 0,
            heading_rad=own.heading_rad,
            heading_error_rad=own.heading_error_rad if own.raw else FUSED_RAD,
            yaw_rate_ns=new["yaw-rate"] if math.isfinite(own.yaw_rate_radps) else 0,
            yaw_rate_radps=own.yaw_rate_radps,
        )

    def _navigation(self, rank: int, use: frozenset[str], said: Observed, now_ns: int) -> dict[str, Any]:
        """Of one source, what is believed."""
        found: dict[str, Any] = {}
        if said.fix_ns and "fix" in use and self._believed("fix", rank, now_ns):
            found |= {
                "stamp_ns": said.fix_ns,
                "lat_deg": said.lat_deg,
                "lon_deg": said.lon_deg,
                "position_error_m": said.position_error_m,
                "v_north_mps": said.v_north_mps,
                "v_east_mps": said.v_east_mps,
                "velocity_error_mps": said.velocity_error_mps,
            }
        if said.heading_ns and "heading" in use and self._believed("heading", rank, now_ns):
            found |= {
                "heading_stamp_ns": said.heading_ns,
                "heading_rad": said.heading_rad,
                "heading_error_rad": said.heading_error_rad,
            }
        if said.yaw_rate_ns and "yaw-rate" in use and self._believed("yaw-rate", rank, now_ns):
            found |= {"yaw_rate_stamp_ns": said.yaw_rate_ns, "yaw_rate_radps": said.yaw_rate_radps}
        return found

    def _believed(self, what: str, rank: int, now_ns: int) -> bool:
        choice = self._choices[what]
        before = choice.chosen
        used = choice.take(rank, now_ns)
        if used and rank != before:
            self._note(f"{what} from {self._fitted[rank].name}")
        return used

    def _note(self, text: str) -> None:
        log.warning(text, extra={"event": "sensor"})
        self._notes.append(text)

    def noted(self) -> list[str]:
        """What changed about the sensors since the last call, in words."""
        notes, self._notes = self._notes, []
        return notes

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command the boat."""
        return self._driver.write(surge_mps, yaw_rate_radps)

    def neutral(self) -> None:
        """No thrust."""
        self._driver.neutral()

    def close(self) -> None:
        """Leave the boat in neutral and disconnect all."""
        self._driver.close()
        for one in self._fitted:
            if one.sensor is not None:
                try:
                    one.sensor.close()
                except Exception as error:  # noqa: BLE001 - as above
                    log.warning("%s: %s", one.name, error)
