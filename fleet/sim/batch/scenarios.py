"""A set of scenarios: numbers only, one row per scenario, one column per boat."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from msgspec import Struct, structs
from numpy.typing import NDArray

from fleet.agent.modes import Goal
from fleet.guidance import Limits
from fleet.mission.beside import Room
from fleet.ops import FloatArray
from fleet.paths import Path

IntArray = NDArray[np.intp]
NEVER = np.inf
ENDLESS = 1.0e18
PER_BOAT = ("path", "x", "y", "psi", "u", "s", "cruise", "u_min", "u_max", "offset", "member", "goal", "goal_m")
PER_BOAT_LATER = ("s_end", "mute_s", "avoids", "hull", "leader", "room")
PER_SCENARIO = ("limit_s", "measure_s", "current_n", "current_e", "wind_n", "wind_e", "delay_s", "loss")


class Change(Struct, frozen=True, kw_only=True):
    """What the operator orders at one moment, complete: it replaces what was ordered before."""

    at_s: FloatArray  # (B,), inf never; of several changes the later ones are later in every scenario
    goal: FloatArray  # (B, K) fleet.agent.modes.Goal
    offset: FloatArray  # (B, K) [m]
    cruise: FloatArray  # (B, K) [m/s]

    def part(self, rows: Any) -> Self:
        """Of some scenarios."""
        return type(self)(
            at_s=self.at_s[rows], goal=self.goal[rows], offset=self.offset[rows], cruise=self.cruise[rows]
        )


class Scenarios(Struct, frozen=True, kw_only=True):
    """B scenarios of K boats each. Arrays are (B, K) unless they say (B,); metres, seconds, radians."""

    family: str
    seed: int
    case: IntArray  # (B,) a scenario is named by (family, seed, case)
    paths: tuple[Path, ...]
    path: IntArray  # number of the boat's path
    x: FloatArray
    y: FloatArray
    psi: FloatArray
    u: FloatArray
    s: FloatArray  # abscissa at which it begins
    cruise: FloatArray  # C
    u_min: FloatArray  # in formation
    u_max: FloatArray
    offset: FloatArray  # of its slot
    member: FloatArray  # number of the formation of its scenario that it belongs to, 0 none
    goal: FloatArray  # fleet.agent.modes.Goal at the start
    goal_m: FloatArray  # abscissa at which it has arrived; inf: it sails until the time is up
    s_end: FloatArray  # abscissa at which it holds
    mute_s: FloatArray  # from when on it is never heard again
    avoids: FloatArray  # 0 it keeps clear of nobody
    hull: FloatArray  # number of its model in `hulls`
    leader: FloatArray  # number of the boat beside which it sails, -1 none
    room: FloatArray  # number of its table in `rooms`
    limit_s: FloatArray  # (B,) end of the run; sooner when everybody has arrived
    measure_s: FloatArray  # (B,) from when on errors of track and formation count
    current_n: FloatArray  # (B,)
    current_e: FloatArray  # (B,)
    wind_n: FloatArray  # (B,) leeway
    wind_e: FloatArray  # (B,)
    delay_s: FloatArray  # (B,) of every message
    loss: FloatArray  # (B,) share of messages lost
    changes: tuple[Change, ...] = ()
    rooms: tuple[Room, ...] = ()  # how far from abeam wingmen want to be
    hulls: tuple[str, ...] = ("unicycle",)  # models of boats
    limits: Limits = Limits()
    gain_per_m: float = 0.3  # k_u
    gnss_sigma_m: float = 0.0  # slow error, 60 s, per axis
    gnss_white_m: float = 0.0
    gnss_velocity_mps: float = 0.0  # white, per axis
    clock_error_s: float = 0.0  # of two clocks: radius grows by this times the speed of the other

    @property
    def count(self) -> int:
        """B."""
        return len(self.case)

    @property
    def boats(self) -> int:
        """K."""
        return int(self.x.shape[1])

    @property
    def winged(self) -> bool:
        """Some boats sail beside others."""
        return bool((self.leader >= 0.0).any())

    @property
    def nominal_s(self) -> FloatArray:
        """(B, K) time to arrive with nobody in the way; inf where the boat has no goal [s]."""
        return (self.goal_m - self.s) / np.maximum(self.cruise, 1e-9)

    def part(self, rows: Any) -> Self:
        """Some of the scenarios; `rows` is a slice, or numbers of rows."""
        names = ("case", *PER_BOAT, *PER_BOAT_LATER, *PER_SCENARIO)
        chosen = {name: getattr(self, name)[rows] for name in names}
        used, path = np.unique(chosen["path"], return_inverse=True)
        chosen["path"] = path.reshape(chosen["path"].shape)
        paths = tuple(self.paths[i] for i in used.tolist())
        return structs.replace(self, paths=paths, changes=tuple(c.part(rows) for c in self.changes), **chosen)

    def only(self, case: int) -> Self:
        """The one scenario of that case."""
        rows = np.flatnonzero(self.case == case)
        if not len(rows):
            raise KeyError(f"{self.family} has no case {case}")
        return self.part(rows[:1])


def assemble(
    family: str, seed: int, case: IntArray, paths: Sequence[Path], path: Any, x: Any, y: Any, psi: Any, **given: Any
) -> Scenarios:
    """Scenarios with defaults: 1 m/s along the path from its start, no water, perfect radio, no formation.

    Arrays are broadcast to (B, K), those per scenario to (B,). Without `limit_s` a run ends after three times the
    longest nominal time and 60 s.
    """
    shape = np.broadcast_shapes(np.shape(x), np.shape(y), (len(case), 1))

    def boats(value: Any) -> FloatArray:
        return np.array(np.broadcast_to(np.asarray(value, dtype=float), shape))

    def rows(value: Any) -> FloatArray:
        return np.array(np.broadcast_to(np.asarray(value, dtype=float), shape[:1]))

    cruise = boats(given.pop("cruise", 1.0))
    limits: Limits = given.get("limits", Limits())
    defaults: dict[str, Any] = {
        "u": cruise,
        "s": 0.0,
        "cruise": cruise,
        "u_min": limits.speed_min_mps,
        "u_max": limits.speed_max_mps,
        "offset": 0.0,
        "member": 0.0,
        "goal": float(Goal.FOLLOW),
        "goal_m": NEVER,
        "s_end": ENDLESS,
        "mute_s": NEVER,
        "avoids": 1.0,
        "hull": 0.0,
        "leader": -1.0,
        "room": -1.0,
        "x": x,
        "y": y,
        "psi": psi,
    }
    per_boat: dict[str, Any] = {name: boats(given.pop(name, value)) for name, value in defaults.items()}
    nominal = (per_boat["goal_m"] - per_boat["s"]) / np.maximum(cruise, 1e-9)
    longest = np.where(np.isfinite(nominal), nominal, 0.0).max(axis=1)
    limit_s = rows(given.pop("limit_s", 3.0 * longest + 60.0))
    per_scenario: dict[str, Any] = {name: rows(given.pop(name, 0.0)) for name in PER_SCENARIO[1:]}
    numbers = np.array(np.broadcast_to(np.asarray(path, dtype=np.intp), shape))
    return Scenarios(
        family=family,
        seed=seed,
        case=np.asarray(case, dtype=np.intp),
        paths=tuple(paths),
        path=numbers,
        limit_s=limit_s,
        **per_boat,
        **per_scenario,
        **given,
    )
