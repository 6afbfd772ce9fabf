"""How old a position is; what a wrong clock does to it: never that it is ignored (DESIGN section 4, Age)."""

from __future__ import annotations

from pathlib import Path

import pytest

from fleet.agent.modes import Mode
from fleet.agent.picture import Other, Track
from tests.agent.harness import Sea, mission

WRONG_BY_S = [-3600.0, -5.0, 0.3, 5.0, 29.0, 3600.0, 1e9]


def launched(folder: Path, *, wrong_s: float = 0.0, clock_ns: int = 50_000_000, delay_s: float = 0.0) -> Sea:
    """Two boats under way; the clock of b2 is wrong, and says how sure it is of itself."""
    sea = Sea(folder, mission(2, 12.0), delay_s=delay_s)
    sea.kill("b2")
    station = sea.stations["b2"]
    station.clock_offset_ns, station.clock_ns = int(wrong_s * 1e9), clock_ns
    station.switch_on()
    sea.run(0.5)
    assert all(ack.ok for ack in sea.launch().values())
    sea.run(10.0)
    return sea


def seen(sea: Sea, by: str = "b1", of: str = "b2") -> tuple[Other, Track]:
    other = sea.agent(by).picture.others[of]
    assert other.track is not None
    return other, other.track


def age(sea: Sea, by: str = "b1", of: str = "b2") -> tuple[float, float]:
    other, track = seen(sea, by, of)
    return sea.agent(by).picture.age_s(other, track, sea.agent(by).now_ns)


def test_between_disciplined_clocks_the_age_is_now_less_the_stamp(tmp_path: Path) -> None:
    sea = launched(tmp_path, delay_s=0.3)
    _, track = seen(sea)
    assert age(sea)[0] == pytest.approx((sea.now_ns - track.state.stamp_ns) * 1e-9)
    assert age(sea)[0] >= 0.3


def test_the_age_between_disciplined_clocks_is_as_uncertain_as_both_clocks(tmp_path: Path) -> None:
    assert age(launched(tmp_path))[1] == pytest.approx(0.1)


def test_a_clock_that_says_it_is_not_disciplined_makes_no_age(tmp_path: Path) -> None:
    sea = launched(tmp_path, wrong_s=20.0, clock_ns=200_000_000)
    other, track = seen(sea)
    assert other.half_trip_s >= 0.0, "an echo was asked for"
    assert age(sea)[0] == pytest.approx((sea.now_ns - track.heard_ns) * 1e-9 + other.half_trip_s)


def test_half_the_round_trip_of_an_echo_takes_the_place_of_the_stamp(tmp_path: Path) -> None:
    sea = launched(tmp_path, wrong_s=20.0, clock_ns=10**9, delay_s=0.4)
    other, _ = seen(sea)
    assert other.half_trip_s == pytest.approx(0.4, abs=0.1), "there and back, each after 0.4 s and at the next tick"
    assert age(sea)[1] == other.half_trip_s


def test_an_age_that_was_never_measured_is_taken_to_be_a_second(tmp_path: Path) -> None:
    sea = launched(tmp_path, wrong_s=20.0, clock_ns=10**9)
    other, track = seen(sea)
    other.half_trip_s = -1.0
    picture = sea.agent("b1").picture
    assert picture.age_s(other, track, track.heard_ns) == (1.0, 1.0)


def test_an_uncertain_age_widens_the_obstacle_by_what_it_may_have_moved(tmp_path: Path) -> None:
    sea = launched(tmp_path, wrong_s=20.0, clock_ns=10**9, delay_s=0.5)
    other, track = seen(sea)
    (peer,) = sea.agent("b1").peers
    assert peer.widen == pytest.approx(other.half_trip_s * track.state.sog_mps)
    assert peer.widen > 0.4


def test_no_echo_is_asked_for_while_clocks_tell_the_age(tmp_path: Path) -> None:
    sea = launched(tmp_path)
    assert seen(sea)[0].half_trip_s == -1.0


@pytest.mark.parametrize("clock_ns", [50_000_000, 10**9], ids=["lies", "honest"])
@pytest.mark.parametrize("wrong_s", WRONG_BY_S)
def test_a_wrong_clock_never_makes_a_position_ignored(tmp_path: Path, wrong_s: float, clock_ns: int) -> None:
    sea = launched(tmp_path, wrong_s=wrong_s, clock_ns=clock_ns)
    for by, of in (("b1", "b2"), ("b2", "b1")):
        (peer,) = sea.agent(by).peers
        believed = abs(wrong_s) < 30.0 and clock_ns < 10**8  # then dead-reckoned for the wrong time, 10 s at most
        assert peer.x == pytest.approx(sea.where(of)[0], abs=12.0 if believed else 1.5)
        assert sum(sea.agent(by).picture.refused.values()) == 0
    assert set(sea.modes()) <= {Mode.FOLLOW, Mode.AVOID}
    assert sea.members("b1") == sea.members("b2") == 1


@pytest.mark.parametrize("wrong_s", [-3600.0, 3600.0, 1e9])
def test_a_boat_that_restarts_with_its_clock_put_right_or_wrong_is_heard_at_once(
    tmp_path: Path, wrong_s: float
) -> None:
    sea = launched(tmp_path, wrong_s=wrong_s)
    sea.kill("b2")
    sea.run(2.0)
    sea.stations["b2"].clock_offset_ns = 0
    sea.restart("b2")
    sea.run(1.0)
    assert sea.agent("b1").now_ns - seen(sea)[1].heard_ns < 3e8
    sea.kill("b2")
    sea.run(2.0)
    sea.stations["b2"].clock_offset_ns = int(wrong_s * 1e9)
    sea.restart("b2")
    sea.run(1.0)
    assert sea.agent("b1").now_ns - seen(sea)[1].heard_ns < 3e8
