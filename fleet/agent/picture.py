"""The picture of the others: what they last said, how old it is, and what may still be believed of it.

Fed by the bus, asked once a tick. Everything that `step` gets of the others passes here, as numbers.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable
from operator import attrgetter

from msgspec import Struct, field

from fleet import ops
from fleet.agent.doubt import FASTEST_JUMP_MPS, Doubt, most_missed
from fleet.agent.modes import UNDER_ORDERS, Mode
from fleet.avoidance.reckoning import reckoned
from fleet.avoidance.types import Peer
from fleet.wire.bus import Heard
from fleet.wire.codec import Refused, decode_state
from fleet.wire.messages import BoatState

SILENT_PERIODS = 7.0  # 0.7 s at 10 Hz
SILENT_WITHOUT_TOKEN_S = 0.3
DISCIPLINED_NS = 100_000_000
CLASH_S = 1.0
FRESH_PERIODS = 1.5  # who was heard so lately still speaks
FARTHEST_M = 100_000.0  # beyond it nobody is a neighbour, and a flat sea is no good
JUMP_SLACK_M = 20.0
RETURN_RAMP_S = 2.0  # weight in the formation grows from 0 to 1, so that a return is no bump
AHEAD_S = 10.0  # a silent boat is anywhere between its last position and this far along its path
OLDEST_S = 30.0  # a stamp further from reception than this is a wrong clock, not a slow message
GROWS_MPS = 0.2
STRANGERS_FROM = 1000
MOST_OTHERS = 256

Along = Callable[[str, float], tuple[float, float] | None]
"""(boat, abscissa) -> its position on its path, if it sails our mission."""

_number = attrgetter("number")


Directions = tuple[float, float, float, float, float, float]


def directions(state: BoatState) -> Directions:
    """(vx, vy, gx, gy, tx, ty): velocity over ground [m/s], and the unit vectors of its planned course and its path."""
    sin_chi, cos_chi = ops.sincos(state.cog_rad)
    gy, gx = ops.sincos(state.plan_course_rad)
    ty, tx = ops.sincos(state.tangent_rad)
    return state.sog_mps * cos_chi, state.sog_mps * sin_chi, gx, gy, tx, ty


class Track(Struct):
    """One boat under one epoch: what it said last, in our local frame."""

    state: BoatState
    heard_ns: int
    x: float
    y: float
    vx: float
    vy: float
    gx: float
    gy: float
    tx: float
    ty: float
    lead_s: float  # age at reception, by stamps; negative when the clocks cannot tell


class Other(Struct):
    """Everything about one name."""

    name: str
    number: int
    track: Track | None = None
    second: Track | None = None  # of the other epoch, in a clash
    weight: float = 0.0
    clash_since_ns: int = 0  # since when two epochs alternate
    retired: dict[int, int] = {}  # epoch -> its last sequence number
    heard: int = 0
    lost: int = 0
    half_trip_s: float = -1.0  # half of the last echo's round trip
    doubt: Doubt = field(default_factory=Doubt)  # about its numbers or its place
    newcomer: Doubt = field(default_factory=Doubt)  # another process under its name, perhaps


class Picture:
    """The others as one boat sees them."""

    def __init__(self, boat: str, to_local: Callable[[float, float], tuple[float, float]], state_hz: float) -> None:
        self._boat, self._to_local = boat, to_local
        self._state_hz = state_hz
        self._silent_s = SILENT_PERIODS / state_hz
        self.others: dict[str, Other] = {}
        self.roster: dict[str, int] = {}
        self.silent_names: set[str] = set()  # as `peers` found them in this tick
        self.refused: Counter[str] = Counter()
        self.own_name_heard_ns = 0
        self.own_epoch = 0
        self._namesake = Doubt()
        self.own_clock_ns = DISCIPLINED_NS
        self.directions = directions  # a simulation works them out once for all who hear a message

    # -- who -------------------------------------------------------------------------------------------------------
    def set_roster(self, names: Iterable[str], to_local: Callable[[float, float], tuple[float, float]]) -> None:
        """Number the boats as the mission does, and project to its datum."""
        self._to_local = to_local
        self.roster = {name: number for number, name in enumerate(names)}
        strangers = STRANGERS_FROM
        for other in self.others.values():
            other.number = self.roster.get(other.name, strangers)
            strangers += other.name not in self.roster
            for track in (other.track, other.second):
                if track is not None:
                    track.x, track.y = to_local(track.state.lat_deg, track.state.lon_deg)

    def set_state_hz(self, state_hz: float) -> None:
        """How often the others publish: what silence means hangs on it."""
        self._state_hz = state_hz
        self._silent_s = SILENT_PERIODS / state_hz

    def watched(self, name: str) -> Other:
        """The entry of a name, made when new."""
        other = self.others.get(name)
        if other is None:
            number = self.roster.get(name)
            if len(self.others) >= MOST_OTHERS:
                self._drop_a_stranger()
            if number is None:
                taken = [o.number for o in self.others.values()]
                number = max([STRANGERS_FROM - 1, *taken]) + 1
            other = self.others[name] = Other(name, number)
        return other

    def _drop_a_stranger(self) -> None:
        """Forget the boat not of the mission that has been silent for longest: names cost nothing, memory does."""
        strangers = [other for other in self.others.values() if other.name not in self.roster]
        if strangers:
            oldest = min(strangers, key=lambda other: other.track.heard_ns if other.track is not None else 0)
            del self.others[oldest.name]

    def name_of(self, number: float) -> str:
        """The boat of a number; of both halves of a clash."""
        for other in self.others.values():
            if other.number == math.floor(number):
                return other.name
        return ""

    def forget(self, names: Iterable[str]) -> list[str]:
        """Silent boats that the operator knows to be gone; returns those that were forgotten."""
        gone: list[str] = []
        for name in names:
            other = self.others.get(name)
            if other is not None and other.track is not None:
                other.track = other.second = None
                other.weight = 0.0
                gone.append(name)
        return gone

    # -- hearing ---------------------------------------------------------------------------------------------------
    def hear(self, message: Heard) -> BoatState | None:
        """Take in a state; None, and a count, when it is refused."""
        try:
            state = decode_state(message.payload, message.sender)
            if message.sender == self._boat:
                self._hear_own_name(state, message.at_ns)
            believed = self._take(self.watched(message.sender), state, message.at_ns)
        except Refused as refusal:
            self.refused[str(refusal)] += 1
            return None
        return state if believed else None

    def _hear_own_name(self, state: BoatState, now_ns: int) -> None:
        """Own words that come back are nobody; another process that goes on speaking is."""
        if state.epoch == self.own_epoch:
            raise Refused("own words")
        told = max(state.clock_ns, self.own_clock_ns) <= DISCIPLINED_NS
        if told and not -0.5 < (now_ns - state.stamp_ns) * 1e-9 < OLDEST_S:
            raise Refused("replay")
        self._namesake.add(state, 0.0, 0.0, now_ns, self._state_hz)
        if self._namesake.settled(3, 0.0):
            self.own_name_heard_ns = now_ns
        raise Refused("own name")

    def _local(self, state: BoatState) -> tuple[float, float]:
        x, y = self._to_local(state.lat_deg, state.lon_deg)
        if not abs(x) + abs(y) <= FARTHEST_M:
            raise Refused("too far away")
        return x, y

    def _take(self, other: Other, state: BoatState, now_ns: int) -> bool:
        """Whether it now stands for the boat; not when it is the second one in a clash."""
        track = other.track
        if track is None:
            other.track = self._track(state, now_ns)
            other.heard += 1
        elif state.epoch == track.state.epoch:
            self._follow(other, track, state, now_ns)
        elif other.second is not None and state.epoch == other.second.state.epoch:
            self._speaks_on(other.second, state, now_ns)
            return False
        else:
            self._new_epoch(other, track, state, now_ns)
        return other.second is None

    def _follow(self, other: Other, track: Track, state: BoatState, now_ns: int) -> None:
        """The next message of the same process."""
        missed = state.seq - track.state.seq - 1
        if missed < 0:
            raise Refused("old or doubled")
        gap_s = max((now_ns - track.heard_ns) * 1e-9, 0.0)
        x, y = self._local(state)
        leapt = missed > most_missed(gap_s, self._state_hz)  # believed, it would shut out every true message after it
        if leapt or ops.hypot(x - track.x, y - track.y) > FASTEST_JUMP_MPS * gap_s + JUMP_SLACK_M:
            other.doubt.add(state, x, y, now_ns, self._state_hz)
            if not other.doubt.settled(10, 0.5):  # better late than an obstacle in the wrong place
                raise Refused("impossible sequence number" if leapt else "impossible jump")
        other.doubt.clear()
        other.heard += 1
        other.lost += min(missed, 1000)
        self._update(track, state, now_ns, x, y)

    def _new_epoch(self, other: Other, track: Track, state: BoatState, now_ns: int) -> None:
        """Another process under the same name: a restart, two boats with one name, or a replay."""
        last = other.retired.get(state.epoch)
        both_disciplined = max(state.clock_ns, track.state.clock_ns) <= DISCIPLINED_NS
        if last is not None and state.seq <= last:
            raise Refused("replay")
        speaks = (now_ns - track.heard_ns) * 1e-9 <= CLASH_S
        if (
            last is None
            and speaks
            and both_disciplined
            and track.lead_s >= 0.0
            and state.stamp_ns < track.state.stamp_ns
        ):
            raise Refused("replay")  # else a restart with a wrong clock would be ignored
        x, y = self._local(state)
        fresh = (now_ns - track.heard_ns) * 1e-9 <= FRESH_PERIODS / self._state_hz
        if fresh or other.second is not None:  # one forged message must not replace a boat that speaks
            other.newcomer.add(state, x, y, now_ns, self._state_hz)
            if not other.newcomer.settled(3, FRESH_PERIODS / self._state_hz):
                raise Refused("another start, not yet believed")
            other.second = self._track(state, now_ns)  # two live processes
            other.clash_since_ns = other.clash_since_ns or other.newcomer.since_ns
            return
        self._retire(other, track)
        other.retired.pop(state.epoch, None)
        other.track = self._track(state, now_ns)
        other.heard += 1

    @staticmethod
    def _retire(other: Other, track: Track) -> None:
        while len(other.retired) >= 64:
            del other.retired[next(iter(other.retired))]
        other.retired[track.state.epoch] = track.state.seq

    def _speaks_on(self, second: Track, state: BoatState, now_ns: int) -> None:
        if state.seq <= second.state.seq:
            raise Refused("replay")
        self._update(second, state, now_ns, *self._local(state))

    def _track(self, state: BoatState, now_ns: int) -> Track:
        x, y = self._local(state)
        track = Track(state, now_ns, x, y, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0)
        self._update(track, state, now_ns, x, y)
        return track

    def _update(self, track: Track, state: BoatState, now_ns: int, x: float, y: float) -> None:
        track.vx, track.vy, track.gx, track.gy, track.tx, track.ty = self.directions(state)
        track.x, track.y, track.state, track.heard_ns = x, y, state, now_ns
        lead_s = (now_ns - state.stamp_ns) * 1e-9
        disciplined = max(state.clock_ns, self.own_clock_ns) <= DISCIPLINED_NS
        track.lead_s = max(lead_s, 0.0) if disciplined and -0.5 < lead_s < OLDEST_S else -1.0

    # -- believing -------------------------------------------------------------------------------------------------
    def age_s(self, other: Other, track: Track, now_ns: int) -> tuple[float, float]:
        """Age of what it said, and how uncertain that age is [s]."""
        since = max((now_ns - track.heard_ns) * 1e-9, 0.0)
        if track.lead_s >= 0.0:
            return since + track.lead_s, (track.state.clock_ns + self.own_clock_ns) * 1e-9
        half_trip_s = other.half_trip_s if other.half_trip_s >= 0.0 else 1.0
        return since + half_trip_s, half_trip_s

    def silent(self, other: Other, now_ns: int, token_lost: bool) -> bool:
        """Not heard for 7 state periods, or for 0.3 s when its token is gone though our link is up."""
        if other.track is None:
            return True
        limit_s = min(SILENT_WITHOUT_TOKEN_S, self._silent_s) if token_lost else self._silent_s
        return (now_ns - other.track.heard_ns) * 1e-9 > limit_s

    def clashes(self, other: Other, now_ns: int) -> bool:
        """Two epochs have been alternating for a second. When one of them falls silent, the other is the boat."""
        track, second = other.track, other.second
        if track is None or second is None:
            return False
        if (now_ns - second.heard_ns) * 1e-9 > CLASH_S:
            self._retire(other, second)
            other.second, other.clash_since_ns = None, 0
            return False
        if (now_ns - track.heard_ns) * 1e-9 > CLASH_S:
            self._retire(other, track)
            other.retired.pop(second.state.epoch, None)
            other.track, other.second, other.clash_since_ns = second, None, 0
            return False
        return (now_ns - other.clash_since_ns) * 1e-9 >= CLASH_S

    def weigh(self, other: Other, present: bool, dt: float) -> float:
        """Its weight in the formation: away at once, back within two seconds."""
        other.weight = min(1.0, other.weight + dt / RETURN_RAMP_S) if present else 0.0
        return other.weight

    def peers(
        self, now_ns: int, gone: Callable[[str], bool], own: tuple[float, float], along: Along
    ) -> list[Peer[float]]:
        """Vehicles to keep clear of, by number; `gone` tells whose token is lost while our own link is up."""
        peers: list[Peer[float]] = []
        self.silent_names.clear()
        for other in sorted(self.others.values(), key=_number):
            clash = self.clashes(other, now_ns)
            track = other.track
            if track is None:
                continue
            if self.silent(other, now_ns, gone(other.name)):
                self.silent_names.add(other.name)
                peers.append(self._silent_peer(other, track, now_ns, own, along))
            else:
                peers.append(self._peer(other, track, now_ns, float(other.number), 0.0 if clash else 1.0))
            if other.second is not None:
                peers.append(self._peer(other, other.second, now_ns, other.number + 0.5, 0.0))
        return peers

    def _peer(self, other: Other, track: Track, now_ns: int, number: float, known: float) -> Peer[float]:
        age, uncertain = self.age_s(other, track, now_ns)
        age = min(age, AHEAD_S)
        state = track.state
        x, y, vx, vy = reckoned(track.x, track.y, track.vx, track.vy, state.yaw_rate_radps, age)
        widen = uncertain * state.sog_mps
        plan = known if state.mode in UNDER_ORDERS else 0.0
        return Peer(
            number=number,
            present=1.0,
            x=x,
            y=y,
            vx=vx,
            vy=vy,
            known=plan,
            gx=track.gx,
            gy=track.gy,
            u_d=state.plan_speed_mps,
            tx=track.tx,
            ty=track.ty,
            straight=state.straight_s,
            sigma=state.position_error_m,
            widen=widen,
            y_e=0.0 if state.mode == Mode.HOLD else state.cross_track_m,
            r=state.yaw_rate_radps,
        )

    def _silent_peer(
        self, other: Other, track: Track, now_ns: int, own: tuple[float, float], along: Along
    ) -> Peer[float]:
        """A boat not heard: at the point nearest to us between its last position and its prediction, standing still."""
        age, _ = self.age_s(other, track, now_ns)
        ahead = min(age, AHEAD_S)
        state = track.state
        end = along(other.name, state.s_m + state.sog_mps * ahead) if state.mode != Mode.HOLD else None
        x1, y1 = end if end is not None else (track.x + track.vx * ahead, track.y + track.vy * ahead)
        if ops.hypot(x1 - track.x, y1 - track.y) > state.sog_mps * ahead + 5.0:  # it was off its path
            x1, y1 = track.x + track.vx * ahead, track.y + track.vy * ahead
        dx, dy = x1 - track.x, y1 - track.y
        length_sq = dx * dx + dy * dy
        share = ((own[0] - track.x) * dx + (own[1] - track.y) * dy) / length_sq if length_sq > 1e-9 else 0.0
        share = min(max(share, 0.0), 1.0)
        return Peer(
            number=float(other.number),
            present=1.0,
            x=track.x + share * dx,
            y=track.y + share * dy,
            vx=0.0,
            vy=0.0,
            known=0.0,
            gx=track.gx,
            gy=track.gy,
            u_d=0.0,
            tx=track.tx,
            ty=track.ty,
            straight=0.0,
            sigma=state.position_error_m,
            widen=min(GROWS_MPS * age, self.half_radius_m),
        )

    half_radius_m = 3.0  # R / 2 of the mission

    def abscissa(self, other: Other, track: Track, now_ns: int, stretch: float = 1.0) -> float:
        """Its abscissa, dead-reckoned to now; `stretch`: metres that it goes for a metre of abscissa."""
        age = min(self.age_s(other, track, now_ns)[0], AHEAD_S)
        return track.state.s_m + age * (track.vx * track.tx + track.vy * track.ty) / stretch
