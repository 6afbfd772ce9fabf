"""A live fleet sails while a station of its own attacks it: what was sent, what was refused, and what it did.

python -m tests.attack.run --count 100000     the whole of it, 100 s; the test sends 10,000
"""

from __future__ import annotations

import argparse
import math
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from fleet.mission.load import encode as encode_mission
from fleet.mission.load import load
from fleet.mission.model import Boat, Formation, Mission, Start, Through
from fleet.recording import topics
from fleet.recording.reader import read
from fleet.sim.sail import FLEET, OPERATOR, Progress, Sailing
from fleet.wire import keys
from fleet.wire.messages import BoatStatus
from fleet.wire.zenoh_shore import OperatorBus
from tests.attack.attacker import Plan, Result
from tests.sim.sailed import Sailed, sail

COLUMN = str(Path(__file__).parents[1] / "sim" / "column.toml")
BOATS = ("b1", "b2", "b3")
VICTIM = "b2"
QUIET_S, ATTACK_S = 12.0, 22.0  # undisturbed from the first to the second; then the attacker begins
LISTENS_S = 3.5  # the attacker, before its first message


class Probe(Struct):
    """What the boats said at one moment."""

    t_s: float
    statuses: dict[str, BoatStatus]
    rss_kb: dict[str, int]


class Attack(Struct):
    """A run under attack, and what is known of it."""

    run: Any  # Sailed
    result: Result
    probes: list[Probe]

    def grew(self, boat: str, what: str, first: int = 1, last: int = -1) -> int:
        """How much a counter of a boat's status grew between two probes."""
        one, two = self.probes[first].statuses[boat], self.probes[last].statuses[boat]
        return int(getattr(two, what)) - int(getattr(one, what))

    def rss_grew_mb(self, boat: str) -> float:
        """Memory of the boat's agent that was not there before the attack."""
        return (self.probes[-1].rss_kb[boat] - self.probes[1].rss_kb[boat]) / 1024.0


def unsailable() -> list[bytes]:
    """Missions in the place of a good one: dear to check, or dear to refuse."""
    plain = load(COLUMN)
    good = msgspec.to_builtins(plain)
    pack = msgspec.msgpack.encode
    curve = Through(points=tuple((200.0 * i, 100.0 * math.sin(0.3 * i)) for i in range(226)))  # 45 km
    others = tuple(Boat(name=f"z{i}", path="line", slot=-float(i), start=Start(s_m=200.0 - 20.0 * i)) for i in range(5))
    long: Mission = msgspec.structs.replace(
        plain,
        paths={"line": curve},
        boats=others,
        fence=None,
        timeline=(),
        formation=Formation(spacing_m=20.0, cruise_mps=1.0),
    )
    return [
        b"",
        b"\x91" * 100_000,
        encode_mission(long),  # can be sailed, but not by this boat
        encode_mission(
            msgspec.structs.replace(long, boats=plain.boats, checks={"unheard-of": 1.0})
        ),  # built to know it
        pack({**good, "boats": [None] * 50_000}),
        pack({**good, "boats": [good["boats"][0]] * 500}),
        pack(
            {
                **good,
                "paths": {
                    "line": {
                        "kind": "sine",
                        "start": [0, 0],
                        "end": [900, 0],
                        "amplitude_m": 1e-9,
                        "wavelength_m": 1e-3,
                    }
                },
            }
        ),
        encode_mission(plain)[:-7],
    ]


def attack(folder: Path, count: int, rate_hz: float = 1000.0) -> Attack:
    """Sail, quietly at first, then under attack by so many messages."""
    recorded: list[bytes] = []
    probes: list[Probe] = []
    children: list[subprocess.Popen[bytes]] = []
    plan_file, out = folder / "plan.bin", folder / "result.json"
    real = OperatorBus.ask_all

    def overhear(self: OperatorBus, what: str, payload: bytes, timeout_s: float, boat: str = "*") -> dict[str, bytes]:
        if what == keys.COMMAND:
            recorded.append(payload)
        return real(self, what, payload, timeout_s, boat)

    def probe(sailing: Sailing, progress: Progress) -> None:
        views = progress.fleet.boats
        statuses = {boat: views[boat].status for boat in BOATS}
        rss = {boat: _rss_kb(sailing.processes.pid(boat)) for boat in BOATS}
        probes.append(Probe(progress.t_s, {b: s for b, s in statuses.items() if s is not None}, rss))

    def begin(sailing: Sailing, progress: Progress) -> None:
        probe(sailing, progress)
        plan = Plan(
            connect=sailing.processes.connect,
            fleet=FLEET,
            boats=BOATS,
            victim=VICTIM,
            count=count,
            rate_hz=rate_hz,
            commands=sorted(set(recorded)),
            missions=unsailable(),
            operator=OPERATOR,
        )
        plan_file.write_bytes(msgspec.msgpack.encode(plan))
        with out.open("wb") as stdout:
            argv = [sys.executable, "-m", "tests.attack.attacker", str(plan_file)]
            children.append(subprocess.Popen(argv, stdout=stdout, cwd=Path(__file__).parents[2]))

    under_attack_s = ATTACK_S + LISTENS_S + count / rate_hz
    OperatorBus.ask_all = overhear  # type: ignore[method-assign]
    try:
        run = sail(
            COLUMN,
            folder,
            f"duration_s={under_attack_s + 10.0}",
            at={
                2.0: lambda sailing, progress: progress.fleet.hold() and None,
                3.0: lambda sailing, progress: progress.fleet.resume() and None,
                QUIET_S: probe,
                ATTACK_S: begin,
                under_attack_s + 4.0: probe,
            },
            warp=1.0,
        )
    finally:
        OperatorBus.ask_all = real  # type: ignore[method-assign]
        for child in children:
            if child.poll() is None:
                child.terminate()
            child.wait()
    return Attack(run, msgspec.json.decode(out.read_bytes(), type=Result), probes)


def _rss_kb(pid: int) -> int:
    for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    return 0


def reasons(run: Sailed, boat: str, since_s: float, until_s: float) -> set[str]:
    """Reasons that a boat wrote down itself."""
    found = (s.reasons for s in run.own_states[boat] if since_s <= run.t(s.stamp_ns) <= until_s)
    return {reason for reasons in found for reason in reasons}


def gaps_m(run: Sailed, since_s: float, until_s: float) -> tuple[float, float]:
    """Least and largest true distance between neighbours of the column."""
    tracks = {
        boat: {round(run.t(t.stamp_ns), 1): (t.x_m, t.y_m) for t in truths if since_s <= run.t(t.stamp_ns) <= until_s}
        for boat, truths in run.truths.items()
    }
    gaps = [
        math.dist(tracks[a][t], tracks[b][t])
        for a, b in (("b1", "b2"), ("b2", "b3"))
        for t in tracks[a]
        if t in tracks[b]
    ]
    return min(gaps), max(gaps)


def aside_m(run: Sailed, since_s: float, until_s: float) -> float:
    """Farthest that any boat was from the line."""
    return max(
        abs(t.y_m or 0.0) for truths in run.truths.values() for t in truths if since_s <= run.t(t.stamp_ns) <= until_s
    )


def speeds(run: Sailed, since_s: float, until_s: float) -> tuple[float, float]:
    """Slowest and fastest that any boat was."""
    found = [
        math.hypot(t.vx_mps or 0.0, t.vy_mps or 0.0)
        for truths in run.truths.values()
        for t in truths
        if since_s <= run.t(t.stamp_ns) <= until_s
    ]
    return min(found), max(found)


def late_ticks(run: Sailed, boat: str, since_s: float, until_s: float) -> int:
    """Ticks skipped, as the boat wrote down."""
    topic = topics.status_topic(boat)
    late = [
        status.ticks_late
        for message in read(run.folder / "boats" / f"{boat}.mcap")
        if message.topic == topic
        for status in [msgspec.json.decode(message.payload, type=topics.Status)]
        if since_s <= run.t(status.stamp_ns) <= until_s
    ]
    return late[-1] - late[0]


def main() -> None:
    """Attack, and print what came of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--rate", type=float, default=1000.0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        done = attack(Path(folder), options.count, options.rate)
        result, run = done.result, done.run
        end_s = ATTACK_S + LISTENS_S + options.count / options.rate
        print(f"{sum(result.sent.values())} messages in {result.took_s:.1f} s")
        for name, count in sorted(result.sent.items()):
            asked = name in result.answered or name.startswith(("commands", "ask"))
            more = (
                f"  answered {result.answered.get(name, 0)}, acknowledged {result.obeyed.get(name, 0)}" if asked else ""
            )
            print(f"  {name:40s} {count:7d}{more}")
        on = sum(count for key, count in result.on.items() if key in BOATS)
        print(f"states on the boats' keys {on}, on all keys {result.on.get('*', 0)}")
        for boat in BOATS:
            before, late = late_ticks(run, boat, QUIET_S, ATTACK_S), late_ticks(run, boat, ATTACK_S, end_s)
            print(
                f"{boat}: refused {done.grew(boat, 'messages_refused')} states, "
                f"{done.grew(boat, 'requests_refused')} requests; memory {done.rss_grew_mb(boat):+.1f} MB; "
                f"ticks late {before} in {ATTACK_S - QUIET_S:g} s before, {late} in {end_s - ATTACK_S:g} s under attack"
            )
            print("   ", "; ".join(done.probes[-1].statuses[boat].refusals))
            print("   ", reasons(run, boat, ATTACK_S, end_s), run.own_modes(boat, ATTACK_S, end_s))
            for event in run.own[boat]:
                if ATTACK_S < run.t(event.stamp_ns) < end_s and event.kind != "refused":
                    print(f"    {run.t(event.stamp_ns):7.1f} {event.kind}: {event.text[:100]}")
        for name, since, until in (("before", QUIET_S, ATTACK_S), ("under attack", ATTACK_S, end_s)):
            low, high = gaps_m(run, since, until)
            slow, fast = speeds(run, since, until)
            print(
                f"{name}: gaps {low:.2f} to {high:.2f} m, aside {aside_m(run, since, until):.2f} m, "
                f"speed {slow:.3f} to {fast:.3f} m/s"
            )
        print("messages lost:", [done.grew(boat, "messages_lost") for boat in BOATS])


if __name__ == "__main__":
    main()
