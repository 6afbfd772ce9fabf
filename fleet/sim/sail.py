"""Sail a mission with real agents: start everything, launch as an operator would, follow the timeline, end it all."""

from __future__ import annotations

import contextlib
import signal
import socket
import time
from pathlib import Path

import msgspec

from fleet.agent.clock import SystemClock, warped
from fleet.errors import FleetError, NobodyReachable
from fleet.mission.load import encode
from fleet.mission.model import Event, Mission
from fleet.mission.plan import build
from fleet.mission.timeline import ACTIONS
from fleet.operator import Fleet, Outcome
from fleet.recording.runs import new_run
from fleet.recording.topics import UNSAID
from fleet.sim import passes
from fleet.sim.device import must_have
from fleet.sim.processes import Processes
from fleet.sim.record import RunRecorder
from fleet.sim.share import (
    FLEET,
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
from fleet.sim.suite import must_have_sensors
from fleet.sim.world_process import Begin, Trouble, TruthOfAll, Watch
from fleet.wire import keys
from fleet.wire.codec import Refused, decode, decode_state
from fleet.wire.messages import BoatStatus, FleetEvent

__all__ = ["FLEET", "OPERATOR", "Options", "Progress", "Sailing", "Watcher"]
READY_S = 60.0
ROOM_S = 3.0  # wall time that a launch or a change may take before it applies; warp makes it longer
_decode_truth = msgspec.msgpack.Decoder(TruthOfAll).decode
_encode = msgspec.msgpack.Encoder().encode


class Sailing:
    """One run of one mission."""

    def __init__(self, mission: Mission, name: str, options: Options, watcher: Watcher) -> None:
        must_have(options.driver)
        must_have_sensors(options.sensors)
        self._mission, self._name, self._options, self._watcher = mission, name, options, watcher
        self._plan = build(mission)
        boats = tuple(boat.name for boat in mission.boats)
        if options.credentials not in ("", passes.NEW):
            passes.check(Path(options.credentials), FLEET, boats, OPERATOR)
        self.run = new_run(options.root, name)
        text = as_toml(mission)
        self.run.mission_file.write_bytes(text)
        spec = warped(options.warp)
        self._clock = SystemClock(spec)
        self.credentials = Path(options.credentials) if options.credentials else None
        if options.credentials == passes.NEW:
            self.credentials = passes.found(self.run.folder / "credentials", FLEET, boats, OPERATOR)
        self.processes = Processes(
            self.run.folder,
            spec,
            boats,
            fleet=FLEET,
            topology=options.topology,
            seed=options.seed,
            record=options.record,
            hub_port=options.hub_port,
            control_hz=mission.state_hz,
            driver=options.driver,
            credentials=self.credentials,
            transport=options.transport,
            sensors=options.sensors,
        )
        header = {"seed": str(options.seed), "warp": f"{options.warp:g}", "topology": options.topology}
        header["driver"] = options.driver
        header["sensors"] = options.sensors
        self._recorder = RunRecorder(self.run, self._plan, name, header, text, options.record)
        self._truth = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._truth.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
        self._truth.setblocking(False)
        self.start_ns = 0
        self._progress: Progress | None = None

    def sail(self) -> Path:
        """Sail to the end; the run's folder. FleetError when it could not be begun."""
        try:
            self._start()
            mine = self.credentials / OPERATOR if self.credentials is not None else ""
            with Fleet(
                FLEET,
                connect=self.processes.connect,
                operator=OPERATOR,
                timeout_s=ROOM_S + 2.0 * self._mission.radio.delay_s,
                credentials=mine,
            ) as fleet:
                self._progress = Progress(
                    self._plan, fleet, self.run, self.processes.connect, duration_s=self._mission.duration_s
                )
                self._launch(fleet)
                self._follow(fleet)
                if self._options.keep:
                    self._stay(fleet)
        finally:
            self.processes.close()
            self._recorder.recording.close()
            self._truth.close()
        return self.run.folder

    # -- beginning -------------------------------------------------------------------------------------------------
    def _start(self) -> None:
        mission_file = self.run.folder / "mission.bin"
        mission_file.write_bytes(encode(self._mission))
        self.processes.start_hub()
        self.processes.start_world(mission_file, waits=True)
        self._truth.connect(self.processes.world_address)
        self._truth.send(_encode(Watch()))
        for boat in self._plan.boats:
            if not boat.starts_late:
                self.processes.start_agent(boat.name)

    def _launch(self, fleet: Fleet) -> None:
        present = [boat.name for boat in self._plan.boats if not boat.starts_late]
        deadline = time.monotonic() + READY_S
        while missing := fleet.wait_for(present, 0.1):
            self._drain(fleet)
            died = [boat for boat in self.processes.dead() if boat in missing]
            if died:
                log = self.run.folder / "logs" / f"{died[0]}.log"
                raise FleetError(f"the agent of {died[0]} ended while starting: see {log}")
            if time.monotonic() > deadline:
                raise NobodyReachable(
                    f"{', '.join(missing)}: not ready after {READY_S:g} s; see {self.run.folder}/logs"
                )
            self._show("starting")
        lead = lead_s(self._options.warp)
        launched_ns = self._clock.now_ns()
        self.start_ns = launched_ns + int(lead * 1e9)
        self._recorder.begins_ns = self.start_ns
        self._truth.send(_encode(Begin(self.start_ns)))  # before the launch, which waits for boats that start late
        outcome = fleet.launch(self._mission, apply_in_s=lead)
        self._told(outcome)
        must_not_be_refused(outcome, present)

    # -- under way -------------------------------------------------------------------------------------------------
    def _follow(self, fleet: Fleet) -> None:
        events = sorted(self._mission.timeline, key=lambda event: event.at_s)
        while True:
            t_s = (self._clock.now_ns() - self.start_ns) * 1e-9
            while events and events[0].at_s <= t_s:
                self._act(events.pop(0), fleet)
            self._drain(fleet)
            assert self._progress is not None
            self._progress.t_s = t_s
            self._show("")
            if t_s >= self._mission.duration_s:
                return
            time.sleep(0.02)

    def _stay(self, fleet: Fleet) -> None:
        """Sail on until interrupted, so that other terminals may command."""
        while True:
            self._drain(fleet)
            self._show("sailing on; Ctrl-C ends it")
            time.sleep(0.05)

    def _act(self, event: Event, fleet: Fleet) -> None:
        boats = event.boats or tuple(boat.name for boat in self._mission.boats)
        if ACTIONS[event.do].by == "operator":
            try:
                self._told(say(event, fleet, apply_in_s(self._options.warp)))
            except FleetError as error:
                self._recorder.happened(self._clock.now_ns(), UNSAID, f"{event.do}: {error}")
                if self._progress is not None:
                    self._progress.outcomes.append(Outcome(event.do, "", {}, note=f"not said: {error}"))
            return
        for boat in boats:
            self._break(event, boat)
            self._recorder.happened(self._clock.now_ns(), event.do, f"{event.do} {boat}", boat, event.number)

    def _break(self, event: Event, boat: str) -> None:
        processes = self.processes
        if event.do == "kill":
            processes.signal(boat, signal.SIGKILL)
        elif event.do == "start":
            processes.start_agent(boat)
        elif event.do == "freeze":
            processes.signal(boat, signal.SIGSTOP)
        elif event.do == "thaw":
            processes.signal(boat, signal.SIGCONT)
        else:
            self._truth.send(_encode(Trouble(boat, event.do, event.number)))

    def _told(self, outcome: Outcome) -> None:
        self._recorder.command(self._clock.now_ns(), outcome)
        if self._progress is not None:
            self._progress.outcomes.append(outcome)

    def _drain(self, fleet: Fleet) -> None:
        """Record what the world and the boats said."""
        with contextlib.suppress(BlockingIOError, ConnectionRefusedError):
            while True:
                told = _decode_truth(self._truth.recv(65535))
                self._recorder.truth(told.truths, told.traffic)
        fleet.look(self._take)

    def _take(self, what: str, boat: str, payload: bytes) -> None:
        with contextlib.suppress(Refused):
            if what == keys.STATE:
                self._recorder.state(decode_state(payload, boat))
            elif what == keys.STATUS:
                self._recorder.status(decode(payload, BoatStatus))
            else:
                self._recorder.event(decode(payload, FleetEvent))

    def _show(self, note: str) -> None:
        if self._progress is not None:
            self._progress.note = note
            self._watcher(self._progress)
