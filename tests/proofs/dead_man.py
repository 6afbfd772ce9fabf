"""Who stops the boat when what dies, and after how long, measured in real time with real processes and sockets.

    python -m tests.proofs.dead_man                          all of it, about ten minutes
    python -m tests.proofs.dead_man can "agent killed"       one row

For each driver and each row: a hub, one boat's agent (two where the hub dies) as processes, the simulated autopilot or
thruster controller on its UDP port, the hull; 1 m/s; then it happens. Printed: how long the boat was still driven by
the old command, when it was slower than 0.1 m/s, what the agent says first, and what the boat does then.
"""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable, Iterator
from typing import get_args

from msgspec import Struct

from fleet.drivers.can.frames import MODES
from fleet.drivers.mavlink.words import mode_name
from tests.proofs.afloat import Afloat, Kind

LOOK_S = 14.0
SLOW_MPS = 0.1
ALONE_S = 5.0  # instead of the 30 s of a mission that does not say, so that the row does not take a minute
ROOM_S = 1.0  # beyond the documented limit


class Layer(Struct, frozen=True):
    """One thing that may happen."""

    what: str
    limit_s: dict[Kind, float]  # the old command may last so long, as the driver's page says; others do not have it
    deed: Callable[[Afloat], None]
    acts: dict[Kind, str]  # which layer stops the boat


def _stop_now(boat: Afloat) -> None:
    assert boat.fleet is not None
    boat.fleet.stop_now()


LAYERS = (
    Layer(
        "agent killed (SIGKILL)",
        {"mavlink": 3.0, "can": 0.55},
        lambda boat: boat.signal(signal.SIGKILL),
        {"mavlink": "GUIDED's own limit", "can": "the controller's watchdog"},
    ),
    Layer(
        "agent frozen (SIGSTOP)",
        {"mavlink": 3.0, "can": 0.55},
        lambda boat: boat.signal(signal.SIGSTOP),
        {"mavlink": "GUIDED's own limit", "can": "the controller's watchdog"},
    ),
    Layer(
        "agent ended in good order (SIGTERM)",
        {"mavlink": 0.1, "can": 0.1},
        lambda boat: boat.signal(signal.SIGTERM),
        {"mavlink": "the driver, as it ends", "can": "the driver, as it ends"},
    ),
    Layer(
        "driver's port closed under it",
        {"mavlink": 3.0, "can": 0.55},
        lambda boat: boat.close_socket(),
        {"mavlink": "GUIDED's own limit", "can": "the controller's watchdog"},
    ),
    Layer(
        "cable cut",
        {"mavlink": 3.0, "can": 0.55},
        lambda boat: boat.cut(),
        {"mavlink": "GUIDED's own limit", "can": "the controller's watchdog"},
    ),
    Layer("bus off", {"can": 0.55}, lambda boat: boat.trouble("bus-off"), {"can": "the controller's watchdog"}),
    Layer(
        "autopilot rebooted",
        {"mavlink": 0.1},
        lambda boat: boat.trouble("autopilot-restarts"),
        {"mavlink": "the autopilot: MANUAL, not armed"},
    ),
    Layer(
        "mode taken by the pilot",
        {"mavlink": 0.1, "can": 0.2},
        lambda boat: boat.trouble("pilot-takes"),
        {"mavlink": "the autopilot", "can": "the controller"},
    ),
    Layer(
        "GPS lost",
        {"mavlink": 1.1, "can": 0.55},
        lambda boat: boat.trouble("gnss-down"),
        {"mavlink": "the driver: a fix is good for 1 s", "can": "the driver, then the watchdog"},
    ),
    Layer(
        "operator says stop-now",
        {"mavlink": 0.2, "can": 0.2},  # a tick of the agent, a navigation set or a mode of the device, the hub
        _stop_now,
        {"mavlink": "the agent", "can": "the agent"},
    ),
)


class Row(Struct):
    """What the boat did."""

    kind: Kind
    layer: Layer
    drove_s: float  # on the old command
    again_s: float  # driven again so long after that; 0: not
    stopped_s: float  # until slower than 0.1 m/s; below 0: not within the time looked
    says: str  # what is new in what the agent says, first
    said_s: float
    then: str  # where the device is in the end

    @property
    def holds(self) -> bool:
        """Whether the old command ended in time."""
        return self.drove_s <= self.layer.limit_s[self.kind] + ROOM_S


def measure(kind: Kind, layer: Layer, look_s: float = LOOK_S) -> Row:
    """Let it happen, and look."""
    afloat = Afloat(kind)
    try:
        afloat.sail()
        boat = afloat.boats[0]
        before = boat.told[-1][1] if boat.told else ""
        began = time.monotonic()
        layer.deed(afloat)
        afloat.wait(lambda: boat.looks[-1].at_s > began + look_s, look_s + 5.0, "looking on")
        looks = [look for look in boat.looks if look.at_s >= began]
        said = next(((at, text) for at, text in boat.told if at >= began and text != before), None)
        off = next((look.at_s for look in looks if not look.drives), began + look_s)
        again = next((look.at_s for look in looks if look.at_s > off and look.drives), off)
        slow = next((look.at_s for look in looks if look.speed_mps < SLOW_MPS), began - 1.0)
        return Row(
            kind=kind,
            layer=layer,
            drove_s=off - began,
            again_s=again - off,
            stopped_s=slow - began,
            says=said[1] if said is not None else "",
            said_s=said[0] - began if said is not None else 0.0,
            then=_then(afloat),
        )
    finally:
        afloat.close()


def _then(afloat: Afloat) -> str:
    one = afloat.devices[afloat.boats[0].name]
    if afloat.kind == "can":
        return f"controller: {MODES[one.controller.mode(afloat.world.now_ns)]}"
    return f"{mode_name(one.rover.mode)}, {'armed' if one.rover.armed else 'not armed'}"


class Lonely(Struct):
    """Two boats whose hub dies: nobody stops, since nobody commands from there."""

    kind: Kind
    alone_s: float  # until the first says that it is alone
    hold_s: float  # after that, until it holds
    speed_mps: float  # least, while alone


def hub_killed(kind: Kind) -> Lonely:
    """Kill the hub under a column of two, and look."""
    afloat = Afloat(kind, boats=2, alone_for_s=ALONE_S)
    try:
        afloat.sail()
        began = time.monotonic()
        afloat.hub.kill()
        boats = afloat.boats

        def first(mode: str, name: int) -> float:
            return next((at for at, text in boats[name].told if at >= began and text.startswith(mode)), 0.0)

        afloat.wait(lambda: all(first("hold", n) for n in (0, 1)), 30.0, "both hold")
        alone, hold = max(first("alone", n) for n in (0, 1)), max(first("hold", n) for n in (0, 1))
        speeds = [look.speed_mps for boat in boats for look in boat.looks if began <= look.at_s < hold]
        return Lonely(kind, alone - began, hold - alone, min(speeds))
    finally:
        afloat.close()


def rows(kinds: tuple[Kind, ...], words: list[str]) -> Iterator[Row]:
    """All rows whose words are asked for."""
    for kind in kinds:
        for layer in LAYERS:
            if kind in layer.limit_s and (not words or any(word in layer.what for word in words)):
                yield measure(kind, layer)


def line(row: Row) -> str:
    """A row of the table."""
    limit = f"{row.layer.limit_s[row.kind]:g} s"
    stop = f"{row.stopped_s:.1f} s" if row.stopped_s >= 0.0 else "-"
    again = f"; driven again {row.again_s:.1f} s later" if row.again_s > 0.0 else ""
    says = f"{row.says.split(', not recording')[0]} ({row.said_s:.1f} s)" if row.says else "nothing"
    held = "" if row.holds else " **too long**"
    acts = row.layer.acts[row.kind]
    return (
        f"| `{row.kind}` | {row.layer.what} | {acts} | {limit} | {row.drove_s:.2f} s{held} | {stop}{again} | {says} |"
        f" {row.then} |"
    )


def main(argv: list[str]) -> int:
    """Print the table; 1 if a row took too long."""
    known: tuple[Kind, ...] = get_args(Kind)
    kinds = tuple(kind for kind in known if kind in argv) or known
    words = [word for word in argv if word not in known]
    head = "| driver | what happened | what stops the boat | documented | old command lasted | < 0.1 m/s after |"
    print(f"{head} the agent says | then |")
    print("|---|---|---|---|---|---|---|---|")
    wrong = 0
    for row in rows(kinds, words):
        print(line(row), flush=True)
        wrong += not row.holds
    if not words or "hub killed" in words:
        print("\n| driver | hub killed: `alone` after | then holds after | least speed until then |\n|---|---|---|---|")
        for kind in kinds:
            seen = hub_killed(kind)
            print(f"| `{kind}` | {seen.alone_s:.1f} s | {seen.hold_s:.1f} s | {seen.speed_mps:.2f} m/s |", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
