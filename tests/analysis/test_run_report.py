"""The page and the picture of a run stand alone."""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from sailed import T0

from fleet.analysis.figures import draw
from fleet.analysis.html import shown
from fleet.analysis.metrics import summarise, summary_of
from fleet.analysis.report import page, pictures, write_report
from fleet.analysis.separation import approaches
from fleet.analysis.series import Series, Track, load
from fleet.errors import RecordingError, UsageError
from fleet.recording.runs import Run
from fleet.recording.topics import State, declare_boat, declare_fleet, encode, state_topic
from fleet.recording.writer import Recorder


@pytest.fixture(scope="module")
def text(run: Run) -> str:
    """The page of the run."""
    return write_report(run.folder).read_text(encoding="utf-8")


VOID = {"meta", "br", "img", "link", "hr", "input"}


class Page(HTMLParser):
    """Collects what a page would load, and whether its tags match."""

    def __init__(self) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.tags: set[str] = set()
        self.open: list[str] = []
        self.heads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag not in VOID:
            self.open.append(tag)
        self.heads += [value or "" for name, value in attrs if name == "id"]
        self.loads += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href", "data")]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_report_is_one_page_without_scripts_that_loads_nothing(text: str) -> None:
    page = Page()
    page.feed(text)
    assert page.open == []
    assert "script" not in page.tags
    assert "svg" in page.tags
    assert all(one.startswith("#") for one in page.loads)  # within the picture
    assert not re.search(r"url\((?!#)|@import", text)


def test_the_report_says_checks_events_with_reasons_and_approaches(text: str) -> None:
    assert "Overtaking on a straight path &lt;&amp;&gt;" in text
    for expected in ("passed", "min_separation_m", "blue - red", "5.95 m", "keeps clear of the other", "ahead"):
        assert expected in text


@pytest.mark.parametrize(("name", "begins"), [("run.png", b"\x89PNG"), ("run.svg", b"<?xml")])
def test_the_picture_is_drawn_by_the_ending_of_its_name(run: Run, tmp_path: Path, name: str, begins: bytes) -> None:
    drawn = draw(run.folder, tmp_path / "pictures" / name)
    assert drawn.read_bytes().startswith(begins)


def test_without_matplotlib_the_error_names_the_extra_and_the_page_is_written_all_the_same(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(UsageError, match=r"fleet-usv\[plots\]"):
        draw(run.folder, tmp_path / "run.png")
    assert "fleet-usv[plots]" in write_report(run.folder, tmp_path / "page.html").read_text(encoding="utf-8")


def test_numbers_are_shown_with_their_unit() -> None:
    assert [shown(1.234, "m"), shown(2.0, "s"), shown(3), shown(None, "m"), shown(float("nan"))] == [
        "1.23 m", "2 s", "3", "none", "none",
    ]  # fmt: skip


def cells(text: str, heading: str) -> list[list[str]]:
    """Rows of the table under a heading, as words."""
    table = text.split(f"<h2>{heading}</h2>")[1].split("</table>", maxsplit=1)[0].split("<tbody>")[1]
    rows = re.findall(r"<tr>(.*?)</tr>", table, flags=re.DOTALL)
    return [[re.sub(r"<[^>]+>", "", one) for one in re.findall(r"<td[^>]*>(.*?)</td>", row)] for row in rows]


def test_every_boat_check_approach_and_decision_is_there_with_its_number(run: Run, text: str) -> None:
    series, summary = load(run.folder), summarise(run.folder)
    assert [row[0] for row in cells(text, "Boats")] == ["blue", "red"]
    assert {row[0]: (row[1], row[3]) for row in cells(text, "Checks")} == {
        one.name: (shown(one.value, "m" if one.name.endswith("_m") else ""), "ok") for one in summary.checks
    }
    nearest = approaches(series.tracks)[0]
    assert cells(text, "Closest approaches") == [
        ["blue - red", f"{nearest.distance_m:.2f} m", f"{nearest.at_s:.1f} s", "blue avoid, red avoid", ""]
    ]
    decided = cells(text, "Decisions")
    assert [(row[0], row[2], row[3]) for row in decided] == [
        ("40.1 s", boat, "keeps clear of the other, ahead") for boat in ("red", "blue")
    ]
    assert len(cells(text, "Events and commands")) == len(series.events) == 4


def test_the_top_says_verdict_worst_numbers_and_when(run: Run, text: str) -> None:
    top = text.split("<figure>", maxsplit=1)[0]
    nearest = approaches(load(run.folder).tracks)[0]
    for expected in ("2 of 2", "all hold", f"blue - red at {nearest.at_s:.1f} s", "largest cross-track error", "4 m"):
        assert expected in top


def test_no_name_stands_twice_in_a_page_and_every_reference_has_its_target(text: str) -> None:
    found = Page()
    found.feed(text)
    assert len(found.heads) == len(set(found.heads))
    assert {one[1:] for one in found.loads} <= set(found.heads)
    assert set(re.findall(r"url\(#([^)]+)\)", text)) <= set(found.heads)


def test_a_page_is_small(text: str) -> None:
    assert len(text) < 400_000


def test_pictures_have_words_for_those_who_cannot_see_them(text: str) -> None:
    said = re.findall(r'<svg role="img" aria-label="([^"]+)"', text)
    assert len(said) == 2
    assert said[0].startswith("Map of the tracks of blue, red. Closest approach: blue and red, 5.95 m at ")


def lone(**more: object) -> Series:
    t = np.arange(0.0, 10.0, 0.1)
    track = Track(t=t, x=t, y=0.0 * t, psi=0.0 * t, speed=1.0 + 0.0 * t, length_m=2.4)
    return Series(**{"folder": Path("nowhere"), "start_ns": 0, "tracks": {"b1": track}, **more})  # type: ignore[arg-type]


def test_one_boat_without_events_gives_a_page() -> None:
    text = page(lone(), summary_of(lone(), "alone", {}), pictures(lone(), {}))
    assert "no checks" in text
    assert "Closest approaches" not in text
    assert "<h2>Decisions</h2><p>none</p>" in text


def test_a_run_that_ended_before_its_mission_says_so() -> None:
    assert "The run ended after 9.9 s; its mission lasts 130 s." in page(
        lone(), summary_of(lone(), "cut", {}), "", {"duration_s": 130.0}
    )


def nameless(folder: Path, fixes: bool) -> Run:
    """A recording of a boat that knew no position, or of nothing at all."""
    run = Run(folder)
    folder.mkdir(parents=True)
    recorder = Recorder(run.recording, {"mission": "none"}, wait=True)
    declare_fleet(recorder)
    if fixes:
        declare_boat(recorder, "b1")
        for k in range(20):
            state = State(stamp_ns=T0 + k * 10**8, x_m=None, y_m=None, psi_rad=None, sog_mps=None, mode="fault")
            recorder.put(state_topic("b1"), state.stamp_ns, encode(state))
    recorder.close()
    return run


def test_a_boat_without_a_position_gives_a_page_that_says_so(tmp_path: Path) -> None:
    text = write_report(nameless(tmp_path / "run", fixes=True).folder).read_text(encoding="utf-8")
    assert "No position is known of b1." in text
    assert "no position is known" in text
    assert cells(text, "Boats")[0][:4] == ["b1", "none", "none", "fault"]


def test_a_recording_of_nothing_is_refused_unless_asked_for_and_then_gives_a_page(tmp_path: Path) -> None:
    run = nameless(tmp_path / "run", fixes=False)
    with pytest.raises(RecordingError, match="no boat in it"):
        write_report(run.folder)
    text = write_report(run.folder, series=load(run.folder, empty=True)).read_text(encoding="utf-8")
    assert "Nothing was recorded of any boat." in text
