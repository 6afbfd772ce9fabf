"""Reference runs: what the boats decided when their laws were last accepted; a changed law shows as a difference.

python -m fleet.sim.lockstep_reference            show where the laws of today decide otherwise; 1 if anywhere
python -m fleet.sim.lockstep_reference --accept   show it, sail the reference runs again, and keep those
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
from msgspec.structs import replace

from fleet import __version__
from fleet.analysis.replay import replay
from fleet.analysis.replayed import Replay, summary_of
from fleet.errors import FleetError, RecordingError
from fleet.mission.load import load
from fleet.mission.model import Event, Mission
from fleet.mission.plan import build
from fleet.recording.seam import Recording
from fleet.sim.lockstep import CLOSED_S, NEVER_S, Lockstep, operator
from fleet.sim.lockstep_numbers import numbers
from fleet.sim.share import say

FOLDER = Path("tests/replay/reference")
NUMBERS = "numbers.json"
SWAP = Event(at_s=2.0, do="set spacing", value=-20.0)
CURRENT = ("environment.current_mps=0.2", "environment.current_toward_deg=60")
ROUGH = ("environment.gnss_sigma_m=0.5", "environment.gnss_white_m=0.1", "radio.loss=0.3", "radio.delay_s=0.4")
CASES: dict[str, tuple[str, tuple[str, ...], float, tuple[Event, ...]]] = {
    "overtaking-scoring": ("overtaking", (), 40.0, (SWAP,)),
    "overtaking-circle": ("overtaking-circle", (), 40.0, (SWAP,)),
    "circuit": ("circuit", (), 25.0, ()),
    "rough": ("circuit", ROUGH, 15.0, ()),
    "comes-back": (
        "comes-back",
        CURRENT,
        34.0,
        (
            Event(at_s=3.0, do="kill", boats=("b2",)),
            Event(at_s=18.0, do="start", boats=("b2",)),
            Event(at_s=26.0, do="hold", boats=("b1",)),
            Event(at_s=29.0, do="gnss-down", boats=("b3",)),
        ),
    ),
}
"""Name of the reference run: ready mission, overrides, duration, timeline. Short: every kind of decision, no more."""


class _Decisions:
    """One recording for all boats of a run, with what replay needs and nothing else."""

    trouble = ""
    dropped = 0

    def __init__(self, recorder: Recording) -> None:
        self._recorder = recorder

    def channel(self, topic: str, schema_name: str, encoding: str, schema: bytes = b"") -> None:
        """Declare a topic, if replay needs it."""
        if encoding == "msgpack":
            self._recorder.channel(topic, schema_name, encoding, schema)

    def put(self, topic: str, stamp_ns: int, payload: bytes) -> None:
        """Keep a message, if replay needs it."""
        if topic.endswith(("/inputs", "/decision", "/laid")):
            self._recorder.put(topic, stamp_ns, payload)

    def close(self, timeout_s: float = 5.0) -> None:
        """The run goes on without this boat."""


def mission_of(case: str) -> Mission:
    """The mission of a reference run."""
    where, overrides, duration_s, timeline = CASES[case]
    return replace(load(where, overrides), duration_s=duration_s, timeline=timeline)


def sail(case: str, file: Path) -> None:
    """Sail a reference run into a file: equal laws give equal bytes."""
    from fleet.recording.writer import Recorder

    mission = mission_of(case)
    recorder = Recorder(file, {"case": case, "version": __version__}, wait=True, flush_s=NEVER_S, fsync_s=NEVER_S)
    boats = _Decisions(recorder)
    sim = Lockstep(build(mission), recorder_of=lambda boat: boats)
    with operator(sim) as fleet:
        fleet.wait_for([boat.name for boat in mission.boats])
        fleet.launch(mission)
        begin_s = sim.monotonic() + sim.nature.lead_s
        for event in mission.timeline:
            sim.sleep(max(0.0, begin_s + event.at_s - sim.monotonic()))
            if event.do in ("hold", "set spacing"):
                say(event, fleet, sim.nature.apply_in_s)
            else:
                for boat in event.boats:
                    sim.do(event.do, boat, event.number)
        sim.sleep(max(0.0, begin_s + mission.duration_s - sim.monotonic()))
    sim.close()
    recorder.close(CLOSED_S)


def compare(folder: Path = FOLDER) -> dict[str, Replay]:
    """Every reference run replayed by the laws of today; RecordingError when one is missing."""
    missing = [case for case in CASES if not (folder / f"{case}.mcap").exists()]
    if missing:
        raise RecordingError(f"{folder}: no reference run of {', '.join(missing)}; sail them with --accept")
    return {case: replay(folder / f"{case}.mcap") for case in CASES}


def unlike_numbers(folder: Path = FOLDER) -> list[str]:
    """Functions of the laws that return other numbers over the reference runs than those accepted, if only one bit."""
    try:
        accepted = msgspec.json.decode((folder / NUMBERS).read_bytes(), type=dict[str, str])
    except (OSError, msgspec.DecodeError) as error:
        raise RecordingError(f"{folder / NUMBERS}: cannot be read: {error}; make it with --accept") from error
    found = numbers(folder / f"{case}.mcap" for case in CASES)
    return sorted(name for name in found.keys() | accepted.keys() if found.get(name) != accepted.get(name))


def accept(folder: Path = FOLDER) -> dict[str, Replay]:
    """Sail the reference runs again and keep them, and the numbers; what the old runs gave when replayed."""
    folder.mkdir(parents=True, exist_ok=True)
    before = {case: replay(folder / f"{case}.mcap") for case in CASES if (folder / f"{case}.mcap").exists()}
    with TemporaryDirectory(dir=folder) as drafts:  # all of them, or none
        for case in CASES:
            sail(case, Path(drafts) / f"{case}.mcap")
        for case in CASES:
            (Path(drafts) / f"{case}.mcap").replace(folder / f"{case}.mcap")
    found = numbers(folder / f"{case}.mcap" for case in CASES)
    (folder / NUMBERS).write_bytes(msgspec.json.format(msgspec.json.encode(found), indent=1) + b"\n")
    return before


def lines(replays: dict[str, Replay]) -> list[str]:
    """For a person: each run, and every field that differs with its first tick and size."""
    found = []
    for case, one in replays.items():
        differing = sum(boat.differing for boat in one.boats)
        verdict = f"{differing} of {one.ticks} ticks differ" if differing else f"{one.ticks} ticks, all alike"
        found.append(f"{case}: {verdict}")
        found += [f"  {note}" for note in one.notes]
        found += [f"  {boat.boat}: {note}" for boat in one.boats for note in boat.notes]
        found += [f"  {boat.boat}: not replayed: {why}" for boat in one.boats for why in boat.skipped]
        found += [f"  {line}" for line in summary_of(one.differences)]
    return found


def main(argv: list[str]) -> int:
    """Compare, or accept; the exit code."""
    accepting = "--accept" in argv
    folder = Path(next((word for word in argv if not word.startswith("-")), str(FOLDER)))
    try:
        whole = all((folder / name).exists() for name in (NUMBERS, *(f"{case}.mcap" for case in CASES)))
        replays = compare(folder) if not accepting else {}
        otherwise = unlike_numbers(folder) if whole or not accepting else []
        replays = accept(folder) if accepting else replays
    except FleetError as error:
        print(error, file=sys.stderr)
        return 1
    print("\n".join(lines(replays)) or "no reference runs before")
    if whole:
        words = "\n".join(f"{name}: returns other numbers" for name in otherwise)
        print(words or "numbers inside of the laws: all alike")
    if accepting:
        print(f"accepted: {len(CASES)} runs in {folder}")
    return 0 if accepting or (not otherwise and all(one.same for one in replays.values())) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
