"""The recording of a whole run: truth as the world tells it, and what the boats published, in one file."""

from __future__ import annotations

from fleet import __version__
from fleet.agent.modes import Reason, in_words, mode_word
from fleet.mission.pattern import PATTERNS
from fleet.mission.plan import Plan
from fleet.operator import Outcome
from fleet.recording import topics
from fleet.recording.runs import Run
from fleet.recording.seam import Attachment, NullRecorder, Recording
from fleet.recording.topics import Truth
from fleet.wire.messages import BoatState, BoatStatus, FleetEvent

FIX_NS = 500_000_000
LATEST_NS = 60_000_000_000  # ahead of the world's time


class RunRecorder:
    """Writes `run.mcap`."""

    def __init__(
        self,
        run: Run,
        plan: Plan,
        name: str,
        header: dict[str, str],
        mission_text: bytes,
        record: bool,
        flush_s: float = 1.0,
    ) -> None:
        self._plan = plan
        self._offsets = {boat.name: plan.shape.ahead(boat.number) for boat in plan.boats}
        self._now_ns = 0
        self.begins_ns = 1 << 62  # what was before the mission is not part of the run
        self._formation: dict[str, tuple[float, float, float]] = {}
        self._fixed_ns: dict[str, int] = {}
        self._seen: dict[str, tuple[int, int]] = {}
        self.recording: Recording = NullRecorder()
        if record:
            from fleet.recording.writer import Recorder

            facts = {"mission": name, "version": __version__, "boats": ",".join(self._offsets), **header}
            mission = Attachment("mission.toml", "application/toml", mission_text)
            self.recording = Recorder(run.recording, facts, [mission], wait=True, flush_s=flush_s)
        topics.declare_fleet(self.recording)
        for boat in self._offsets:
            topics.declare_boat(self.recording, boat, truth=True)
        for vessel in plan.mission.traffic:
            topics.declare_vessel(self.recording, vessel.name)

    def truth(self, truths: dict[str, Truth], traffic: dict[str, Truth]) -> None:
        """Where the hulls are, and the other vessels."""
        for vessel, truth in traffic.items():
            if truth.stamp_ns >= self.begins_ns:
                self.recording.put(topics.traffic_topic(vessel), truth.stamp_ns, topics.encode(truth))
        for boat, truth in truths.items():
            if truth.stamp_ns < self.begins_ns:
                continue
            self._now_ns = truth.stamp_ns
            self.recording.put(topics.truth_topic(boat), truth.stamp_ns, topics.encode(truth))

    def state(self, state: BoatState) -> None:
        """What a boat published; once a message."""
        boat = state.boat
        if not self._believed(boat, state.stamp_ns) or self._seen.get(boat) == (state.epoch, state.seq):
            return
        self._seen[boat] = (state.epoch, state.seq)
        x, y = self._plan.plane.to_local(state.lat_deg, state.lon_deg)
        launched = (self._plan.shape.spacing_m, 0.0, self._offsets[boat])
        spacing, cruise, offset = self._formation.get(boat, launched)
        message = topics.State(
            stamp_ns=state.stamp_ns,
            x_m=x,
            y_m=y,
            psi_rad=state.heading_rad,
            sog_mps=state.sog_mps,
            u_d_mps=state.decided_speed_mps,
            s_m=state.s_m,
            lap=state.lap,
            mode=mode_word(state.mode),
            reasons=list(in_words(state.reasons)),
            y_e_m=state.cross_track_m,
            e_s_m=state.along_path_m,
            spacing_m=spacing,
            offset_m=offset,
            cruise_mps=cruise,
            nearest=state.nearest,
            nearest_m=state.nearest_m,
            avoiding=bool(state.reasons & Reason.AVOIDING),
            mission_id=state.mission_id,
            revision=state.in_force.counter,
        )
        self.recording.put(topics.state_topic(boat), state.stamp_ns, topics.encode(message))
        if state.stamp_ns - self._fixed_ns.get(boat, 0) >= FIX_NS:
            self._fixed_ns[boat] = state.stamp_ns
            variance = state.position_error_m * state.position_error_m
            fix = topics.location_fix(state.stamp_ns, boat, state.lat_deg, state.lon_deg, variance)
            self.recording.put(topics.fix_topic(boat), state.stamp_ns, fix)

    def _believed(self, boat: str, stamp_ns: int) -> bool:
        """Only boats of the mission, and only times that the world has seen: anybody may write on the bus."""
        return boat in self._offsets and self.begins_ns <= stamp_ns <= self._now_ns + LATEST_NS

    def status(self, status: BoatStatus) -> None:
        """A boat's counters."""
        if status.boat not in self._offsets:
            return
        pattern = PATTERNS.get(status.pattern, PATTERNS["column"])
        ahead, _ = pattern.place(status.slot, status.spacing_m, status.lateral_m)
        self._formation[status.boat] = (status.spacing_m, status.cruise_mps, ahead)
        message = topics.Status(
            stamp_ns=status.stamp_ns,
            ticks=status.ticks,
            ticks_late=status.ticks_late,
            messages_received=status.messages_heard,
            messages_lost=status.messages_lost,
            messages_refused=status.messages_refused,
            recording=status.recording,
        )
        self.recording.put(topics.status_topic(status.boat), status.stamp_ns, topics.encode(message))

    def event(self, event: FleetEvent) -> None:
        """Something that a boat told."""
        if event.boat not in self._offsets:
            return
        message = topics.Event(
            stamp_ns=event.stamp_ns, boat=event.boat, kind=event.kind, text=event.text, value=event.value
        )
        self.recording.put(topics.EVENT, event.stamp_ns, topics.encode(message))

    def happened(self, now_ns: int, kind: str, text: str, boat: str = "", value: float = 0.0) -> None:
        """Something that the simulator did."""
        message = topics.Event(stamp_ns=now_ns, boat=boat, kind=kind, text=text, value=value)
        self.recording.put(topics.EVENT, now_ns, topics.encode(message))

    def command(self, now_ns: int, outcome: Outcome) -> None:
        """What an operator said, and the answers."""
        acks = {
            boat: "not answered" if ack is None else ("acknowledged" if ack.ok else f"refused: {ack.reason}")
            for boat, ack in outcome.acks.items()
        }
        message = topics.Command(stamp_ns=now_ns, command=outcome.command, old=outcome.old, new=outcome.new, acks=acks)
        self.recording.put(topics.COMMAND, now_ns, topics.encode(message))
