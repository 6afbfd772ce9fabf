"""A boat that cannot go on says why, stays safe, and recovers by itself (the last row of the trouble table)."""

from __future__ import annotations

import math
from pathlib import Path

from fleet.agent.modes import Mode, Reason
from tests.agent.harness import Sea, forged, mission, sailing

RING_M = 8.0
WRECKS = [f"wreck-{k}" for k in range(9)]


def wrecks_speak(sea: Sea, centre: tuple[float, float], seq: int) -> None:
    """Nine boats without thrust in a ring, saying where they lie."""
    agent = sea.agent("b1")
    assert agent.plane is not None
    for k, name in enumerate(WRECKS):
        bearing = 2.0 * math.pi * k / len(WRECKS)
        x, y = centre[0] + RING_M * math.cos(bearing), centre[1] + RING_M * math.sin(bearing)
        lat_deg, lon_deg = agent.plane.to_geographic(x, y)
        agent.bus.watch(name)
        state = forged(
            sea.state("b1"),
            boat=name,
            epoch=7,
            seq=seq,
            stamp_ns=sea.now_ns,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            sog_mps=0.0,
            mode=int(Mode.NEUTRAL),
            mission_id="",
        )
        sea.say_as(name, state, to=("b1",))


def test_a_boat_that_is_boxed_in_says_so_touches_nobody_and_goes_on_when_the_way_is_free(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(1, method="scoring"), 5.0)
    centre = sea.where("b1")
    centre = (centre[0] + 2.0, centre[1])
    nearest = math.inf
    for seq in range(400):
        wrecks_speak(sea, centre, seq)
        sea.tick()
        x, y = sea.where("b1")
        for k in range(len(WRECKS)):
            bearing = 2.0 * math.pi * k / len(WRECKS)
            wreck = (centre[0] + RING_M * math.cos(bearing), centre[1] + RING_M * math.sin(bearing))
            nearest = min(nearest, math.dist((x, y), wreck))
    assert Reason.BOXED_IN in sea.reasons("b1")
    assert nearest > 2.4, "no hull was touched"
    assert math.dist(sea.where("b1"), centre) < RING_M
    sea.agent("b1").picture.forget(WRECKS)
    sea.run(20.0)
    assert sea.mode("b1") == Mode.FOLLOW
    assert Reason.BOXED_IN not in sea.reasons("b1")
    assert sea.speed("b1") > 0.9
