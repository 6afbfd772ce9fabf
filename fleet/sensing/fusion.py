"""Where the own boat is and how it moves, from sensors that are noisy, late, wrong at times, or gone.

Two filters: position, velocity and the slow error of the fixes (`drift`), and heading. Sensors give values with
a 1-sigma error and an age; one that has nothing gives NaN. All values are floats.
"""

from __future__ import annotations

import math
from typing import Annotated

from msgspec import Meta, Struct, structs

from fleet import ops
from fleet.sensing import drift
from fleet.sensing.drift import Cov, Drifting, DriftParams

LEAST_S = 0.005  # two headings nearer in time are one
Positive = Annotated[float, Meta(gt=0.0)]


class FusionParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Tuning of the fusion."""

    drift: DriftParams = drift.PARAMS  # of position, velocity and the slow error of fixes
    sigma_m: Positive = 0.02  # no position is taken to be better
    sigma_mps: Positive = 0.02
    sigma_rad: Positive = 0.005
    start_mps: Positive = 2.0  # of a velocity not measured
    gate: Positive = 5.0  # sigmas; what is farther off is an outlier
    gate_s: Positive = 3.0  # outliers only, for so long: then it is the filter that was wrong
    old_s: Positive = 0.5  # a value older than this is not used
    slow_s: Positive = 1.5  # a compass that has told nothing for so long is lost; cheap ones tell once a second
    reckon_s: Positive = 10.0  # without a fix, then the position is unknown
    most_m: Positive = 5.0  # so uncertain, it is unknown
    rate_low_pass_s: Positive = 0.5  # of a yaw rate from headings
    drift_rad2ps: Positive = 1e-4  # variance that the heading gains a second on the yaw rate alone [rad2/s]
    blind_rad2ps: Positive = 1e-2  # and without the yaw rate
    course_mps: Positive = 0.3  # slower boats have no course to take the heading from
    leeway_rad: Positive = 0.1  # 1 sigma between heading and course
    most_rad: Positive = 0.5  # so uncertain, the heading is unknown


class Sensors(Struct, frozen=True, gc=False):
    """What the sensors say; NaN where one has nothing new. Ages are at the time of the call."""

    x: float  # north [m]
    y: float  # east [m]
    sigma: float  # 1-sigma error of the position per axis, as the receiver knows it [m]
    vx: float  # velocity over ground, north [m/s]
    vy: float  # east [m/s]
    sigma_v: float  # 1-sigma error per axis [m/s]
    fix_age: float  # of position and velocity [s]
    psi: float  # heading [rad]
    sigma_psi: float  # [rad]
    psi_age: float  # [s]
    r: float  # yaw rate, + to starboard [rad/s]
    r_age: float  # [s]


class Fused(Struct, frozen=True, gc=False):
    """What is known, and remembered from tick to tick."""

    x: float  # north [m]
    y: float  # east [m]
    vx: float  # velocity over ground, north [m/s]
    vy: float  # east [m/s]
    bx: float  # slow error of the fixes, north [m]
    by: float  # east [m]
    cov: Cov  # of position, velocity and slow error, per axis
    psi: float  # heading [rad]
    P_psi: float  # its variance [rad2]; inf: never known
    r: float  # yaw rate [rad/s]
    told: float  # 1-sigma error of the last fix as the receiver knew it [m]
    no_fix: float  # seconds without a fix that was believed; inf: never
    no_heading: float  # seconds without a heading from the compass
    no_rate: float  # seconds without a yaw rate from the gyro
    refused: float  # seconds for which every fix has been an outlier
    outliers: float  # fixes and headings refused, all together
    last_psi: float  # last heading of the compass, for the yaw rate; NaN none [rad]
    last_age: float  # how old that is [s]

    @property
    def sigma(self) -> float:
        """1-sigma error of the position per axis [m]; at least half of what the receiver says (`drift.said`)."""
        return drift.said(self.cov, self.told)

    @property
    def sigma_v(self) -> float:
        """1-sigma error of the velocity per axis [m/s]."""
        return ops.sqrt(self.cov.vv)


NOTHING = Fused(
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0, Cov(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    0.0, math.inf, 0.0, 0.0, math.inf, math.inf, math.inf, 0.0, 0.0, math.nan, 0.0,
)  # fmt: skip
"""Before the first fix."""
PARAMS = FusionParams()


def known(fused: Fused, params: FusionParams = PARAMS) -> bool:
    """Whether position and heading are known well enough to sail by."""
    return (
        fused.no_fix <= params.reckon_s and fused.sigma <= params.most_m and fused.P_psi <= params.most_rad**2
    )  # fmt: skip


def fuse(fused: Fused, sensors: Sensors, dt: float, params: FusionParams = PARAMS) -> Fused:
    """What is known after one more look at the sensors.

    What is lost with a sensor:
        GNSS: position and velocity are reckoned, the velocity turning with the boat, with a growing error; unknown
            after 10 s or beyond 5 m.
        Heading: reckoned with the yaw rate, and corrected by the course over ground above 0.3 m/s.
        Yaw rate: from the differences of headings, low-passed; it lags by half a second.

    Args:
        fused: what was known before
        sensors: what they say now
        dt: time since the look before [s]
        params: tuning
    """
    fused = _heading(_rate(fused, sensors, dt, params), sensors, dt, params)
    fused = _predicted(fused, dt, params)
    if math.isfinite(sensors.x + sensors.y + sensors.sigma) and 0.0 <= sensors.fix_age <= params.old_s:
        fused = _fixed(fused, sensors, dt, params)
    else:
        fused = structs.replace(fused, no_fix=fused.no_fix + dt)
    return _course(fused, dt, params)


def _rate(fused: Fused, sensors: Sensors, dt: float, params: FusionParams) -> Fused:
    """The yaw rate: from the gyro, else from headings."""
    if math.isfinite(sensors.r) and sensors.r_age <= params.old_s:
        return structs.replace(_looked_up(fused, sensors, dt, params)[0], r=sensors.r, no_rate=0.0)
    no_rate = fused.no_rate + dt
    fused, turned, over = _looked_up(fused, sensors, dt, params)
    if no_rate <= params.old_s or not over:
        return structs.replace(fused, no_rate=no_rate)
    r = fused.r + (turned - fused.r) * over / (params.rate_low_pass_s + over)
    return structs.replace(fused, r=r, no_rate=no_rate)


def _looked_up(fused: Fused, sensors: Sensors, dt: float, params: FusionParams) -> tuple[Fused, float, float]:
    """The compass's newest heading remembered; the yaw rate since the one before [rad/s], and over how long [s].

    Over 0 s: it has told nothing new. Without any heading for long the boat is taken to turn no more.
    """
    age = fused.last_age + dt
    if not (math.isfinite(sensors.psi) and sensors.psi_age <= params.old_s):
        return structs.replace(fused, last_age=age), 0.0, dt if age > params.slow_s else 0.0
    over = age - sensors.psi_age
    if not math.isfinite(fused.last_psi):
        return structs.replace(fused, last_psi=sensors.psi, last_age=sensors.psi_age), 0.0, 0.0
    if over < LEAST_S:  # the same one again
        return structs.replace(fused, last_age=age), 0.0, 0.0
    turned = ops.wrap(sensors.psi - fused.last_psi) / over
    return structs.replace(fused, last_psi=sensors.psi, last_age=sensors.psi_age), turned, over


def _heading(fused: Fused, sensors: Sensors, dt: float, params: FusionParams) -> Fused:
    """Kalman filter of the heading, turned by the yaw rate."""
    sure = fused.no_rate <= params.old_s or fused.no_heading <= params.slow_s
    P = fused.P_psi + (params.drift_rad2ps if sure else params.blind_rad2ps) * dt
    psi = ops.wrap(fused.psi + fused.r * dt)
    if not (math.isfinite(sensors.psi) and sensors.psi_age <= params.old_s):
        return structs.replace(fused, psi=psi, P_psi=P, no_heading=fused.no_heading + dt)
    measured = sensors.psi + fused.r * sensors.psi_age
    R = max(sensors.sigma_psi, params.sigma_rad) ** 2
    if not math.isfinite(P) or fused.no_heading > params.gate_s:
        return structs.replace(fused, psi=ops.wrap(measured), P_psi=R, no_heading=0.0)
    off = ops.wrap(measured - psi)
    if off * off > params.gate**2 * (P + R):
        return structs.replace(
            fused, psi=psi, P_psi=P, no_heading=fused.no_heading + dt, outliers=fused.outliers + 1.0
        )  # fmt: skip
    K = P / (P + R)
    return structs.replace(fused, psi=ops.wrap(psi + K * off), P_psi=P - K * P, no_heading=0.0)


def _predicted(fused: Fused, dt: float, params: FusionParams) -> Fused:
    """Position, velocity and slow error a step later; the velocity turns with the boat."""
    if not math.isfinite(fused.no_fix):
        return fused
    there = drift.moved(_drifting(fused), fused.r, dt, drift.left(dt, params.drift))
    return _with(fused, there, drift.predicted(fused.cov, fused.told, dt, params.drift))


def _drifting(fused: Fused) -> Drifting[float]:
    return Drifting(fused.x, fused.y, fused.vx, fused.vy, fused.bx, fused.by)


def _with(fused: Fused, known: Drifting[float], cov: Cov) -> Fused:
    k = known
    return structs.replace(fused, x=k.x, y=k.y, vx=k.vx, vy=k.vy, bx=k.bx, by=k.by, cov=cov)


def _fixed(fused: Fused, sensors: Sensors, dt: float, params: FusionParams) -> Fused:
    """After a fix: position, and velocity where the receiver measures it; unless it is an outlier."""
    told = max(sensors.sigma, params.sigma_m)
    knows_v = math.isfinite(sensors.vx + sensors.vy)
    vx, vy = (sensors.vx, sensors.vy) if knows_v else (fused.vx, fused.vy)
    x, y = sensors.x + vx * sensors.fix_age, sensors.y + vy * sensors.fix_age
    off_x, off_y = x - fused.x, y - fused.y
    first = not math.isfinite(fused.no_fix)
    off_sq = off_x * off_x + off_y * off_y
    outlier = not first and off_sq > params.gate**2 * 2.0 * (fused.cov.xx + told * told)
    if outlier and fused.refused + dt < params.gate_s and fused.no_fix + dt < params.reckon_s:
        return structs.replace(
            fused, no_fix=fused.no_fix + dt, refused=fused.refused + dt, outliers=fused.outliers + 1.0
        )  # fmt: skip
    if first or outlier:
        sigma_v = max(sensors.sigma_v, params.sigma_mps) if knows_v else params.start_mps
        start = (vx, vy) if knows_v else (0.0, 0.0)
        return structs.replace(
            fused, x=x, y=y, vx=start[0], vy=start[1], bx=0.0, by=0.0, cov=drift.first(told, sigma_v, params.drift),
            told=told, no_fix=0.0, refused=0.0,
        )  # fmt: skip
    cov, gain = drift.by_fix(fused.cov, drift.white_of(told, params.drift))
    there = drift.corrected(_drifting(fused), gain, off_x - fused.bx, off_y - fused.by)
    fused = structs.replace(_with(fused, there, cov), told=told, no_fix=0.0, refused=0.0)
    if knows_v:
        fused = _gated(fused, sensors.vx, sensors.vy, max(sensors.sigma_v, params.sigma_mps) ** 2, params)
    return fused


def _gated(fused: Fused, vx: float, vy: float, R: float, params: FusionParams) -> Fused:
    """Kalman update by a velocity [m/s]; an outlier counts for nothing."""
    dx, dy = vx - fused.vx, vy - fused.vy
    if dx * dx + dy * dy > params.gate**2 * 2.0 * (fused.cov.vv + R):
        return structs.replace(fused, outliers=fused.outliers + 1.0)
    cov, gain = drift.by_velocity(fused.cov, R)
    return _with(fused, drift.corrected(_drifting(fused), gain, dx, dy), cov)


def _course(fused: Fused, dt: float, params: FusionParams) -> Fused:
    """Without a compass the course over ground stands for the heading, once the boat moves: one value a second.

    Leeway does not go away in the mean: the heading never gets surer than it.
    """
    speed = ops.hypot(fused.vx, fused.vy)
    if fused.no_heading <= params.slow_s or speed < params.course_mps or fused.no_fix > params.old_s:
        return fused
    chi = ops.atan2(fused.vy, fused.vx)
    leeway = params.leeway_rad * params.leeway_rad
    R = leeway + fused.cov.vv / (speed * speed)
    if not math.isfinite(fused.P_psi):
        return structs.replace(fused, psi=chi, P_psi=R)
    K = fused.P_psi / (fused.P_psi + R / min(dt, 1.0))
    psi = ops.wrap(fused.psi + K * ops.wrap(chi - fused.psi))
    return structs.replace(fused, psi=psi, P_psi=max(fused.P_psi - K * fused.P_psi, leeway))
