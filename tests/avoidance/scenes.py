"""Scenes of one boat and its peers, for tests of the laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
from hypothesis import strategies as st

from fleet.avoidance.types import Own, Peer

FAR_S = 1000.0  # a path without a bend


def own_at(
    x: float = 0.0,
    y: float = 0.0,
    chi: float = 0.0,
    u: float = 1.0,
    gamma: float | None = None,
    chi_p: float = 0.0,
    y_e: float = 0.0,
    u_d: float = 1.0,
    sigma: float = 0.0,
    r: float = 0.0,
) -> Own[float]:
    """The own boat; on its path to the north unless told otherwise."""
    g = chi_p if gamma is None else gamma
    return Own(
        x=x,
        y=y,
        vx=u * math.cos(chi),
        vy=u * math.sin(chi),
        chi=chi,
        gx=math.cos(g),
        gy=math.sin(g),
        u_d=u_d,
        tx=math.cos(chi_p),
        ty=math.sin(chi_p),
        y_e=y_e,
        straight=FAR_S,
        sigma=sigma,
        r=r,
    )


def peer_at(
    number: float,
    x: float,
    y: float,
    chi: float,
    u: float = 1.0,
    *,
    known: float = 1.0,
    gamma: float | None = None,
    chi_p: float | None = None,
    u_d: float | None = None,
    present: float = 1.0,
    sigma: float = 0.0,
    widen: float = 0.0,
    y_e: float = 0.0,
    r: float = 0.0,
) -> Peer[float]:
    """A peer on its path along its own course unless told otherwise."""
    g = chi if gamma is None else gamma
    p = chi if chi_p is None else chi_p
    return Peer(
        number=number,
        present=present,
        x=x,
        y=y,
        vx=u * math.cos(chi),
        vy=u * math.sin(chi),
        known=known,
        gx=math.cos(g),
        gy=math.sin(g),
        u_d=u if u_d is None else u_d,
        tx=math.cos(p),
        ty=math.sin(p),
        straight=FAR_S,
        sigma=sigma,
        widen=widen,
        y_e=y_e,
        r=r,
    )


def lanes(values: Sequence[Any]) -> Any:
    """Many Structs (or tuples) of floats as one of arrays."""
    first = values[0]
    if isinstance(first, tuple):
        return tuple(lanes(column) for column in zip(*values, strict=True))
    if isinstance(first, msgspec.Struct):
        columns = zip(*(msgspec.structs.astuple(v) for v in values), strict=True)
        return type(first)(*(lanes(column) for column in columns))
    return np.array(values, dtype=float)


def lane(value: Any, k: int) -> Any:
    """Lane k of a Struct (or tuple) of arrays, as floats."""
    if isinstance(value, tuple):
        return tuple(lane(v, k) for v in value)
    if isinstance(value, msgspec.Struct):
        return type(value)(*(lane(v, k) for v in msgspec.structs.astuple(value)))
    return float(value[k])


def rotated(value: Any, angle: float) -> Any:
    """The same scene, turned clockwise by an angle [rad] about the origin."""
    c, s = math.cos(angle), math.sin(angle)
    changes: dict[str, float] = {}
    for a, b in (("x", "y"), ("vx", "vy"), ("gx", "gy"), ("tx", "ty")):
        p, q = getattr(value, a), getattr(value, b)
        changes[a], changes[b] = c * p - s * q, s * p + c * q
    if hasattr(value, "chi"):
        changes["chi"] = math.remainder(value.chi + angle, 2.0 * math.pi)
    return msgspec.structs.replace(value, **changes)


angles = st.floats(-math.pi, math.pi)
speeds = st.floats(0.0, 1.5)
flags = st.sampled_from([0.0, 1.0])
turns = st.sampled_from([0.0, -0.3, 0.2])
owns = st.builds(
    own_at,
    chi=angles,
    u=speeds,
    gamma=angles,
    chi_p=angles,
    y_e=st.floats(-20.0, 20.0),
    u_d=speeds,
    sigma=st.sampled_from([0.0, 0.3, 1.5]),
    r=turns,
)


def peers_of(number: float) -> st.SearchStrategy[Peer[float]]:
    """A peer of that number, near enough to matter."""
    return st.builds(
        peer_at,
        st.just(number),
        st.floats(-40.0, 40.0),
        st.floats(-40.0, 40.0),
        angles,
        speeds,
        known=flags,
        gamma=angles,
        chi_p=angles,
        u_d=speeds,
        sigma=st.sampled_from([0.0, 1.5]),
        widen=st.sampled_from([0.0, 1.0]),
        y_e=st.floats(-20.0, 20.0),
        r=turns,
    )
