"""Short versions of the long column: nobody drifts, and one straggler does not pull the others apart."""

from __future__ import annotations

import numpy as np

from tests.proofs.column import BEHIND_M, column, kept, straggled
from tests.proofs.fleets import sail


def test_three_boats_in_a_current_with_bad_radio_and_noise_keep_their_places_in_every_part_of_the_time() -> None:
    seen = sail(column("rough", boats=3, duration_s=390.0))
    for part in kept(seen, 390.0):
        assert part.along_rms_m < 1.0  # GNSS errs by 0.5 m at one sigma
        assert part.cross_rms_m < 1.0


def test_the_others_of_five_keep_together_while_one_comes_from_200_m_behind() -> None:
    seen = sail(column(boats=5, duration_s=260.0, behind_m=BEHIND_M))
    found = straggled(seen)
    assert found.apart_m < 0.1
    assert 0.3 < found.waiting_mps < found.coming_mps  # they wait under way, and do not stop
    assert found.joined_s < 230.0
    assert found.least_m > 13.0
    assert np.all(np.diff(seen.x[100:, :4].mean(axis=1)) > 0.0)
