"""An agent's own configuration: flags over `FLEET_*` over a TOML file."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import msgspec
from msgspec import Meta, Struct, field

from fleet.agent.clock import ClockSpec
from fleet.agent.scans import ScanParams
from fleet.drivers.can.config import CanConfig
from fleet.drivers.kinds import wrong_kind
from fleet.drivers.mavlink.config import MavlinkConfig
from fleet.drivers.sensors.config import SensorConfig
from fleet.drivers.sensors.kinds import wrong_sensors
from fleet.errors import ConfigError, FleetError
from fleet.guidance.limits import OwnLimits
from fleet.hulls import HULLS
from fleet.mission.problem import texts
from fleet.mission.structure import problems
from fleet.wire.keys import valid_name
from fleet.wire.link import LinkConfig, check_link


class DriverConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which hardware."""

    kind: str = "simulated"
    world: str = "127.0.0.1:7440"  # of a simulated boat: where the world process listens
    simulated: bool = False  # this hardware is simulated in a world process: `fleet sim --driver` says so
    can: CanConfig = field(default_factory=CanConfig)
    mavlink: MavlinkConfig = field(default_factory=MavlinkConfig)
    options: dict[str, Any] = field(default_factory=dict)  # of a driver that another package adds
    sensors: tuple[SensorConfig, ...] = ()  # beside it; the first is believed first


class AgentConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything that is one boat's."""

    boat: str = ""
    fleet: str = "demo"
    hull: str = ""  # which model of `hulls` it is like; a mission that takes it for another is refused
    limits: OwnLimits = field(default_factory=OwnLimits)  # a mission that asks more of it is refused
    link: LinkConfig = field(default_factory=LinkConfig)
    driver: DriverConfig = field(default_factory=DriverConfig)
    scans: ScanParams = field(default_factory=ScanParams)  # what is made of a scanner's scans
    state_dir: str = ""  # where stops, mission and progress are kept; default: ~/.local/state/fleet/<boat>
    record: str = ""  # file of the recording; "none": no recording; default: <state_dir>/recordings/<stamp>.mcap
    mission: str = ""  # a mission file to sail by itself, without an operator
    control_hz: Annotated[float, Meta(ge=1.0, le=100.0)] = 10.0
    clock_error_ms: float = -1.0  # how wrong this machine's clock may be; below 0: as the kernel says, every 10 s
    clock: ClockSpec = field(default_factory=ClockSpec)
    boot_id: str = ""  # default: the kernel's
    seed: int = 0  # of the simulated radio
    slots: Annotated[int, Meta(ge=1, le=64)] = 8  # publication times in one period, by roster number

    def folder(self) -> Path:
        """Where this boat keeps what must survive a restart; a service manager's `StateDirectory=` is the default."""
        if self.state_dir:
            return Path(self.state_dir)
        given = os.environ.get("STATE_DIRECTORY", "").split(":")[0]
        return Path(given) if given else Path.home() / ".local" / "state" / "fleet" / self.boat


LOOPBACK_HUB = "tcp/127.0.0.1:7447"
SECURE_HUB = "tls/127.0.0.1:7447"
FLAGS = {"driver.kind": "driver"}  # those that are not called as the last part of their key
ENVIRONMENT: dict[str, str] = {
    "FLEET_BOAT": "boat",
    "FLEET_FLEET": "fleet",
    "FLEET_TOPOLOGY": "link.topology",
    "FLEET_CONNECT": "link.connect",
    "FLEET_LISTEN": "link.listen",
    "FLEET_CREDENTIALS": "link.credentials",
    "FLEET_INSECURE": "link.insecure",
    "FLEET_STATE_DIR": "state_dir",
    "FLEET_RECORD": "record",
    "FLEET_MISSION": "mission",
    "FLEET_DRIVER": "driver.kind",
    "FLEET_WORLD": "driver.world",
    "FLEET_CAN_INTERFACE": "driver.can.interface",
    "FLEET_CAN_CHANNEL": "driver.can.channel",
    "FLEET_MAVLINK_ENDPOINT": "driver.mavlink.endpoint",
    "FLEET_CONTROL_HZ": "control_hz",
    "FLEET_CLOCK_ERROR_MS": "clock_error_ms",
}


def _put(tree: dict[str, Any], dotted: str, value: Any) -> None:
    *parents, last = dotted.split(".")
    for parent in parents:
        tree = tree.setdefault(parent, {})
    tree[last] = value


def _from_text(dotted: str, text: str) -> Any:
    if dotted in ("link.connect", "link.listen"):
        return [part for part in text.split(",") if part]
    if dotted == "link.insecure":
        return {"true": True, "1": True, "false": False, "0": False}.get(text.lower(), text)
    kind: Any = get_type_hints(AgentConfig).get(dotted)
    if kind in (float, int):
        try:
            return kind(text)
        except ValueError:
            return text
    return text


def read_table(path: Path) -> dict[str, Any]:
    """A TOML file as a table; ConfigError with file and line."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file; expected a configuration in TOML") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: not TOML: {error}") from None


def load_config(
    path: Path | None = None,
    flags: Mapping[str, Any] | None = None,
    environment: Mapping[str, str] | None = None,
) -> AgentConfig:
    """The agent's configuration; ConfigError names the file, the variable or the flag, and what was expected.

    Args:
        path: TOML file, if any
        flags: dotted key -> value; None values are not given
        environment: `FLEET_*`; the process's own when None
    """
    environment = os.environ if environment is None else environment
    layers: list[tuple[str, dict[str, Any]]] = []
    if path is not None:
        layers.append((str(path), read_table(path)))
    for name, dotted in ENVIRONMENT.items():
        if environment.get(name):
            layer: dict[str, Any] = {}
            _put(layer, dotted, _from_text(dotted, environment[name]))
            layers.append((f"environment {name}={environment[name]!r}", layer))
    for dotted, value in (flags or {}).items():
        if value is not None:
            layer = {}
            _put(layer, dotted, value)
            layers.append((f"flag --{FLAGS.get(dotted, dotted.split('.')[-1]).replace('_', '-')} {value!r}", layer))
    tree: dict[str, Any] = {}
    for origin, layer in layers:
        merged = _merge(tree, layer)
        try:
            read = msgspec.convert(merged, AgentConfig)
        except msgspec.ValidationError:
            found = texts(problems(merged, AgentConfig))
            raise ConfigError("\n".join(f"{origin}: {text}" for text in found)) from None
        _must_exist(read.driver, origin)
        tree = merged
    config = msgspec.convert(tree, AgentConfig)
    wrong = "\n".join(misfits(config))
    if wrong:
        raise ConfigError(wrong)
    if config.link.topology == "hub" and not config.link.connect:
        hub = SECURE_HUB if config.link.credentials else LOOPBACK_HUB
        return msgspec.structs.replace(config, link=msgspec.structs.replace(config.link, connect=(hub,)))
    return config


def misfits(config: AgentConfig) -> Iterator[str]:
    """What does not fit together, or names what is not there; each by itself a value of the right kind."""
    if not config.boat:
        yield "boat: no name given; expected --boat NAME, FLEET_BOAT or `boat = ` in the configuration"
    for what, name in (("boat", config.boat), ("fleet", config.fleet)):
        if name or what == "fleet":
            yield from _said(partial(valid_name, what, name))
    if config.hull and config.hull not in HULLS:
        yield f"hull {config.hull!r}: {HULLS.why(config.hull) or 'no such hull; known: ' + ', '.join(HULLS)}"
    slowest, fastest = config.limits.speed_min_mps, config.limits.speed_max_mps
    if slowest is not None and fastest is not None and slowest >= fastest:
        yield f"limits.speed_min_mps = {slowest:g}: expected less than limits.speed_max_mps = {fastest:g}"
    if config.driver.kind == "mavlink":
        yield from _said(config.driver.mavlink.check)
    link = config.link
    if link.topology != "hub" and not link.connect and not link.listen:
        yield (
            f"link.topology {link.topology!r} with nothing to listen on or connect to reaches nobody; expected "
            "link.listen and link.connect such as tcp/10.0.0.5:7447, or --topology hub"
        )
    yield from _said(partial(check_link, link))


def _said(check: Callable[[], object]) -> Iterator[str]:
    """What a check that raises has to say."""
    try:
        check()
    except FleetError as error:
        yield str(error)


def _must_exist(driver: DriverConfig, origin: str) -> None:
    """ConfigError where driver or sensors are of a kind that there is not."""
    wrong = wrong_kind(driver.kind)
    if wrong:
        raise ConfigError(f'{origin}: driver.kind = "{driver.kind}": {wrong}')
    wrong = wrong_sensors(driver.sensors)
    if wrong:
        raise ConfigError(f"{origin}: {wrong}")


def _merge(a: dict[str, Any], b: dict[str, Any]) -> dict[str, Any]:
    result = dict(a)
    for key, value in b.items():
        old = result.get(key)
        result[key] = _merge(old, value) if isinstance(old, dict) and isinstance(value, dict) else value
    return result
