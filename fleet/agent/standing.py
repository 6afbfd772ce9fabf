"""What operators' words have left this boat with: its mission, its goal, its stops, who holds control."""

from __future__ import annotations

from collections.abc import Callable

from fleet.agent.flights import Flights
from fleet.agent.modes import Goal, Reason
from fleet.agent.sailing import Sailing
from fleet.guidance.limits import OwnLimits
from fleet.mission.plan import Plan
from fleet.wire.codec import LARGEST_JUMP
from fleet.wire.messages import Revision, Signed

FOR_ALL = "all-"  # so begins the id of a stop that an operator says to the whole fleet
MOST_STOPS = 32
MOST_NOTES = 64


class Standing:
    """What stands, whoever said it; neighbours' knowledge of it is taken in here."""

    def __init__(self, boat: str, *, simulated: bool, version: str) -> None:
        self.boat, self.simulated, self.version = boat, simulated, version
        self.hull, self.limits = "", OwnLimits()  # the boat's own, as its configuration says
        self.sailing: Sailing | None = None
        self.goal = Goal.STANDBY
        self.why = Reason(0)
        self.control = Revision()
        self.stops: dict[str, None] = {}
        self.released: dict[str, None] = {}  # not taken again from a neighbour that missed the release
        self.ended: Plan | None = None  # of a mission that was aborted: its battery levels still hold
        self.known_missions: dict[str, None] = {}  # held before: never taken again from a neighbour
        self.stop_words: dict[str, Signed] = {}  # of stops of the whole fleet, to be handed on
        self.said: dict[str, int] = {}  # by signer: stamp of the last word that was obeyed
        self.sign: Callable[[str, bytes], Signed] = lambda purpose, body: Signed(body)
        self.revision_of_goal = 0  # one more whenever the goal was set anew
        self.notes: list[tuple[str, str, float]] = []  # (kind, text, value) to be published as events
        self.changed = True  # something that must survive a restart
        self.forget: Callable[[tuple[str, ...]], list[str]] = lambda names: []
        self.resume_at: Callable[[str], str] = lambda text: ""
        self.obeyed: Callable[[str], None] = lambda kind: None  # told the kind of every command that was accepted
        self.apart = False  # whether heavy missions are checked by a process of their own
        self.abscissas: Callable[[], dict[str, float]] = dict
        self.position_error_m: Callable[[], float] = float
        self.flights = Flights()

    def begin(self, sailing: Sailing, goal: Goal) -> None:
        """Take a mission as one's own."""
        self.sailing = sailing
        self.known_missions[sailing.order.mission_id] = None
        self._set_goal(goal, Reason(0))
        self.note("mission", f"{sailing.plan.mission.title} ({sailing.order.mission_id})")

    def _set_goal(self, goal: Goal, why: Reason) -> None:
        self.goal, self.why = goal, why
        self.revision_of_goal += 1
        self.changed = True

    def turn_back(self, goal: Goal, text: str) -> None:
        """A trouble ends the following: back along the own track, or hold; an operator resumes."""
        self._set_goal(goal, Reason.RETURNING if goal == Goal.RETURN else Reason.HELD)
        self.note("trouble", f"{text}: {goal.name.lower()}")

    def told(self, goal: Goal, why: Reason) -> None:
        """What an operator said before the mission on disk was taken up holds for it too."""
        self._set_goal(goal, why)

    def stand_by(self, why: Reason) -> None:
        """Hold a mission without sailing it."""
        self._set_goal(Goal.STANDBY, why)

    def hear_stops(self, stops: tuple[str, ...]) -> None:
        """A stop of the whole fleet reaches who was out of reach from its neighbours, unless it was released."""
        for stop in stops:
            if stop.startswith(FOR_ALL) and stop not in self.stops and stop not in self.released:
                if len(self.stops) >= MOST_STOPS:
                    return
                self.stops[stop] = None
                self.changed = True
                self.note("stop", f"a neighbour knows of {stop}")

    def unheard_stops(self, stops: tuple[str, ...]) -> bool:
        """Whether a neighbour knows of a stop of the whole fleet that this boat has not heard of."""
        return any(stop.startswith(FOR_ALL) and stop not in self.stops and stop not in self.released for stop in stops)

    def keep_stop_words(self, stop: str, words: Signed) -> None:
        """An operator's words, to be handed on as long as the stop holds."""
        self.stop_words = {one: said for one, said in self.stop_words.items() if one in self.stops}
        if stop in self.stops and stop.startswith(FOR_ALL):
            self.stop_words[stop] = words
        self.changed = True

    def newest_mission_ns(self) -> int:
        """When the newest mission that this boat ever held was launched; 0 for none."""
        stamps = (mission.partition("-")[0] for mission in self.known_missions)
        return max((int(stamp) for stamp in stamps if stamp.isdecimal() and len(stamp) < 20), default=0)

    def hear_control(self, control: Revision) -> None:
        """A neighbour's word on who holds control: the larger revision wins."""
        if self.control < control and control.counter <= self.control.counter + LARGEST_JUMP:
            self.control = control
            self.changed = True

    def note(self, kind: str, text: str, value: float = 0.0) -> None:
        """Something to be published as an event."""
        if len(self.notes) < MOST_NOTES:
            self.notes.append((kind, text, value))
