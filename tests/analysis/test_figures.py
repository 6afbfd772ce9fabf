"""What the pictures show: every boat, what was planned, what happened, in colours and places that can be checked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet.analysis.canvas import look, runs_of, svg, thinned, unique_ids
from fleet.analysis.chart import Chart, chart_of
from fleet.analysis.figures import map_figure, picture, time_figure
from fleet.analysis.figures_map import instants
from fleet.analysis.figures_paper import draw_paper
from fleet.analysis.figures_time import happenings, panels
from fleet.analysis.metrics import mission_tree
from fleet.analysis.series import Series, Track, load
from fleet.recording.runs import Run
from fleet.recording.topics import Event

pytest.importorskip("matplotlib")


@pytest.fixture(scope="module")
def series(run: Run) -> Series:
    return load(run.folder)


def labels(axis: object) -> set[str]:
    return {str(line.get_label()) for line in axis.get_lines()}  # type: ignore[attr-defined]


def test_the_map_has_every_boat_and_the_planned_path(series: Series, run: Run) -> None:
    chart = chart_of(mission_tree(run.folder))
    axis = map_figure(series, chart).axes[0]
    assert {"red", "blue", "planned path"} <= labels(axis)
    assert (chart.radius_m, set(chart.paths)) == (6.0, {"line"})
    assert chart.paths["line"][0][-1] == pytest.approx(200.0)


def test_a_boat_has_one_colour_in_every_panel(series: Series) -> None:
    figure = picture(series, Chart(), "m")
    for axis in figure.axes:
        for line in axis.get_lines():
            if line.get_label() in ("red", "blue"):
                assert line.get_color() == look(series, str(line.get_label()))["color"]
    assert look(series, "red") != look(series, "blue")


def test_all_time_series_have_the_same_time(series: Series) -> None:
    axes = time_figure(series, Chart()).axes
    assert len(axes) == len(panels(series)) == 5
    assert len({axis.get_xlim() for axis in axes}) == 1
    assert axes[0].get_xlim() == pytest.approx((0.0, 120.0))


def test_the_boats_are_drawn_at_round_times(series: Series) -> None:
    assert instants(series) == [15.0 * k for k in range(1, 9)]


def test_a_formation_change_on_both_boats_is_one_mark(series: Series) -> None:
    marks = happenings(series)
    assert [(at, words) for at, words, _ in marks] == [(20.0, "spacing 20 -> -20 m")]


def test_of_a_formation_only_what_changed_is_written() -> None:
    words = ["spacing 10 m, cruise 1 m/s, revision 1:a", "spacing 10 m, cruise 2 m/s, revision 2:a"]
    events = [Event(stamp_ns=k, boat="b1", kind="formation", text=text) for k, text in enumerate(words)]
    found = happenings(Series(folder=Path("run"), start_ns=0, events=events))
    assert [text for _, text, _ in found] == ["b1: spacing 10 m, cruise 1 m/s", "b1: cruise 2 m/s"]


def test_the_nearest_pair_is_marked_where_it_was(series: Series) -> None:
    words = {text.get_text() for text in map_figure(series, Chart()).axes[0].texts}
    assert any(one.startswith("5.95 m at ") for one in words)


def test_a_fence_is_drawn_where_it_is_near_the_boats_only(series: Series) -> None:
    near = Chart(fence=((-50.0, -15.0), (300.0, -15.0), (300.0, 15.0), (-50.0, 15.0)))
    far = Chart(fence=((-9e3, -9e3), (9e3, -9e3), (9e3, 9e3), (-9e3, 9e3)))
    found = [labels(map_figure(series, chart).axes[0]) for chart in (near, far)]
    assert ["fence" in one for one in found] == [True, False]


def test_two_pictures_in_a_page_share_no_name(series: Series) -> None:
    drawn = unique_ids(svg(time_figure(series, Chart()), 'a "said" one'), "t")
    assert 'aria-label="a &quot;said&quot; one"' in drawn
    assert 'id="t-figure_1"' in drawn
    assert 'id="figure_1"' not in drawn


def test_the_papers_figures_are_drawn_into_one_file(run: Run, tmp_path: Path) -> None:
    drawn = draw_paper(run.folder, tmp_path / "paper.png")
    assert drawn.read_bytes().startswith(b"\x89PNG")
    assert drawn.stat().st_size < 150_000


@pytest.mark.parametrize("count", [0, 1])
def test_a_run_of_one_boat_or_of_none_is_drawn(count: int) -> None:
    t = np.arange(0.0, 10.0)
    one = Track(t=t, x=t, y=t, psi=np.full_like(t, np.nan), speed=t, length_m=np.nan)
    tracks = {"b1": one, "lost": Track(*[np.array([])] * 5, np.nan)} if count else {}
    found = Series(folder=Path("run"), start_ns=0, tracks=tracks)
    figure = picture(found, Chart(), "m")
    words = {text.get_text() for text in figure.axes[0].texts}
    assert ("no position is known" in words) == (count == 0)


@given(st.lists(st.floats(-1e3, 1e3) | st.just(float("nan")), min_size=1, max_size=300), st.integers(4, 60))
def test_a_thinned_line_keeps_its_ends_and_peaks(values: list[float], most: int) -> None:
    t, y = np.arange(float(len(values))), np.array(values)
    few_t, few = thinned(t, y, most)
    assert len(few) <= most + 2
    assert (few_t[0], few_t[-1]) == (t[0], t[-1])
    assert (np.diff(few_t) > 0.0).all()
    if not np.isnan(y).all():
        assert (np.nanmin(few), np.nanmax(few)) == (np.nanmin(y), np.nanmax(y))


def test_stretches_that_are_true_are_found() -> None:
    assert runs_of([True, True, False, True]) == [(0, 2), (3, 4)]
    assert runs_of([]) == []
