"""N real agents with hub and world on this machine, in standby and then sailing: what they and the kernel noted."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from bench.agent_process import NOTES, Notes
from bench.procs import Threads, machine_ns, memory_mib, threads
from bench.scenes import mission
from bench.timing import calibration, percentile
from fleet.agent.clock import warped
from fleet.mission.load import encode
from fleet.mission.model import Vessel
from fleet.operator import Fleet
from fleet.sim.device import DriverKind
from fleet.sim.processes import Processes
from fleet.sim.suite import SensorKind

ROOT = Path(__file__).resolve().parent.parent
FLEET = "bench"
HZ = 10.0
SETTLE_S = 3.0
APPLY_S = 3.0


class Watched(Processes):
    """As `fleet sim` starts them, but with the agents watched."""

    def _spawn(self, name: str, *argv: str, answers: bool = False) -> str:
        module = "bench.agent_process" if argv[0] == "fleet.agent" else argv[0]
        return super()._spawn(name, module, *argv[1:], answers=answers)


class Window(msgspec.Struct):
    """One stretch of time in which nothing was changed."""

    name: str
    began_ns: int
    ended_ns: int
    agents: dict[str, Threads]
    hub: Threads
    world: Threads
    tick_us: list[float]  # CPU of the loop's thread from tick to tick, all agents
    late_ms: list[float]
    heard: int
    could: float  # messages that were due between the first and the last look at the counters
    lost: int
    skipped: int  # ticks that did not take place
    rss: list[float]
    pss: list[float]
    unit_us: float  # the calibration loop, meanwhile, warm
    slept_us: float  # the calibration loop once after a sleep, as an agent's tick begins
    strangers: float  # cores that processes of others used meanwhile

    @property
    def seconds(self) -> float:
        """How long."""
        return (self.ended_ns - self.began_ns) * 1e-9

    def late(self, share: float) -> float:
        """Percentile of the lateness [ms]."""
        return percentile(self.late_ms, share)


class Result(msgspec.Struct):
    """One fleet, from start to end."""

    boats: int
    start_s: float  # from the first process until every boat is alive and heard
    first_tick_cpu_ms: float  # median over the agents
    windows: dict[str, Window]
    worst_launch_ms: float  # CPU of the tick that takes the mission, median over the agents


def run(
    boats: int,
    standby_s: float,
    sailing_s: float,
    say: Callable[[str], None],
    driver: DriverKind = "simulated",
    sensors: SensorKind = "simulated",
    traffic: tuple[Vessel, ...] = (),
) -> Result:
    """Start, watch in standby, launch, watch sailing, end."""
    os.environ["PYTHONPATH"] = str(ROOT)
    plan = mission(boats, *traffic)
    names = tuple(boat.name for boat in plan.boats)
    with tempfile.TemporaryDirectory(prefix="fleet-bench-") as place:
        folder = Path(place)
        (folder / "boats").mkdir()
        mission_file = folder / "mission.bin"
        mission_file.write_bytes(encode(plan))
        options: dict[str, Any] = {"fleet": FLEET, "topology": "hub", "seed": 1, "record": True, "control_hz": HZ}
        processes = Watched(folder, warped(1.0), names, driver=driver, sensors=sensors, **options)
        began = time.monotonic()
        try:
            processes.start_hub()
            processes.start_world(mission_file)
            for name in names:
                processes.start_agent(name)
            with Fleet(FLEET, connect=processes.connect, operator="bench", timeout_s=10.0) as fleet:
                missing = fleet.wait_for(names, 120.0)
                if missing:
                    raise RuntimeError(f"not ready after 120 s: {', '.join(missing)}")
            start_s = time.monotonic() - began
            say(f"  {boats} agents up after {start_s:.1f} s")
            time.sleep(SETTLE_S)
            windows = [_window("standby", processes, names, standby_s)]
            with Fleet(FLEET, connect=processes.connect, operator="bench", timeout_s=20.0) as fleet:
                launched_ns = time.monotonic_ns()
                fleet.wait_for(names, 10.0)
                outcome = fleet.launch(plan, apply_in_s=APPLY_S)
                if outcome.refused or None in outcome.acks.values():
                    raise RuntimeError("launch refused or not answered: " + "; ".join(outcome.lines()))
            time.sleep(APPLY_S + SETTLE_S)
            windows.append(_window("sailing", processes, names, sailing_s))
        finally:
            processes.close()
        notes = [msgspec.msgpack.decode((folder / "state" / name / NOTES).read_bytes(), type=Notes) for name in names]
    for window in windows:
        _fill(window, notes)
    first = percentile([note.first_tick_cpu_ns * 1e-6 for note in notes], 0.5)
    launch = [max(_ticks_us(note, launched_ns, windows[1].began_ns), default=0.0) for note in notes]
    return Result(boats, start_s, first, {w.name: w for w in windows}, percentile(launch, 0.5) * 1e-3)


def _window(name: str, processes: Processes, boats: tuple[str, ...], seconds: float) -> Window:
    """Let the fleet be for a while; the calibration loop is run a few times on the way."""
    pids = {boat: processes.pid(boat) for boat in boats}
    hub, world = processes.pid("hub"), processes.pid("world")
    before = {boat: threads(pid) for boat, pid in pids.items()}
    hub_before, world_before = threads(hub), threads(world)
    machine = machine_ns()
    began, own = time.monotonic_ns(), time.process_time_ns()
    units: list[float] = []
    slept: list[float] = []
    while time.monotonic_ns() - began < seconds * 1e9:
        slept.append(_calibrated_us(1))
        units.append(_calibrated_us(20))
        time.sleep(0.25)
    ended = time.monotonic_ns()
    spent_by = {boat: threads(pid).since(before[boat]) for boat, pid in pids.items()}
    hub_spent, world_spent = threads(hub).since(hub_before), threads(world).since(world_before)
    ours = sum(x.all for x in spent_by.values()) + hub_spent.all + world_spent.all + time.process_time_ns() - own
    strangers = max(0.0, (machine_ns() - machine - ours) / (ended - began))
    memory = [memory_mib(pid) for pid in pids.values()]
    return Window(
        name=name,
        began_ns=began,
        ended_ns=ended,
        agents=spent_by,
        hub=hub_spent,
        world=world_spent,
        tick_us=[],
        late_ms=[],
        heard=0,
        could=0.0,
        lost=0,
        skipped=0,
        rss=[rss for rss, _ in memory],
        pss=[pss for _, pss in memory],
        unit_us=percentile(units, 0.5),
        slept_us=percentile(slept, 0.5),
        strangers=strangers,
    )


def _calibrated_us(times: int) -> float:
    began = time.thread_time_ns()
    for _ in range(times):
        calibration()
    return (time.thread_time_ns() - began) * 1e-3 / times


def _ticks_us(note: Notes, began_ns: int, ended_ns: int) -> list[float]:
    """CPU of the loop's thread from each tick of a stretch to the next [us]."""
    return [
        (after - spent) * 1e-3
        for at, spent, after in zip(note.at_ns, note.spent_ns, note.spent_ns[1:], strict=False)
        if began_ns <= at < ended_ns
    ]


def _fill(window: Window, notes: list[Notes]) -> None:
    """Add what the agents noted in this window."""
    for note in notes:
        window.tick_us += _ticks_us(note, window.began_ns, window.ended_ns)
        late = [
            ns * 1e-6
            for at, ns in zip(note.at_ns, note.late_ns, strict=True)
            if window.began_ns <= at < window.ended_ns
        ]
        window.late_ms += late
        window.skipped += max(0, int(window.seconds * HZ) - len(late))
        counted = [c for c in note.counted if window.began_ns <= c[0] < window.ended_ns]
        if len(counted) > 1:
            window.heard += counted[-1][1] - counted[0][1]
            window.lost += counted[-1][2] - counted[0][2]
            window.could += (counted[-1][0] - counted[0][0]) * 1e-9 * HZ * (len(notes) - 1)
