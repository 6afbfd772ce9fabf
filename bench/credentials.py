"""What credentials cost: a fleet under way, plain, over TLS and over QUIC, through a hub and each boat a router.

    python -m bench.credentials [--boats 5] [--seconds 20]

CPU time and memory of the processes, as ratios to plain TCP in the same run; times to sign and to verify.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any, Literal, NamedTuple

from bench.timing import timed
from fleet.agent.clock import ClockSpec
from fleet.mission.load import encode, load
from fleet.operator import Fleet
from fleet.sim import passes
from fleet.sim.processes import Processes
from fleet.wire.credentials import authority
from fleet.wire.credentials.trust import load as load_trust

FLEET, OPERATOR = "sim", "anna"
WAYS: tuple[tuple[Literal["hub", "routed"], str], ...] = tuple(
    (topology, way) for topology in ("hub", "routed") for way in ("plain", "tls", "quic")
)
TICKS_A_S = 100


class Cost(NamedTuple):
    """Of one fleet."""

    boat_cores: float
    hub_cores: float
    boat_mb: float
    late: int
    refused: int


def _cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_A_S


def _rss_mb(pid: int) -> float:
    for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024
    return 0.0


def under_way(topology: Literal["hub", "routed"], way: str, boats: int, seconds: float) -> Cost:
    """A column that sails, and what its processes take."""
    folder = Path(tempfile.mkdtemp(prefix="fleet-bench-"))
    plan = load("survey-column", ("timeline=[]",), boats)
    names = tuple(boat.name for boat in plan.boats)
    secure: dict[str, Any] = {}
    if way != "plain":
        place = passes.found(folder / "credentials", FLEET, names, OPERATOR)
        secure = {"credentials": place, "transport": way}
    mission = folder / "mission.bin"
    mission.write_bytes(encode(plan))
    spec = ClockSpec()
    processes = Processes(folder, spec, names, fleet=FLEET, topology=topology, seed=0, record=False, **secure)
    try:
        processes.start_hub()
        processes.start_world(mission)
        for name in names:
            processes.start_agent(name)
        mine = secure["credentials"] / OPERATOR if secure else ""
        with Fleet(FLEET, connect=processes.connect, operator=OPERATOR, credentials=mine, timeout_s=10.0) as fleet:
            assert not fleet.wait_for(names, 60.0)
            assert fleet.launch(plan).ok
            _look(fleet, 5.0)
            pids = [processes.pid(name) for name in names]
            hub = processes.pid("hub") if topology == "hub" else 0
            late = _late(fleet)
            before, hub_before, began = sum(map(_cpu_s, pids)), _cpu_s(hub) if hub else 0.0, time.monotonic()
            _look(fleet, seconds)
            took = time.monotonic() - began
            boat = (sum(map(_cpu_s, pids)) - before) / took / boats
            at_hub = (_cpu_s(hub) - hub_before) / took if hub else 0.0
            refused = sum(view.status.requests_refused for view in fleet.boats.values() if view.status is not None)
            return Cost(boat, at_hub, sum(map(_rss_mb, pids)) / boats, _late(fleet) - late, refused)
    finally:
        processes.close()


def _look(fleet: Fleet, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        fleet.look()
        time.sleep(0.2)


def _late(fleet: Fleet) -> int:
    return sum(view.status.ticks_late for view in fleet.look().values() if view.status is not None)


def signatures() -> tuple[float, float, float]:
    """Times to sign a word, to verify it, and to verify a forged one [us]."""
    folder = Path(tempfile.mkdtemp(prefix="fleet-bench-"))
    founded = authority.create(folder, FLEET, time.time())
    for role, name in (("boat", "b1"), ("operator", OPERATOR)):
        founded.issue(role, name, time.time())  # type: ignore[arg-type]
    boat, anna = load_trust(folder / "b1", FLEET, "boat"), load_trust(folder / OPERATOR, FLEET, "operator")
    body = b"x" * 200
    words = anna.sign("command", body)
    forged = anna.sign("command", body + b"y")
    forged = type(forged)(body, forged.signature, forged.signer)

    def refuse() -> None:
        try:
            boat.signer("command", forged)
        except ValueError:
            return
        raise AssertionError("a forged word was believed")

    sign, verify = timed(lambda: anna.sign("command", body)), timed(lambda: boat.signer("command", words))
    return sign.us, verify.us, timed(refuse).us


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--boats", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=20.0)
    given = parser.parse_args()
    sign, verify, refuse = signatures()
    print(f"sign {sign:.0f} us, verify {verify:.0f} us, refuse a forged word {refuse:.0f} us")
    plain: dict[str, Cost] = {}
    print(f"{given.boats} boats under way for {given.seconds:g} s, 10 Hz")
    for topology, way in WAYS:
        cost = under_way(topology, way, given.boats, given.seconds)
        base = plain.setdefault(topology, cost)
        hub = f"  hub {cost.hub_cores:6.1%} x{cost.hub_cores / base.hub_cores:.2f}" if base.hub_cores else ""
        print(
            f"{topology:<7} {way:<6} boat {cost.boat_cores:6.1%} of a core x{cost.boat_cores / base.boat_cores:.2f}  "
            f"{cost.boat_mb:5.1f} MB x{cost.boat_mb / base.boat_mb:.2f}{hub}  late ticks {cost.late}",
            flush=True,
        )


if __name__ == "__main__":
    main()
