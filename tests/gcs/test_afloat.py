"""A ground station, a bridge, and real agents in lock-step: what becomes of a button in the water."""

from __future__ import annotations

import math
from collections.abc import Callable

from msgspec import structs

from fleet.agent.modes import Mode
from fleet.drivers.mavlink.words import ARDUPILOT
from fleet.gcs.bridge import Bridge
from fleet.gcs.captain import fulfil
from fleet.gcs.sysids import Sysids
from fleet.mission.load import load
from fleet.mission.plan import build
from fleet.operator import Fleet
from fleet.sim.lockstep import BEGIN_NS, Lockstep
from tests.gcs.deck import MAVLINK, Deck, GroundStation
from tests.gcs.test_missions import Item

HOLD, LOITER, AUTO, RTL, GUIDED = 4, 5, 10, 11, 15
OUT = load("survey-column", ("timeline=[]", "fence.points=[[-80,-80],[300,-80],[300,300],[-80,300]]"))


class Afloat(Deck):
    """Five boats, and a station; a tick is a tenth of a second of the simulation."""

    def __init__(self) -> None:
        self.sim = Lockstep(build(OUT))
        self.fleet = Fleet("sim", operator="gcs", bus=self.sim.shore, clock=self.sim, timeout_s=2.0)
        self.bridge = Bridge(MAVLINK, Sysids({}), operator="gcs", autopilot=ARDUPILOT)
        self.stations: list[GroundStation] = []
        self.wishes = []
        self._stamps: dict[str, int] = {}
        self.sim.each_tick.append(self._tick)
        self.fleet.__enter__()
        self.station = self.join()
        self.run(5.0)

    @property
    def now_s(self) -> float:  # type: ignore[override]
        """Of the simulation."""
        return (self.sim.now_ns - BEGIN_NS) * 1e-9

    def _tick(self) -> None:
        views = self.fleet.look()
        for view in views.values():
            if view.state is not None and view.state.stamp_ns != self._stamps.get(view.name):
                self._stamps[view.name] = view.state.stamp_ns
            age_s = (self.sim.now_ns - self._stamps.get(view.name, 0)) * 1e-9
            view.heard_s = self.now_s - age_s
        events, self.fleet.events = self.fleet.events, []
        self.bridge.look(views, events, self.now_s)
        self.bridge.step(self.now_s)
        self.flush()

    def run(self, seconds: float = 0.1) -> None:
        """Time passes, and what is wished is done."""
        until = self.now_s + seconds - 1e-6
        while self.now_s < until:
            self.sim.tick()
            wishes, self.wishes = self.wishes, []
            for wish in wishes:
                for done in fulfil(self.fleet, [wish]):
                    self.bridge.done(done, self.now_s)
            self.flush()

    def until(self, condition: Callable[[], bool], at_most_s: float = 60.0) -> None:
        """Time passes until it holds."""
        began = self.now_s
        while not condition():
            assert self.now_s - began < at_most_s, (self.station.texts(), self.modes())
            self.run()

    def modes(self) -> list[int]:
        """What all do."""
        return [int(self.sim.stations[f"b{i}"].agent.decision.mode) for i in range(1, 6)]

    def place(self, boat: str) -> tuple[float, float]:
        """Where its hull is: metres from the mission's datum."""
        state = self.sim.world.ships[boat].state
        return state.x, state.y


def at(*points: tuple[float, float]) -> list[Item]:
    """Waypoints in metres from the datum."""
    plane = build(OUT).plane
    items = []
    for i, (x, y) in enumerate(((0.0, 0.0), *points)):
        lat, lon = plane.to_geographic(x, y)
        items.append(Item(i, 3, 16, 0, 1, (0.0,) * 4, round(lat * 1e7), round(lon * 1e7), 0.0))
    return items


def test_a_fleet_sails_what_a_ground_station_uploads_and_does_what_its_buttons_say() -> None:
    deck = Afloat()
    s = deck.station
    assert s.upload(1, at((-20.0, 0.0), (200.0, 0.0), (200.0, 60.0))) == -1
    deck.run(0.2)
    assert s.last("MISSION_ACK").type == 0

    s.command(1, 400, 1)
    s.mode(1, AUTO)
    deck.until(lambda: deck.modes() == [Mode.FOLLOW] * 5, 10.0)
    assert [a.result for a in s.all("COMMAND_ACK", 1)] == [0, 0]
    deck.run(15.0)
    assert all(abs(deck.place(f"b{i}")[1]) < 0.5 for i in range(1, 6)), "on the first leg"

    s.set(3, "FLT_SPACING", 12.0)
    s.set(3, "FLT_SPACING", 3.0)
    deck.run(25.0)
    assert s.last("PARAM_VALUE", 3).param_value == 12.0
    assert any("FLT_SPACING refused: spacing 3 m" in text for text in s.texts(3))
    assert abs(deck.place("b1")[0] - deck.place("b2")[0] - 12.0) < 0.5

    s.mode(5, LOITER)
    deck.until(lambda: deck.modes()[4] == Mode.HOLD)
    assert deck.modes()[:4] == [Mode.FOLLOW] * 4, "the others sail on"
    x, y = deck.place("b5")
    goal = at((x, y - 20.0))[1]
    s.say("command_int", 5, 1, 0, 192, 0, 0, -1.0, 1.0, 0.0, math.nan, goal.x, goal.y, 0.0)
    deck.until(lambda: deck.modes()[4] == Mode.FOLLOW)
    deck.run(1.0)
    assert s.last("HEARTBEAT", 5).custom_mode == GUIDED
    deck.until(lambda: deck.modes()[4] == Mode.HOLD, 120.0)
    assert math.dist(deck.place("b5"), (x, y - 20.0)) < 3.0

    s.command(2, 400, 0)
    deck.until(lambda: deck.modes()[1] == Mode.NEUTRAL)
    deck.run(1.5)
    assert not s.last("HEARTBEAT", 2).base_mode & 128
    s.mode(2, AUTO)
    deck.run(0.5)
    assert any("release first" in text for text in s.texts(2)), "a stopped boat is not resumed"
    s.command(2, 400, 1)
    deck.until(lambda: deck.modes()[1] == Mode.HOLD)
    s.mode(2, AUTO)
    deck.until(lambda: deck.modes()[1] in (Mode.FOLLOW, Mode.AVOID))
    s.mode(1, RTL)
    deck.until(lambda: deck.modes()[0] == Mode.RETURN)


def test_a_launch_by_others_is_seen_and_their_control_respected() -> None:
    deck = Afloat()
    anna = Fleet("sim", operator="anna", bus=deck.sim.shore, clock=deck.sim)
    assert anna.launch(structs.replace(OUT, title="Anna's")).ok
    deck.run(4.0)
    assert len(deck.station.download(1)) == 10
    assert deck.station.last("MISSION_ITEM_INT").get_srcSystem() == 1
    deck.station.mode(1, RTL)
    deck.run(0.5)
    assert deck.station.texts(1)[-1] == "RTL refused: anna holds control; `fleet take` takes it over"
    deck.station.set(1, "FLT_CONTROL", 1.0)
    deck.run(0.5)
    assert deck.station.last("PARAM_VALUE", 1).param_value == 1.0
    deck.station.mode(1, RTL)
    deck.until(lambda: deck.modes()[0] == Mode.RETURN, 5.0)


def test_what_cannot_be_sailed_is_refused_by_the_checks_of_mission_files() -> None:
    deck = Afloat()
    deck.station.set(1, "FLT_RADIUS", 20.0)
    assert deck.station.upload(1, at((0.0, 0.0), (200.0, 0.0), (200.0, 60.0))) == -1
    deck.run(0.2)
    assert deck.station.last("MISSION_ACK").type == 5
    assert "mission refused: formation.spacing_m = 15: " in deck.station.texts(1)[-1]
    deck.station.mode(1, AUTO)
    deck.run(0.2)
    assert deck.station.texts(1)[-1] == "AUTO refused: no mission; upload one"
