"""Serial lines and the CAN interface, as a machine shows them."""

from __future__ import annotations

import json
import os
import pty
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest

from fleet.agent.config import DriverConfig
from fleet.doctor import wiring


def test_the_serial_lines_of_a_boat() -> None:
    mavlink = msgspec.convert({"kind": "mavlink", "mavlink": {"endpoint": "serial:/dev/ttyAMA0:921600"}}, DriverConfig)
    assert wiring.serial_devices(mavlink) == {"/dev/ttyAMA0": "autopilot"}
    slcan = msgspec.convert(
        {"kind": "can", "can": {"interface": "slcan", "channel": "/dev/ttyACM0@115200"}}, DriverConfig
    )
    assert wiring.serial_devices(slcan) == {"/dev/ttyACM0": "CAN adapter"}
    compass = {"kind": "nmea", "name": "compass", "endpoint": "serial:/dev/ttyUSB0:4800"}
    sensors = msgspec.convert({"kind": "can", "sensors": [compass, {"kind": "gpsd"}]}, DriverConfig)
    assert wiring.serial_devices(sensors) == {"/dev/ttyUSB0": "compass"}


def test_a_line_that_is_there_and_nobody_elses() -> None:
    ours, theirs = pty.openpty()
    device = os.ttyname(theirs)
    os.close(theirs)
    try:
        assert wiring.serial_line(device, "autopilot").verdict == "ok"
    finally:
        os.close(ours)


def test_a_line_that_another_program_has_open_is_told_with_its_process() -> None:
    ours, theirs = pty.openpty()
    device = os.ttyname(theirs)
    holder = subprocess.Popen([sys.executable, "-c", "input()"], stdin=theirs)
    os.close(theirs)
    try:
        found = wiring.serial_line(device, "autopilot")
        assert found.verdict == "warn"
        assert f"in use by process {holder.pid}" in found.found
    finally:
        holder.kill()
        holder.wait()
        os.close(ours)


def test_lines_that_are_not_there_not_devices_or_the_kernels_console(tmp_path: Path) -> None:
    (tmp_path / "dev").mkdir()
    missing = wiring.serial_line("/dev/ttyAMA0", "autopilot", tmp_path)
    assert (missing.verdict, missing.found) == ("fail", "/dev/ttyAMA0 (autopilot): not there")
    assert missing.do.endswith("none is plugged in")
    (tmp_path / "dev/serial/by-id").mkdir(parents=True)
    (tmp_path / "dev/serial/by-id/usb-FTDI").touch()
    assert "/dev/serial/by-id/usb-FTDI" in wiring.serial_line("/dev/ttyAMA0", "autopilot", tmp_path).do
    (tmp_path / "dev/ttyAMA0").touch()
    assert wiring.serial_line("/dev/ttyAMA0", "autopilot", tmp_path).found.endswith("not a device")
    (tmp_path / "dev/ttyS0").symlink_to("/dev/null")
    (tmp_path / "proc").mkdir()
    (tmp_path / "proc/cmdline").write_text("quiet console=null,115200 console=tty1\n")
    assert "console" in wiring.serial_line("/dev/ttyS0", "gnss", tmp_path).found


def test_an_agent_of_this_boat_is_seen_by_its_process(tmp_path: Path) -> None:
    for number, words in ((71, ["python", "-m", "fleet.agent", '{"boat":"b1","fleet":"x"}']), (72, ["sh", "-c", "x"])):
        (tmp_path / "proc" / str(number)).mkdir(parents=True)
        (tmp_path / "proc" / str(number) / "cmdline").write_bytes("\0".join(words).encode() + b"\0")
    assert wiring.agent_of("x", "b1", tmp_path) == 71
    assert wiring.agent_of("x", "b11", tmp_path) == wiring.agent_of("y", "b1", tmp_path) == 0


# -- CAN ---------------------------------------------------------------------------------------------------------------
def shown(state: str = "ERROR-ACTIVE", *, up: bool = True, kind: str = "can", restart_ms: int = 100) -> str:
    """As iproute2 6.1 prints it."""
    data: dict[str, Any] = {"state": state, "bittiming": {"bitrate": 250000}}
    if restart_ms:
        data["restart_ms"] = restart_ms
    flags = ["NOARP", *(["UP", "LOWER_UP", "ECHO"] if up else [])]
    return json.dumps([{"ifname": "can0", "flags": flags, "linkinfo": {"info_kind": kind, "info_data": data}}])


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (shown(), ["ok can0 is up, 250 kbit/s, ERROR-ACTIVE"]),
        (shown(up=False), ["fail can0 is down"]),
        (shown("BUS-OFF"), ["fail can0 is up, 250 kbit/s, BUS-OFF"]),
        (shown("ERROR-PASSIVE"), ["warn can0 is up, 250 kbit/s, ERROR-PASSIVE"]),
        (shown(restart_ms=0), ["ok can0 is up, 250 kbit/s, ERROR-ACTIVE", "warn can0 stays off after bus-off"]),
        (shown(kind="vcan"), ["warn can0 is up, and virtual"]),
        (shown(kind="dummy"), ["fail can0: not a CAN interface"]),
        ('[{"ifname": "eth0", "flags": ["UP"]}]', ["fail can0: not a CAN interface"]),
        ("Device does not exist", ["warn can0: `ip` said nothing that can be read"]),
    ],
)
def test_a_can_interface(text: str, found: list[str]) -> None:
    seen = list(wiring.judge_can("can0", text))
    assert [f"{one.verdict} {one.found}" for one in seen] == found
    assert all(one.do for one in seen if one.verdict != "ok")


def test_an_interface_that_is_not_there(tmp_path: Path) -> None:
    (found,) = wiring.can_link("can0", tmp_path)
    assert (found.verdict, found.found) == ("fail", "can0: no such interface")


def test_an_interface_of_another_kind_is_told_by_ip_itself() -> None:
    (found,) = wiring.can_link("lo")
    assert found.verdict in ("fail", "warn"), "not CAN, or no `ip` here"
