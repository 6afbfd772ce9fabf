"""What a hull can do, as guidance and keeping clear need it."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct


class Limits(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Limits of one boat's motion; defaults are those of the reference simulation (2.4 m hull)."""

    speed_min_mps: Annotated[float, Meta(ge=0.0)] = 0.0  # slowest speed under way, surge
    speed_max_mps: Annotated[float, Meta(gt=0.0)] = 1.5
    yaw_rate_max_radps: Annotated[float, Meta(gt=0.0)] = 0.35
    acceleration_max_mps2: Annotated[float, Meta(gt=0.0)] = 0.3
    surge_lag_s: Annotated[float, Meta(gt=0.0)] = 2.0
    yaw_lag_s: Annotated[float, Meta(gt=0.0)] = 0.6
    length_m: Annotated[float, Meta(gt=0.0)] = 2.4
