"""What an autopilot's parameters must be for boats of a fleet, and why. Values in, findings out."""

from __future__ import annotations

import math
from collections.abc import Mapping

from msgspec import Struct


class Rule(Struct, frozen=True):
    """One parameter."""

    names: tuple[str, ...]  # the newest first; older firmware has another
    least: float
    most: float
    set_to: float
    why: str
    must: bool = True  # without it a boat is not fit; else advice
    optional: bool = False  # not every firmware has it

    @property
    def wanted(self) -> str:
        """In words."""
        if self.least == self.most:
            return f"{self.least:g}"
        if math.isinf(self.most):
            return f"{self.least:g} or more"
        return f"{self.least:g} to {self.most:g}"


class Finding(Struct, frozen=True):
    """What became of a rule."""

    name: str
    value: float | None  # None: the autopilot does not answer for it
    wanted: str
    verdict: str  # "ok", "change", "advice"; "unknown": no answer; "absent": none, and not every firmware has it
    set_to: float
    why: str


def rules(sysid: int, own_sysid: int, speed_mps: float) -> tuple[Rule, ...]:
    """For an autopilot of a boat that sails up to `speed_mps`."""
    return (
        Rule(("MAV_SYSID", "SYSID_THISMAV"), sysid, sysid, sysid, "the boat answers to this number, no other has it"),
        Rule(
            ("MAV_GCS_SYSID", "SYSID_MYGCS"),
            own_sysid,
            own_sysid,
            own_sysid,
            "the ground station failsafe waits for the agent's HEARTBEAT",
        ),
        Rule(("FS_GCS_ENABLE",), 1, 1, 1, "a boat whose agent died is stopped even if set-points still flow"),
        Rule(("FS_GCS_TIMEOUT",), 1, 5, 5, "of the ground station failsafe, in seconds"),
        Rule(("FS_TIMEOUT",), 0.1, 1.5, 1.5, "added to it, in seconds"),
        Rule(("FS_ACTION",), 6, 6, 6, "LOITER, else HOLD: HOLD alone cuts the thrust and does not brake"),
        Rule(("FS_EKF_ACTION",), 1, 1, 1, "HOLD when the position is lost"),
        Rule(("FS_EKF_THRESH",), 0.01, 0.8, 0.8, "when the position counts as lost"),
        Rule(("GUID_TIMEOUT",), 0.5, 3, 3, "without a set-point the boat stops, in seconds", optional=True),
        Rule(("FRAME_CLASS",), 2, 2, 2, "a boat, not a rover"),
        Rule(("WP_SPEED",), speed_mps, math.inf, speed_mps, "faster set-points are clamped to it, in m/s"),
        Rule(("SCHED_LOOP_RATE",), 50, 400, 50, "streams come at half of it at most, in Hz"),
        Rule(("ARMING_CHECK",), 1, 1, 1, "all checks before arming", must=False, optional=True),
        Rule(("INITIAL_MODE",), 4, 4, 4, "HOLD after a start, not MANUAL", must=False),
        Rule(("LOIT_RADIUS",), 0.5, 3, 2, "a stopped boat stays so near, in m", must=False),
    )


def judge(rule: Rule, held: Mapping[str, float]) -> Finding:
    """A rule against the parameters that the autopilot told."""
    name = next((name for name in rule.names if name in held), rule.names[0])
    value = held.get(name)
    if value is None:
        verdict = "absent" if rule.optional else "unknown"
    elif rule.least - 1e-6 <= value <= rule.most + 1e-6:
        verdict = "ok"
    else:
        verdict = "change" if rule.must else "advice"
    return Finding(name, value, rule.wanted, verdict, rule.set_to, rule.why)
