"""The overtaking of Bibuli et al. (2014), Fig. 5 and 6, with real agents over real Zenoh, within its bands."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sim.sailed import Sailed, sail

pytestmark = pytest.mark.sails


def formation_error_m(run: Sailed, after_change_s: float) -> float:
    """Largest formation error of a boat from that time after the change on [m]."""
    change = run.t(run.happened("formation")[-1].stamp_ns)
    late = [
        abs(state.e_s_m)
        for states in run.states.values()
        for state in states
        if run.t(state.stamp_ns) >= change + after_change_s and state.e_s_m is not None
    ]
    return max(late)


@pytest.mark.parametrize(
    ("mission", "overrides", "options", "separation_m", "settled_s"),
    [
        ("overtaking", (), {}, 6.0, (80.0, 90.0)),
        ("overtaking-circle", (), {}, 4.8, (75.0, 80.0)),
        ("overtaking", (), {"topology": "routed"}, 6.0, (80.0, 90.0)),
    ],
    ids=["scoring", "circle", "routed"],
)
def test_the_one_behind_overtakes_within_the_bands(
    tmp_path: Path,
    mission: str,
    overrides: tuple[str, ...],
    options: dict[str, object],
    separation_m: float,
    settled_s: tuple[float, float],
) -> None:
    run = sail(mission, tmp_path, *overrides, **options)  # type: ignore[arg-type]
    summary = run.summary
    assert summary.passed, summary.checks
    assert summary.collisions == 0
    assert summary.min_separation_m is not None
    assert summary.min_separation_m >= separation_m
    assert summary.messages_lost == 0
    assert formation_error_m(run, settled_s[0]) < 1.0
    assert formation_error_m(run, settled_s[1]) < 0.1
    skew_s = [run.t(event.stamp_ns) for event in run.happened("formation")]
    assert max(skew_s) - min(skew_s) < 0.3
    for boat in run.truths:
        change = run.t(run.happened("formation")[-1].stamp_ns)
        assert run.speed(boat, change + settled_s[1]) == pytest.approx(1.0, abs=0.02)


def test_with_a_tenth_of_the_messages_lost_and_late_the_formation_is_made_again(tmp_path: Path) -> None:
    run = sail("overtaking", tmp_path, "radio.loss=0.1", "radio.delay_s=0.2")
    assert run.summary.collisions == 0
    assert run.summary.min_separation_m is not None
    assert run.summary.min_separation_m >= 6.0
    assert run.summary.reformed_s is not None
    assert run.summary.messages_lost is not None
    assert run.summary.messages_lost > 100


def test_a_boat_that_joins_late_gets_mission_and_formation_from_its_neighbours(tmp_path: Path) -> None:
    run = sail("late-joiner", tmp_path, warp=12.0)
    assert run.summary.passed, run.summary.checks
    assert {states[-1].mission_id for states in run.states.values()} == {run.states["b1"][-1].mission_id}
