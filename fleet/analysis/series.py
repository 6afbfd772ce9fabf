"""A run as arrays over time, read from its recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from fleet.errors import RecordingError
from fleet.recording.disk import parts
from fleet.recording.reader import RecordingFile, read
from fleet.recording.seam import Message
from fleet.recording.topics import COMMAND, EVENT, Command, Event, State, Status, Truth

Floats = NDArray[np.float64]
T = TypeVar("T", bound=Struct)
KEEPS_FORMATION = ("follow", "avoid")


class Track(Struct, frozen=True):
    """Where one hull was: truth of a simulation, or what the boat itself said on the water."""

    t: Floats  # seconds since the beginning of the run, increasing
    x: Floats
    y: Floats  # north, east of the datum [m]
    psi: Floats  # heading [rad]
    speed: Floats  # over ground [m/s]
    length_m: float  # of the hull; NaN: not known


class Said(Struct, frozen=True):
    """What one boat published, one value a message."""

    t: Floats
    speed: Floats  # over ground, as it believes [m/s]
    u_d: Floats  # surge speed asked for [m/s]
    e_s: Floats  # along-path error [m]
    y_e: Floats  # cross-track error [m]
    mode: tuple[str, ...]
    avoiding: NDArray[np.bool_]
    reasons: tuple[tuple[str, ...], ...]

    def within(self, *modes: str) -> NDArray[np.bool_]:
        """Where the mode is one of these."""
        return np.array([mode in modes for mode in self.mode], dtype=bool)


class Series(Struct, frozen=True):
    """A run."""

    folder: Path
    start_ns: int
    header: dict[str, str] = field(default_factory=dict)
    tracks: dict[str, Track] = field(default_factory=dict)
    said: dict[str, Said] = field(default_factory=dict)
    statuses: dict[str, list[Status]] = field(default_factory=dict)
    events: list[Event] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
    unreadable: int = 0  # messages that do not decode
    traffic: dict[str, Track] = field(default_factory=dict)  # vessels that are not of the fleet

    @property
    def boats(self) -> list[str]:
        """Names of the boats of the fleet; of all hulls where none said anything."""
        return sorted(self.said) or sorted(self.tracks)

    @property
    def end_s(self) -> float:
        """When it ended, from its beginning [s]."""
        times = [*(one.t for one in self.tracks.values()), *(one.t for one in self.said.values())]
        return max((float(t[-1]) for t in times if len(t)), default=0.0)

    def seconds(self, stamp_ns: int) -> float:
        """A stamp as seconds from the beginning."""
        return (stamp_ns - self.start_ns) * 1e-9


def load(folder: Path | str, *, empty: bool = False) -> Series:
    """The run in a folder.

    Args:
        folder: a run folder
        empty: a recording without boats is a run of nothing, and no error

    Raises:
        RecordingError: there is no recording, or nothing in it
    """
    path = Path(folder) / "run.mcap"
    found = parts(path)
    if not found:
        raise RecordingError(f"{path}: no such recording; a run folder holds run.mcap")
    with RecordingFile(found[0]) as file:
        header = file.header
    taken = _Taken()
    for message in read(path):
        taken.take(message)
    stamps = [one.stamp_ns for many in taken.truths.values() for one in many]
    stamps += [one.stamp_ns for many in taken.states.values() for one in many]
    if not stamps and not empty:
        raise RecordingError(f"{path}: no boat in it; expected messages on /truth/<boat> or /<boat>/state")
    start_ns = min(stamps, default=0)
    said = {name: _said(many, start_ns) for name, many in taken.states.items()}
    tracks = {name: _true_track(many, start_ns) for name, many in taken.truths.items()}
    for name, many in taken.states.items():
        tracks.setdefault(name, _own_track(many, start_ns))
    return Series(
        folder=Path(folder),
        start_ns=start_ns,
        header=header,
        tracks=tracks,
        said=said,
        statuses=taken.statuses,
        events=taken.events,
        commands=taken.commands,
        unreadable=taken.unreadable,
        traffic={name: _true_track(many, start_ns) for name, many in taken.traffic.items()},
    )


class _Taken:
    """Messages sorted by what they are."""

    def __init__(self) -> None:
        self.truths: dict[str, list[Truth]] = {}
        self.traffic: dict[str, list[Truth]] = {}
        self.states: dict[str, list[State]] = {}
        self.statuses: dict[str, list[Status]] = {}
        self.events: list[Event] = []
        self.commands: list[Command] = []
        self.unreadable = 0
        self._decoders: dict[type[Struct], msgspec.json.Decoder[Any]] = {}

    def take(self, message: Message) -> None:
        """Put a message where it belongs; one that does not decode is counted."""
        first, _, last = message.topic.strip("/").partition("/")
        try:
            if first == "truth":
                self.truths.setdefault(last, []).append(self._decode(message, Truth))
            elif first == "traffic":
                self.traffic.setdefault(last, []).append(self._decode(message, Truth))
            elif last == "state":
                self.states.setdefault(first, []).append(self._decode(message, State))
            elif last == "status":
                self.statuses.setdefault(first, []).append(self._decode(message, Status))
            elif message.topic == EVENT:
                self.events.append(self._decode(message, Event))
            elif message.topic == COMMAND:
                self.commands.append(self._decode(message, Command))
        except msgspec.DecodeError:
            self.unreadable += 1

    def _decode(self, message: Message, layout: type[T]) -> T:
        decoder = self._decoders.setdefault(layout, msgspec.json.Decoder(layout))
        decoded: T = decoder.decode(message.payload)
        return decoded


def _column(many: Iterable[Any], value: Callable[[Any], float | None]) -> Floats:
    """One field of many messages; unknown is NaN."""
    return np.array([np.nan if (one := value(item)) is None else one for item in many], dtype=np.float64)


def _seconds(many: Iterable[Any], start_ns: int) -> Floats:
    return np.array([(one.stamp_ns - start_ns) * 1e-9 for one in many], dtype=np.float64)


def _increasing(many: list[T]) -> list[T]:
    """Messages by stamp, the later of two with the same one."""
    return list({one.stamp_ns: one for one in sorted(many, key=lambda one: int(one.stamp_ns))}.values())  # type: ignore[attr-defined]


def _true_track(many: list[Truth], start_ns: int) -> Track:
    many = [one for one in _increasing(many) if one.x_m is not None and one.y_m is not None]
    return Track(
        t=_seconds(many, start_ns),
        x=_column(many, lambda one: one.x_m),
        y=_column(many, lambda one: one.y_m),
        psi=_column(many, lambda one: one.psi_rad),
        speed=np.hypot(_column(many, lambda one: one.vx_mps), _column(many, lambda one: one.vy_mps)),
        length_m=float("nan") if not many or many[-1].length_m is None else many[-1].length_m,
    )


def _own_track(many: list[State], start_ns: int) -> Track:
    many = [one for one in _increasing(many) if one.x_m is not None and one.y_m is not None]
    return Track(
        t=_seconds(many, start_ns),
        x=_column(many, lambda one: one.x_m),
        y=_column(many, lambda one: one.y_m),
        psi=_column(many, lambda one: one.psi_rad),
        speed=_column(many, lambda one: one.sog_mps),
        length_m=float("nan"),
    )


def _said(many: list[State], start_ns: int) -> Said:
    many = _increasing(many)
    return Said(
        t=_seconds(many, start_ns),
        speed=_column(many, lambda one: one.sog_mps),
        u_d=_column(many, lambda one: one.u_d_mps),
        e_s=_column(many, lambda one: one.e_s_m),
        y_e=_column(many, lambda one: one.y_e_m),
        mode=tuple(one.mode for one in many),
        avoiding=np.array([one.avoiding for one in many], dtype=bool),
        reasons=tuple(tuple(one.reasons) for one in many),
    )
