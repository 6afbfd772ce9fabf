"""From orders and troubles to one goal: every row of the trouble table that is not the picture's or `step`'s own."""

from __future__ import annotations

from msgspec import Struct

from fleet.agent.modes import Goal, Reason
from fleet.agent.orders import Orders
from fleet.mission.model import Mission

FENCE_S = 1.0  # outside for so long before the boat turns back: one wild fix is not a breach


class Circumstances(Struct, frozen=True):
    """What the boat knows of itself this tick."""

    now_ns: int
    link_up: bool
    operator_there: bool
    inside_fence: bool
    battery_percent: float  # NaN unknown
    authority: str
    driver_trouble: str
    name_taken: bool
    has_track: bool
    leader_lost_s: float = 0.0  # for how long a wingman has not heard its leader


class Troubles:
    """Remembers since when a trouble lasts."""

    def __init__(self) -> None:
        self.link_down_ns = 0
        self.operator_gone_ns = 0
        self.outside_ns = 0

    def goal(self, orders: Orders, seen: Circumstances) -> tuple[Goal, Reason]:
        """What the boat does now, and why."""
        why = orders.why
        if seen.name_taken:
            return Goal.STANDBY, why | Reason.NAME_TAKEN
        if orders.stops:
            return Goal.NEUTRAL, why | Reason.STOPPED
        if seen.authority:
            return Goal.NEUTRAL, why | Reason.AUTHORITY
        if seen.driver_trouble:
            return Goal.NEUTRAL, why | Reason.DRIVER
        sailing = orders.sailing
        if sailing is None and orders.goal not in (Goal.HOLD, Goal.RETURN):
            return Goal.STANDBY, why | Reason.NO_MISSION
        if sailing is None:
            levels = orders.ended.mission.battery if orders.ended is not None else None
            if levels is not None and seen.battery_percent < levels.critical_percent:
                return Goal.NEUTRAL, why | Reason.BATTERY_CRITICAL
            return orders.goal, why
        mission = sailing.plan.mission
        if seen.battery_percent < mission.battery.critical_percent:
            return Goal.NEUTRAL, why | Reason.BATTERY_CRITICAL
        if orders.goal == Goal.STANDBY:
            return Goal.STANDBY, why
        why |= self._fence(orders, seen) | self._battery(orders, mission, seen)
        if orders.goal != Goal.FOLLOW:
            return orders.goal, why
        if seen.now_ns < sailing.starts_ns:
            return Goal.STANDBY, why
        goal, more = self._links(mission, len(sailing.plan.boats), orders, seen)
        return goal, why | more

    def _fence(self, orders: Orders, seen: Circumstances) -> Reason:
        if seen.inside_fence:
            self.outside_ns = 0
            return Reason(0)
        self.outside_ns = self.outside_ns or seen.now_ns
        if orders.goal == Goal.FOLLOW and (seen.now_ns - self.outside_ns) * 1e-9 >= FENCE_S:
            orders.turn_back(Goal.RETURN if seen.has_track else Goal.HOLD, "outside the fence")
        return Reason.OUTSIDE_FENCE

    @staticmethod
    def _battery(orders: Orders, mission: Mission, seen: Circumstances) -> Reason:
        if not seen.battery_percent < mission.battery.reserve_percent:
            return Reason(0)
        if orders.goal == Goal.FOLLOW:
            orders.turn_back(Goal.RETURN if seen.has_track else Goal.HOLD, "battery below reserve")
        return Reason.BATTERY_RESERVE

    def _links(self, mission: Mission, boats: int, orders: Orders, seen: Circumstances) -> tuple[Goal, Reason]:
        now = seen.now_ns
        if not seen.link_up and boats > 1:
            self.link_down_ns = self.link_down_ns or now
            alone = (now - self.link_down_ns) * 1e-9 < mission.lost.alone_for_s
            return (Goal.ALONE if alone else Goal.HOLD), Reason.LINK_DOWN
        self.link_down_ns = 0
        if seen.leader_lost_s > mission.lost.alone_for_s:
            return Goal.HOLD, Reason(0)
        if seen.operator_there or mission.lost.operator == "continue":
            self.operator_gone_ns = 0
            return Goal.FOLLOW, Reason(0)
        self.operator_gone_ns = self.operator_gone_ns or now
        if (now - self.operator_gone_ns) * 1e-9 < mission.lost.operator_after_s:
            return Goal.FOLLOW, Reason(0)
        if mission.lost.operator == "hold":
            return Goal.HOLD, Reason.OPERATOR_LOST
        orders.turn_back(Goal.RETURN if seen.has_track else Goal.HOLD, "no operator in reach")
        return orders.goal, Reason.OPERATOR_LOST
