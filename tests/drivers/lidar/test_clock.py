"""A scanner's milliseconds on the agent's clock: wrapping, drift, and a scanner that was switched off and on."""

from __future__ import annotations

from fleet.drivers.lidar.clock import MS, WRONG_MOST, ScannerClock
from fleet.drivers.lidar.scip import TICKS

S = 1_000_000_000


def test_the_answer_that_came_back_quickest_says_how_the_clocks_lie() -> None:
    clock = ScannerClock()
    clock.answered(1000, 100 * S, 100 * S + 60 * MS)  # in the middle, 30 ms late
    clock.answered(1100, 100 * S + 100 * MS, 100 * S + 104 * MS)
    clock.answered(1200, 100 * S + 200 * MS, 100 * S + 290 * MS)
    assert clock.stamp_ns(2000, 101 * S + 20 * MS, 0) == 100 * S + 102 * MS + 900 * MS


def test_it_goes_on_where_the_scanners_24_bits_begin_anew() -> None:
    clock = ScannerClock()
    clock.answered(TICKS - 50, 10 * S, 10 * S)
    assert clock.stamp_ns(TICKS - 10, 10 * S + 60 * MS, 0) == 10 * S + 40 * MS
    assert clock.stamp_ns(30, 10 * S + 100 * MS, 0) == 10 * S + 80 * MS
    assert clock.refused == 0


def test_a_scanner_that_does_not_tell_its_time_is_stamped_by_its_first_scan() -> None:
    clock = ScannerClock()
    assert not clock.known
    assert clock.stamp_ns(777, 5 * S, 100 * MS) == 5 * S - 100 * MS
    assert clock.stamp_ns(877, 5 * S + 130 * MS, 100 * MS) == 5 * S  # this one came 30 ms late


def test_a_clock_that_runs_slow_is_followed() -> None:
    clock = ScannerClock()
    clock.answered(0, 0, 0)
    for k in range(1, 3000):  # five minutes of ten scans a second, 100 parts in a million slow
        true_ns = k * 100 * MS
        stamp = clock.stamp_ns(round(k * 100 * (1.0 - 1e-4)), true_ns + (30 + k % 7) * MS, 0)
        assert abs(stamp - true_ns) < 4 * MS


def test_a_scanner_that_was_switched_off_and_on_is_noticed_and_no_scan_gets_a_wrong_stamp() -> None:
    clock = ScannerClock()
    clock.answered(500_000, 10 * S, 10 * S)
    assert clock.stamp_ns(500_100, 10 * S + 120 * MS, 0) > 0
    stamps = [clock.stamp_ns(100 * k, 12 * S + 100 * k * MS, 0) for k in range(WRONG_MOST)]
    assert stamps == [0] * WRONG_MOST
    assert clock.lost
    assert clock.refused == WRONG_MOST
