"""The other boats of the formation, as keeping it and keeping clear see them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from msgspec import structs

from fleet.agent import course as courses
from fleet.agent.modes import IN_FORMATION
from fleet.agent.wing import InPlace
from fleet.avoidance.types import Peer
from fleet.coordination import Member
from fleet.paths import Lane
from fleet.wire.messages import BoatState

if TYPE_CHECKING:
    from fleet.agent.agent import Agent
    from fleet.agent.picture import Other
    from fleet.agent.sailing import Sailing


class Company:
    """Who sails with one boat, and in which order."""

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self._ordered: set[float] = set()  # numbers of boats that are ahead or astern of us as their slots are

    def members(self, now_ns: int, dt: float) -> list[Member[float]]:
        """The boats of the formation, in the order of the roster; notes which are ahead or astern as they should."""
        agent = self._agent
        self._ordered.clear()
        sailing = agent.orders.sailing
        if sailing is None or agent.wings.flies:  # wingmen look at their leader, and the leader at nobody
            return []
        members: list[Member[float]] = []
        me, offset = sailing.plan.boats[sailing.number], agent.offset_m
        for boat in sailing.plan.boats:
            other = agent.picture.others.get(boat.name)
            if other is None or other.track is None:
                continue
            weight = agent.picture.weigh(other, self.present(other, other.track.state, sailing), dt)
            if weight > 0.0:
                lane = boat.lane(sailing.shape) if sailing.drawn[boat.number][1] else boat.path
                stretch = lane.stretch(other.track.state.s_m) if isinstance(lane, Lane) else 1.0
                s = agent.picture.abscissa(other, other.track, now_ns, stretch)
                ahead = sailing.ahead(boat.number, now_ns)
                members.append(Member(weight, s - ahead))
                if boat.path_name == me.path_name and self._in_order(s - agent.state.s, ahead - offset):
                    self._ordered.add(float(boat.number))
        return members

    def _in_order(self, gap_m: float, wanted_m: float) -> bool:
        """Whether a boat so far ahead along the path is on the side where it belongs, on the same lap."""
        agent = self._agent
        path = agent.course.path
        lap_m = path.length if path.closed else courses.ENDLESS
        return gap_m * wanted_m > 0.0 and agent.radius_m < abs(gap_m) < 0.5 * lap_m

    def minded(self) -> list[Peer[float]]:
        """The vehicles that keeping clear looks at."""
        agent = self._agent
        if not agent.wings.flies:
            return [structs.replace(p, ordered=1.0) if p.number in self._ordered else p for p in agent.peers]
        d, x, y = agent.decision, agent.nav.x, agent.nav.y
        own = InPlace(d.mode, d.e, d.y_e)
        others = {float(other.number): other for other in agent.picture.others.values()}

        def near(p: Peer[float]) -> bool:
            return math.hypot(p.x - x, p.y - y) <= agent.radius_m

        def minded(p: Peer[float]) -> bool:
            other = others.get(p.number)
            return other is None or p.known < 0.5 or near(p) or agent.wings.minded(own, other)

        return [p for p in agent.peers if minded(p)]

    def present(self, other: Other, state: BoatState, sailing: Sailing) -> bool:
        """Fresh state, same mission id and formation revision, mode follow or avoid."""
        agent = self._agent
        return (
            state.mission_id == sailing.order.mission_id
            and state.in_force == sailing.formation.revision
            and state.mode in IN_FORMATION
            and state.simulated == agent.driver.simulated
            and other.second is None
            and other.name not in agent.picture.silent_names
        )

    def sails(self, name: str) -> bool:
        """Whether a boat of the roster sails in the formation."""
        agent = self._agent
        if name == agent.boat:
            return agent.decision.mode in IN_FORMATION and agent.course.kind == "mission"
        sailing, other = agent.orders.sailing, agent.picture.others.get(name)
        if sailing is None or other is None or other.track is None:
            return False
        state = other.track.state
        there = state.mode in IN_FORMATION and state.mission_id == sailing.order.mission_id
        return there and name not in agent.picture.silent_names

    def along(self, name: str, s: float) -> tuple[float, float] | None:
        """Where a boat of our mission is at an abscissa of its path."""
        agent = self._agent
        sailing = agent.orders.sailing
        number = agent.picture.roster.get(name)
        if sailing is None or number is None:
            return None
        point = sailing.plan.boats[number].lane(sailing.shape).at(s)
        return point.x, point.y

    def abscissas(self) -> dict[str, float]:
        """Where this boat and those that it hears are on their paths, for the check of a change."""
        agent = self._agent
        sailing = agent.orders.sailing
        if sailing is None or agent.course.kind != "mission":
            return {}
        now_ns, mission_id = agent.now_ns, sailing.order.mission_id
        found = {agent.boat: agent.state.s}
        for other in agent.picture.others.values():
            track = other.track
            if track is not None and other.name in agent.picture.roster and track.state.mission_id == mission_id:
                found[other.name] = agent.picture.abscissa(other, track, now_ns)
        return found
