"""A driver's reading as the agent takes it: dead-reckoned, or raw for the fusion, NaN where a sensor has nothing."""

from __future__ import annotations

import math
from collections.abc import Callable

from fleet.agent.step import Nav
from fleet.drivers.seam import Reading
from fleet.sensing.fusion import Sensors


def sensors_of(reading: Reading, to_local: Callable[[float, float], tuple[float, float]], now_ns: int) -> Sensors:
    """What the sensors say, with ages at `now_ns`; a position at 0, 0 or off the globe is none."""
    age_s = _age_s(reading.stamp_ns, now_ns) if reading.stamp_ns > 0 else math.nan
    lat_deg, lon_deg = reading.lat_deg, reading.lon_deg
    there = math.isfinite(lat_deg + lon_deg) and abs(lat_deg) <= 90.0 and not lat_deg == lon_deg == 0.0
    sane = 0.0 <= reading.position_error_m < math.inf
    x, y = to_local(lat_deg, lon_deg) if there and sane else (math.nan, math.nan)
    return Sensors(
        x=x,
        y=y,
        sigma=reading.position_error_m,
        vx=reading.v_north_mps,
        vy=reading.v_east_mps,
        sigma_v=reading.velocity_error_mps,
        fix_age=age_s,
        psi=reading.heading_rad,
        sigma_psi=reading.heading_error_rad,
        psi_age=_age_s(reading.heading_stamp_ns, now_ns) if reading.heading_stamp_ns else age_s,
        r=reading.yaw_rate_radps,
        r_age=_age_s(reading.yaw_rate_stamp_ns, now_ns) if reading.yaw_rate_stamp_ns else age_s,
    )


def nav_of(
    reading: Reading, to_local: Callable[[float, float], tuple[float, float]], now_ns: int, stale_s: float
) -> Nav[float] | None:
    """A reading that is not raw, dead-reckoned to `now_ns`; None where it is unknown, impossible or stale."""
    age_s = (now_ns - reading.stamp_ns) * 1e-9
    numbers = reading.lat_deg + reading.lon_deg + reading.heading_rad + reading.v_north_mps + reading.v_east_mps
    known = (
        reading.stamp_ns > 0
        and math.isfinite(numbers)
        and not (reading.lat_deg == 0.0 and reading.lon_deg == 0.0)
        and abs(reading.lat_deg) <= 90.0
        and 0.0 <= reading.position_error_m < math.inf
    )
    if not known or not -0.5 < age_s < stale_s:
        return None
    x, y = to_local(reading.lat_deg, reading.lon_deg)
    age_s = max(age_s, 0.0)
    return Nav(
        1.0,
        x + reading.v_north_mps * age_s,
        y + reading.v_east_mps * age_s,
        reading.heading_rad,
        reading.v_north_mps,
        reading.v_east_mps,
        reading.yaw_rate_radps if math.isfinite(reading.yaw_rate_radps) else 0.0,
        reading.position_error_m,
    )


def _age_s(stamp_ns: int, now_ns: int) -> float:
    """Age of a value; one from the future by no more than half a second is of now [s]."""
    age_s = (now_ns - stamp_ns) * 1e-9
    return max(age_s, 0.0) if age_s > -0.5 else math.nan
