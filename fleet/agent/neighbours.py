"""What neighbours know and this boat does not: missions, formations and stops handed on, echoes.

Whatever is handed on is an operator's word, and is taken only as the guard lets it pass.
"""

from __future__ import annotations

from collections import Counter, deque
from typing import TYPE_CHECKING

from fleet.agent.modes import Goal, Mode, Reason
from fleet.agent.picture import DISCIPLINED_NS
from fleet.agent.standing import MOST_STOPS
from fleet.wire import keys
from fleet.wire.bus import Answer
from fleet.wire.codec import decode, decode_held, decode_mission_order, encode
from fleet.wire.messages import MAJOR, BoatState, Echo, Signed, Stops

if TYPE_CHECKING:
    from fleet.agent.agent import Agent
    from fleet.agent.sailing import Sailing

COUNTED = 64  # different words in a count; more are one
ASK_AGAIN_S = 0.5
NOT_SAILED = int(Reason.NOT_RESUMED | Reason.HELD | Reason.RETURNING | Reason.MISSION_ENDED | Reason.ABORTED)
"""A mission that its boat only holds for one of these reasons is no reason for another to set sail."""


class Neighbours:
    """What comes of their states and answers, in the thread that decides."""

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self._asked_ns: dict[tuple[str, str], int] = {}
        self._reading = False  # a neighbour's mission
        self._unfit: deque[int] = deque(maxlen=16)  # neighbours' missions that this boat does not sail
        self.refused: Counter[str] = Counter()

    def count(self, why: str) -> None:
        """One more refusal, in words that senders cannot multiply."""
        why = why[:120]
        self.refused[why if why in self.refused or len(self.refused) < COUNTED - 1 else "others"] += 1

    def compare(self, state: BoatState, now_ns: int) -> None:
        """Something newer in a neighbour's state is asked for."""
        agent = self._agent
        orders = agent.orders
        if state.simulated != agent.driver.simulated:
            return
        if agent.guard.trust is None:
            orders.hear_stops(state.stops)
        elif orders.unheard_stops(state.stops):
            self._ask(state.boat, keys.STOPS, now_ns)
        sailing = orders.sailing
        ours = sailing is None or state.boat in agent.picture.roster
        if ours and agent.guard.may_control(state.control.operator):
            orders.hear_control(state.control)
        if sailing is not None and state.mission_id == sailing.order.mission_id:
            if sailing.held < state.held:
                self._ask(state.boat, keys.FORMATION, now_ns)
        elif (
            self._stands_by()
            and state.mission_id
            and state.mission_id not in orders.known_missions
            and state.mode in (Mode.FOLLOW, Mode.AVOID, Mode.HOLD, Mode.ALONE, Mode.STANDBY)
            and not state.reasons & NOT_SAILED
        ):
            self._ask(state.boat, keys.MISSION, now_ns)

    def _stands_by(self) -> bool:
        """Free for a mission that neighbours sail: without one, or with one that was not resumed."""
        orders = self._agent.orders
        return orders.goal == Goal.STANDBY and not orders.stops and not self._agent.resumption.pending

    def _ask(self, boat: str, what: str, now_ns: int) -> None:
        if now_ns - self._asked_ns.get((boat, what), -(10**18)) < ASK_AGAIN_S * 1e9:
            return
        if len(self._asked_ns) > 1024:
            self._asked_ns.clear()
        self._asked_ns[boat, what] = now_ns
        self._agent.bus.ask(boat, what, b"")

    def _take(self, answer: Answer, now_ns: int) -> None:
        agent = self._agent
        if answer.what == keys.ECHO:
            echo = decode(answer.payload, Echo)
            trip_s = (now_ns - echo.stamp_ns) * 1e-9
            other = agent.picture.others.get(answer.boat)
            if other is not None and 0.0 <= trip_s < 10.0:
                other.half_trip_s = trip_s / 2.0
            return
        if answer.what == keys.STOPS:
            self._take_stops(answer)
            return
        held = decode_held(answer.payload)
        words = held.order
        if words is None:
            return
        if answer.what == keys.FORMATION:
            if not agent.orders.wants_formation(words):
                return
            agent.guard.formation(words, answer.boat)
            work = agent.orders.formation_work(words, None)
            if work is None:
                self._hand_on(words, held.remaining_s, answer.boat, now_ns)
            else:
                agent.background.submit(work, lambda: self._hand_on(words, held.remaining_s, answer.boat, now_ns))
            return
        order = decode_mission_order(words)
        mark = hash(words.body)
        if (
            self._reading
            or not self._stands_by()
            or order.mission_id in agent.orders.known_missions
            or mark in self._unfit
        ):
            return
        agent.guard.mission(words, answer.boat, now_ns)
        read: list[tuple[str, Sailing | None]] = []
        self._reading = True

        def begin() -> None:
            self._reading = False
            problem, sailing = read[0] if read else ("cannot be read", None)
            if sailing is None:
                self._unfit.append(mark)
                self.count(f"mission from {answer.boat}: {problem}")
            else:
                self._sail_too(sailing, held.remaining_s, now_ns)

        if not agent.background.submit(lambda: read.append(agent.orders.read_mission(words, now_ns)), begin):
            self._reading = False

    def _hand_on(self, words: Signed, remaining_s: float, boat: str, now_ns: int) -> None:
        """Take a neighbour's newer formation."""
        problem = self._agent.orders.handed_on(words, remaining_s, now_ns)
        if problem and problem != "not newer":
            self.count(f"formation from {boat}: {problem}")

    def _take_stops(self, answer: Answer) -> None:
        """Stops that a neighbour knows of, each in the words of an operator."""
        guard, orders = self._agent.guard, self._agent.orders
        if guard.trust is None:
            return
        for words in decode(answer.payload, Stops).words[:MOST_STOPS]:
            stop = guard.stop(words, answer.boat)
            if stop:
                orders.hear_stops((stop,))
                orders.keep_stop_words(stop, words)

    def _sail_too(self, sailing: Sailing, remaining_s: float, now_ns: int) -> None:
        """Take a neighbour's mission, if this boat still waits for one."""
        orders = self._agent.orders
        if not self._stands_by():
            return
        if sailing.order.mission_id not in orders.known_missions and not (
            orders.sailing is not None and sailing.order.stamp_ns < orders.sailing.order.stamp_ns
        ):
            sailing.starts_ns = now_ns + int(min(max(remaining_s, 0.0), sailing.order.apply_in_s) * 1e9)
            orders.begin(sailing, Goal.FOLLOW)

    def _ask_echoes(self, now_ns: int) -> None:
        """Round trips, where clocks do not tell ages."""
        agent = self._agent
        for other in agent.picture.others.values():
            track = other.track
            if track is None or (max(track.state.clock_ns, agent.clock_ns) <= DISCIPLINED_NS and track.lead_s >= 0.0):
                continue
            agent.bus.ask(other.name, keys.ECHO, encode(Echo(MAJOR, now_ns)))
