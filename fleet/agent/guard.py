"""Whose words this boat obeys: with credentials, those that an operator of the roster signed, each of them once.

Against words of yesterday played again a boat remembers, across restarts, the stamp of the last word of each signer:
what is older is not obeyed. A word that makes a boat move must besides be of the last two minutes, where this boat's
clock is disciplined. `stop-now` goes by its id instead, so that no wrong clock stands in its way.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from fleet.agent.orders import Orders
from fleet.agent.picture import DISCIPLINED_NS
from fleet.agent.sailing import Sailing
from fleet.wire.codec import Refused, decode, decode_command, decode_formation, decode_mission_order
from fleet.wire.credentials.trust import Trust
from fleet.wire.messages import Command, Frames, Signed

COMMAND, MISSION, FORMATION, FRAMES = "command", "mission", "formation", "frames"
FRESH_NS = 120_000_000_000
MISSION_FRESH_NS = 86_400_000_000_000  # of one that a neighbour hands on
HARMLESS = ("hold", "abort", "stop-now")
SIGNERS = 64  # whose last words are remembered
CHECKS_A_TICK = 24  # signatures, a tenth of a millisecond each; a flood of forged words costs no more
AGAIN_S = 10.0  # between two lines of a log with the same words

log = logging.getLogger("fleet.agent")


class Guard:
    """Signatures asked for and checked; without credentials everything passes."""

    def __init__(self, orders: Orders, trust: Trust | None, clock_ns: Callable[[], int]) -> None:
        self._orders, self.trust, self._clock_ns = orders, trust, clock_ns
        self._left = CHECKS_A_TICK
        self.asks_age = True  # False where operators' clocks run at another pace: in warped simulations
        self._said: dict[str, float] = {}
        self._framed_ns: dict[str, int] = {}  # stamp of the last frames of each signer
        if trust is not None:
            orders.sign = trust.sign

    def tick(self) -> None:
        """A new tick: so many signatures may be checked in it."""
        self._left = CHECKS_A_TICK

    # -- words of operators ----------------------------------------------------------------------------------------
    def command(self, payload: bytes, now_ns: int) -> tuple[Command, Signed | None]:
        """The command in a request, and its words where they are signed; Refused when it must not be obeyed."""
        words = _signed(payload)
        command = decode_command(words.body if words is not None else payload)
        if self.trust is None:
            return command, words
        if words is None:
            self._say(f"{command.kind} of {command.operator}", "is not signed")
            raise Refused("is not signed; this boat obeys signed words only: --credentials FOLDER")
        what = f"{command.kind} of {command.operator}"
        self._by(what, COMMAND, words, command.operator)
        if command.order is not None:
            self._by(f"order in the {what}", MISSION if command.kind == "launch" else FORMATION, command.order, "")
            if command.order.signer != words.signer:
                self._refuse(what, "carries an order of another signer")
        if not self._orders.answered(command):
            self._once(what, command, words.signer, now_ns)
        return command, words

    def _once(self, what: str, command: Command, signer: str, now_ns: int) -> None:
        """Refused when it may have been said before."""
        orders = self._orders
        if command.boats and orders.boat not in command.boats:
            return
        if command.kind == "stop-now":
            if command.id in orders.released:
                self._refuse(what, "is a stop that was released: played again")
            return
        last_ns = orders.said.get(signer, 0)
        if command.stamp_ns <= last_ns:
            behind_s = (last_ns - command.stamp_ns) * 1e-9
            self._refuse(
                what, f"is {behind_s:.0f} s older than the last word of its signer: played again, or a clock set back"
            )
        off_ns = now_ns - command.stamp_ns
        if command.kind not in HARMLESS and abs(off_ns) > FRESH_NS + self._clock_ns() and self._disciplined():
            word = "old" if off_ns > 0 else "ahead of this boat's clock"
            self._refuse(what, f"is {abs(off_ns) * 1e-9:.0f} s {word}, at most {FRESH_NS * 1e-9:.0f}: played again?")

    def heeded(self, command: Command, words: Signed | None) -> None:
        """The command was answered: what is older is not obeyed from now on."""
        orders = self._orders
        if self.trust is None or words is None or (command.boats and orders.boat not in command.boats):
            return
        if command.kind == "stop-now":
            orders.keep_stop_words(command.id, words)
            return
        while len(orders.said) >= SIGNERS and words.signer not in orders.said:
            del orders.said[next(iter(orders.said))]
        orders.said[words.signer] = max(command.stamp_ns, orders.said.get(words.signer, 0))
        orders.changed = True

    def frames(self, payload: bytes, now_ns: int) -> Frames:
        """A ground station's frames for this boat's autopilot, each once; Refused when they must not go on."""
        words = _signed(payload) if self.trust is not None else None
        message = decode(words.body if words is not None else payload, Frames)
        if self.trust is None:
            return message
        if words is None:
            raise Refused("are not signed")
        what = f"frames of {message.operator}"
        self._by(what, FRAMES, words, message.operator)
        late = abs(now_ns - message.stamp_ns) > FRESH_NS and self._disciplined()
        if message.boat != self._orders.boat or message.stamp_ns <= self._framed_ns.get(words.signer, 0) or late:
            self._refuse(what, "are another boat's, or played again")
        if len(self._framed_ns) >= SIGNERS and words.signer not in self._framed_ns:
            del self._framed_ns[next(iter(self._framed_ns))]
        self._framed_ns[words.signer] = message.stamp_ns
        return message

    def may_control(self, operator: str) -> bool:
        """Whether a neighbour's word that this operator holds control can be true."""
        return self.trust is None or not operator or self.trust.has("operator", operator)

    # -- words that neighbours hand on -----------------------------------------------------------------------------
    def mission(self, words: Signed, boat: str, now_ns: int) -> None:
        """Refused unless an operator launched it, not too long ago."""
        if self.trust is None:
            return
        order = decode_mission_order(words)
        what = f"mission of {order.operator} from {boat}"
        self._by(what, MISSION, words, order.operator)
        if order.stamp_ns <= self._orders.newest_mission_ns():
            self._refuse(what, "is older than one that this boat held: played again?")
        if now_ns - order.stamp_ns > MISSION_FRESH_NS and self._disciplined():
            self._refuse(what, f"is more than {MISSION_FRESH_NS * 1e-9 / 3600:.0f} h old: launch it anew")

    def formation(self, words: Signed, boat: str) -> None:
        """Refused unless an operator said it, or a boat that closes up as the mission allows."""
        if self.trust is None:
            return
        order = decode_formation(words)
        by = order.revision.operator
        what = f"formation of {by} from {boat}"
        identity = self._signer(what, FORMATION, words)
        if identity[1] != by:
            self._refuse(what, f"is signed by {' '.join(identity)}")
        if identity[0] == "boat" and not self._closes_up(words, self._orders.sailing):
            self._refuse(what, "is a boat's, and more than closing up")
        if identity[0] not in ("operator", "boat"):
            self._refuse(what, f"is signed by a {identity[0]}, expected an operator")

    def _closes_up(self, words: Signed, sailing: Sailing | None) -> bool:
        """Whether a change only fills slots of boats that left, and the mission asks for that."""
        order = decode_formation(words)
        if sailing is None or sailing.plan.mission.formation.vacancies != "close-up":
            return False
        if order.revision.operator not in {boat.name for boat in sailing.plan.boats}:
            return False
        shape, pending = sailing.shape, sailing.pending
        now = (
            (pending.pattern, pending.spacing_m, pending.lateral_m, pending.cruise_mps)
            if pending is not None
            else (shape.pattern, shape.spacing_m, shape.lateral_m, shape.cruise_mps)
        )
        return (order.pattern, order.spacing_m, order.lateral_m, order.cruise_mps) == now

    def stop(self, words: Signed, boat: str) -> str:
        """The id of a stop that a neighbour hands on, '' when it is known; Refused unless an operator said it."""
        command = decode_command(words.body)
        orders = self._orders
        if command.id in orders.stops or command.id in orders.released:
            return ""
        what = f"stop of {command.operator} from {boat}"
        self._by(what, COMMAND, words, command.operator)
        if command.kind != "stop-now" or command.boats:
            self._refuse(what, f"is no stop of the whole fleet but {command.kind!r}")
        return command.id

    def _disciplined(self) -> bool:
        """Whether stamps can be held against this boat's clock."""
        return self.asks_age and self._clock_ns() <= DISCIPLINED_NS

    # -- who said it -----------------------------------------------------------------------------------------------
    def _by(self, what: str, purpose: str, words: Signed, operator: str) -> None:
        """Refused unless this operator of the roster said it; '': any."""
        role, name = self._signer(what, purpose, words)
        if role != "operator":
            self._refuse(what, f"is signed by {role} {name}: only operators command")
        if operator and name != operator:
            self._refuse(what, f"is signed by operator {name}")

    def _signer(self, what: str, purpose: str, words: Signed) -> tuple[str, str]:
        assert self.trust is not None
        if self._left <= 0:
            raise Refused("came with too many others at once; say it again")
        self._left -= 1
        try:
            identity = self.trust.signer(purpose, words)
        except Refused as refusal:
            self._say(what, str(refusal))
            raise
        return identity.role, identity.name

    def _refuse(self, what: str, why: str) -> None:
        self._say(what, why)
        raise Refused(why)

    def _say(self, what: str, why: str) -> None:
        """A line in the log and an event; the desk counts."""
        text = f"{what} {why}"[:300]
        now = time.monotonic()
        if now - self._said.get(text, -AGAIN_S) < AGAIN_S:
            return
        if len(self._said) >= SIGNERS:
            self._said.clear()
        self._said[text] = now
        log.warning("refused: %s", text, extra={"event": "refused"})
        self._orders.note("refused", text)


def _signed(payload: bytes) -> Signed | None:
    """The envelope of signed words; None where there is none."""
    try:
        return decode(payload, Signed)
    except Refused:
        return None
