"""Noise, and frames that mean nothing, at a ground-station bridge: no word to the fleet, boats still shown."""

from __future__ import annotations

from tests.attack.gcs import BOATS, attack


def test_six_thousand_bad_frames_say_nothing_to_the_fleet_and_hold_nothing_up() -> None:
    result = attack(6_000)
    assert result.internal_errors == 0
    assert result.wishes_of_noise == 0, "one of 65,536 has a right checksum by chance; these have none"
    assert result.wishes > 0, "well-formed frames are taken"
    assert result.heartbeats >= len(BOATS) * int(result.seconds_simulated - 1.0)
    assert result.most_wishes_waiting <= 400
    assert result.most_out < 2_000
    assert result.bad > 500
