"""What a boat decided alone, decided once more as one lane of a batch: other ticks are the other lanes.

Ticks of one method and tuning wait until they fill a batch. Each has its own time step, and `step` takes one for all
lanes: so the batch is decided once for every time step in it, and the lanes that have it are looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import msgspec
from msgspec import Struct
from msgspec.structs import astuple, replace

from fleet.agent.report import Inputs
from fleet.agent.step import Decision, PathLike, State, StepParams, step
from fleet.analysis.bits import unlike
from fleet.avoidance import Method
from fleet.avoidance.types import Peer
from fleet.coordination import Member
from fleet.ops import FloatArray
from fleet.paths import Lane, Path, PathPoint

ABSENT: Peer[float] = Peer(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
NOBODY: Member[float] = Member(0.0, 0.0)


class Alone(Struct, frozen=True):
    """A tick as one boat decided it, on floats."""

    given: Inputs
    state: State[float, Any]
    path: Path | Lane
    method: Method
    params: StepParams
    after: State[float, Any]
    decision: Decision[float]
    decided: Callable[[list[tuple[str, Any, Any]]], None]
    """Told what the lane has otherwise: field, alone, in the batch."""


class Batches:
    """Batches of so many lanes, each lane a tick."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._waiting: dict[tuple[str, StepParams], list[Alone]] = {}
        self._encode = msgspec.msgpack.Encoder().encode

    def put(self, tick: Alone) -> None:
        """One tick more; decided when the batch is full."""
        key = (tick.method.name, tick.params)
        waiting = self._waiting.setdefault(key, [])
        waiting.append(tick)
        if len(waiting) == self._count:
            self._decide(self._waiting.pop(key))

    def done(self) -> None:
        """No more ticks: what waits fills a batch by being in it several times."""
        while self._waiting:
            self._decide(self._waiting.popitem()[1])

    def _decide(self, ticks: Sequence[Alone]) -> None:
        import numpy as np

        lanes = [ticks[i % len(ticks)] for i in range(self._count)]
        method, params = lanes[0].method, lanes[0].params
        numbers = sorted({peer.number for tick in ticks for peer in tick.given.peers})
        most = max(len(tick.given.members) for tick in ticks)
        path = _paths([tick.path for tick in lanes])
        state = _stacked([_for_peers(tick.state, method, _numbers(tick), numbers) for tick in lanes])
        nav, order = (_stacked([getattr(tick.given, name) for tick in lanes]) for name in ("nav", "order"))
        members = _stacked([(*tick.given.members, *[NOBODY] * (most - len(tick.given.members))) for tick in lanes])
        peers = _stacked([_columns(tick.given.peers, numbers) for tick in lanes])
        steps = np.array([tick.given.dt for tick in ticks])
        for dt in np.unique(steps).tolist():
            after, decision = step(state, nav, members, peers, order, path, method, params, dt)
            for i in np.flatnonzero(steps == dt).tolist():
                back = _for_peers(_lane(after, i), method, numbers, _numbers(ticks[i]))
                self._compare(ticks[i], back, _lane(decision, i))

    def _compare(self, tick: Alone, after: State[float, Any], decision: Decision[float]) -> None:
        found: list[tuple[str, Any, Any]] = []
        for prefix, alone, lane in (("lane.", tick.decision, decision), ("lane.next.", tick.after, after)):
            one, other = self._encode(alone), self._encode(lane)
            if one != other:
                differ = unlike(msgspec.msgpack.decode(one), msgspec.msgpack.decode(other))
                found += [(prefix + field, a, b) for field, a, b in differ]
        tick.decided(found)


class _Each:
    """Paths of lanes that no table holds, such as one beside another: each evaluated by itself."""

    def __init__(self, paths: Sequence[Path | Lane]) -> None:
        self._paths = paths

    def at(self, s: FloatArray) -> PathPoint[FloatArray]:
        """The points at abscissae s [m]."""
        found: PathPoint[FloatArray] = _stacked([p.at(v) for p, v in zip(self._paths, s.tolist(), strict=True)])
        return found

    def straight(self, s: FloatArray) -> FloatArray:
        """Metres ahead of s for which the course stays within 10 deg."""
        found: FloatArray = _stacked([p.straight(v) for p, v in zip(self._paths, s.tolist(), strict=True)])
        return found


def _paths(paths: Sequence[Path | Lane]) -> PathLike[FloatArray]:
    """A path for each lane of the batch."""
    from fleet.paths.table import PathTable

    known = {id(path): path for path in paths}
    curves = [path for path in known.values() if isinstance(path, Path)]
    if len(curves) < len(known):
        return _Each(paths)
    place = {number: i for i, number in enumerate(known)}
    return PathTable(curves, [place[id(path)] for path in paths])


def _numbers(tick: Alone) -> list[float]:
    return [peer.number for peer in tick.given.peers]


def _for_peers(state: State[float, Any], method: Method, old: list[float], new: list[float]) -> State[float, Any]:
    """The state with its memory aligned with other peers, and none of foreign vessels: there are none."""
    return replace(state, keep=method.align(state.keep, old, new), foreign=None)


def _columns(peers: Sequence[Peer[float]], numbers: list[float]) -> tuple[Peer[float], ...]:
    """A column for every number; masked where this tick has no such peer."""
    here = {peer.number: peer for peer in peers}
    return tuple(here.get(number) or replace(ABSENT, number=number) for number in numbers)


def _stacked(values: Sequence[Any]) -> Any:
    """One Struct or tuple of arrays out of many of floats; None where there is nothing."""
    import numpy as np

    first = values[0]
    if isinstance(first, Struct):
        return type(first)(*(_stacked(field) for field in zip(*(astuple(v) for v in values), strict=True)))
    if isinstance(first, tuple):
        return tuple(_stacked(part) for part in zip(*values, strict=True))
    return None if first is None else np.array(values, dtype=float)


def _lane(value: Any, i: int) -> Any:
    """One lane of a Struct or tuple of arrays."""
    if isinstance(value, Struct):
        return type(value)(*(_lane(field, i) for field in astuple(value)))
    if isinstance(value, tuple):
        return tuple(_lane(part, i) for part in value)
    return value[i].item() if getattr(value, "ndim", 0) else value
