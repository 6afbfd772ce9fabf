"""Sensors by name: those of `fleet`, and those of other packages (entry points `fleet.sensors`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from fleet.drivers.seam import Driver, Sensor
from fleet.drivers.sensors.config import SensorConfig
from fleet.drivers.sensors.equipped import Equipped, Fitted
from fleet.errors import ConfigError
from fleet.plugins import Kinds

Factory = Callable[[str, SensorConfig, Callable[[], int]], Sensor]
"""(boat, its table in `[[driver.sensors]]`, the agent's clock [ns]) -> sensor, not yet open; ConfigError if wrong."""


def _nmea(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> Sensor:
    from fleet.drivers.nmea.sensor import nmea

    return nmea(boat, config, now_ns)


def _ais(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> Sensor:
    from fleet.drivers.nmea.sensor import ais

    return ais(boat, config, now_ns)


def _gpsd(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> Sensor:
    from fleet.drivers.gpsd.sensor import gpsd

    return gpsd(boat, config, now_ns)


def _lidar(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> Sensor:  # noqa: ARG001
    from fleet.drivers.lidar.driver import Lidar

    return Lidar(config, now_ns)


def _scan(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> Sensor:  # noqa: ARG001
    from fleet.drivers.lidar.published import PublishedScans

    return PublishedScans(config, now_ns)


BUILT_IN: dict[str, Factory] = {"nmea": _nmea, "gpsd": _gpsd, "ais": _ais, "lidar": _lidar, "scan": _scan}
OTHERS: Kinds[Factory] = Kinds("fleet.sensors", {})
OWN = "driver"


def wrong_sensors(sensors: Sequence[SensorConfig]) -> str:
    """Why there can be no such sensors; '' when there can."""
    names: set[str] = set()
    for one in sensors:
        where = f'driver.sensors, {one.called}: kind = "{one.kind}"'
        if one.kind != OWN and one.kind not in BUILT_IN and one.kind not in OTHERS:
            known = ", ".join((*BUILT_IN, OWN))
            why = OTHERS.why(one.kind) or f"expected one of {known}, or a sensor that an installed package adds"
            return f"{where}: {why}"
        if one.called in names:
            return f'{where}: two sensors are called {one.called!r}; expected another `name = "..."` for each'
        names.add(one.called)
        if one.kind == OWN and (one.endpoint or one.options):
            return f"{where}: stands for what the driver measures; expected no endpoint and no options"
        if one.kind in BUILT_IN:
            try:
                BUILT_IN[one.kind]("", one, lambda: 0)
            except ConfigError as error:
                return str(error)
    return ""


def made(boat: str, config: SensorConfig, now_ns: Callable[[], int]) -> Sensor:
    """One sensor, not yet open; ConfigError where it cannot be made."""
    if config.kind in BUILT_IN:
        return BUILT_IN[config.kind](boat, config, now_ns)
    try:
        return OTHERS[config.kind](boat, config, now_ns)
    except (TypeError, ValueError, KeyError, OSError) as error:
        raise ConfigError(f"driver.sensors, {config.called}: {type(error).__name__}: {error}") from error


def equipped(boat: str, driver: Driver, sensors: Sequence[SensorConfig], now_ns: Callable[[], int]) -> Driver:
    """The driver with these sensors beside it; itself, where there are none."""
    if not sensors:
        return driver
    fitted = []
    for one in sensors:
        sensor = None if one.kind == OWN else made(boat, one, now_ns)
        gives = frozenset(one.use) or (sensor.gives if sensor is not None else frozenset())
        if sensor is not None and not gives <= sensor.gives:
            gives_not = ", ".join(sorted(gives - sensor.gives))
            raise ConfigError(f"driver.sensors, {one.called}: use: a sensor of kind {one.kind!r} gives no {gives_not}")
        fitted.append(Fitted(one.called, sensor, gives))
    return Equipped(driver, fitted, now_ns)
