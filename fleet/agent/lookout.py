"""The lookout for foreign vessels: what `step` is told of them, who decides about them, and what is said of it.

In a formation one boat decides for all: the foremost of those present, of several the one nearest to slot 0. What it
decides is in every state that it publishes. Boats that cannot hear it, are out of their place, or sail another way at
that moment decide for themselves.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from fleet import ops
from fleet.agent.abroad import ALONE, FOLLOWS, LEADS, Abroad, Fellow, Watch, acts, course_of
from fleet.agent.modes import Goal
from fleet.agent.scanned import Mate
from fleet.agent.scans import Outlook
from fleet.agent.traffic import Traffic
from fleet.agent.traffic_words import action, meeting, sentence
from fleet.avoidance.foreign.decision import prepare
from fleet.avoidance.foreign.types import FOLLOW_PATH, Action, Edge, Order
from fleet.drivers.seam import Sighting
from fleet.paths import Lane
from fleet.wire.messages import ForeignOrder

if TYPE_CHECKING:
    from fleet.agent.agent import Agent
    from fleet.agent.picture import Other
    from fleet.agent.sailing import Sailing

IN_SLOT_M = 10.0  # along the path; farther out a boat decides for itself
ONE_WAY = 0.5  # cosine of the angle between the paths of boats that decide as one
PATIENCE_S = 3.0  # with a leader that tells nothing of foreign vessels, then a boat decides for itself
IDLE = (0.0, 0.0, 1.0)  # no action
AGES_S = 2.0  # a state older than that is not rolled out any further


class Lookout:
    """What one boat knows of foreign vessels."""

    def __init__(self, agent: Agent, epoch_ns: int) -> None:
        self._agent = agent
        self.traffic = Traffic(lambda: agent.picture.roster, epoch_ns)
        self.outlook = Outlook()
        self._met_mates: set[float] = set()  # numbers of boats that were heard
        self._base_ns = epoch_ns  # from which the law's clock counts: the same on every boat of a mission
        self._part = ALONE
        self._told_ns = 0  # when a leader last told of foreign vessels; at first, when we began to wait for it
        self._edges: tuple[Edge, ...] = ()
        self._heard: tuple[tuple[str, int, int], Order] | None = None  # (boat, epoch, serial), and what it said
        self._met: dict[float, float] = {}  # kinds of the encounters that were told
        self._sailed = IDLE  # the action that was told
        self._prepared = False  # what a decision needs has been imported, or is just now

    @property
    def watched(self) -> Watch | None:
        """What was advised in this tick."""
        return self._agent.state.foreign

    @property
    def acting(self) -> bool:
        """Whether the boat keeps clear of a foreign vessel."""
        return acts(self.watched)

    def enter(self, sailing: Sailing) -> None:
        """Another mission: its clock, its fence, no orders yet."""
        self._base_ns = sailing.order.stamp_ns
        fence = sailing.plan.fence
        self._edges = tuple((*a, *b) for a, b in pairwise((*fence, fence[0]))) if fence else ()
        self._heard = None

    def hear(self, now_ns: int) -> None:
        """What the driver reports of others."""
        agent, plane = self._agent, self._agent.plane
        reading = agent.reading
        if (reading.sightings or reading.scans) and not self._prepared:
            self._prepared = agent.background.submit(prepare, lambda: None) is not None
        if plane is None:
            return
        told: list[Sequence[Sighting]] = [reading.sightings] if reading.sightings else []
        if reading.scans:
            told += self.outlook.sightings(reading.scans, agent.nav, plane.to_geographic, now_ns)
        mates = self._mates() if told or len(agent.peers) != len(self._met_mates) else ()
        for sightings in told:
            self.traffic.hear(sightings, plane.to_local, mates, now_ns)

    def _mates(self) -> list[Mate]:
        """Boats of the fleet; those heard for the first time may have been taken for vessels until now."""
        agent = self._agent
        own, mates = agent.nav.sigma, []
        for peer in agent.peers:
            error = 3.0 * ops.hypot(peer.sigma, own) + peer.widen
            mates.append(Mate(peer.x, peer.y, error, peer.vx, peer.vy))
            if peer.number not in self._met_mates:
                self.traffic.greet(mates[-1])
        self._met_mates = {peer.number for peer in agent.peers}
        return mates

    def abroad(self, goal: Goal, now_ns: int) -> Abroad | None:
        """What `step` is told; None while there is nothing to tell."""
        if not self.traffic and self.watched is None:
            self._told_ns = 0
            return None
        targets = self.traffic.targets(now_ns)
        fellows: tuple[Fellow, ...] = ()
        party: tuple[float, ...] = ()
        self._part, heard = ALONE, None
        sailing = self._agent.orders.sailing
        if sailing is not None and goal == Goal.FOLLOW and self._agent.course.kind == "mission":
            there = dict(self._there(sailing))
            ranks = [(-sailing.shape.ahead(i), abs(sailing.shape.slots[i]), i) for i in (sailing.number, *there)]
            leader = min(ranks)[2]
            party = tuple(float(number) for number, other in there.items() if not _decides_alone(other))
            if there and leader == sailing.number:
                self._part, fellows = LEADS, tuple(self._fellows(sailing, there, now_ns))
            elif leader in there:
                heard = self._order_of(there[leader], now_ns)
                self._told_ns = now_ns if heard is not None else self._told_ns or now_ns
                self._part = FOLLOWS if (now_ns - self._told_ns) * 1e-9 < PATIENCE_S else ALONE
        now = (now_ns - self._base_ns) * 1e-9
        return Abroad(now, targets, self._part, fellows, heard, self._edges, party)

    # -- the formation -----------------------------------------------------------------------------------------------
    def _there(self, sailing: Sailing) -> Iterator[tuple[int, Other]]:
        """The boats of the formation that are present, but for this one."""
        agent = self._agent
        for boat in sailing.plan.boats:
            other = agent.picture.others.get(boat.name)
            if (
                other is not None
                and other.track is not None
                and agent.company.present(other, other.track.state, sailing)
            ):
                yield boat.number, other

    def _fellows(self, sailing: Sailing, there: dict[int, Other], now_ns: int) -> Iterator[Fellow]:
        """Those that this boat decides for: in their slots, under way as we are."""
        agent = self._agent
        here = agent.course.path.at(agent.state.s)
        for number, other in there.items():
            track = other.track
            assert track is not None
            state = track.state
            if _decides_alone(other) or abs(state.along_path_m) > IN_SLOT_M:
                continue
            lane = sailing.plan.boats[number].lane(sailing.shape)
            stretch = lane.stretch(state.s_m) if isinstance(lane, Lane) else 1.0
            s = agent.picture.abscissa(other, track, now_ns, stretch)
            point = lane.at(s)
            if point.tx * here.tx + point.ty * here.ty < ONE_WAY:
                continue
            age = min(agent.picture.age_s(other, track, now_ns)[0], AGES_S)
            chi, U = course_of(track.vx, track.vy, state.heading_rad)
            abeam = sailing.shape.abeam(number)
            x, y = track.x + track.vx * age, track.y + track.vy * age
            yield Fellow(float(number), abeam, x, y, chi, U, state.yaw_rate_radps, s)

    def _order_of(self, other: Other, now_ns: int) -> Order | None:
        """The leader's decision, by the own clock; None where it tells none, or sails another way."""
        agent, track = self._agent, other.track
        assert track is not None
        told = track.state.foreign
        if told is None:
            return None
        point = agent.course.path.at(agent.state.s)
        s, c = ops.sincos(told.path_rad)
        if point.tx * c + point.ty * s < ONE_WAY:
            return None
        key = (other.name, track.state.epoch, told.serial)
        if self._heard is None or self._heard[0] != key:
            age, _ = agent.picture.age_s(other, track, now_ns)
            sent_ns = now_ns - round(age * 1e9) if track.lead_s < 0.0 else track.state.stamp_ns
            at = (sent_ns + told.apply_ns - track.state.stamp_ns - self._base_ns) * 1e-9
            s, c = ops.sincos(told.course_rad)
            decided = Action(1.0, told.offset_rad, told.factor, c, s, told.sense, at)
            said = decided if told.acting else Action(0.0, 0.0, 1.0, FOLLOW_PATH.cx, FOLLOW_PATH.cy, 0.0, at)
            target = self.traffic.number_of(told.vessel)
            order = Order(float(other.number), float(told.serial), said, target, float(told.reason))
            self._heard = (key, order)
        return self._heard[1]

    def order(self) -> ForeignOrder | None:
        """What the boat has decided, or was told, for its state message."""
        watched = self.watched
        if watched is None:
            return None
        memory = watched.memory
        decided, point = memory.ordered, self._agent.course.path.at(self._agent.state.s)
        return ForeignOrder(
            serial=int(memory.serial),
            apply_ns=self._base_ns + round(decided.at * 1e9),
            acting=decided.acting > 0.5,
            offset_rad=decided.a,
            factor=decided.factor,
            course_rad=math.atan2(decided.cy, decided.cx),
            sense=decided.sense,
            path_rad=math.atan2(point.ty, point.tx),
            reason=int(memory.reason),
            vessel=self.traffic.name_of(memory.target),
            alone=self._part == ALONE or memory.alone > 0.5,
        )

    # -- words -------------------------------------------------------------------------------------------------------
    def words(self) -> tuple[str, ...]:
        """A line for each vessel in sight, the next to be met first."""
        watched = self.watched
        if watched is None:
            return ()
        contacts = sorted(watched.advice.contacts, key=lambda one: (one.entry, one.distance))
        return tuple(f"{self.traffic.name_of(one.number)}: {meeting(one)}" for one in contacts)

    def notes(self) -> Iterator[tuple[str, str]]:
        """(kind, text) of what is new in this tick: encounters, decisions."""
        watched = self.watched
        if watched is None:
            self._met.clear()
            self._sailed = IDLE
            return
        advice = watched.advice
        for one in advice.contacts:
            if one.kind != self._met.get(one.number, 0.0):
                self._met[one.number] = one.kind
                if one.kind:
                    yield "traffic", f"{self.traffic.name_of(one.number)}: {meeting(one)}"
        sailed = watched.memory.sailed
        now = (sailed.acting, sailed.a, sailed.factor) if self.acting else IDLE
        if now == self._sailed:
            return
        self._sailed = now
        if self.acting:
            name = self.traffic.name_of(advice.target) or "a vessel"
            yield "avoid", f"{sentence(advice, name)}: {action(sailed)}"
        else:
            yield "avoid", "past and clear of other vessels, back to the path"


def _decides_alone(other: Other) -> bool:
    """It says that it keeps clear of foreign vessels by itself."""
    told = other.track.state.foreign if other.track is not None else None
    return told is not None and told.alone
