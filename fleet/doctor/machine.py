"""The computer on board: its clock, its processor, what is installed."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from fleet import __version__
from fleet.agent.clock import UNDISCIPLINED_NS
from fleet.doctor.finding import Finding, fail, ok, warn

DISCIPLINED_NS = 100_000_000  # from here on ages come from echoes, not from stamps
BUILT_S = 1_750_000_000  # no right clock is before this version
HOT_C, TOO_HOT_C = 70.0, 80.0  # a Raspberry Pi slows down from 80 on
TRIED = ("x86_64", "aarch64")
LIBRARIES = {"mavlink": ("pymavlink",), "can": ("python-can", "cantools")}  # of drivers, by kind
ALWAYS = ("eclipse-zenoh", "msgspec", "mcap")
THROTTLED = {0: "supply voltage too low", 1: "clock rate capped", 2: "throttled", 3: "too hot"}  # of a Raspberry Pi
BEFORE = 16  # so many bits higher: it was so since the start


def clock(error_ns: int, now_s: float | None = None) -> Finding:
    """Whether the time is right, and how sure that is.

    Args:
        error_ns: bound of its error, as `kernel_error_ns` has it
        now_s: the time that it shows, unix; now when None
    """
    now_s = time.time() if now_s is None else now_s
    if now_s < BUILT_S:
        shown = time.strftime("%Y-%m-%d", time.gmtime(now_s))
        return fail("clock", f"it shows {shown}", "set it: a network or a GNSS for NTP; certificates are refused so")
    if error_ns >= UNDISCIPLINED_NS:
        return warn(
            "clock",
            "nothing disciplines it",
            "timedatectl set-ntp true, or chrony with the boat's GNSS; until then ages come from echoes, and "
            "certificates may be refused",
        )
    if error_ns > DISCIPLINED_NS:
        return warn(
            "clock", f"right to {error_ns * 1e-9:.1f} s only", "wait, or chronyc sources: which does it follow?"
        )
    return ok("clock", f"right to {error_ns * 1e-6:.0f} ms")


def versions(driver: str) -> Iterator[Finding]:
    """What is installed, and whether a driver's libraries are."""
    machine = platform.machine()
    said = f"fleet {__version__}, Python {platform.python_version()}, Linux {platform.release()} on {machine}"
    if machine in TRIED:
        yield ok("versions", said)
    else:
        yield warn("versions", said, f"take a 64-bit system: only {' and '.join(TRIED)} have wheels of every library")
    found = []
    for name in (*ALWAYS, *LIBRARIES.get(driver, ())):
        try:
            found.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            extra = "" if name in ALWAYS else f"[{driver}]"
            yield fail("versions", f"{name} is not installed", f"{sys.executable} -m pip install 'fleet-usv{extra}'")
    yield ok("versions", ", ".join(found))


def processor(root: Path = Path("/")) -> Iterator[Finding]:
    """How fast it may run, how hot it is, whether its supply holds; only what this machine shows."""
    cpus = os.cpu_count() or 1
    load = _number(root / "proc" / "loadavg")
    if load is not None and load > cpus:
        yield warn("processor", f"load {load:.1f} on {cpus} cores", "see what else runs: top")
    governor = _text(root / "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")
    if governor == "powersave":
        yield warn("processor", "governor powersave", "cpupower frequency-set -g ondemand, or performance")
    elif governor:
        yield ok("processor", f"governor {governor}")
    hottest = [
        value / 1000.0
        for zone in sorted((root / "sys/class/thermal").glob("thermal_zone*"))
        if (value := _number(zone / "temp")) is not None
    ]
    if hottest:
        degrees = max(hottest)
        said = f"{degrees:.0f} degrees C"
        if degrees >= TOO_HOT_C:
            yield fail("processor", said, "cool it: it slows itself down; shade, a heat sink, a fan")
        elif degrees >= HOT_C:
            yield warn("processor", said, f"it slows itself down from {TOO_HOT_C:.0f} on; in the sun it will be hotter")
        else:
            yield ok("processor", said)
    yield from _supply(_text(root / "sys/devices/platform/soc/soc:firmware/get_throttled"))


def _supply(text: str) -> Iterator[Finding]:
    """What a Raspberry Pi says about its supply and its clock rate."""
    try:
        bits = int(text, 16)
    except ValueError:
        return
    now = [words for bit, words in THROTTLED.items() if bits & (1 << bit)]
    was = [words for bit, words in THROTTLED.items() if bits & (1 << (bit + BEFORE)) and words not in now]
    if now:
        yield fail("supply", ", ".join(now), "a supply of 5 V and 3 A (Pi 5: 5 A) and a short cable; cooling")
    if was:
        yield warn("supply", f"since the start: {', '.join(was)}", "look at it under load, with all radios on")
    if not now and not was:
        yield ok("supply", "voltage and temperature held since the start")


def _text(place: Path) -> str:
    try:
        return place.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError):
        return ""


def _number(place: Path) -> float | None:
    try:
        return float(_text(place).split()[0])
    except (ValueError, IndexError):
        return None
