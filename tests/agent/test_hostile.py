"""Messages that lie: none is obeyed, all are counted, no good boat is evicted, and limits hold."""

from __future__ import annotations

import math
import random
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fleet.agent.modes import Mode
from fleet.mission.model import Mission, Start, Through
from fleet.wire import keys
from fleet.wire.codec import encode
from fleet.wire.messages import BoatState, FormationOrder, MissionOrder, Revision, Signed
from tests.agent.harness import CIRCUIT, MAJOR, Sea, forged, mission, sailing

FLOATS = [name for name, kind in BoatState.__annotations__.items() if kind == "float"]
EXTREMES = [1e300, -1e300, 1e154, -1e154, 1e18, -1e18, 1e9, -1e9, 7.0, 0.0, -0.0, 5e-324]


def steers_well(sea: Sea, boat: str = "b1") -> None:
    decision = sea.agent(boat).decision
    limits = sea.agent(boat).params.limits
    assert 0.0 <= decision.u_d <= limits.speed_max_mps
    assert abs(decision.r_d) <= limits.yaw_rate_max_radps
    assert math.isfinite(decision.s + decision.e + decision.gx + decision.gy)


@pytest.mark.parametrize("method", ["circle", "scoring"])
@pytest.mark.parametrize("field", FLOATS)
def test_a_well_formed_state_with_an_extreme_number_upsets_nobody(tmp_path: Path, field: str, method: str) -> None:
    sea = sailing(
        tmp_path, mission(2, 12.0, method=method, path=CIRCUIT, starts=[Start(s_m=45.0), Start(s_m=30.0)]), 3.0
    )
    sea.freeze("b2")
    for k, value in enumerate(EXTREMES, 1):
        model = sea.state("b2")
        sea.say_as("b2", forged(model, seq=model.seq + k, stamp_ns=sea.now_ns, **{field: value}))
        sea.tick()
        steers_well(sea)
    sea.run(1.5)  # silent: predicted along the path from what was said last
    steers_well(sea)
    sea.thaw("b2")
    sea.run(1.5)
    steers_well(sea)


fields = st.dictionaries(st.sampled_from(FLOATS), st.floats(allow_nan=True, allow_infinity=True), max_size=6)
wholes = st.dictionaries(
    st.sampled_from(["epoch", "seq", "stamp_ns", "clock_ns", "lap", "mode", "reasons"]),
    st.integers(-(1 << 63), (1 << 63) - 1),
    max_size=3,
)


def test_any_state_at_all_leaves_the_others_within_their_limits(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3, 12.0), 3.0)

    @settings(max_examples=300, deadline=None, suppress_health_check=list(HealthCheck))
    @given(fields, wholes, st.sampled_from(["b2", "b1", "stranger"]))
    def throw(floats: dict[str, float], whole: dict[str, int], name: str) -> None:
        model = sea.state("b2")
        changes: dict[str, Any] = {"seq": model.seq + 1, "stamp_ns": sea.now_ns, "boat": name, **floats, **whole}
        sea.agent("b1").bus.watch("stranger")
        sea.say_as(name, forged(model, **changes))
        sea.tick()
        steers_well(sea, "b1")
        steers_well(sea, "b3")

    throw()


def test_rubbish_is_counted_and_nothing_else(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3, 12.0), 3.0)
    rng = random.Random(5)
    good = sea.raw["b2"]
    before = sea.agent("b1").picture.refused.total()
    bad = 0
    for _ in range(30):
        for _ in range(100):
            kind = rng.randrange(3)
            if kind == 0:
                payload = rng.randbytes(rng.randrange(300))
            elif kind == 1:
                payload = good[: rng.randrange(len(good))]
            else:
                payload = forged(sea.state("b2"), **{rng.choice(FLOATS): rng.choice([math.nan, math.inf, -math.inf])})
            sea.say_as("b2", payload, to=("b1",))
            bad += 1
        sea.tick()
        assert sea.members("b1") == 2, "no good boat is evicted"
    assert sea.agent("b1").picture.refused.total() - before == bad
    assert sea.mode("b1") in (Mode.FOLLOW, Mode.AVOID)


def test_a_flood_under_one_name_does_not_silence_another(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3, 12.0), 3.0)
    for _ in range(20):
        for _ in range(2000):
            sea.say_as("b2", b"\x00", to=("b1",))
        sea.tick()
        other = sea.agent("b1").picture.others["b3"]
        assert other.track is not None
        assert sea.now_ns - other.track.heard_ns <= 100_000_000


def test_foreign_missions_and_revisions_in_a_state_are_asked_about_and_not_obeyed(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(3, 12.0), 3.0)
    for k in range(30):
        model = sea.state("b2")
        far = Revision(1 << 39, "evil") if k % 2 else Revision(999, "evil")
        sea.say_as(
            "b2",
            forged(
                model,
                seq=model.seq + 1,
                stamp_ns=sea.now_ns,
                held=far,
                mission_id="evil" if k % 3 else model.mission_id,
            ),
            to=("b1",),
        )
        sea.tick()
    sea.run(2.0)
    assert sea.revision("b1") == Revision(0, "")
    assert sea.mode("b1") in (Mode.FOLLOW, Mode.AVOID)
    assert sea.members("b1") == 2


commands = st.binary(max_size=300)


def test_any_bytes_asked_of_a_boat_are_answered_or_dropped(tmp_path: Path) -> None:
    sea = sailing(tmp_path, mission(2, 12.0), 3.0)

    @settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
    @given(commands, st.sampled_from([keys.COMMAND, keys.ECHO, keys.MISSION, keys.FORMATION, "nonsense"]))
    def throw(payload: bytes, what: str) -> None:
        for bus in sea.water.boats.values():
            bus.deposit_request(what, payload, lambda answer: None)
        sea.tick()
        steers_well(sea)

    throw()
    assert set(sea.modes()) <= {Mode.FOLLOW, Mode.AVOID}


@settings(max_examples=150, deadline=None)
@given(
    spacing=st.floats(allow_nan=True, allow_infinity=True),
    cruise=st.floats(allow_nan=True, allow_infinity=True),
    wait=st.floats(allow_nan=True, allow_infinity=True),
    counter=st.integers(-(1 << 63), (1 << 63) - 1),
)
def test_any_formation_is_taken_or_refused_with_words(
    tmp_path_factory: pytest.TempPathFactory, spacing: float, cruise: float, wait: float, counter: int
) -> None:
    sea = formation_sea(tmp_path_factory)
    orders = sea.agent("b1").orders
    held = orders.sailing
    assert held is not None
    order = FormationOrder(MAJOR, held.order.mission_id, Revision(counter, "x"), held.held, spacing, cruise, wait)
    words = Signed(encode(order))
    text = orders.handed_on(words, wait if math.isfinite(wait) else 0.0, sea.now_ns)
    assert text or orders.sailing is not None
    held.pending = held.pending_words = None


_SEAS: list[Sea] = []


def formation_sea(factory: pytest.TempPathFactory) -> Sea:
    if not _SEAS:
        _SEAS.append(sailing(factory.mktemp("sea"), mission(2, 12.0), 1.0))
    return _SEAS[0]


def hostile_missions() -> list[tuple[str, bytes]]:
    from fleet.mission.load import encode as encode_mission

    def lined(**more: Any) -> Mission:
        return mission(2, 12.0, **more)

    huge = 1e308
    return [
        ("nothing", b""),
        ("rubbish", b"\x93\x01\x02"),
        ("a million zeros", b"\x00" * 1_000_000),
        (
            "infinite path",
            encode_mission(lined(path=type(CIRCUIT)(points=((0.0, 0.0), (huge, huge)), corner_radius_m=1.0))),
        ),
        ("nan path", encode_mission(lined(path=Through(points=((0.0, 0.0), (math.nan, 1.0), (5.0, 5.0)))))),
        ("one point thrice", encode_mission(lined(path=Through(points=((1.0, 1.0),) * 3)))),
        ("start beyond everything", encode_mission(lined(starts=[Start(s_m=huge), Start(s_m=-huge)]))),
        ("start at nan", encode_mission(lined(starts=[Start(s_m=math.nan), Start(s_m=math.nan)]))),
        ("slots at infinity", encode_mission(lined(slots=[math.inf, -math.inf]))),
        ("slots huge", encode_mission(lined(slots=[huge, -huge]))),
        ("cruise huge", encode_mission(lined(cruise_mps=huge))),
    ]


@pytest.mark.parametrize(("name", "content"), hostile_missions(), ids=lambda v: v if isinstance(v, str) else "")
def test_a_hostile_mission_is_refused_with_words_and_the_boat_stays_where_it_is(
    tmp_path: Path, name: str, content: bytes
) -> None:
    sea = Sea(tmp_path, mission(2, 12.0))
    sea.run(0.5)
    words = Signed(encode(MissionOrder(MAJOR, "evil", "anna", sea.now_ns, content, 0.0)))
    acks = sea.command("launch", order=words)
    assert len(acks) == 2
    assert not any(ack.ok for ack in acks.values()), name
    assert all(ack.reason for ack in acks.values())
    sea.run(1.0)
    assert sea.modes() == [Mode.STANDBY] * 2
