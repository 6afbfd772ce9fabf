"""Every wrong kind of credentials against live agents: what came of it, and the line of the log that names it.

    python -m tests.attack.credentials [--topology hub|routed] [--transport tls|quic]       all four without

Two boats stand by, their agents real, over TLS or QUIC, through a hub or each a router. Nothing of what is said to them
may be obeyed, except the last: the launch of their operator.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, NamedTuple

from msgspec import structs

from fleet.agent.clock import ClockSpec
from fleet.mission.load import encode as encode_mission
from fleet.mission.load import load
from fleet.operator import Fleet
from fleet.sim import passes
from fleet.sim.processes import Processes
from fleet.wire import keys
from fleet.wire.codec import decode, encode
from fleet.wire.credentials import authority
from fleet.wire.credentials.trust import load as load_trust
from fleet.wire.messages import MAJOR, Ack, BoatState, Command, MissionOrder, Signed
from tests.attack.imposters import connects, imposter, until

FLEET, BOATS = "sim", ("b1", "b2")
ROGUE, REVOKED, EXPIRED, STRANGER = "rogue", "revoked", "expired", "stranger"
OPERATOR = "anna"
Topology = Literal["hub", "routed"]
PATIENCE_S = 15.0


class Row(NamedTuple):
    """One attack."""

    attack: str
    obeyed: bool
    line: str  # of a log, that names it; "" for none


class Yard:
    """The fleet, its folders and its logs."""

    def __init__(self, folder: Path, topology: Topology, transport: passes.Transport) -> None:
        self.folder, self.topology = folder, topology
        self.place = passes.found(folder / "credentials", FLEET, BOATS, OPERATOR)
        founded = authority.load(self.place)
        now = time.time()
        founded.issue("boat", ROGUE, now)
        founded.issue("boat", REVOKED, now)
        founded.revoke(REVOKED, now)
        founded.issue("boat", EXPIRED, now - 86400.0, days=0.5)
        stations = Path(shutil.copytree(self.place, folder / "stations"))  # as copied to their machines
        self.other = authority.create(folder / "other", FLEET, now)
        self.other.issue("boat", STRANGER, now)
        mission = folder / "mission.bin"
        self.mission = load("overtaking")
        mission.write_bytes(encode_mission(self.mission))
        spec = ClockSpec()
        self.processes = Processes(
            folder,
            spec,
            BOATS,
            fleet=FLEET,
            topology=topology,
            seed=0,
            record=False,
            credentials=stations,
            transport=transport,
        )
        self.processes.start_hub()
        self.processes.start_world(mission)
        for boat in BOATS:
            self.processes.start_agent(boat)
        self.at = self.processes.connect[0]
        self.fleet = Fleet(FLEET, connect=self.processes.connect, credentials=self.place / OPERATOR, timeout_s=5.0)
        self.said: list[bytes] = []  # commands of the operator, as they went

    def states(self) -> list[BoatState]:
        """The boats' newest."""
        views = self.fleet.look()
        found = [views[boat].state for boat in BOATS if boat in views]
        return [state for state in found if state is not None]

    def b1(self) -> BoatState:
        """One of them."""
        return self.states()[0]

    def speak_again(self) -> None:
        """Every boat has published two more states: what came to it before shows in the second."""
        before = {state.boat: (state.epoch, state.seq + 2) for state in self.states()}
        later = until(lambda: all((s.epoch, s.seq) >= before[s.boat] for s in self.states()), PATIENCE_S)
        assert later, "the boats fell silent"

    def untouched(self) -> bool:
        """The boats stand by, hold no mission, know no stop, obey nobody."""
        self.speak_again()
        return all(not s.mission_id and not s.stops and s.control.operator == "" for s in self.states())

    def line(self, pattern: str, patience_s: float = 3.0) -> str:
        """The first line of a log that has it."""
        found: list[str] = []

        def there() -> bool:
            for log in sorted((self.folder / "logs").glob("*.log")):
                found.extend(
                    f"{log.stem}: {text[1]}"
                    for text in re.finditer(r'"text": "((?:[^"\\]|\\.)*)"', log.read_text(encoding="utf-8"))
                    if re.search(pattern, text[1])
                )
            return bool(found)

        until(there, patience_s)
        return found[0] if found else ""


@contextmanager
def yard(folder: Path, topology: Topology, transport: passes.Transport) -> Iterator[Yard]:
    """A fleet that waits, until the end."""
    one = Yard(folder, topology, transport)
    try:
        with one.fleet:
            missing = one.fleet.wait_for(BOATS, 30.0)
            assert not missing, f"{missing} not ready: see {folder}/logs"
            yield one
    finally:
        one.processes.close()


# -- who does not get in -----------------------------------------------------------------------------------------------
def strangers(yard: Yard) -> Iterator[Row]:
    """No session at all."""
    other = yard.folder / "other" / STRANGER
    got_in = connects(yard.at, other, yard.place)
    yield Row(
        "a stranger: certificate of another authority", got_in, yard.line("a stranger: .*(UnknownIssuer|BadSignature)")
    )
    got_in = connects(yard.at, other, yard.place, shows=False)
    yield Row("a stranger: no certificate", got_in, yard.line("a stranger: peer sent no certificates"))
    got_in = connects(yard.at, yard.place / EXPIRED, yard.place)
    yield Row("a boat whose certificate expired", got_in, yard.line(r"a stranger: .*certificate: expired \d"))
    got_in = connects(yard.at.replace("tls/", "tcp/").replace("quic/", "udp/"), other, yard.place)
    yield Row("a stranger: plain, without TLS", got_in, "no such transport: no session, no line")


def revoked(yard: Yard) -> Iterator[Row]:
    """A session, and nothing passes."""
    with imposter(FLEET, REVOKED, yard.at, yard.place / REVOKED, yard.place) as one:
        heard = one.hears("b1", keys.STATE)
        answered = one.asks("b1", keys.COMMAND, command("stop-now"))
        one.lives()
        one.sails(yard.b1, 0.5, lambda: False, stops=("all-revoked",))
        seen = REVOKED in yard.fleet.look()
        obeyed = heard or bool(answered) or seen or not yard.untouched()
    yield Row("a revoked boat: listens, commands, publishes", obeyed, yard.line(rf"boat {REVOKED} \(\w+\), revoked"))


# -- a member of the fleet that lies -----------------------------------------------------------------------------------
def as_another(yard: Yard) -> Iterator[Row]:
    """On another boat's key."""
    forged = structs.replace(yard.b1(), boat="b2", epoch=time.time_ns(), seq=1, stops=("all-forged",))
    heard: list[BoatState] = []
    with imposter(FLEET, ROGUE, yard.at, yard.place / ROGUE, yard.place) as one:
        for _ in range(5):
            one.puts("b2", keys.STATE, encode(structs.replace(forged, stamp_ns=time.time_ns())))
            yard.speak_again()
            heard += [state for state in yard.states() if state.epoch == forged.epoch]
    obeyed = bool(heard) or not yard.untouched()
    yield Row("a boat publishes as another", obeyed, yard.line(rf"boat {ROGUE} \(\w+\) may not put fleet/sim/b2/state"))


def commands(yard: Yard) -> Iterator[Row]:
    """Asked of b1 by a boat: unsigned, signed by itself, signed in the operator's name."""
    rogue = load_trust(yard.place / ROGUE, FLEET, "boat")
    anna = load_trust(yard.place / OPERATOR, FLEET, "operator")
    wrong = {
        "unsigned, in the operator's name": (command("abort"), rf"abort of {OPERATOR} is not signed"),
        "signed by itself": (
            encode(rogue.sign("command", command("abort"))),
            rf"abort of {OPERATOR} is signed by boat {ROGUE}: only operators command",
        ),
        "signed by itself, in the operator's name": (
            encode(structs.replace(rogue.sign("command", command("hold")), signer=anna.common_name)),
            rf"hold of {OPERATOR} does not bear the signature of operator {OPERATOR}",
        ),
    }
    with imposter(FLEET, ROGUE, yard.at, yard.place / ROGUE, yard.place) as one:
        for name, (payload, words) in wrong.items():
            answers = [decode(answer, Ack) for answer in one.asks("b1", keys.COMMAND, payload)]
            obeyed = any(answer.ok for answer in answers) or not yard.untouched()
            at_hub = rf"boat {ROGUE} \(\w+\) may not query fleet/sim/b1/command"
            yield Row(f"a boat commands: {name}", obeyed, yard.line(at_hub if yard.topology == "hub" else words))


def altered(yard: Yard) -> Iterator[Row]:
    """A boat hands on what its operator did not say so."""
    anna = load_trust(yard.place / OPERATOR, FLEET, "operator")
    rogue = load_trust(yard.place / ROGUE, FLEET, "boat")
    stamp = time.time_ns()
    true = MissionOrder(MAJOR, f"{stamp}-{OPERATOR}", OPERATOR, stamp, encode_mission(yard.mission), 2.0)
    signed = anna.sign("mission", encode(true))
    fast = structs.replace(yard.mission.formation, cruise_mps=1.2)
    body = encode(structs.replace(true, mission=encode_mission(structs.replace(yard.mission, formation=fast))))
    what = f"mission of {OPERATOR} from {ROGUE}"
    wrong = {
        "altered": (structs.replace(signed, body=body), rf"{what} does not bear the signature of operator {OPERATOR}"),
        "signed by the boat": (rogue.sign("mission", encode(true)), rf"{what} is signed by boat {ROGUE}"),
        "not signed": (Signed(encode(true)), f"{what} is not signed"),
    }
    for name, (words, pattern) in wrong.items():
        with imposter(FLEET, ROGUE, yard.at, yard.place / ROGUE, yard.place) as one:
            one.holds(words)
            one.lives()
            one.sails(yard.b1, PATIENCE_S, lambda p=pattern: bool(yard.line(p, 0.0)), mission_id=true.mission_id)  # type: ignore[misc]
            yield Row(f"a boat hands on a mission: {name}", not yard.untouched(), yard.line(pattern))


def stops(yard: Yard) -> Iterator[Row]:
    """A boat says that the operator stopped the fleet."""
    rogue = load_trust(yard.place / ROGUE, FLEET, "boat")
    forged = rogue.sign("command", command("stop-now", "all-"))
    with imposter(FLEET, ROGUE, yard.at, yard.place / ROGUE, yard.place) as one:
        one.knows_stops(forged)
        one.lives()
        pattern = rf"stop of {OPERATOR} from {ROGUE} is signed by boat {ROGUE}"
        one.sails(yard.b1, PATIENCE_S, lambda: bool(yard.line(pattern, 0.0)), stops=("all-forged",))
        yield Row("a boat hands on a stop that nobody said", not yard.untouched(), yard.line(pattern))


def replayed(yard: Yard) -> Iterator[Row]:
    """Words that the operator did say, said again by a boat that relayed them; b1 was started anew in between."""
    anna = load_trust(yard.place / OPERATOR, FLEET, "operator")
    old = encode(anna.sign("command", command("take", stamp_ns=time.time_ns() - 1_000_000)))
    yard.fleet.hold()
    yard.processes.signal("b1", 9)
    yard.processes.start_agent("b1")
    until(lambda: "b1" not in yard.fleet.look() or not yard.fleet.boats["b1"].alive, 5.0)
    assert not yard.fleet.wait_for(("b1",), 30.0)
    with imposter(FLEET, ROGUE, yard.at, yard.place / ROGUE, yard.place) as one:
        answers = [decode(answer, Ack) for answer in one.asks("b1", keys.COMMAND, old)]
        obeyed = any(answer.ok for answer in answers) or not yard.untouched()
    words = "older than the last word" if yard.topology == "routed" else rf"boat {ROGUE} .* may not query"
    yield Row("a boat plays an operator's word again, after a restart", obeyed, yard.line(words))


def revoked_under_way(yard: Yard) -> Iterator[Row]:
    """A member of the fleet until its operator brings another roster."""
    with imposter(FLEET, ROGUE, yard.at, yard.place / ROGUE, yard.place) as one:
        assert one.hears("b1", keys.STATE), "a boat of the fleet reads its peers"
        authority.load(yard.place).revoke(ROGUE, time.time())
        with Fleet(FLEET, connect=yard.processes.connect, credentials=yard.place / OPERATOR, timeout_s=5.0) as fleet:
            began = time.monotonic()
            brought = fleet.send_roster()
        until(lambda: not one.hears("b1", keys.STATE), PATIENCE_S)
        took = time.monotonic() - began
        yard.speak_again()
        obeyed = not set(BOATS) <= set(brought.acknowledged) or one.hears("b1", keys.STATE) or not yard.untouched()
    yield Row(f"a boat revoked under way: {took:.0f} s", obeyed, yard.line(rf"boat {ROGUE} \(\w+\), revoked at", 8.0))


def operator(yard: Yard) -> Iterator[Row]:
    """And the fleet still obeys whom it should."""
    assert not yard.fleet.wait_for(BOATS, PATIENCE_S)
    outcome = yard.fleet.launch(yard.mission)
    sails = until(lambda: all(state.mission_id for state in yard.states()), PATIENCE_S)
    yield Row("the operator launches", outcome.ok and sails, "; ".join(outcome.lines()))


ATTACKS: tuple[Callable[[Yard], Iterator[Row]], ...] = (
    strangers,
    revoked,
    as_another,
    commands,
    altered,
    stops,
    replayed,
    revoked_under_way,
    operator,
)


def command(kind: str, begins: str = "", stamp_ns: int = 0) -> bytes:
    """A command in the operator's name."""
    words = Command(
        MAJOR, begins + uuid.uuid4().hex, OPERATOR, kind, () if begins else ("b1",), stamp_ns=stamp_ns or time.time_ns()
    )
    return encode(words)


def attack(folder: Path, topology: Topology, transport: passes.Transport) -> list[Row]:
    """All of them."""
    with yard(folder, topology, transport) as one:
        return [row for kind in ATTACKS for row in kind(one)]


def main(argv: list[str] | None = None) -> int:
    """The table; 1 when something was obeyed, or not named."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--topology", choices=("hub", "routed"))
    parser.add_argument("--transport", choices=("tls", "quic"))
    given = parser.parse_args(argv)
    wrong = 0
    for topology in (given.topology,) if given.topology else ("hub", "routed"):
        for transport in (given.transport,) if given.transport else ("tls", "quic"):
            folder = Path(tempfile.mkdtemp(prefix="fleet-credentials-"))
            print(f"\n{topology} over {transport}")
            for row in attack(folder, topology, transport):
                good = row.attack == "the operator launches"
                wrong += row.obeyed != good or not row.line
                print(f"  {row.attack:<55} {'obeyed' if row.obeyed else 'refused':<8} {row.line or 'NO LINE'}")
            shutil.rmtree(folder)
    print(f"\n{wrong} wrong" if wrong else "\nnone obeyed, each named")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
