"""Patterns and wingmen sailed by real agents in lock-step: what the operator says, and what the boats then do."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
from msgspec import Struct, structs

from fleet.agent.agent import Agent
from fleet.agent.modes import Mode, Reason
from fleet.analysis.replay import replay
from fleet.mission.load import load
from fleet.mission.model import Boat, Event, Lost, Mission, Start
from fleet.mission.multiply import multiply
from fleet.mission.plan import build
from fleet.operator import Fleet
from fleet.sim.lockstep import Lockstep, operator, sail_lockstep
from fleet.sim.share import Options


class Voyage(Struct):
    """A fleet under way, and what was seen of it."""

    sim: Lockstep
    fleet: Fleet
    least_m: float = math.inf
    watch: list[Callable[[], None]] = []

    def agent(self, boat: str) -> Agent:
        agent = self.sim.stations[boat].agent
        assert agent is not None
        return agent

    def at(self, boat: str) -> tuple[float, float]:
        state = self.sim.world.ships[boat].state
        return state.x, state.y

    def sail(self, seconds: float) -> None:
        self.sim.sleep(seconds)

    def look(self) -> None:
        spots = [self.at(boat) for boat in self.sim.stations]
        self.least_m = min([self.least_m, *(math.dist(a, b) for a, b in combinations(spots, 2))])
        for each in self.watch:
            each()


@contextmanager
def under_way(mission: Mission) -> Iterator[Voyage]:
    """The fleet when it begins to sail."""
    sim = Lockstep(build(mission))
    with operator(sim) as fleet:
        assert not fleet.wait_for([boat.name for boat in mission.boats])
        assert fleet.launch(mission).ok
        sim.sleep(sim.nature.lead_s)
        voyage = Voyage(sim, fleet)
        sim.each_tick.append(voyage.look)
        yield voyage
    sim.close()


def three(name: str, starts_m: Sequence[float], **formation: object) -> Mission:
    """The first three boats of a ready mission, already at speed."""
    mission = multiply(load(name), 3)
    cruise = mission.formation.cruise_mps
    boats = [
        structs.replace(b, start=Start(s_m=s, speed_mps=cruise)) for b, s in zip(mission.boats, starts_m, strict=True)
    ]
    wide = {"spacing_m": 12.0, "lateral_m": 12.0} if name == "patterns" else {}
    changed = structs.replace(mission.formation, **{**wide, **formation})
    return structs.replace(mission, boats=tuple(boats), formation=changed, timeline=(), checks={})


def wingman(**changes: object) -> Mission:
    mission = load("wingman")
    return structs.replace(mission, boats=at_speed(mission), checks={}, **changes)


def at_speed(mission: Mission) -> tuple[Boat, ...]:
    return tuple(structs.replace(b, start=structs.replace(b.start, speed_mps=1.0)) for b in mission.boats)


def abeam(voyage: Voyage) -> tuple[float, float]:
    """The wingman ahead of its leader, and to starboard of it, as the hulls really lie [m]."""
    (x1, y1), (x2, y2) = voyage.at("b1"), voyage.at("b2")
    return x2 - x1, y2 - y1


# -- patterns ----------------------------------------------------------------------------------------------------------
def test_a_swath_stays_abreast_through_a_turn() -> None:
    with under_way(three("swath", [85.0] * 3)) as voyage:
        worst: list[float] = []
        voyage.watch.append(lambda: worst.append(max(abs(voyage.agent(b).decision.e) for b in ("b1", "b2", "b3"))))
        voyage.sail(150.0)
        assert voyage.agent("b1").state.s > 175.0  # round the corner
        assert max(worst) < 0.6
        assert voyage.least_m > 9.5
        assert all(voyage.agent(b).decision.mode == Mode.FOLLOW for b in ("b1", "b2", "b3"))


def test_a_column_becomes_a_wedge_under_way_and_nobody_has_to_keep_clear() -> None:
    with under_way(three("patterns", [62.0, 50.0, 38.0])) as voyage:
        voyage.sail(5.0)
        outcome = voyage.fleet.set_pattern("wedge")
        assert outcome.ok
        assert (outcome.old, outcome.new, outcome.note) == ("column", "wedge", "slots b1=0, b2=1, b3=-1")
        avoided: set[str] = set()
        voyage.watch.append(
            lambda: avoided.update(b for b in ["b1", "b2", "b3"] if voyage.agent(b).decision.mode == 2.0)
        )
        voyage.sail(70.0)
        (x, y), (x2, y2), (x3, y3) = (voyage.at(b) for b in ("b1", "b2", "b3"))
        assert (x2 - x, y2 - y) == (approx(-12.0, 0.3), approx(12.0, 0.3))
        assert (x3 - x, y3 - y) == (approx(-12.0, 0.3), approx(-12.0, 0.3))
        assert voyage.least_m > 8.0
        assert not avoided


def approx(value: float, within: float) -> Any:
    return pytest.approx(value, abs=within)


def test_boats_abreast_exchange_their_slots_across_a_third() -> None:
    with under_way(three("patterns", [60.0] * 3, pattern="abreast")) as voyage:
        assert voyage.fleet.set_slots({"b2": 1.0, "b3": -1.0}).ok
        assert [round(voyage.at(b)[1]) for b in ("b1", "b2", "b3")] == [0, -12, -24]
        voyage.sail(128.0)
        assert [round(voyage.at(b)[1]) for b in ("b1", "b2", "b3")] == [0, 12, -12]
        assert voyage.least_m > 7.0


def test_what_cannot_be_reached_is_refused_by_every_boat_and_nothing_moves() -> None:
    with under_way(three("patterns", [62.0, 50.0, 38.0])) as voyage:
        outcome = voyage.fleet.set_lateral(5.0)
        assert outcome.ok  # in column nothing lies abeam
        outcome = voyage.fleet.set_pattern("abreast")
        assert outcome.exit_code == 5
        assert set(outcome.refused.values()) == {
            "lateral 5 m: b1 and b3 are 5.0 m apart on path line (and 1 more); at least 8.0 m"
        }
        voyage.sail(3.0)
        assert {voyage.agent(b).orders.sailing.shape.pattern for b in ("b1", "b2", "b3")} == {"column"}  # type: ignore[union-attr]


def test_a_new_leader_and_the_old_one_exchange_their_slots_on_every_boat() -> None:
    with under_way(three("patterns", [62.0, 50.0, 38.0])) as voyage:
        outcome = voyage.fleet.set_leader("b2")
        assert (outcome.ok, outcome.old, outcome.new) == (True, "b1", "b2")
        voyage.sail(2.5)
        assert slots(voyage, "b1", "b2", "b3") == {(-1.0, 0.0, -2.0)}


def test_boats_that_exchanged_their_slots_in_column_pass_each_other_and_close_up() -> None:
    with under_way(three("patterns", [62.0, 50.0, 38.0])) as voyage:
        assert voyage.fleet.set_slots({"b1": -2.0, "b3": 0.0}).ok
        voyage.sail(110.0)
        ahead = [voyage.at(b)[0] - voyage.at("b2")[0] for b in ("b1", "b3")]
        assert ahead == [approx(-12.0, 0.5), approx(12.0, 0.5)]
        assert voyage.least_m > 6.0


def test_a_boat_that_lies_stopped_on_the_path_is_passed_by_those_behind_it() -> None:
    with under_way(three("patterns", [62.0, 50.0, 38.0])) as voyage:
        voyage.fleet.stop_now(["b1"])
        voyage.sail(60.0)
        x = voyage.at("b1")[0]
        assert voyage.at("b2")[0] > x + 10.0
        assert voyage.at("b3")[0] > x
        assert voyage.least_m > 6.0


def test_a_boat_whose_slot_lies_inside_anothers_circle_holds_beside_it_and_nobody_circles() -> None:
    with under_way(three("patterns", [388.0, 376.0, 364.0])) as voyage:
        voyage.sail(10.0)
        end = voyage.agent("b1").course.path.length - 12.0  # where the slot of b2 is at the end
        while voyage.agent("b1").state.s < end - 3.0:
            voyage.sail(0.5)
        voyage.fleet.hold(["b1"])
        voyage.sail(35.0)
        turned = dict.fromkeys(("b1", "b2", "b3"), 0.0)
        voyage.watch.append(lambda: turned.update({b: turned[b] + 0.1 * voyage.agent(b).nav.r for b in turned}))
        voyage.sail(25.0)
        assert {voyage.agent(b).decision.mode for b in turned} == {Mode.HOLD}
        assert max(map(abs, turned.values())) < 6.0  # less than once round
        assert voyage.least_m > 6.0
        assert abs(voyage.at("b2")[0] - voyage.at("b1")[0]) < 12.0


def test_a_boat_that_was_away_comes_back_into_its_own_lane() -> None:
    mission = three("patterns", [62.0, 50.0, 38.0], pattern="echelon")
    with under_way(mission) as voyage:
        voyage.sail(10.0)
        voyage.sim.do("kill", "b3")
        voyage.sail(5.0)
        voyage.sim.do("start", "b3")
        voyage.sail(40.0)
        agent = voyage.agent("b3")
        assert agent.decision.mode == Mode.FOLLOW
        assert voyage.at("b3")[1] == approx(24.0, 0.5)
        assert abs(agent.decision.e) < 1.0


def test_the_boats_close_up_when_one_is_gone_and_it_comes_back_at_the_end() -> None:
    mission = three("patterns", [62.0, 50.0, 38.0], vacancies="close-up")
    with under_way(mission) as voyage:
        voyage.sail(3.0)
        voyage.sim.do("kill", "b2")
        voyage.sail(9.0)
        assert slots(voyage, "b1", "b3") == {(0.0, -1.0, -2.0)}
        voyage.sail(5.0)
        assert slots(voyage, "b1", "b3") == {(0.0, -2.0, -1.0)}
        assert voyage.agent("b3").orders.sailing.formation.revision.operator == "b1"  # type: ignore[union-attr]
        voyage.sim.do("start", "b2")
        voyage.sail(40.0)
        assert slots(voyage, "b1", "b2", "b3") == {(0.0, -2.0, -1.0)}


def test_gaps_are_kept_unless_the_mission_says_otherwise() -> None:
    with under_way(three("patterns", [62.0, 50.0, 38.0])) as voyage:
        voyage.sim.do("kill", "b2")
        voyage.sail(16.0)
        assert slots(voyage, "b1", "b3") == {(0.0, -1.0, -2.0)}


def slots(voyage: Voyage, *boats: str) -> set[tuple[float, ...]]:
    return {voyage.agent(boat).orders.sailing.shape.slots for boat in boats}  # type: ignore[union-attr]


# -- wingmen -----------------------------------------------------------------------------------------------------------
def test_a_wingman_falls_back_where_the_paths_cross_and_is_abeam_again_within_a_minute() -> None:
    with under_way(wingman()) as voyage:
        seen: list[tuple[float, float]] = []
        speeds: list[float] = []
        voyage.watch.append(lambda: seen.append(abeam(voyage)))
        voyage.watch.append(lambda: speeds.append(voyage.agent("b2").decision.U))
        voyage.sail(135.0)
        crossing = next(i for i, (_, y) in enumerate(seen) if y < 0.0)
        assert seen[crossing][0] < -7.0  # astern of its leader
        assert voyage.least_m > 7.0
        assert all(abs(ahead) < 0.5 for ahead, _ in seen[crossing + 400 : crossing + 500])
        assert min(speeds[100:]) >= 0.5  # hulls drift before the launch, and gather way
        assert max(speeds) <= 2.5


def test_strictly_abeam_with_the_papers_circle_it_turns_to_starboard() -> None:
    mission = load("wingman-circle")
    mission = structs.replace(mission, boats=at_speed(mission), checks={})
    with under_way(mission) as voyage:
        tracks: list[tuple[float, float]] = []
        agent = voyage.agent("b2")
        voyage.watch.append(lambda: tracks.append((agent.decision.mode, agent.decision.y_e)))
        voyage.sail(70.0)
        assert any(mode == Mode.AVOID for mode, _ in tracks)
        assert max(y for _, y in tracks) > 0.8
        assert min(y for _, y in tracks) > -0.3
        assert voyage.least_m >= 2.9


def test_with_its_leader_to_starboard_it_turns_to_starboard_passes_astern_and_comes_up_again() -> None:
    mission = load("wingman-colregs")
    mission = structs.replace(mission, boats=at_speed(mission), checks={})
    with under_way(mission) as voyage:
        seen: list[tuple[float, float]] = []
        turned: list[float] = []
        voyage.watch.append(lambda: seen.append(abeam(voyage)))
        leader, agent = voyage.agent("b1"), voyage.agent("b2")
        voyage.watch.append(lambda: turned.append(agent.nav.psi - math.atan2(agent.decision.ty, agent.decision.tx)))
        led: list[tuple[float, float]] = []
        voyage.watch.append(lambda: led.append((leader.decision.y_e, leader.decision.U)))
        voyage.sail(115.0)
        crossing = next(i for i, (_, y) in enumerate(seen) if y > 0.0)
        assert seen[crossing][0] < -6.0  # astern of its leader
        assert max(turned) > 1.0  # by more than 57 degrees to starboard
        assert voyage.least_m > 6.0
        assert all(abs(ahead) < 0.5 for ahead, _ in seen[crossing + 550 :])
        assert max(abs(y) for y, _ in led) < 0.01  # its leader goes on
        assert min(u for _, u in led[100:]) > 0.99


def test_a_leader_keeps_clear_of_a_wingman_that_lies_in_its_way() -> None:
    mission = load("wingman-colregs")
    mission = structs.replace(mission, boats=at_speed(mission), checks={})
    with under_way(mission) as voyage:
        voyage.sail(58.0)
        voyage.fleet.hold(["b2"])
        voyage.sail(30.0)
        assert voyage.least_m > 5.0


def chain(**changes: object) -> Mission:
    """b3 sails beside b2, and b2 beside b1, on curves 25 m apart."""
    mission = wingman(**changes)
    mission = structs.replace(mission, duration_s=400.0)
    third = structs.replace(mission.boats[1], name="b3", path="other", slot=2.0)
    curve: Any = mission.paths["curve"]
    other = structs.replace(curve, start=(0.0, 25.0), end=(330.0, 25.0))
    return structs.replace(mission, boats=(*mission.boats, third), paths={**mission.paths, "other": other})


def ahead_of(voyage: Voyage, boat: str, leader: str) -> float:
    """How far a boat is ahead of its leader, along the leader's path [m]."""
    (x1, y1), (x2, y2), d = voyage.at(leader), voyage.at(boat), voyage.agent(leader).decision
    return d.tx * (x2 - x1) + d.ty * (y2 - y1)


def test_wingmen_of_wingmen_stay_abeam_link_by_link() -> None:
    with under_way(chain()) as voyage:
        ahead: list[float] = []
        voyage.sail(12.0)
        voyage.watch.append(lambda: ahead.append(ahead_of(voyage, "b3", "b2")))
        voyage.sail(80.0)  # past a crossing of b2 with its leader
        assert max(map(abs, ahead)) < 2.5  # beside its own leader, wherever that is
        assert voyage.least_m > 6.0


def test_when_the_first_of_a_chain_is_lost_the_others_go_on_and_then_hold_together() -> None:
    with under_way(chain(lost=Lost(alone_for_s=12.0))) as voyage:
        voyage.sail(20.0)
        voyage.sim.do("kill", "b1")
        voyage.sail(8.0)
        second, third = voyage.agent("b2"), voyage.agent("b3")
        assert second.reasons & Reason.LEADER_LOST
        assert not third.reasons & Reason.LEADER_LOST  # it hears b2
        assert second.decision.U > 0.8
        assert abs(ahead_of(voyage, "b3", "b2")) < 1.0
        voyage.sail(20.0)
        assert second.decision.mode == Mode.HOLD
        assert third.decision.mode == Mode.HOLD  # its leader has stopped
        assert abs(ahead_of(voyage, "b3", "b2")) < 2.5


def test_without_its_leader_a_wingman_holds_its_last_good_speed_then_its_station() -> None:
    with under_way(wingman(lost=Lost(alone_for_s=12.0))) as voyage:
        voyage.sail(20.0)
        agent = voyage.agent("b2")
        before = agent.decision.u_plan
        voyage.sim.do("kill", "b1")
        voyage.sail(2.0)
        plans: set[float] = set()
        voyage.watch.append(lambda: plans.add(agent.decision.u_plan))
        voyage.sail(9.0)
        assert len(plans) == 1
        assert plans.pop() == approx(before, 0.05)
        assert agent.reasons & Reason.LEADER_LOST
        voyage.sail(6.0)
        assert agent.decision.mode == Mode.HOLD


def test_when_its_leader_stops_a_wingman_stops_beside_it_and_does_not_circle() -> None:
    with under_way(wingman()) as voyage:
        voyage.sail(20.0)
        voyage.fleet.hold(["b1"])
        voyage.sail(12.0)
        agent = voyage.agent("b2")
        headings: list[float] = []
        voyage.watch.append(lambda: headings.append(agent.nav.psi))
        voyage.sail(20.0)
        ahead, _ = abeam(voyage)
        assert abs(ahead) < 2.0
        assert agent.decision.mode == Mode.HOLD
        assert agent.reasons & Reason.LEADER_STOPPED
        assert max(headings) - min(headings) < 0.3
        assert agent.decision.U < 0.1
        voyage.fleet.resume(["b1"])
        voyage.sail(30.0)
        assert agent.decision.mode in (Mode.FOLLOW, Mode.AVOID)
        assert voyage.least_m > 6.0


@pytest.mark.parametrize("delay_s", [0.0, 0.5, 2.0])
def test_a_wingman_stops_with_its_leader_at_the_end_however_late_its_words_are(delay_s: float) -> None:
    """Its leader's words are 2 s old, and it is 2 m farther by then: but never beyond the end of its path."""
    mission = wingman()
    paths = {**mission.paths, "line": structs.replace(mission.paths["line"], end=(85.0, 0.0))}
    late = structs.replace(mission, paths=paths, radio=structs.replace(mission.radio, delay_s=delay_s))
    with under_way(late) as voyage:
        voyage.sail(35.0)
        assert voyage.agent("b1").decision.mode == Mode.FOLLOW
        assert abs(abeam(voyage)[0]) < 0.7
        voyage.sail(20.0)
        for boat in ("b1", "b2"):
            assert voyage.agent(boat).decision.mode == Mode.HOLD
            assert abs(voyage.agent(boat).decision.e) < 0.5
        assert abs(abeam(voyage)[0]) < 1.0


def test_three_boats_cross_near_one_point_and_are_back_on_their_paths_within_65_s() -> None:
    with under_way(load("three-crossing")) as voyage:
        voyage.sail(65.0)
        for boat in ("b1", "b2", "b3"):
            agent = voyage.agent(boat)
            assert abs(agent.decision.y_e) < 0.5
            assert agent.state.s > 75.0  # past the point
        assert voyage.least_m > 6.0


# -- replay ------------------------------------------------------------------------------------------------------------
def test_a_run_with_lanes_and_one_with_a_leader_replay_to_the_bit(tmp_path: Path) -> None:
    wedge = (Event(at_s=4.0, do="set pattern", value="wedge"), Event(at_s=9.0, do="set lateral", value=15.0))
    for name, mission in (
        ("patterns", structs.replace(three("patterns", [62.0, 50.0, 38.0]), timeline=wedge, duration_s=20.0)),
        ("wingman", wingman(duration_s=10.0)),
    ):
        run = sail_lockstep(mission, name, Options(root=str(tmp_path)))
        found = replay(run.folder)
        assert found.same, found.lines()
