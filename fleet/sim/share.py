"""What the two ways to sail a mission share: real processes (`fleet.sim.sail`) and lock-step (`fleet.sim.lockstep`)."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Literal

import msgspec
from msgspec import Struct

from fleet.errors import FleetError
from fleet.mission.model import Event, Mission
from fleet.mission.plan import Plan
from fleet.operator import Fleet, Outcome
from fleet.recording.runs import Run
from fleet.sim.device import DriverKind
from fleet.sim.passes import Transport
from fleet.sim.suite import SensorKind

LEAD_S = 2.0  # of the launch: boats begin together so long after it [s]
APPLY_S = 2.0  # of a change of the formation
FLEET = "sim"
OPERATOR = "sim-operator"


def lead_s(warp: float) -> float:
    """Between launch and beginning: time that a launch takes on the wall passes faster under warp [s]."""
    return max(LEAD_S, 0.3 * warp)


def apply_in_s(warp: float) -> float:
    """Between a change of the formation and its taking effect [s]."""
    return max(APPLY_S, 0.2 * warp)


class Options(Struct, frozen=True, kw_only=True):
    """How to sail. Lock-step takes `seed`, `record` and `root`; the others are about processes and clocks."""

    warp: float = 1.0
    seed: int = 0
    topology: Literal["hub", "routed", "mesh"] = "hub"
    record: bool = True
    credentials: str = ""  # `new`, or the folder of an authority; "" nothing is signed
    transport: Transport = "tls"
    driver: DriverKind = "simulated"  # of the boats: what stands between hull and agent
    sensors: SensorKind = "simulated"  # of the boats: how they reach the agent
    keep: bool = False
    hub_port: int = 0
    root: str | None = None


class Progress(Struct):
    """What a terminal may show while the mission sails."""

    plan: Plan
    fleet: Fleet
    run: Run
    connect: tuple[str, ...]
    t_s: float = 0.0
    duration_s: float = 0.0
    note: str = ""
    outcomes: list[Outcome] = []


Watcher = Callable[[Progress], None]


def as_toml(mission: Mission) -> bytes:
    """The mission as sailed, overrides and all, as a file."""
    return msgspec.toml.encode(_without_none(msgspec.to_builtins(mission)))


def _without_none(value: object) -> object:
    if isinstance(value, dict):
        return {key: _without_none(v) for key, v in value.items() if v is not None}
    if isinstance(value, (list, tuple)):
        return [_without_none(v) for v in value]
    return value


def say(event: Event, fleet: Fleet, apply_in: float) -> Outcome:
    """An operator's entry of the timeline, said to the fleet; a change of the formation applies in so many seconds."""
    if event.do.startswith("set ") and event.value is not None:
        return fleet.set(event.do.removeprefix("set "), event.value, apply_in_s=apply_in)
    if event.do == "release":
        return fleet.release(event.boats)
    if event.do == "forget":
        return fleet.forget(event.boats)
    return fleet.command(event.do, event.boats)


def must_not_be_refused(launch: Outcome, present: Collection[str]) -> None:
    """FleetError when a boat that is there does not sail; one that starts late need not answer yet."""
    refused = [f"{boat}: {why}" for boat, why in launch.refused.items() if boat in present]
    if refused:
        raise FleetError("launch refused by " + "; ".join(refused))
