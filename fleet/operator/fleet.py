"""A fleet as an operator's script sees it.

with Fleet("demo", connect=["tcp/127.0.0.1:7447"], operator="anna") as fleet:
    print(fleet.set_spacing(-20.0).lines())
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence

from fleet import __version__
from fleet.errors import FleetError, NobodyReachable, UsageError
from fleet.mission.change import changed, words
from fleet.mission.check import check
from fleet.mission.load import decode as decode_mission
from fleet.mission.load import encode as encode_mission
from fleet.mission.model import Mission
from fleet.operator.connection import ASK_AGAIN_S, Connection
from fleet.operator.outcome import Outcome
from fleet.operator.view import Change
from fleet.wire import keys
from fleet.wire.codec import Refused, decode, decode_mission_order
from fleet.wire.formation import order_for
from fleet.wire.messages import (
    MAJOR,
    Ack,
    Held,
    MissionOrder,
    Revision,
)


class Fleet(Connection):
    """A connection to a fleet. Commands wait at most `timeout_s` and name every boat that did not answer."""

    def mission_of(self, boat: str) -> tuple[str, Mission] | None:
        """(mission id, mission) that one boat holds; None when it holds none, or does not answer."""
        answer = self._bus.ask_all(keys.MISSION, b"", min(1.0, self.timeout_s), boat).get(boat)
        try:
            held = decode(answer, Held) if answer is not None else None
            order = decode_mission_order(held.order) if held is not None and held.order is not None else None
        except Refused:
            return None
        return (order.mission_id, decode_mission(order.mission)) if order is not None else None

    def formation(self) -> Change:
        """The formation that the boats hold; FleetError when they hold none, or none answers."""
        held = self._held_by_anybody(patient=True)
        if held is None:
            if not self._bus.alive():
                raise NobodyReachable(f"no boat of fleet {self.fleet!r} is in reach at {', '.join(self._connect)}")
            raise FleetError(f"no boat of fleet {self.fleet!r} holds a mission: `fleet launch MISSION` first")
        return held

    def launch(self, mission: Mission, *, apply_in_s: float = 2.0) -> Outcome:
        """Give the boats of the roster a mission; they begin together after `apply_in_s`."""
        findings = check(mission)
        if findings.problems:
            from fleet.errors import MissionError

            raise MissionError("mission", findings.problems)
        roster = [boat.name for boat in mission.boats]
        stamp_ns = self._clock.time_ns()
        order = MissionOrder(
            MAJOR, f"{stamp_ns}-{self.operator}", self.operator, stamp_ns, encode_mission(mission), apply_in_s
        )
        outcome = self.command("launch", roster, order=self._words("mission", order), expected=roster)
        others = sorted({ack.version for ack in outcome.acks.values() if ack is not None} - {"", __version__})
        note = f"boats run fleet {', '.join(others)}, this is {__version__}" if others else ""
        return Outcome("launch", outcome.id, outcome.acks, outcome.old, mission.title, note)

    def set_spacing(self, spacing_m: float, *, apply_in_s: float = 2.0) -> Outcome:
        """Change the formation distance on all boats together."""
        return self.set("spacing", spacing_m, apply_in_s=apply_in_s)

    def set_speed(self, cruise_mps: float, *, apply_in_s: float = 2.0) -> Outcome:
        """Change the cruise speed on all boats together."""
        return self.set("speed", cruise_mps, apply_in_s=apply_in_s)

    def set_pattern(self, pattern: str, *, apply_in_s: float = 2.0) -> Outcome:
        """Draw the fleet up in another pattern; each boat takes the slot that makes all ways together shortest."""
        return self.set("pattern", pattern, apply_in_s=apply_in_s)

    def set_lateral(self, lateral_m: float, *, apply_in_s: float = 2.0) -> Outcome:
        """Change the distance abeam from slot to slot on all boats together."""
        return self.set("lateral", lateral_m, apply_in_s=apply_in_s)

    def set_leader(self, boat: str, *, apply_in_s: float = 2.0) -> Outcome:
        """This boat leads: it and the leader exchange their slots."""
        return self.set("leader", boat, apply_in_s=apply_in_s)

    def set_slots(self, slots: Mapping[str, float], *, apply_in_s: float = 2.0) -> Outcome:
        """Give some boats other slots; the others keep theirs."""
        return self.set("slots", ",".join(f"{boat}={slot!r}" for boat, slot in slots.items()), apply_in_s=apply_in_s)

    def set(self, what: str, value: float | str, *, apply_in_s: float = 2.0) -> Outcome:
        """Change the formation on all boats together; `what` is a key of `fleet.mission.change.CHANGES`."""
        held = self.formation()
        shape = changed(held.roster, held.shape, what, value)
        revision = Revision(held.revision.counter + 1, self.operator)
        stamp_ns = self._clock.time_ns()
        order = order_for(shape, held.mission, held.mission_id, revision, held.revision, apply_in_s, stamp_ns)
        expected = sorted({*held.roster} | {b for b in self._bus.alive() if b in held.roster})
        outcome = self.command("set", (), order=self._words("formation", order), expected=expected)
        old, new = (words(held.roster, one, what) for one in (held.shape, shape))
        slots = words(held.roster, shape, "slots")
        note = f"slots {slots}" if what != "slots" and shape.slots != held.shape.slots else ""
        return Outcome(f"set {what}", outcome.id, outcome.acks, old, new, note)

    def send_roster(self) -> Outcome:
        """Bring boats and hubs this operator's roster; those that hold a newer one keep theirs."""
        trust = self.trust
        if trust is None:
            raise UsageError("sending the roster needs credentials; expected --credentials FOLDER")
        acks: dict[str, Ack | None] = dict.fromkeys((*self._bus.alive(), *(one.name for one in trust.members("hub"))))
        deadline = self._clock.monotonic() + self.timeout_s
        while (left := deadline - self._clock.monotonic()) > 0.0 and (None in acks.values() or not acks):
            for boat, answer in self._bus.ask_all(keys.ROSTER, trust.envelope, left).items():
                with contextlib.suppress(Refused):
                    acks[boat] = decode(answer, Ack)
            self._clock.sleep(min(ASK_AGAIN_S, max(0.0, deadline - self._clock.monotonic())))
        olds = {ack.old for ack in acks.values() if ack is not None and ack.old}
        return Outcome("roster", "", acks, " | ".join(sorted(olds)), str(trust.roster.number))

    # -- words -----------------------------------------------------------------------------------------------------
    def hold(self, boats: Sequence[str] = ()) -> Outcome:
        """Keep station."""
        return self.command("hold", boats)

    def resume(self, boats: Sequence[str] = (), *, at: str = "") -> Outcome:
        """Go on; after a restart `at` says where: `nearest`, or an abscissa in metres."""
        return self.command("resume", boats, text=at)

    def abort(self, boats: Sequence[str] = ()) -> Outcome:
        """End the mission, then hold."""
        return self.command("abort", boats)

    def return_home(self, boats: Sequence[str] = ()) -> Outcome:
        """Back along the travelled track to home, then hold."""
        return self.command("return", boats)

    def stop_now(self, boats: Sequence[str] = ()) -> Outcome:
        """No thrust, until released."""
        return self.command("stop-now", boats)

    def release(self, boats: Sequence[str] = (), ids: Sequence[str] = ()) -> Outcome:
        """Release stops: the ids named, else every one that the boats publish."""
        names = list(ids)
        if not names:
            deadline = self._clock.monotonic() + min(1.0, self.timeout_s)
            while self._clock.monotonic() < deadline:
                views = [view for view in self.look().values() if view.alive]
                if views and all(view.state is not None for view in views):
                    break
                self._clock.sleep(0.02)
            states = [view.state for view in self.look().values() if not boats or view.name in boats]
            names = sorted({stop for state in states if state is not None for stop in state.stops})
        return self.command("release", boats, names=names)

    def take(self) -> Outcome:
        """Take control."""
        return self.command("take")

    def forget(self, names: Sequence[str]) -> Outcome:
        """Tell the others that these silent boats are gone from the water."""
        reachable = [boat for boat in self._bus.alive() if boat not in names]
        return self.command("forget", (), names=names, expected=sorted(reachable))
