"""Between the simulated autopilot and its hull: what it senses, what it tells the thrusters."""

from __future__ import annotations

from msgspec import Struct


class Senses(Struct, frozen=True):
    """What the autopilot's sensors say of its hull."""

    lat_deg: float
    lon_deg: float
    psi_rad: float
    v_north_mps: float
    v_east_mps: float
    r_radps: float
    u_mps: float
    fix: bool = True
    error_m: float = 0.5
    battery_percent: float = 100.0


class Thrust(Struct, frozen=True):
    """What the hull is told."""

    powered: bool = False
    surge_mps: float = 0.0
    yaw_rate_radps: float = 0.0
