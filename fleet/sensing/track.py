"""The track of one foreign vessel: a Kalman filter for constant velocity that notices when the vessel manoeuvres.

The axes north and east are independent and have the same noise, so one covariance serves both. All values are floats;
times are those of the caller's clock [s].
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct, structs

from fleet import ops
from fleet.sensing.kalman import by_position, by_velocity

Positive = Annotated[float, Meta(gt=0.0)]


class TrackParams(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Tuning of the filter."""

    q: Positive = 0.001  # spectral density of the acceleration [m2/s3]
    q_alert: Positive = 0.02  # added while the vessel manoeuvres
    alert_s: Positive = 15.0
    sigma_min_m: Positive = 0.3  # no position is taken to be better
    sigma_start_mps: Positive = 3.0  # of a velocity nobody told
    sigma_ais_mps: Positive = 0.15  # of the velocity that AIS tells, per axis
    nis_most: Positive = 4.0  # smoothed normalised innovation squared above which it manoeuvres
    nis_new: Positive = 0.4  # share of the new one
    drift_new: Positive = 0.15  # share of the new innovation in their mean;
    drift_most: Positive = 6.0  # the square of that mean, in its own variances, above which it manoeuvres
    bump_v: Positive = 0.5  # added to the variance of the velocity then [m2/s2]
    om_every_s: Positive = 0.9  # between two courses of which the turn rate is the difference
    om_most: Positive = 0.1  # [rad/s]
    om_low_pass_s: Positive = 3.0
    om_least: Positive = 0.02  # smaller turn rates are noise [rad/s]
    om_speed_mps: Positive = 0.5  # slower vessels have no course to turn
    om_old_s: Positive = 12.0  # the track must be older
    om_fresh_s: Positive = 6.0  # and its data younger
    usable_mps: Positive = 0.6  # the velocity is known better than this,
    usable_s: Positive = 6.0  # or the track is this old
    keep_s: Positive = 120.0  # without data, then it is lost


class Track(Struct, frozen=True, gc=False):
    """All that is known of a vessel, at time t."""

    number: float  # of the vessel, for good
    length: float  # of its hull [m]
    t: float  # time of the values below [s]
    x: float  # north [m]
    y: float  # east [m]
    vx: float  # north [m/s]
    vy: float  # east [m/s]
    P11: float  # variance of the position per axis [m2]
    P12: float  # its covariance with the velocity [m2/s]
    P22: float  # variance of the velocity per axis [m2/s2]
    nis: float  # smoothed normalised innovation squared, about 1 for a steady vessel
    alert: float  # until when it counts as manoeuvring [s]
    om: float  # turn rate, + to starboard [rad/s]
    ref_t: float  # when the course was taken that the next one is compared with [s]
    ref_vx: float
    ref_vy: float
    born: float  # first data [s]
    heard: float  # last data [s]
    mx: float = 0.0  # mean of the normalised innovations of late, north; 0 for a steady vessel
    my: float = 0.0  # east


class Target(Struct, frozen=True, gc=False):
    """A vessel as it is now, dead-reckoned: what keeping clear takes."""

    number: float
    x: float  # north [m]
    y: float  # east [m]
    vx: float  # velocity over ground, north [m/s]
    vy: float  # velocity over ground, east [m/s]
    P11: float  # variance of the position per axis, age included [m2]
    P12: float
    P22: float  # variance of the velocity per axis [m2/s2]
    om: float  # turn rate that counts, 0 where it cannot be trusted; + to starboard [rad/s]
    length: float  # [m]
    age: float  # time since the last data [s]
    usable: float  # 1 its velocity is known well enough to decide by


PARAMS = TrackParams()


def begin(
    number: float,
    x: float,
    y: float,
    sigma: float,
    now: float,
    length: float,
    velocity: tuple[float, float] | None = None,
    params: TrackParams = PARAMS,
) -> Track:
    """A track from its first data: a position [m] with its 1-sigma error, and a velocity [m/s] where AIS tells one."""
    R = _variance(sigma, params)
    vx, vy = velocity if velocity is not None else (0.0, 0.0)
    sigma_v = params.sigma_ais_mps if velocity is not None else params.sigma_start_mps
    P22 = sigma_v * sigma_v
    return Track(
        number=number, length=length, t=now, x=x, y=y, vx=vx, vy=vy, P11=R, P12=0.0, P22=P22,
        nis=1.0, alert=now, om=0.0, ref_t=now, ref_vx=vx, ref_vy=vy, born=now, heard=now,
    )  # fmt: skip


def predict(track: Track, now: float, params: TrackParams = PARAMS) -> Track:
    """The track at `now`, straight on.

        P11 += 2 h P12 + h^2 P22 + q h^3 / 3,  P12 += h P22 + q h^2 / 2,  P22 += q h

    Data older than the track (h < 0) leave it where it is.
    """
    h = ops.maximum(now - track.t, 0.0)
    alerted = ops.clip(track.alert - track.t, 0.0, h)  # of this time it counts as manoeuvring
    q = params.q + (params.q_alert * alerted / h if h > 0.0 else 0.0)
    return structs.replace(
        track,
        t=track.t + h,
        x=track.x + h * track.vx,
        y=track.y + h * track.vy,
        P11=track.P11 + h * (2.0 * track.P12 + h * (track.P22 + q * h / 3.0)),
        P12=track.P12 + h * (track.P22 + 0.5 * q * h),
        P22=track.P22 + q * h,
    )


def update_position(track: Track, x: float, y: float, sigma: float, now: float, params: TrackParams = PARAMS) -> Track:
    """The track after a position [m] with its 1-sigma error.

    Where the smoothed innovation is too large the vessel manoeuvres: its velocity becomes uncertain.
    """
    track = _positioned(predict(track, now, params), x, y, _variance(sigma, params), params)
    return _turning(structs.replace(track, heard=track.t), params)


def update_ais(
    track: Track,
    x: float,
    y: float,
    sigma: float,
    vx: float,
    vy: float,
    now: float,
    params: TrackParams = PARAMS,
) -> Track:
    """The track after an AIS report: a position [m] with its 1-sigma error, and a velocity over ground [m/s]."""
    track = predict(track, now, params)
    dx, dy = vx - track.vx, vy - track.vy
    R_v = params.sigma_ais_mps * params.sigma_ais_mps
    off = dx * dx + dy * dy
    if off > params.nis_most * 2.0 * (track.P22 + R_v):
        track = structs.replace(track, P22=track.P22 + off, alert=track.t + params.alert_s)
    track = _positioned(track, x, y, _variance(sigma, params), params)
    track = by_velocity(track, vx - track.vx, vy - track.vy, R_v)
    return _turning(structs.replace(track, heard=track.t), params)


def seen(track: Track, now: float, params: TrackParams = PARAMS) -> Target:
    """The vessel as it is now, for deciding and for showing."""
    here = predict(track, now, params)
    age = now - track.heard
    trusted = (
        abs(track.om) > params.om_least
        and here.vx * here.vx + here.vy * here.vy > params.om_speed_mps * params.om_speed_mps
        and now - track.born > params.om_old_s
        and age < params.om_fresh_s
    )
    usable = ops.sqrt(track.P22) < params.usable_mps or now - track.born >= params.usable_s
    return Target(
        number=here.number,
        x=here.x,
        y=here.y,
        vx=here.vx,
        vy=here.vy,
        P11=here.P11,
        P12=here.P12,
        P22=here.P22,
        om=track.om if trusted else 0.0,
        length=here.length,
        age=age,
        usable=1.0 if usable else 0.0,
    )


def lost(track: Track, now: float, params: TrackParams = PARAMS) -> bool:
    """Without data for so long that the track is to be dropped."""
    return now - track.heard > params.keep_s


def _variance(sigma: float, params: TrackParams) -> float:
    """R of a position [m2]."""
    s = ops.maximum(sigma, params.sigma_min_m)
    return s * s


def _positioned(track: Track, x: float, y: float, R: float, params: TrackParams) -> Track:
    """Kalman update by a position with variance R per axis."""
    dx, dy = x - track.x, y - track.y
    off = 0.5 * (dx * dx + dy * dy)
    new = params.drift_new
    nis = (1.0 - params.nis_new) * track.nis + params.nis_new * off / (track.P11 + R)
    per = 1.0 / ops.sqrt(track.P11 + R)
    mx, my = track.mx + new * (dx * per - track.mx), track.my + new * (dy * per - track.my)
    drift = 0.5 * (mx * mx + my * my) * (2.0 - new) / new
    if nis > params.nis_most or drift > params.drift_most:
        mx, my = 0.0, 0.0
        track = structs.replace(track, P11=track.P11 + R, P22=track.P22 + params.bump_v, alert=track.t + params.alert_s)
    track = structs.replace(track, nis=nis, mx=mx, my=my)
    return by_position(track, dx, dy, R)


def _turning(track: Track, params: TrackParams) -> Track:
    """The turn rate, from the courses of the filtered velocity at least `om_every_s` apart."""
    h = track.t - track.ref_t
    if h < params.om_every_s:
        return track
    turned = ops.atan2(
        track.ref_vx * track.vy - track.ref_vy * track.vx, track.ref_vx * track.vx + track.ref_vy * track.vy
    )
    rate = ops.clip(turned / h, -params.om_most, params.om_most)
    om = track.om + (rate - track.om) * h / (params.om_low_pass_s + h)
    return structs.replace(track, om=om, ref_t=track.t, ref_vx=track.vx, ref_vy=track.vy)
