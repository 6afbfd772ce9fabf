"""What the others ask of this boat, and what it asks of them: commands, missions and formations handed on, echoes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING

from fleet.agent.modes import Goal, Mode, Reason
from fleet.agent.picture import DISCIPLINED_NS
from fleet.wire import keys
from fleet.wire.bus import Answer, Request
from fleet.wire.codec import Refused, decode, decode_command, encode
from fleet.wire.messages import MAJOR, Ack, BoatState, Echo, Held

if TYPE_CHECKING:
    from fleet.agent.agent import Agent

REQUESTS_A_TICK = 128
ASK_AGAIN_S = 0.5
ECHO_S = 1.0
NOT_SAILED = int(Reason.NOT_RESUMED | Reason.HELD | Reason.RETURNING | Reason.MISSION_ENDED | Reason.ABORTED)
"""A mission that its boat only holds for one of these reasons is no reason for another to set sail."""


class Desk:
    """Where requests are answered, in the thread that decides."""

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self._asked_ns: dict[tuple[str, str], int] = {}
        self._echo_ns = 0
        self._waiting: list[Callable[[], None]] = []
        self.refused: Counter[str] = Counter()

    def serve(self, now_ns: int) -> None:
        """Answer what was asked since the last tick, take in what came back."""
        for request in self._agent.bus.poll_requests(REQUESTS_A_TICK):
            self._answer(request, now_ns)
        for answer in self._agent.bus.poll_answers():
            try:
                self._take(answer, now_ns)
            except Refused as refusal:
                self.refused[f"{answer.what}: {refusal}"] += 1
        if now_ns - self._echo_ns >= ECHO_S * 1e9:
            self._echo_ns = now_ns
            self._ask_echoes(now_ns)

    def _answer(self, request: Request, now_ns: int) -> None:
        orders = self._agent.orders
        if request.what == keys.ECHO:
            request.reply(request.payload[:64])
        elif request.what == keys.MISSION:
            words = orders.sailing.words if orders.sailing is not None else None
            wait_s = max(0.0, (orders.sailing.starts_ns - now_ns) * 1e-9) if orders.sailing is not None else 0.0
            request.reply(encode(Held(MAJOR, words, wait_s)))
        elif request.what == keys.FORMATION:
            formation, remaining_s = orders.held_formation(now_ns)
            request.reply(encode(Held(MAJOR, formation, remaining_s)))
        else:
            self._obey(request, now_ns)

    def _obey(self, request: Request, now_ns: int) -> None:
        agent = self._agent
        try:
            command = decode_command(request.payload)
        except Refused as refusal:
            self.refused[f"command: {refusal}"] += 1
            request.reply(encode(Ack(MAJOR, "", agent.boat, False, f"the command {refusal}")))
            return
        ack = agent.orders.obey(command, now_ns)
        answer = encode(ack)
        if command.kind in ("stop-now", "release") and ack.ok:
            self._waiting.append(lambda: request.reply(answer))
        else:
            request.reply(answer)

    @property
    def waits_for_disk(self) -> bool:
        """A stop or a release is not yet acknowledged, because it is not yet written."""
        return bool(self._waiting)

    def written(self) -> Callable[[], None]:
        """What to do once the stops of this tick are on disk: acknowledge them."""
        waiting, self._waiting = self._waiting, []

        def acknowledge() -> None:
            for reply in waiting:
                reply()

        return acknowledge

    # -- neighbours ------------------------------------------------------------------------------------------------
    def compare(self, state: BoatState, now_ns: int) -> None:
        """Something newer in a neighbour's state is asked for."""
        agent = self._agent
        orders = agent.orders
        if state.simulated != agent.driver.simulated:
            return
        orders.hear_control(state.control)
        sailing = orders.sailing
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
        held = decode(answer.payload, Held)
        if held.order is None:
            return
        if not math.isfinite(held.remaining_s):
            raise Refused("not finite")
        if answer.what == keys.FORMATION:
            problem = agent.orders.handed_on(held.order, held.remaining_s, now_ns)
            if problem and problem != "not newer":
                self.refused[f"formation from {answer.boat}: {problem}"] += 1
            return
        orders = agent.orders
        if not self._stands_by():
            return
        problem, sailing = orders.read_mission(held.order, now_ns)
        if sailing is None:
            self.refused[f"mission from {answer.boat}: {problem}"] += 1
        elif sailing.order.mission_id not in orders.known_missions and not (
            orders.sailing is not None and sailing.order.stamp_ns < orders.sailing.order.stamp_ns
        ):
            sailing.starts_ns = now_ns + int(min(max(held.remaining_s, 0.0), sailing.order.apply_in_s) * 1e9)
            orders.begin(sailing, Goal.FOLLOW)

    def _ask_echoes(self, now_ns: int) -> None:
        """Round trips, where clocks do not tell ages."""
        agent = self._agent
        for other in agent.picture.others.values():
            track = other.track
            if track is None or (max(track.state.clock_ns, agent.clock_ns) <= DISCIPLINED_NS and track.lead_s >= 0.0):
                continue
            agent.bus.ask(other.name, keys.ECHO, encode(Echo(MAJOR, now_ns)))
