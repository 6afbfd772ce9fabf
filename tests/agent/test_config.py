# ruff: noqa: E501 - a table is read along its rows
"""A wrong configuration is refused with what is wrong, the value, where it stands, and what was expected."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from fleet.agent.config import load_config
from fleet.errors import ConfigError, UsageError

HUB = '[link]\ntopology = "hub"\n'
# file, environment, flags, message
WRONG: list[tuple[str, dict[str, str], dict[str, Any], str]] = [
    (HUB, {}, {}, "boat: no name given; expected --boat NAME, FLEET_BOAT or `boat = ` in the configuration"),
    ('boat = "B 1"\n[link]\ntopology = "hub"\n', {}, {}, "boat 'B 1': expected 1 to 32 of a-z, 0-9 and -"),
    ('boat = "operator"\n[link]\ntopology="hub"\n', {}, {}, "boat 'operator': this name is kept for operators"),
    ("boat = 7\n", {}, {}, "boat.toml: boat = 7: expected text"),
    ('boat = "b1\n', {}, {}, "boat.toml: not TOML: Illegal character '\\n' (at line 1, column 11)"),
    ('boat = "b1"\nspeed = 3\n', {}, {}, 'boat.toml: speed: unknown key; did you mean "seed"?'),
    (
        'boat = "b1"\n[link]\ntopology = "star"\n',
        {},
        {},
        'boat.toml: link.topology = "star": expected one of hub, mesh, routed',
    ),
    (
        'boat = "b1"\n',
        {},
        {},
        "link.topology 'routed' with nothing to listen on or connect to reaches nobody; expected link.listen and link.connect such as tcp/10.0.0.5:7447, or --topology hub",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\nlease_ms = "long"\n',
        {},
        {},
        'boat.toml: link.lease_ms = "long": expected a whole number',
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\nconnect = "tcp/1.2.3.4:7447"\n',
        {},
        {},
        'boat.toml: link.connect = "tcp/1.2.3.4:7447": expected a list',
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n[driver]\nkind = "rudder"\n',
        {},
        {},
        'boat.toml: driver.kind = "rudder": expected one of can, mavlink, simulated, or a driver that an installed package adds',
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n[driver]\nworld = 5\n',
        {},
        {},
        "boat.toml: driver.world = 5: expected text",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n',
        {"FLEET_CONTROL_HZ": "fast"},
        {},
        "environment FLEET_CONTROL_HZ='fast': control_hz = \"fast\": expected a number from 1 to 100",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n',
        {"FLEET_CONTROL_HZ": "1000"},
        {},
        "environment FLEET_CONTROL_HZ='1000': control_hz = 1000: expected a number from 1 to 100",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n',
        {},
        {"control_hz": 0.0},
        "flag --control-hz 0.0: control_hz = 0: expected a number from 1 to 100",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n',
        {},
        {"driver.kind": "cam"},
        "flag --driver 'cam': driver.kind = \"cam\": expected one of can, mavlink, simulated, or a driver that an installed package adds",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n',
        {"FLEET_TOPOLOGY": "ring"},
        {},
        "environment FLEET_TOPOLOGY='ring': link.topology = \"ring\": expected one of hub, mesh, routed",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n',
        {},
        {"fleet": "My Fleet"},
        "fleet 'My Fleet': expected 1 to 32 of a-z, 0-9 and -",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n[clock]\nwarp = 0\n',
        {},
        {},
        "boat.toml: clock.warp = 0: expected a number above 0",
    ),
    (
        'boat = "b1"\n[driver.can]\ncommand_age_s = 5.0\n',
        {},
        {},
        "boat.toml: driver.can.command_age_s = 5: expected a number above 0",
    ),
    (
        'boat = "b1"\n[driver.can]\nchanel = "can1"\n',
        {},
        {},
        'boat.toml: driver.can.chanel: unknown key; did you mean "channel"?',
    ),
    (
        'boat = "b1"\n[driver.can]\noptions = { port = [1] }\n',
        {},
        {},
        "boat.toml: driver.can.options.port = [1]: expected a number",
    ),
    (
        'boat = "b1"\n[driver.can.thrusters]\nrear_arm_m = 0\n',
        {},
        {},
        "boat.toml: driver.can.thrusters.rear_arm_m = 0: expected a number above 0",
    ),
    (
        'boat = "b1"\n[driver.can.loops]\nmass_kg = "heavy"\n',
        {},
        {},
        'boat.toml: driver.can.loops.mass_kg = "heavy": expected a number above 0',
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n[driver]\nkind = "mavlink"\n',
        {},
        {},
        "driver.mavlink.endpoint: missing; expected where the autopilot is, such as udp:127.0.0.1:14550",
    ),
    (
        'boat = "b1"\n[link]\ntopology = "hub"\n[driver]\nkind = "mavlink"\n',
        {"FLEET_MAVLINK_ENDPOINT": "com3"},
        {},
        "driver.mavlink.endpoint 'com3': expected udp:HOST:PORT, udpin:HOST:PORT, tcp:HOST:PORT or serial:DEVICE:BAUD, such as udp:127.0.0.1:14550",
    ),
    (
        'boat = "b1"\n[driver.mavlink]\narm = "always"\n',
        {},
        {},
        'boat.toml: driver.mavlink.arm = "always": expected one of never, operator',
    ),
    (
        'boat = "b1"\n[driver.mavlink]\nsysid = 0\n',
        {},
        {},
        "boat.toml: driver.mavlink.sysid = 0: expected a whole number from 1 to 255",
    ),
    (
        'boat = "b1"\nhull = "canoe"\n[link]\ntopology = "hub"\n',
        {},
        {},
        "hull 'canoe': no such hull; known: unicycle, otter, catamaran",
    ),
    (
        'boat = "b1"\n[limits]\nspeed_min_mps = 1.5\nspeed_max_mps = 1.2\n' + HUB,
        {},
        {},
        "limits.speed_min_mps = 1.5: expected less than limits.speed_max_mps = 1.2",
    ),
    (
        'boat = "b1"\n[limits]\nspeed_max_mps = 0\n' + HUB,
        {},
        {},
        "boat.toml: limits.speed_max_mps = 0: expected a number above 0",
    ),
    ('boat = "b1"\nslots = 0\n', {}, {}, "boat.toml: slots = 0: expected a whole number from 1 to 64"),
]


@pytest.mark.parametrize(("text", "environment", "flags", "message"), WRONG)
def test_a_wrong_configuration_gets_its_message(
    tmp_path: Path, text: str, environment: dict[str, str], flags: dict[str, Any], message: str
) -> None:
    file = tmp_path / "boat.toml"
    file.write_text(text)
    with pytest.raises(UsageError) as refused:
        load_config(file, flags, environment)
    assert str(refused.value).replace(str(file), "boat.toml") == message
    assert refused.value.exit_code == 2


def test_every_misfit_of_a_file_is_told_at_once(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    file.write_text('boat = 7\nslots = 0\ncontrol_hz = "fast"\n')
    with pytest.raises(ConfigError) as refused:
        load_config(file, {}, {})
    assert len(str(refused.value).splitlines()) == 3


def test_values_that_do_not_fit_together_are_told_at_once_too(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    file.write_text('boat = "B 1"\nhull = "canoe"\n[driver]\nkind = "mavlink"\n')
    with pytest.raises(ConfigError) as refused:
        load_config(file, {}, {})
    assert [line.split()[0] for line in str(refused.value).splitlines()] == [
        "boat",
        "hull",
        "driver.mavlink.endpoint:",
        "link.topology",
    ]


def test_a_service_managers_state_directory_is_the_default_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    assert load_config(None, {"boat": "b1", "link.topology": "hub"}, {}).folder() == tmp_path
    assert load_config(None, {"boat": "b1", "link.topology": "hub", "state_dir": "/x"}, {}).folder() == Path("/x")


def test_flags_win_over_the_environment_and_the_environment_over_the_file(tmp_path: Path) -> None:
    file = tmp_path / "boat.toml"
    file.write_text('boat = "b1"\nfleet = "file"\ncontrol_hz = 5.0\nslots = 3\n[link]\ntopology = "hub"\n')
    config = load_config(file, {"fleet": "flag"}, {"FLEET_FLEET": "environment", "FLEET_CONTROL_HZ": "20"})
    assert (config.fleet, config.control_hz, config.slots) == ("flag", 20.0, 3)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="no such file"):
        load_config(tmp_path / "none.toml", {}, {})
