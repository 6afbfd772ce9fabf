"""`fleet drive`: one boat on a line at the quay, driven for some seconds while a key is held."""

from __future__ import annotations

import contextlib
import math
import os
import select
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from fleet.cli import say
from fleet.cli.doctor import FIND_S, OwnSysid, SigningKey, Sysid, config
from fleet.errors import FleetError, UsageError

if TYPE_CHECKING:
    from fleet.agent.config import AgentConfig
    from fleet.agent.quay import Quay

LONGEST_S, FASTEST_MPS, FASTEST_RADPS = 30.0, 1.0, 0.5
HELD_S = 0.7  # a key that is held repeats; without one for so long the boat stops
FIRST_S = 20.0  # for the first key
TAKE_S, AT_ONCE_S = 20.0, 3.0  # to be driven: by an autopilot that must be armed, by another driver
STOP_S, DISARM_S = 4.0, 3.0
SHOWN_S = 0.5
SEEN_RADPS, SEEN_MPS = 0.02, 0.05  # what counts as having turned, as having moved
LEAST_SEEN = 5  # looks at how the boat moved, to judge by
ENDS = (signal.SIGHUP, signal.SIGTERM)
SYSID, OWN_SYSID = 1, 254
Seen = list[tuple[float, float]]


def add_to(app: typer.Typer) -> None:
    """Register the command."""
    app.command("drive")(drive)


def drive(
    endpoint: Annotated[
        str,
        typer.Argument(metavar="ENDPOINT", help="Of an autopilot: udp:HOST:PORT, tcp:HOST:PORT, serial:DEVICE:BAUD."),
    ] = "",
    boat: Annotated[
        Path | None, typer.Option("--config", metavar="FILE", help="The boat's TOML file, instead: any driver.")
    ] = None,
    surge: Annotated[float, typer.Option(metavar="MPS", help="Along the heading, + ahead; at most 1.")] = 0.0,
    yaw_rate: Annotated[float, typer.Option(metavar="RADPS", help="+ to starboard; at most 0.5.")] = 0.0,
    for_: Annotated[float, typer.Option("--for", metavar="SECONDS", help="At most 30.")] = 5.0,
    arm: Annotated[bool, typer.Option("--arm", help="Arm an autopilot, and disarm it at the end.")] = False,
    sysid: Sysid = SYSID,
    own_sysid: OwnSysid = OWN_SYSID,
    signing_key: SigningKey = "",
) -> None:
    """Drive one boat at the quay and check the signs; it moves only while you hold a key down.

    With the driver and the sensors of the boat's own file, or of an autopilot by its endpoint. No agent may run for
    this boat at the same time; one on this computer is seen, and nothing is driven. Exit code 1 if the boat did not
    do what it was told; what nothing on board measures is not judged, and said.
    """
    _within("--surge", surge, FASTEST_MPS, "m/s")
    _within("--yaw-rate", yaw_rate, FASTEST_RADPS, "rad/s")
    if not 0.0 < for_ <= LONGEST_S:
        raise UsageError(f"--for {for_:g}: expected more than 0 and at most {LONGEST_S:g} s")
    if surge == 0.0 and yaw_rate == 0.0:
        raise UsageError("nothing to do: expected --surge, --yaw-rate or both")
    if (boat is None) == (endpoint == ""):
        raise UsageError("which boat? expected either ENDPOINT of an autopilot or --config FILE")
    if boat is not None and (sysid, own_sysid, signing_key) != (SYSID, OWN_SYSID, ""):
        raise UsageError("--sysid, --own-sysid, --signing-key: the boat's file says them; expected none with --config")
    chosen = _of_file(boat, arm=arm) if boat is not None else _of_endpoint(endpoint, sysid, own_sysid, signing_key, arm)
    if not sys.stdin.isatty():
        raise UsageError("the dead-man is a key that is held down, and there is no terminal to hold it on")
    from fleet.agent.quay import Quay

    with _ends_in_good_order():
        quay = Quay(chosen)
        try:
            quay.find(FIND_S)
            was_armed = quay.armed
            try:
                with _keys():
                    seen = _session(quay, surge, yaw_rate, for_)
            finally:
                _stop(quay, disarm=arm and not was_armed)
        finally:
            quay.close()
    _judge(seen, surge, yaw_rate)


def _of_endpoint(endpoint: str, sysid: int, own_sysid: int, signing_key: str, arm: bool) -> AgentConfig:
    """An autopilot and nothing else."""
    mavlink = config(endpoint, sysid, own_sysid, signing_key=signing_key)
    from fleet.agent.config import AgentConfig, DriverConfig
    from fleet.agent.quay import at_quay

    return at_quay(AgentConfig(driver=DriverConfig(kind="mavlink", mavlink=mavlink)), arm=arm)


def _of_file(path: Path, *, arm: bool) -> AgentConfig:
    """Driver and sensors of a boat."""
    from fleet.agent.config import load_config
    from fleet.agent.quay import at_quay
    from fleet.doctor.wiring import agent_of

    boat = load_config(path)
    if arm and boat.driver.kind != "mavlink":
        raise UsageError(f'--arm: driver.kind = "{boat.driver.kind}" has nothing that is armed; leave it out')
    agent = agent_of(boat.fleet, boat.boat)
    if agent:
        raise FleetError(f"an agent of {boat.boat} runs, process {agent}: it has the boat; stop it first")
    return at_quay(boat, arm=arm)


def _within(option: str, value: float, most: float, unit: str) -> None:
    if not abs(value) <= most:
        raise UsageError(f"{option} {value:g}: expected {-most:g} to {most:g} {unit}")


@contextlib.contextmanager
def _ends_in_good_order() -> Iterator[None]:
    """A terminal that hangs up, or somebody who ends us, is an error like others: the boat is stopped first."""

    def end(number: int, frame: object) -> None:  # noqa: ARG001
        for one in ENDS:
            signal.signal(one, signal.SIG_IGN)
        raise FleetError(f"ended by {signal.Signals(number).name}")

    before = [signal.signal(one, end) for one in ENDS]
    try:
        yield
    finally:
        for one, handler in zip(ENDS, before, strict=True):
            signal.signal(one, handler)


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
        with contextlib.suppress(termios.error):  # the terminal is gone
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def _pressed() -> bool:
    """Whether a key came since the last look."""
    came = False
    while select.select([sys.stdin], [], [], 0.0)[0]:
        if not os.read(sys.stdin.fileno(), 64):
            return False  # the terminal is gone
        came = True
    return came


def _session(quay: Quay, surge: float, yaw_rate: float, for_s: float) -> Seen:
    """Take the boat, drive it while a key is held; (surge, yaw rate) seen while it was driven."""
    say.note(f"hold a key (space) to drive {surge:+.2f} m/s, {yaw_rate:+.2f} rad/s for {for_s:g} s; let go to stop")
    deadline = time.monotonic() + FIRST_S
    while not _pressed():
        quay.tick()
        if time.monotonic() > deadline:
            raise FleetError(f"no key within {FIRST_S:g} s: nothing was driven")
    quay.permit()
    quay.asked = surge, yaw_rate
    seen: Seen = []
    held = shown = last = time.monotonic()
    took = last + (TAKE_S if quay.arms is not None else AT_ONCE_S)
    driven_s = 0.0
    while driven_s < for_s:
        quay.tick()
        now = time.monotonic()
        held = now if _pressed() else held
        if now - held > HELD_S:
            say.note("let go: stopping")
            break
        if quay.reading.authority:
            raise FleetError(f"somebody else commands the boat: {quay.reading.authority}")
        refused = quay.drive(surge, yaw_rate)
        if refused and now > took:
            raise FleetError(f"the boat cannot be driven: {refused}")
        if not refused:
            driven_s += now - last
            seen.append((quay.surge_mps, quay.yaw_rate_radps))
        last = now
        if now - shown > SHOWN_S:
            shown = now
            _show(quay, driven_s, refused)
    return seen


def _show(quay: Quay, driven_s: float, refused: str) -> None:
    lat, lon = quay.place
    where = _known("{:.6f}", lat) + " " + _known("{:.6f}", lon)
    heading = _known("{:3.0f}", math.degrees(quay.heading_rad) % 360.0)
    motion = f"surge {_known('{:+.2f}', quay.surge_mps)} m/s  yaw rate {_known('{:+.2f}', quay.yaw_rate_radps)} rad/s"
    battery = _known("{:.0f}", quay.reading.battery_percent)
    does = refused or "driving"
    say.out(f"{driven_s:4.1f} s  {where}  heading {heading} deg  {motion}  battery {battery} %  {does}")


def _known(form: str, value: float) -> str:
    return form.format(value) if math.isfinite(value) else "?"


def _stop(quay: Quay, *, disarm: bool) -> None:
    """No thrust, or as an autopilot stays; disarm what we armed. Nothing is said before the boat is stopped."""
    quay.stop()
    deadline = time.monotonic() + STOP_S
    while time.monotonic() < deadline and abs(quay.surge_mps) > SEEN_MPS:
        quay.tick()
        quay.stop()
    quay.stop()
    disarmed = not disarm or quay.disarm(DISARM_S)
    for text in dict.fromkeys(quay.heard):
        say.note(f"the boat says: {text}")
    for text in quay.reading.amiss:
        say.note(f"not heard: {text}")
    if not disarmed:
        say.warning("the boat is still armed")


class Axis(NamedTuple):
    """How one of two set-points is judged."""

    name: str
    unit: str
    least: float  # what counts as having moved
    ahead: str  # what a positive one does
    astern: str
    measure: str  # what says how it moves


AXES = (
    Axis("surge", "m/s", SEEN_MPS, "the boat to move ahead", "the boat to move astern", "velocity and heading"),
    Axis("yaw rate", "rad/s", SEEN_RADPS, "a turn to starboard", "a turn to port", "yaw rate or heading"),
)


def _judge(seen: Seen, surge: float, yaw_rate: float) -> None:
    """Say whether the boat did what it was told, by the second half of what was seen; exit code 1 if it did not."""
    late = seen[len(seen) // 2 :]
    if len(late) < LEAST_SEEN:
        raise FleetError("driven for too short a time: the signs cannot be judged")
    wrong, right, unknown = [], [], []
    for axis, asked, column in zip(AXES, (surge, yaw_rate), zip(*late, strict=True), strict=True):
        known = [one for one in column if math.isfinite(one)]
        if len(known) < LEAST_SEEN:
            unknown += [f"{axis.name} was not judged: nothing on board tells {axis.measure}"] if asked else []
            continue
        mean = sum(known) / len(known)
        told = f"{axis.name}: on average {mean:+.2f} {axis.unit}, asked {asked:+.2f}"
        say.out(told)
        if asked and (mean * asked <= 0.0 or abs(mean) < axis.least):
            wrong.append(f"{told}; expected {axis.ahead if asked > 0.0 else axis.astern}")
        elif asked:
            right.append(axis.name)
    for line in unknown:
        say.warning(line)
    for line in wrong:
        say.error(line)
    if wrong:
        raise typer.Exit(1)
    if not unknown:
        say.out("the boat does what it is told")
    elif right:
        say.out(f"the boat does what it is told in {right[0]}")
    else:
        say.out("whether the boat does what it is told, only you have seen")
