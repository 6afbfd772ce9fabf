"""Sail a mission in lock-step: the agents that boats run, one process, no wall clock; equal bits from run to run.

Every tick the world advances by one period, then every agent ticks once, then what they said is delivered. What real
processes have by nature (the time that a process takes to start, a network's lease) is a number here: `Nature`.
"""

from __future__ import annotations

import gc
import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import msgspec
from msgspec import Struct

from fleet import __version__
from fleet.agent.agent import Agent
from fleet.errors import FleetError
from fleet.mission.model import Event, Mission
from fleet.mission.plan import BoatPlan, Plan, build
from fleet.mission.timeline import ACTIONS
from fleet.operator import Fleet, Outcome
from fleet.recording.runs import new_run
from fleet.recording.seam import NullRecorder, Recording
from fleet.recording.topics import UNSAID
from fleet.sim.lockstep_water import LockstepShore, MemoryStore, Mooring, Tap, Tide, WorldDriver
from fleet.sim.record import RunRecorder
from fleet.sim.share import (
    APPLY_S,
    FLEET,
    LEAD_S,
    OPERATOR,
    Options,
    Progress,
    Watcher,
    apply_in_s,
    as_toml,
    lead_s,
    must_not_be_refused,
    say,
)
from fleet.sim.world import STEP_NS, World
from fleet.wire import keys
from fleet.wire.codec import decode, decode_state
from fleet.wire.messages import BoatStatus, FleetEvent
from fleet.wire.radio import RadioBus

BEGIN_NS = 1_700_000_000_000_000_000  # every run begins here: 14 November 2023, 22:13:20 UTC
BOOT = "lockstep"
SHOWN_S = 1.0
TRUTH_S = 0.1
NEVER_S = 1.0e9
NEVER_NS = 1 << 62
COLLECTED_AFTER = 70_000  # objects; usually 700
CLOSED_S = 600.0  # to write what waits; a simulation has the time

RecorderOf = Callable[[str], Recording]


class Nature(Struct, frozen=True, kw_only=True):
    """What real processes have by nature, in simulated time: at warp K everything here takes K times as long."""

    startup_s: float = 0.6  # from the start of an agent's process to its first tick
    lease_s: float = 0.5  # after which the network misses a frozen agent, and lets its token go
    reconnect_s: float = 0.5  # from the thaw of an agent that was missed until its link is up again
    lead_s: float = LEAD_S  # between launch and beginning
    apply_in_s: float = APPLY_S  # of a change of the formation


def at_warp(warp: float, startup_s: float = 0.6) -> Nature:
    """What a real run at that warp has; `startup_s` by the clock on the wall."""
    return Nature(
        startup_s=startup_s * warp,
        lease_s=0.5 * warp,
        reconnect_s=0.5 * warp,
        lead_s=lead_s(warp),
        apply_in_s=apply_in_s(warp),
    )


class Station:
    """One boat: its agent, if it runs, and what outlives it."""

    def __init__(self, tide: Tide, world: World, boat: BoatPlan, seed: int, control_hz: float) -> None:
        self.name = boat.name
        self.starts_ns = 0  # when its agent comes up; 0: it is not to start
        self.frozen_ns = 0  # since when it is frozen; 0: it is not
        self.back_ns = 0  # when its link is up again
        self.agent: Agent | None = None
        self._tide, self._world, self._seed, self._hz = tide, world, seed, control_hz
        self._store = MemoryStore()
        self._mooring = Mooring(tide, boat.name)
        self._radio = RadioBus(self._mooring, boat.name, tide.now_ns, seed)

    def start(self, recording: Recording, now_ns: int) -> None:
        """A new process."""
        self.starts_ns = self.back_ns = 0
        self._mooring = Mooring(self._tide, self.name)
        self._radio = RadioBus(self._mooring, self.name, self._tide.now_ns, self._seed)
        self.agent = Agent(
            self.name,
            self._radio,
            WorldDriver(self._world, self.name),
            self._store,
            recording,
            now_ns,
            boot_id=BOOT,
            control_hz=self._hz,
            clock_ns=0,
        )
        self.agent.picture.directions = self._tide.directions
        self._mooring.open()
        self._mooring.announce()

    def kill(self) -> None:
        """kill -9: nothing is said, nothing is written; the token goes with the socket."""
        self.starts_ns = self.frozen_ns = 0
        if self.agent is not None:
            self._mooring.close()
            self.agent.reporter.recording.close(CLOSED_S)
            self.agent = None

    def freeze(self, now_ns: int) -> None:
        """SIGSTOP."""
        self.frozen_ns = self.frozen_ns or now_ns

    def thaw(self, now_ns: int, nature: Nature) -> None:
        """SIGCONT; a boat that the network has missed must connect anew."""
        self.frozen_ns = 0
        if self._mooring.cut:
            self.back_ns = now_ns + int(nature.reconnect_s * 1e9)

    def link(self, now_ns: int, nature: Nature) -> None:
        """The network misses a frozen agent, and takes back one that connects again."""
        if self.agent is None:
            return
        if self.frozen_ns and not self._mooring.cut and now_ns - self.frozen_ns >= nature.lease_s * 1e9:
            self._mooring.cut = True
            self._tide.token(self.name, False)
        elif self.back_ns and now_ns >= self.back_ns:
            self.back_ns, self._mooring.cut = 0, False
            self._tide.token(self.name, True)

    def tick(self, now_ns: int, delay_s: float, loss: float, down: bool) -> None:
        """One tick of the agent, if it runs."""
        if self.agent is None or self.frozen_ns:
            return
        self.agent.tick(now_ns)
        self._radio.set(delay_s, loss)
        self._radio.set_down(down)


class Lockstep:
    """A fleet and its world, advanced a period at a time."""

    def __init__(
        self,
        plan: Plan,
        *,
        seed: int = 0,
        nature: Nature | None = None,
        recorder_of: RecorderOf = lambda boat: NullRecorder(),
    ) -> None:
        self.plan, self.nature = plan, nature or Nature()
        self.now_ns = BEGIN_NS
        self.period_ns = round(1e9 / plan.mission.state_hz)
        self.world = World(plan, BEGIN_NS, seed)
        self.ids = (f"{OPERATOR}-{number}" for number in count(1))  # of commands
        self.tide = Tide(lambda: self.now_ns, OPERATOR)
        self.shore = LockstepShore(self.tide, self.tick)
        self._recorder_of = recorder_of
        self._taps: list[Tap] = [self.shore.hear]
        self.each_tick: list[Callable[[], None]] = []
        self._hash = hashlib.blake2b(digest_size=16)
        self._encode = msgspec.msgpack.Encoder().encode
        self.stations = {
            boat.name: Station(self.tide, self.world, boat, seed, plan.mission.state_hz) for boat in plan.boats
        }
        for boat in plan.boats:
            if not boat.starts_late:
                self.start(boat.name)

    @property
    def digest(self) -> str:
        """A hash of every decision and of where every hull was: equal runs have equal digests."""
        return self._hash.hexdigest()

    def tap(self, tap: Tap) -> None:
        """Give everything that boats publish to `tap` too."""
        self._taps.append(tap)

    def start(self, boat: str) -> None:
        """Start a boat's agent; it ticks when it has started up."""
        station = self.stations[boat]
        if station.agent is None and not station.starts_ns:
            station.starts_ns = self.now_ns + int(self.nature.startup_s * 1e9)

    def do(self, action: str, boat: str, value: float = 0.0) -> None:
        """The simulator's part of a timeline."""
        station = self.stations[boat]
        if action == "kill":
            station.kill()
        elif action == "start":
            self.start(boat)
        elif action == "freeze":
            station.freeze(self.now_ns)
        elif action == "thaw":
            station.thaw(self.now_ns, self.nature)
        else:
            self.world.trouble(boat, action, value)

    def tick(self) -> None:
        """One period passes."""
        self.now_ns += self.period_ns
        world, now_ns, radio = self.world, self.now_ns, self.plan.mission.radio
        while world.now_ns + STEP_NS <= now_ns:
            world.step()
        for station in self.stations.values():
            if station.starts_ns and station.starts_ns <= now_ns:
                station.start(self._recorder_of(station.name), now_ns)
            station.link(now_ns, self.nature)
        for name, station in self.stations.items():
            ship = world.ships[name]
            station.tick(now_ns, radio.delay_s, radio.loss, ship.radio_down)
            decision = station.agent.decision if station.agent is not None else None
            self._hash.update(self._encode((decision, ship.state)))
        self.tide.flow(self._publish)
        for look in self.each_tick:
            look()

    def _publish(self, what: str, boat: str, payload: bytes) -> None:
        for tap in self._taps:
            tap(what, boat, payload)

    # -- the time that an operator lives by (fleet.operator.view.Time) -----------------------------------------------
    def monotonic(self) -> float:
        """Seconds since the beginning."""
        return (self.now_ns - BEGIN_NS) * 1e-9

    def time_ns(self) -> int:
        """UTC [ns]."""
        return self.now_ns

    def sleep(self, seconds: float, /) -> None:
        """So much time passes, in whole periods."""
        until_ns = self.now_ns + int(seconds * 1e9)
        while self.now_ns < until_ns:
            self.tick()

    def close(self) -> None:
        """End all agents in good order."""
        for station in self.stations.values():
            if station.agent is not None:
                station.agent.reporter.recording.close(CLOSED_S)
                station.agent.close()


@contextmanager
def operator(sim: Lockstep, timeout_s: float = 3.0) -> Iterator[Fleet]:
    """The operator of a simulation: the library that operators use, with the simulation's bus and time."""
    new_id = sim.ids.__next__
    fleet = Fleet(FLEET, connect=(), operator=OPERATOR, timeout_s=timeout_s, bus=sim.shore, clock=sim, new_id=new_id)
    with fleet:
        yield fleet


@contextmanager
def seldom_collected() -> Iterator[None]:
    """The collector looks a hundred times as seldom: ticks leave hardly a cycle, and looking takes a tenth of them."""
    usual = gc.get_threshold()
    gc.set_threshold(COLLECTED_AFTER, *usual[1:])
    try:
        yield
    finally:
        gc.set_threshold(*usual)


class LockstepRun(Struct, frozen=True):
    """What a run in lock-step leaves."""

    folder: Path
    start_ns: int
    digest: str
    """Of all decisions and hulls: equal from run to run, with and without recording."""
    simulated_s: float


def _unwatched(progress: Progress) -> None:
    """Nobody looks."""


class LockstepSailing:
    """One run of one mission in lock-step; used as `fleet.sim.sail.Sailing` is."""

    def __init__(
        self, mission: Mission, name: str, options: Options, watcher: Watcher = _unwatched, nature: Nature | None = None
    ) -> None:
        self._mission, self._watcher = mission, watcher
        self._plan = build(mission)
        self.run = new_run(options.root, name)
        text = as_toml(mission)
        self.run.mission_file.write_bytes(text)
        self._records = options.record
        self.sim = Lockstep(
            self._plan, seed=options.seed, nature=nature, recorder_of=self._record if options.record else _nobody
        )
        header = {"seed": str(options.seed), "way": "lockstep"}
        self._recorder = RunRecorder(self.run, self._plan, name, header, text, options.record, flush_s=NEVER_S)
        self.sim.world.begins_ns = NEVER_NS
        self._shown_ns = self._truth_ns = 0
        self._progress: Progress | None = None
        self.start_ns = 0
        self.sim.each_tick.append(self._look)
        if options.record:
            self.sim.tap(self._take)

    def _record(self, boat: str) -> Recording:
        from fleet.recording.writer import Recorder

        facts = {"boat": boat, "fleet": FLEET, "version": __version__}
        path = self.run.boat_recording(boat)
        return Recorder(path, facts, wait=True, flush_s=NEVER_S, fsync_s=NEVER_S)

    def sail(self) -> Path:
        """Sail to the end; the run's folder."""
        return self.sailed().folder

    def sailed(self) -> LockstepRun:
        """Sail to the end; FleetError when it could not be begun."""
        sim = self.sim
        try:
            with operator(sim, 3.0 + 2.0 * self._mission.radio.delay_s) as fleet:
                self._progress = Progress(self._plan, fleet, self.run, (), duration_s=self._mission.duration_s)
                self._launch(fleet)
                with seldom_collected():
                    self._follow(fleet)
        finally:
            sim.close()
            self._recorder.recording.close(CLOSED_S)
        return LockstepRun(self.run.folder, self.start_ns, sim.digest, sim.monotonic())

    def _launch(self, fleet: Fleet) -> None:
        present = [boat.name for boat in self._plan.boats if not boat.starts_late]
        missing = fleet.wait_for(present, self.sim.nature.startup_s + 10.0)
        if missing:
            raise FleetError(f"{', '.join(missing)}: not ready")
        launched_ns = self.sim.now_ns
        lead = self.sim.nature.lead_s
        self.start_ns = launched_ns + int(lead * 1e9)
        self._recorder.begins_ns = self.sim.world.begins_ns = self.start_ns
        outcome = fleet.launch(self._mission, apply_in_s=lead)
        self._told(outcome)
        must_not_be_refused(outcome, present)

    def _follow(self, fleet: Fleet) -> None:
        events = sorted(self._mission.timeline, key=lambda event: event.at_s)
        end_ns = self.start_ns + int(self._mission.duration_s * 1e9)
        while self.sim.now_ns < end_ns:
            while events and self.start_ns + events[0].at_s * 1e9 <= self.sim.now_ns:
                self._act(events.pop(0), fleet)
            self.sim.tick()

    def _act(self, event: Event, fleet: Fleet) -> None:
        now_ns = self.sim.now_ns
        if ACTIONS[event.do].by == "operator":
            try:
                self._told(say(event, fleet, self.sim.nature.apply_in_s))
            except FleetError as error:
                self._recorder.happened(now_ns, UNSAID, f"{event.do}: {error}")
                if self._progress is not None:
                    self._progress.outcomes.append(Outcome(event.do, "", {}, note=f"not said: {error}"))
            return
        for boat in event.boats or tuple(self.sim.stations):
            self.sim.do(event.do, boat, event.number)
            self._recorder.happened(now_ns, event.do, f"{event.do} {boat}", boat, event.number)

    def _told(self, outcome: Outcome) -> None:
        self._recorder.command(self.sim.now_ns, outcome)
        if self._progress is not None:
            self._progress.outcomes.append(outcome)

    # -- looking -----------------------------------------------------------------------------------------------------
    def _take(self, what: str, boat: str, payload: bytes) -> None:
        if what == keys.STATE:
            self._recorder.state(decode_state(payload, boat))
        elif what == keys.STATUS:
            self._recorder.status(decode(payload, BoatStatus))
        else:
            self._recorder.event(decode(payload, FleetEvent))

    def _look(self) -> None:
        now_ns, world = self.sim.now_ns, self.sim.world
        if self._records and now_ns - self._truth_ns >= TRUTH_S * 1e9:
            self._truth_ns = now_ns
            boats = {boat: world.truth(boat) for boat in world.ships}
            self._recorder.truth(boats, {vessel: world.vessel(vessel) for vessel in world.crafts})
        if self._progress is not None and now_ns - self._shown_ns >= SHOWN_S * 1e9:
            self._shown_ns = now_ns
            self._progress.t_s = (now_ns - self.start_ns) * 1e-9 if self.start_ns else 0.0
            self._progress.note = "" if self.start_ns else "starting"
            self._progress.fleet.look()
            self._watcher(self._progress)


def _nobody(boat: str) -> Recording:  # noqa: ARG001 - a `RecorderOf`
    return NullRecorder()


def sail_lockstep(
    mission: Mission,
    name: str,
    options: Options | None = None,
    watcher: Watcher = _unwatched,
    nature: Nature | None = None,
) -> LockstepRun:
    """Sail a mission in lock-step; FleetError when it could not be begun.

    Args:
        mission: what is sailed
        name: of the run folder
        options: `seed`, `record` and `root` are taken; the others are about processes
        watcher: called every second of the simulation
        nature: what real processes have by nature
    """
    return LockstepSailing(mission, name, options or Options(), watcher, nature).sailed()
