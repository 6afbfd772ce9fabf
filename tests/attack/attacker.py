"""A station that means ill: it listens for a while, then publishes and asks at a steady rate, and says what came back.

    python -m tests.attack.attacker PLAN     one JSON object (Plan); prints one JSON object (Result)

Only on the network it is pointed at, only so many messages as it is told, then it ends.
"""

from __future__ import annotations

import contextlib
import math
import random
import sys
import time
from collections import Counter, deque
from collections.abc import Callable
from typing import Any

import msgspec
import zenoh
from msgspec import Struct, structs

from fleet.wire import keys
from fleet.wire.codec import Refused, decode, encode
from fleet.wire.link import LinkConfig
from fleet.wire.messages import MAJOR, Ack, BoatState, Command, FormationOrder, MissionOrder, Revision, Signed
from fleet.wire.zenoh_link import session_config
from tests.attack.imposters import until

BATCH_S = 0.01
ANSWER_S = 5.0
FLOATS = [field.name for field in structs.fields(BoatState) if field.type is float or field.type == "float"]
pack = msgspec.msgpack.encode


class Plan(Struct, frozen=True):
    """What to do."""

    connect: tuple[str, ...]
    fleet: str
    boats: tuple[str, ...]
    victim: str
    count: int
    rate_hz: float
    commands: list[bytes]  # of the operator, as recorded
    missions: list[bytes]  # that cannot be sailed, or not by this boat
    operator: str  # whose name stands in orders that are malformed
    seed: int = 1
    listen_s: float = 2.0
    ghosts: int = 150  # names with a liveliness token


class Result(Struct):
    """What was done, and what came back; by class of message."""

    sent: dict[str, int]
    on: dict[str, int]  # what was published, by boat on whose key; "*": on all keys at once
    answered: dict[str, int]
    obeyed: dict[str, int]  # acknowledged as done
    took_s: float


class Attacker:
    """See the module."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.rng = random.Random(plan.seed)
        self.session = zenoh.open(session_config("client", LinkConfig(topology="hub", connect=plan.connect)))
        self.recorded: dict[str, deque[bytes]] = {boat: deque(maxlen=400) for boat in plan.boats}
        self.last: dict[str, BoatState] = {}
        self.sent: Counter[str] = Counter()
        self.on: Counter[str] = Counter()
        self.answered: Counter[str] = Counter()
        self.obeyed: Counter[str] = Counter()
        self.kept: list[Any] = []
        self.questions = 0
        self.open: set[int] = set()  # questions that may still be answered
        for boat in plan.boats:
            self.kept.append(self.session.declare_subscriber(self._key(boat), self._listen(boat)))
        self.attacking = False
        self.number = 0

    def _key(self, boat: str, what: str = keys.STATE) -> str:
        return keys.key(self.plan.fleet, boat, what)

    def _listen(self, boat: str) -> Callable[[zenoh.Sample], None]:
        def take(sample: zenoh.Sample) -> None:
            with contextlib.suppress(Refused):
                payload = sample.payload.to_bytes()
                state = decode(payload, BoatState)
                last = self.last.get(boat)
                if not self.attacking:
                    self.recorded[boat].append(payload)
                    self.last[boat] = state
                elif last is not None and state.epoch == last.epoch and 0 < state.seq - last.seq < 5:
                    self.last[boat] = state  # the true ones, as far as an attacker can tell

        return take

    # -- states ------------------------------------------------------------------------------------------------------
    def old(self, boat: str) -> bytes:
        """A true state as it was recorded."""
        return self.rng.choice(self.recorded[boat])

    def next(self, of: str, **changes: Any) -> bytes:
        """The state that comes next, with lies in it."""
        state = self.last[of]
        return encode(structs.replace(state, seq=state.seq + 1, stamp_ns=state.stamp_ns + 10**8, **changes))

    def anew(self, of: str, **changes: Any) -> bytes:
        """As of a process just started."""
        state = self.last[of]
        epoch = self.rng.getrandbits(62)
        return encode(structs.replace(state, epoch=epoch, seq=1, stamp_ns=state.stamp_ns + 10**8, **changes))

    def truncated(self, boat: str) -> bytes:
        payload = self.old(boat)
        return payload[: self.rng.randrange(len(payload))]

    def random_bytes(self, _: str) -> bytes:
        return self.rng.randbytes(self.rng.randrange(1, 1000))

    def bit_flip(self, boat: str) -> bytes:
        payload = bytearray(self.old(boat) if self.rng.random() < 0.5 else encode(self.last[boat]))
        for _ in range(self.rng.randrange(1, 4)):
            payload[self.rng.randrange(len(payload))] ^= 1 << self.rng.randrange(8)
        return bytes(payload)

    def not_finite(self, boat: str) -> bytes:
        return self.next(boat, **{self.rng.choice(FLOATS): self.rng.choice((math.nan, math.inf, -math.inf))})

    def impossible(self, boat: str) -> bytes:
        lie = self.rng.choice(
            (
                "lat_deg:91",
                "lon_deg:-999",
                "sog_mps:400",
                "sog_mps:-1",
                "cog_rad:99",
                "s_m:1e300",
                "position_error_m:1e9",
            )
        )
        name, _, value = lie.partition(":")
        return self.next(boat, **{name: float(value)})

    def jump(self, boat: str) -> bytes:
        return self.next(boat, lat_deg=self.last[boat].lat_deg + self.rng.choice((0.001, 0.01, -1.0, 40.0)))

    def leap(self, boat: str) -> bytes:
        state = self.last[boat]
        return encode(structs.replace(state, seq=state.seq + self.rng.choice((30, 900, 10**6, 2**61))))

    def foreign_mission(self, boat: str) -> bytes:
        mission = f"{self.rng.randrange(10**9)}-mallory"
        if self.rng.random() < 0.5:
            return self.anew(boat, mission_id=mission)
        return encode(structs.replace(decode(self.old(boat), BoatState), mission_id=mission))

    def far_ahead(self, boat: str) -> bytes:
        ahead = Revision(self.rng.choice((500, 5000, 2**39)), "mallory")
        return self.anew(boat, held=ahead, in_force=ahead, control=ahead)

    def other_name(self, boat: str) -> bytes:
        name = self.rng.choice((*self.plan.boats, "", "x" * 32, "../../etc"))
        return self.next(boat, boat=name if name != boat else "nobody")

    def wrong_clock(self, boat: str) -> bytes:
        state = self.last[boat]
        stamp = self.rng.choice((0, -(10**18), state.stamp_ns + 10**18, 2**63 - 1, state.stamp_ns - 3600 * 10**9))
        if self.rng.random() < 0.5:
            return encode(structs.replace(state, stamp_ns=stamp))
        return encode(structs.replace(state, epoch=self.rng.getrandbits(62), seq=1, stamp_ns=stamp))

    def replay(self, boat: str) -> bytes:
        return self.old(boat)

    def replay_old_epoch(self, boat: str) -> bytes:
        state = decode(self.old(boat), BoatState)
        return encode(structs.replace(state, epoch=state.epoch - 3600 * 10**9, stamp_ns=state.stamp_ns - 600 * 10**9))

    def huge(self, _: str) -> bytes:
        return self.rng.randbytes(self.rng.choice((5_000, 50_000, 500_000)))

    def deep(self, _: str) -> bytes:
        return b"\x91" * self.rng.choice((1000, 4000))

    # -- commands ----------------------------------------------------------------------------------------------------
    def fresh_id(self) -> str:
        self.number += 1
        return f"mallory-{self.number}"

    def word(self, kind: str, operator: str = "mallory", **more: Any) -> bytes:
        return encode(Command(MAJOR, self.fresh_id(), operator, kind, (), **more))

    def rubbish(self) -> bytes:
        payload = bytearray(self.rng.choice(self.plan.commands))
        which = self.rng.randrange(3)
        if which == 0:
            return self.rng.randbytes(200)
        return bytes(payload[: self.rng.randrange(len(payload))]) if which == 1 else b"\x9a" + b"\x91" * 5000

    def said_again(self) -> bytes:
        return self.rng.choice(self.plan.commands)

    def said_otherwise(self) -> bytes:
        command = decode(self.rng.choice(self.plan.commands), Command)
        kind = self.rng.choice([kind for kind in ("hold", "abort", "stop-now", "return") if kind != command.kind])
        return encode(structs.replace(command, kind=kind, boats=(), order=None))

    def without_control(self) -> bytes:
        kind = self.rng.choice(("set", "resume", "return", "release", "forget", "launch", "scuttle"))
        return self.word(kind, names=self.plan.boats, text="nearest", order=Signed(self.rng.choice(self.plan.missions)))

    def malformed_order(self) -> bytes:
        mission = self.last[self.plan.victim].mission_id
        if self.rng.random() < 0.3:
            order = MissionOrder(
                MAJOR, self.fresh_id(), self.plan.operator, 0, self.rng.choice(self.plan.missions), 2.0
            )
            return self.word("launch", self.plan.operator, order=Signed(encode(order)))
        held = self.last[self.plan.victim].held
        one = Revision(held.counter + self.rng.choice((1, 5000)), self.plan.operator)
        value = self.rng.choice((math.nan, 1e308, -1e308, 0.0, 1.0))
        formation = FormationOrder(MAJOR, mission, one, held, value, self.rng.choice((math.inf, 400.0, -1.0)))
        body = self.rng.choice((encode(formation), b"", b"\x91" * 3000, self.rng.randbytes(100)))
        return self.word("set", self.plan.operator, order=Signed(body))

    def huge_words(self) -> bytes:
        long = "x" * self.rng.choice((300, 10_000, 100_000))
        return self.word(
            self.rng.choice(("set", long)), names=(long,), text=self.rng.choice(("", long)), mission_id=long
        )

    def other_operator(self) -> bytes:
        """Ever other names and ids, commands that only who holds control may give."""
        return self.word("return", f"op-{self.rng.randrange(10**6)}", text=str(self.number))

    # -- the attack --------------------------------------------------------------------------------------------------
    def publish(self, kind: str, boat: str, payload: bytes) -> None:
        """Put on a boat's state key."""
        self.sent[kind] += 1
        self.on[boat] += 1
        self.session.put(self._key(boat), payload, congestion_control=zenoh.CongestionControl.BLOCK)

    def ask(self, kind: str, what: str, payload: bytes) -> None:
        """Ask the victim, and take down the answer."""
        self.sent[kind] += 1

        def take(reply: zenoh.Reply) -> None:
            if reply.ok is None:
                return
            self.answered[kind] += 1
            if what == keys.COMMAND:
                with contextlib.suppress(Refused):
                    self.obeyed[kind] += decode(reply.ok.payload.to_bytes(), Ack).ok

        self.questions += 1
        number = self.questions
        self.open.add(number)
        until_over = zenoh.handlers.Callback(take, lambda: self.open.discard(number))
        self.session.get(self._key(self.plan.victim, what), until_over, payload=payload, timeout=ANSWER_S)

    def one(self) -> None:
        """One message, of any kind."""
        rng, boat = self.rng, self.rng.choice(self.plan.boats)
        name, make = rng.choice(self.menu)
        if name in ("deleted", "on all keys", "unknown boats"):
            self._odd(name, boat)
        elif name.startswith("ask "):
            self.ask(name, name.removeprefix("ask "), rng.randbytes(rng.choice((0, 20, 20_000))))
        elif make.__name__ in COMMANDS:
            self.ask(name, keys.COMMAND, make())
        else:
            self.publish(name, boat, make(boat))

    def _odd(self, name: str, boat: str) -> None:
        if name == "deleted":
            self.sent[name] += 1
            self.on[boat] += 1
            self.session.delete(self._key(boat), congestion_control=zenoh.CongestionControl.BLOCK)
        elif name == "on all keys":
            self.publish(name, "*", self.truncated(boat))
        else:
            ghost = f"g{self.rng.randrange(5000)}"
            self.sent[name] += 1
            self.session.put(self._key(ghost), self.next(boat, boat=ghost))

    def run(self) -> Result:
        """Listen, then attack."""
        time.sleep(self.plan.listen_s)
        live = self.session.liveliness()
        for i in range(self.plan.ghosts):
            self.kept.append(live.declare_token(self._key(f"ghost-{i}", keys.ALIVE)))
        for odd in ("*", "**", "UPPER", "x" * 40):
            with contextlib.suppress(zenoh.ZError):
                self.kept.append(live.declare_token(self._key(odd, keys.ALIVE)))
        time.sleep(0.5)
        self.attacking = True
        self.menu: list[tuple[str, Any]] = [
            (name, make) for name, make, weight in self._classes() for _ in range(weight)
        ]
        began = time.monotonic()
        done = 0
        while done < self.plan.count:
            due = min(self.plan.count, int((time.monotonic() - began) * self.plan.rate_hz) + 1)
            while done < due:
                self.one()
                done += 1
            time.sleep(BATCH_S)
        took_s = time.monotonic() - began
        until(lambda: not self.open, ANSWER_S + 1.0)
        result = Result(dict(self.sent), dict(self.on), dict(self.answered), dict(self.obeyed), took_s)
        self.session.close()  # type: ignore[no-untyped-call]
        return result

    def _classes(self) -> list[tuple[str, Any, int]]:
        return [
            ("cut short", self.truncated, 8),
            ("random bytes", self.random_bytes, 6),
            ("bits flipped", self.bit_flip, 10),
            ("NaN or infinite in one field", self.not_finite, 8),
            ("impossible values", self.impossible, 6),
            ("impossible jumps", self.jump, 6),
            ("sequence numbers far ahead", self.leap, 5),
            ("foreign mission ids", self.foreign_mission, 6),
            ("revisions far ahead", self.far_ahead, 4),
            ("other boats' names", self.other_name, 4),
            ("clocks from the future and the past", self.wrong_clock, 6),
            ("replays", self.replay, 8),
            ("replays of an older epoch", self.replay_old_epoch, 3),
            ("huge payloads", self.huge, 1),
            ("deeply nested", self.deep, 1),
            ("deleted", None, 1),
            ("on all keys", None, 1),
            ("unknown boats", None, 4),
            ("commands: rubbish", self.rubbish, 2),
            ("commands: replayed", self.said_again, 2),
            ("commands: old id, other content", self.said_otherwise, 2),
            ("commands: without control", self.without_control, 2),
            ("commands: malformed orders", self.malformed_order, 2),
            ("commands: huge words", self.huge_words, 1),
            ("commands: thousands of operators", self.other_operator, 2),
            ("ask mission", None, 1),
            ("ask formation", None, 1),
            ("ask echo", None, 2),
        ]


COMMANDS = (
    "rubbish",
    "said_again",
    "said_otherwise",
    "without_control",
    "malformed_order",
    "huge_words",
    "other_operator",
)


def main() -> None:
    """Attack as the plan in the file says."""
    with open(sys.argv[1], "rb") as file:
        plan = msgspec.msgpack.decode(file.read(), type=Plan)
    print(msgspec.json.encode(Attacker(plan).run()).decode(), flush=True)


if __name__ == "__main__":
    main()
