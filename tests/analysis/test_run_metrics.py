"""Every figure of a run, by cases that can be worked out by hand."""

from __future__ import annotations

import json
import math
import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.analysis.metrics import (
    FIGURES,
    Summary,
    counted,
    cross_track_rms_m,
    finished,
    formation_error_m,
    launch_s,
    reformed_s,
    run_up_end_s,
    speed_range,
    summarise,
    summary_of,
    write_summary,
)
from fleet.analysis.separation import approaches, distance, touches
from fleet.analysis.series import Said, Track, load
from fleet.errors import RecordingError
from fleet.recording.runs import Run
from fleet.recording.topics import Status


def track(points: list[tuple[float, float, float]], length_m: float = 2.0, speed: float = 1.0) -> Track:
    """A track through (t, x, y)."""
    t, x, y = np.array(points, dtype=float).reshape(-1, 3).T
    return Track(t=t, x=x, y=y, psi=0.0 * t, speed=0.0 * t + speed, length_m=length_m)


def said(
    e_s: list[float], mode: str | list[str] = "follow", y_e: float = 0.0, avoiding: bool = False, u_d: float = 1.0
) -> Said:
    """What a boat said, once a second."""
    n = len(e_s)
    return Said(
        t=np.arange(n, dtype=float),
        speed=np.ones(n),
        u_d=np.full(n, u_d),
        e_s=np.array(e_s, dtype=float),
        y_e=np.full(n, y_e),
        mode=(mode,) * n if isinstance(mode, str) else tuple(mode),
        avoiding=np.full(n, avoiding),
        reasons=((),) * n,
    )


def test_boats_that_pass_between_two_samples_are_measured_where_they_pass() -> None:
    east = track([(0, 0, -10), (10, 0, 10)])
    west = track([(0, 3, 10), (10, 3, -10)])
    (nearest,) = approaches({"a": east, "b": west})
    assert (nearest.distance_m, nearest.at_s, nearest.touches) == (pytest.approx(3.0), pytest.approx(5.0), 0)


def test_samples_at_different_times_are_brought_together_exactly() -> None:
    a = track([(0, 0, 0), (10, 10, 0)])
    b = track([(-3, 5, -8), (0, 5, -5), (5, 5, 0), (7, 5, 9)])
    (nearest,) = approaches({"a": a, "b": b})
    assert (nearest.distance_m, nearest.at_s) == (pytest.approx(0.0, abs=1e-12), pytest.approx(5.0))


def test_hulls_touch_below_the_sum_of_half_lengths_and_each_entering_counts() -> None:
    still = track([(0, 0, 0), (100, 0, 0)], length_m=2.0)
    comes_twice = track([(0, 10, 0), (10, 2.9, 0), (20, 10, 0), (30, -10, 0), (40, -3, 0)], length_m=4.0)
    apart = distance(still, comes_twice)
    assert apart is not None
    assert touches(apart, 3.0) == 2  # at 10 s and while crossing over between 20 s and 30 s
    assert touches(apart, 2.9) == 1
    assert touches(apart, math.nan) == 0


def test_hulls_that_overlap_from_the_beginning_count_once() -> None:
    (pair,) = approaches({"a": track([(0, 0, 0), (9, 0, 0)]), "b": track([(0, 1, 0), (9, 1, 0)])})
    assert pair.touches == 1


def test_boats_that_were_never_there_together_have_no_separation() -> None:
    assert approaches({"a": track([(0, 0, 0), (1, 0, 0)]), "b": track([(2, 0, 0), (3, 0, 0)])}) == []
    assert approaches({"a": track([]), "b": track([(2, 0, 0), (3, 0, 0)])}) == []


places = st.lists(st.tuples(st.floats(-50, 50), st.floats(-50, 50)), min_size=2, max_size=6)


@given(places, places)
def test_no_moment_between_samples_is_nearer_than_the_closest_approach(
    first: list[tuple[float, float]], second: list[tuple[float, float]]
) -> None:
    a = track([(float(i), *one) for i, one in enumerate(first)])
    b = track([(0.7 * i, *one) for i, one in enumerate(second)])
    (nearest,) = approaches({"a": a, "b": b})
    t = np.linspace(0.0, min(a.t[-1], b.t[-1]), 400)
    dx = np.interp(t, a.t, a.x) - np.interp(t, b.t, b.x)
    dy = np.interp(t, a.t, a.y) - np.interp(t, b.t, b.y)
    assert nearest.distance_m <= np.hypot(dx, dy).min() + 1e-9
    assert approaches({"b": a, "a": b})[0].distance_m == pytest.approx(nearest.distance_m, abs=1e-9)


def test_reformed_is_when_the_last_boat_comes_within_a_metre_for_good() -> None:
    a = said([0, 0, 9, 5, 0.5, 2, 0.9, 0.1, 0])
    b = said([0, 0, -9, -0.5, -0.5, -0.5, -0.5, -1.5, 0])
    assert reformed_s({"a": a}, 2.0) == 4.0
    assert reformed_s({"a": a, "b": b}, 2.0) == 6.0
    assert reformed_s({"a": a}, 6.0) == 0.0


def test_a_formation_that_is_off_at_the_end_never_reformed() -> None:
    assert reformed_s({"a": said([0, 5, 0.5, 1.0]), "b": said([0, 0, 0, 0])}, 0.0) is None
    assert reformed_s({}, 0.0) is None
    assert reformed_s({"a": said([0.0] * 3, "hold")}, 0.0) is None


def test_a_boat_that_left_while_off_does_not_keep_the_others_from_having_reformed() -> None:
    gone = said([0, 5, 5, 5, 5, 5, 5, 5, 5], ["follow"] * 4 + ["neutral"] * 5)
    assert reformed_s({"a": said([0, 5, 0, 0, 0, 0, 0, 0, 0]), "gone": gone}, 0.0) == 3.0


def test_the_run_up_ends_when_all_are_in_formation_and_under_way() -> None:
    boats = {"a": said([3, 2, 0.5, 0, 0, 0]), "b": said([0, 0, 0, 0, 0, 0])}
    assert run_up_end_s(boats, {}, 0.0) == 2.0
    slow = Track(t=np.array([0.0, 5.0]), x=np.zeros(2), y=np.zeros(2), psi=np.zeros(2),
                 speed=np.array([0.0, 1.0]), length_m=2.0)  # fmt: skip
    assert run_up_end_s(boats, {"b": slow}, 0.0) == 5.0
    assert run_up_end_s({"a": said([9.0] * 40)}, {}, 0.0) == 20.0
    assert run_up_end_s({}, {}, 0.0) == 20.0


def test_speeds_and_cross_track_errors_are_those_of_boats_that_sail_after_the_run_up() -> None:
    boats = {
        "a": said([0.0] * 10, "follow", y_e=0.3),
        "b": said([0.0] * 10, "avoid", y_e=4.0, avoiding=True),
        "c": said([0.0] * 10, "hold", y_e=9.0),
    }
    ramp = Track(t=np.array([0.0, 10.0]), x=np.zeros(2), y=np.zeros(2), psi=np.zeros(2),
                 speed=np.array([0.0, 1.0]), length_m=2.0)  # fmt: skip
    assert speed_range(boats, {"a": ramp, "c": track([(0, 0, 0)], speed=5.0)}, 5.0) == pytest.approx((0.5, 1.0))
    assert cross_track_rms_m(boats, 5.0) == pytest.approx(0.3)
    assert speed_range(boats, {}, 99.0) is None
    assert cross_track_rms_m(boats, 99.0) is None


def test_the_formation_error_at_the_end_is_of_the_boats_that_are_there() -> None:
    boats = {"a": said([0, 0.2]), "b": said([0, -0.7], "hold"), "c": said([9, 9], "fault"), "d": said([0, math.nan])}
    assert formation_error_m(boats, 1.0) == pytest.approx(0.7)
    assert formation_error_m(boats, 60.0) is None
    assert not finished(boats, 1.0)
    assert finished({"a": boats["a"], "b": boats["b"]}, 1.0)
    assert launch_s({"a": said([0, 0, 0], ["standby", "standby", "follow"])}) == 2.0


def test_counters_of_a_restarted_agent_add_up() -> None:
    statuses = {
        "a": [Status(stamp_ns=i, ticks=n) for i, n in enumerate([10, 20, 3, 8])],
        "b": [],
        "c": [Status(stamp_ns=0)],
    }
    assert counted(statuses, "ticks") == 28
    assert counted({}, "ticks") is None


def test_what_nobody_measured_is_unknown_and_not_zero(run: Run) -> None:
    series = load(run.folder)
    without = {name: msgspec.structs.replace(one, length_m=math.nan) for name, one in series.tracks.items()}
    field_run = msgspec.structs.replace(series, tracks=without, statuses={})
    summary = summary_of(field_run, "field", {"collisions": 0, "messages_lost": 0, "ticks_late_share": 0.1})
    assert (summary.collisions, summary.messages_lost, summary.ticks) == (None, None, None)
    assert [one.ok for one in summary.checks] == [False, False, False]


def test_the_summary_of_a_recorded_run(run: Run) -> None:
    summary = summarise(run.folder, wall_s=12.0)
    assert summary.passed
    assert [one.name for one in summary.checks] == ["min_separation_m", "collisions"]
    assert summary.boats == ["blue", "red"]
    assert summary.min_separation_m == pytest.approx(5.95, abs=0.01)
    assert (summary.collisions, summary.messages_lost, summary.ticks) == (0, 2, 2400)
    assert summary.reformed_s == pytest.approx(69.4, abs=0.2)
    assert summary.speed_min_mps == pytest.approx(0.7, abs=1e-3)
    assert summary.speed_max_mps == pytest.approx(1.3, abs=1e-3)
    assert summary.simulated_s == pytest.approx(120.0)
    write_summary(summary, run.summary_file)
    written = json.loads(run.summary_file.read_text())
    assert list(written) == list(Summary.__struct_fields__)
    assert written["checks"][0]["name"] == "min_separation_m"
    assert summarise(run.folder).wall_s == 12.0
    assert set(FIGURES) < set(Summary.__struct_fields__)


def test_where_an_autopilot_stands_between_limits_of_speed_are_judged_by_what_is_asked_of_it(run: Run) -> None:
    series = load(run.folder)
    swings = {
        name: msgspec.structs.replace(one, speed=one.speed - 0.1 * (one.t > 30.0))
        for name, one in series.tracks.items()
    }
    limits = {"speed_min_mps": 0.69, "speed_max_mps": 1.31}

    def judged(driver: str) -> list[tuple[str, bool]]:
        told = msgspec.structs.replace(series, tracks=swings, header={**series.header, "driver": driver})
        return [(one.by, one.ok) for one in summary_of(told, "run", limits).checks]

    assert judged("simulated") == [("", False), ("", True)]
    assert judged("mavlink") == [("setpoint_min_mps", True), ("setpoint_max_mps", True)]
    summary = summary_of(msgspec.structs.replace(series, tracks=swings), "run", limits)
    assert summary.setpoint_min_mps == pytest.approx(0.7)
    assert summary.speed_min_mps is not None
    assert summary.speed_min_mps < 0.62, "and the hull's own is told beside it"


def test_a_figure_that_does_not_exist_fails_its_check(run: Run) -> None:
    summary = summarise(run.folder, checks={"reformed_s": 10.0, "no-such-figure": 1.0, "finished": 1})
    assert [one.ok for one in summary.checks] == [False, False, True]
    assert not summary.passed


def test_a_recording_cut_by_a_crash_still_has_its_figures(run: Run, tmp_path: Path) -> None:
    shutil.copytree(run.folder, tmp_path / "cut")
    whole = run.recording.read_bytes()
    (tmp_path / "cut" / "run.mcap").write_bytes(whole[: len(whole) * 2 // 3])
    series = load(tmp_path / "cut")
    assert series.boats == ["blue", "red"]
    assert 60.0 < series.end_s < 110.0


def test_a_folder_without_a_recording_is_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no such recording; a run folder holds"):
        load(tmp_path)
