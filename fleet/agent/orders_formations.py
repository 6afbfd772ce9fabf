"""Changes of the formation: judged, expected, handed on from boat to boat, put in force."""

from __future__ import annotations

from collections.abc import Callable

from fleet.agent.orders_missions import AHEAD, Missions, Ruling
from fleet.agent.sailing import formation_words
from fleet.mission.formation import check_formation, gap_needed
from fleet.mission.pattern import PATTERNS
from fleet.mission.plan import Plan
from fleet.mission.redraw import redrawing
from fleet.wire.codec import LARGEST_JUMP, Refused, decode_formation
from fleet.wire.formation import shape_in
from fleet.wire.messages import Command, FormationOrder, Signed

LONG_WORK = {name: pattern.lateral or name == "wingman" for name, pattern in PATTERNS.items()}
"""Patterns that take long to check: lanes are held against the fence, wingmen against their leaders."""
MANY_PATHS = 10  # from here on it takes longer than a tick may to hold all places against each other


class Formations(Missions):
    """What formations are told."""

    def __init__(self, boat: str, *, simulated: bool, version: str) -> None:
        super().__init__(boat, simulated=simulated, version=version)
        self._checked: list[tuple[Signed, Plan, list[str]]] = []  # so, formations held against each other

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
        old = formation_words(sailing.pending or sailing.formation, sailing.plan.shape)
        self.expect(order, command.order, now_ns + int(order.apply_in_s * 1e9))
        return Ruling(True, "", old, formation_words(order, sailing.plan.shape))

    def _too_close(self, plan: Plan, order: FormationOrder) -> list[str]:
        """Slots that the position error of this boat makes too narrow."""
        sigma_m = self.position_error_m()
        return check_formation(plan, shape_in(order, plan.mission), None, sigma_m) if sigma_m > 0.0 else []

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
            if not found and shape.pattern == "wingman":
                self.flights.prepare(plan, shape)
            del self._checked[:-AHEAD]
            self._checked.append((words, plan, found))

        return check_ahead

    def wants_formation(self, words: Signed) -> bool:
        """Whether a formation that a neighbour holds is newer than this boat's."""
        sailing = self.sailing
        if sailing is None:
            return False
        order = decode_formation(words)
        return order.mission_id == sailing.order.mission_id and sailing.held < order.revision

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
                f"{formation_words(rival, sailing.plan.shape)} (revision {rival.revision}) gives way to "
                f"{formation_words(order, sailing.plan.shape)} (revision {order.revision})",
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
            f"{formation_words(sailing.formation, sailing.plan.shape)}, revision {sailing.formation.revision}",
            sailing.formation.spacing_m,
        )
        return True

    def held_formation(self, now_ns: int) -> tuple[Signed | None, float]:
        """The newest formation as its operator wrote it, and the time until it applies [s]."""
        sailing = self.sailing
        if sailing is None:
            return None, 0.0
        if sailing.pending_words is not None:
            return sailing.pending_words, max(0.0, (sailing.pending_ns - now_ns) * 1e-9)
        return sailing.formation_words, 0.0
