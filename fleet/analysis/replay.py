"""Replay: call `step` again with what a boat recorded, and say where, if anywhere, it decides otherwise.

Every tick is given the state, the inputs and the path that were recorded; decision and next state are compared bit for
bit. What the shell around `step` did to the state between two ticks (a new path laid, a process started) is told apart
from what `step` returned. On request every tick is also one lane of a batch (`replay_lanes`).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from fleet import __version__
from fleet.agent import course as courses
from fleet.agent.agent import tuning
from fleet.agent.report import Inputs, Laid, course_topic
from fleet.agent.step import Decision, State, StepParams, start, step
from fleet.analysis.bits import filled, unlike
from fleet.analysis.replay_lanes import Alone, Batches
from fleet.analysis.replayed import BoatReplay, Difference, Replay, ShellChange
from fleet.avoidance import Method
from fleet.errors import FleetError, RecordingError
from fleet.guidance import Limits
from fleet.mission.load import decode as decode_mission
from fleet.mission.model import KeepingClear
from fleet.mission.plan import Plan, build
from fleet.paths import Lane, lane
from fleet.paths import Path as Curve
from fleet.recording.disk import parts
from fleet.recording.reader import RecordingFile
from fleet.recording.runs import Run
from fleet.recording.seam import Message
from fleet.recording.topics import decision_topic, inputs_topic

KEPT = 1000  # differences of one boat that are kept one by one; all are counted


def replay(where: Path | str, lanes: int = 0) -> Replay:
    """Replay a run folder (every boat in it), or one recording with all its parts.

    Args:
        where: a run folder, or a recording
        lanes: decide every tick as one lane of a batch of so many, too, and compare; 0 not

    Raises:
        RecordingError: there is nothing to replay
    """
    path = Path(where)
    files = [Run(path).boat_recording(boat) for boat in Run(path).boats()] if path.is_dir() else [path]
    if not files:
        raise RecordingError(f"{path}: no boat recorded itself; expected boats/<name>.mcap")
    boats: dict[str, Replayer] = {}
    notes: list[str] = []
    batches = Batches(lanes) if lanes else None
    for file in files:
        found = parts(file)
        if not found:
            raise RecordingError(f"{file}: no such file; expected a run folder or a boat's recording")
        for one in found:
            _replay_file(one, boats, notes, batches)
    if not boats:
        raise RecordingError(f"{path}: no inputs of a boat in it; expected topics such as /<boat>/inputs")
    if batches is not None:
        batches.done()
    results = [replayer.done() for replayer in boats.values()]
    for other in sorted({boat.version for boat in results} - {"", __version__}):
        notes.append(f"recorded by fleet {other}, replayed by {__version__}: differences may be meant")
    return Replay(str(path), results, notes)


def _replay_file(path: Path, boats: dict[str, Replayer], notes: list[str], batches: Batches | None) -> None:
    """One file, whole or damaged."""
    with RecordingFile(path) as file:
        names = [topic.split("/")[1] for topic in file.topics if topic.count("/") == 2 and topic.endswith("/inputs")]
        wanted: dict[str, tuple[Replayer, str]] = {}
        for name in names:
            replayer = boats.setdefault(name, Replayer(name, batches))
            replayer.result.version = replayer.result.version or file.header.get("version", "")
            for kind, topic in (("laid", course_topic), ("inputs", inputs_topic), ("decision", decision_topic)):
                wanted[topic(name)] = (replayer, kind)
        for message in file.messages(wanted):
            replayer, kind = wanted[message.topic]
            replayer.take(kind, message)
        if not file.whole:
            notes.append(f"{path.name} was not closed: read up to its last whole chunk")
        if file.bad_chunks:
            notes.append(f"{path.name}: {file.bad_chunks} chunks are damaged and were passed over")


class Replayer:
    """One boat's messages in order, tick by tick."""

    def __init__(self, boat: str, batches: Batches | None = None) -> None:
        self.result = BoatReplay(boat)
        self._batches = batches
        self._encode = msgspec.msgpack.Encoder().encode
        self._inputs = msgspec.msgpack.Decoder(Inputs)
        self._laid = msgspec.msgpack.Decoder(Laid)
        self._plans: dict[bytes, Plan] = {}
        self._states: dict[str, Any] = {}  # decoder of the state, by method
        self._path: Curve | Lane | None = None
        self._method: Method
        self._params: StepParams
        self._method, self._params = tuning(KeepingClear(), Limits())
        self._unknown = "the path is not known: the recording begins later"
        self._tick = 0
        self._next: State[float, Any] | None = None  # what step returned last
        self._numbers: list[float] = []
        self._decision: bytes | None = None  # replayed, until the recorded one comes
        self._relaid = ""
        self._differs = False

    def take(self, kind: str, message: Message) -> None:
        """The next message."""
        if kind == "laid":
            self._lay(message)
        elif kind == "inputs":
            self._step(message)
        else:
            self._compare(message)

    def done(self) -> BoatReplay:
        """The last tick has been."""
        self._close_tick()
        return self.result

    # -- what step is given ------------------------------------------------------------------------------------------
    def _begin(self) -> None:
        """A process starts: no mission and no path, unless it laid one within its first tick."""
        if not self._relaid:
            self._path, self._unknown = courses.at_point(0.0, 0.0).path, ""
            self._method, self._params = tuning(KeepingClear(), Limits())
        self._next = start(0.0, 0.0, self._method.start(0.0, 0))
        self._numbers = []
        self.result.starts += 1

    def _lay(self, message: Message) -> None:
        """Another path from this tick on."""
        self._relaid, self._path = "path laid", None
        try:
            laid = self._laid.decode(message.payload)
            self.result.version = laid.version
            clear, limits = KeepingClear(), Limits()
            plan = self._plan(laid.mission) if laid.mission else None
            if plan is not None and laid.number >= 0:
                clear, limits = plan.mission.keeping_clear, plan.boats[laid.number].limits
            self._method, self._params = tuning(clear, limits, plan)
            self._path = _path(laid, plan)
            self._unknown = "the path of its kind is not known to this version" if self._path is None else ""
        except (msgspec.DecodeError, FleetError, KeyError, IndexError) as error:
            self._unknown = f"the path laid at {message.stamp_ns} cannot be built: {error}"

    def _plan(self, mission: bytes) -> Plan:
        plan = self._plans.get(mission)
        if plan is None:
            plan = self._plans[mission] = build(decode_mission(mission))
        return plan

    # -- a tick ------------------------------------------------------------------------------------------------------
    def _step(self, message: Message) -> None:
        self._close_tick()
        self.result.ticks += 1
        try:
            given = self._inputs.decode(message.payload)
        except msgspec.DecodeError as error:
            self._skip(f"the inputs do not decode: {error}")
            return
        if given.tick == 1:
            self._begin()
        elif self._tick and given.tick != self._tick + 1:
            self.result.missing += max(given.tick - self._tick - 1, 0)
            self._next = None
        self._tick = given.tick
        if self._path is None:
            self._skip(self._unknown)
            return
        numbers = [peer.number for peer in given.peers]
        try:
            state = self._state(given.state)
            self._chain(given, numbers, message.stamp_ns)
            nav, members, peers, order = given.nav, given.members, given.peers, given.order
            method, params = self._method, self._params
            path, dt, abroad, leader = self._path, given.dt, given.abroad, given.leader
            after, decision = step(state, nav, members, peers, order, path, method, params, dt, abroad, leader)
        except msgspec.DecodeError as error:
            self._skip(f"the state does not decode: {error}")
            return
        except (ArithmeticError, ValueError, TypeError, IndexError) as error:
            self._differ(message.stamp_ns, "step", "decided", f"{type(error).__name__}: {error}")
            self._next = None
            return
        self.result.replayed += 1
        self._in_lanes(given, state, after, decision, message.stamp_ns)
        self._next, self._numbers, self._relaid = after, numbers, ""
        self._decision = self._encode(decision)

    def _in_lanes(
        self, given: Inputs, state: State[float, Any], after: State[float, Any], decision: Decision[float], at_ns: int
    ) -> None:
        """The same tick once more, as a lane; its verdict comes when the batch is full."""
        if self._batches is None:
            return
        if given.abroad is not None:
            self.result.notes.setdefault("foreign vessels in sight: decided alone, not as lanes", given.tick)
            return
        assert self._path is not None
        if given.leader is not None or isinstance(self._path, Lane):
            what = "a leader" if given.leader is not None else "a lane beside the path"
            self.result.notes.setdefault(f"{what}: decided alone, not as lanes", given.tick)
            return
        decided = partial(self._lane_decided, given.tick, at_ns)
        self._batches.put(Alone(given, state, self._path, self._method, self._params, after, decision, decided))

    def _lane_decided(self, tick: int, stamp_ns: int, unlike_it: list[tuple[str, Any, Any]]) -> None:
        self.result.lanes += 1
        self.result.lanes_differing += bool(unlike_it)
        for field, alone, in_batch in unlike_it:
            self._keep(tick, stamp_ns, field, alone, in_batch)

    def _state(self, raw: msgspec.Raw) -> State[float, Any]:
        decoder = self._states.get(self._method.name)
        if decoder is None:
            kind = State[float, self._method.memory]  # type: ignore[name-defined]
            decoder = self._states[self._method.name] = msgspec.msgpack.Decoder(kind)
        try:
            state: State[float, Any] = decoder.decode(raw)
        except msgspec.ValidationError:  # of a version that remembered less: the rest as step itself would remember it
            base = self._next or start(0.0, 0.0, self._method.start(0.0, 0))
            tree = filled(msgspec.to_builtins(base), msgspec.msgpack.decode(raw))
            state = decoder.decode(self._encode(tree))
            note = "fields of the state were not recorded: taken from the tick before"
            self.result.filled += 1
            self.result.notes.setdefault(note, self._tick)
        return state

    def _chain(self, given: Inputs, numbers: list[float], stamp_ns: int) -> None:
        """The state that was recorded must be the one that step returned, aligned with the peers of this tick."""
        expected = self._next
        if expected is None:
            return
        if numbers != self._numbers and not self._relaid:
            keep = self._method.align(expected.keep, self._numbers, numbers)
            expected = msgspec.structs.replace(expected, keep=keep)
            self.result.realigned += 1
        encoded = self._encode(expected)
        if encoded == bytes(given.state):
            return
        differ = list(unlike(msgspec.msgpack.decode(given.state), msgspec.msgpack.decode(encoded)))
        if self._relaid:
            fields = tuple(field for field, _, _ in differ)
            self.result.changes.append(ShellChange(self.result.boat, given.tick, stamp_ns, self._relaid, fields))
            return
        for field, recorded, replayed in differ:
            self._differ(stamp_ns, f"next.{field}", recorded, replayed, self._tick - 1)

    def _compare(self, message: Message) -> None:
        replayed, self._decision = self._decision, None
        if replayed is None or replayed == message.payload:
            return
        try:
            recorded = msgspec.msgpack.decode(message.payload)
        except msgspec.DecodeError as error:
            self._skip(f"the decision does not decode: {error}")
            return
        for field, old, new in unlike(recorded, msgspec.msgpack.decode(replayed)):
            self._differ(message.stamp_ns, field, old, new)

    def _differ(self, stamp_ns: int, field: str, recorded: Any, replayed: Any, tick: int | None = None) -> None:
        self._differs = True
        self._keep(self._tick if tick is None else tick, stamp_ns, field, recorded, replayed)

    def _keep(self, tick: int, stamp_ns: int, field: str, recorded: Any, replayed: Any) -> None:
        if len(self.result.differences) < KEPT:
            self.result.differences.append(Difference(self.result.boat, tick, stamp_ns, field, recorded, replayed))

    def _close_tick(self) -> None:
        self.result.differing += self._differs
        self._differs, self._decision = False, None

    def _skip(self, why: str) -> None:
        self.result.skipped[why] = self.result.skipped.get(why, 0) + 1
        self._next = None


def _path(laid: Laid, plan: Plan | None) -> Curve | Lane | None:
    """The path that was laid; None when its kind is not known."""
    if laid.kind == "mission" and plan is not None:
        return lane(plan.boats[laid.number].path, laid.abeam, laid.shift)
    if laid.kind == "point":
        return courses.at_point(*laid.points[0]).path
    track = courses.of_track(laid.points) if laid.kind == "track" else None
    return track.path if track is not None else None
