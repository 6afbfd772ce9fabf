"""Slots of boats that left are filled again, where the mission says `close-up`.

Nobody decides alone: the first boat of the roster that still sails asks for another formation, a revision like that of
an operator, which the others take over from their neighbours and put in force together.
"""

from __future__ import annotations

from collections.abc import Callable

from msgspec import structs

from fleet.agent.orders import Orders
from fleet.errors import FleetError
from fleet.mission.formation import check_formation
from fleet.mission.pattern import Shape, closed_up
from fleet.wire.codec import encode
from fleet.wire.formation import order_for
from fleet.wire.messages import Revision

STEADY_S = 10.0  # a boat is out, or back, when it has been so for so long without a break
APPLY_S = 2.0


class Vacancies:
    """Who is out of the formation, as one boat sees it."""

    def __init__(self, boat: str) -> None:
        self._boat = boat
        self._mission_id = ""
        self._since_ns: dict[str, int] = {}  # since when it is otherwise than `out` says
        self.out: set[str] = set()
        self._refused: tuple[float, ...] = ()  # slots that could not be sailed

    def consider(self, orders: Orders, present: Callable[[str], bool], now_ns: int) -> None:
        """Look who is there, and ask for another formation if it falls to this boat.

        Args:
            orders: with the mission under way; the new formation is put there
            present: whether a boat of the roster sails in the formation now, this one included
            now_ns: now
        """
        sailing = orders.sailing
        if sailing is None or sailing.plan.mission.formation.vacancies != "close-up":
            return
        if sailing.order.mission_id != self._mission_id:
            self._mission_id, self._refused = sailing.order.mission_id, ()
            self.out.clear()
            self._since_ns.clear()
        names = [boat.name for boat in sailing.plan.boats]
        for name in names:
            self._look(name, present(name), now_ns)
        sailing_ones = [name for name in names if name not in self.out]
        if not present(self._boat) or sailing_ones[:1] != [self._boat] or sailing.pending is not None:
            return
        slots = closed_up(sailing.shape.slots, [name in self.out for name in names])
        if slots not in (sailing.shape.slots, self._refused):
            self._ask(orders, structs.replace(sailing.shape, slots=slots), now_ns)

    def _look(self, name: str, there: bool, now_ns: int) -> None:
        if there != (name in self.out):
            self._since_ns.pop(name, None)
        elif (now_ns - self._since_ns.setdefault(name, now_ns)) * 1e-9 >= STEADY_S:
            del self._since_ns[name]
            (self.out.discard if there else self.out.add)(name)

    def _ask(self, orders: Orders, shape: Shape, now_ns: int) -> None:
        sailing = orders.sailing
        assert sailing is not None
        try:
            problems = check_formation(sailing.plan, shape)
        except FleetError as error:
            problems = [str(error)]
        gone = ", ".join(sorted(self.out)) or "nobody"
        if problems:
            self._refused = shape.slots
            orders.note("refused", f"closing up without {gone}: {problems[0]}"[:400])
            return
        held = sailing.held
        revision = Revision(held.counter + 1, self._boat)
        plan, mission_id = sailing.plan, sailing.order.mission_id
        order = order_for(shape, plan.mission, mission_id, revision, held, APPLY_S, now_ns)
        orders.note("formation", f"closing up without {gone}")
        orders.expect(order, orders.sign("formation", encode(order)), now_ns + int(APPLY_S * 1e9))
