"""What the others ask of this boat, and what it asks of them: commands, missions and formations handed on, echoes."""

from __future__ import annotations

import logging
from collections import Counter, deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from fleet.agent.modes import Goal, Mode, Reason
from fleet.agent.picture import DISCIPLINED_NS
from fleet.wire import keys
from fleet.wire.bus import Answer, Request
from fleet.wire.codec import Refused, decode, decode_command, decode_held, decode_mission_order, encode
from fleet.wire.messages import MAJOR, Ack, BoatState, Command, Echo, Held, Signed

if TYPE_CHECKING:
    from fleet.agent.agent import Agent
    from fleet.agent.sailing import Sailing

log = logging.getLogger("fleet.agent")
REQUESTS_A_TICK = 128
ANSWERED_BYTES = 1 << 18  # of missions, in one tick: who asks for more waits in vain and asks again
COUNTED = 64  # different words in a count; more are one
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
        self._working: dict[str, list[tuple[Request, Command]]] = {}  # by id: commands looked into elsewhere
        self._reading = False  # a neighbour's mission
        self._unfit: deque[int] = deque(maxlen=16)  # neighbours' missions that this boat does not sail
        self._room = ANSWERED_BYTES
        self._dropped = 0
        self.refused: Counter[str] = Counter()

    def count(self, why: str) -> None:
        """One more refusal, in words that senders cannot multiply."""
        why = why[:120]
        self.refused[why if why in self.refused or len(self.refused) < COUNTED - 1 else "others"] += 1

    def failed(self, what: str) -> None:
        """A message met a mistake of ours: it costs the message, not the boat. To be called while handling it."""
        first = f"{what}: internal error" not in self.refused
        self.count(f"{what}: internal error")
        if first:
            log.exception("%s could not be taken in", what, extra={"event": "internal-error"})

    def serve(self, now_ns: int) -> None:
        """Answer what was asked since the last tick, take in what came back."""
        self._room = ANSWERED_BYTES
        dropped = self._agent.bus.overflowed()
        if dropped > self._dropped:
            self.refused["too many at once: dropped unread"] += dropped - self._dropped
            self._dropped = dropped
        for request in self._agent.bus.poll_requests(REQUESTS_A_TICK):
            try:
                self._answer(request, now_ns)
            except Exception:  # noqa: BLE001  a boat under way outlives any message
                self.failed(request.what)
                request.drop()
        for answer in self._agent.bus.poll_answers():
            try:
                self._take(answer, now_ns)
            except Refused as refusal:
                self.count(f"{answer.what}: {refusal}")
            except Exception:  # noqa: BLE001  a boat under way outlives any message
                self.failed(answer.what)
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
            self._hand_out(request, Held(MAJOR, words, wait_s))
        elif request.what == keys.FORMATION:
            formation, remaining_s = orders.held_formation(now_ns)
            self._hand_out(request, Held(MAJOR, formation, remaining_s))
        else:
            self._obey(request, now_ns)

    def _hand_out(self, request: Request, held: Held) -> None:
        """A mission or a formation, as far as one tick's room goes."""
        if self._room <= 0:
            self.count(f"{request.what}: asked too often")
            request.drop()
            return
        answer = encode(held)
        self._room -= len(answer)
        request.reply(answer)

    def _obey(self, request: Request, now_ns: int) -> None:
        agent = self._agent
        try:
            command = decode_command(request.payload)
        except Refused as refusal:
            self.count(f"command: {refusal}")
            request.reply(encode(Ack(MAJOR, "", agent.boat, False, f"the command {refusal}")))
            return
        waiting = self._working.get(command.id)
        if waiting is not None and len(waiting) < COUNTED:
            waiting.append((request, command))
            return
        work = agent.orders.work(command, now_ns)
        if work is None:
            self._acknowledge(request, command, now_ns)
            return
        self._working[command.id] = [(request, command)]
        if not agent.background.submit(work, lambda: self._worked(command.id, now_ns)):
            del self._working[command.id]
            self.count("command: busy")
            request.reply(encode(Ack(MAJOR, command.id, agent.boat, False, "busy with other commands; say it again")))

    def _worked(self, command_id: str, now_ns: int) -> None:
        """What takes long is done: obey, as of when the command was received."""
        for request, command in self._working.pop(command_id, ()):
            self._acknowledge(request, command, now_ns)

    def _acknowledge(self, request: Request, command: Command, now_ns: int) -> None:
        ack = self._agent.orders.obey(command, now_ns)
        if not ack.ok:
            self.count(f"command: {command.kind} refused")
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
        orders.hear_stops(state.stops)
        sailing = orders.sailing
        if sailing is None or state.boat in agent.picture.roster:
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
        held = decode_held(answer.payload)
        words = held.order
        if words is None:
            return
        if answer.what == keys.FORMATION:
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
