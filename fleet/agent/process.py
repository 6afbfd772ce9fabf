"""An agent as a process: from its configuration to a running loop, and to a clean end."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import threading
from collections.abc import Callable
from pathlib import Path

from fleet import __version__
from fleet.agent.agent import Agent
from fleet.agent.clock import SystemClock
from fleet.agent.config import AgentConfig
from fleet.agent.hardware import Converses, driver_of, parts, subscribe
from fleet.agent.loop import run
from fleet.agent.modes import Goal, in_words, mode_word
from fleet.agent.notify import Notifier
from fleet.agent.orders import encoded
from fleet.agent.scans import Outlook
from fleet.agent.store import Store, boot_id
from fleet.drivers.seam import Driver, Informed, PassesOn
from fleet.errors import FleetError
from fleet.mission.load import encode, load
from fleet.recording.seam import NullRecorder, Recording
from fleet.wire import keys, zenoh_log
from fleet.wire.bus import Bus
from fleet.wire.credentials.roster import words_of
from fleet.wire.credentials.trust import Trust
from fleet.wire.credentials.trust import load as load_trust
from fleet.wire.link import warning
from fleet.wire.messages import MAJOR, MissionOrder
from fleet.wire.radio import RadioBus
from fleet.wire.zenoh_bus import ZenohBus

log = logging.getLogger("fleet.agent")
NAME_AGAIN_S = 1.0
STALE_WALL_S = 0.25  # a busy machine may delay a simulated reading so long, whatever the warp
CLOCK_ASKED_NS = 10_000_000_000


def recorder_of(config: AgentConfig, stamp_ns: int) -> Recording:
    """The recording that the configuration asks for."""
    if config.record == "none":
        return NullRecorder()
    path = Path(config.record) if config.record else config.folder() / "recordings" / f"{stamp_ns}.mcap"
    path.parent.mkdir(parents=True, exist_ok=True)
    from fleet.recording.writer import Recorder

    return Recorder(path, {"boat": config.boat, "fleet": config.fleet, "version": __version__})


class Announcer:
    """Declares the boat alive once it is ready and nobody else is alive under its name; asks in a thread of its own."""

    def __init__(self, agent: Agent, bus: Bus) -> None:
        self._agent, self._bus = agent, bus
        self._stop = threading.Event()
        self._done = False
        self._thread = threading.Thread(target=self._run, name="announce", daemon=True)
        agent.may_speak = False

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.is_set():
            if not self._bus.open():
                self._stop.wait(0.02)
                continue
            alone = self._bus.alone_with_my_name()
            self._agent.name_taken = not alone
            if alone:
                self._bus.announce()
                self._agent.may_speak = True
                log.info("ready", extra={"event": "ready"})
                return
            log.warning("another boat is alive under this name: standing by", extra={"event": "name-taken"})
            self._stop.wait(NAME_AGAIN_S)

    def close(self) -> None:
        """End."""
        self._stop.set()


def sail_from_file(agent: Agent, where: str, now_ns: int) -> None:
    """Sail a mission file without an operator; FleetError when this boat cannot."""
    mission = load(where)
    order = MissionOrder(MAJOR, f"{now_ns}-file", "file", now_ns, encode(mission), 0.0)
    problem, sailing = agent.orders.read_mission(encoded(order), now_ns)
    if sailing is None:
        raise FleetError(f"{where}: {problem}")
    agent.orders.begin(sailing, Goal.FOLLOW)


def join(agent: Agent, driver: Driver) -> Callable[[], None]:
    """Lets a driver hear what operators order; what is returned lets them hear the driver, a tick at a time."""
    hardware_of, sensors = parts(driver)
    converses = hardware_of if isinstance(hardware_of, Converses) else None
    if converses is not None:
        agent.orders.obeyed = converses.obeyed

    passes = hardware_of if isinstance(hardware_of, PassesOn) and hardware_of.sysid else None
    agent.autopilot = passes
    navigates = sensors is not None and sensors.navigates
    agent.informed = hardware_of if navigates and isinstance(hardware_of, Informed) else None

    def listen() -> None:
        for text in converses.said() if converses is not None else ():
            agent.orders.note("autopilot", text)
        for text in sensors.noted() if sensors is not None else ():
            agent.orders.note("sensor", text)
        frames = passes.handed_on() if passes is not None else b""
        if frames:
            agent.bus.put(keys.MAVLINK, frames)

    return listen


def trust_of(config: AgentConfig) -> Trust | None:
    """The credentials that the configuration names; ConfigError when they cannot be used."""
    if not config.link.credentials:
        return None
    trust = load_trust(config.link.credentials, config.fleet, "boat", config.boat)
    log.info("credentials of %s, roster %d", words_of(trust.common_name), trust.roster.number, extra={"event": "trust"})
    if trust.warning():
        log.warning(trust.warning(), extra={"event": "trust"})
    return trust


def run_agent(config: AgentConfig, stop: threading.Event, ready: Callable[[Agent], None] = lambda agent: None) -> None:
    """Be one boat's agent until `stop`; FleetError when the configuration cannot work."""
    clock, manager = SystemClock(config.clock), Notifier()
    now_ns = clock.now_ns()
    open_to = warning(config.link)
    if open_to:
        log.warning(open_to, extra={"event": "insecure"})
    trust = trust_of(config)
    driver, world = driver_of(config, clock.now_ns)
    driver.open()
    network: Bus = ZenohBus(config.fleet, config.boat, config.link, clock.now_ns, trust)
    subscribe(driver, network)
    radio = RadioBus(network, config.boat, clock.now_ns, config.seed)
    agent = Agent(
        config.boat,
        radio,
        driver,
        Store(config.folder()),
        recorder_of(config, now_ns),
        now_ns,
        boot_id=config.boot_id or boot_id(),
        control_hz=config.control_hz,
        clock_ns=clock.error_ns() if config.clock_error_ms < 0.0 else int(config.clock_error_ms * 1e6),
        threaded=True,
        trust=trust,
    )
    agent.guard.asks_age = config.clock.warp == 1.0
    agent.links = zenoh_log.refusals.counts
    if open_to:
        agent.security = lambda: open_to
    agent.can_do(config.hull, config.limits)
    agent.lookout.outlook = Outlook(config.scans)
    listen = join(agent, driver)
    agent.stale_s = max(agent.stale_s, STALE_WALL_S * config.clock.warp)
    if config.mission:
        sail_from_file(agent, config.mission, now_ns)
    announcer = Announcer(agent, radio)
    ready(agent)
    announcer.start()

    def after_tick(now_ns: int) -> None:
        """What is done between two ticks, once this one's command is out."""
        if manager.listens:
            manager.whole_tick(agent.may_speak and agent.reading.stamp_ns > 0, in_a_line(agent))
        listen()
        for words in zenoh_log.refusals.fresh():
            agent.orders.note("refused", words)
        if (
            config.clock_error_ms < 0.0
            and now_ns // CLOCK_ASKED_NS != (now_ns - int(1e9 * agent.period_s)) // CLOCK_ASKED_NS
        ):
            agent.clock_ns = agent.picture.own_clock_ns = clock.error_ns()
        if world is None:
            return
        sensed = world.sensed
        radio.set(sensed.radio_delay_s, sensed.radio_loss)
        radio.set_down(sensed.radio_down)

    try:
        run(agent, clock, stop, slots=config.slots, after_tick=after_tick)
    finally:
        manager.ends()
        announcer.close()
        agent.close()


def in_a_line(agent: Agent) -> str:
    """What the boat does and why, for the service manager."""
    why = [*in_words(agent.reasons), *([agent.driver_trouble] if agent.driver_trouble else [])]
    if not agent.may_speak:
        why.insert(0, "not announced yet: " + ("its name is taken" if agent.name_taken else "no link"))
    mode = mode_word(int(agent.decision.mode))
    return f"{mode}: {', '.join(why)}" if why else mode


def end_on_signals(stop: threading.Event) -> None:
    """SIGTERM and SIGINT end the process in good order."""
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.set())


def end_with_parent(stop: threading.Event) -> None:
    """End when the pipe on stdin closes: a supervisor that was killed leaves nobody behind."""

    def watch() -> None:
        with contextlib.suppress(OSError):
            while os.read(0, 4096):
                pass
        stop.set()

    threading.Thread(target=watch, name="parent", daemon=True).start()
