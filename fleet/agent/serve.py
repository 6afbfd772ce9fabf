"""What the others ask of this boat, and what it asks of them: commands, missions and formations handed on, echoes."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from msgspec import Struct

from fleet.agent.background import Piece
from fleet.agent.neighbours import COUNTED, Neighbours
from fleet.wire import keys
from fleet.wire.bus import Request
from fleet.wire.codec import Refused, decode, decode_command, encode
from fleet.wire.messages import MAJOR, Ack, Command, Held, Signed, Stops

if TYPE_CHECKING:
    from fleet.agent.agent import Agent

log = logging.getLogger("fleet.agent")
REQUESTS_A_TICK = 128
ANSWERED_BYTES = 1 << 18  # of missions, in one tick: who asks for more waits in vain and asks again
ECHO_S = 1.0
PATIENCE_S = 1.5  # a command that waits longer to be looked into is turned away: who asked waits 3 s for an answer
BUSY = "busy with other commands; say it again"
Asked = tuple[Request, Command, Signed | None]


class Looked(Struct):
    """A command that is looked into elsewhere, and who asked for it."""

    since_ns: int
    asked: list[Asked]
    piece: Piece | None = None


class Desk(Neighbours):
    """Where requests are answered, in the thread that decides."""

    def __init__(self, agent: Agent) -> None:
        super().__init__(agent)
        self._echo_ns = 0
        self._waiting: list[Callable[[], None]] = []
        self._working: dict[str, Looked] = {}  # by id
        self._reading = False  # a neighbour's mission
        self._unfit: deque[int] = deque(maxlen=16)  # neighbours' missions that this boat does not sail
        self._room = ANSWERED_BYTES
        self._dropped = 0

    def failed(self, what: str) -> None:
        """A message met a mistake of ours: it costs the message, not the boat. To be called while handling it."""
        first = f"{what}: internal error" not in self.refused
        self.count(f"{what}: internal error")
        if first:
            log.exception("%s could not be taken in", what, extra={"event": "internal-error"})

    def serve(self, now_ns: int) -> None:
        """Answer what was asked since the last tick, take in what came back."""
        self._room = ANSWERED_BYTES
        self._agent.guard.tick()
        dropped = self._agent.bus.overflowed()
        if dropped > self._dropped:
            self.refused["too many at once: dropped unread"] += dropped - self._dropped
            self._dropped = dropped
        self._turn_away(now_ns)
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
        elif request.what == keys.MAVLINK:
            self._pass(request, now_ns)
        elif request.what == keys.MISSION:
            words = orders.sailing.words if orders.sailing is not None else None
            wait_s = max(0.0, (orders.sailing.starts_ns - now_ns) * 1e-9) if orders.sailing is not None else 0.0
            self._hand_out(request, Held(MAJOR, words, wait_s))
        elif request.what == keys.STOPS:
            self._hand_out(request, Stops(MAJOR, tuple(orders.stop_words.values())))
        elif request.what == keys.ROSTER:
            self._take_roster(request)
        elif request.what == keys.FORMATION:
            formation, remaining_s = orders.held_formation(now_ns)
            self._hand_out(request, Held(MAJOR, formation, remaining_s))
        else:
            self._obey(request, now_ns)

    def _hand_out(self, request: Request, held: Held | Stops) -> None:
        """A mission, a formation or stops, as far as one tick's room goes."""
        if self._room <= 0:
            self.count(f"{request.what}: asked too often")
            request.drop()
            return
        answer = encode(held)
        self._room -= len(answer)
        request.reply(answer)

    def _pass(self, request: Request, now_ns: int) -> None:
        """Frames of a ground station for the boat's own autopilot; only who may command the boat has any passed on."""
        autopilot, control = self._agent.autopilot, self._agent.orders.control.operator
        if autopilot is None:
            request.drop()
            return
        try:
            frames = self._agent.guard.frames(request.payload, now_ns)
        except Refused as refusal:
            self.count(f"mavlink: {refusal}")
            request.drop()
            return
        why = f"{control} holds control" if frames.frames and control not in ("", frames.operator) else ""
        why = why or autopilot.hand_in(frames.frames)
        if why:
            self.count(f"mavlink: {why}")
        request.reply(encode(Ack(MAJOR, "", self._agent.boat, not why, why)))

    def _obey(self, request: Request, now_ns: int) -> None:
        agent = self._agent
        try:
            command, words = agent.guard.command(request.payload, now_ns)
        except Refused as refusal:
            self.count(f"command: {refusal}")
            request.reply(encode(Ack(MAJOR, _id_of(request.payload), agent.boat, False, f"the command {refusal}")))
            return
        waiting = self._working.get(command.id)
        if waiting is not None and len(waiting.asked) < COUNTED:
            waiting.asked.append((request, command, words))
            return
        work = agent.orders.work(command, now_ns)
        if work is None:
            self._acknowledge(request, command, words, now_ns)
            return
        looked = self._working[command.id] = Looked(now_ns, [(request, command, words)])
        looked.piece = agent.background.submit(work, lambda: self._worked(command.id, now_ns))
        if looked.piece is None:
            self._say_busy(command.id)

    def _turn_away(self, now_ns: int) -> None:
        """Commands that have waited too long: late is worse than not at all, for who asked has given it up by then."""
        late = [name for name, one in self._working.items() if now_ns - one.since_ns > PATIENCE_S * 1e9]
        for command_id in late:
            piece = self._working[command_id].piece
            if piece is not None and piece.claim():
                self._say_busy(command_id)

    def _say_busy(self, command_id: str) -> None:
        for request, _, _ in self._working.pop(command_id).asked:
            self.count("command: busy")
            request.reply(encode(Ack(MAJOR, command_id, self._agent.boat, False, BUSY)))

    def _worked(self, command_id: str, now_ns: int) -> None:
        """What takes long is done: obey, as of when the command was received."""
        for request, command, words in self._working.pop(command_id).asked:
            self._acknowledge(request, command, words, now_ns)

    def _acknowledge(self, request: Request, command: Command, words: Signed | None, now_ns: int) -> None:
        ack = self._agent.orders.obey(command, now_ns)
        self._agent.guard.heeded(command, words)
        if not ack.ok:
            self.count(f"command: {command.kind} refused")
        answer = encode(ack)
        on_disk = command.kind in ("stop-now", "release") or (words is not None and not self._agent.store.trouble)
        if on_disk and ack.ok:
            self._waiting.append(lambda: request.reply(answer))
        else:
            request.reply(answer)

    def _take_roster(self, request: Request) -> None:
        """A roster that an operator brings: the authority's signature is all it needs."""
        agent = self._agent
        trust = agent.guard.trust
        if trust is None:
            request.reply(encode(Ack(MAJOR, "", agent.boat, False, "this boat has no credentials")))
            return
        old, found = trust.roster.number, [""]

        def take() -> None:
            try:
                found[0] = "" if trust.told(request.payload, "the wire") else "not newer"
            except Refused as refusal:
                found[0] = str(refusal)

        def answer() -> None:
            ok = trust.roster.number > old or found[0] == "not newer"
            if not ok:
                self.count(f"roster: {found[0]}")
                log.warning("refused: %s", found[0], extra={"event": "refused"})
            ack = Ack(MAJOR, "", agent.boat, ok, found[0], str(old), str(trust.roster.number), agent.orders.version)
            request.reply(encode(ack))

        if agent.background.submit(take, answer) is None:
            self.count("roster: busy")
            request.reply(encode(Ack(MAJOR, "", agent.boat, False, BUSY)))

    @property
    def waits_for_disk(self) -> bool:
        """A stop, a release or a signed word is not yet acknowledged, because it is not yet written."""
        return bool(self._waiting)

    def written(self) -> Callable[[], None]:
        """What to do once the stops of this tick are on disk: acknowledge them."""
        waiting, self._waiting = self._waiting, []

        def acknowledge() -> None:
            for reply in waiting:
                reply()

        return acknowledge


def _id_of(payload: bytes) -> str:
    """The id of a command that is refused, so that its operator knows which."""
    try:
        words = decode(payload, Signed)
    except Refused:
        words = Signed(payload)
    try:
        return decode_command(words.body).id
    except Refused:
        return ""
