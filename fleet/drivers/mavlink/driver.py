"""A boat steered by an autopilot: see `fleet.drivers.seam.Driver`, and docs/drivers-mavlink.md.

No thread: `read` takes in what arrived and keeps the talk going, `write` sends a set-point or says why not. When the
loop stands still so does everything that we send, and the autopilot's own dead-man acts.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from msgspec import structs

from fleet.drivers.mavlink import words
from fleet.drivers.mavlink.config import MavlinkConfig
from fleet.drivers.mavlink.frames import Frames
from fleet.drivers.mavlink.handing import Handing
from fleet.drivers.mavlink.link import link_to
from fleet.drivers.mavlink.signing import Signing
from fleet.drivers.mavlink.talk import Talk
from fleet.drivers.mavlink.vehicle import SILENT_S, Vehicle
from fleet.drivers.seam import Reading
from fleet.errors import ConfigError

HEARTBEAT_S = 1.0
COMMAND_AGE_S = 0.5  # a set-point decided on a reading that is older is not sent
SETPOINT_S = 0.05  # between two set-points
WANTED_S = 2.5  # the boat is to be driven: a set-point was handed in so lately; an agent in trouble tries each second
STAY_S = 4.0  # after the last one the boat is left to the autopilot's LOITER; it brakes until then
LEAD_S = 5.0  # a launch takes effect within: the boat is made ready for it at once
PERMIT_S = 60.0  # after an operator's word: for so long we may take the boat and arm it
AGAIN_S, ARM_AGAIN_S = 1.5, 2.0  # between two requests
REOPEN_S = 2.0
STREAM_PERIODS = 3.0  # a stream that is older is asked for again
STREAMS: dict[int, float] = {  # message -> Hz
    words.GLOBAL_POSITION_INT: 10.0,
    words.ATTITUDE: 10.0,
    words.EKF_STATUS_REPORT: 2.0,
    words.GPS_RAW_INT: 5.0,
    words.SYS_STATUS: 1.0,
}
WANTED = frozenset((words.HEARTBEAT, words.STATUSTEXT, words.COMMAND_ACK, words.PARAM_VALUE, *STREAMS))
SETS_OFF = frozenset(("launch", "resume", "return"))
PERMITS = SETS_OFF | {"take"}
WITHDRAWS = frozenset(("hold", "abort", "stop-now"))
NS = 1e-9


class MavlinkDriver:
    """An autopilot and its boat."""

    def __init__(self, config: MavlinkConfig, now_ns: Callable[[], int], *, simulated: bool = False) -> None:
        """Args: config: checked here, ConfigError; now_ns: the agent's clock; simulated: the boat is not there."""
        config.check()
        mavlink = words.dialect()
        self.simulated = simulated
        self.config, self._now_ns = config, now_ns
        self.vehicle = Vehicle()
        self.frames = Frames(mavlink, config.sysid, words.AUTOPILOT_COMPONENT, WANTED)
        self.talk = Talk(mavlink, config.own_sysid, config.sysid)
        self.link = link_to(config.endpoint)
        self._handing = Handing(config.sysid, config.own_sysid) if config.forward != "off" else None
        self.frames.tap = self._handing.tap if self._handing is not None else None
        self._signing = Signing(config.signing_key) if config.signing_key else None
        self._codecs = (self.talk.codec, self.frames.codec)
        self.parameters: dict[str, float] = {}  # as they arrive
        self._said: list[str] = []
        self._reboots = 0
        self._taken = False  # we drive the boat, or did last
        self._guided = False  # the mode was GUIDED at the reading before
        self._parked = -1  # the mode in which we left the boat ourselves
        self._permit_ns = self._wanted_ns = self._read_ns = self._began_ns = 0
        self._asked_ns: dict[str, int] = {}  # what -> when we asked for it last

    # -- the seam --------------------------------------------------------------------------------------------------
    def open(self) -> None:
        """Connect; the autopilot may come later."""
        self.link.open()
        self._began_ns = self._now_ns()
        if self._signing is not None:
            self._signing.begin(self._codecs, self._began_ns)
        self._converse(self._began_ns)

    def read(self) -> Reading:
        """The newest reading."""
        now_ns = self._read_ns = self._now_ns()
        for payload in self.link.receive():
            frames = self.frames
            for message in frames.datagram(payload) if self.link.datagrams else frames.stream(payload):
                self._take(message, now_ns)
        vehicle, was_guided = self.vehicle, self._guided
        self._guided = vehicle.mode == words.GUIDED
        if was_guided and not self._guided and vehicle.mode != self._parked:
            self._permit_ns = 0  # somebody else does not want it so
        self._taken = self._taken and vehicle.armed and self._guided
        self._converse(now_ns)
        reading = vehicle.reading(now_ns)
        authority, trouble = self._authority(now_ns), self._trouble(now_ns)
        return structs.replace(reading, authority=authority, trouble=trouble) if authority or trouble else reading

    def write(self, surge_mps: float, yaw_rate_radps: float) -> str:
        """Command the boat; '' or why it could not be done."""
        now_ns = self._now_ns()
        self._wanted_ns = max(self._wanted_ns, now_ns)
        if not math.isfinite(surge_mps + yaw_rate_radps):
            return f"set-point {surge_mps:g} m/s, {yaw_rate_radps:g} rad/s: expected numbers"
        if (now_ns - self._read_ns) * NS > COMMAND_AGE_S:
            return "the set-point is older than its limit"
        return self._not_driving(now_ns) or self._send_setpoint(now_ns, surge_mps, yaw_rate_radps)

    def neutral(self) -> None:
        """Stop: zero velocity, then the autopilot's own LOITER, or HOLD where it has no position."""
        now_ns, vehicle = self._now_ns(), self.vehicle
        if not self._taken:
            return  # a ground station may steer in GUIDED too
        if vehicle.lost(now_ns):  # zero by a velocity that is not known would drive the boat
            self._park(now_ns, words.HOLD)
            return
        self._send_setpoint(now_ns, 0.0, 0.0)
        if (now_ns - self._wanted_ns) * NS > STAY_S:
            self._park(now_ns, words.HOLD if self.config.stop == "hold" else words.LOITER)

    def close(self) -> None:
        """Leave the boat stopped, on station where it has a position, and disconnect."""
        now_ns, vehicle = self._now_ns(), self.vehicle
        if self.link.up and self._taken:
            self._send_setpoint(now_ns, 0.0, 0.0)
            stays = self.config.stop == "loiter" and not vehicle.lost(now_ns)
            for confirmation in range(3):  # nobody waits for the answer
                self.link.send(self.talk.set_mode(words.LOITER if stays else words.HOLD, confirmation))
        self.link.close()

    # -- an operator's word ----------------------------------------------------------------------------------------
    def obeyed(self, kind: str) -> None:
        """An operator's command was accepted: some let us take the boat, and arm it if the configuration does."""
        if kind in PERMITS:
            self._permit_ns = self._now_ns()
            if kind in SETS_OFF:
                self._wanted_ns = self._permit_ns + int(LEAD_S / NS)
        elif kind in WITHDRAWS:
            self._permit_ns, self._wanted_ns = 0, min(self._wanted_ns, self._now_ns())

    @property
    def armed(self) -> bool:
        """Whether the autopilot is, as its HEARTBEAT says."""
        return self.vehicle.armed

    def disarm(self) -> None:
        """Ask for it, once; an agent never does, a person at the quay may."""
        self.link.send(self.talk.arm(False))

    # -- ground stations -------------------------------------------------------------------------------------------
    @property
    def sysid(self) -> int:
        """Of the autopilot; 0: its frames are not passed on."""
        return self.config.sysid if self._handing is not None else 0

    @property
    def takes_frames(self) -> bool:
        """Whether ground stations may speak to it."""
        return self.config.forward == "both"

    def hand_in(self, frames: bytes) -> str:
        """A ground station listens; its frames for the autopilot, if any. '' or why they do not go on."""
        if self._handing is None:
            return "nothing is passed on"
        now_s = self._now_ns() * NS
        self._handing.listened(now_s)
        if not frames:
            return ""
        if not self.takes_frames:
            return 'driver.mavlink.forward is not "both"'
        passed, why = self._handing.take(frames, now_s, driving=self._taken)
        for frame in passed:
            why = self.link.send(frame) or why
        return why

    def handed_on(self) -> bytes:
        """Frames of the autopilot since the last call, as they came, while somebody listens."""
        return self._handing.give(self._now_ns() * NS) if self._handing is not None else b""

    def said(self) -> list[str]:
        """What the autopilot said since the last call, for the operator."""
        while self.vehicle.texts:
            self._said.append(self.vehicle.texts.popleft()[1])
        said, self._said = self._said, []
        return list(dict.fromkeys(said))

    # -- hearing ---------------------------------------------------------------------------------------------------
    def _take(self, message: object, now_ns: int) -> None:
        number: int = message.get_msgId()  # type: ignore[attr-defined]
        if number == words.COMMAND_ACK:
            self._acknowledged(message.command, message.result, message.target_system)  # type: ignore[attr-defined]
        elif number == words.PARAM_VALUE:
            self.parameters[message.param_id] = message.param_value  # type: ignore[attr-defined]
        else:
            self.vehicle.take(message, now_ns)

    def _acknowledged(self, command: int, result: int, target: int) -> None:
        if target not in (0, self.config.own_sysid) or result == words.ACCEPTED:
            return  # the HEARTBEAT tells whether it was done
        what = {
            words.DO_SET_MODE: "mode change",
            words.ARM_DISARM: "arming",
            words.SET_MESSAGE_INTERVAL: "rate of a message",
        }.get(command, f"command {command}")
        self._said.append(f"{what}: {words.RESULTS.get(result, f'result {result}')}")

    # -- talking ---------------------------------------------------------------------------------------------------
    def _due(self, what: str, now_ns: int, every_s: float) -> bool:
        """Whether something is to be said again; notes that it is."""
        last = self._asked_ns.get(what, 0)
        if last and (now_ns - last) * NS < every_s:
            return False
        self._asked_ns[what] = now_ns
        return True

    def _converse(self, now_ns: int) -> None:
        """HEARTBEAT, streams, mode and arming, as they fall due."""
        if not self.link.up:
            if self._due("reopen", now_ns, REOPEN_S):
                try:
                    self.link.open()
                except ConfigError:
                    return
            return
        if self._due("heartbeat", now_ns, HEARTBEAT_S):
            if self._signing is not None:
                self._signing.follow(self._codecs, now_ns)
            self.link.send(self.talk.heartbeat())
        if self.vehicle.reboots != self._reboots:
            self._reboots = self.vehicle.reboots
            self._permit_ns, self._parked = 0, -1
            self._said.append("the autopilot was restarted")
        if self.vehicle.silent_s(now_ns) > SILENT_S:
            return
        self._ask_stream(now_ns)
        if self._wanted_ns and (now_ns - self._wanted_ns) * NS < WANTED_S:
            self._take_up(now_ns)

    def _ask_stream(self, now_ns: int) -> None:
        """Ask for one stream that does not come as often as it should."""
        for message, hz in STREAMS.items():
            age_s = (now_ns - self.vehicle.seen_ns.get(message, self._began_ns)) * NS
            asked = f"stream {message}" in self._asked_ns
            overdue = age_s * hz > STREAM_PERIODS
            if (not asked or overdue) and self._due(f"stream {message}", now_ns, AGAIN_S):
                self.link.send(self.talk.rate(message, hz))
                return

    def _take_up(self, now_ns: int) -> None:
        """Bring a boat that is to be driven to GUIDED and armed, one step at a time, as far as we may."""
        vehicle = self.vehicle
        if vehicle.mode == words.INITIALISING:
            return  # acknowledged then, and forgotten
        if vehicle.mode != words.GUIDED:
            if self._ours(now_ns) and self._due("guided", now_ns, AGAIN_S):
                self.link.send(self.talk.set_mode(words.GUIDED))
            return
        if vehicle.armed:
            self._taken, self._parked = True, -1
            self._permit_ns = 0  # used: whoever takes the boat now keeps it
            return
        if self._may_arm(now_ns) and vehicle.ready and self._due("arm", now_ns, ARM_AGAIN_S):
            self.link.send(self.talk.arm(True))

    def _park(self, now_ns: int, mode: int) -> None:
        """Leave the boat to the autopilot in a mode of our choice."""
        self._parked = mode
        if self._due("park", now_ns, AGAIN_S):
            self.link.send(self.talk.set_mode(mode))

    def _send_setpoint(self, now_ns: int, surge_mps: float, yaw_rate_radps: float) -> str:
        if not self._due("setpoint", now_ns, SETPOINT_S):
            return ""
        boot_ms = (now_ns - self._began_ns) // 1_000_000
        return self.link.send(self.talk.setpoint(boot_ms, surge_mps, yaw_rate_radps))

    # -- judging ---------------------------------------------------------------------------------------------------
    def _permitted(self, now_ns: int) -> bool:
        return bool(self._permit_ns) and (now_ns - self._permit_ns) * NS < PERMIT_S

    def _may_arm(self, now_ns: int) -> bool:
        return self.config.arm == "operator" and self._permitted(now_ns)

    def _ours(self, now_ns: int) -> bool:
        """Whether the mode is one that we chose, or an operator lets us choose."""
        mode = self.vehicle.mode
        return mode == words.GUIDED or self._permitted(now_ns) or (mode == self._parked and not self.vehicle.critical)

    def _authority(self, now_ns: int) -> str:
        """Who commands the boat, if we do not."""
        vehicle = self.vehicle
        if vehicle.critical and vehicle.mode != words.GUIDED:
            self._parked = -1  # a failsafe acts: what becomes of the boat is an operator's to say
        if not vehicle.armed or vehicle.mode == words.INITIALISING or self._ours(now_ns):
            return ""
        name = words.mode_name(vehicle.mode)
        return f"failsafe {name}" if vehicle.critical else f"pilot or ground station: {name}"

    def _trouble(self, now_ns: int) -> str:
        """Why the boat cannot be commanded whatever is said."""
        silent_s = self.vehicle.silent_s(now_ns)
        if math.isinf(silent_s):
            hint = "; others speak there, is its sysid another?" if self.frames.counts["others"] else ""
            return f"no autopilot with sysid {self.config.sysid} at {self.config.endpoint}{hint}"
        return f"the autopilot is silent for {silent_s:.0f} s" if silent_s > SILENT_S else ""

    def _not_driving(self, now_ns: int) -> str:
        """Why the boat is not armed in GUIDED; '' when it is."""
        vehicle = self.vehicle
        trouble = self._trouble(now_ns)
        if trouble:
            return trouble
        if vehicle.mode == words.INITIALISING:
            return "the autopilot is starting"
        if vehicle.mode != words.GUIDED:
            name = words.mode_name(vehicle.mode)
            return f"waiting for GUIDED, in {name}" if self._ours(now_ns) else f"in {name}: not ours to change"
        if vehicle.armed:
            return ""
        if self.config.arm != "operator":
            return "not armed: somebody has to arm the boat"
        if not self._permitted(now_ns):
            return "not armed: an operator has to say launch, resume or take"
        return "arming" if vehicle.ready else f"cannot arm: {vehicle.why_not_ready(now_ns)}"
