"""The page and the picture of a run stand alone."""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from fleet.analysis.figures import draw
from fleet.analysis.report import shown, write_report
from fleet.errors import UsageError
from fleet.recording.runs import Run

VOID = {"meta", "br", "img", "link", "hr", "input"}


class Page(HTMLParser):
    """Collects what a page would load, and whether its tags match."""

    def __init__(self) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.tags: set[str] = set()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        if tag not in VOID:
            self.open.append(tag)
        self.loads += [value or "" for name, value in attrs if name in ("src", "href", "xlink:href", "data")]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_report_is_one_page_without_scripts_that_loads_nothing(run: Run) -> None:
    text = write_report(run.folder).read_text(encoding="utf-8")
    page = Page()
    page.feed(text)
    assert page.open == []
    assert "script" not in page.tags
    assert "svg" in page.tags
    assert all(one.startswith("#") for one in page.loads)  # within the picture
    assert not re.search(r"url\((?!#)|@import", text)


def test_the_report_says_checks_events_with_reasons_and_approaches(run: Run) -> None:
    text = write_report(run.folder).read_text(encoding="utf-8")
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
