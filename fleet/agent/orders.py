"""What the boat is told: missions, formations with their revisions, control, stops. No clock, no wire of its own.

A formation revision is (counter, operator) within one mission id; the larger one wins wherever two meet. Operators'
words are kept as they were written, so that any boat that holds them can hand them on unaltered.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from hashlib import blake2b

from msgspec import Struct, structs

from fleet.agent import door
from fleet.agent.examine import apart
from fleet.agent.modes import Goal, Reason
from fleet.errors import FleetError
from fleet.guidance.limits import OwnLimits, asked_too_much
from fleet.mission.check import check
from fleet.mission.formation import check_formation, gap_needed
from fleet.mission.model import Boat
from fleet.mission.pattern import PATTERNS, Place, Shape
from fleet.mission.plan import Plan, build
from fleet.mission.redraw import Redrawing, redrawing
from fleet.wire.codec import LARGEST_JUMP, Refused, decode_formation, decode_mission_order, encode
from fleet.wire.formation import shape_in
from fleet.wire.messages import MAJOR, Ack, Command, FormationOrder, MissionOrder, Revision, Signed

FREE_KINDS = ("hold", "abort", "stop-now", "take")
"""What any permitted operator may say, in control or not."""
REMEMBERED = 256  # of those obeyed, and of those refused: a flood of refusals makes no old command new
FOR_ALL = "all-"  # so begins the id of a stop that an operator says to the whole fleet
MOST_STOPS = 32
STAND_IN = "unicycle"  # the hull of a mission that does not say which: it stands for any
AHEAD = 8  # pieces of work done ahead and kept until taken; a few are for commands that are refused after all
LONGEST_REASON = 400
REFUSALS_TOLD_S = 0.2  # between two events about refusals; all of them are counted
LONG_WORK = {name: pattern.lateral or name == "wingman" for name, pattern in PATTERNS.items()}
"""Patterns that take long to check: lanes are held against the fence, wingmen against their leaders."""
MANY_PATHS = 10  # from here on it takes longer than a tick may to hold all places against each other

log = logging.getLogger("fleet.agent")


class Sailing(Struct):
    """A mission that this boat holds."""

    order: MissionOrder
    words: Signed
    plan: Plan
    number: int  # of this boat in the roster
    starts_ns: int  # when it begins to follow
    formation: FormationOrder  # in force
    shape: Shape  # what it asks for
    drawn: tuple[Place, ...]  # where everybody's place is in it, ahead of slot 0 and to starboard of the path [m]
    redrawing: Redrawing | None = None  # how the fleet comes from the formation before to this one
    formation_words: Signed | None = None  # None: revision 0, which the mission's words carry
    pending: FormationOrder | None = None
    pending_words: Signed | None = None
    pending_ns: int = 0
    switched_ns: int = 0

    def ahead(self, number: int, now_ns: int) -> float:
        """o_i: where a boat's place is now, ahead of slot 0 [m]."""
        if self.redrawing is None:
            return self.drawn[number][0]
        return self.redrawing.ahead(number, (now_ns - self.switched_ns) * 1e-9)

    def places(self, now_ns: int) -> tuple[Place, ...]:
        """Where everybody's place is now, ahead of slot 0 and to starboard of the path [m]."""
        if self.redrawing is None:
            return self.drawn
        return self.redrawing.places((now_ns - self.switched_ns) * 1e-9)

    @property
    def held(self) -> Revision:
        """Newest formation that this boat holds."""
        return self.pending.revision if self.pending is not None else self.formation.revision


class Ruling(Struct, frozen=True):
    """What came of a command."""

    ok: bool
    reason: str = ""
    old: str = ""
    new: str = ""
    safety: bool = False


class Orders:
    """Everything that operators have told this boat."""

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
        self.revision_of_goal = 0  # one more whenever the goal was set anew
        self.notes: list[tuple[str, str, float]] = []  # (kind, text, value) to be published as events
        self.changed = True  # something that must survive a restart
        self.forget: Callable[[tuple[str, ...]], list[str]] = lambda names: []
        self.resume_at: Callable[[str], str] = lambda text: ""
        self.obeyed: Callable[[str], None] = lambda kind: None  # told the kind of every command that was accepted
        self.apart = False  # whether heavy missions are checked by a process of their own
        self.abscissas: Callable[[], dict[str, float]] = dict
        self.position_error_m: Callable[[], float] = float
        self._obeyed: dict[str, tuple[bytes, Ack]] = {}
        self._refused: dict[str, tuple[bytes, Ack]] = {}
        self._told_ns = 0
        self._read: list[tuple[Signed, str, Sailing | None]] = []  # missions read in the background, not yet taken
        self._checked: list[tuple[Signed, Plan, list[str]]] = []  # so, formations held against each other
        self._rulings: Mapping[str, Callable[[Command, int], Ruling]] = {
            "launch": self._launch,
            "set": self._set,
            "hold": self._hold,
            "resume": self._resume,
            "abort": self._abort,
            "return": self._return,
            "stop-now": self._stop,
            "release": self._release,
            "take": self._take,
            "forget": self._forget,
        }

    # -- commands --------------------------------------------------------------------------------------------------
    def obey(self, command: Command, now_ns: int) -> Ack:
        """Do what an operator says, or refuse with the reason; the same id twice is done once."""
        digest = blake2b(encode(structs.replace(command, stamp_ns=0)), digest_size=16).digest()
        known = self._obeyed.get(command.id) or self._refused.get(command.id)
        if known is not None and known[0] == digest:
            return known[1]
        ruling = Ruling(False, "another command had this id") if known is not None else self._rule(command, now_ns)
        reason = ruling.reason[:LONGEST_REASON]
        ack = Ack(MAJOR, command.id, self.boat, ruling.ok, reason, ruling.old, ruling.new, self.version, ruling.safety)
        addressed = not command.boats or self.boat in command.boats
        if not ruling.ok and addressed and now_ns - self._told_ns >= REFUSALS_TOLD_S * 1e9:
            self._told_ns = now_ns
            self.note("refused", f"{command.kind} of {command.operator}: {reason}")
        if known is None:
            answered = self._obeyed if ruling.ok else self._refused
            while len(answered) >= REMEMBERED:
                del answered[next(iter(answered))]
            answered[command.id] = digest, ack
        return ack

    def work(self, command: Command, now_ns: int) -> Callable[[], None] | None:
        """What takes too long for a tick and must be done before `obey`; None when nothing does."""
        words = command.order
        if words is None or command.id in self._obeyed or command.id in self._refused:
            return None
        if self._not_permitted(command) is not None:
            return None
        if command.kind == "launch" and not self.stops and self._launched_before(words, command.operator) is None:
            return lambda: self._read_ahead(words, now_ns)
        return self.formation_work(words, self.abscissas()) if command.kind == "set" else None

    def formation_work(self, words: Signed, abscissas: dict[str, float] | None) -> Callable[[], None] | None:
        """The part of judging a change that takes long in a large formation."""
        sailing = self.sailing
        if sailing is None:
            return None
        try:
            order = decode_formation(words)
            shape = shape_in(order, sailing.plan.mission)
        except Refused:
            return None
        if len(sailing.plan.paths) <= MANY_PATHS and not LONG_WORK[shape.pattern]:
            return None
        if order.mission_id != sailing.order.mission_id or not sailing.held < order.revision:
            return None
        plan, before = sailing.plan, sailing.shape

        def check_ahead() -> None:
            found = check_formation(plan, shape, abscissas, before=before)
            del self._checked[:-AHEAD]
            self._checked.append((words, plan, found))

        return check_ahead

    def _misfits(
        self, plan: Plan, order: FormationOrder, words: Signed, abscissas: dict[str, float] | None
    ) -> list[str]:
        """Why a formation cannot be sailed, as found in the background or now."""
        for checked in self._checked:
            if checked[0] is words:
                self._checked.remove(checked)
                if checked[1] is plan:
                    return checked[2]
                break
        before = self.sailing.shape if self.sailing is not None and self.sailing.plan is plan else None
        try:
            return check_formation(plan, shape_in(order, plan.mission), abscissas, before=before)
        except Refused as refusal:
            return [f"the order {refusal}"]

    def _rule(self, command: Command, now_ns: int) -> Ruling:
        refusal = self._not_permitted(command)
        if refusal is not None:
            return refusal
        ruling = self._rulings[command.kind](command, now_ns)
        if ruling.ok:
            self.obeyed(command.kind)
        if ruling.ok and command.kind not in FREE_KINDS and not self.control.operator:
            self.control = Revision(self.control.counter + 1, command.operator)
            self.changed = True
        return ruling

    def _not_permitted(self, command: Command) -> Ruling | None:
        """Why a command is not even looked into."""
        if command.boats and self.boat not in command.boats:
            return Ruling(False, "not addressed to this boat")
        if command.kind not in self._rulings:
            return Ruling(False, f"unknown command {command.kind!r}; this boat runs fleet {self.version}")
        if command.mission_id and (self.sailing is None or self.sailing.order.mission_id != command.mission_id):
            mine = self.sailing.order.mission_id if self.sailing else "none"
            return Ruling(False, f"it is for mission {command.mission_id}; this boat holds {mine}")
        if command.kind not in FREE_KINDS and self.control.operator not in ("", command.operator):
            return Ruling(False, f"{self.control.operator} holds control; `fleet take` takes it over")
        return None

    def _launch(self, command: Command, now_ns: int) -> Ruling:
        if command.order is None:
            return Ruling(False, "a launch without a mission")
        if self.stops:
            return Ruling(False, f"stopped by {_and(self.stops)}; release first", safety=True)
        old = self.sailing.order.mission_id if self.sailing else "none"
        before = self._launched_before(command.order, command.operator)
        if before is not None:
            return before
        problem, sailing = self._take_read(command.order, now_ns)
        if sailing is None:
            return Ruling(False, problem, safety=True)
        sailing.starts_ns = now_ns + int(sailing.order.apply_in_s * 1e9)
        self.begin(sailing, Goal.FOLLOW)
        return Ruling(True, "", old, sailing.order.mission_id)

    def _launched_before(self, words: Signed, operator: str) -> Ruling | None:
        """What a launch comes to whose mission need not, or must not, be read."""
        try:
            order = decode_mission_order(words)
        except Refused as refusal:
            return Ruling(False, f"the mission {refusal}", safety=True)
        if order.operator != operator:
            return Ruling(False, f"the mission was written by {order.operator}, not by {operator}")
        old = self.sailing.order.mission_id if self.sailing else "none"
        if order.mission_id not in self.known_missions:
            return None
        if order.mission_id != old:
            return Ruling(False, f"mission {order.mission_id} was launched before; launch it anew")
        return Ruling(True, "held already", old, order.mission_id)

    def _read_ahead(self, words: Signed, now_ns: int) -> None:
        problem, sailing = self.read_mission(words, now_ns)
        del self._read[:-AHEAD]
        self._read.append((words, problem, sailing))

    def _take_read(self, words: Signed, now_ns: int) -> tuple[str, Sailing | None]:
        """A mission as read in the background, or now."""
        for read in self._read:
            if read[0] is words:
                self._read.remove(read)
                return read[1], read[2]
        return self.read_mission(words, now_ns)

    def read_mission(self, words: Signed, now_ns: int) -> tuple[str, Sailing | None]:
        """The mission in an operator's words, or why this boat does not sail it."""
        try:
            order = decode_mission_order(words)
            mission = door.read(order.mission)
            numbers = {boat.name: number for number, boat in enumerate(mission.boats)}
            if self.boat not in numbers:  # before it is looked at any closer, which takes long
                return f"not in the roster {_and(numbers)}", None
            problems = apart(order.mission) if self.apart and door.heavy(mission) else check(mission).problems
            if problems:
                return "; ".join(problems[:3]), None
            plan = build(mission)
        except Refused as refusal:
            return f"the mission {refusal}", None
        except FleetError as error:
            return str(error), None
        except Exception as error:
            log.exception("a mission could not be read", extra={"event": "mission"})
            return f"the mission cannot be read: {type(error).__name__}", None
        if not self.simulated and mission.fence is None:
            return "no fence: a real boat sails only inside one", None
        beyond = self._beyond(mission.boats[numbers[self.boat]])
        if beyond:
            return beyond, None
        formation = FormationOrder(
            MAJOR,
            order.mission_id,
            Revision(0, ""),
            Revision(0, ""),
            mission.formation.spacing_m,
            mission.formation.cruise_mps,
        )
        number = numbers[self.boat]
        shape = plan.shape
        return "", Sailing(order, words, plan, number, now_ns, formation, shape, shape.places, switched_ns=now_ns)

    def _beyond(self, asked: Boat) -> str:
        """Why a mission asks more of this boat than it can do; '' when it does not."""
        if self.hull and asked.hull not in (self.hull, STAND_IN):
            return f"it takes this boat for the hull {asked.hull!r}; it is {self.hull!r}"
        too_much = asked_too_much(self.limits, asked.limits)
        return f"it asks more than this boat can: {'; '.join(too_much)}" if too_much else ""

    def begin(self, sailing: Sailing, goal: Goal) -> None:
        """Take a mission as one's own."""
        self.sailing = sailing
        self.known_missions[sailing.order.mission_id] = None
        self._set_goal(goal, Reason(0))
        self.note("mission", f"{sailing.plan.mission.title} ({sailing.order.mission_id})")

    def _set(self, command: Command, now_ns: int) -> Ruling:
        sailing = self.sailing
        if sailing is None:
            return Ruling(False, "no mission to change")
        if command.order is None:
            return Ruling(False, "a change without an order")
        try:
            order = decode_formation(command.order)
        except Refused as refusal:
            return Ruling(False, f"the order {refusal}")
        held = sailing.held
        if order.mission_id != sailing.order.mission_id:
            return Ruling(False, f"it is for mission {order.mission_id}; this boat holds {sailing.order.mission_id}")
        if order.based_on != held:
            return Ruling(False, f"based on revision {order.based_on}, but {held} is held")
        if order.revision.operator != command.operator or order.revision.counter <= held.counter:
            return Ruling(False, f"revision {order.revision} of {command.operator} does not follow {held}")
        if order.revision.counter > held.counter + LARGEST_JUMP:
            return Ruling(False, f"revision {order.revision} is more than {LARGEST_JUMP} ahead of {held}")
        problems = self._misfits(sailing.plan, order, command.order, self.abscissas())
        problems += [] if problems else self._too_close(sailing.plan, order)
        if problems:
            return Ruling(False, "; ".join(problems), safety=True)
        old = _formation_words(sailing.pending or sailing.formation, sailing.plan.shape)
        self.expect(order, command.order, now_ns + int(order.apply_in_s * 1e9))
        return Ruling(True, "", old, _formation_words(order, sailing.plan.shape))

    def _too_close(self, plan: Plan, order: FormationOrder) -> list[str]:
        """Slots that the position error of this boat makes too narrow."""
        sigma_m = self.position_error_m()
        return check_formation(plan, shape_in(order, plan.mission), None, sigma_m) if sigma_m > 0.0 else []

    def expect(self, order: FormationOrder, words: Signed, at_ns: int) -> None:
        """Switch to a formation at that time."""
        assert self.sailing is not None
        self.sailing.pending, self.sailing.pending_words, self.sailing.pending_ns = order, words, at_ns
        self.changed = True

    def handed_on(self, words: Signed, remaining_s: float, now_ns: int) -> str:
        """A formation that a neighbour holds; '' or why it is not taken."""
        sailing = self.sailing
        if sailing is None:
            return "no mission"
        try:
            order = decode_formation(words)
        except Refused as refusal:
            return f"the order {refusal}"
        held = sailing.held
        if order.mission_id != sailing.order.mission_id or not held < order.revision:
            return "not newer"
        if held.counter > 0 and order.revision.counter > held.counter + LARGEST_JUMP:  # who holds none has missed all
            return f"revision {order.revision} is more than {LARGEST_JUMP} ahead of {held}"
        problems = self._misfits(sailing.plan, order, words, None)
        if problems:
            return "; ".join(problems)
        rival = sailing.pending or sailing.formation
        descends = order.based_on == held or (
            order.based_on.operator == held.operator and order.based_on.counter > held.counter
        )
        if held.counter > 0 and not descends:
            self.note(
                "superseded",
                f"{_formation_words(rival, sailing.plan.shape)} (revision {rival.revision}) gives way to "
                f"{_formation_words(order, sailing.plan.shape)} (revision {order.revision})",
            )
        self.expect(order, words, now_ns + int(min(max(remaining_s, 0.0), order.apply_in_s) * 1e9))
        return ""

    def switch(self, now_ns: int) -> bool:
        """Put the pending formation in force when its time has come."""
        sailing = self.sailing
        if sailing is None:
            return False
        if sailing.redrawing is not None and (now_ns - sailing.switched_ns) * 1e-9 >= sailing.redrawing.duration_s:
            sailing.redrawing = None
        if sailing.pending is None or now_ns < sailing.pending_ns:
            return False
        places = sailing.places(now_ns)
        sailing.formation, sailing.formation_words = sailing.pending, sailing.pending_words
        sailing.shape = shape_in(sailing.formation, sailing.plan.mission)
        sailing.drawn = sailing.shape.places
        need = gap_needed(sailing.plan.mission)
        sailing.redrawing = redrawing(places, sailing.shape, sailing.plan.boats, need)
        sailing.pending = sailing.pending_words = None
        sailing.switched_ns = now_ns
        self.changed = True
        self.note(
            "formation",
            f"{_formation_words(sailing.formation, sailing.plan.shape)}, revision {sailing.formation.revision}",
            sailing.formation.spacing_m,
        )
        return True

    # -- goals -----------------------------------------------------------------------------------------------------
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

    def _hold(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002 - all rulings are alike
        old = self.goal.name.lower()
        self._set_goal(Goal.HOLD, Reason.HELD)
        return Ruling(True, "", old, "hold")

    def _resume(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        if self.sailing is None:
            return Ruling(False, "no mission to resume")
        if self.stops:
            return Ruling(False, f"stopped by {_and(self.stops)}; release first", safety=True)
        old = self.goal.name.lower()
        problem = self.resume_at(command.text)
        if problem:
            return Ruling(False, problem, safety=True)
        self._set_goal(Goal.FOLLOW, Reason(0))
        return Ruling(True, "", old, "follow")

    def _abort(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        old = self.sailing.order.mission_id if self.sailing else "none"
        self.ended = self.sailing.plan if self.sailing is not None else self.ended
        self.sailing = None
        self._set_goal(Goal.HOLD, Reason.ABORTED)
        return Ruling(True, "", old, "none, hold")

    def _return(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        if self.stops:
            return Ruling(False, f"stopped by {_and(self.stops)}; release first", safety=True)
        old = self.goal.name.lower()
        self._set_goal(Goal.RETURN, Reason.RETURNING)
        return Ruling(True, "", old, "return")

    def _stop(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        old = _and(self.stops) or "no stop"
        if len(self.stops) >= MOST_STOPS:
            return Ruling(True, "stopped already", old, old)
        self.stops[command.id] = None
        self.changed = True
        return Ruling(True, "", old, _and(self.stops))

    def hear_stops(self, stops: tuple[str, ...]) -> None:
        """A stop of the whole fleet reaches who was out of reach from its neighbours, unless it was released."""
        for stop in stops:
            if stop.startswith(FOR_ALL) and stop not in self.stops and stop not in self.released:
                if len(self.stops) >= MOST_STOPS:
                    return
                self.stops[stop] = None
                self.changed = True
                self.note("stop", f"a neighbour knows of {stop}")

    def _release(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        old = _and(self.stops) or "no stop"
        unknown = [name for name in command.names if name not in self.stops]
        for name in command.names:
            self.stops.pop(name, None)
            self.released[name] = None
        while len(self.released) > REMEMBERED:
            del self.released[next(iter(self.released))]
        self.changed = True
        if self.goal != Goal.STANDBY and not self.stops and self.goal != Goal.HOLD:
            self._set_goal(Goal.HOLD, Reason.HELD)
        remark = f"did not know {_and(unknown)}" if unknown else ""
        return Ruling(True, remark, old, _and(self.stops) or "released; holding until resumed")

    def _take(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        old = self.control.operator or "nobody"
        if old != command.operator:
            self.control = Revision(self.control.counter + 1, command.operator)
            self.changed = True
        return Ruling(True, "", old, command.operator)

    def _forget(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        gone = self.forget(command.names)
        return Ruling(True, "" if gone else "knew none of them", _and(command.names), "forgotten" if gone else "")

    # -- what neighbours know --------------------------------------------------------------------------------------
    def hear_control(self, control: Revision) -> None:
        """A neighbour's word on who holds control: the larger revision wins."""
        if self.control < control and control.counter <= self.control.counter + LARGEST_JUMP:
            self.control = control
            self.changed = True

    def held_formation(self, now_ns: int) -> tuple[Signed | None, float]:
        """The newest formation as its operator wrote it, and the time until it applies [s]."""
        sailing = self.sailing
        if sailing is None:
            return None, 0.0
        if sailing.pending_words is not None:
            return sailing.pending_words, max(0.0, (sailing.pending_ns - now_ns) * 1e-9)
        return sailing.formation_words, 0.0

    def note(self, kind: str, text: str, value: float = 0.0) -> None:
        """Something to be published as an event."""
        if len(self.notes) < 64:
            self.notes.append((kind, text, value))


def _formation_words(order: FormationOrder, launched: Shape) -> str:
    """A formation; pattern and slots where they are not as they were at launch."""
    words = f"spacing {order.spacing_m:g} m, cruise {order.cruise_mps:g} m/s"
    now = (order.pattern, order.lateral_m, tuple(slot for _, slot in order.slots))
    if not order.pattern or now == (launched.pattern, launched.lateral_m, launched.slots):
        return words
    slots = ", ".join(f"{boat}={slot:g}" for boat, slot in order.slots)
    return f"{words}, {order.pattern}, lateral {order.lateral_m:g} m, slots {slots}"


def _and(names: Mapping[str, object] | tuple[str, ...] | list[str]) -> str:
    return ", ".join(names)


def encoded(order: MissionOrder | FormationOrder) -> Signed:
    """An operator's words, unsigned."""
    return Signed(encode(order))
