"""What the two ways to sail a mission share: real processes (`fleet.sim.sail`) and lock-step (`fleet.sim.lockstep`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import msgspec
from msgspec import Struct

from fleet.mission.model import Event, Mission
from fleet.mission.plan import Plan
from fleet.operator import Fleet, Outcome
from fleet.recording.runs import Run

LEAD_S = 2.0  # of the launch: boats begin together so long after it [s]
FLEET = "sim"
OPERATOR = "sim-operator"


class Options(Struct, frozen=True, kw_only=True):
    """How to sail. Lock-step takes `seed`, `record` and `root`; the others are about processes and clocks."""

    warp: float = 1.0
    seed: int = 0
    topology: Literal["hub", "routed", "mesh"] = "hub"
    record: bool = True
    keep: bool = False
    hub_port: int = 0
    root: str | None = None
    drawing: bool = True


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


def say(event: Event, fleet: Fleet, apply_in_s: float) -> Outcome:
    """An operator's entry of the timeline, said to the fleet."""
    value = event.value or 0.0
    if event.do == "set spacing":
        return fleet.set_spacing(value, apply_in_s=apply_in_s)
    if event.do == "set speed":
        return fleet.set_speed(value, apply_in_s=apply_in_s)
    if event.do == "release":
        return fleet.release(event.boats)
    if event.do == "forget":
        return fleet.forget(event.boats)
    return fleet.command(event.do, event.boats)
