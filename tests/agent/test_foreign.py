"""Vessels that are not of the fleet: seen, given way to, by one boat, by a formation as one, and among fleet mates."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from msgspec.structs import replace

from fleet.agent.modes import Mode, Reason
from fleet.agent.scanned import Mate
from fleet.agent.step import FOREIGN_FROM
from fleet.agent.traffic import Traffic
from fleet.drivers.seam import Sighting
from fleet.mission.model import Ais, Gap, Mission, Start, Steady, Straight, Vessel
from fleet.wire.codec import Refused, decode_state
from fleet.wire.memory_bus import MemoryBus

from .harness import BEGIN_NS, Sea, forged, mission

BEGINS_NS = BEGIN_NS + 2_600_000_000
SURE = Ais(interval_s=2.0, noise_m=1.0, loss=0.0)
FERRY = Vessel(
    name="ferry",
    length_m=20.0,
    speed_mps=4.0,
    track=Steady(start=(145.0, 190.0), course_deg=270.0),  # from starboard: with b1 at the crossing
    sensed=SURE,
)


def meeting(
    folder: Path,
    *vessels: Vessel,
    boats: int = 1,
    what: Mission | None = None,
    before: Callable[[Sea], object] | None = None,
) -> Sea:
    """A fleet that begins, under way and in its places, when the vessels do."""
    chosen = what or mission(boats, method="scoring", fence=None)
    sea = Sea(folder, replace(chosen, traffic=vessels))
    sea.world.begins_ns = BEGINS_NS
    if before is not None:
        before(sea)
    sea.run(0.5)
    acks = sea.launch()
    assert all(ack.ok for ack in acks.values()), acks
    sea.run_until(lambda: sea.now_ns >= BEGINS_NS, 5.0)
    return sea


def hulls_apart(sea: Sea, boat: str, vessel: str = "ferry") -> float:
    """Distance of a boat from the middle line of a vessel, less half its beam [m]."""
    craft = sea.world.crafts[vessel]
    x, y = sea.where(boat)
    dx, dy = x - craft.motion.x, y - craft.motion.y
    c, s = math.cos(craft.motion.chi), math.sin(craft.motion.chi)
    half = 0.4 * craft.script.length_m
    along = min(max(dx * c + dy * s, -half), half)
    return math.hypot(dx - along * c, dy - along * s) - 0.1 * craft.script.length_m


def watch_least(sea: Sea, boats: list[str], vessel: str = "ferry") -> dict[str, float]:
    """The least distances from now on, kept while it sails."""
    least = dict.fromkeys(boats, math.inf)

    def look() -> None:
        for boat in boats:
            least[boat] = min(least[boat], hulls_apart(sea, boat, vessel))

    sea.each_tick.append(look)
    return least


def acting(sea: Sea, boat: str) -> bool:
    return sea.agent(boat).lookout.acting


def begins_to_act(sea: Sea, boats: list[str], at_most_s: float = 20.0) -> dict[str, float]:
    """When each boat begins to act [s]."""
    found: dict[str, float] = {}

    def look() -> bool:
        for boat in boats:
            if boat not in found and acting(sea, boat):
                found[boat] = sea.time_s
        return len(found) == len(boats)

    sea.run_until(look, at_most_s)
    return found


# -- one boat --------------------------------------------------------------------------------------------------------
def test_a_boat_gives_way_to_a_ship_from_starboard_says_so_and_goes_back_to_its_path(tmp_path: Path) -> None:
    sea = meeting(tmp_path, FERRY)
    least = watch_least(sea, ["b1"])
    begins_to_act(sea, ["b1"])
    assert sea.mode("b1") == Mode.AVOID
    assert Reason.FOREIGN in sea.reasons("b1")
    (first,) = sea.says("b1", "avoid")
    assert first.startswith("gives way to ferry, crossing from starboard: ")
    assert sea.says("b1", "traffic")[0].startswith("ferry: crossing from starboard, gives way, ")
    sea.run(1.0)
    assert sea.statuses["b1"].traffic[0].startswith("ferry: ")
    assert sea.agent("b1").decision.target == FOREIGN_FROM + 1.0
    sea.run(70.0)
    assert not acting(sea, "b1")
    assert sea.says("b1", "avoid")[-1] == "past and clear of other vessels, back to the path"
    assert least["b1"] > 10.0


def test_a_ship_that_passes_far_off_changes_nothing(tmp_path: Path) -> None:
    far = replace(FERRY, track=Steady(start=(600.0, 190.0), course_deg=270.0))
    sea = meeting(tmp_path, far)
    sea.run(15.0)
    assert sea.mode("b1") == Mode.FOLLOW
    assert sea.says("b1", "avoid") == []
    assert sea.agent("b1").decision.u_d == pytest.approx(1.0)


def test_a_boat_stands_on_first_for_a_ship_from_port(tmp_path: Path) -> None:
    port = replace(FERRY, track=Steady(start=(145.0, -190.0), course_deg=90.0))
    sea = meeting(tmp_path, port)
    least = watch_least(sea, ["b1"])
    begun = begins_to_act(sea, ["b1"], 45.0)["b1"] - 2.6
    assert 8.0 < begun < 40.0  # a boat that has to give way acts within two seconds
    assert "which has not given way" in sea.says("b1", "avoid")[0]
    sea.run(30.0)
    assert least["b1"] > 3.0


def test_a_boat_that_keeps_its_station_gets_out_of_the_way_and_comes_back(tmp_path: Path) -> None:
    sea = meeting(tmp_path, replace(FERRY, track=Steady(start=(260.0, 3.0), course_deg=180.0)))
    sea.command("hold")
    station = sea.where("b1")
    least = watch_least(sea, ["b1"])
    begins_to_act(sea, ["b1"], 30.0)
    assert sea.mode("b1") == Mode.HOLD
    sea.run(65.0)
    assert least["b1"] > 8.0
    assert math.dist(sea.where("b1"), station) < 4.0


def test_without_thrust_nothing_is_decided_about_ships(tmp_path: Path) -> None:
    sea = meeting(tmp_path, FERRY)
    sea.command("stop-now", command_id="s1")
    sea.run(10.0)
    assert sea.mode("b1") == Mode.NEUTRAL
    assert sea.agent("b1").state.foreign is None
    assert sea.agent("b1").lookout.traffic  # but it goes on looking


# -- a formation decides as one ----------------------------------------------------------------------------------------
BOATS = ["b1", "b2", "b3"]


def same_action(sea: Sea) -> None:
    told = {(m.sailed.a, m.sailed.factor) for m in (sea.agent(b).state.foreign.memory for b in BOATS)}  # type: ignore[union-attr]
    assert len(told) == 1


def test_the_formation_acts_in_the_same_tick_and_resumes_in_the_same_tick(tmp_path: Path) -> None:
    sea = meeting(tmp_path, FERRY, boats=3)
    least = watch_least(sea, BOATS)
    begun = begins_to_act(sea, BOATS)
    assert len(set(begun.values())) == 1
    same_action(sea)
    leader = sea.state("b1").foreign
    assert leader is not None
    assert not leader.alone
    assert sea.says("b2", "avoid")[0].startswith("keeps clear of ferry as its leader says: ")
    ended: dict[str, float] = {}

    def all_back() -> bool:
        ended.update({boat: sea.time_s for boat in BOATS if boat not in ended and not acting(sea, boat)})
        return len(ended) == 3

    sea.run_until(all_back, 90.0)
    assert len(set(ended.values())) == 1
    assert min(least.values()) > 9.0
    assert sea.least_m > 8.0


def test_an_order_is_sailed_by_all_at_once_though_a_third_of_the_messages_is_lost(tmp_path: Path) -> None:
    sea = meeting(tmp_path, FERRY, boats=3, before=lambda sea: through(sea, 0.0, 0.33))
    assert len(set(begins_to_act(sea, BOATS).values())) == 1
    same_action(sea)


def test_an_order_that_comes_late_is_sailed_at_once_when_it_comes(tmp_path: Path) -> None:
    later = replace(FERRY, sensed=replace(SURE, gaps=(Gap(from_s=0.0, to_s=4.0),)))  # the formation stands by then
    sea = meeting(tmp_path, later, boats=3, before=lambda sea: through(sea, 1.1, 0.0))
    begun = begins_to_act(sea, BOATS)
    assert begun["b2"] == begun["b3"]
    assert 0.2 < begun["b2"] - begun["b1"] < 0.8  # 1.1 s of delay, 0.7 s ahead
    sea.run(3.0)
    same_action(sea)


def test_an_order_that_comes_twice_is_sailed_once(tmp_path: Path) -> None:
    def twice(sea: Sea) -> None:
        def again() -> None:
            for name in ("b2", "b3"):
                if "b1" in sea.raw:
                    MemoryBus.deposit_state(sea.water.boats[name], "b1", sea.raw["b1"], sea.now_ns)

        sea.each_tick.append(again)

    sea = meeting(tmp_path, FERRY, boats=3, before=twice)
    begins_to_act(sea, BOATS)
    sea.run(3.0)
    assert [len(sea.says(boat, "avoid")) for boat in BOATS] == [1, 1, 1]
    assert {sea.agent(boat).state.foreign.memory.serial for boat in BOATS} == {1.0}  # type: ignore[union-attr]


def through(sea: Sea, delay_s: float, loss: float) -> None:
    """Every radio is as bad as that."""
    for station in sea.stations.values():
        assert station.radio is not None
        station.radio.set(delay_s, loss)


def blind(sea: Sea, boat: str) -> None:
    """The boat receives nothing of other vessels."""
    sea.stations[boat].driver.spoil = lambda reading: replace(reading, sightings=())


def test_followers_of_a_leader_that_sees_nothing_act_alone(tmp_path: Path) -> None:
    sea = meeting(tmp_path, FERRY, boats=3, before=lambda sea: blind(sea, "b1"))
    least = watch_least(sea, BOATS)
    begins_to_act(sea, ["b2"], 30.0)
    assert sea.state("b2").foreign.alone  # type: ignore[union-attr]
    assert sea.says("b2", "avoid")[0].startswith("gives way to ferry")
    sea.run(60.0)
    assert sea.says("b1", "avoid") == []
    assert min(least["b2"], least["b3"]) > 9.0
    assert sea.least_m > 3.0


def test_a_follower_that_waits_for_an_order_in_vain_acts_alone_in_time(tmp_path: Path) -> None:
    far = replace(FERRY, name="far", track=Steady(start=(900.0, 900.0), course_deg=0.0))
    fast = replace(FERRY, track=Steady(start=(133.0, 190.0), course_deg=270.0))  # with b2 at the crossing

    def leader_misses_the_ferry(sea: Sea) -> None:
        sea.stations["b1"].driver.spoil = lambda r: replace(
            r, sightings=tuple(one for one in r.sightings if one.name == "far")
        )

    sea = meeting(tmp_path, fast, far, boats=2, before=leader_misses_the_ferry)
    least = watch_least(sea, ["b2"])
    begins_to_act(sea, ["b2"], 40.0)
    assert sea.says("b2", "avoid")[0].startswith("without an order keeps clear of ferry")
    assert not acting(sea, "b1")
    sea.run(25.0)
    assert least["b2"] > 2.0


def test_when_the_leader_dies_the_next_one_leads_and_all_come_back(tmp_path: Path) -> None:
    sea = meeting(tmp_path, FERRY, boats=3)
    least = watch_least(sea, ["b2", "b3"])
    begins_to_act(sea, BOATS)
    sea.kill("b1")
    sea.run(3.0)
    assert acting(sea, "b2")
    assert acting(sea, "b3")
    assert not sea.state("b2").foreign.alone  # type: ignore[union-attr]
    sea.run_until(lambda: not acting(sea, "b2") and not acting(sea, "b3"), 90.0)
    assert min(least.values()) > 5.0
    assert sea.least_m > 3.0  # b1 drifts on


def test_an_impossible_order_is_refused_at_the_door(tmp_path: Path) -> None:
    sea = meeting(tmp_path, FERRY, boats=2)
    begins_to_act(sea, ["b1"])
    state = sea.state("b1")
    assert state.foreign is not None
    assert decode_state(forged(state), "b1").foreign == state.foreign
    for wrong in (
        {"factor": math.nan},
        {"course_rad": math.inf},
        {"sense": 0.5},
        {"apply_ns": -1},
        {"vessel": "x" * 500},
    ):
        with pytest.raises(Refused):
            decode_state(forged(state, foreign=replace(state.foreign, **wrong)), "b1")


# -- fleet and foreign at once -----------------------------------------------------------------------------------------
def test_a_fleet_mate_in_the_way_of_the_manoeuvre_is_not_touched_and_the_ship_is_kept_clear_of(tmp_path: Path) -> None:
    lanes = mission(
        2, method="scoring", fence=None, starts=(Start(s_m=100.0, speed_mps=1.0), Start(s_m=100.0, speed_mps=1.0))
    )
    beside = Straight(start=(0.0, 9.0), end=(1000.0, 9.0))  # to starboard, where b1 has to turn
    two = replace(
        lanes,
        paths={**lanes.paths, "beside": beside},
        boats=(lanes.boats[0], replace(lanes.boats[1], path="beside", slot=0.0)),
    )
    sea = meeting(tmp_path, FERRY, what=two, before=lambda sea: blind(sea, "b2"))  # b2 sees nothing, and sails on
    least = watch_least(sea, ["b1"])
    begins_to_act(sea, ["b1"])
    sea.run(60.0)
    assert least["b1"] > 5.0
    assert sea.least_m > 2.4


def test_while_it_acts_for_a_ship_a_boat_bends_its_course_for_a_mate_that_drifts_on_it(tmp_path: Path) -> None:
    base = mission(2, method="scoring", fence=None)
    side = Straight(start=(99.3, 24.0), end=(99.3, 600.0))  # b2 is killed there, where b1 has to go
    two = replace(
        base,
        paths={**base.paths, "side": side},
        boats=(
            replace(base.boats[0], start=Start(s_m=100.0, speed_mps=1.0)),
            replace(base.boats[1], path="side", slot=0.0, start=Start(s_m=0.0)),
        ),
    )
    fast = replace(FERRY, speed_mps=6.0, track=Steady(start=(140.0, 250.0), course_deg=265.0))
    sea = meeting(tmp_path, fast, what=two)
    sea.kill("b2")
    least = watch_least(sea, ["b1"])
    sea.run(45.0)
    said = sea.says("b1", "avoid")
    assert said[0].startswith("gives way to ferry")
    assert said.index("keeping clear of b2") < said.index("past and clear of other vessels, back to the path")
    assert sea.least_m > 6.0
    assert least["b1"] > 11.0


def test_a_ship_inside_a_crossing_of_our_own_boats_goes_before_it(tmp_path: Path) -> None:
    base = mission(2, method="scoring", fence=None)
    across = Straight(start=(145.0, -500.0), end=(145.0, 500.0))  # eastward, over the path of b1
    two = replace(
        base,
        paths={**base.paths, "across": across},
        boats=(
            replace(base.boats[0], start=Start(s_m=100.0, speed_mps=1.0)),
            replace(base.boats[1], path="across", slot=0.0, start=Start(s_m=455.0, speed_mps=1.0)),
        ),
    )
    ferry = replace(FERRY, track=Steady(start=(270.0, 125.0), course_deg=225.0))  # both, and the ship, at [145, 0]
    sea = meeting(tmp_path, ferry, what=two)
    least = watch_least(sea, ["b1", "b2"])
    sea.run(100.0)
    assert min(least.values()) > 5.0
    assert sea.least_m > 6.0  # even while both keep clear of the ship
    assert [sea.mode(boat) for boat in ("b1", "b2")] == [Mode.FOLLOW, Mode.FOLLOW]


# -- the picture -------------------------------------------------------------------------------------------------------
def sighting(x: float, y: float, at_s: float, name: str = "", **more: float) -> Sighting:
    return Sighting(round(at_s * 1e9), "ais" if name else "positions", name, x / 1e5, y / 1e5, 1.0, **more)


def local(lat: float, lon: float) -> tuple[float, float]:
    return lat * 1e5, lon * 1e5


def heard(traffic: Traffic, *reports: Sighting, mates: tuple[Mate, ...] = ()) -> None:
    for one in reports:
        traffic.hear([one], local, mates, one.stamp_ns)


def test_bare_positions_of_two_vessels_become_two_tracks() -> None:
    traffic = Traffic(lambda: (), 0)
    for k in range(20):
        heard(traffic, sighting(2.0 * k, 0.0, k), sighting(2.0 * k, 100.0, k + 0.4))
    found = traffic.targets(20_000_000_000)
    assert len(found) == 2
    assert [round(target.vx, 1) for target in found] == [2.0, 2.0]
    assert [traffic.name_of(target.number) for target in found] == ["vessel-1", "vessel-2"]


def test_a_false_echo_is_no_vessel_and_soon_forgotten() -> None:
    traffic = Traffic(lambda: (), 0)
    heard(traffic, sighting(0.0, 0.0, 1.0), sighting(0.5, 0.0, 2.0))
    assert traffic.targets(3_000_000_000) == ()
    assert len(traffic.vessels) == 1
    assert traffic.targets(13_000_000_000) == ()
    assert not traffic


def test_a_name_keeps_its_track_and_a_bare_position_on_it_belongs_to_it() -> None:
    traffic = Traffic(lambda: (), 0)
    for k in range(5):
        heard(traffic, sighting(4.0 * k, 0.0, k, "mv", v_north_mps=4.0, v_east_mps=0.0, length_m=80.0))
        heard(traffic, sighting(4.0 * k + 2.0, 0.0, k + 0.5))
    (target,) = traffic.targets(5_000_000_000)
    assert (traffic.name_of(target.number), target.length) == ("mv", 80.0)
    assert traffic.number_of("mv") == target.number


def test_boats_of_the_fleet_are_not_taken_for_vessels() -> None:
    traffic = Traffic(lambda: ("b2",), 0)
    heard(traffic, sighting(50.0, 0.0, 1.0, "b2", v_north_mps=1.0, v_east_mps=0.0))
    heard(traffic, sighting(50.0, 0.0, 2.0), mates=(Mate(51.0, 1.0, 0.0),))
    assert not traffic
    heard(traffic, sighting(80.0, 0.0, 3.0), mates=(Mate(51.0, 1.0, 0.0),))
    assert len(traffic.vessels) == 1


@pytest.mark.parametrize(
    "wrong",
    [
        {"lat_deg": math.nan},
        {"lat_deg": 91.0},
        {"position_error_m": -1.0},
        {"v_north_mps": 500.0, "v_east_mps": 0.0},
        {"length_m": 5000.0},
        {"stamp_ns": 0},
        {"lat_deg": 80.0},
    ],
)
def test_a_report_that_cannot_be_true_is_passed_over_and_counted(wrong: dict[str, float]) -> None:
    traffic = Traffic(lambda: (), 0)
    traffic.hear([replace(sighting(10.0, 0.0, 30.0, "mv"), **wrong)], local, (), 30_000_000_000)
    assert not traffic
    assert traffic.refused == 1


def test_a_vessel_is_forgotten_two_minutes_after_its_last_report() -> None:
    traffic = Traffic(lambda: (), 0)
    heard(traffic, sighting(0.0, 0.0, 1.0, "mv", v_north_mps=1.0, v_east_mps=0.0))
    assert len(traffic.targets(120_000_000_000)) == 1
    assert traffic.targets(122_000_000_000) == ()


def test_a_flood_of_vessels_is_bounded() -> None:
    traffic = Traffic(lambda: (), 0)
    heard(traffic, *(sighting(100.0 * k, 0.0, k / 100.0, f"v{k}") for k in range(200)))
    assert len(traffic.vessels) == 64
