"""Noise and mutated frames do not move the boat, and are counted."""

from __future__ import annotations

from tests.attack.mavlink import WORST_M, attack


def test_ten_thousand_bad_frames_move_nothing_and_every_good_one_is_taken() -> None:
    result = attack(10_000)
    assert result.worst_m < WORST_M
    assert result.unknown_ticks == 0
    assert result.foreign_authority == 0
    assert result.taken >= result.good_sent
    assert result.taken <= result.good_sent + 10_000 // 500, "by luck one of 65,536, and mutations that undo each other"
    assert result.bad > 5_000


def test_frames_with_wrong_values_and_a_right_checksum_move_nothing_either() -> None:
    result = attack(5_000, lucky=1_000)
    assert result.lucky > 30
    assert result.worst_m < WORST_M
    assert result.values_refused > 0
