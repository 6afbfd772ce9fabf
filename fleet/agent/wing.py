"""A wingman's leader, as the boat knows it; and which mates need no looking after, because their places keep apart."""

from __future__ import annotations

import math

from msgspec import Struct

from fleet.agent import course as courses
from fleet.agent.flights import Flights
from fleet.agent.modes import IN_FORMATION, Mode
from fleet.agent.picture import Other, Picture
from fleet.agent.sailing import Sailing
from fleet.coordination import Leader
from fleet.mission.pattern import Shape
from fleet.mission.wingman import Wingman

IN_PLACE_M = 2.0  # from its place along and across the path: then it is where everybody knows it to be
ALL_TURN = "circle"  # the method of the paper, in which every boat that comes near another one turns
ON_ITS_PATH = IN_FORMATION | {int(Mode.ALONE)}
STOPPED = frozenset(map(int, (Mode.HOLD, Mode.NEUTRAL, Mode.FAULT, Mode.STANDBY, Mode.RETURN)))


class InPlace(Struct, frozen=True):
    """What a boat says about its own place."""

    mode: float
    along: float
    across: float

    @property
    def sure(self) -> bool:
        """It follows, keeps clear of nobody, and is where it belongs."""
        return self.mode == Mode.FOLLOW and abs(self.along) < IN_PLACE_M and abs(self.across) < IN_PLACE_M


class Wings:
    """The pattern wingman, for one boat."""

    def __init__(self, flights: Flights) -> None:
        self._flights = flights
        self._shape: Shape | None = None
        self._sailing: Sailing | None = None
        self._found: dict[int, Wingman] = {}
        self._end_m = math.inf  # where our leader's mission ends, on its path
        self._apart: frozenset[int] = frozenset()
        self._mine: frozenset[int] = frozenset()  # wingmen of this boat that keep clear of it, and not it of them
        self._last: Leader[float] | None = None
        self._last_s = 0.0
        self.lost_ns = 0  # since when the leader is lost; 0: it is not, or there is none
        self.stopped = False

    def take(self, sailing: Sailing | None) -> None:
        """The formation in force."""
        shape = sailing.shape if sailing is not None else None
        if sailing is self._sailing and shape is self._shape:
            return
        if sailing is not self._sailing or shape is None:
            self._last = None
        self._sailing, self._shape = sailing, shape
        self._found, self._apart, self._mine, self.lost_ns, self.stopped = {}, frozenset(), frozenset(), 0, False
        self._end_m = math.inf
        if sailing is None or shape is None or shape.pattern != "wingman":
            return
        flight = self._flights.prepare(sailing.plan, shape)
        self._found, self._apart = flight.wingmen, flight.mates(sailing.number)
        if (mine := self._found.get(sailing.number)) is not None:
            self._end_m = courses.end_abscissa(sailing.plan, mine.leader.number, shape)
        mission = sailing.plan.mission
        if mission.formation.crossing == "keep-on" and mission.keeping_clear.method != ALL_TURN:
            self._mine = frozenset(n for n, one in self._found.items() if one.leader.number == sailing.number)

    @property
    def flies(self) -> bool:
        """Whether the formation in force is of wingmen."""
        return self._shape is not None and self._shape.pattern == "wingman"

    def beside(self, picture: Picture, s_cvt: float, now_ns: int, *, there: bool) -> Leader[float] | None:
        """The leader now, for `step`; None for who has none. Notes whether it is lost or stopped.

        Args:
            picture: the others; who is silent was found in this tick
            s_cvt: abscissa of the CVT on the own path [m]
            now_ns: now
            there: whether the boat is on its mission's path
        """
        sailing = self._sailing
        one = self._found.get(sailing.number) if sailing is not None and there else None
        if sailing is None or one is None:
            self.lost_ns, self.stopped = 0, False
            return None
        self._hear(sailing, one, picture, now_ns)
        if self._last is None:  # never heard: wait for it
            self.stopped = True
            p = one.leader.path.at(one.leader.s)
            return Leader(0.0, 1.0, p.x, p.y, p.tx, p.ty, p.c, 0.0, 0.0, 0.0)
        room, slope = one.room.at(s_cvt)
        last = self._last
        good, stopped = float(not self.lost_ns), float(self.stopped)
        gains = one.room.gains(s_cvt, last.U, one.boat.limits.surge_lag_s)
        return Leader(good, stopped, last.x, last.y, last.tx, last.ty, last.c, last.U, room, slope, gains)

    def _hear(self, sailing: Sailing, one: Wingman, picture: Picture, now_ns: int) -> None:
        """Take in what the leader says of itself."""
        other = picture.others.get(one.leader.name)
        track = other.track if other is not None else None
        gone = (
            other is None
            or track is None
            or other.second is not None
            or other.name in picture.silent_names
            or track.state.mission_id not in ("", sailing.order.mission_id)
        )
        if gone or other is None or track is None:
            self.lost_ns = self.lost_ns or now_ns
            self.stopped = False
            return
        state = track.state
        self.lost_ns = 0
        self.stopped = state.mode in STOPPED or not state.mission_id
        if self.stopped and (state.mode in (Mode.RETURN, Mode.STANDBY) or not state.mission_id):
            if self._last is not None:  # its abscissa is not that of its path: stop beside where it was
                last = self._last
                self._last = Leader(1.0, 1.0, last.x, last.y, last.tx, last.ty, last.c, 0.0, 0.0, 0.0)
            return
        moving = state.mode in ON_ITS_PATH
        s = picture.abscissa(other, track, now_ns) if moving else state.s_m
        if moving and s >= self._end_m:  # it has come to its end by now: it will say so when its words have come
            s, moving, self.stopped = self._end_m, False, True
        p = one.leader.path.at(s)
        speed = max(track.vx * p.tx + track.vy * p.ty, 0.0) if moving else 0.0
        self._last = Leader(1.0, float(self.stopped), p.x, p.y, p.tx, p.ty, p.c, speed, 0.0, 0.0)

    def minded(self, own: InPlace, other: Other) -> bool:
        """Whether keeping clear looks at a mate.

        Not where both are in places that keep apart; and where paths cross and wingmen stay abeam, not at an own one
        that is under way: it keeps clear of its leader, and the leader goes on.
        """
        track = other.track
        if track is None or other.second is not None:
            return True
        state = track.state
        if other.number in self._mine and state.mode in IN_FORMATION:
            return False
        if other.number not in self._apart or not own.sure:
            return True
        same = self._sailing is not None and state.mission_id == self._sailing.order.mission_id
        return not (same and InPlace(float(state.mode), state.along_path_m, state.cross_track_m).sure)
