"""Whatever dies, the boat does not go on by an old command for longer than the layer that acts says, and a second."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.drivers.mavlink.dead_man import CASES, measure

STAYS = {"autopilot restarted": "MANUAL", "mode taken by the pilot": "MANUAL"}
STAYS |= dict.fromkeys(("GNSS lost", "GNSS lost and agent killed"), "HOLD")
SAYS = {
    "link cut between agent and autopilot": "own navigation is stale or not finite",
    "autopilot restarted": "own navigation is stale or not finite",
    "mode taken by the pilot": "pilot or ground station: MANUAL",
    "GNSS lost": "own navigation is stale or not finite",
    "operator says stop-now": "stopped by an operator, not released",
}


@pytest.mark.parametrize("what", CASES)
def test_the_boat_stops_in_time_and_says_why(what: str, tmp_path: Path) -> None:
    row = measure(what, tmp_path)
    assert row.drove_s <= CASES[what][1] + 1.0
    assert 0.0 < row.stopped_s <= row.drove_s + 6.0
    assert row.mode == STAYS.get(what, "LOITER")
    assert row.armed == (what != "autopilot restarted")
    assert row.says == SAYS.get(what, "")
    assert row.said_s <= 1.2
