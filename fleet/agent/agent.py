"""One boat's agent: everything around `step`, a tick at a time. Time, bus, driver and disk are handed in.

The same class runs in a boat's process (`loop`), and in a lock-step simulation; whatever it decides by itself enters
`step` as numbers.
"""

from __future__ import annotations

import math

from msgspec import structs

from fleet import __version__
from fleet.agent import course as courses
from fleet.agent.abroad import Sea
from fleet.agent.background import Background
from fleet.agent.course import Course, Track
from fleet.agent.lookout import Lookout
from fleet.agent.modes import IN_FORMATION, Goal, Mode, Reason
from fleet.agent.orders import Orders, Sailing
from fleet.agent.picture import Other, Picture
from fleet.agent.report import Reporter
from fleet.agent.resume import Resumption
from fleet.agent.sensors import sensors_of
from fleet.agent.serve import Desk
from fleet.agent.step import Decision, Nav, Order, State, StepParams, start, step
from fleet.agent.store import Store
from fleet.agent.troubles import Circumstances, Troubles
from fleet.agent.vacancies import Vacancies
from fleet.agent.wing import InPlace, Wings
from fleet.avoidance import METHODS, Method
from fleet.avoidance.foreign.params import ForeignParams
from fleet.avoidance.types import Peer
from fleet.coordination import Member
from fleet.drivers.seam import Driver, Reading
from fleet.geo import Datum, Plane, plane_of
from fleet.guidance import FollowParams, Limits, StationParams
from fleet.guidance.limits import OwnLimits, within
from fleet.mission.model import KeepingClear
from fleet.mission.plan import Plan
from fleet.paths import Lane
from fleet.recording.seam import Recording
from fleet.sensing import fusion
from fleet.wire.bus import Bus
from fleet.wire.messages import BoatState, FormationOrder

NAVIGATION_STALE_S = 1.0
STATES_A_TICK = 256  # of one sender
MOST_STRANGERS = 100  # boats listened to that are not of the own mission
SAVE_S = 1.0
STUCK_S = 10.0
DRIVER_AGAIN_S = 1.0
OUT_OF_REACH_S = 180.0  # exchanging places at the limits of speed takes half of it
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
    ) -> None:
        self.boat, self.bus, self.driver, self.store = boat, bus, driver, store
        self.period_s = 1.0 / control_hz
        self.clock_ns = clock_ns
        self.orders = Orders(boat, simulated=driver.simulated, version=__version__)
        self.orders.forget = self._forget
        self.orders.resume_at = self._resume_at
        self.orders.abscissas = self._abscissas
        self.orders.position_error_m = lambda: self.nav.sigma
        self.plane: Plane | None = None
        self.picture = Picture(boat, self._to_local, control_hz)
        self.picture.own_clock_ns = clock_ns
        self.picture.own_epoch = now_ns
        self.background = Background(threaded=threaded)
        self.orders.apart = threaded
        self.troubles = Troubles()
        self.wings = Wings()
        self.vacancies = Vacancies(boat)
        self.track = Track()
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
        self._ordered: set[float] = set()  # numbers of boats that are ahead or astern of us as their slots are
        self._watched: frozenset[str] = frozenset()
        self._strangers: set[str] = set()
        self._end_of: tuple[FormationOrder | None, float] = (None, 0.0)  # abscissa of the end, for a formation
        self._sailing: Sailing | None = None
        self._goal_revision = -1
        self._last_ns = 0
        self._saved_ns = 0
        self._saved_stops: tuple[str, ...] = ()
        self._stuck_s = self._late_s = 0.0
        self.stale_s = NAVIGATION_STALE_S
        self._driver_trouble = ""
        self._driver_failed_ns = 0
        self.fused = fusion.NOTHING
        self._fused_ns = 0
        self.sound_ns = 0  # when navigation was last sound; 0: never
        self.may_speak = True  # False until nobody else is known to be alive under this name
        self._set_params(None)

    # -- set-up ----------------------------------------------------------------------------------------------------
    def can_do(self, hull: str, limits: OwnLimits) -> None:
        """What the boat's own configuration says of it, before the first tick; a mission that asks more is refused."""
        self.orders.hull, self.orders.limits = hull, limits
        self._set_params(self.orders.sailing)

    def _set_params(self, sailing: Sailing | None) -> None:
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
            self._redraw()
        goal, why = self._goal(now_ns)
        self._change_course(now_ns)
        self._decide(goal, now_ns, dt)
        self.reasons = why | self._own_reasons(now_ns, dt)
        self._drive()
        self.vacancies.consider(self.orders, self._sails, now_ns)
        self.reporter.report(now_ns, goal, dt)
        self._keep(now_ns)

    def _navigate(self, now_ns: int) -> None:
        """What the driver knows, dead-reckoned to now."""
        reading = self.reading = self.driver.read()
        if reading.raw:
            self._fuse(reading, now_ns)
            return
        age_s = (now_ns - reading.stamp_ns) * 1e-9
        numbers = reading.lat_deg + reading.lon_deg + reading.heading_rad + reading.v_north_mps + reading.v_east_mps
        known = (
            reading.stamp_ns > 0
            and math.isfinite(numbers)
            and not (reading.lat_deg == 0.0 and reading.lon_deg == 0.0)
            and abs(reading.lat_deg) <= 90.0
            and 0.0 <= reading.position_error_m < math.inf
        )
        if not known or not -0.5 < age_s < self.stale_s:
            self.nav = Nav(0.0, self.nav.x, self.nav.y, self.nav.psi, 0.0, 0.0, 0.0, self.nav.sigma)
            return
        x, y = self._to_local(reading.lat_deg, reading.lon_deg)
        age_s = max(age_s, 0.0)
        self.sound_ns = now_ns
        self.nav = Nav(
            1.0,
            x + reading.v_north_mps * age_s,
            y + reading.v_east_mps * age_s,
            reading.heading_rad,
            reading.v_north_mps,
            reading.v_east_mps,
            reading.yaw_rate_radps if math.isfinite(reading.yaw_rate_radps) else 0.0,
            reading.position_error_m,
        )
        if self.decision.powered:
            self.track.add(x, y)

    def _fuse(self, reading: Reading, now_ns: int) -> None:
        """The same from raw sensors; the course of a boat that lost one is as good as the others make it."""
        dt = min((now_ns - self._fused_ns) * 1e-9, LONGEST_TICK_S) if self._fused_ns else self.period_s
        self._fused_ns = now_ns
        if self.plane is not None or math.isfinite(reading.lat_deg + reading.lon_deg):
            self.fused = fusion.fuse(self.fused, sensors_of(reading, self._to_local, now_ns), dt)
        f = self.fused
        if not fusion.known(f):
            self.nav = Nav(0.0, self.nav.x, self.nav.y, self.nav.psi, 0.0, 0.0, 0.0, self.nav.sigma)
            return
        self.sound_ns = now_ns
        self.nav = Nav(1.0, f.x, f.y, f.psi, f.vx, f.vy, f.r, f.sigma)
        if self.decision.powered:
            self.track.add(f.x, f.y)

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

    def _change_course(self, now_ns: int) -> None:
        """Take up another mission, or another path, when orders say so."""
        orders = self.orders
        sailing = orders.sailing
        if sailing is not self._sailing:
            self._sailing = sailing
            self.wings.take(sailing)
            if sailing is not None:
                self._enter(sailing)
        if orders.revision_of_goal == self._goal_revision:
            return
        if orders.goal == Goal.FOLLOW and sailing is not None and now_ns < sailing.starts_ns:
            return
        if self.nav.sound < 0.5 and orders.goal in (Goal.FOLLOW, Goal.RETURN):
            return  # where it begins is known when the position is
        self._goal_revision = orders.revision_of_goal
        self._lay(sailing, now_ns)

    def _enter(self, sailing: Sailing) -> None:
        """Project to the mission's datum and take its roster and tuning."""
        plane = sailing.plan.plane
        if self.plane is not None and self.track.points:
            self.track = Track([plane.to_local(*self.plane.to_geographic(x, y)) for x, y in self.track.points])
        if self.plane is not None:
            x, y = plane.to_local(*self.plane.to_geographic(self.nav.x, self.nav.y))
            n = self.nav
            self.nav = Nav(n.sound, x, y, n.psi, n.vx, n.vy, n.r, n.sigma)
            self.fused = structs.replace(self.fused, x=x, y=y)
            was = self.plane
            self.lookout.traffic.move(lambda x, y: plane.to_local(*was.to_geographic(x, y)))
        self.plane = plane
        self.lookout.enter(sailing)
        self.picture.set_roster((boat.name for boat in sailing.plan.boats), plane.to_local)
        self.picture.set_state_hz(min(sailing.plan.mission.state_hz, 1.0 / self.period_s))
        self.reporter.state_ns = int(1e9 / sailing.plan.mission.state_hz)
        for boat in sailing.plan.boats:
            if boat.name != self.boat:
                self.bus.watch(boat.name)
        self.bus.watch(self.boat)
        self.reporter.mission(sailing)
        self.course = courses.at_point(self.nav.x, self.nav.y)
        self._set_params(sailing)
        self.reporter.course(self.course)

    def _lay(self, sailing: Sailing | None, now_ns: int) -> None:
        """The path that the new goal asks for, and where on it the boat begins."""
        nav, goal = self.nav, self.orders.goal
        if goal == Goal.FOLLOW and sailing is not None:
            before = self.course.kind
            s = self.resumption.take_abscissa()
            if s is None and before == "mission":
                s = courses.start_abscissa(sailing, nav.x, nav.y, None, around=self.state.s)
            if s is None:
                s = courses.start_abscissa(sailing, nav.x, nav.y, self._lap_reference(sailing, now_ns))
            self.course = courses.along_mission(sailing)
        elif goal == Goal.RETURN:
            home = sailing.plan.home if sailing is not None else None
            back = courses.back_along(self.track.points, (nav.x, nav.y), home)
            if back is None:
                self.orders.turn_back(Goal.HOLD, "no track to go back along")
                self._goal_revision = self.orders.revision_of_goal
                return
            self.course, s = back, 0.0
        elif self.course.kind == "mission" and sailing is not None:
            s = self.state.s
        else:
            self.course, s = courses.at_point(nav.x, nav.y), 0.0
        old = self.state
        self.state = State(s, 0.0, old.good, 0.0, old.x_h, old.y_h, 0.0, old.keep, old.foreign)
        self.reporter.course(self.course)

    def _redraw(self) -> None:
        """Another formation is in force: over to the lane of the own slot."""
        sailing = self.orders.sailing
        self.wings.take(sailing)
        if sailing is None or self.course.kind != "mission":
            return
        redrawing, lane = sailing.redrawing, sailing.shape.abeam(sailing.number)
        length = redrawing.duration_s * sailing.shape.cruise_mps if redrawing is not None else 0.0
        radius = self.params.limits.speed_max_mps / self.params.limits.yaw_rate_max_radps
        course = courses.over_to(self.course, lane, self.state.s, length, radius)
        if course is not self.course:
            self.course = course
            self.reporter.course(course)

    def _lap_reference(self, sailing: Sailing, now_ns: int) -> tuple[float, float] | None:
        """(abscissa, offset) of the lowest slot present: of those that sail already, else of those that are there."""
        sailing_ones: list[tuple[float, float, float]] = []
        waiting: list[tuple[float, float, float]] = []
        shape = sailing.shape
        for boat in sailing.plan.boats:
            other = self.picture.others.get(boat.name)
            if other is None or other.track is None or self.picture.silent(other, now_ns, False):
                continue
            track = other.track
            offset = shape.ahead(boat.number)
            if track.state.mission_id == sailing.order.mission_id and track.state.mode in (Mode.FOLLOW, Mode.AVOID):
                sailing_ones.append((offset, self.picture.abscissa(other, track, now_ns), offset))
            else:
                waiting.append((offset, boat.path.project(track.x, track.y), offset))
        me = sailing.plan.boats[sailing.number]
        if not sailing_ones:
            offset = shape.ahead(me.number)
            waiting.append((offset, me.path.project(self.nav.x, self.nav.y), offset))
        _, s, offset = min(sailing_ones or waiting)
        return s, offset

    # -- deciding --------------------------------------------------------------------------------------------------
    def _decide(self, goal: Goal, now_ns: int, dt: float) -> None:
        link_up = self.bus.link_up()
        alive = self.bus.alive()
        nav = self.nav
        self.peers = self.picture.peers(now_ns, lambda name: link_up and name not in alive, (nav.x, nav.y), self._along)
        members = self._members(now_ns, dt)
        self.lookout.hear(now_ns)
        idle = goal in (Goal.STANDBY, Goal.NEUTRAL)  # nothing to decide, and nothing to remember from it
        peers = [] if idle else self._minded()
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

    def _minded(self) -> list[Peer[float]]:
        """The vehicles that keeping clear looks at."""
        if not self.wings.flies:
            return [structs.replace(p, ordered=1.0) if p.number in self._ordered else p for p in self.peers]
        d, x, y = self.decision, self.nav.x, self.nav.y
        own = InPlace(d.mode, d.e, d.y_e)
        others = {float(other.number): other for other in self.picture.others.values()}

        def near(p: Peer[float]) -> bool:
            return math.hypot(p.x - x, p.y - y) <= self.radius_m

        def minded(p: Peer[float]) -> bool:
            other = others.get(p.number)
            return other is None or p.known < 0.5 or near(p) or self.wings.minded(own, other)

        return [p for p in self.peers if minded(p)]

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

    def _along(self, name: str, s: float) -> tuple[float, float] | None:
        """Where a boat of our mission is at an abscissa of its path."""
        sailing = self.orders.sailing
        number = self.picture.roster.get(name)
        if sailing is None or number is None:
            return None
        point = sailing.plan.boats[number].lane(sailing.shape).at(s)
        return point.x, point.y

    def _members(self, now_ns: int, dt: float) -> list[Member[float]]:
        """The boats of the formation, in the order of the roster; notes which are ahead or astern as they should."""
        self._ordered.clear()
        sailing = self.orders.sailing
        if sailing is None or self.wings.flies:  # wingmen look at their leader, and the leader at nobody
            return []
        members: list[Member[float]] = []
        me, offset = sailing.plan.boats[sailing.number], self.offset_m
        for boat in sailing.plan.boats:
            other = self.picture.others.get(boat.name)
            if other is None or other.track is None:
                continue
            weight = self.picture.weigh(other, self.present(other, other.track.state, sailing), dt)
            if weight > 0.0:
                lane = boat.lane(sailing.shape) if sailing.drawn[boat.number][1] else boat.path
                stretch = lane.stretch(other.track.state.s_m) if isinstance(lane, Lane) else 1.0
                s = self.picture.abscissa(other, other.track, now_ns, stretch)
                ahead = sailing.ahead(boat.number, now_ns)
                members.append(Member(weight, s - ahead))
                if boat.path_name == me.path_name and self._in_order(s - self.state.s, ahead - offset):
                    self._ordered.add(float(boat.number))
        return members

    def _in_order(self, gap_m: float, wanted_m: float) -> bool:
        """Whether a boat so far ahead along the path is on the side where it belongs, on the same lap."""
        path = self.course.path
        lap_m = path.length if path.closed else courses.ENDLESS
        return gap_m * wanted_m > 0.0 and self.radius_m < abs(gap_m) < 0.5 * lap_m

    def present(self, other: Other, state: BoatState, sailing: Sailing) -> bool:
        """Fresh state, same mission id and formation revision, mode follow or avoid."""
        return (
            state.mission_id == sailing.order.mission_id
            and state.in_force == sailing.formation.revision
            and state.mode in IN_FORMATION
            and state.simulated == self.driver.simulated
            and other.second is None
            and other.name not in self.picture.silent_names
        )

    def _sails(self, name: str) -> bool:
        """Whether a boat of the roster sails in the formation."""
        if name == self.boat:
            return self.decision.mode in IN_FORMATION and self.course.kind == "mission"
        sailing, other = self.orders.sailing, self.picture.others.get(name)
        if sailing is None or other is None or other.track is None:
            return False
        state = other.track.state
        there = state.mode in IN_FORMATION and state.mission_id == sailing.order.mission_id
        return there and name not in self.picture.silent_names

    def _own_reasons(self, now_ns: int, dt: float) -> Reason:
        """What `step`, the picture and the disk have to say."""
        d, why = self.decision, Reason(0)
        if d.mode == Mode.FAULT or self.nav.sound < 0.5:
            why |= Reason.NAVIGATION
        if d.avoiding > 0.5:
            why |= Reason.AVOIDING
        if d.braking > 0.5:
            why |= Reason.BRAKING
        if self.lookout.acting:
            why |= Reason.FOREIGN
        following = d.mode in (Mode.FOLLOW, Mode.AVOID)
        self._stuck_s = self._stuck_s + dt if following and d.avoiding > 0.5 and d.U < 0.1 else 0.0
        if self._stuck_s > STUCK_S:
            why |= Reason.BOXED_IN
        self._late_s = self._late_s + dt if following and abs(d.e) > 5.0 else 0.0
        if self._late_s > OUT_OF_REACH_S:
            why |= Reason.SLOT_OUT_OF_REACH
        if self.state.ended > 0.5:
            why |= Reason.MISSION_ENDED
        if self.wings.lost_ns:
            why |= Reason.LEADER_LOST
        if self.wings.stopped:
            why |= Reason.LEADER_STOPPED
        if self.store.trouble:
            why |= Reason.STORE
        if self.reporter.recording.trouble:
            why |= Reason.NOT_RECORDING
        if now_ns - self.picture.own_name_heard_ns < 5e9 and self.picture.own_name_heard_ns:
            why |= Reason.IDENTITY_CLASH
        return why | self._others_reasons(now_ns)

    def _others_reasons(self, now_ns: int) -> Reason:
        why = Reason(0)
        sailing = self.orders.sailing
        for other in self.picture.others.values():
            if other.second is not None and self.picture.clashes(other, now_ns):
                why |= Reason.IDENTITY_CLASH
            if other.track is None or sailing is None or other.name not in self.picture.roster:
                continue
            if other.name in self.picture.silent_names:
                why |= Reason.PEER_SILENT
            elif other.track.state.mission_id not in ("", sailing.order.mission_id):
                why |= Reason.PEER_ELSEWHERE
        return why

    def _abscissas(self) -> dict[str, float]:
        """Where this boat and those that it hears are on their paths, for the check of a change."""
        sailing = self.orders.sailing
        if sailing is None or self.course.kind != "mission":
            return {}
        now_ns, mission_id = self._last_ns, sailing.order.mission_id
        found = {self.boat: self.state.s}
        for other in self.picture.others.values():
            track = other.track
            if track is not None and other.name in self.picture.roster and track.state.mission_id == mission_id:
                found[other.name] = self.picture.abscissa(other, track, now_ns)
        return found

    # -- acting ----------------------------------------------------------------------------------------------------
    def _drive(self) -> None:
        """The decision to the hardware; somebody else's command is not fought."""
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
        if stops != self._saved_stops or self.desk.waits_for_disk:
            self._saved_stops = stops
            self.store.save_stops(stops, self.desk.written())
        if orders.changed:
            orders.changed = False
            self.store.save_kept(self.resumption.kept())
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
