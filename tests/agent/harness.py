"""A fleet in memory, in lock-step: real agents over the water of one process, a world as truth, a counter for a clock.

    sea = Sea(tmp_path, mission(boats=3))
    sea.launch()
    sea.run(60.0)

No wall clock, no sleeps, no network: a tick of all boats is one call, and the same calls give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from fleet.agent.agent import Agent
from fleet.agent.modes import Mode, Reason
from fleet.agent.step import Decision
from fleet.agent.store import Store
from fleet.drivers.seam import Reading
from fleet.mission.load import encode as encode_mission
from fleet.mission.model import (
    Battery,
    Boat,
    Fence,
    Formation,
    Geographic,
    KeepingClear,
    Lost,
    Mission,
    PathSpec,
    Polyline,
    Start,
    Straight,
)
from fleet.mission.plan import Plan, build
from fleet.recording.seam import MemoryRecorder, NullRecorder
from fleet.sim.world import World
from fleet.wire import keys
from fleet.wire.codec import decode, encode
from fleet.wire.credentials.trust import Trust
from fleet.wire.memory_bus import MemoryBus, Water
from fleet.wire.messages import (
    MAJOR,
    Ack,
    BoatState,
    BoatStatus,
    Command,
    FleetEvent,
    FormationOrder,
    MissionOrder,
    Revision,
    Signed,
)
from fleet.wire.radio import RadioBus

TICK_NS = 100_000_000
STEPS_A_TICK = 5
BEGIN_NS = 1_700_000_000_000_000_000
LEASE_NS = 2_000_000_000  # after which the others' network misses a station that went without a word
LINE = Straight(start=(0.0, 0.0), end=(1000.0, 0.0))
CIRCUIT = Polyline(points=((0.0, 0.0), (40.0, 0.0), (40.0, 30.0), (0.0, 30.0)), corner_radius_m=12.0, closed=True)
WIDE = Fence(points=((-300.0, -300.0), (1500.0, -300.0), (1500.0, 300.0), (-300.0, 300.0)))


def mission(
    boats: int = 3,
    spacing_m: float = 12.0,
    *,
    path: PathSpec = LINE,
    cruise_mps: float = 1.0,
    starts: Sequence[Start] = (),
    slots: Sequence[float] = (),
    lost: Lost | None = None,
    fence: Fence | None = WIDE,
    battery: Battery | None = None,
    title: str = "Boats in column on a line",
    method: str = "circle",  # the quicker one to compute; most tests are about other things
) -> Mission:
    """Boats b1, b2, ... in column, b1 foremost, already in their places."""
    places = [Start(s_m=100.0 - spacing_m * i, speed_mps=cruise_mps) for i in range(boats)]
    return Mission(
        title=title,
        datum=Geographic(lat_deg=44.38, lon_deg=8.93),
        paths={"path": path},
        boats=tuple(
            Boat(
                name=f"b{i + 1}",
                path="path",
                slot=slots[i] if slots else -float(i),
                start=starts[i] if i < len(starts) else places[i],
            )
            for i in range(boats)
        ),
        formation=Formation(spacing_m=spacing_m, cruise_mps=cruise_mps),
        duration_s=600.0,
        fence=fence,
        home=(0.0, -20.0),
        lost=lost or Lost(),
        battery=battery or Battery(),
        keeping_clear=KeepingClear(method=method),
    )


class MemoryDriver:
    """A boat in the world, driven by calls; see `fleet.drivers.seam.Driver`."""

    def __init__(self, station: Station, *, simulated: bool) -> None:
        self._station = station
        self.simulated = simulated
        self.spoil: Callable[[Reading], Reading] = lambda reading: reading
        self.refuses = ""  # what `write` says
        self.written: list[tuple[float, float]] = []
        self.neutrals = 0

    def open(self) -> None:
        """Nothing to connect."""

    def read(self) -> Reading:
        """What the sensors say, by the boat's own clock, spoilt as a test wants."""
        station = self._station
        reading = station.sea.world.sense(station.name)
        return self.spoil(msgspec.structs.replace(reading, stamp_ns=reading.stamp_ns + station.clock_offset_ns))

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command the hull."""
        self.written.append((surge_mps, yaw_rate_radps))
        if self.refuses:
            return self.refuses
        self._station.sea.world.command(self._station.name, True, surge_mps, yaw_rate_radps)
        return ""

    def neutral(self) -> None:
        """No thrust."""
        self.neutrals += 1
        self._station.sea.world.command(self._station.name, False, 0.0, 0.0)

    def close(self) -> None:
        """Nothing to disconnect."""


class Mooring(MemoryBus):
    """A boat's end of the water, which may lie in a part that hears no other; stamps by the boat's own clock."""

    def __init__(self, station: Station) -> None:
        super().__init__(station.sea.water, station.name)
        self._station = station

    def deposit_state(self, sender: str, payload: bytes, at_ns: int) -> None:
        """A state arrives, if it can."""
        if self._station.sea.joined(sender, self._station.name):
            super().deposit_state(sender, payload, at_ns + self._station.clock_offset_ns)

    def ask(self, boat: str, what: str, payload: bytes) -> None:
        """Ask a boat, if it can be reached."""
        if self._station.sea.joined(boat, self._station.name):
            super().ask(boat, what, payload)

    def alive(self) -> frozenset[str]:
        """Tokens that the network still keeps on this side."""
        sea = self._station.sea
        return frozenset(name for name in super().alive() if sea.token_kept(name, self._station.name))

    def operators(self) -> frozenset[str]:
        """Operators on this side."""
        sea = self._station.sea
        there = (name for name, part in sea.operators.items() if part in (None, sea.parts.get(self._station.name, 0)))
        return frozenset(there) if self.link_up() else frozenset()


class Station:
    """One boat: its agent, and everything that outlives it."""

    def __init__(self, sea: Sea, name: str, *, simulated: bool, clock_ns: int) -> None:
        self.sea, self.name, self.clock_ns = sea, name, clock_ns
        self.folder = sea.folder / name
        self.clock_offset_ns = 0
        self.boot_id = "boot-1"
        self.driver = MemoryDriver(self, simulated=simulated)
        self.frozen = False
        self.quiet_ns = 0  # since when the network hears nothing of it
        self.starts = 0
        self.agent: Agent | None = None
        self.bus: Mooring | None = None
        self.radio: RadioBus | None = None
        self.recorder: MemoryRecorder | NullRecorder = NullRecorder()
        self.history: list[Decision[float]] = []

    def now_ns(self) -> int:
        """The boat's own clock."""
        return self.sea.now_ns + self.clock_offset_ns

    def switch_on(self, *, announce: bool = True) -> None:
        """A new process."""
        self.starts += 1
        self.bus = Mooring(self)
        self.radio = RadioBus(self.bus, self.name, self.now_ns, self.sea.seed)
        self.radio.set(self.sea.delay_s, self.sea.loss)
        self.recorder = MemoryRecorder() if self.sea.record else NullRecorder()
        self.agent = Agent(
            self.name,
            self.radio,
            self.driver,
            Store(self.folder, threaded=False),
            self.recorder,
            self.now_ns() + self.starts,
            boot_id=self.boot_id,
            clock_ns=self.clock_ns,
            trust=self.sea.trust(self.name) if self.sea.trust is not None else None,
        )
        self.quiet_ns = 0
        if announce:
            self.bus.open()
            self.bus.announce()


class Sea:
    """A fleet in memory."""

    def __init__(
        self,
        folder: Path,
        what: Mission | None = None,
        *,
        delay_s: float = 0.0,
        loss: float = 0.0,
        seed: int = 0,
        real: bool = False,
        clock_ns: int = 50_000_000,
        record: bool = False,
        ashore: Iterable[str] = (),
        trust: Callable[[str], Trust] | None = None,
        signers: Mapping[str, Trust] | None = None,
    ) -> None:
        self.trust, self.signers = trust, dict(signers or {})  # credentials of boats, and of operators
        self.folder, self.seed, self.delay_s, self.loss, self.record = folder, seed, delay_s, loss, record
        self.mission = what if what is not None else mission()
        self.plan: Plan = build(self.mission)
        self.now_ns = BEGIN_NS
        self.world = World(self.plan, BEGIN_NS, seed)
        self.water = Water(lambda: self.now_ns)
        self.operators: dict[str, int | None] = {"anna": None}  # name -> part of the water, None: everywhere
        self.parts: dict[str, int] = {}  # boat -> part of the water, when it is divided
        self.parted_ns = 0
        self.events: list[tuple[float, FleetEvent]] = []
        self.states: dict[str, BoatState] = {}
        self.raw: dict[str, bytes] = {}
        self.statuses: dict[str, BoatStatus] = {}
        self.each_tick: list[Callable[[], None]] = []
        self.ids = 0
        self.stations: dict[str, Station] = {}
        self.least_m = float("inf")  # nearest that two hulls ever came
        for boat in self.plan.boats:
            station = self.stations[boat.name] = Station(self, boat.name, simulated=not real, clock_ns=clock_ns)
            if boat.name not in ashore:
                station.switch_on()

    # -- looking ---------------------------------------------------------------------------------------------------
    @property
    def time_s(self) -> float:
        """Since the beginning."""
        return (self.now_ns - BEGIN_NS) * 1e-9

    def agent(self, boat: str) -> Agent:
        """The boat's running agent."""
        agent = self.stations[boat].agent
        assert agent is not None
        return agent

    def agents(self) -> dict[str, Agent]:
        """Those that run."""
        return {name: s.agent for name, s in self.stations.items() if s.agent is not None}

    def mode(self, boat: str) -> Mode:
        """What it does."""
        return Mode(int(self.agent(boat).decision.mode))

    def modes(self) -> list[Mode]:
        """What they all do."""
        return [self.mode(name) for name in self.agents()]

    def reasons(self, boat: str) -> Reason:
        """Why."""
        return self.agent(boat).reasons

    def says(self, boat: str, kind: str) -> list[str]:
        """Texts of its events of one kind."""
        return [event.text for _, event in self.events if event.boat == boat and event.kind == kind]

    def members(self, boat: str) -> int:
        """How many boats count in its formation."""
        agent = self.agent(boat)
        return sum(other.weight > 0.0 for other in agent.picture.others.values())

    def spacing(self, boat: str) -> float:
        """Of the formation in force."""
        sailing = self.agent(boat).orders.sailing
        assert sailing is not None
        return sailing.formation.spacing_m

    def revision(self, boat: str) -> Revision:
        """Of the formation in force."""
        sailing = self.agent(boat).orders.sailing
        assert sailing is not None
        return sailing.formation.revision

    def holds_mission(self, boat: str) -> bool:
        """Whether it has one."""
        return self.agent(boat).orders.sailing is not None

    def speed(self, boat: str) -> float:
        """True surge [m/s]."""
        return self.world.ships[boat].state.u

    def where(self, boat: str) -> tuple[float, float]:
        """True position [m]."""
        state = self.world.ships[boat].state
        return state.x, state.y

    def powered(self, boat: str) -> bool:
        """Whether its thrusters are driven."""
        return self.world.ships[boat].powered > 0.5

    # -- who hears whom --------------------------------------------------------------------------------------------
    def joined(self, one: str, two: str) -> bool:
        """Whether they lie in the same part of the water."""
        return self.parts.get(one, 0) == self.parts.get(two, 0)

    def token_kept(self, name: str, listener: str) -> bool:
        """A token lives on for a lease after its station fell silent."""
        station = self.stations.get(name)
        if not self.joined(name, listener) and self.now_ns - self.parted_ns >= LEASE_NS:
            return False
        return station is None or not station.quiet_ns or self.now_ns - station.quiet_ns < LEASE_NS

    def divide(self, *parts: Iterable[str]) -> None:
        """Boats of different parts do not hear each other; without parts all is one again."""
        self.parts = {boat: number for number, part in enumerate(parts) for boat in part}
        self.parted_ns = self.now_ns

    def cut(self, boat: str) -> None:
        """The boat's radio is dead."""
        station = self.stations[boat]
        assert station.radio is not None
        station.radio.set_down(True)
        station.quiet_ns = self.now_ns

    def mend(self, boat: str) -> None:
        """The boat's radio works again."""
        station = self.stations[boat]
        assert station.radio is not None
        station.radio.set_down(False)
        station.quiet_ns = 0

    # -- processes -------------------------------------------------------------------------------------------------
    def kill(self, boat: str) -> None:
        """kill -9: nothing is said, nothing is written; the token goes with the socket, the hull drifts on."""
        station = self.stations[boat]
        self.water.boats.pop(boat, None)
        self.water.tokens.discard(boat)
        station.agent = station.bus = station.radio = None

    def restart(self, boat: str, *, boot_id: str | None = None, after_s: float = 0.0) -> None:
        """A new process on the same disk."""
        if self.stations[boat].agent is not None:
            self.kill(boat)
        self.run(after_s)
        if boot_id is not None:
            self.stations[boat].boot_id = boot_id
        self.stations[boat].switch_on()

    def freeze(self, boat: str) -> None:
        """SIGSTOP."""
        self.stations[boat].frozen = True
        self.stations[boat].quiet_ns = self.now_ns

    def thaw(self, boat: str) -> None:
        """SIGCONT."""
        self.stations[boat].frozen = False
        self.stations[boat].quiet_ns = 0

    # -- time ------------------------------------------------------------------------------------------------------
    def tick(self) -> None:
        """A tenth of a second passes; every boat ticks once, in the order of the roster."""
        for _ in range(STEPS_A_TICK):
            self.world.step()
        self.now_ns += TICK_NS
        for station in self.stations.values():
            if station.agent is not None and not station.frozen:
                station.agent.tick(station.now_ns())
                station.history.append(station.agent.decision)
        self._collect()
        ships = [ship.state for ship in self.world.ships.values()]
        for i, a in enumerate(ships):
            for b in ships[:i]:
                self.least_m = min(self.least_m, ((a.x - b.x) ** 2 + (a.y - b.y) ** 2) ** 0.5)
        for look in self.each_tick:
            look()

    def _collect(self) -> None:
        for what, boat, payload in self.water.published:
            if what == keys.STATE:
                self.raw[boat] = payload
                self.states.pop(boat, None)
            elif what == keys.STATUS:
                self.statuses[boat] = decode(payload, BoatStatus)
            elif what == keys.EVENT:
                self.events.append((self.time_s, decode(payload, FleetEvent)))
        self.water.published.clear()

    def state(self, boat: str) -> BoatState:
        """What it published last."""
        if boat not in self.states:
            self.states[boat] = decode(self.raw[boat], BoatState)
        return self.states[boat]

    def run(self, seconds: float) -> None:
        """So much time passes."""
        for _ in range(round(seconds * 10.0)):
            self.tick()

    def run_until(self, condition: Callable[[], Any], at_most_s: float) -> float:
        """Time passes until the condition holds; how long it took [s]."""
        began = self.time_s
        while not condition():
            assert self.time_s - began < at_most_s, f"not within {at_most_s} s: {self.modes()}"
            self.tick()
        return self.time_s - began

    # -- operators -------------------------------------------------------------------------------------------------
    def ask(
        self,
        kind: str,
        *,
        operator: str = "anna",
        boats: Sequence[str] = (),
        order: Signed | None = None,
        names: Sequence[str] = (),
        text: str = "",
        command_id: str = "",
        mission_id: str = "",
    ) -> dict[str, Ack]:
        """Say something to every boat in reach; the answers appear in the result as the boats tick."""
        self.ids += 1
        command = Command(
            MAJOR,
            command_id or f"c{self.ids}",
            operator,
            kind,
            tuple(boats),
            order,
            tuple(names),
            text,
            mission_id,
            self.now_ns,
        )
        words = self.sign("command", encode(command), operator)
        return self.ask_raw(encode(words) if words.signature else words.body, operator)

    def sign(self, purpose: str, body: bytes, operator: str) -> Signed:
        """Words of an operator, signed if it has credentials."""
        signer = self.signers.get(operator)
        return signer.sign(purpose, body) if signer is not None else Signed(body)

    def ask_raw(self, payload: bytes, operator: str = "anna", what: str = keys.COMMAND) -> dict[str, Ack]:
        """Bytes, as an operator's."""
        answers: dict[str, Ack] = {}
        part = self.operators.get(operator)
        for name, bus in list(self.water.boats.items()):
            if part is not None and part != self.parts.get(name, 0):
                continue

            def take(answer: bytes, name: str = name) -> None:
                assert name not in answers, "answered twice"
                answers[name] = decode(answer, Ack)

            bus.deposit_request(what, payload, take)
        return answers

    def command(self, kind: str, **more: Any) -> dict[str, Ack]:
        """Say something, and let the boats tick once."""
        answers = self.ask(kind, **more)
        self.tick()
        return answers

    def mission_words(
        self, what: Mission | None = None, *, operator: str = "anna", apply_in_s: float = 2.0, mission_id: str = ""
    ) -> Signed:
        """A launch as its operator wrote it."""
        order = MissionOrder(
            MAJOR,
            mission_id or f"{self.now_ns}-{operator}",
            operator,
            self.now_ns,
            encode_mission(what or self.mission),
            apply_in_s,
        )
        return self.sign("mission", encode(order), operator)

    def launch(self, what: Mission | None = None, *, operator: str = "anna", apply_in_s: float = 2.0) -> dict[str, Ack]:
        """Give the boats their mission."""
        words = self.mission_words(what, operator=operator, apply_in_s=apply_in_s)
        return self.command("launch", operator=operator, order=words)

    def change(
        self,
        *,
        spacing_m: float | None = None,
        cruise_mps: float | None = None,
        operator: str = "anna",
        of: str | None = None,
        counter: int | None = None,
        based_on: Revision | None = None,
        apply_in_s: float = 2.0,
        mission_id: str | None = None,
        boats: Sequence[str] = (),
        signer: str | None = None,
    ) -> dict[str, Ack]:
        """Change the formation, as based on what boat `of` (or the first that holds a mission) holds."""
        source = of or next(n for n, a in self.agents().items() if a.orders.sailing is not None)
        sailing = self.agent(source).orders.sailing
        assert sailing is not None
        held = sailing.pending or sailing.formation
        base = based_on if based_on is not None else held.revision
        order = FormationOrder(
            MAJOR,
            mission_id if mission_id is not None else sailing.order.mission_id,
            Revision(counter if counter is not None else base.counter + 1, signer or operator),
            base,
            spacing_m if spacing_m is not None else held.spacing_m,
            cruise_mps if cruise_mps is not None else held.cruise_mps,
            apply_in_s,
            self.now_ns,
        )
        return self.command(
            "set", operator=operator, order=self.sign("formation", encode(order), operator), boats=boats
        )

    # -- strangers -------------------------------------------------------------------------------------------------
    def say_as(self, name: str, payload: bytes, to: Iterable[str] | None = None) -> None:
        """Put a state on a boat's key, as anybody could."""
        for boat, bus in list(self.water.boats.items()):
            if to is None or boat in to:
                MemoryBus.deposit_state(bus, name, payload, self.now_ns + self.stations[boat].clock_offset_ns)


def forged(state: BoatState, **changes: Any) -> bytes:
    """The state with other values, as bytes."""
    return encode(msgspec.structs.replace(state, **changes))


def sailing(folder: Path, what: Mission | None = None, seconds: float = 10.0, **more: Any) -> Sea:
    """A fleet that was launched and has been under way for a while."""
    sea = Sea(folder, what, **more)
    sea.run(0.5)
    acks = sea.launch()
    assert all(ack.ok for ack in acks.values()), acks
    sea.run(seconds)
    return sea
