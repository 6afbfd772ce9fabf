"""What the boat is told: missions, formations with their revisions, control, stops. No clock, no wire of its own.

A formation revision is (counter, operator) within one mission id; the larger one wins wherever two meet. Operators'
words are kept as they were written, so that any boat that holds them can hand them on unaltered.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from hashlib import blake2b

from msgspec import structs

from fleet.agent.modes import Goal, Reason
from fleet.agent.orders_formations import Formations
from fleet.agent.orders_missions import Ruling
from fleet.agent.sailing import joined
from fleet.agent.standing import MOST_STOPS
from fleet.wire.codec import encode
from fleet.wire.messages import MAJOR, Ack, Command, FormationOrder, MissionOrder, Revision, Signed

FREE_KINDS = ("hold", "abort", "stop-now", "take")
"""What any permitted operator may say, in control or not."""
REMEMBERED = 256  # of those obeyed, and of those refused: a flood of refusals makes no old command new
LONGEST_REASON = 400
REFUSALS_TOLD_S = 0.2  # between two events about refusals; all of them are counted


class Orders(Formations):
    """Everything that operators have told this boat."""

    def __init__(self, boat: str, *, simulated: bool, version: str) -> None:
        super().__init__(boat, simulated=simulated, version=version)
        self._obeyed: dict[str, tuple[bytes, Ack]] = {}
        self._refused: dict[str, tuple[bytes, Ack]] = {}
        self._told_ns = 0
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

    def answered(self, command: Command) -> bool:
        """Whether a command with this id was answered before: then it is not obeyed again."""
        return command.id in self._obeyed or command.id in self._refused

    def work(self, command: Command, now_ns: int) -> Callable[[], None] | None:
        """What takes too long for a tick and must be done before `obey`; None when nothing does."""
        words = command.order
        if words is None or self.answered(command):
            return None
        if self._not_permitted(command) is not None:
            return None
        if command.kind == "launch" and not self.stops and self._launched_before(words, command.operator) is None:
            return lambda: self._read_ahead(words, now_ns)
        return self.formation_work(words, self.abscissas()) if command.kind == "set" else None

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

    def _hold(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002 - all rulings are alike
        old = self.goal.name.lower()
        self._set_goal(Goal.HOLD, Reason.HELD)
        return Ruling(True, "", old, "hold")

    def _resume(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        if self.sailing is None:
            return Ruling(False, "no mission to resume")
        if self.stops:
            return Ruling(False, f"stopped by {joined(self.stops)}; release first", safety=True)
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
            return Ruling(False, f"stopped by {joined(self.stops)}; release first", safety=True)
        old = self.goal.name.lower()
        self._set_goal(Goal.RETURN, Reason.RETURNING)
        return Ruling(True, "", old, "return")

    def _stop(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        old = joined(self.stops) or "no stop"
        if len(self.stops) >= MOST_STOPS:
            return Ruling(True, "stopped already", old, old)
        self.stops[command.id] = None
        self.changed = True
        return Ruling(True, "", old, joined(self.stops))

    def _release(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        old = joined(self.stops) or "no stop"
        unknown = [name for name in command.names if name not in self.stops]
        for name in command.names:
            self.stops.pop(name, None)
            self.released[name] = None
        while len(self.released) > REMEMBERED:
            del self.released[next(iter(self.released))]
        self.changed = True
        if self.goal != Goal.STANDBY and not self.stops and self.goal != Goal.HOLD:
            self._set_goal(Goal.HOLD, Reason.HELD)
        remark = f"did not know {joined(unknown)}" if unknown else ""
        return Ruling(True, remark, old, joined(self.stops) or "released; holding until resumed")

    def _take(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        old = self.control.operator or "nobody"
        if old != command.operator:
            self.control = Revision(self.control.counter + 1, command.operator)
            self.changed = True
        return Ruling(True, "", old, command.operator)

    def _forget(self, command: Command, now_ns: int) -> Ruling:  # noqa: ARG002
        gone = self.forget(command.names)
        return Ruling(True, "" if gone else "knew none of them", joined(command.names), "forgotten" if gone else "")


def encoded(order: MissionOrder | FormationOrder) -> Signed:
    """An operator's words, unsigned."""
    return Signed(encode(order))
