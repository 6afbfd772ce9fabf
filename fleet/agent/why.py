"""Why a boat does what it does, as far as `step`, the picture and the disk know: named reasons for its status."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fleet.agent.modes import Mode, Reason

if TYPE_CHECKING:
    from fleet.agent.agent import Agent

STUCK_S = 10.0
OUT_OF_REACH_S = 180.0  # exchanging places at the limits of speed takes half of it


class Why:
    """What is wrong with one boat, and for how long."""

    def __init__(self, agent: Agent) -> None:
        self._agent = agent
        self._stuck_s = self._late_s = 0.0

    def reasons(self, now_ns: int, dt: float) -> Reason:
        """What `step`, the picture and the disk have to say."""
        agent = self._agent
        d, why = agent.decision, Reason(0)
        if d.mode == Mode.FAULT or agent.nav.sound < 0.5:
            why |= Reason.NAVIGATION
        if d.avoiding > 0.5:
            why |= Reason.AVOIDING
        if d.braking > 0.5:
            why |= Reason.BRAKING
        if agent.lookout.acting:
            why |= Reason.FOREIGN
        following = d.mode in (Mode.FOLLOW, Mode.AVOID)
        self._stuck_s = self._stuck_s + dt if following and d.avoiding > 0.5 and d.U < 0.1 else 0.0
        if self._stuck_s > STUCK_S:
            why |= Reason.BOXED_IN
        self._late_s = self._late_s + dt if following and abs(d.e) > 5.0 else 0.0
        if self._late_s > OUT_OF_REACH_S:
            why |= Reason.SLOT_OUT_OF_REACH
        if agent.state.ended > 0.5:
            why |= Reason.MISSION_ENDED
        if agent.wings.lost_ns:
            why |= Reason.LEADER_LOST
        if agent.wings.stopped:
            why |= Reason.LEADER_STOPPED
        if agent.store.trouble:
            why |= Reason.STORE
        if agent.reporter.recording.trouble:
            why |= Reason.NOT_RECORDING
        if now_ns - agent.picture.own_name_heard_ns < 5e9 and agent.picture.own_name_heard_ns:
            why |= Reason.IDENTITY_CLASH
        return why | self._others_reasons(now_ns)

    def _others_reasons(self, now_ns: int) -> Reason:
        agent = self._agent
        why = Reason(0)
        sailing = agent.orders.sailing
        for other in agent.picture.others.values():
            if other.second is not None and agent.picture.clashes(other, now_ns):
                why |= Reason.IDENTITY_CLASH
            if other.track is None or sailing is None or other.name not in agent.picture.roster:
                continue
            if other.name in agent.picture.silent_names:
                why |= Reason.PEER_SILENT
            elif other.track.state.mission_id not in ("", sailing.order.mission_id):
                why |= Reason.PEER_ELSEWHERE
        return why
