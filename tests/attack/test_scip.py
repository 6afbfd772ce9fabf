"""A small sample of `python -m tests.attack.scip`."""

from __future__ import annotations

import random

from tests.attack.scip import attack, held


def test_random_and_mutated_frames_crash_nothing_and_give_no_wrong_range() -> None:
    result = attack(3000, random.Random(7))
    assert held(result), result
    assert result.good_heard > 400
    assert result.wrong_bit > 400
    assert 60 < result.published_refused < result.published - 60
