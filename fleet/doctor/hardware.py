"""Does the driver open, and does the boat's hardware answer?"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator

from fleet.agent.config import AgentConfig
from fleet.agent.hardware import driver_of
from fleet.doctor.finding import Finding, fail, ok, warn
from fleet.drivers.seam import Driver, Reading
from fleet.errors import FleetError

LOOK_S = 0.05
Makes = Callable[[AgentConfig, Callable[[], int]], Driver]
ADVICE = {
    "mavlink": "fleet doctor mavlink ENDPOINT tells more; endpoint, baud rate, sysid?",
    "can": "candump shows what is on the bus; does the controller run, is the DBC its own?",
    "simulated": "it wants a world: fleet sim starts one",
}


def driver(config: AgentConfig, agent: int, patience_s: float, makes: Makes | None = None) -> Iterator[Finding]:
    """Open it, wait for a reading, close it; nothing is commanded.

    Args:
        config: the boat's
        agent: process of an agent of this boat that runs, 0 where there is none; it has the driver then
        patience_s: for the first reading
        makes: the driver of a configuration, not yet open; the agent's own when None
    """
    kind = config.driver.kind
    if agent:
        yield warn("driver", f"{kind}: left to the agent that runs, process {agent}", "fleet status tells what it says")
        return
    advice = ADVICE.get(kind, "the manual of its package")
    try:
        made = (makes or (lambda config, now_ns: driver_of(config, now_ns)[0]))(config, time.time_ns)
        made.open()
    except FleetError as error:
        yield fail("driver", f"{kind}: {error}", advice)
        return
    try:
        reading = _first(made, patience_s)
    finally:
        made.close()
    if reading.trouble and not reading.stamp_ns:
        yield fail("driver", f"{kind}: {reading.trouble}", advice)
        return
    if not reading.stamp_ns:
        yield fail("driver", f"{kind}: it opens, and says nothing within {patience_s:g} s", advice)
        return
    yield ok("driver", f"{kind}: {_in_words(reading)}")
    if not math.isfinite(reading.lat_deg + reading.lon_deg):
        yield fail("driver", f"{kind}: no position", "antenna, sky, time since the start; " + advice)
    if not math.isfinite(reading.heading_rad):
        yield fail("driver", f"{kind}: no heading", "compass, its calibration; " + advice)
    if reading.trouble:
        yield warn("driver", f"{kind}: {reading.trouble}", advice)
    if reading.authority:
        yield warn("driver", f"{kind}: commanded by {reading.authority}", "the transmitter's switch; it is respected")
    if made.simulated:
        yield warn("driver", f"{kind}: simulated", "driver.kind for a boat on the water: mavlink, can, ...")


def _first(made: Driver, patience_s: float) -> Reading:
    """The first reading with a stamp and without trouble, or the last that came."""
    deadline = time.monotonic() + patience_s
    while True:
        reading = made.read()
        if (reading.stamp_ns and not reading.trouble) or time.monotonic() > deadline:
            return reading
        time.sleep(LOOK_S)


def _in_words(reading: Reading) -> str:
    parts = [f"{reading.lat_deg:.6f} {reading.lon_deg:.6f}"]
    if math.isfinite(reading.heading_rad):
        parts.append(f"heading {math.degrees(reading.heading_rad) % 360.0:.0f} deg")
    if reading.position_error_m:
        parts.append(f"right to {reading.position_error_m:.1f} m")
    if math.isfinite(reading.battery_percent):
        parts.append(f"battery {reading.battery_percent:.0f} %")
    return ", ".join(parts)
