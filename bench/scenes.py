"""What is measured: a boat among peers, a state message, a mission for N boats."""

from __future__ import annotations

import math
from typing import Any

from msgspec import Struct, structs

from fleet.agent.step import Decision, Nav, Order, State, StepParams, start, step
from fleet.avoidance import METHODS, Method
from fleet.avoidance.types import Peer
from fleet.coordination import Member
from fleet.guidance import FollowParams, Limits, StationParams
from fleet.mission.model import (
    Boat,
    Formation,
    Geographic,
    Lidar,
    Mission,
    Positions,
    Start,
    Steady,
    Straight,
    Vessel,
)
from fleet.paths import Path, straight
from fleet.wire.messages import MAJOR, BoatState, Revision

RADIUS_M = 6.0
SPACING_M = 12.0  # slots need R + 2 m
LONG_M = 20_000.0


class Scene(Struct):
    """Everything that `step` takes, between two ticks."""

    state: State[float, Any]
    nav: Nav[float]
    members: list[Member[float]]
    peers: list[Peer[float]]
    order: Order[float]
    path: Path
    method: Method
    params: StepParams
    dt: float = 0.1

    def tick(self) -> tuple[State[float, Any], Decision[float]]:
        """One tick from this state; the scene stays as it is."""
        return step(
            self.state, self.nav, self.members, self.peers, self.order, self.path, self.method, self.params, self.dt
        )


def _peer(number: int, x: float, y: float, heads: float) -> Peer[float]:
    """A boat at (x, y) that follows a straight path north (+1) or south (-1) at 1 m/s."""
    return Peer(
        number=float(number),
        present=1.0,
        x=x,
        y=y,
        vx=heads,
        vy=0.0,
        known=1.0,
        gx=heads,
        gy=0.0,
        u_d=1.0,
        tx=heads,
        ty=0.0,
        straight=1e6,
        sigma=0.0,
        widen=0.0,
    )


def column(method: str, peers: int, *, conflict: bool = False) -> Scene:
    """A boat in the middle of a column in formation, nobody in conflict; or one more boat head-on, 40 m ahead."""
    path = straight((0.0, 0.0), (LONG_M, 0.0))
    s = 5000.0
    places = [(k // 2 + 1) * (1 if k % 2 else -1) for k in range(peers)]
    others = [_peer(n, s + SPACING_M * place, 0.0, 1.0) for n, place in enumerate(sorted(places), 1)]
    if conflict:
        others[-1] = _peer(peers, s + 40.0, 0.5, -1.0)
    way = METHODS[method]
    params = StepParams(
        follow=FollowParams(), station=StationParams(), limits=Limits(), keep=way.params(RADIUS_M, "closest")
    )
    scene = Scene(
        state=structs.replace(start(0.0, s, way.start(0.0, len(others))), good=10.0),
        nav=Nav(1.0, s, 0.2, 0.0, 1.0, 0.0, 0.0, 0.0),
        members=[Member(1.0, s + 0.01 * place) for place in sorted(places)],
        peers=others,
        order=Order(1.0, 0.0, 1.0, 0.7, 1.3, 0.3, 1e18),
        path=path,
        method=way,
        params=params,
    )
    scene.state = scene.tick()[0]  # peers are known, the first decision is made
    return scene


def in_a_crowd(peers: int) -> Scene:
    """A boat that meets all of its peers, from all sides at once, everybody with plain GNSS: all rules have work."""
    scene = column("scoring", peers)
    others = []
    for k in range(peers):
        bearing = 2.0 * math.pi * k / peers + 0.3
        far = 25.0 + 4.0 * k
        c, s = math.cos(bearing), math.sin(bearing)
        peer = _peer(k + 1, scene.nav.x + far * c, scene.nav.y + far * s, 1.0)
        others.append(structs.replace(peer, vx=-c, vy=-s, gx=-c, gy=-s, tx=-c, ty=-s, sigma=1.5, widen=0.3))
    nav = structs.replace(scene.nav, sigma=1.5)
    crowd = structs.replace(scene, peers=others, nav=nav)
    crowd.state = structs.replace(crowd.state, keep=crowd.method.start(0.0, peers))
    crowd.state = crowd.tick()[0]
    return crowd


def due(scene: Scene) -> Scene:
    """The same scene at a tick on which velocity scoring decides."""
    keep = structs.replace(scene.state.keep, countdown=scene.dt)
    return structs.replace(scene, state=structs.replace(scene.state, keep=keep))


def boat_state(name: str = "b7", seq: int = 1, stamp_ns: int = 1_700_000_000_000_000_000) -> BoatState:
    """A state as a boat in formation publishes it."""
    return BoatState(
        major=MAJOR,
        boat=name,
        epoch=1_700_000_000_000_000_000,
        seq=seq,
        stamp_ns=stamp_ns,
        clock_ns=50_000_000,
        lat_deg=44.3812345,
        lon_deg=8.9312345,
        cog_rad=0.0123,
        sog_mps=1.0123,
        heading_rad=0.0119,
        yaw_rate_radps=0.001,
        position_error_m=0.8,
        lap=0,
        s_m=1234.567,
        mode=1,
        reasons=0,
        plan_course_rad=0.0121,
        plan_speed_mps=1.0021,
        tangent_rad=math.pi / 7.0,
        straight_s=150.0,
        decided_yaw_rate_radps=0.0123,
        decided_speed_mps=1.0021,
        cross_track_m=0.123,
        along_path_m=0.045,
        nearest="b6",
        nearest_m=12.03,
        mission_id="1700000000000000000-anna",
        in_force=Revision(3, "anna"),
        held=Revision(3, "anna"),
        stops=(),
        simulated=True,
        control=Revision(1, "anna"),
    )


def moored(sensed: Lidar | Positions) -> Vessel:
    """A vessel that lies abeam of the path of few boats, and that they see so; they need not act."""
    track = Steady(start=(70.0, 35.0), course_deg=60.0)
    return Vessel(name="barge", length_m=12.0, speed_mps=0.0, track=track, sensed=sensed)


def mission(boats: int, *traffic: Vessel) -> Mission:
    """N boats in column on one straight path, already in formation."""
    length = boats * SPACING_M + 1000.0
    roster = tuple(
        Boat(name=f"b{k + 1}", path="line", slot=float(k), start=Start(s_m=20.0 + k * SPACING_M, speed_mps=1.0))
        for k in range(boats)
    )
    return Mission(
        title=f"{boats} boats in column",
        datum=Geographic(lat_deg=44.38, lon_deg=8.93),
        paths={"line": Straight(start=(0.0, 0.0), end=(length, 0.0))},
        boats=roster,
        formation=Formation(spacing_m=SPACING_M, cruise_mps=1.0),
        duration_s=600.0,
        traffic=traffic,
    )
