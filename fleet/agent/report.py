"""What the boat says and writes down: state every tick, status once a second, events, the recording."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import msgspec
from msgspec import Struct

from fleet import __version__
from fleet.agent.abroad import Abroad
from fleet.agent.modes import Goal, Mode, in_words, mode_word
from fleet.agent.step import FOREIGN_FROM, Decision, Nav, Order, State
from fleet.avoidance.types import Peer
from fleet.coordination import Leader, Member
from fleet.mission.load import encode as encode_mission
from fleet.paths import Shift
from fleet.recording import topics
from fleet.recording.seam import NullRecorder, Recording
from fleet.wire import keys
from fleet.wire.codec import encode
from fleet.wire.messages import MAJOR, BoatState, BoatStatus, FleetEvent, Revision

if TYPE_CHECKING:
    from fleet.agent.agent import Agent
    from fleet.agent.course import Course
    from fleet.agent.sailing import Sailing

STATUS_S = 1.0
VIEWER_S = 0.5
DRIFTS_MPS = 0.1  # 1 sigma of a boat without navigation; others add twice that to radii, as about a silent one
SIDES = {1.0: "port", -1.0: "starboard"}


class Inputs(Struct, frozen=True, array_like=True):
    """What `step` was given in one tick; with the last `Laid` it is all that a replay needs."""

    tick: int
    dt: float
    state: msgspec.Raw  # State[float, memory of the way of keeping clear]
    nav: Nav[float]
    members: tuple[Member[float], ...]
    peers: tuple[Peer[float], ...]
    order: Order[float]
    abroad: Abroad | None = None
    leader: Leader[float] | None = None


class Laid(Struct, frozen=True, array_like=True):
    """The path that `step` was given from this tick on, and the mission whose limits and method it used."""

    version: str
    boat: str
    number: int  # in the roster of the mission that it has the limits of, -1 before any
    kind: str  # "mission", "track" or "point"
    points: tuple[tuple[float, float], ...]
    mission: bytes
    abeam: float = 0.0  # metres to starboard of the mission's path
    shift: Shift | None = None  # of lanes


class Counters(Struct):
    """What the loop counts."""

    ticks: int = 0
    late: int = 0
    worst_late_ms: float = 0.0


def course_topic(boat: str) -> str:
    """`/<boat>/laid`: what path and parameters the inputs refer to, msgpack."""
    return f"/{boat}/laid"


class Reporter:
    """Publishes and records for one agent."""

    def __init__(self, agent: Agent, recording: Recording, epoch: int) -> None:
        self._agent, self.recording, self._epoch = agent, recording, epoch
        self.counters = Counters()
        self._seq = 0
        self.state_ns = 0  # time between two states; every tick by default
        self._stated_ns = 0
        self._status_ns = self._viewed_ns = 0
        self._mode, self._avoiding, self._reasons, self._target = -1.0, 0.0, 0, -1.0
        self._mission, self._number = b"", -1
        self._records = not isinstance(recording, NullRecorder)
        self._encode = msgspec.msgpack.Encoder().encode
        boat = agent.boat
        topics.declare_fleet(recording)
        topics.declare_boat(recording, boat, raw=True)
        recording.channel(course_topic(boat), "fleet.Laid", "msgpack")
        self._inputs, self._decision = topics.inputs_topic(boat), topics.decision_topic(boat)
        self._state_topic, self._fix_topic = topics.state_topic(boat), topics.fix_topic(boat)
        self._status_topic, self._course_topic = topics.status_topic(boat), course_topic(boat)

    # -- recording -------------------------------------------------------------------------------------------------
    def mission(self, sailing: Sailing) -> None:
        """The boat takes up a mission."""
        self._mission, self._number = encode_mission(sailing.plan.mission), sailing.number

    def course(self, course: Course) -> None:
        """The boat lays another course."""
        boat, kind = self._agent.boat, course.kind
        laid = Laid(__version__, boat, self._number, kind, course.points, self._mission, course.abeam, course.shift)
        self.recording.put(self._course_topic, self._agent.now_ns, self._encode(laid))

    def tick(
        self,
        now_ns: int,
        dt: float,
        state: State[float, object],
        nav: Nav[float],
        members: Sequence[Member[float]],
        peers: Sequence[Peer[float]],
        order: Order[float],
        decision: Decision[float],
        abroad: Abroad | None = None,
        leader: Leader[float] | None = None,
    ) -> None:
        """What went into `step`, and what came out."""
        self.counters.ticks += 1
        if not self._records:
            return
        put = self.recording.put
        inputs = (self.counters.ticks, dt, state, nav, members, peers, order)
        more = (abroad,) if leader is None else (abroad, leader)
        put(self._inputs, now_ns, self._encode(inputs if more == (None,) else (*inputs, *more)))
        put(self._decision, now_ns, self._encode(decision))

    # -- publishing ------------------------------------------------------------------------------------------------
    def report(self, now_ns: int, goal: Goal, dt: float) -> None:  # noqa: ARG002 - what every tick knows
        """Publish the state; status and events as they fall due."""
        agent = self._agent
        due = now_ns - self._stated_ns >= self.state_ns - 0.5e9 * agent.period_s
        if due and agent.may_speak and agent.sound_ns:  # who never knew where it is has no state
            self._stated_ns = now_ns
            agent.bus.put_state(encode(self._boat_state(now_ns)))
        self._note_changes()
        changed = bool(agent.orders.notes)
        for kind, text, value in agent.orders.notes:
            self._event(now_ns, kind, text, value)
        agent.orders.notes.clear()
        if changed or now_ns - self._status_ns >= STATUS_S * 1e9 or agent.reasons != self._reasons:
            self._reasons = int(agent.reasons)
            self._status_ns = now_ns
            self._publish_status(now_ns)
        if self._records and now_ns - self._viewed_ns >= VIEWER_S * 1e9:
            self._viewed_ns = now_ns
            self._record_view(now_ns)

    def _nearest(self) -> tuple[str, float]:
        agent = self._agent
        x, y = agent.nav.x, agent.nav.y
        number, least = -1.0, math.inf
        for peer in agent.peers:
            d = math.hypot(peer.x - x, peer.y - y)
            if d < least:
                least, number = d, peer.number
        name = agent.picture.name_of(number)
        return name, least if name else 0.0

    def _boat_state(self, now_ns: int) -> BoatState:
        agent, d = self._agent, self._agent.decision
        nav, sailing = agent.nav, agent.orders.sailing
        assert agent.plane is not None
        lat_deg, lon_deg = agent.plane.to_geographic(nav.x, nav.y)  # without navigation: where it was last
        lost_s = (now_ns - agent.sound_ns) * 1e-9
        nearest, nearest_m = self._nearest()
        self._seq += 1
        path = agent.course.path
        on_mission = agent.course.kind == "mission"
        return BoatState(
            major=MAJOR,
            boat=agent.boat,
            epoch=self._epoch,
            seq=self._seq,
            stamp_ns=now_ns,
            clock_ns=agent.clock_ns,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            cog_rad=d.chi,
            sog_mps=d.U,
            heading_rad=nav.psi if nav.sound > 0.5 else 0.0,
            yaw_rate_radps=nav.r,
            position_error_m=nav.sigma + min(DRIFTS_MPS * lost_s, agent.radius_m / 4.0),
            lap=math.floor(d.s / path.length) if path.closed else 0,
            s_m=d.s,
            mode=int(d.mode),
            reasons=int(agent.reasons),
            plan_course_rad=math.atan2(d.gy, d.gx),
            plan_speed_mps=d.u_plan,
            tangent_rad=math.atan2(d.ty, d.tx),
            straight_s=d.straight,
            decided_yaw_rate_radps=d.r_d,
            decided_speed_mps=d.u_d,
            cross_track_m=d.y_e if on_mission else 0.0,
            along_path_m=d.e if on_mission else 0.0,
            nearest=nearest,
            nearest_m=nearest_m,
            mission_id=sailing.order.mission_id if sailing is not None else "",
            in_force=sailing.formation.revision if sailing is not None else Revision(),
            held=sailing.held if sailing is not None else Revision(),
            stops=tuple(agent.orders.stops),
            simulated=agent.driver.simulated,
            control=agent.orders.control,
            length_m=agent.params.limits.length_m,
            foreign=agent.lookout.order(),
        )

    def _note_changes(self) -> None:
        """Mode changes, avoidance begun and ended."""
        agent, d = self._agent, self._agent.decision
        if d.mode != self._mode:
            if self._mode >= 0.0:
                why = ", ".join(in_words(agent.reasons))
                text = f"{mode_word(int(self._mode))} -> {mode_word(int(d.mode))}" + (f": {why}" if why else "")
                agent.orders.note("mode", text, d.mode)
            self._mode = d.mode
        for kind, text in agent.lookout.notes():
            agent.orders.note(kind, text)
        by_fleet = not agent.lookout.acting or bool(agent.picture.name_of(d.target))  # else the lookout has said it
        if d.avoiding != self._avoiding or (d.avoiding > 0.5 and d.target != self._target):
            if d.avoiding > 0.5 and by_fleet:
                side = SIDES.get(d.side, "")
                name = agent.picture.name_of(d.target) or "others"
                agent.orders.note("avoid", f"keeping clear of {name}" + (f", leaving it to {side}" if side else ""))
            elif d.avoiding < 0.5 and self._target < FOREIGN_FROM:
                agent.orders.note("avoid", "clear")
            self._avoiding, self._target = d.avoiding, d.target

    def _event(self, now_ns: int, kind: str, text: str, value: float) -> None:
        boat = self._agent.boat
        self._agent.bus.put(keys.EVENT, encode(FleetEvent(MAJOR, boat, now_ns, kind, text, value)))
        event = topics.Event(stamp_ns=now_ns, boat=boat, kind=kind, text=text, value=value)
        self.recording.put(topics.EVENT, now_ns, topics.encode(event))

    def _publish_status(self, now_ns: int) -> None:
        agent = self._agent
        sailing, picture, counters = agent.orders.sailing, agent.picture, self.counters
        refusals = [pair for one in (picture.refused, agent.desk.refused, agent.links) for pair in one.most_common(5)]
        status = BoatStatus(
            major=MAJOR,
            boat=agent.boat,
            epoch=self._epoch,
            stamp_ns=now_ns,
            version=__version__,
            mode=mode_word(int(agent.decision.mode)),
            reasons=(*in_words(int(agent.reasons)), *agent.reading.amiss),
            mission_id=sailing.order.mission_id if sailing is not None else "",
            mission_title=sailing.plan.mission.title if sailing is not None else "",
            controller=agent.orders.control.operator,
            spacing_m=sailing.formation.spacing_m if sailing is not None else 0.0,
            cruise_mps=sailing.formation.cruise_mps if sailing is not None else 0.0,
            battery_percent=agent.reading.battery_percent,
            peers=sum(other.track is not None for other in picture.others.values()),
            ticks=counters.ticks,
            ticks_late=counters.late,
            worst_late_ms=counters.worst_late_ms,
            messages_heard=sum(other.heard for other in picture.others.values()),
            messages_lost=sum(other.lost for other in picture.others.values()),
            messages_refused=picture.refused.total(),
            requests_refused=agent.desk.refused.total(),
            recording=self.recording.trouble,
            driver=agent.driver_trouble or agent.reading.authority,
            hull=sailing.plan.boats[sailing.number].hull if sailing is not None else "",
            refusals=tuple(f"{count} x {why}" for why, count in refusals),
            switched_ns=sailing.switched_ns if sailing is not None else 0,
            pattern=sailing.shape.pattern if sailing is not None else "",
            lateral_m=sailing.shape.lateral_m if sailing is not None else 0.0,
            slot=sailing.shape.slots[sailing.number] if sailing is not None else 0.0,
            traffic=(*agent.lookout.words(), *agent.lookout.outlook.words()),
            security=agent.security(),
            roster=agent.guard.trust.roster.number if agent.guard.trust is not None else 0,
            autopilot=agent.autopilot.sysid if agent.autopilot is not None else 0,
            takes_frames=agent.autopilot is not None and agent.autopilot.takes_frames,
        )
        counters.worst_late_ms = 0.0
        agent.bus.put(keys.STATUS, encode(status))
        recorded = topics.Status(
            stamp_ns=now_ns,
            ticks=status.ticks,
            ticks_late=status.ticks_late,
            messages_sent=self._seq,
            messages_received=status.messages_heard,
            messages_lost=status.messages_lost,
            messages_refused=status.messages_refused,
            records_dropped=self.recording.dropped,
            recording=status.recording,
        )
        self.recording.put(self._status_topic, now_ns, topics.encode(recorded))

    def _record_view(self, now_ns: int) -> None:
        """Position and state for viewers, twice a second; every tick is in the inputs."""
        agent, d, nav, sailing = self._agent, self._agent.decision, self._agent.nav, self._agent.orders.sailing
        if agent.plane is None or nav.sound < 0.5:
            return
        lat_deg, lon_deg = agent.plane.to_geographic(nav.x, nav.y)
        fix = topics.location_fix(now_ns, agent.boat, lat_deg, lon_deg, nav.sigma * nav.sigma)
        self.recording.put(self._fix_topic, now_ns, fix)
        nearest, nearest_m = self._nearest()
        state = topics.State(
            stamp_ns=now_ns,
            x_m=nav.x,
            y_m=nav.y,
            psi_rad=nav.psi,
            sog_mps=d.U,
            u_d_mps=d.u_d,
            s_m=d.s,
            lap=math.floor(d.s / agent.course.path.length) if agent.course.path.closed else 0,
            mode=mode_word(int(d.mode)),
            reasons=list(in_words(int(agent.reasons))),
            y_e_m=d.y_e,
            e_s_m=d.e,
            spacing_m=sailing.formation.spacing_m if sailing is not None else None,
            offset_m=agent.offset_m,
            cruise_mps=sailing.formation.cruise_mps if sailing is not None else None,
            nearest=nearest,
            nearest_m=nearest_m,
            avoiding=d.avoiding > 0.5,
            side=SIDES.get(d.side, ""),
            mission_id=sailing.order.mission_id if sailing is not None else "",
            revision=sailing.formation.revision.counter if sailing is not None else 0,
        )
        self.recording.put(self._state_topic, now_ns, topics.encode(state))

    def late(self, periods: int, late_ms: float) -> None:
        """The loop was late, and skipped so many ticks."""
        self.counters.late += periods
        self.counters.worst_late_ms = max(self.counters.worst_late_ms, late_ms)

    @property
    def mode(self) -> Mode:
        """The mode last published."""
        return Mode(int(self._agent.decision.mode))
