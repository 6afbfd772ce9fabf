"""Replay: call `step` again with what a boat recorded, and say where, if anywhere, it decides otherwise.

Every tick is given the state, the inputs and the path that were recorded; decision and next state are compared bit for
bit. What the shell around `step` did to the state between two ticks (a new path laid, a process started) is told apart
from what `step` returned.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from fleet import __version__
from fleet.agent import course as courses
from fleet.agent.agent import tuning
from fleet.agent.report import Inputs, Laid, course_topic
from fleet.agent.step import PathLike, State, StepParams, start, step
from fleet.avoidance import Method
from fleet.errors import FleetError, RecordingError
from fleet.guidance import Limits
from fleet.mission.load import decode as decode_mission
from fleet.mission.model import KeepingClear
from fleet.mission.plan import Plan, build
from fleet.recording.disk import parts
from fleet.recording.reader import RecordingFile
from fleet.recording.runs import Run
from fleet.recording.seam import Message
from fleet.recording.topics import decision_topic, inputs_topic

KEPT = 1000  # differences of one boat that are kept one by one; all are counted


class Difference(Struct, frozen=True):
    """One number that came out otherwise."""

    boat: str
    tick: int
    stamp_ns: int
    field: str
    """Of the decision, or `next.` and a field of the state for the tick after."""
    recorded: float | str | None
    replayed: float | str | None

    @property
    def size(self) -> float:
        """How far apart, infinite where that is not a number."""
        if isinstance(self.recorded, int | float) and isinstance(self.replayed, int | float):
            apart = abs(self.recorded - self.replayed)
            return apart if apart == apart else math.inf  # noqa: PLR0124 - NaN
        return math.inf


class ShellChange(Struct, frozen=True):
    """The shell replaced the state between two ticks: no decision of `step`."""

    boat: str
    tick: int
    stamp_ns: int
    why: str
    fields: tuple[str, ...]
    """Of the state, that changed."""


class BoatReplay(Struct):
    """What came of one boat's recording."""

    boat: str
    version: str = ""
    ticks: int = 0
    """Ticks that were recorded."""
    replayed: int = 0
    differing: int = 0
    """Ticks that came out otherwise."""
    differences: list[Difference] = []
    changes: list[ShellChange] = []
    realigned: int = 0
    """Times that the memory was aligned with other peers; replayed and compared like everything else."""
    starts: int = 0
    """Processes that began in this recording."""
    missing: int = 0
    """Ticks that are not in the recording, though earlier and later ones are."""
    filled: int = 0
    """Ticks whose state lacked fields that this version has."""
    notes: dict[str, int] = {}
    """What else there is to say, with the first tick that it is about."""
    skipped: dict[str, int] = {}
    """Ticks that could not be replayed, by reason."""


class Replay(Struct):
    """What came of a recording."""

    source: str
    boats: list[BoatReplay]
    notes: list[str]

    @property
    def ticks(self) -> int:
        """Ticks replayed, all boats together."""
        return sum(boat.replayed for boat in self.boats)

    @property
    def differences(self) -> list[Difference]:
        """All that were kept, by boat and tick."""
        return [one for boat in self.boats for one in boat.differences]

    @property
    def changes(self) -> list[ShellChange]:
        """What the shell changed."""
        return [one for boat in self.boats for one in boat.changes]

    @property
    def same(self) -> bool:
        """Whether something was replayed, and all of it came out alike."""
        return self.ticks > 0 and not any(boat.differing for boat in self.boats)

    @property
    def exit_code(self) -> int:
        """0 all alike; 1 otherwise."""
        return 0 if self.same else 1

    def lines(self) -> list[str]:
        """For a person."""
        found = [f"{self.source}: {note}" for note in self.notes]
        for boat in self.boats:
            verdict = (
                f"{boat.differing} differ" if boat.differing else "all alike" if boat.replayed else "nothing to say"
            )
            found.append(
                f"{boat.boat}: {boat.replayed} of {boat.ticks} ticks replayed, {verdict}; "
                f"{boat.starts} starts, {len(boat.changes)} changes by the shell, {boat.missing} ticks missing"
            )
            found += [f"{boat.boat}: from tick {tick}: {note}" for note, tick in boat.notes.items()]
            found += [f"{boat.boat}: {count} ticks not replayed: {why}" for why, count in boat.skipped.items()]
            found += [f"  {line}" for line in summary_of(boat.differences)]
        return found

    def as_json(self) -> dict[str, Any]:
        """The same as one object."""
        return {"same": self.same, "ticks": self.ticks, "version": __version__, **msgspec.to_builtins(self)}


def summary_of(differences: Iterable[Difference]) -> list[str]:
    """One line a field: first tick with both values, how often, the largest size."""
    by_field: dict[tuple[str, str], list[Difference]] = {}
    for one in differences:
        by_field.setdefault((one.boat, one.field), []).append(one)
    return [
        f"{boat} {field}: first at tick {many[0].tick}, recorded {many[0].recorded!r}, replayed {many[0].replayed!r}; "
        f"{len(many)} times, at most {max(one.size for one in many):.3g} apart"
        for (boat, field), many in by_field.items()
    ]


def replay(where: Path | str) -> Replay:
    """Replay a run folder (every boat in it), or one recording with all its parts.

    Raises:
        RecordingError: there is nothing to replay
    """
    path = Path(where)
    files = [Run(path).boat_recording(boat) for boat in Run(path).boats()] if path.is_dir() else [path]
    if not files:
        raise RecordingError(f"{path}: no boat recorded itself; expected boats/<name>.mcap")
    boats: dict[str, Replayer] = {}
    notes: list[str] = []
    for file in files:
        for one in parts(file) or [file]:
            _replay_file(one, boats, notes)
    if not boats:
        raise RecordingError(f"{path}: no inputs of a boat in it; expected topics such as /<boat>/inputs")
    found = [replayer.done() for replayer in boats.values()]
    for other in sorted({boat.version for boat in found} - {"", __version__}):
        notes.append(f"recorded by fleet {other}, replayed by {__version__}: differences may be meant")
    return Replay(str(path), found, notes)


def _replay_file(path: Path, boats: dict[str, Replayer], notes: list[str]) -> None:
    """One file, whole or damaged."""
    with RecordingFile(path) as file:
        names = [topic.split("/")[1] for topic in file.topics if topic.count("/") == 2 and topic.endswith("/inputs")]
        wanted: dict[str, tuple[Replayer, str]] = {}
        for name in names:
            replayer = boats.setdefault(name, Replayer(name))
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

    def __init__(self, boat: str) -> None:
        self.result = BoatReplay(boat)
        self._encode = msgspec.msgpack.Encoder().encode
        self._inputs = msgspec.msgpack.Decoder(Inputs)
        self._laid = msgspec.msgpack.Decoder(Laid)
        self._plans: dict[bytes, Plan] = {}
        self._states: dict[str, Any] = {}  # decoder of the state, by method
        self._path: PathLike[float] | None = None
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
            self._method, self._params = tuning(clear, limits)
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
            after, decision = step(state, nav, members, peers, order, self._path, method, params, given.dt)
        except msgspec.DecodeError as error:
            self._skip(f"the state does not decode: {error}")
            return
        except (ArithmeticError, ValueError, TypeError, IndexError) as error:
            self._differ(message.stamp_ns, "step", "decided", f"{type(error).__name__}: {error}")
            self._next = None
            return
        self.result.replayed += 1
        self._next, self._numbers, self._relaid = after, numbers, ""
        self._decision = self._encode(decision)

    def _state(self, raw: msgspec.Raw) -> State[float, Any]:
        decoder = self._states.get(self._method.name)
        if decoder is None:
            kind = State[float, self._method.memory]  # type: ignore[name-defined]
            decoder = self._states[self._method.name] = msgspec.msgpack.Decoder(kind)
        try:
            state: State[float, Any] = decoder.decode(raw)
        except msgspec.ValidationError:  # of a version that remembered less: the rest as step itself would remember it
            base = self._next or start(0.0, 0.0, self._method.start(0.0, 0))
            tree = _filled(msgspec.to_builtins(base), msgspec.msgpack.decode(raw))
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
        unlike = list(_unlike(msgspec.msgpack.decode(given.state), msgspec.msgpack.decode(encoded)))
        if self._relaid:
            fields = tuple(field for field, _, _ in unlike)
            self.result.changes.append(ShellChange(self.result.boat, given.tick, stamp_ns, self._relaid, fields))
            return
        for field, recorded, replayed in unlike:
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
        for field, old, new in _unlike(recorded, msgspec.msgpack.decode(replayed)):
            self._differ(message.stamp_ns, field, old, new)

    def _differ(self, stamp_ns: int, field: str, recorded: Any, replayed: Any, tick: int | None = None) -> None:
        self._differs = True
        if len(self.result.differences) < KEPT:
            at = self._tick if tick is None else tick
            self.result.differences.append(Difference(self.result.boat, at, stamp_ns, field, recorded, replayed))

    def _close_tick(self) -> None:
        self.result.differing += self._differs
        self._differs, self._decision = False, None

    def _skip(self, why: str) -> None:
        self.result.skipped[why] = self.result.skipped.get(why, 0) + 1
        self._next = None


def _filled(base: Any, tree: Any) -> Any:
    """The tree, with what only `base` has."""
    if isinstance(base, dict) and isinstance(tree, dict):
        return {**base, **{key: _filled(base.get(key), value) for key, value in tree.items()}}
    return tree


def _path(laid: Laid, plan: Plan | None) -> PathLike[float] | None:
    """The path that was laid; None when its kind is not known."""
    if laid.kind == "mission" and plan is not None:
        return plan.boats[laid.number].path
    if laid.kind == "point":
        return courses.at_point(*laid.points[0]).path
    track = courses.of_track(laid.points) if laid.kind == "track" else None
    return track.path if track is not None else None


def _unlike(a: Any, b: Any, name: str = "") -> Iterator[tuple[str, Any, Any]]:
    """(field, value in a, value in b) wherever two trees of numbers differ in a bit, of the fields that both have.

    A field that the other version does not know is no difference of decision.
    """
    if isinstance(a, dict) and isinstance(b, dict):
        for key in a:
            if key in b:
                yield from _unlike(a[key], b[key], f"{name}.{key}" if name else str(key))
    elif isinstance(a, list | tuple) and isinstance(b, list | tuple):
        if len(a) != len(b):
            yield f"{name}.length", len(a), len(b)
        for i, (one, other) in enumerate(zip(a, b, strict=False)):
            yield from _unlike(one, other, f"{name}.{i}")
    elif not _same(a, b):
        yield name, a, b


def _same(a: Any, b: Any) -> bool:
    """Equal to the last bit: -0.0 is not 0.0, NaN is NaN."""
    if isinstance(a, int | float) and isinstance(b, int | float):
        return (a == b and math.copysign(1.0, a) == math.copysign(1.0, b)) or (a != a and b != b)  # noqa: PLR0124
    return bool(a == b)
