"""A boat whose agent hears sentences and nothing else: what it does without one sensor or the other."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.drivers.sensors.losses import Outcome, lose


def lost(name: str, folder: Path) -> Outcome:
    return lose(name, folder, 20.0)


def test_with_all_of_them_it_keeps_its_path(tmp_path: Path) -> None:
    it = lost("nothing", tmp_path)
    assert (it.told_s, it.stopped_s) == (math.inf, math.inf)
    assert it.aside_m < 0.3


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("GNSS receiver says void", "nmea: no fix: void"),
        ("the whole line cut", "nmea: silent"),
        ("the line 2 s late", "nmea: no fix: its sentences come late"),
    ],
)
def test_without_fixes_it_says_so_after_three_seconds_and_stops_after_ten(name: str, what: str, tmp_path: Path) -> None:
    it = lost(name, tmp_path)
    assert it.told_s == pytest.approx(3.0, abs=0.3)
    assert it.what == what
    assert it.stopped_s == pytest.approx(10.0, abs=0.3)
    assert it.aside_m < 5.0


def test_without_the_compass_it_says_so_and_sails_on(tmp_path: Path) -> None:
    it = lost("compass silent", tmp_path)
    assert it.what == "nmea: no heading"
    assert it.stopped_s == math.inf
    assert it.aside_m < 0.5
