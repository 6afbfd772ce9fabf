"""Missions: read in the background where that takes long, taken up by a launch."""

from __future__ import annotations

import logging

from msgspec import Struct

from fleet.agent import door
from fleet.agent.examine import apart
from fleet.agent.modes import Goal
from fleet.agent.sailing import Sailing, joined
from fleet.agent.standing import Standing
from fleet.errors import FleetError
from fleet.guidance.limits import asked_too_much
from fleet.mission.check import check
from fleet.mission.model import Boat
from fleet.mission.plan import build
from fleet.wire.codec import Refused, decode_mission_order
from fleet.wire.messages import MAJOR, Command, FormationOrder, Revision, Signed

STAND_IN = "unicycle"  # the hull of a mission that does not say which: it stands for any
AHEAD = 8  # pieces of work done ahead and kept until taken; a few are for commands that are refused after all

log = logging.getLogger("fleet.agent")


class Ruling(Struct, frozen=True):
    """What came of a command."""

    ok: bool
    reason: str = ""
    old: str = ""
    new: str = ""
    safety: bool = False


class Missions(Standing):
    """What missions are told."""

    def __init__(self, boat: str, *, simulated: bool, version: str) -> None:
        super().__init__(boat, simulated=simulated, version=version)
        self._read: list[tuple[Signed, str, Sailing | None]] = []  # missions read in the background, not yet taken

    def _launch(self, command: Command, now_ns: int) -> Ruling:
        if command.order is None:
            return Ruling(False, "a launch without a mission")
        if self.stops:
            return Ruling(False, f"stopped by {joined(self.stops)}; release first", safety=True)
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
                return f"not in the roster {joined(numbers)}", None
            problems = apart(order.mission) if self.apart and door.heavy(mission) else check(mission).problems
            if problems:
                return "; ".join(problems[:3]), None
            plan = build(mission)
            if plan.shape.pattern == "wingman":
                self.flights.prepare(plan, plan.shape)
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
