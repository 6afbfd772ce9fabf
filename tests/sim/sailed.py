"""Missions sailed by real processes for the tests: what happened, as events, truth and figures."""

from __future__ import annotations

import os
from bisect import bisect_left
from collections.abc import Callable, Mapping
from math import hypot
from pathlib import Path

import msgspec

from fleet.analysis.metrics import Summary, summarise
from fleet.mission.load import load
from fleet.recording import topics
from fleet.recording.reader import read
from fleet.sim.sail import Options, Progress, Sailing

Deed = Callable[[Sailing, Progress], None]


class Sailed:
    """A run, read back."""

    def __init__(self, folder: Path, sailing: Sailing) -> None:
        self.folder, self.sailing = folder, sailing
        self.events: list[topics.Event] = []
        self.states: dict[str, list[topics.State]] = {}
        self.truths: dict[str, list[topics.Truth]] = {}
        self.summary: Summary = summarise(folder)
        for message in read(folder / "run.mcap"):
            if message.topic == topics.EVENT:
                self.events.append(msgspec.json.decode(message.payload, type=topics.Event))
            elif message.topic.startswith("/truth/"):
                truth = msgspec.json.decode(message.payload, type=topics.Truth)
                self.truths.setdefault(message.topic.split("/")[2], []).append(truth)
            elif message.topic.endswith("/state"):
                state = msgspec.json.decode(message.payload, type=topics.State)
                self.states.setdefault(message.topic.split("/")[1], []).append(state)
        self.own: dict[str, list[topics.Event]] = {}
        self.own_states: dict[str, list[topics.State]] = {}
        for file in sorted((folder / "boats").glob("??.mcap")):
            boat = file.name.split(".")[0]
            for message in read(file):
                if message.topic == topics.EVENT:
                    event = msgspec.json.decode(message.payload, type=topics.Event)
                    self.own.setdefault(boat, []).append(event)
                elif message.topic == topics.state_topic(boat):
                    state = msgspec.json.decode(message.payload, type=topics.State)
                    self.own_states.setdefault(boat, []).append(state)
        self.start_ns = sailing.start_ns

    def t(self, stamp_ns: int) -> float:
        """Seconds since the mission began."""
        return (stamp_ns - self.start_ns) * 1e-9

    def happened(self, kind: str, boat: str = "", after_s: float = -1e9) -> list[topics.Event]:
        """Events of a kind."""
        return [e for e in self.events if e.kind == kind and boat in ("", e.boat) and self.t(e.stamp_ns) >= after_s]

    def modes(self, boat: str, since_s: float, until_s: float) -> set[str]:
        """Modes that a boat published in a span of time."""
        return {s.mode for s in self.states[boat] if since_s <= self.t(s.stamp_ns) <= until_s}

    def reasons(self, boat: str, since_s: float, until_s: float) -> set[str]:
        """Reasons that a boat published in a span of time."""
        found = (s.reasons for s in self.states[boat] if since_s <= self.t(s.stamp_ns) <= until_s)
        return {reason for reasons in found for reason in reasons}

    def own_modes(self, boat: str, since_s: float, until_s: float) -> set[str]:
        """Modes that a boat wrote down itself in a span of time."""
        return {s.mode for s in self.own_states[boat] if since_s <= self.t(s.stamp_ns) <= until_s}

    def position_error(self, boat: str, state: topics.State) -> float:
        """Metres between where a boat said it was and where it was then, between two truths 0.1 s apart."""
        truths = self.truths[boat]
        after = bisect_left(truths, state.stamp_ns, key=lambda truth: truth.stamp_ns)
        one, two = truths[after - 1], truths[after]
        share = (state.stamp_ns - one.stamp_ns) / (two.stamp_ns - one.stamp_ns)
        x_m, y_m = one.x_m + share * (two.x_m - one.x_m), one.y_m + share * (two.y_m - one.y_m)
        return hypot(state.x_m - x_m, state.y_m - y_m)

    def speed(self, boat: str, at_s: float) -> float:
        """True speed over ground at a time."""
        truth = min(self.truths[boat], key=lambda one: abs(self.t(one.stamp_ns) - at_s))
        assert truth.vx_mps is not None
        assert truth.vy_mps is not None
        return float((truth.vx_mps**2 + truth.vy_mps**2) ** 0.5)


def sail(
    mission: str,
    folder: Path,
    *overrides: str,
    at: Mapping[float, Deed] | None = None,
    warp: float = 8.0,
    **options: object,
) -> Sailed:
    """Sail a mission with real processes; `at` does something at a simulated time."""
    deeds = sorted((at or {}).items())

    def watch(progress: Progress) -> None:
        while deeds and progress.note == "" and progress.t_s >= deeds[0][0]:
            deeds.pop(0)[1](sailing, progress)

    chosen = Options(warp=warp, root=str(folder), **options)  # type: ignore[arg-type]
    sailing = Sailing(load(mission, overrides), "test", chosen, watch)
    path = sailing.sail()
    for pid in sailing.processes.pids:
        assert not _runs(pid), f"process {pid} was left behind"
    return Sailed(path, sailing)


def _runs(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True
