"""Serial lines and the CAN interface: are they there, may they be used, does somebody else have them?"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import stat
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fleet.agent.config import DriverConfig
from fleet.doctor.finding import Finding, fail, ok, warn

CAN_TYPE = "280"  # ARPHRD_CAN


def serial_devices(driver: DriverConfig) -> dict[str, str]:
    """Devices that this boat uses, and what for."""
    found: dict[str, str] = {}
    if driver.kind == "mavlink":
        found |= _device(driver.mavlink.endpoint, "autopilot")
    if driver.kind == "can" and driver.can.channel.startswith("/dev/"):
        found[driver.can.channel.split("@")[0]] = "CAN adapter"
    for sensor in driver.sensors:
        found |= _device(sensor.endpoint, sensor.called)
    return found


def _device(endpoint: str, what: str) -> dict[str, str]:
    kind, _, rest = endpoint.partition(":")
    return {rest.rsplit(":", 1)[0]: what} if kind == "serial" and rest else {}


def serial_line(device: str, what: str, root: Path = Path("/")) -> Finding:
    """One line."""
    place = root / device.lstrip("/")
    said = f"{device} ({what})"
    try:
        there = place.stat()
    except OSError:
        others = sorted(one.name for one in (root / "dev" / "serial" / "by-id").glob("*"))
        here = f"there is /dev/serial/by-id/{', '.join(others)}" if others else "none is plugged in"
        return fail("serial", f"{said}: not there", f"plug it in, switch the port on, or name another: {here}")
    if not stat.S_ISCHR(there.st_mode):
        return fail("serial", f"{said}: not a device", "name a serial device, such as /dev/ttyAMA0")
    if not os.access(place, os.R_OK | os.W_OK):
        return fail("serial", f"{said}: no permission", f"usermod -aG {_group(there.st_gid)} USER, then log in again")
    console = f"console={place.resolve().name}"
    if any(word.split(",")[0] == console for word in _words(root / "proc" / "cmdline")):
        return fail(
            "serial", f"{said}: the kernel's console is on it", f"take {console} out of the kernel's command line"
        )
    holders = holding(place, root)
    if holders:
        return warn(
            "serial", f"{said}: in use by {', '.join(holders)}", "one program only: end the other, or is it the agent?"
        )
    return ok("serial", said)


def _words(place: Path) -> list[str]:
    try:
        return place.read_text(encoding="ascii").split()
    except (OSError, UnicodeDecodeError):
        return []


def _group(number: int) -> str:
    import grp

    try:
        return grp.getgrgid(number).gr_name
    except KeyError:
        return str(number)


def processes(root: Path = Path("/")) -> Iterator[tuple[int, list[str]]]:
    """(process id, its words) of all that can be seen but this one."""
    for folder in (root / "proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if int(folder.name) != os.getpid():
            yield int(folder.name), [word for word in words if word]


def holding(place: Path, root: Path = Path("/")) -> list[str]:
    """Who has a device open, as far as it may be seen."""
    wanted = str(place.resolve())
    return [
        f"process {number} ({' '.join(words)[:60]})" for number, words in processes(root) if _has(wanted, number, root)
    ]


def _has(wanted: str, number: int, root: Path) -> bool:
    """Whether a process has a device open, as far as it may be seen."""
    try:
        opened = list((root / "proc" / str(number) / "fd").iterdir())
    except OSError:
        return False
    for one in opened:
        with contextlib.suppress(OSError):  # closed meanwhile
            if os.readlink(one) == wanted:
                return True
    return False


def agent_of(fleet: str, boat: str, root: Path = Path("/")) -> int:
    """The process of this boat's agent; 0 where none is seen."""
    name = f'"boat":"{boat}","fleet":"{fleet}"'
    for number, words in processes(root):
        if words[1:3] == ["-m", "fleet.agent"] and any(name in word for word in words[3:]):
            return number
    return 0


# -- CAN ---------------------------------------------------------------------------------------------------------------
def can_link(channel: str, root: Path = Path("/")) -> Iterator[Finding]:
    """SocketCAN's interface, as `ip -details link` shows it."""
    if not (root / "sys/class/net" / channel).exists():
        yield fail(
            "can",
            f"{channel}: no such interface",
            "plug the adapter in and load its driver (on a Raspberry Pi: dtoverlay=mcp2515-can0,... in config.txt)",
        )
        return
    program = shutil.which("ip") or shutil.which("ip", path="/sbin:/usr/sbin")
    shown = None
    if program is not None:
        done = subprocess.run(
            [program, "-details", "-statistics", "-json", "link", "show", channel],
            capture_output=True, text=True, timeout=10, check=False,
        )  # fmt: skip
        shown = done.stdout if done.returncode == 0 else None
    if shown is None:
        yield warn("can", f"{channel} is there; its state cannot be read", "apt install iproute2")
        return
    yield from judge_can(channel, shown)


def judge_can(channel: str, shown: str) -> Iterator[Finding]:
    """What `ip -details -json link show` says of a CAN interface."""
    try:
        (link,) = json.loads(shown)
    except ValueError:
        yield warn("can", f"{channel}: `ip` said nothing that can be read", "ip -details link show " + channel)
        return
    info: dict[str, Any] = link.get("linkinfo", {})
    kind = info.get("info_kind", "")
    if kind not in ("can", "vcan"):
        yield fail("can", f"{channel}: not a CAN interface", "driver.can.channel: expected one such as can0")
        return
    rate = info.get("info_data", {}).get("bittiming", {}).get("bitrate", 0)
    if "UP" not in link.get("flags", []):
        set_up = f"ip link set {channel} type can bitrate {rate or 250000} restart-ms 100; " if kind == "can" else ""
        yield fail("can", f"{channel} is down", f"{set_up}ip link set {channel} up")
        return
    if kind == "vcan":
        yield warn("can", f"{channel} is up, and virtual", "for a boat a real adapter is wanted")
        return
    state = info.get("info_data", {}).get("state", "?")
    said = f"{channel} is up, {rate / 1000:g} kbit/s, {state}"
    if state == "BUS-OFF":
        yield fail("can", said, "bit rate, wiring, 120 ohm at both ends; then ip link set down and up")
    elif state != "ERROR-ACTIVE":
        yield warn("can", said, "is another node on the bus? bit rate, wiring, 120 ohm at both ends")
    else:
        yield ok("can", said)
    if not info.get("info_data", {}).get("restart_ms"):
        yield warn("can", f"{channel} stays off after bus-off", f"ip link set {channel} type can restart-ms 100")
