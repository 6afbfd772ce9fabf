"""From orders to a path: which mission, which path, where on it the boat begins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec import structs

from fleet.agent import course as courses
from fleet.agent.course import Track
from fleet.agent.modes import Goal, Mode
from fleet.agent.step import Nav, State

if TYPE_CHECKING:
    from fleet.agent.agent import Agent
    from fleet.agent.sailing import Sailing


class Route:
    """Lays the agent's course as its orders ask for."""

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self._sailing: Sailing | None = None
        self._goal_revision = -1

    def follow_orders(self, now_ns: int) -> None:
        """Take up another mission, or another path, when orders say so."""
        agent = self._agent
        orders = agent.orders
        sailing = orders.sailing
        if sailing is not self._sailing:
            self._sailing = sailing
            agent.wings.take(sailing)
            if sailing is not None:
                self._enter(sailing)
        if orders.revision_of_goal == self._goal_revision:
            return
        if orders.goal == Goal.FOLLOW and sailing is not None and now_ns < sailing.starts_ns:
            return
        if agent.nav.sound < 0.5 and orders.goal in (Goal.FOLLOW, Goal.RETURN):
            return  # where it begins is known when the position is
        self._goal_revision = orders.revision_of_goal
        self._lay(sailing, now_ns)

    def _enter(self, sailing: Sailing) -> None:
        """Project to the mission's datum and take its roster and tuning."""
        agent = self._agent
        plane = sailing.plan.plane
        if agent.plane is not None and agent.track.points:
            agent.track = Track([plane.to_local(*agent.plane.to_geographic(x, y)) for x, y in agent.track.points])
        if agent.plane is not None:
            x, y = plane.to_local(*agent.plane.to_geographic(agent.nav.x, agent.nav.y))
            n = agent.nav
            agent.nav = Nav(n.sound, x, y, n.psi, n.vx, n.vy, n.r, n.sigma)
            agent.fused = structs.replace(agent.fused, x=x, y=y)
            was = agent.plane
            agent.lookout.traffic.move(lambda x, y: plane.to_local(*was.to_geographic(x, y)))
        agent.plane = plane
        agent.lookout.enter(sailing)
        agent.picture.set_roster((boat.name for boat in sailing.plan.boats), plane.to_local)
        agent.picture.set_state_hz(min(sailing.plan.mission.state_hz, 1.0 / agent.period_s))
        agent.reporter.state_ns = int(1e9 / sailing.plan.mission.state_hz)
        for boat in sailing.plan.boats:
            if boat.name != agent.boat:
                agent.bus.watch(boat.name)
        agent.bus.watch(agent.boat)
        agent.reporter.mission(sailing)
        agent.course = courses.at_point(agent.nav.x, agent.nav.y)
        agent.set_params(sailing)
        agent.reporter.course(agent.course)

    def _lay(self, sailing: Sailing | None, now_ns: int) -> None:
        """The path that the new goal asks for, and where on it the boat begins."""
        agent = self._agent
        nav, goal = agent.nav, agent.orders.goal
        if goal == Goal.FOLLOW and sailing is not None:
            before = agent.course.kind
            s = agent.resumption.take_abscissa()
            if s is None and before == "mission":
                s = courses.start_abscissa(sailing, nav.x, nav.y, None, around=agent.state.s)
            if s is None:
                s = courses.start_abscissa(sailing, nav.x, nav.y, self._lap_reference(sailing, now_ns))
            agent.course = courses.along_mission(sailing)
        elif goal == Goal.RETURN:
            home = sailing.plan.home if sailing is not None else None
            back = courses.back_along(agent.track.points, (nav.x, nav.y), home)
            if back is None:
                agent.orders.turn_back(Goal.HOLD, "no track to go back along")
                self._goal_revision = agent.orders.revision_of_goal
                return
            agent.course, s = back, 0.0
        elif agent.course.kind == "mission" and sailing is not None:
            s = agent.state.s
        else:
            agent.course, s = courses.at_point(nav.x, nav.y), 0.0
        old = agent.state
        agent.state = State(s, 0.0, old.good, 0.0, old.x_h, old.y_h, 0.0, old.keep, old.foreign)
        agent.reporter.course(agent.course)

    def redraw(self) -> None:
        """Another formation is in force: over to the lane of the own slot."""
        agent = self._agent
        sailing = agent.orders.sailing
        agent.wings.take(sailing)
        if sailing is None or agent.course.kind != "mission":
            return
        redrawing, lane = sailing.redrawing, sailing.shape.abeam(sailing.number)
        length = redrawing.duration_s * sailing.shape.cruise_mps if redrawing is not None else 0.0
        radius = agent.params.limits.speed_max_mps / agent.params.limits.yaw_rate_max_radps
        course = courses.over_to(agent.course, lane, agent.state.s, length, radius)
        if course is not agent.course:
            agent.course = course
            agent.reporter.course(course)

    def _lap_reference(self, sailing: Sailing, now_ns: int) -> tuple[float, float] | None:
        """(abscissa, offset) of the lowest slot present: of those that sail already, else of those that are there."""
        agent = self._agent
        sailing_ones: list[tuple[float, float, float]] = []
        waiting: list[tuple[float, float, float]] = []
        shape = sailing.shape
        for boat in sailing.plan.boats:
            other = agent.picture.others.get(boat.name)
            if other is None or other.track is None or agent.picture.silent(other, now_ns, False):
                continue
            track = other.track
            offset = shape.ahead(boat.number)
            if track.state.mission_id == sailing.order.mission_id and track.state.mode in (Mode.FOLLOW, Mode.AVOID):
                sailing_ones.append((offset, agent.picture.abscissa(other, track, now_ns), offset))
            else:
                waiting.append((offset, boat.path.project(track.x, track.y), offset))
        me = sailing.plan.boats[sailing.number]
        if not sailing_ones:
            offset = shape.ahead(me.number)
            waiting.append((offset, me.path.project(agent.nav.x, agent.nav.y), offset))
        _, s, offset = min(sailing_ones or waiting)
        return s, offset
