"""`fleet drive`: one boat on a line at the quay, driven for some seconds while a key is held."""

from __future__ import annotations

import contextlib
import math
import os
import select
import sys
import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated

import typer

from fleet.cli import say
from fleet.cli.doctor import FIND_S, Endpoint, OwnSysid, SigningKey, Sysid, config
from fleet.errors import FleetError, UsageError

if TYPE_CHECKING:
    from fleet.drivers.mavlink.ashore import Ashore

LONGEST_S, FASTEST_MPS, FASTEST_RADPS = 30.0, 1.0, 0.5
HELD_S = 0.7  # a key that is held repeats; without one for so long the boat stops
FIRST_S = 20.0  # for the first key
TAKE_S, STOP_S = 20.0, 4.0
SHOWN_S = 0.5
SEEN_RADPS, SEEN_MPS = 0.02, 0.05  # what counts as having turned, as having moved


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command("drive")(drive)


def drive(
    endpoint: Endpoint,
    surge: Annotated[float, typer.Option(metavar="MPS", help="Along the heading, + ahead; at most 1.")] = 0.0,
    yaw_rate: Annotated[float, typer.Option(metavar="RADPS", help="+ to starboard; at most 0.5.")] = 0.0,
    for_: Annotated[float, typer.Option("--for", metavar="SECONDS", help="At most 30.")] = 5.0,
    arm: Annotated[bool, typer.Option("--arm", help="Arm the boat, and disarm it at the end.")] = False,
    sysid: Sysid = 1,
    own_sysid: OwnSysid = 254,
    signing_key: SigningKey = "",
) -> None:
    """Drive one boat at the quay and check the signs; it moves only while you hold a key down.

    No agent may talk to the autopilot at the same time. Exit code 1 if the boat did not do what it was told.
    """
    _within("--surge", surge, FASTEST_MPS, "m/s")
    _within("--yaw-rate", yaw_rate, FASTEST_RADPS, "rad/s")
    if not 0.0 < for_ <= LONGEST_S:
        raise UsageError(f"--for {for_:g}: expected more than 0 and at most {LONGEST_S:g} s")
    if surge == 0.0 and yaw_rate == 0.0:
        raise UsageError("nothing to do: expected --surge, --yaw-rate or both")
    chosen = config(endpoint, sysid, own_sysid, arm="operator" if arm else "never", signing_key=signing_key)
    if not sys.stdin.isatty():
        raise UsageError("the dead-man is a key that is held down, and there is no terminal to hold it on")
    from fleet.drivers.mavlink.ashore import Ashore

    link = Ashore(chosen)
    try:
        link.find(FIND_S)
        was_armed = link.driver.vehicle.armed
        try:
            with _keys():
                seen = _session(link, surge, yaw_rate, for_)
        finally:
            _stop(link, disarm=arm and not was_armed)
    finally:
        link.close()
    wrong = _judge(seen, surge, yaw_rate)
    for line in wrong:
        say.error(line)
    if wrong:
        raise typer.Exit(1)
    say.out("the boat does what it is told")


def _within(option: str, value: float, most: float, unit: str) -> None:
    if not abs(value) <= most:
        raise UsageError(f"{option} {value:g}: expected {-most:g} to {most:g} {unit}")


@contextlib.contextmanager
def _keys() -> Iterator[None]:
    """Keys one by one, without being shown."""
    import termios
    import tty

    before = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)
    try:
        yield
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def _pressed() -> bool:
    """Whether a key came since the last look."""
    came = False
    while select.select([sys.stdin], [], [], 0.0)[0]:
        if not os.read(sys.stdin.fileno(), 64):
            return False  # the terminal is gone
        came = True
    return came


def _session(link: Ashore, surge: float, yaw_rate: float, for_s: float) -> list[tuple[float, float]]:
    """Take the boat, drive it while a key is held; (surge, yaw rate) seen while it was driven."""
    say.note(f"hold a key (space) to drive {surge:+.2f} m/s, {yaw_rate:+.2f} rad/s for {for_s:g} s; let go to stop")
    deadline = time.monotonic() + FIRST_S
    while not _pressed():
        link.tick()
        if time.monotonic() > deadline:
            raise FleetError(f"no key within {FIRST_S:g} s: nothing was driven")
    link.driver.obeyed("launch")
    seen: list[tuple[float, float]] = []
    held = shown = time.monotonic()
    took, driven_s, last = time.monotonic() + TAKE_S, 0.0, time.monotonic()
    while driven_s < for_s:
        link.tick()
        now = time.monotonic()
        held = now if _pressed() else held
        if now - held > HELD_S:
            say.note("let go: stopping")
            break
        if link.reading.authority:
            raise FleetError(f"somebody else commands the boat: {link.reading.authority}")
        refused = link.driver.write(surge, yaw_rate)
        if refused and now > took:
            raise FleetError(f"the boat cannot be driven: {refused}")
        if not refused:
            driven_s += now - last
            seen.append((_surge(link), link.reading.yaw_rate_radps))
        last = now
        if now - shown > SHOWN_S:
            shown = now
            _show(link, driven_s, refused)
    return seen


def _surge(link: Ashore) -> float:
    """Velocity over ground along the heading [m/s]."""
    r = link.reading
    return r.v_north_mps * math.cos(r.heading_rad) + r.v_east_mps * math.sin(r.heading_rad)


def _show(link: Ashore, driven_s: float, refused: str) -> None:
    r = link.reading
    heading = math.degrees(r.heading_rad) % 360.0
    where = f"{r.lat_deg:.6f} {r.lon_deg:.6f}  heading {heading:3.0f} deg"
    motion = f"surge {_surge(link):+.2f} m/s  yaw rate {r.yaw_rate_radps:+.2f} rad/s  battery {r.battery_percent:.0f} %"
    say.out(f"{driven_s:4.1f} s  {where}  {motion}  {refused or 'driving'}")


def _stop(link: Ashore, *, disarm: bool) -> None:
    """Zero velocity, then as the autopilot stays; disarm what we armed."""
    deadline = time.monotonic() + STOP_S
    while time.monotonic() < deadline and abs(_surge(link)) > SEEN_MPS:
        link.tick()
        link.driver.neutral()
    link.driver.neutral()
    for text in dict.fromkeys(link.heard):
        say.note(f"the autopilot says: {text}")
    if disarm and link.driver.vehicle.armed and not link.reading.authority:
        link.driver.link.send(link.driver.talk.arm(False))
        if not link.wait(lambda: not link.driver.vehicle.armed, 3.0):
            say.warning("the boat is still armed")


def _judge(seen: list[tuple[float, float]], surge: float, yaw_rate: float) -> list[str]:
    """What did not come as it was told, in the second half of what was seen."""
    late = [one for one in seen[len(seen) // 2 :] if math.isfinite(sum(one))]
    if len(late) < 5:
        return ["driven for too short a time, or without a position: the signs cannot be judged"]
    u, r = (sum(column) / len(late) for column in zip(*late, strict=True))
    said = f"on average {u:+.2f} m/s and {r:+.2f} rad/s, asked {surge:+.2f} m/s and {yaw_rate:+.2f} rad/s"
    wrong = []
    if surge and (u * surge <= 0.0 or abs(u) < SEEN_MPS):
        wrong.append(f"surge: {said}; expected the boat to move {'ahead' if surge > 0.0 else 'astern'}")
    if yaw_rate and (r * yaw_rate <= 0.0 or abs(r) < SEEN_RADPS):
        wrong.append(f"yaw rate: {said}; expected a turn to {'starboard' if yaw_rate > 0.0 else 'port'}")
    say.out(said)
    return wrong
