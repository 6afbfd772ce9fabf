"""How far a sweep is, as lines and as a bar."""

from __future__ import annotations

import time

import pytest

from fleet.cli.progress import Bar, Lines, watcher, words
from fleet.sim.sweep.run import Progress


def progress(cases: int, ahead_s: float = 600.0) -> Progress:
    """A sweep of 400 cases, of which 100 took so long, the latest just now."""
    now = time.monotonic()
    return Progress(cases=cases, total=400, failures=3, before=cases - 100, began=now - ahead_s, latest=now)


def test_it_says_how_many_cases_fail_and_when_it_ends() -> None:
    said = words(progress(300))  # 100 in ten minutes, 100 are left
    assert said.startswith("300 of 400 cases, 3 failing, ends ")
    assert said.endswith((" in 10:00", " in 9:59"))
    assert len(said) + 31 <= 80
    assert words(progress(200, 3600.0)).endswith((" in 2:00:00", " in 1:59:59"))


def test_at_the_end_and_before_the_first_part_nothing_is_estimated() -> None:
    assert words(progress(400)) == "400 of 400 cases, 3 failing"
    assert words(Progress(100, 400, 0, 100, 0.0, 0.0)) == "100 of 400 cases, 0 failing"


def test_elsewhere_than_on_a_terminal_there_are_lines_but_not_for_every_part(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with watcher() as look:
        assert isinstance(look, Lines)
        for cases in (100, 200, 300, 400):
            look(progress(cases))
    assert [line[:3] for line in capsys.readouterr().err.splitlines()] == ["100", "400"]


def test_a_bar_ends_at_what_came_last(capsys: pytest.CaptureFixture[str]) -> None:
    with Bar() as look:
        look(progress(300))
        look(progress(400))
    assert "400 of 400 cases, 3 failing" in capsys.readouterr().err
