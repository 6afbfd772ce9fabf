"""Equal bits over whole missions: recorded, alone on floats, and as one lane of a batch of 1,000.

Each mission is sailed by real agents and in lock-step; then every tick of every boat is decided again.

python -m tests.proofs.equal_bits                overtaking, circuit and comes-back: some six minutes
python -m tests.proofs.equal_bits late-joiner    others
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from fleet.analysis.replay import replay
from fleet.mission.load import load
from fleet.sim.lockstep import sail_lockstep
from fleet.sim.sail import Sailing
from fleet.sim.share import Options

MISSIONS = ("overtaking", "circuit", "comes-back")
LANES = 1000
WARP = 6.0


def proof(name: str, way: str, root: Path) -> tuple[str, bool]:
    """One mission sailed one way: a line, and whether all was equal."""
    mission, options = load(name), Options(warp=WARP, root=str(root))
    if way == "lock-step":
        folder = sail_lockstep(mission, name, options).folder
    else:
        folder = Sailing(mission, name, options, lambda progress: None).sail()
    found = replay(folder, LANES)
    ticks = sum(boat.ticks for boat in found.boats)
    lanes = sum(boat.lanes for boat in found.boats)
    differing = sum(boat.differing for boat in found.boats)
    apart = sum(boat.lanes_differing for boat in found.boats)
    line = (
        f"{name:12s} {way:11s} {ticks} ticks: {found.ticks} decided alone, {differing} differ from the recording; "
        f"{lanes} as one of {LANES} lanes, {apart} differ"
    )
    return line, found.same and lanes == found.ticks == ticks


def main(argv: list[str]) -> int:
    """Each mission both ways; 1 if a bit differs."""
    equal = True
    with TemporaryDirectory() as root:
        for name in argv or MISSIONS:
            for way in ("real agents", "lock-step"):
                line, same = proof(name, way, Path(root))
                print(line, flush=True)
                equal = equal and same
    return 0 if equal else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
