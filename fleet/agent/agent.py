"""One boat's agent: everything around `step`, a tick at a time. Time, bus, driver and disk are handed in.

The same class runs in a boat's process (`loop`), and in a lock-step simulation; whatever it decides by itself enters
`step` as numbers.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable

from msgspec import structs

from fleet import __version__
from fleet.agent import course as courses
from fleet.agent.abroad import Sea
from fleet.agent.background import Background
from fleet.agent.company import Company
from fleet.agent.course import Course, Track
from fleet.agent.guard import Guard
from fleet.agent.lookout import Lookout
from fleet.agent.modes import Goal, Reason
from fleet.agent.orders import Orders
from fleet.agent.picture import Picture
from fleet.agent.report import Reporter
from fleet.agent.resume import Resumption
from fleet.agent.route import Route
from fleet.agent.sailing import Sailing
from fleet.agent.sensors import nav_of, sensors_of
from fleet.agent.serve import Desk
from fleet.agent.step import Decision, Nav, Order, State, StepParams, start, step
from fleet.agent.store import Store
from fleet.agent.troubles import Circumstances, Troubles
from fleet.agent.vacancies import Vacancies
from fleet.agent.why import Why
from fleet.agent.wing import Wings
from fleet.avoidance import METHODS, Method
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.types import Peer
from fleet.drivers.seam import Driver, Informed, PassesOn, Reading
from fleet.geo import Datum, Plane, plane_of
from fleet.guidance import FollowParams, Limits, StationParams
from fleet.guidance.limits import OwnLimits, within
from fleet.mission.model import KeepingClear
from fleet.mission.plan import Plan
from fleet.recording.seam import Recording
from fleet.sensing import fusion
from fleet.wire.bus import Bus
from fleet.wire.credentials.trust import Trust
from fleet.wire.messages import FormationOrder

NAVIGATION_STALE_S = 1.0
STATES_A_TICK = 256  # of one sender
MOST_STRANGERS = 100  # boats listened to that are not of the own mission
SAVE_S = 1.0
DRIVER_AGAIN_S = 1.0
LONGEST_TICK_S = 1.0

ZERO_DECISION: Decision[float] = Decision(
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0
)


def tuning(clear: KeepingClear, limits: Limits, plan: Plan | None = None) -> tuple[Method, StepParams]:
    """The way of keeping clear, and everything that stays while the boat sails; with a plan, its roster too."""
    method = METHODS[clear.method]
    keep = method.params(clear.radius_m, clear.side)
    sea = Sea(ForeignParams(), tuple((boat.path, boat.limits) for boat in plan.boats)) if plan is not None else None
    return method, StepParams(
        follow=FollowParams(),
        station=StationParams(),
        limits=limits,
        keep=keep,
        closer=method.closer(keep),
        sea=sea,
    )


class Agent:
    """A boat that decides."""

    autopilot: PassesOn | None = None  # a driver whose autopilot ground stations may see
    informed: Informed | None = None  # a driver whose hardware does not know how the boat moves

    def __init__(
        self,
        boat: str,
        bus: Bus,
        driver: Driver,
        store: Store,
        recording: Recording,
        now_ns: int,
        *,
        boot_id: str,
        control_hz: float = 10.0,
        clock_ns: int = 50_000_000,
        threaded: bool = False,
        trust: Trust | None = None,
    ) -> None:
        self.boat, self.bus, self.driver, self.store = boat, bus, driver, store
        self.period_s = 1.0 / control_hz
        self.company, self.route, self.why = Company(self), Route(self), Why(self)
        self.clock_ns = clock_ns
        self.orders = Orders(boat, simulated=driver.simulated, version=__version__)
        self.orders.forget = self._forget
        self.orders.resume_at = self._resume_at
        self.orders.abscissas = self.company.abscissas
        self.orders.position_error_m = lambda: self.nav.sigma
        self.plane: Plane | None = None
        self.picture = Picture(boat, self._to_local, control_hz)
        self.picture.own_clock_ns = clock_ns
        self.picture.own_epoch = now_ns
        self.background = Background(threaded=threaded)
        self.orders.apart = threaded
        self.troubles = Troubles()
        self.wings = Wings(self.orders.flights)
        self.vacancies = Vacancies(boat)
        self.track = Track()
        self.links: Counter[str] = Counter()  # what the network refused, in words
        self.security: Callable[[], str] = lambda: trust.warning() if trust is not None else ""
        self.guard = Guard(self.orders, trust, lambda: self.clock_ns)
        self.desk = Desk(self)
        self.lookout = Lookout(self, now_ns)
        self.reporter = Reporter(self, recording, epoch=now_ns)
        self.resumption = Resumption(self, boot_id)
        self.course: Course = courses.at_point(0.0, 0.0)
        self.state: State[float, object] = start(0.0, 0.0, None)
        self.decision = ZERO_DECISION
        self.nav: Nav[float] = Nav(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self.reading = Reading(stamp_ns=0)
        self.reasons = Reason(0)
        self.peers: list[Peer[float]] = []
        self.ready = False
        self.name_taken = False
        self._numbers: list[float] = []
        self._watched: frozenset[str] = frozenset()
        self._strangers: set[str] = set()
        self._end_of: tuple[FormationOrder | None, float] = (None, 0.0)  # abscissa of the end, for a formation
        self._last_ns = 0
        self._saved_ns = 0
        self._saved_stops: tuple[str, ...] = ()
        self.stale_s = NAVIGATION_STALE_S
        self._driver_trouble = ""
        self._driver_failed_ns = 0
        self.fused = fusion.NOTHING
        self._fused_ns = 0
        self.sound_ns = 0  # when navigation was last sound; 0: never
        self.may_speak = True  # False until nobody else is known to be alive under this name
        self.set_params(None)

    # -- set-up ----------------------------------------------------------------------------------------------------
    def can_do(self, hull: str, limits: OwnLimits) -> None:
        """What the boat's own configuration says of it, before the first tick; a mission that asks more is refused."""
        self.orders.hull, self.orders.limits = hull, limits
        self.set_params(self.orders.sailing)

    def set_params(self, sailing: Sailing | None) -> None:
        """Tuning for a mission, or for waiting."""
        clear = sailing.plan.mission.keeping_clear if sailing is not None else KeepingClear()
        limits = sailing.plan.boats[sailing.number].limits if sailing is not None else within(self.orders.limits)
        plan = sailing.plan if sailing is not None else None
        self.method, self.params = tuning(clear, limits, plan)
        self.radius_m = clear.radius_m
        self.picture.half_radius_m = clear.radius_m / 2.0
        self._numbers = []
        keep = self.method.start(0.0, 0)
        s = self.state.s
        self.state = start(0.0, s, keep)

    def _to_local(self, lat_deg: float, lon_deg: float) -> tuple[float, float]:
        if self.plane is None:
            self.plane = plane_of(Datum(lat_deg, lon_deg))
        return self.plane.to_local(lat_deg, lon_deg)

    def _forget(self, names: tuple[str, ...]) -> list[str]:
        return self.picture.forget(names)

    @property
    def now_ns(self) -> int:
        """The time of this tick."""
        return self._last_ns

    @property
    def offset_m(self) -> float:
        """Offset of the own slot, + ahead [m]."""
        sailing = self.orders.sailing
        return sailing.ahead(sailing.number, self._last_ns) if sailing is not None else 0.0

    @property
    def driver_trouble(self) -> str:
        """Why the boat cannot be commanded; '' when it can."""
        return self.reading.trouble or self._driver_trouble

    # -- a tick ----------------------------------------------------------------------------------------------------
    def tick(self, now_ns: int) -> None:
        """Read, decide, write, publish, record."""
        dt = (now_ns - self._last_ns) * 1e-9 if self._last_ns else self.period_s
        dt = min(max(dt, 0.001), LONGEST_TICK_S)
        self._last_ns = now_ns
        self._navigate(now_ns)
        self._listen(now_ns)
        self.resumption.consider(now_ns)
        if self.orders.switch(now_ns):
            self.route.redraw()
        goal, why = self._goal(now_ns)
        self.route.follow_orders(now_ns)
        self._decide(goal, now_ns, dt)
        self.reasons = why | self.why.reasons(now_ns, dt)
        self._drive()
        self.vacancies.consider(self.orders, self.company.sails, now_ns)
        self.reporter.report(now_ns, goal, dt)
        self._keep(now_ns)

    def _listen(self, now_ns: int) -> None:
        """Take in what the others said, and answer what was asked."""
        self.ready = self.bus.open()
        self.background.finish()
        alive = self.bus.alive()
        if alive != self._watched:
            self._watched = alive
            self._watch(alive)
        for message in self.bus.poll_states(STATES_A_TICK):
            if self.plane is None:
                continue  # the own position says where the plane lies, not the first word of another
            try:
                state = self.picture.hear(message)
                if state is not None:
                    self.desk.compare(state, now_ns)
            except Exception:  # noqa: BLE001  a boat under way outlives any message
                self.desk.failed("state")
        self.desk.serve(now_ns)

    def _watch(self, alive: frozenset[str]) -> None:
        """Listen to who is there: to the roster always, to so many strangers as may really be."""
        roster = self.picture.roster
        for name in sorted(self._strangers):
            if name in roster:
                self._strangers.discard(name)
            elif name not in alive:
                self._strangers.discard(name)
                self.bus.unwatch(name)
        for name in sorted(alive):  # in an order that does not change from run to run
            if name not in roster and name not in self._strangers:
                if len(self._strangers) >= MOST_STRANGERS:
                    continue
                self._strangers.add(name)
            self.bus.watch(name)

    def _goal(self, now_ns: int) -> tuple[Goal, Reason]:
        sailing = self.orders.sailing
        fence = sailing.plan.fence if sailing is not None else ()
        seen = Circumstances(
            now_ns=now_ns,
            link_up=self.bus.link_up(),
            operator_there=bool(self.bus.operators()),
            inside_fence=self.nav.sound < 0.5 or courses.inside(fence, self.nav.x, self.nav.y),
            battery_percent=self.reading.battery_percent,
            authority=self.reading.authority,
            driver_trouble=self.driver_trouble,
            name_taken=self.name_taken,
            has_track=len(self.track.points) > 1,
            leader_lost_s=(now_ns - self.wings.lost_ns) * 1e-9 if self.wings.lost_ns else 0.0,
        )
        return self.troubles.goal(self.orders, seen)

    def _navigate(self, now_ns: int) -> None:
        """What the driver knows, dead-reckoned to now."""
        reading = self.reading = self.driver.read()
        nav = self._fuse(reading, now_ns) if reading.raw else nav_of(reading, self._to_local, now_ns, self.stale_s)
        if nav is None:
            last = self.nav
            self.nav = Nav(0.0, last.x, last.y, last.psi, 0.0, 0.0, 0.0, last.sigma)
            return
        self.nav, self.sound_ns = nav, now_ns
        if self.decision.powered:
            self.track.add(nav.x, nav.y)

    def _fuse(self, reading: Reading, now_ns: int) -> Nav[float] | None:
        """The same from raw sensors; the course of a boat that lost one is as good as the others make it."""
        dt = min((now_ns - self._fused_ns) * 1e-9, LONGEST_TICK_S) if self._fused_ns else self.period_s
        self._fused_ns = now_ns
        if self.plane is not None or math.isfinite(reading.lat_deg + reading.lon_deg):
            self.fused = fusion.fuse(self.fused, sensors_of(reading, self._to_local, now_ns), dt)
        f = self.fused
        return Nav(1.0, f.x, f.y, f.psi, f.vx, f.vy, f.r, f.sigma) if fusion.known(f) else None

    # -- deciding --------------------------------------------------------------------------------------------------
    def _decide(self, goal: Goal, now_ns: int, dt: float) -> None:
        link_up = self.bus.link_up()
        alive = self.bus.alive()
        nav = self.nav
        self.peers = self.picture.peers(
            now_ns, lambda name: link_up and name not in alive, (nav.x, nav.y), self.company.along
        )
        members = self.company.members(now_ns, dt)
        self.lookout.hear(now_ns)
        idle = goal in (Goal.STANDBY, Goal.NEUTRAL)  # nothing to decide, and nothing to remember from it
        peers = [] if idle else self.company.minded()
        numbers = [peer.number for peer in peers]
        state = self.state
        if numbers != self._numbers:
            keep = self.method.align(state.keep, self._numbers, numbers)
            state = structs.replace(state, keep=keep)
            self._numbers = numbers
        order = self._order(goal)
        path = self.course.path
        s_cvt = state.wing.s if state.wing is not None else state.s
        leader = self.wings.beside(self.picture, s_cvt, now_ns, there=self.course.kind == "mission")
        abroad = None if idle else self.lookout.abroad(goal, now_ns)
        self.state, self.decision = step(
            state, nav, members, peers, order, path, self.method, self.params, dt, abroad, leader
        )
        self.reporter.tick(now_ns, dt, state, nav, members, peers, order, self.decision, abroad, leader)

    def _order(self, goal: Goal) -> Order[float]:
        sailing, limits = self.orders.sailing, self.params.limits
        if sailing is None:
            slow, fast = limits.speed_min_mps, limits.speed_max_mps
            return Order(float(goal), 0.0, 0.5 * (slow + fast), slow, fast, 0.3, self.course.path.length)
        formation, cruise, stretch = sailing.formation, sailing.shape.cruise_mps, 1.0
        if self.course.kind == "mission":
            if self._end_of[0] is not formation:
                end = courses.end_abscissa(sailing.plan, sailing.number, sailing.shape)
                self._end_of = (formation, end)
            s_end = self._end_of[1]
            stretch = self.course.stretch(self.state.s)
            soon = self.state.s + cruise * limits.surge_lag_s  # where the boat is when it has taken up the speed
            cruise *= self.course.stretch(soon)
        else:
            s_end = self.course.path.length
        return Order(
            goal=float(goal),
            offset=self.offset_m,
            cruise=cruise,
            u_min=limits.speed_min_mps,
            u_max=limits.speed_max_mps,
            gain=sailing.plan.mission.formation.gain_per_m,
            s_end=s_end,
            stretch=stretch,
        )

    # -- acting ----------------------------------------------------------------------------------------------------
    def _drive(self) -> None:
        """The decision to the hardware; somebody else's command is not fought."""
        nav = self.nav
        if self.informed is not None and nav.sound > 0.5:
            surge = nav.vx * math.cos(nav.psi) + nav.vy * math.sin(nav.psi)
            self.informed.moves(self._last_ns, surge, nav.r)
        if self.reading.authority:
            self._driver_trouble = ""
            return
        if self.decision.powered > 0.5:
            self._driver_trouble = self.driver.write(self.decision.u_d, self.decision.r_d)
            self._driver_failed_ns = self._last_ns
            return
        if self._driver_trouble and (self._last_ns - self._driver_failed_ns) * 1e-9 >= DRIVER_AGAIN_S:
            self._driver_trouble = self.driver.write(0.0, 0.0)  # a try without thrust: does it work again?
            self._driver_failed_ns = self._last_ns
        self.driver.neutral()

    def _resume_at(self, text: str) -> str:
        """Where an operator wants the boat to go on; '' or why it does not."""
        sailing = self.orders.sailing
        assert sailing is not None
        if not courses.inside(sailing.plan.fence, self.nav.x, self.nav.y):
            return "outside the fence"
        battery = sailing.plan.mission.battery
        if self.reading.battery_percent < battery.reserve_percent:
            return f"battery at {self.reading.battery_percent:.0f} %, reserve is {battery.reserve_percent:.0f} %"
        return self.resumption.resume_at(text, sailing)

    def _keep(self, now_ns: int) -> None:
        """Write down what must survive a restart."""
        orders = self.orders
        stops = tuple(orders.stops)
        if orders.changed:
            orders.changed = False
            self.store.save_kept(self.resumption.kept())
        if stops != self._saved_stops or self.desk.waits_for_disk:
            self._saved_stops = stops
            self.store.save_stops(stops, self.desk.written())
        if now_ns - self._saved_ns >= SAVE_S * 1e9 and self.nav.sound > 0.5 and orders.sailing is not None:
            self._saved_ns = now_ns
            self.store.save_progress(self.resumption.progress(now_ns))

    def close(self) -> None:
        """Leave the boat in neutral, tell the others, end."""
        self.driver.neutral()
        self.driver.close()
        self.bus.close()
        self.store.close()
        self.reporter.recording.close()
