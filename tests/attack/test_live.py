"""A live fleet under attack, 1,000 messages a second: none obeyed, all counted, no tick missed, no good peer evicted.

10,000 messages here; `python -m tests.attack.run --count 100000` sends the whole of it, FLEET_ATTACK_COUNT more here.
"""

from __future__ import annotations

import os

import pytest

from fleet.agent.agent import MOST_STRANGERS
from fleet.sim.sail import OPERATOR
from tests.attack.run import (
    ATTACK_S,
    BOATS,
    LISTENS_S,
    QUIET_S,
    VICTIM,
    Attack,
    aside_m,
    attack,
    gaps_m,
    late_ticks,
    reasons,
    speeds,
)

COUNT = int(os.environ.get("FLEET_ATTACK_COUNT", "10000"))
END_S = ATTACK_S + LISTENS_S + COUNT / 1000.0
pytestmark = [
    pytest.mark.sails,
    pytest.mark.timeout(180 + COUNT // 500),
]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Attack:
    return attack(tmp_path_factory.mktemp("attack"), COUNT)


def test_as_much_was_sent_as_was_meant(done: Attack) -> None:
    assert sum(done.result.sent.values()) == COUNT
    assert done.result.took_s < COUNT / 1000.0 * 1.2 + 1.0


def test_no_message_was_obeyed(done: Attack) -> None:
    obeyed = {kind: count for kind, count in done.result.obeyed.items() if count}
    assert set(obeyed) <= {"commands: replayed"}, "said again, acknowledged again"
    for boat in BOATS:
        assert done.run.own_modes(boat, QUIET_S, END_S) <= {"follow", "avoid"}
        since = [s for s in done.run.own_states[boat] if QUIET_S <= done.run.t(s.stamp_ns) <= END_S]
        assert len({(s.mission_id, s.revision, s.spacing_m, s.cruise_mps) for s in since}) == 1
        assert done.probes[-1].statuses[boat].controller == OPERATOR
        for kind in ("mission", "formation", "superseded", "resumed", "trouble"):
            assert not [e for e in done.run.own[boat] if e.kind == kind and QUIET_S < done.run.t(e.stamp_ns) < END_S]


def test_no_good_peer_was_evicted_and_nobody_was_thought_to_be_another(done: Attack) -> None:
    for boat in BOATS:
        assert not reasons(done.run, boat, QUIET_S, END_S) - {"keeping clear"}


def test_the_boats_sailed_as_if_nothing_were(done: Attack) -> None:
    for since_s, until_s in ((QUIET_S, ATTACK_S), (ATTACK_S, END_S)):
        low, high = gaps_m(done.run, since_s, until_s)
        slow, fast = speeds(done.run, since_s, until_s)
        assert 19.5 < low <= high < 20.5
        assert 0.9 < slow <= fast < 1.1
        assert aside_m(done.run, since_s, until_s) < 0.5


def test_every_state_was_refused_and_counted(done: Attack) -> None:
    on = done.result.on
    keys_heard = len(BOATS) + MOST_STRANGERS  # a message on all keys at once is heard on each
    heard = sum(on.get(boat, 0) for boat in BOATS) + on.get("*", 0) * keys_heard
    for boat in BOATS:
        refused = done.grew(boat, "messages_refused")
        assert abs(refused - heard) <= 0.005 * heard, (boat, refused, heard)


def test_every_request_was_answered_and_those_that_ask_for_something_wrong_counted(done: Attack) -> None:
    result = done.result
    for kind, count in result.sent.items():
        if kind.startswith(("commands", "ask")):
            assert result.answered.get(kind, 0) >= 0.99 * count, kind
    wrong = sum(n for kind, n in result.sent.items() if kind.startswith("commands") and kind != "commands: replayed")
    assert abs(done.grew(VICTIM, "requests_refused") - wrong) <= 0.01 * wrong + 2


def test_no_tick_was_missed_because_of_it(done: Attack) -> None:
    for boat in BOATS:
        before = late_ticks(done.run, boat, QUIET_S, ATTACK_S)
        spare = 2 + before * (END_S - ATTACK_S) / (ATTACK_S - QUIET_S)  # on a busy machine some are missed anyway
        assert late_ticks(done.run, boat, ATTACK_S, END_S) <= spare, boat


def test_no_memory_was_filled(done: Attack) -> None:
    for boat in BOATS:
        assert done.rss_grew_mb(boat) < 40.0, boat
