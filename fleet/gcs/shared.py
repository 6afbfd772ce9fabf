"""What all vehicles of a bridge have in common: what boats hold, what was uploaded, what was set. Times handed in."""

from __future__ import annotations

from msgspec import Struct

from fleet.errors import FleetError
from fleet.gcs.chart import PATTERNS, Basis, Draft, Pose, chart, formation_of
from fleet.gcs.items import Course, Item, items_of, milestones
from fleet.gcs.seat import Seat
from fleet.mission.model import Geographic, Mission
from fleet.mission.pattern import Shape
from fleet.mission.plan import Plan, build, shape_of
from fleet.operator.view import BoatView
from fleet.wire.messages import BoatState, BoatStatus

MOST_PLANS = 64
ACCEPTED_S = 4.0  # a value that boats have taken is shown until they are seen to sail by it
DEG = 57.29577951308232


class Charted(Struct):
    """An uploaded mission."""

    items: tuple[Item, ...]
    course: Course
    boat: str  # to which it was uploaded
    alone: bool
    mission_id: str = ""  # once it was started


class Shared:
    """One for a bridge."""

    def __init__(self, operator: str, template: Mission | None, *, home_first: bool) -> None:
        self.operator, self.template, self.home_first = operator, template, home_first
        self.seat = Seat()
        self.draft = Draft()
        self.views: dict[str, BoatView] = {}
        self.plans: dict[str, Plan] = {}  # by mission id
        self.homes: dict[str, Geographic] = {}  # by mission id, where the mission has one
        self.charted: Charted | None = None  # for the formation
        self.own_stops: set[str] = set()  # ids of stops that this bridge said
        self._accepted: dict[tuple[str, str], tuple[float, float]] = {}  # (boat or '', name) -> value, until
        self._shown: dict[tuple[str, str], tuple[Item, ...]] = {}
        self._stones: dict[tuple[str, str], tuple[tuple[float, int], ...]] = {}

    # -- what boats hold -------------------------------------------------------------------------------------------
    def state(self, boat: str) -> BoatState | None:
        """Its last state."""
        view = self.views.get(boat)
        return view.state if view is not None else None

    def status(self, boat: str) -> BoatStatus | None:
        """Its last status."""
        view = self.views.get(boat)
        return view.status if view is not None else None

    def learn(self, mission_id: str, mission: Mission) -> None:
        """A mission that a boat holds."""
        try:
            plan = build(mission)
        except FleetError:  # the boats sail it, and a newer fleet may know how
            return
        while len(self.plans) >= MOST_PLANS:
            gone = next(iter(self.plans))
            del self.plans[gone]
            self.homes.pop(gone, None)
            for kept in (self._shown, self._stones):
                for key in [key for key in kept if key[0] == gone]:
                    del kept[key]
        self.plans[mission_id] = plan
        if plan.home is not None:
            lat_deg, lon_deg = plan.plane.to_geographic(*plan.home)
            self.homes[mission_id] = Geographic(lat_deg=lat_deg, lon_deg=lon_deg)

    def plan(self, boat: str) -> Plan | None:
        """Of the mission that it holds."""
        state = self.state(boat)
        return self.plans.get(state.mission_id) if state is not None else None

    def items(self, boat: str) -> tuple[Item, ...]:
        """The mission that it holds, as waypoints."""
        state, plan = self.state(boat), self.plan(boat)
        if state is None or plan is None or all(one.name != boat for one in plan.boats):
            return ()
        key = (state.mission_id, boat)
        if key not in self._shown:
            self._shown[key] = items_of(plan, boat, home_first=self.home_first)
        return self._shown[key]

    def progress(self, boat: str, items: tuple[Item, ...]) -> int:
        """The item that a boat on its mission sails to; 0 for none."""
        state, plan = self.state(boat), self.plan(boat)
        if state is None or plan is None or not items or all(one.name != boat for one in plan.boats):
            return 0
        key = (state.mission_id, boat)
        if key not in self._stones:
            self._stones[key] = milestones(items, plan, boat, home_first=self.home_first)
        path, stones = plan.boat(boat).path, self._stones[key]
        s = state.s_m % path.length if path.closed else state.s_m
        return next((seq for at, seq in stones if at > s), stones[-1][1] if stones else 0)

    def in_company(self, boat: str) -> int:
        """How many boats are in its mission's roster."""
        plan = self.plan(boat)
        return len(plan.boats) if plan is not None else 0

    # -- the next mission ------------------------------------------------------------------------------------------
    def basis(self, boat: str, *, alone: bool) -> Basis:
        """Who sails what is uploaded to a boat, and within what: the mission held, else the template."""
        poses = {
            name: Pose(s.lat_deg, s.lon_deg, (s.heading_rad * DEG) % 360.0)
            for name, view in self.views.items()
            if (s := view.state) is not None and view.alive
        }
        held = {state.mission_id for view in self.views.values() if (state := view.state) is not None and view.alive}
        fit = [
            (mission_id, plan)
            for mission_id, plan in self.plans.items()
            if mission_id in held and any(one.name == boat for one in plan.boats)
        ]
        fit.sort(key=lambda one: _stamp(one[0]), reverse=True)
        together = [one for one in fit if len(one[1].boats) > 1]
        for mission_id, plan in together or (fit if self.template is None and (alone or len(poses) == 1) else []):
            return Basis(poses, plan.mission, self.shape(mission_id, plan))
        return Basis(poses, self.template)

    def shape(self, mission_id: str, plan: Plan) -> Shape:
        """The formation in force, as far as boats have told it."""
        shape = shape_of(plan.mission)
        told = {
            name: view.status
            for name, view in self.views.items()
            if view.status is not None and view.status.mission_id == mission_id and view.status.pattern
        }
        if not told:
            return shape
        one = next(iter(told.values()))
        slots = tuple(told[b.name].slot if b.name in told else b.slot for b in plan.boats)
        return Shape(one.pattern, one.spacing_m, one.lateral_m, one.cruise_mps, slots)

    def mission_for(self, course: Course, boat: str, *, alone: bool, title: str = "") -> Mission:
        """The mission for a course; FleetError when there is none."""
        return chart(course, boat, self.basis(boat, alone=alone), self.draft, alone=alone, title=title)

    # -- parameters ------------------------------------------------------------------------------------------------
    def accept(self, boat: str, name: str, value: float, now_s: float) -> None:
        """Boats have taken a value; boat '': all of them."""
        self._accepted[boat, name] = (value, now_s + ACCEPTED_S)

    def value(self, boat: str, name: str, now_s: float) -> float:
        """A parameter of the formation, in force or, with no mission, of the next one."""
        for whose in (boat, ""):
            value, until_s = self._accepted.get((whose, name), (0.0, -1.0))
            if now_s < until_s:
                return value
        status, plan = self.status(boat), self.plan(boat)
        if status is not None and status.mission_id and status.pattern and name not in ("FLT_GAIN", "FLT_RADIUS"):
            pattern = PATTERNS.index(status.pattern) if status.pattern in PATTERNS else 0
            return {
                "FLT_SPACING": status.spacing_m,
                "FLT_LATERAL": status.lateral_m,
                "FLT_CRUISE": status.cruise_mps,
                "FLT_PATTERN": float(pattern),
                "FLT_SLOT": status.slot,
            }[name]
        basis = Basis({}, plan.mission if plan is not None else self.template)
        formation, radius_m = formation_of(basis, self.draft)
        lateral = formation.spacing_m if formation.lateral_m is None else formation.lateral_m
        slots = {one.name: one.slot for one in basis.mission.boats} if basis.mission is not None else {}
        return {
            "FLT_SPACING": formation.spacing_m,
            "FLT_LATERAL": lateral,
            "FLT_CRUISE": formation.cruise_mps,
            "FLT_PATTERN": float(PATTERNS.index(formation.pattern)),
            "FLT_SLOT": slots.get(boat, 0.0),
            "FLT_GAIN": formation.gain_per_m,
            "FLT_RADIUS": radius_m,
        }[name]

    def controls(self, boat: str) -> str:
        """Who holds control, as a boat says."""
        state = self.state(boat)
        return state.control.operator if state is not None else ""


def _stamp(mission_id: str) -> int:
    """When a mission was launched."""
    digits = mission_id.partition("-")[0]
    return int(digits) if digits.isdigit() and len(digits) < 30 else 0
