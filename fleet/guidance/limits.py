"""What a hull can do, as guidance and keeping clear need it."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct, structs


class Limits(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Limits of one boat's motion; defaults are those of the reference simulation (2.4 m hull)."""

    speed_min_mps: Annotated[float, Meta(ge=0.0)] = 0.0  # slowest speed under way, surge
    speed_max_mps: Annotated[float, Meta(gt=0.0)] = 1.5
    yaw_rate_max_radps: Annotated[float, Meta(gt=0.0)] = 0.35
    acceleration_max_mps2: Annotated[float, Meta(gt=0.0)] = 0.3
    surge_lag_s: Annotated[float, Meta(gt=0.0)] = 2.0
    yaw_lag_s: Annotated[float, Meta(gt=0.0)] = 0.6
    length_m: Annotated[float, Meta(gt=0.0)] = 2.4


class OwnLimits(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What one boat can do, as its own configuration says; None: it does not say."""

    speed_min_mps: Annotated[float, Meta(ge=0.0)] | None = None
    speed_max_mps: Annotated[float, Meta(gt=0.0)] | None = None
    yaw_rate_max_radps: Annotated[float, Meta(gt=0.0)] | None = None
    acceleration_max_mps2: Annotated[float, Meta(gt=0.0)] | None = None
    surge_lag_s: Annotated[float, Meta(gt=0.0)] | None = None
    yaw_lag_s: Annotated[float, Meta(gt=0.0)] | None = None
    length_m: Annotated[float, Meta(gt=0.0)] | None = None


AT_MOST = ("speed_max_mps", "yaw_rate_max_radps", "acceleration_max_mps2")
"""Of these a boat may be asked less than it can; of the others more: it is slower, lazier or longer than its least."""


def asked_too_much(own: OwnLimits, asked: Limits) -> list[str]:
    """Where limits ask more of a boat than it can do, as `speed_max_mps = 1.5, the boat's own 1.2`."""
    found = []
    for name, can in structs.asdict(own).items():
        wants = getattr(asked, name)
        if can is not None and (wants > can if name in AT_MOST else wants < can):
            found.append(f"{name} = {wants:g}, the boat's own {can:g}")
    return found


def within(own: OwnLimits) -> Limits:
    """The limits of a boat that has no mission to give it any: its own, and the defaults where these ask no more."""
    said = {name: value for name, value in structs.asdict(own).items() if value is not None}
    limits = structs.replace(Limits(), **said)
    return structs.replace(limits, speed_max_mps=max(limits.speed_max_mps, limits.speed_min_mps))
