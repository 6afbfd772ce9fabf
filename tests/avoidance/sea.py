"""A small sea for scenarios: unicycles on straight paths that hear each other perfectly.

Runs many cases at once (lane = boat * cases + case) or one case of plain floats: the same text for both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fleet import ops
from fleet.avoidance import METHODS
from fleet.avoidance.types import Own, Peer
from fleet.guidance.limits import Limits

TICK_S = 0.1
STEPS = 5  # integration at 50 Hz
K1, PSI_A, K_PHI = 0.8, 1.05, 0.2


@dataclass
class Fleet:
    """Where boats start and what they want; every field is indexed (boat, case)."""

    x: np.ndarray  # start of the path, where the boat lies [m]
    y: np.ndarray
    chi_p: np.ndarray  # course of the path [rad]
    speed: np.ndarray  # wanted, and at the start [m/s]
    length: np.ndarray  # of the path [m]
    deaf: tuple[int, ...] = ()  # boats that do not keep clear
    silent: tuple[int, ...] = ()  # boats that publish no plan, only where they are
    y_e: np.ndarray | None = None  # initial cross-track error [m]


@dataclass
class Outcome:
    """What happened; arrays are indexed (boat, case) or (case,)."""

    least: np.ndarray  # least distance of any two boats, per case [m]
    arrived: np.ndarray  # time of arrival, inf if never [s]
    nominal: np.ndarray  # without others [s]
    switches: np.ndarray
    trace: list[Any] = field(default_factory=list)

    @property
    def delay(self) -> np.ndarray:
        return self.arrived - self.nominal


def follow(y_e: Any, chi: Any, chi_p: Any, u: Any) -> tuple[Any, Any]:
    """Yaw rate and wanted course (phi) of the paper's path-following on a straight path."""
    slope = ops.tanh(K_PHI * y_e)
    phi = -PSI_A * slope
    beta = ops.wrap(chi - chi_p)
    phi_dot = -PSI_A * K_PHI * (1.0 - slope * slope) * (u * ops.sincos(beta)[0])
    return phi_dot - K1 * ops.wrap(beta - phi), phi


def hull(state: tuple[Any, ...], u_d: Any, r_d: Any, limits: Limits) -> tuple[Any, ...]:
    """The unicycle with lags, one tick on."""
    x, y, psi, u, r = state
    h = TICK_S / STEPS
    r_d = ops.clip(r_d, -limits.yaw_rate_max_radps, limits.yaw_rate_max_radps)
    a = limits.acceleration_max_mps2
    for _ in range(STEPS):
        s, c = ops.sincos(psi)
        x, y, psi = x + h * u * c, y + h * u * s, psi + h * r
        u = u + h * ops.clip((u_d - u) / limits.surge_lag_s, -a, a)
        r = r + h * (r_d - r) / limits.yaw_lag_s
    return x, y, ops.wrap(psi), u, r


def sail(
    fleet: Fleet,
    name: str = "scoring",
    params: Any = None,
    wanted: Callable[[Any, Any], Any] | None = None,
    limits: Limits | None = None,
    time_s: float | None = None,
    watch: Callable[..., Any] | None = None,
) -> Outcome:
    """Sail all cases until everybody has arrived, or the time is up.

    wanted(s, time): speeds (boat, case) wanted at the abscissae s (boat, case), if they are not fixed.
    """
    method = METHODS[name]
    params = method.params(6.0, "closest") if params is None else params
    limits = limits or Limits()
    boats, cases = fleet.x.shape
    lanes = boats * cases
    others = np.array([[j for j in range(boats) if j != i] for i in range(boats)], dtype=int).reshape(boats, boats - 1)

    def flat(a: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(np.broadcast_to(a, (boats, cases)), dtype=float).reshape(lanes)

    def columns(a: np.ndarray) -> list[np.ndarray]:
        table = a.reshape(boats, cases)
        return [table[others[:, k]].reshape(lanes) for k in range(boats - 1)]

    x0, y0, chi_p = flat(fleet.x), flat(fleet.y), flat(fleet.chi_p)
    ty, tx = ops.sincos(chi_p)
    start = flat(fleet.y_e) if fleet.y_e is not None else np.zeros(lanes)
    u_d = flat(fleet.speed)
    state: tuple[Any, ...] = (x0 - start * ty, y0 + start * tx, chi_p, u_d, np.zeros(lanes))
    number = np.repeat(np.arange(boats, dtype=float), cases)
    hears = np.repeat(np.array([0.0 if i in fleet.deaf else 1.0 for i in range(boats)]), cases)
    silent = np.repeat(np.array([1.0 if i in fleet.silent else 0.0 for i in range(boats)]), cases)
    known = columns(1.0 - silent)
    ones, zeros = np.ones(lanes), np.zeros(lanes)
    memory = method.start(zeros, boats - 1)
    nominal = (flat(fleet.length) / np.maximum(u_d, 1e-9)).reshape(boats, cases)
    limit = 3.0 * float(np.where(np.isfinite(nominal), nominal, 0.0).max()) + 60.0 if time_s is None else time_s
    arrived, least = np.full(lanes, np.inf), np.full(cases, np.inf)
    switches, was = np.zeros(lanes), np.zeros(lanes)
    numbers = columns(number)
    outcome = Outcome(least, arrived, nominal, switches)
    counted = [i for i in range(boats) if i not in fleet.deaf] or list(range(boats))
    for tick in range(int(limit / TICK_S)):
        x, y, psi, u, _ = state
        s = (x - x0) * tx + (y - y0) * ty
        y_e = (y - y0) * tx - (x - x0) * ty
        arrived[:] = np.where((s >= flat(fleet.length)) & np.isinf(arrived), tick * TICK_S, arrived)
        if not np.isinf(arrived.reshape(boats, cases)[counted]).any():
            break
        if wanted is not None:
            u_d = flat(wanted(s.reshape(boats, cases), tick * TICK_S))
        r_path, phi = follow(y_e, psi, chi_p, u)
        gy, gx = ops.sincos(chi_p + phi)
        sin_psi, cos_psi = ops.sincos(psi)
        vx, vy = u * cos_psi, u * sin_psi
        own = Own(x, y, vx, vy, psi, gx, gy, u_d, tx, ty, y_e, ones * 1e3, zeros)
        plan = [(gx, cos_psi), (gy, sin_psi), (u_d, u), (tx, cos_psi), (ty, sin_psi)]
        told = zip(
            *(columns(v) for v in (x, y, vx, vy)),
            *(columns(np.where(silent == 1.0, seen, said)) for said, seen in plan),
            strict=True,
        )
        peers = [
            Peer(n, ones, px, py, pvx, pvy, k, pgx, pgy, pu, ptx, pty, ones * 1e3, zeros, zeros)
            for n, k, (px, py, pvx, pvy, pgx, pgy, pu, ptx, pty) in zip(numbers, known, told, strict=True)
        ]
        for peer in peers:
            d = ops.hypot(peer.x - x, peer.y - y).reshape(boats, cases).min(axis=0)
            least[:] = np.minimum(least, d)
        if len(fleet.deaf) == boats:
            state = hull(state, u_d, r_path, limits)
            continue
        memory, advice = method.keep_clear(own, peers, memory, limits, params, TICK_S)
        if watch is not None:
            watch(tick, own, peers, memory, advice)
        avoiding = advice.avoiding * hears
        switches += avoiding != was
        was = avoiding
        steers = (advice.steers * hears) == 1.0
        speed = np.where(hears == 1.0, advice.u_d, u_d)
        state = hull(state, speed, np.where(steers, advice.r_d, r_path), limits)
    outcome.arrived, outcome.switches = arrived.reshape(boats, cases), switches.reshape(boats, cases)
    return outcome


def meeting(boats: int, cases: int, seed: int, before_s: float = 70.0, apart_m: float = 20.0) -> Fleet:
    """Straight paths of random heading and speed 0.7-1.5 m/s that meet near one point within 3 s, starts well apart."""
    rng = np.random.default_rng(seed)
    chi, speed = np.empty((boats, 0)), np.empty((boats, 0))
    before = np.empty((boats, 0))
    while chi.shape[1] < cases:
        new_chi = rng.uniform(-np.pi, np.pi, (boats, cases))
        new_speed = rng.uniform(0.7, 1.5, (boats, cases))
        new_before = new_speed * (before_s + rng.uniform(-1.5, 1.5, (boats, cases)))
        x, y = new_before * np.cos(new_chi), new_before * np.sin(new_chi)
        apart = np.full(cases, np.inf)
        for i in range(boats):
            for j in range(i):
                apart = np.minimum(apart, np.hypot(x[i] - x[j], y[i] - y[j]))
        good = apart > apart_m
        chi, speed = np.hstack((chi, new_chi[:, good])), np.hstack((speed, new_speed[:, good]))
        before = np.hstack((before, new_before[:, good]))
    chi, speed, before = chi[:, :cases], speed[:, :cases], before[:, :cases]
    return Fleet(-before * np.cos(chi), -before * np.sin(chi), chi, speed, 2.0 * before_s * speed)


def antipodal(boats: int, cases: int, seed: int, radius: float) -> Fleet:
    """Boats on a circle, each bound for the opposite point, at about 1 m/s; small perturbations."""
    rng = np.random.default_rng(seed)
    place = np.arange(boats)[:, None] * (2.0 * np.pi / boats) + rng.uniform(-0.05, 0.05, (boats, cases))
    chi = place + np.pi
    off = rng.uniform(-1.0, 1.0, (2, boats, cases))
    speed = rng.uniform(0.95, 1.05, (boats, cases))
    x, y = radius * np.cos(place) + off[0], radius * np.sin(place) + off[1]
    return Fleet(x, y, ops.wrap(chi), speed, np.full((boats, cases), 2.0 * radius))
