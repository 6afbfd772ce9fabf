"""Going on after a restart: only within the same boot, soon, near where it was, and with no stop unreleased.

A boat switched on at the quay never sails yesterday's mission: it stands by, says why, and waits for
`resume --at nearest | S`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fleet.agent import course as courses
from fleet.agent.modes import Goal, Reason
from fleet.agent.sailing import Sailing
from fleet.agent.store import UNKNOWN_BOOT, Kept, Progress
from fleet.geo import Plane

if TYPE_CHECKING:
    from fleet.agent.agent import Agent

SOON_S = 60.0
NEAR_M = 20.0
TRACK_KEPT = 100  # points of the track that are written
LAPS = 10_000  # more than anybody sails round a circuit


class Resumption:
    """What the disk remembers, and whether it still holds."""

    def __init__(self, agent: Agent, boot_id: str) -> None:
        self._agent, self._boot_id = agent, boot_id
        self._kept: Kept | None = agent.store.kept()
        self._progress: Progress | None = agent.store.progress()
        self._abscissa: float | None = None
        self._plane: Plane | None = None
        self._places: dict[courses.Point, courses.Point] = {}
        self._open = True  # still to be considered
        self._reading = False
        self._read: tuple[str, Sailing | None] | None = None
        self.refused = ""
        orders = agent.orders
        orders.stops = dict.fromkeys(agent.store.stops())
        if self._kept is not None:
            orders.control = self._kept.control
            orders.known_missions = dict.fromkeys(self._kept.known_missions)
            orders.released = dict.fromkeys(self._kept.released)
            orders.said = dict(self._kept.said)
            orders.stop_words = dict(self._kept.stop_words)

    @property
    def pending(self) -> bool:
        """Whether there is a mission on disk that has not been considered yet."""
        return self._open and self._kept is not None and self._kept.mission is not None

    def consider(self, now_ns: int) -> None:
        """Once the boat knows where it is: take up the mission on disk, or stand by with it and say why."""
        agent = self._agent
        if not self._open:
            return
        kept = self._kept
        if kept is None or kept.mission is None or agent.orders.sailing is not None:
            self._open = False
            return
        if agent.orders.why & Reason.ABORTED:  # an operator ended it before the boat knew where it is
            self._open = False
            return
        if agent.nav.sound < 0.5:
            return
        if not self._reading:
            self._reading = agent.background.submit(self._read_ahead, lambda: None) is not None
        if self._read is None:
            return
        self._open = False
        told = agent.orders.goal, agent.orders.why
        problem, sailing = self._read
        if sailing is None:
            agent.orders.note("not-resumed", f"the mission on disk: {problem}")
            return
        agent.orders.begin(sailing, Goal.STANDBY)
        if kept.formation is not None:
            agent.orders.handed_on(kept.formation, 0.0, now_ns)
            agent.orders.switch(now_ns)
        if told[0] != Goal.STANDBY:  # hold or return, said in the meantime
            agent.orders.told(*told)
            return
        progress = self._progress
        self.refused = self._why_not(progress, sailing, now_ns)
        if self.refused or progress is None:
            agent.orders.stand_by(Reason.NOT_RESUMED)
            agent.orders.note("not-resumed", self.refused)
            return
        self._go_on(progress, sailing, now_ns)

    def _read_ahead(self) -> None:
        assert self._kept is not None
        assert self._kept.mission is not None
        self._read = self._agent.orders.read_mission(self._kept.mission, self._agent.now_ns)

    def _why_not(self, progress: Progress | None, sailing: Sailing, now_ns: int) -> str:
        """Why the mission on disk is not simply gone on with; '' when it is."""
        agent = self._agent
        if progress is None or progress.mission_id != sailing.order.mission_id:
            return "no record of where the boat was"
        if progress.boot_id != self._boot_id or self._boot_id == UNKNOWN_BOOT:
            return "the machine was started anew"
        if progress.goal == Goal.STANDBY:
            return "it stood by before the restart"
        gap_s = (now_ns - progress.stamp_ns) * 1e-9
        if not 0.0 <= gap_s < SOON_S:
            return f"{gap_s:.0f} s have passed, more than {SOON_S:.0f} s"
        if agent.orders.stops:
            return "stopped, not released"
        x, y = sailing.plan.plane.to_local(progress.lat_deg, progress.lon_deg)
        here = self._here(sailing)
        moved = ((here[0] - x) ** 2 + (here[1] - y) ** 2) ** 0.5
        reach = NEAR_M + sailing.plan.boats[sailing.number].limits.speed_max_mps * gap_s
        if moved > reach:
            return f"{moved:.0f} m from where it was, more than {reach:.0f} m"
        return ""

    def _here(self, sailing: Sailing) -> tuple[float, float]:
        """Where the boat is, in the mission's plane."""
        agent, plane = self._agent, sailing.plan.plane
        if agent.plane is None or not agent.reading.raw:
            return plane.to_local(agent.reading.lat_deg, agent.reading.lon_deg)
        return plane.to_local(*agent.plane.to_geographic(agent.nav.x, agent.nav.y))  # a raw reading may hold no fix

    def _go_on(self, progress: Progress, sailing: Sailing, now_ns: int) -> None:
        agent = self._agent
        plane = sailing.plan.plane
        agent.track = courses.Track([plane.to_local(lat, lon) for lat, lon in progress.track])
        boat = sailing.plan.boats[sailing.number]
        gap_s = (now_ns - progress.stamp_ns) * 1e-9
        window = boat.limits.speed_max_mps * gap_s + 5.0
        x, y = self._here(sailing)
        own = courses.along_mission(sailing).path
        self._abscissa = own.project(x, y, progress.s_m - window, progress.s_m + window)
        agent.orders.begin(sailing, Goal(progress.goal))
        agent.orders.note("resumed", f"at {self._abscissa:.0f} m after {gap_s:.1f} s")

    def take_abscissa(self) -> float | None:
        """Where to go on, once."""
        s, self._abscissa = self._abscissa, None
        return s

    def resume_at(self, text: str, sailing: Sailing) -> str:
        """An operator's word on where to go on; '' or why not."""
        agent = self._agent
        boat = sailing.plan.boats[sailing.number]
        if agent.nav.sound < 0.5:
            return "own navigation is stale or not finite"
        if text == "nearest":
            self._abscissa = courses.along_mission(sailing).path.project(agent.nav.x, agent.nav.y)
        elif text:
            try:
                s = float(text)
            except ValueError:
                return f"--at {text!r}: expected `nearest` or an abscissa in metres"
            farthest = LAPS * boat.path.length if boat.path.closed else boat.path.length
            if not 0.0 <= s <= farthest:
                return f"--at {s:g}: expected an abscissa within 0 and {farthest:.0f} m"
            self._abscissa = s
        elif agent.orders.why & Reason.NOT_RESUMED:
            return f"not resumed after a restart ({self.refused}): say where, with --at nearest or --at S"
        return ""

    # -- what is written -------------------------------------------------------------------------------------------
    def kept(self) -> Kept:
        """The mission and the formation in force, as operators wrote them."""
        orders = self._agent.orders
        sailing = orders.sailing
        kept = self._kept
        standing: dict[str, Any] = {
            "released": tuple(orders.released),
            "said": tuple(orders.said.items()),
            "stop_words": tuple(orders.stop_words.items()),
        }
        if kept is not None and self.pending and sailing is None and not orders.why & Reason.ABORTED:
            return Kept(kept.mission, kept.formation, orders.control, kept.known_missions, **standing)
        words = None
        if sailing is not None:
            words = sailing.pending_words if sailing.pending is not None else sailing.formation_words
        known = tuple(orders.known_missions)[-64:]
        return Kept(sailing.words if sailing is not None else None, words, orders.control, known, **standing)

    def progress(self, now_ns: int) -> Progress:
        """Where the boat is."""
        agent = self._agent
        sailing, plane = agent.orders.sailing, agent.plane
        assert sailing is not None
        assert plane is not None
        lat_deg, lon_deg = plane.to_geographic(agent.nav.x, agent.nav.y)
        return Progress(
            boot_id=self._boot_id,
            stamp_ns=now_ns,
            mission_id=sailing.order.mission_id,
            lat_deg=lat_deg,
            lon_deg=lon_deg,
            s_m=agent.state.s,
            goal=int(agent.orders.goal),
            ended=agent.state.ended > 0.5,
            track=self._geographic(plane, agent.track.points[-TRACK_KEPT:]),
        )

    def _geographic(self, plane: Plane, points: Sequence[courses.Point]) -> tuple[courses.Point, ...]:
        """Points of the track on WGS 84: those of the second before are known."""
        if plane is not self._plane:
            self._plane, self._places = plane, {}
        known = self._places
        self._places = {point: known.get(point) or plane.to_geographic(*point) for point in points}
        return tuple(self._places[point] for point in points)
